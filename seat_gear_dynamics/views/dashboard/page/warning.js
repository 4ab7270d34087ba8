// The warning: level, reasons and advice for the eye at once, and for the ear only when they change in kind.

import { byId, LEVELS, SIGNS, make, number, setText, showFacts } from "./text.js";

const LOST = "LOST";

let told = "";

export function showWarning(now) {
  const box = byId("warning");
  box.dataset.level = now.level;
  byId("sign").setAttribute("d", SIGNS[now.level]);
  setText(byId("level"), now.levelName);
  setText(byId("headline"), now.headline);
  setText(byId("reason"), now.reason);
  setText(byId("advice"), now.advice);
  showCaution(now.caution);
  byId("trip").hidden = !now.trip;
  setText(byId("entry"), now.entry);
  byId("entry-key").dataset.soon = String(now.entrySeconds !== null && now.entrySeconds <= 2);
  setText(byId("calm"), now.calmWords);
  setText(byId("motion"), now.motion);
  showFacts(byId("values"), now.values);
  showHealth(now.health);
  tell(now);
  const speed = now.speed === null ? "no speed" : `${number(now.speed)} r/min`;
  const title = `${now.levelName} · ${speed} · Seat gear bench`;
  if (document.title !== title) document.title = title;
}

/** Take the verdict back where nothing is heard any more: an old one must not be read from afar. */
export function showLost(at) {
  const last = byId("level").textContent;
  if (last === LOST) return;
  byId("warning").dataset.level = 3;
  byId("sign").setAttribute("d", SIGNS[3]);
  setText(byId("level"), LOST);
  setText(byId("headline"), "No verdict");
  setText(byId("reason"), `Last heard at ${at}: ${last}`);
  setText(byId("advice"), "Do not rely on what is shown.");
  showCaution(null);
  byId("trip").hidden = true;
  document.title = "No connection · Seat gear bench";
  told = "";
}

function showCaution(text) {
  byId("caution").hidden = text === null;
  setText(byId("caution"), text ?? "");
}

/** Read aloud what is new: a number that moves in the reason is not. */
function tell(now) {
  const kind = `${now.level} ${now.headline}`;
  if (kind === told) return;
  told = kind;
  const urgent = now.level === 2;
  const words = `${now.levelName}: ${now.headline}. ${now.reason}. ${now.advice}`;
  setText(byId(urgent ? "say-now" : "say"), words);
  setText(byId(urgent ? "say" : "say-now"), "");
}

function showHealth(health) {
  const list = byId("health");
  while (list.children.length > health.length) list.lastElementChild.remove();
  health.forEach((status, i) => {
    if (!list.children[i]) {
      const row = make("li");
      row.append(make("span", "level-word"), make("span", "name"), make("span", "text"));
      list.append(row);
    }
    const [word, name, text] = list.children[i].children;
    list.children[i].dataset.level = status.level;
    setText(word, LEVELS[status.level]);
    setText(name, status.name);
    setText(text, status.text);
  });
  byId("no-health").hidden = health.length > 0;
}

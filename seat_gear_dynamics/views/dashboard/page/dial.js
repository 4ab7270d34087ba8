// The speed dial: |speed| on a round scale with the forbidden bands of the present load.

import { byId, describe, number, setText } from "./text.js";

const SWEEP = 240; // degrees of the whole scale
const RADIUS = 141;
const LEAST = 1.4; // degrees; a band narrower than the eye can see is drawn so wide
const SPACE = "http://www.w3.org/2000/svg";

let scale = 2200;
let parts = null;
let drawn = "";

const angle = (rpm) => -SWEEP / 2 + SWEEP * Math.min(Math.max(rpm / scale, 0), 1);

function at(degrees, radius) {
  const a = (degrees * Math.PI) / 180;
  return [radius * Math.sin(a), -radius * Math.cos(a)];
}

const place = (degrees, radius) => at(degrees, radius).map((v) => v.toFixed(2)).join(" ");

function arc(from, to, radius = RADIUS) {
  const large = to - from > 180 ? 1 : 0;
  return `M${place(from, radius)}A${radius} ${radius} 0 ${large} 1 ${place(to, radius)}`;
}

function add(parent, tag, attributes, text) {
  const made = document.createElementNS(SPACE, tag);
  for (const [name, value] of Object.entries(attributes)) made.setAttribute(name, value);
  if (text !== undefined) made.textContent = text;
  parent.append(made);
  return made;
}

export function startDial(scene) {
  scale = scene.scaleRpm;
  drawn = "";
  const svg = byId("dial");
  svg.replaceChildren();
  add(svg, "path", { d: arc(-SWEEP / 2, SWEEP / 2), class: "track" });
  const unknown = add(svg, "path", { class: "unknown" });
  const bands = add(svg, "g", {});
  for (let rpm = 0; rpm <= scale + 1; rpm += 100) {
    const main = rpm % 500 === 0;
    const [x1, y1] = at(angle(rpm), RADIUS + 11);
    const [x2, y2] = at(angle(rpm), RADIUS + (main ? 25 : 18));
    add(svg, "line", { x1, y1, x2, y2, class: main ? "mark main" : "mark" });
    if (main) {
      const [x, y] = at(angle(rpm), RADIUS + 45);
      add(svg, "text", { x, y, class: "scale" }, String(rpm));
    }
  }
  const calm = add(svg, "path", { class: "calm", d: "M0 -127l9 14h-18z" });
  const needle = add(svg, "g", { class: "needle" });
  add(needle, "line", { x1: 0, y1: -116, x2: 0, y2: -165, class: "rim" });
  add(needle, "line", { x1: 0, y1: -116, x2: 0, y2: -165, class: "hand" });
  const value = add(svg, "text", { x: 0, y: 2, class: "value" }, "–");
  const unit = add(svg, "text", { x: 0, y: 52, class: "unit" }, "r/min");
  const direction = add(svg, "text", { x: 0, y: 84, class: "direction" }, "");
  parts = { svg, unknown, bands, calm, needle, value, unit, direction };
}

export function showDial(now) {
  if (!parts) return;
  showBands(now.bands);
  showUnknown(now.outside === null ? now.covered : 0);
  const known = now.speed !== null;
  const size = known ? Math.abs(now.speed) : 0;
  parts.svg.dataset.level = now.level;
  parts.needle.setAttribute("transform", `rotate(${angle(size).toFixed(2)})`);
  parts.needle.style.display = known ? "" : "none";
  setText(parts.value, known ? number(size) : "–");
  setText(parts.direction, known && now.speed < -5 ? "backward" : size > scale ? "beyond the scale" : "");
  const showCalm = now.calm !== null && (now.level === 1 || now.level === 2);
  parts.calm.style.display = showCalm ? "" : "none";
  if (showCalm) parts.calm.setAttribute("transform", `rotate(${angle(Math.abs(now.calm)).toFixed(2)})`);
  const bands = now.bands.map(([low, high]) => `${number(low)} to ${number(high)}`).join(", ");
  describe(parts.svg, `Speed ${number(now.speed)} r/min. Forbidden bands: ${bands || "none known"} r/min.`);
}

/** Mark the speeds of which nothing is known: those from `rpm` on. */
function showUnknown(rpm) {
  const d = rpm < scale ? arc(angle(rpm), SWEEP / 2) : "";
  if (parts.unknown.getAttribute("d") !== d) parts.unknown.setAttribute("d", d);
}

function showBands(bands) {
  const key = JSON.stringify(bands);
  if (key === drawn) return;
  drawn = key;
  parts.bands.replaceChildren();
  for (const [low, high] of bands) {
    const room = Math.max(LEAST - (angle(high) - angle(low)), 0) / 2;
    const d = arc(Math.max(angle(low) - room, -SWEEP / 2), Math.min(angle(high) + room, SWEEP / 2));
    add(parts.bands, "path", { d, class: "band" });
  }
}

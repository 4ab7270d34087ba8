// The page: what the server says goes to the panels, twenty times a second; what is lost is shown as lost.

import { showDial, startDial } from "./dial.js";
import { redrawForces, showForces, startForces } from "./forces.js";
import { Link } from "./link.js";
import { addTrail, clearTrail, redrawMap, showMap, startMap } from "./map.js";
import { forgetOrbits, showPhase, showSection, startOrbits } from "./orbit.js";
import { forgetPress, showAnswer, showRecorder, showRole, startRecorder } from "./recorder.js";
import { byId, number, setText } from "./text.js";
import { startTheme } from "./theme.js";
import { showLost, showWarning } from "./warning.js";

const ROOM = { windows: 600, samples: 600, trend: 1200 }; // rows kept, as the server does
const PANELS = { speed: ".speed", load: ".speed", mesh: ".force, .phase", section: ".section" };

let rows = { windows: [], samples: [], trend: [] };
let latest = null;
let arrivals = [];

const link = new Link({
  hello(message) {
    const { scene } = message;
    setText(byId("machine"), scene.machine);
    byId("door").hidden = true;
    byId("main").hidden = false;
    startDial(scene);
    startMap(scene, true);
    startForces(scene);
    startOrbits(scene);
    showRole(message.role);
  },

  frame(message) {
    try {
      take(message);
      connected();
    } catch (error) {
      // A picture that stands still must not look alive.
      document.body.dataset.link = "lost";
      byId("lost").hidden = false;
      setText(byId("lost"), "This page has a fault and shows old values. Load it anew.");
      throw error;
    }
  },

  answer: showAnswer,

  lost(since) {
    document.body.dataset.link = "lost";
    setText(byId("link"), "Connection lost");
    const at = since.toLocaleTimeString("en-GB");
    byId("lost").hidden = false;
    setText(byId("lost"), `Connection lost at ${at}. What is shown is old. Trying again …`);
    showLost(at);
    forgetPress();
    arrivals = [];
  },

  refused() {
    document.body.dataset.link = "refused";
    setText(byId("link"), "Token wanted");
    byId("main").hidden = true;
    byId("lost").hidden = true;
    byId("door").hidden = false;
    byId("token").value = "";
    byId("token").focus();
  },
});

function take(message) {
  if (message.fresh) forget();
  for (const name of Object.keys(rows)) {
    rows[name].push(...message[name]);
    if (rows[name].length > ROOM[name]) rows[name].splice(0, rows[name].length - ROOM[name]);
  }
  addTrail(message.trail);
  latest = message;
  showWords(message.now);
  if (!document.hidden) draw(message.section ?? null, message.fresh || message.trend.length > 0);
  count();
}

function connected() {
  if (document.body.dataset.link !== "live") {
    document.body.dataset.link = "live";
    byId("lost").hidden = true;
    setText(byId("lost"), "");
  }
}

function forget() {
  rows = { windows: [], samples: [], trend: [] };
  clearTrail();
  forgetOrbits();
}

function showWords(now) {
  showWarning(now);
  setText(byId("load"), number(now.load));
  showRecorder(now.recorder);
  for (const panel of document.querySelectorAll(".panel")) {
    const old = Object.entries(PANELS).some(([name, which]) => now.old.includes(name) && panel.matches(which));
    if (panel.dataset.old !== String(old)) panel.dataset.old = String(old);
  }
}

function draw(section, trendIsNew) {
  if (!latest) return;
  showDial(latest.now);
  showMap(latest.now);
  showForces(rows.windows, rows.samples, rows.trend, trendIsNew);
  showPhase(rows.samples);
  showSection(section);
}

/** Count the frames of the last two seconds that were heard and drawn. */
function count() {
  const now = performance.now();
  arrivals.push(now);
  while (arrivals[0] < now - 2000) arrivals.shift();
  if (arrivals.length % 10) return;
  const rate = (arrivals.length - 1) / Math.max((now - arrivals[0]) / 1000, 1e-3);
  setText(byId("link"), "Live");
  setText(byId("rate"), `${rate.toFixed(0)} updates a second`);
}

startRecorder((action) => link.press(action));
startTheme(() => {
  redrawMap();
  redrawForces();
  draw(null, true);
});
document.addEventListener("visibilitychange", () => document.hidden || draw(null, true));
byId("door-form").addEventListener("submit", (event) => {
  event.preventDefault();
  link.useToken(byId("token").value.trim());
});

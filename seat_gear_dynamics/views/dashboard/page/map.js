// The operating point over speed and load: on the regime map where there is one, else on the published bands.

import { byId, colour, describe, make, number, setText } from "./text.js";
import { hatch, Plane } from "./plane.js";

const TRAIL = 12; // s of the way behind the point
const REGIMES = ["periodic", "quasi-periodic", "chaotic", "undecided"];

let plane = null;
let scene = null;
let trail = [];
let still = null;
let regimes = "";

export function startMap(given, fresh) {
  scene = given;
  plane ??= new Plane(byId("map"), "speed of s1, r/min", "load T4, N·m");
  plane.resized = () => (still = null);
  if (fresh) trail = [];
  still = null;
  const map = scene.map;
  plane.range = map
    ? [edges(map.speeds).at(0), edges(map.speeds).at(-1), edges(map.loads).at(0), edges(map.loads).at(-1)]
    : [0, scene.scaleRpm, 0, 800];
  regimes = map
    ? `Regimes: map ${map.name}.`
    : "No regime map of this machine: compute one with seat-gear map, and start the dashboard with --map FILE.";
  byId("map").closest(".panel").dataset.plain = String(!map);
  showLegend(map);
}

export const redrawMap = () => (still = null);

function edges(nodes) {
  if (nodes.length === 1) return [nodes[0] * 0.95, nodes[0] * 1.05];
  const inner = nodes.slice(1).map((value, i) => (value + nodes[i]) / 2);
  return [2 * nodes[0] - inner[0], ...inner, 2 * nodes.at(-1) - inner.at(-1)];
}

function showLegend(map) {
  const legend = byId("map-legend");
  const present = map ? REGIMES.filter((name) => map.codes.some((row) => row.includes(map.names.indexOf(name)))) : [];
  const made = present.map((name) => {
    const item = make("span", "key", name);
    item.dataset.regime = name;
    return item;
  });
  const band = make("span", "key", map ? "forbidden at the present load" : "forbidden");
  band.dataset.regime = "band";
  legend.replaceChildren(...made, band);
}

function drawStill(c) {
  const { map } = scene;
  if (!map) return;
  const xs = edges(map.speeds).map((v) => plane.x(v));
  const ys = edges(map.loads).map((v) => plane.y(v));
  c.globalAlpha = Number(colour("map-strength"));
  map.codes.forEach((row, j) => {
    row.forEach((code, i) => {
      c.fillStyle = colour(`regime-${map.names[code]}`);
      // On whole pixels: neighbours must neither overlap nor let the ground shine through between them.
      const [left, right, top, bottom] = [xs[i], xs[i + 1], ys[j + 1], ys[j]].map(Math.round);
      c.fillRect(left, top, right - left, bottom - top);
    });
  });
  c.globalAlpha = 1;
}

export function addTrail(rows) {
  trail.push(...rows);
  const last = trail.at(-1)?.[0] ?? 0;
  trail = trail.filter(([t]) => t > last - TRAIL);
}

export function clearTrail() {
  trail = [];
}

export function showMap(now) {
  setText(byId("map-note"), `Forbidden bands: ${now.bandsFrom}. ${regimes}`);
  if (!plane || !plane.width) plane?.fit();
  if (!plane?.width) return;
  if (!still) {
    if (!plane.begin(drawStill, !scene.map)) return;
    still = document.createElement("canvas");
    still.width = plane.canvas.width;
    still.height = plane.canvas.height;
    still.getContext("2d").drawImage(plane.canvas, 0, 0);
  }
  const c = plane.context;
  c.setTransform(1, 0, 0, 1, 0, 0);
  c.clearRect(0, 0, plane.canvas.width, plane.canvas.height);
  c.drawImage(still, 0, 0);
  c.setTransform(plane.ratio, 0, 0, plane.ratio, 0, 0);
  plane.clipped(() => {
    if (!scene.map) drawColumns(c, now);
    else if (now.load !== null) drawBands(c, now);
    drawTrail(c);
    if (now.speed !== null && now.load !== null) drawPoint(c, now);
  });
  const where = now.outside ?? `${number(now.speed === null ? null : Math.abs(now.speed))} r/min, ${number(now.load)} N·m`;
  describe(plane.canvas, `Operating point: ${where}. ${now.motion}.`);
}

function drawTrail(c) {
  c.lineJoin = "round";
  c.lineCap = "round";
  const last = trail.at(-1)?.[0] ?? 0;
  for (const [width, ink] of [[4, "trail-rim"], [1.8, "trail"]]) {
    c.strokeStyle = colour(ink);
    c.lineWidth = width;
    for (let i = 1; i < trail.length; i += 1) {
      if (trail[i][0] - trail[i - 1][0] > 1) continue; // nothing was heard in between
      c.globalAlpha = 0.12 + 0.78 * Math.max(1 - (last - trail[i][0]) / TRAIL, 0);
      c.beginPath();
      c.moveTo(plane.x(trail[i - 1][1]), plane.y(trail[i - 1][2]));
      c.lineTo(plane.x(trail[i][1]), plane.y(trail[i][2]));
      c.stroke();
    }
  }
  c.globalAlpha = 1;
}

/** Without a map: the forbidden bands over every load. */
function drawColumns(c, now) {
  const { y, height } = plane.inner;
  for (const [low, high] of now.bands) {
    const left = plane.x(low);
    hatch(c, left, y, Math.max(plane.x(high) - left, 3), height, "band");
  }
}

/** The forbidden bands of the present load, at its height. */
function drawBands(c, now) {
  const middle = plane.y(now.load);
  for (const [low, high] of now.bands) {
    const left = plane.x(low);
    for (const [height, ink] of [[9, "trail-rim"], [5, "trail"]]) {
      c.fillStyle = colour(ink);
      c.fillRect(left - height / 4, middle - height / 2, Math.max(plane.x(high) - left, 2) + height / 2, height);
    }
  }
}

function drawPoint(c, now) {
  const { x, y, width, height } = plane.inner;
  const px = Math.min(Math.max(plane.x(Math.abs(now.speed)), x + 4), x + width - 4);
  const py = Math.min(Math.max(plane.y(now.load), y + 4), y + height - 4);
  for (const [radius, fill] of [[10, "trail-rim"], [8, "trail"], [4.5, `level-${now.level}`]]) {
    c.fillStyle = colour(fill);
    c.beginPath();
    c.arc(px, py, radius, 0, 2 * Math.PI);
    c.fill();
  }
}

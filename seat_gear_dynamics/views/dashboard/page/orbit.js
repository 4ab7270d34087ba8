// Phase portrait from the samples, and the Poincaré section as the monitor publishes it.

import { byId, colour, describe, number } from "./text.js";
import { Plane } from "./plane.js";

const SPAN = 6; // s of samples in the portrait
const SHRINK = 0.02; // share of the way that a range shrinks towards its points at each picture; it grows at once

class Cloud {
  constructor(canvas, xLabel, yLabel) {
    this.plane = new Plane(canvas, xLabel, yLabel);
    this.tight = null;
  }

  /** Follow the points with the ranges: out at once, back slowly, so that the eye keeps its bearings. */
  follow(points) {
    if (!points.length) return;
    const box = [Infinity, -Infinity, Infinity, -Infinity];
    for (const [x, y] of points) {
      box[0] = Math.min(box[0], x);
      box[1] = Math.max(box[1], x);
      box[2] = Math.min(box[2], y);
      box[3] = Math.max(box[3], y);
    }
    const old = this.tight ?? box;
    this.tight = box.map((value, i) => {
      const outward = i % 2 ? value > old[i] : value < old[i];
      return outward ? value : old[i] + (value - old[i]) * SHRINK;
    });
    const [left, right, low, high] = this.tight;
    const across = Math.max(right - left, this.least[0]);
    const up = Math.max(high - low, this.least[1]);
    const [x, y] = [(left + right) / 2, (low + high) / 2];
    this.plane.range = [x - across * 0.58, x + across * 0.58, y - up * 0.58, y + up * 0.58];
  }

  /** Draw points with `ink` (index → alpha), over the shaded stretch in which the teeth are apart. */
  show(points, half, ink, alpha) {
    this.follow(points);
    const { plane } = this;
    const apart = (c) => {
      const { y, height } = plane.inner;
      c.fillStyle = colour("apart");
      c.fillRect(plane.x(-half), y, plane.x(half) - plane.x(-half), height);
    };
    if (!plane.begin(apart)) return;
    const size = Math.max(plane.font * 0.24, 2.2);
    plane.clipped((c) => {
      c.fillStyle = colour(ink);
      points.forEach(([x, y], i) => {
        c.globalAlpha = alpha(i);
        c.beginPath();
        c.arc(plane.x(x), plane.y(y), size, 0, 2 * Math.PI);
        c.fill();
      });
    });
    if (!points.length) this.say("no points yet");
  }

  say(text) {
    const { plane } = this;
    const { x, y, width, height } = plane.inner;
    plane.context.fillStyle = colour("soft");
    plane.context.textAlign = "center";
    plane.context.fillText(text, x + width / 2, y + height / 2);
  }
}

let scene = null;
let phase = null;
let section = null;
let points = [];
let mesh = 0;

export function startOrbits(given) {
  scene = given;
  if (!phase) {
    phase = new Cloud(byId("phase"), "δ, µm", "dδ/dt, mm/s");
    section = new Cloud(byId("section"), "δ / b_c", "rate of δ, dimensionless");
    for (const radio of document.querySelectorAll("[name=mesh]")) {
      radio.addEventListener("change", () => {
        mesh = Number(radio.value);
        phase.tight = null;
      });
    }
  }
  phase.least = [0.05, 0.5];
  section.least = [0.02, 0.02];
  forgetOrbits();
}

export function forgetOrbits() {
  points = [];
  phase.tight = section.tight = null;
}

export function showPhase(samples) {
  if (!phase) return;
  const end = samples.at(-1)?.[0] ?? 0;
  const shown = samples.filter(([t]) => t > end - SPAN);
  const at = 1 + 3 * mesh;
  const half = scene.halfBacklash[mesh] * 1e6;
  const rows = shown.map((row) => [row[at] * 1e6, row[at + 1] * 1e3]);
  phase.show(rows, half, `mesh-${mesh}`, (i) => 0.15 + (0.85 * (i + 1)) / shown.length);
  const last = rows.at(-1);
  const where = last ? `δ ${number(last[0], 1)} µm, rate ${number(last[1], 1)} mm/s` : "no samples yet";
  describe(phase.plane.canvas, `Phase portrait of ${mesh ? "s3_s4" : "s1_s2"}: ${where}.`);
}

export function showSection(given) {
  if (!section) return;
  if (given) points = given;
  section.show(points, scene.halfBacklash[0] / scene.lengthUnit, "section", () => 0.75);
  describe(section.plane.canvas, `Poincaré section of s1_s2: ${points.length} points.`);
}

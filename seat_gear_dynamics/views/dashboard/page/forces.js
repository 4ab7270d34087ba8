// Mesh forces: the last seconds window by window with the samples in them, and minutes as a trend.

import { byId, colour, describe, number } from "./text.js";

const WAVE = 4; // s
const TREND = [1, 2, 5, 10]; // min; the least of them that holds what there is
const SHRINK = 0.02;

let charts = [];
let minutes = TREND[0];

/** A range that grows at once and shrinks slowly. */
function steady() {
  let kept = null;
  return (plot, low, high) => {
    if (low === null || high === null) return kept ?? [0, 1];
    const box = [Math.min(low, 0), Math.max(high, 1)];
    kept ??= box;
    kept = box.map((value, i) => ((i ? value > kept[i] : value < kept[i]) ? value : kept[i] + (value - kept[i]) * SHRINK));
    const room = 0.04 * (kept[1] - kept[0]);
    return [kept[0] < 0 ? kept[0] - room : 0, kept[1] + room];
  };
}

function chart(element, mesh, span, label, withDots) {
  const range = () => [-span(), 0];
  const ink = () => colour(`mesh-${mesh}`);
  const font = Math.round(parseFloat(getComputedStyle(element).fontSize)); // uPlot scales whole pixels only
  const fontText = `${font}px system-ui, sans-serif`;
  const axis = (extra) => ({
    stroke: () => colour("soft"),
    font: fontText,
    labelFont: fontText,
    labelSize: font * 1.5,
    grid: { stroke: () => colour("grid"), width: 1 },
    ticks: { show: false },
    ...extra,
  });
  const minus = (plot, values) => values.map((v) => String(v).replace("-", "−"));
  const line = (extra) => ({ stroke: ink, points: { show: false }, spanGaps: true, ...extra });
  const series = [
    {},
    line({ width: 0.75, alpha: 0.6 }),
    line({ width: 0.75, alpha: 0.6 }),
    line({ width: 2.2 }),
    line({ width: 1.3, dash: [5, 4] }),
  ];
  if (withDots) series.push({ paths: () => null, points: { show: true, size: 4, fill: () => colour("ink"), stroke: () => colour("ink") } });
  const plot = new uPlot(
    {
      width: Math.max(element.clientWidth, 50),
      height: Math.max(element.clientHeight, 50),
      padding: [font * 0.7, font * 0.8, 0, 0],
      legend: { show: false },
      cursor: { show: false },
      scales: { x: { time: false, range }, y: { range: steady() } },
      axes: [
        axis({ label, size: font * 1.6, gap: 3, values: minus }),
        axis({ label: "N", size: font * 3.6, gap: 4, space: font * 2.4, values: minus }),
      ],
      series,
      bands: [{ series: [1, 2], fill: () => colour(`mesh-${mesh}-band`) }],
    },
    series.map(() => []),
    element,
  );
  new ResizeObserver(() => {
    if (element.clientWidth && element.clientHeight) plot.setSize({ width: element.clientWidth, height: element.clientHeight });
  }).observe(element);
  return plot;
}

export function startForces(scene) {
  byId("force-note").textContent =
    "Left, last 4 s: shaded from the least to the greatest force of each window between two messages (20 ms), counted at " +
    "every step of the model; thick: mean; dashed: rms; dots: the force at the samples, which are too few to follow a tooth. " +
    `Right: the same over up to 10 min, by half seconds. Load scale ${Number(scene.loadScale.toPrecision(3))} of the static force.`;
  if (charts.length) return;
  for (const mesh of [0, 1]) {
    charts.push({
      mesh,
      wave: chart(byId(`wave-${mesh}`), mesh, () => WAVE, "s ago, last seconds", true),
      trend: chart(byId(`trend-${mesh}`), mesh, () => minutes, "min ago, trend", false),
    });
  }
}

export function redrawForces() {
  for (const { wave, trend } of charts) {
    wave.redraw();
    trend.redraw();
  }
}

/** Columns of uPlot from rows of (t, then mean, min, max, rms for each mesh), times before `end`, in `unit` s. */
function columns(rows, mesh, end, unit) {
  const at = 1 + 4 * mesh;
  return [
    rows.map((row) => (row[0] - end) / unit),
    rows.map((row) => row[at + 2]),
    rows.map((row) => row[at + 1]),
    rows.map((row) => row[at]),
    rows.map((row) => row[at + 3]),
  ];
}

export function showForces(windows, samples, trend, trendIsNew) {
  const end = windows.at(-1)?.[0] ?? 0;
  const recent = windows.filter(([t]) => t > end - WAVE - 1);
  const dots = samples.filter(([t]) => t > end - WAVE - 1 && t <= end + 1);
  const length = trend.length ? (trend.at(-1)[0] - trend[0][0]) / 60 : 0;
  minutes = TREND.find((each) => each >= length) ?? TREND.at(-1);
  for (const { mesh, wave, trend: slow } of charts) {
    const points = [dots.map(([t]) => t - end), dots.map((row) => row[3 + 3 * mesh])];
    wave.setData(uPlot.join([columns(recent, mesh, end, 1), points]));
    if (trendIsNew) slow.setData(columns(trend, mesh, trend.at(-1)?.[0] ?? 0, 60));
    tell(mesh, windows.at(-1));
  }
}

function tell(mesh, last) {
  const name = mesh ? "s3_s4" : "s1_s2";
  const at = 1 + 4 * mesh;
  const words = last
    ? `mean ${number(last[at])} N, least ${number(last[at + 1])} N, greatest ${number(last[at + 2])} N, rms ${number(last[at + 3])} N`
    : "none yet";
  describe(byId(`wave-${mesh}`), `Force of ${name}, last window: ${words}.`);
}

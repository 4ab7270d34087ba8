// A plane with two axes on a canvas, sharp on every screen: what map, portrait and section are drawn on.

import { colour, tick } from "./text.js";

function steps(low, high, count) {
  const raw = (high - low) / Math.max(count, 1);
  const power = 10 ** Math.floor(Math.log10(raw));
  const step = power * [1, 2, 2.5, 5, 10].find((nice) => nice * power >= raw * 0.999);
  const found = [];
  for (let i = Math.ceil(low / step - 1e-9); i * step <= high + step * 1e-9; i += 1) found.push(i * step);
  return found;
}

export class Plane {
  constructor(canvas, xLabel, yLabel) {
    this.canvas = canvas;
    this.context = canvas.getContext("2d");
    this.labels = [xLabel, yLabel];
    this.range = [0, 1, 0, 1];
    this.stale = true;
    new ResizeObserver(() => this.fit()).observe(canvas);
  }

  fit() {
    const { clientWidth, clientHeight } = this.canvas;
    const ratio = window.devicePixelRatio || 1;
    if (!clientWidth || !clientHeight) return;
    this.width = clientWidth;
    this.height = clientHeight;
    this.canvas.width = Math.round(clientWidth * ratio);
    this.canvas.height = Math.round(clientHeight * ratio);
    this.ratio = ratio;
    this.font = parseFloat(getComputedStyle(this.canvas).fontSize);
    this.margin = { left: this.font * 4.7, right: this.font * 0.9, top: this.font * 0.7, bottom: this.font * 3 };
    this.stale = true;
    this.resized?.();
  }

  get inner() {
    const { left, right, top, bottom } = this.margin;
    return { x: left, y: top, width: this.width - left - right, height: this.height - top - bottom };
  }

  x(value) {
    const { x, width } = this.inner;
    return x + ((value - this.range[0]) / (this.range[1] - this.range[0])) * width;
  }

  y(value) {
    const { y, height } = this.inner;
    return y + height - ((value - this.range[2]) / (this.range[3] - this.range[2])) * height;
  }

  /** Begin a picture: clear, and draw the grid, axes and their numbers. `under` draws what lies below the grid. */
  begin(under = () => {}, grid = true) {
    if (!this.width) this.fit();
    if (!this.width) return false;
    const c = this.context;
    c.setTransform(this.ratio, 0, 0, this.ratio, 0, 0);
    c.clearRect(0, 0, this.width, this.height);
    this.clipped(() => under(c));
    this.axes(c, grid);
    return true;
  }

  axes(c, grid) {
    const { x, y, width, height } = this.inner;
    const across = steps(this.range[0], this.range[1], width / (this.font * 5.5));
    const up = steps(this.range[2], this.range[3], height / (this.font * 3));
    c.font = `${this.font}px system-ui, sans-serif`;
    c.lineWidth = 1;
    c.strokeStyle = colour("grid");
    c.fillStyle = colour("soft");
    c.beginPath();
    if (grid) {
      for (const value of across) c.rect(Math.round(this.x(value)) + 0.5, y, 0, height);
      for (const value of up) c.rect(x, Math.round(this.y(value)) + 0.5, width, 0);
    }
    c.stroke();
    c.strokeStyle = colour("line");
    c.strokeRect(Math.round(x) + 0.5, Math.round(y) + 0.5, Math.round(width), Math.round(height));
    c.textAlign = "center";
    c.textBaseline = "top";
    for (const value of across) c.fillText(tick(value), this.x(value), y + height + 5);
    c.fillText(this.labels[0], x + width / 2, y + height + 5 + this.font * 1.3);
    c.textAlign = "right";
    c.textBaseline = "middle";
    for (const value of up) c.fillText(tick(value), x - 6, this.y(value));
    c.save();
    c.translate(this.font * 0.6, y + height / 2);
    c.rotate(-Math.PI / 2);
    c.textAlign = "center";
    c.fillText(this.labels[1], 0, 0);
    c.restore();
  }

  clipped(draw) {
    const c = this.context;
    const { x, y, width, height } = this.inner;
    c.save();
    c.beginPath();
    c.rect(x, y, width, height);
    c.clip();
    draw(c);
    c.restore();
  }
}

/** Diagonal lines: told apart from a plain surface without colour. */
export function hatch(c, x, y, width, height, colourName, gap = 7) {
  c.save();
  c.beginPath();
  c.rect(x, y, width, height);
  c.clip();
  c.globalAlpha = 0.16;
  c.fillStyle = colour(colourName);
  c.fillRect(x, y, width, height);
  c.globalAlpha = 0.75;
  c.strokeStyle = colour(colourName);
  c.lineWidth = 1.3;
  c.beginPath();
  const first = Math.floor((x - height) / gap) * gap;
  for (let at = first; at < x + width; at += gap) {
    c.moveTo(at, y + height);
    c.lineTo(at + height, y);
  }
  c.stroke();
  c.restore();
}

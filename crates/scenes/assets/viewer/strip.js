"use strict";
// Below the robot: which feet touch, and what the reward is made of, over the last and the next
// seconds. Light is contact.

const ROW = 13; // px of a foot
const PLOT = 46; // px of a reward term
const GAP = 7;
const AXIS = 20;
const STEP = 4; // px of a control step at least

class Strip {
  constructor(canvas, style, onSeek) {
    this.canvas = canvas;
    this.style = style;
    const seek = (event) => {
      const { left } = canvas.getBoundingClientRect();
      onSeek(this.from + ((event.clientX - left - this.gutter) / (this.width - this.gutter)) * this.span);
    };
    canvas.addEventListener("pointerdown", (event) => {
      canvas.setPointerCapture(event.pointerId);
      seek(event);
    });
    canvas.addEventListener("pointermove", (event) => { if (event.buttons) seek(event); });
  }

  show(clip) {
    this.clip = clip;
    const rows = clip.model.rows.length;
    this.height = rows * ROW + (rows ? GAP : 0) + clip.terms.length * (PLOT + GAP) + AXIS;
    this.canvas.style.height = `${this.height}px`;
    this.ranges = clip.terms.map(({ values }) => {
      let [low, high] = [0, 0];
      values.forEach((value) => { low = Math.min(low, value); high = Math.max(high, value); });
      return high > low ? [low, high] : [0, 1];
    });
  }

  draw(seconds) {
    const { canvas, clip } = this;
    const ratio = window.devicePixelRatio || 1;
    this.width = canvas.clientWidth;
    if (!this.width) return;
    if (canvas.width !== Math.round(this.width * ratio) || canvas.height !== Math.round(this.height * ratio)) {
      canvas.width = Math.round(this.width * ratio);
      canvas.height = Math.round(this.height * ratio);
    }
    const pen = canvas.getContext("2d");
    pen.setTransform(ratio, 0, 0, ratio, 0, 0);
    pen.clearRect(0, 0, this.width, this.height);
    this.gutter = this.width < 620 ? 84 : 150;
    const all = clip.nSteps * clip.seconds_per_step;
    this.span = Math.min(all, ((this.width - this.gutter) / STEP) * clip.seconds_per_step);
    this.from = Math.min(Math.max(seconds - this.span / 2, 0), all - this.span);
    const first = Math.floor(this.from / clip.seconds_per_step);
    const last = Math.min(Math.ceil((this.from + this.span) / clip.seconds_per_step), clip.nSteps) - 1;
    pen.textBaseline = "middle";
    let top = this.drawContacts(pen, first, last);
    clip.terms.forEach((term, i) => {
      this.drawTerm(pen, term, this.ranges[i], top, first, last);
      top += PLOT + GAP;
    });
    this.drawAxis(pen, top);
    const x = this.x(seconds);
    pen.fillStyle = this.style("--head");
    pen.fillRect(x - 1, 0, 2, top + 3);
  }

  x(seconds) {
    return this.gutter + ((seconds - this.from) / this.span) * (this.width - this.gutter);
  }

  drawContacts(pen, first, last) {
    const { clip } = this;
    const { rows } = clip.model;
    const seconds = clip.seconds_per_step;
    rows.forEach((row, i) => {
      const top = i * ROW;
      pen.fillStyle = this.style("--dark");
      pen.fillRect(this.gutter, top, this.width - this.gutter, ROW - 1);
      pen.fillStyle = this.style("--contact");
      for (let step = first; step <= last; step += 1) {
        if (!clip.touches(step, row.body)) continue;
        const [a, b] = [Math.max(this.x(step * seconds), this.gutter), this.x((step + 1) * seconds)];
        pen.fillRect(a, top, b - a + 0.3, ROW - 1);
      }
      pen.fillStyle = this.style("--text");
      pen.font = "11px system-ui, sans-serif";
      pen.textAlign = "right";
      pen.fillText(fitted(pen, this.gutter < 100 ? row.short : row.name, this.gutter - 8), this.gutter - 6, top + ROW / 2);
    });
    return rows.length ? rows.length * ROW + GAP : 0;
  }

  drawTerm(pen, term, [low, high], top, first, last) {
    const y = (value) => top + PLOT - 2 - ((value - low) / (high - low)) * (PLOT - 4);
    pen.fillStyle = this.style("--panel");
    pen.fillRect(this.gutter, top, this.width - this.gutter, PLOT);
    pen.strokeStyle = this.style("--grid-bold");
    pen.lineWidth = 1;
    pen.beginPath();
    pen.moveTo(this.gutter, y(0));
    pen.lineTo(this.width, y(0));
    pen.stroke();
    pen.save();
    pen.beginPath();
    pen.rect(this.gutter, top, this.width - this.gutter, PLOT);
    pen.clip();
    pen.strokeStyle = this.style("--line");
    pen.lineWidth = 1.5;
    pen.beginPath();
    for (let step = Math.max(first - 1, 0); step <= last; step += 1) {
      pen.lineTo(this.x((step + 1) * this.clip.seconds_per_step), y(term.values[step]));
    }
    pen.stroke();
    pen.restore();
    pen.textAlign = "right";
    pen.fillStyle = this.style("--text");
    pen.font = "600 11px system-ui, sans-serif";
    pen.fillText(fitted(pen, term.unit ? `${term.name} [${term.unit}]` : term.name, this.gutter - 8), this.gutter - 6, top + PLOT / 2);
    pen.font = "10px system-ui, sans-serif";
    pen.fillStyle = this.style("--faint");
    pen.fillText(short(high), this.gutter - 6, top + 6);
    if (low < 0) pen.fillText(short(low), this.gutter - 6, top + PLOT - 5);
  }

  drawAxis(pen, top) {
    pen.fillStyle = this.style("--faint");
    pen.font = "11px system-ui, sans-serif";
    pen.textAlign = "center";
    const wanted = this.span / Math.max((this.width - this.gutter) / 70, 1);
    const tick = [0.1, 0.2, 0.5, 1, 2, 5, 10, 20, 50, 100].find((it) => it >= wanted) ?? 200;
    for (let i = Math.ceil(this.from / tick - 1e-9); i * tick <= this.from + this.span + 1e-9; i += 1) {
      const x = this.x(i * tick);
      pen.fillRect(x - 0.5, top - 4, 1, 4);
      const text = `${Number((i * tick).toFixed(1))} s`;
      const half = pen.measureText(text).width / 2;
      pen.fillText(text, Math.min(x, this.width - half), top + 8);
    }
  }
}

function short(value) {
  const text = Math.abs(value) >= 100 || (value !== 0 && Math.abs(value) < 1e-3) ? value.toExponential(1) : value.toPrecision(2);
  return text.replace("-", "\u2212");
}

function fitted(pen, text, width) {
  let end = text.length;
  while (end > 1 && pen.measureText(text.slice(0, end) + (end < text.length ? "\u2026" : "")).width > width) end -= 1;
  return end < text.length ? `${text.slice(0, end)}\u2026` : text;
}

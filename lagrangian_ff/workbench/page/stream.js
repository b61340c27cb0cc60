// Curves of the last seconds as they come: measured and predicted torque, the residual below.
import { drawing, h, number } from "./dom.js";

const SECONDS = 10, GAP = 18, LEFT = 56, RIGHT = 12, BELOW = 24;
const AROUND = 285; // pixels of a window beside the curves
const BESIDE = 0.45; // height of the residual, as a share of the torque's
const HOLE = 0.15; // s without samples over which no line is drawn
const SHRINKS = 0.04; // share of the scale by which it comes closer at each picture
const SERIES = { measured: ["measured", 2.6], predicted: ["predicted", 1.1], residual: ["residual", 1] };

// What came, by joint; it stays while the view is made again.
class Past {
  constructor() {
    this.clear();
  }

  clear() {
    this.joints = new Map();
    this.newest = -Infinity;
    this.names = "";
  }

  add({ joints, time, series }) {
    const names = Object.keys(series).join();
    const known = this.joints.get(joints[0]);
    if (names !== this.names || (known && time[0] < known.time.at(-1))) {
      this.clear(); // another model, or a clock that was set back
      this.names = names;
    }
    joints.forEach((joint, n) => {
      if (!this.joints.has(joint)) {
        this.joints.set(joint, { time: [], series: Object.fromEntries(Object.keys(series).map((name) => [name, { low: [], high: [] }])) });
      }
      const one = this.joints.get(joint);
      one.time.push(...time);
      for (const [name, { low, high }] of Object.entries(series)) {
        one.series[name].low.push(...low.map((row) => row[n]));
        one.series[name].high.push(...high.map((row) => row[n]));
      }
      const old = one.time.findIndex((at) => at > time.at(-1) - SECONDS - 1);
      if (old > 0) {
        one.time.splice(0, old);
        Object.values(one.series).forEach(({ low, high }) => [low, high].forEach((values) => values.splice(0, old)));
      }
    });
    this.newest = time.at(-1);
  }
}

export class Stream {
  constructor() {
    this.past = new Past();
    this.shown = new Set();
    this.scales = new Map();
    this.canvas = null;
  }

  // Returns the canvas of a new view.
  place() {
    this.canvas = h("canvas", { role: "img", "aria-label": `torque of the chosen joints over the last ${SECONDS} s; the table beside it has the residual in figures` });
    new ResizeObserver(() => this.draw()).observe(this.canvas);
    return this.canvas;
  }

  add(samples) {
    this.past.add(samples);
    this.draw();
  }

  draw() {
    if (!this.canvas || !this.canvas.isConnected) {
      return;
    }
    const shown = [...this.past.joints.keys()].filter((joint) => this.shown.has(joint));
    const rest = this.past.names.includes("residual");
    const share = (window.innerHeight - AROUND) / Math.max(1, shown.length) - GAP - 10;
    const TORQUE = Math.max(70, Math.min(360, share / (rest ? 1 + BESIDE : 1)));
    const REST = rest ? TORQUE * BESIDE + 4 : 0, each = TORQUE + REST + GAP + 6;
    const { paint, width, colour } = drawing(this.canvas, Math.max(1, shown.length) * each + BELOW);
    const end = this.past.newest, start = end - SECONDS;
    const x = (at) => LEFT + ((at - start) / SECONDS) * (width - LEFT - RIGHT);
    shown.forEach((joint, row) => {
      const one = this.past.joints.get(joint), top = row * each + GAP;
      paint.fillStyle = colour("ink");
      paint.textAlign = "left";
      paint.textBaseline = "alphabetic";
      paint.font = "600 12px system-ui, sans-serif";
      paint.fillText(`${joint} [N·m]`, LEFT, top - 5);
      paint.font = "12px system-ui, sans-serif";
      const from = Math.max(0, one.time.findIndex((at) => at >= start));
      this.panel(paint, colour, x, width, one, from, top, TORQUE, joint, ["measured", "predicted"]);
      if (rest) {
        this.panel(paint, colour, x, width, one, from, top + TORQUE + 4, REST - 4, joint, ["residual"]);
      }
    });
    if (shown.length) {
      paint.fillStyle = colour("soft");
      paint.font = "12px system-ui, sans-serif";
      paint.textBaseline = "alphabetic";
      for (const back of [10, 8, 6, 4, 2, 0]) {
        paint.textAlign = back === 10 ? "left" : back ? "center" : "right";
        paint.fillText(back ? `−${back} s` : "now", x(end - back), shown.length * each + BELOW - 6);
      }
    }
  }

  panel(paint, colour, x, width, one, from, top, tall, joint, names) {
    const drawn = names.filter((name) => name in one.series);
    let least = Infinity, most = -Infinity;
    for (const name of drawn) {
      const { low, high } = one.series[name];
      for (let k = from; k < one.time.length; k++) {
        if (low[k] !== null && low[k] < least) least = low[k];
        if (high[k] !== null && high[k] > most) most = high[k];
      }
    }
    if (least > most) {
      return;
    }
    // The scale widens at once and comes closer slowly: curves that jump cannot be read.
    const key = joint + names[0], before = this.scales.get(key);
    if (before) {
      const span = before[1] - before[0];
      least = Math.min(least, before[0] + SHRINKS * span);
      most = Math.max(most, before[1] - SHRINKS * span);
    }
    this.scales.set(key, [least, most]);
    const room = (most - least || 1) * 1.05, middle = (most + least) / 2;
    const y = (value) => top + tall / 2 - ((value - middle) / room) * tall;
    paint.fillStyle = colour("soft");
    paint.textAlign = "right";
    paint.textBaseline = "middle";
    for (const value of most - least > 1e-9 ? [least, most] : [middle]) {
      paint.fillText(number(value), LEFT - 6, Math.min(top + tall - 4, Math.max(top + 5, y(value))));
    }
    paint.strokeStyle = colour("line");
    paint.lineWidth = 1;
    if (least < 0 && most > 0) {
      paint.beginPath();
      paint.moveTo(LEFT, y(0));
      paint.lineTo(width - RIGHT, y(0));
      paint.stroke();
    }
    for (const name of drawn) {
      const { low, high } = one.series[name], [tint, thick] = SERIES[name];
      paint.strokeStyle = colour(tint);
      paint.lineWidth = thick;
      paint.lineJoin = "round";
      paint.beginPath();
      for (let k = from; k < one.time.length; k++) {
        if (low[k] === null) {
          continue;
        }
        const at = x(one.time[k]), hole = k === from || low[k - 1] === null || one.time[k] - one.time[k - 1] > HOLE;
        paint[hole ? "moveTo" : "lineTo"](at, y(high[k]));
        if (low[k] !== high[k]) paint.lineTo(at, y(low[k]));
      }
      paint.stroke();
    }
  }
}

// Curves of the joints on one time axis: measured and predicted torque, the residual below.
import { drawing, em, h, number } from "./dom.js";
import { trace } from "./link.js";
import { ticks } from "./figures.js";

// What stays when the page is drawn again. `spans` are chosen, [start, end] in s each.
export const kept = { node: "", joints: null, window: null, cursor: null, spans: [], words: "", marks: false };

const SERIES = ["tau", "predicted", "residual", "lower", "upper", "q"];
const LEAST = 96, MOST = 420, REST = 0.45, AROUND = 340;

export class Curves {
  // marked(spans, words) is called when a stretch of time is chosen.
  constructor(node, seconds, marked) {
    this.node = node;
    this.seconds = seconds;
    this.marked = marked;
    this.canvas = h("canvas", { tabindex: "0", role: "img", "data-key": "curves",
      "aria-label": "measured and predicted torque and residual over time; arrow keys move, plus and minus zoom, Home shows all, M marks what is shown" });
    this.readout = h("p", { class: "quiet", "aria-live": "off" }, "Double-click to see all; the arrow keys, + and − move and zoom, M marks what is shown.");
    this.drag = null;
    this.asked = 0;
    this.posed = () => {};
    this.canvas.addEventListener("pointerdown", (event) => this.down(event));
    this.canvas.addEventListener("pointermove", (event) => this.move(event));
    this.canvas.addEventListener("pointerup", (event) => this.up(event));
    this.canvas.addEventListener("dblclick", () => this.show(0, this.seconds));
    this.canvas.addEventListener("keydown", (event) => this.key(event));
    let width = 0;
    new ResizeObserver(() => {
      if (width !== this.canvas.clientWidth) {
        width = this.canvas.clientWidth;
        this.fetch();
      }
    }).observe(this.canvas);
  }

  get left() {
    return 56 * em();
  }

  get right() {
    return 12 * em();
  }

  time(event) {
    const box = this.canvas.getBoundingClientRect();
    const share = (event.clientX - box.left - this.left) / (box.width - this.left - this.right);
    const [start, end] = kept.window;
    return Math.min(end, Math.max(start, start + share * (end - start)));
  }

  down(event) {
    this.canvas.setPointerCapture(event.pointerId);
    this.drag = this.time(event);
  }

  move(event) {
    kept.cursor = this.time(event);
    this.draw();
  }

  up(event) {
    const from = this.drag, to = this.time(event);
    this.drag = null;
    if (from === null || Math.abs(to - from) <= 0.005 * (kept.window[1] - kept.window[0])) {
      this.draw();
    } else if (kept.marks !== event.shiftKey) {
      this.mark(Math.min(from, to), Math.max(from, to));
    } else {
      this.show(Math.min(from, to), Math.max(from, to));
    }
  }

  mark(from, to) {
    this.marked([[from, to]], `${number(from)} to ${number(to)} s`);
  }

  key(event) {
    const [start, end] = kept.window, span = end - start, middle = kept.cursor ?? (start + end) / 2;
    const moves = {
      ArrowLeft: [start - 0.1 * span, end - 0.1 * span], ArrowRight: [start + 0.1 * span, end + 0.1 * span],
      "+": [middle - 0.35 * span, middle + 0.35 * span], "-": [middle - 0.75 * span, middle + 0.75 * span],
      Home: [0, this.seconds],
    };
    if (event.key in moves) {
      event.preventDefault();
      this.show(...moves[event.key]);
    } else if (event.key.toLowerCase() === "m" && !event.ctrlKey && !event.metaKey) {
      this.mark(start, end);
    }
  }

  show(start, end) {
    const span = Math.min(this.seconds, Math.max(0.05, end - start));
    const from = Math.min(Math.max(0, start), this.seconds - span);
    kept.window = [from, from + span];
    this.fetch();
  }

  async fetch() {
    const width = this.canvas.clientWidth;
    if (!width) {
      return;
    }
    const asked = ++this.asked;
    const found = await trace(this.node.id, ...kept.window, Math.max(50, width - this.left - this.right), SERIES);
    if (found && asked === this.asked) {
      this.found = found;
      this.draw();
    }
  }

  draw() {
    if (!this.found || !this.canvas.isConnected) {
      return;
    }
    const names = this.node.compared.joint_names;
    const shown = names.map((_, n) => n).filter((n) => kept.joints.has(names[n]));
    const size = em(), gap = 18 * size, below = 24 * size, { left, right } = this;
    // The joints share the height of the window, as long as each can be read.
    const room = (window.innerHeight - AROUND * size) / shown.length - gap - 8;
    const torque = Math.max(LEAST * size, Math.min(MOST * size, room / (1 + REST))), rest = torque * REST;
    const each = torque + rest + gap + 8, height = shown.length * each + below;
    const { paint, width, colour } = drawing(this.canvas, height);
    const font = `${12 * size}px system-ui, sans-serif`;
    paint.font = font;
    const { time, series } = this.found, [start, end] = kept.window;
    const x = (at) => left + ((at - start) / (end - start)) * (width - left - right);
    const panel = (top, tall, curves, n) => {
      let least = Infinity, most = -Infinity;
      for (const [name] of curves) {
        const { low, high } = series[name][n];
        for (let k = 0; k < time.length; k++) {
          if (low[k] < least) least = low[k];
          if (high[k] > most) most = high[k];
        }
      }
      const range = (most - least || 1) * 1.05, middle = (most + least) / 2;
      const y = (value) => top + tall / 2 - ((value - middle) / range) * tall;
      paint.fillStyle = colour("soft");
      paint.textAlign = "right";
      paint.textBaseline = "middle";
      for (const value of [least, most]) {
        paint.fillText(number(value), left - 6, Math.min(top + tall - 4, Math.max(top + 5, y(value))));
      }
      paint.strokeStyle = colour("line");
      paint.lineWidth = 1;
      if (least < 0 && most > 0) {
        paint.beginPath();
        paint.moveTo(left, y(0));
        paint.lineTo(width - right, y(0));
        paint.stroke();
      }
      paint.fillStyle = colour("accent");
      paint.globalAlpha = 0.14;
      for (const [from, to] of kept.spans) {
        if (to >= start && from <= end) {
          const first = Math.max(left, x(from));
          paint.fillRect(first, top, Math.max(1, Math.min(width - right, x(to)) - first), tall);
        }
      }
      if (curves.length > 1) {
        paint.fillStyle = colour("predicted");
        paint.beginPath();
        series.upper[n].high.forEach((value, k) => paint.lineTo(x(time[k]), y(value)));
        for (let k = time.length - 1; k >= 0; k--) paint.lineTo(x(time[k]), y(series.lower[n].low[k]));
        paint.fill();
      }
      paint.globalAlpha = 1;
      for (const [name, tint, thick] of curves) {
        const { low, high } = series[name][n];
        paint.strokeStyle = colour(tint);
        paint.lineWidth = thick;
        paint.beginPath();
        for (let k = 0; k < time.length; k++) {
          const at = x(time[k]);
          paint.lineTo(at, y(high[k]));
          if (low[k] !== high[k]) paint.lineTo(at, y(low[k]));
        }
        paint.stroke();
      }
    };
    shown.forEach((n, row) => {
      const top = row * each + gap;
      paint.fillStyle = colour("ink");
      paint.textAlign = "left";
      paint.textBaseline = "alphabetic";
      paint.font = `600 ${font}`;
      paint.fillText(`${names[n]} [N·m]`, left, top - 5);
      paint.font = font;
      panel(top, torque, [["tau", "measured", 2.6], ["predicted", "predicted", 1.1]], n);
      panel(top + torque + 4, rest, [["residual", "residual", 1]], n);
    });
    paint.fillStyle = colour("soft");
    paint.textBaseline = "alphabetic";
    paint.textAlign = "center";
    for (const at of ticks(start, end)) {
      paint.fillText(`${Number(at.toFixed(4))} s`, Math.min(width - right - 14 * size, Math.max(left, x(at))), height - 6);
    }
    if (kept.cursor !== null && kept.cursor >= start && kept.cursor <= end) {
      if (this.drag !== null) {
        paint.fillStyle = colour("tint");
        paint.globalAlpha = 0.6;
        paint.fillRect(Math.min(x(this.drag), x(kept.cursor)), 0, Math.abs(x(kept.cursor) - x(this.drag)), height - below);
        paint.globalAlpha = 1;
      }
      paint.strokeStyle = colour("accent");
      paint.beginPath();
      paint.moveTo(x(kept.cursor), 0);
      paint.lineTo(x(kept.cursor), height - below);
      paint.stroke();
      let k = 0;
      while (k < time.length - 1 && time[k + 1] <= kept.cursor) k++;
      this.posed(Object.fromEntries(names.map((name, n) => [name, series.q[n].high[k]])));
      this.readout.textContent = `${kept.cursor.toFixed(3)} s   ` + shown.map((n) =>
        `${names[n]} ${number(series.tau[n].high[k])}, predicted ${number(series.predicted[n].high[k])}`).join("   ");
    }
  }
}

// Measured and predicted torque of the joints on one time axis, the residual below.
import { drawing, h, head, number } from "./dom.js";
import { current, trace } from "./link.js";
import { ticks } from "./figures.js";
import { ErrorMap } from "./map.js";
import { saver } from "./save.js";
import { Arm } from "./arm.js";

export const TITLE = "Compare";
const kept = { node: "", joints: null, window: null, cursor: null, spans: [], words: "" };

export function status(state) {
  const node = current(state);
  return node && node.compared ? `${number(node.compared.rmse)} N·m unseen` : "where does it fail?";
}

const GAP = 18, LEFT = 56, RIGHT = 12, BELOW = 24;

class Curves {
  constructor(node, seconds) {
    this.node = node;
    this.seconds = seconds;
    this.canvas = h("canvas", { tabindex: "0", role: "img", "data-key": "curves",
      "aria-label": "measured and predicted torque and residual over time; arrow keys move, plus and minus zoom, Home shows all" });
    this.readout = h("p", { class: "quiet", "aria-live": "off" }, "Drag to zoom, double-click to see all; the arrow keys, + and − do the same.");
    this.drag = null;
    this.asked = 0;
    this.posed = () => {};
    this.canvas.addEventListener("pointerdown", (event) => this.down(event));
    this.canvas.addEventListener("pointermove", (event) => this.move(event));
    this.canvas.addEventListener("pointerup", (event) => this.up(event));
    this.canvas.addEventListener("dblclick", () => this.show(0, this.seconds));
    this.canvas.addEventListener("keydown", (event) => this.key(event));
    new ResizeObserver(() => this.fetch()).observe(this.canvas);
  }

  get joints() {
    return kept.joints;
  }

  time(event) {
    const box = this.canvas.getBoundingClientRect();
    const share = (event.clientX - box.left - LEFT) / (box.width - LEFT - RIGHT);
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
    if (from !== null && Math.abs(to - from) > 0.005 * (kept.window[1] - kept.window[0])) {
      this.show(Math.min(from, to), Math.max(from, to));
    } else {
      this.draw();
    }
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
    const found = await trace(this.node.id, ...kept.window, Math.max(50, width - LEFT - RIGHT), ["tau", "predicted", "residual", "lower", "upper", "q"]);
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
    const shown = names.map((_, n) => n).filter((n) => this.joints.has(names[n]));
    const TORQUE = Math.max(96, Math.min(240, 400 / shown.length)), REST = TORQUE * 0.45;
    const each = TORQUE + REST + GAP + 8, height = shown.length * each + BELOW;
    const { paint, width, colour } = drawing(this.canvas, height);
    paint.font = "12px system-ui, sans-serif";
    const { time, series } = this.found, [start, end] = kept.window;
    const x = (at) => LEFT + ((at - start) / (end - start)) * (width - LEFT - RIGHT);
    const panel = (top, tall, curves, n) => {
      let least = Infinity, most = -Infinity;
      for (const [name] of curves) {
        const { low, high } = series[name][n];
        for (let k = 0; k < time.length; k++) {
          if (low[k] < least) least = low[k];
          if (high[k] > most) most = high[k];
        }
      }
      const room = (most - least || 1) * 1.05, middle = (most + least) / 2;
      const y = (value) => top + tall / 2 - ((value - middle) / room) * tall;
      paint.fillStyle = colour("soft");
      paint.textAlign = "right";
      paint.textBaseline = "middle";
      for (const value of [least, most]) {
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
      paint.fillStyle = colour("accent");
      paint.globalAlpha = 0.14;
      for (const [from, to] of kept.spans) {
        if (to >= start && from <= end) {
          const first = Math.max(LEFT, x(from));
          paint.fillRect(first, top, Math.max(1, Math.min(width - RIGHT, x(to)) - first), tall);
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
      const top = row * each + GAP;
      paint.fillStyle = colour("ink");
      paint.textAlign = "left";
      paint.textBaseline = "alphabetic";
      paint.font = "600 12px system-ui, sans-serif";
      paint.fillText(`${names[n]} [N·m]`, LEFT, top - 5);
      paint.font = "12px system-ui, sans-serif";
      panel(top, TORQUE, [["tau", "measured", 2.6], ["predicted", "predicted", 1.1]], n);
      panel(top + TORQUE + 4, REST, [["residual", "residual", 1]], n);
    });
    paint.fillStyle = colour("soft");
    paint.textBaseline = "alphabetic";
    paint.textAlign = "center";
    for (const at of ticks(start, end)) {
      paint.fillText(`${Number(at.toFixed(4))} s`, Math.min(width - RIGHT - 14, Math.max(LEFT, x(at))), height - 6);
    }
    if (kept.cursor !== null && kept.cursor >= start && kept.cursor <= end) {
      if (this.drag !== null) {
        paint.fillStyle = colour("tint");
        paint.globalAlpha = 0.6;
        paint.fillRect(Math.min(x(this.drag), x(kept.cursor)), 0, Math.abs(x(kept.cursor) - x(this.drag)), height - BELOW);
        paint.globalAlpha = 1;
      }
      paint.strokeStyle = colour("accent");
      paint.beginPath();
      paint.moveTo(x(kept.cursor), 0);
      paint.lineTo(x(kept.cursor), height - BELOW);
      paint.stroke();
      let k = 0;
      while (k < time.length - 1 && time[k + 1] <= kept.cursor) k++;
      this.posed(Object.fromEntries(names.map((name, n) => [name, series.q[n].high[k]])));
      this.readout.textContent = `${kept.cursor.toFixed(3)} s   ` + shown.map((n) =>
        `${names[n]} ${number(series.tau[n].high[k])}, predicted ${number(series.predicted[n].high[k])}`).join("   ");
    }
  }
}

export function view(state, { go }) {
  const node = current(state);
  if (!node || !node.compared) {
    return [head("Where does it fail?", "Measured and predicted torque on motion that the model has not seen."),
      h("div", { class: "empty" }, h("h3", {}, node ? "It is being compared" : "No model yet"), node ? "One moment." : "Learn a model first.")];
  }
  const names = node.compared.joint_names;
  if (!kept.joints || ![...kept.joints].every((name) => names.includes(name))) {
    kept.joints = new Set(names.slice(0, 3));
  }
  const seconds = node.compared.seconds;
  if (kept.node !== node.id || !kept.window) {
    kept.window = kept.window && kept.node && kept.window[1] <= seconds ? kept.window : [0, seconds];
    kept.node = node.id;
    kept.spans = [];
  }
  const curves = new Curves(node, seconds);
  const arm = state.skeleton.length ? new Arm(state.skeleton) : null;
  const play = h("button", { class: "plain", "data-key": "play", onclick: () => {
    const playing = play.textContent === "Stop";
    play.textContent = playing ? "Play" : "Stop";
    let before = null;
    const step = (now) => {
      if (play.textContent !== "Stop" || !play.isConnected) {
        return;
      }
      kept.cursor = (kept.cursor ?? kept.window[0]) + (before === null ? 0 : (now - before) / 1000);
      if (kept.cursor > kept.window[1] || kept.cursor < kept.window[0]) {
        kept.cursor = kept.window[0];
      }
      before = now;
      curves.draw();
      requestAnimationFrame(step);
    };
    if (!playing) {
      requestAnimationFrame(step);
    }
  } }, "Play");
  if (arm) {
    curves.posed = (positions) => arm.pose(positions);
  }
  const picks = names.map((name) => {
    const pick = h("button", { class: "pick", "aria-pressed": String(kept.joints.has(name)), "data-key": "joint" + name, onclick: () => {
      if (kept.joints.has(name) && kept.joints.size > 1) {
        kept.joints.delete(name);
      } else {
        kept.joints.add(name);
      }
      pick.setAttribute("aria-pressed", String(kept.joints.has(name)));
      curves.draw();
    } }, name);
    return pick;
  });
  const regions = node.compared.regions.slice(0, 8).map((one, k) =>
    h("li", {}, h("button", { class: "pick", "data-key": "region" + k, onclick: () => {
      kept.joints = new Set([one.joint]);
      picks.forEach((pick, n) => pick.setAttribute("aria-pressed", String(kept.joints.has(names[n]))));
      choose(one.spans, one.words);
    } }, one.words)));
  const marked = h("p", { class: "quiet", "aria-live": "polite" });
  const choose = (spans, words) => {
    kept.spans = spans;
    kept.words = words;
    const length = spans.reduce((sum, [from, to]) => sum + to - from, 0);
    marked.textContent = spans.length ? `Marked: ${words}; ${number(length)} s in ${spans.length} stretches.` : "";
    curves.draw();
  };
  choose(kept.spans, kept.words);
  const worst = names.reduce((a, b) => (node.compared.joints[a].nmse > node.compared.joints[b].nmse ? a : b));
  const map = new ErrorMap(node, regions.length ? node.compared.regions[0].joint : worst, choose);
  return [
    head("Where does it fail?", node.compared.words[0] || "The error is spread evenly over the motion.",
      h("button", { class: "main", "data-key": "next", onclick: () => go("diagnose") }, "Find what is missing")),
    h("div", { class: "two" },
      h("section", {}, h("div", { class: "row", role: "group", "aria-label": "joints that are shown" }, picks), h("div", { class: "lead-up row" }, curves.readout, saver(curves.canvas, "torque")), curves.canvas,
        h("p", { class: "quiet" }, "Grey: measured. Blue: predicted, with its 90 % interval. Below them the residual, measured less predicted."), marked),
      h("div", {}, h("section", { class: "card" }, h("h3", {}, "Where most of the error lies"),
        regions.length ? h("ul", { class: "regions" }, regions) : h("p", { class: "quiet" }, "Nowhere in particular.")),
        h("section", { class: "card" }, h("h3", {}, "The arm at the cursor"), arm ? [arm.canvas, play]
          : h("p", { class: "quiet" }, "Start the workbench with --urdf FILE to see it.")),
        h("section", { class: "card" }, h("h3", {}, "Error over two quantities"), map.element, saver(map.canvas, "error_map")))),
  ];
}

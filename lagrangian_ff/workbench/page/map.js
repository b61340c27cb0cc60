// The error of a joint over two quantities; a rectangle drawn on it chooses those samples everywhere.
import { drawing, em, h, number } from "./dom.js";
import { got, say } from "./link.js";

const SIDES = { size: 300, left: 46, below: 34, top: 8, right: 8 };
const QUANTITIES = { q: ["position", "rad"], qd: ["speed", "rad/s"], tau: ["torque", "N·m"], load: ["load", "N·m"] };
const kept = { x: null, y: null, joint: null };

// The sides of the map in pixels.
function sides() {
  return Object.fromEntries(Object.entries(SIDES).map(([name, value]) => [name, value * em()]));
}

export class ErrorMap {
  // chosen(spans, words) is called when samples are chosen.
  constructor(node, joint, chosen) {
    this.node = node;
    this.chosen = chosen;
    this.spans = [];
    this.lit = [];
    this.names = node.compared.joint_names;
    this.joint = this.names.includes(kept.joint) ? kept.joint : joint;
    kept.x = kept.x || `qd:${this.names.indexOf(this.joint)}`;
    kept.y = kept.y || `load:${this.names.indexOf(this.joint)}`;
    this.canvas = h("canvas", { tabindex: "0", role: "img", "data-key": "map",
      "aria-label": "rms residual over two quantities; drag a rectangle, or press Enter for the worst place" });
    this.canvas.addEventListener("pointerdown", (event) => {
      this.canvas.setPointerCapture(event.pointerId);
      this.from = this.to = this.place(event);
    });
    this.canvas.addEventListener("pointermove", (event) => {
      if (this.from) {
        this.to = this.place(event);
        this.draw();
      }
    });
    this.canvas.addEventListener("pointerup", () => this.choose());
    this.canvas.addEventListener("keydown", (event) => {
      if (event.key === "Enter") {
        this.worst();
      }
    });
    const options = (value) => [h("option", { value: "time", selected: value === "time" }, "time"),
      this.names.flatMap((name, n) => Object.entries(QUANTITIES).map(([key, [words]]) =>
        h("option", { value: `${key}:${n}`, selected: value === `${key}:${n}` }, `${words} of ${name}`)))];
    const pick = (label, key) => h("label", { class: "quiet" }, label + " ",
      h("select", { class: "pick", "data-key": "map" + key, onchange: (event) => {
        kept[key] = event.target.value;
        this.fetch();
      } }, options(kept[key])));
    const joints = h("label", { class: "quiet" }, "error of ", h("select", { class: "pick", "data-key": "mapjoint", onchange: (event) => {
      kept.joint = this.joint = event.target.value;
      this.fetch();
    } }, this.names.map((name) => h("option", { value: name, selected: name === this.joint }, name))));
    this.element = h("div", {}, h("div", { class: "stack" }, joints, pick("across", "x"), pick("up", "y")), this.canvas,
      h("p", { class: "quiet" }, "Darker: larger residual. Drag a rectangle to mark those samples in the curves; what is marked there has a frame here."));
    this.fetch();
  }

  get query() {
    const at = this.names.indexOf(this.joint);
    return `x=${kept.x}&y=${kept.y}&joint=q:${at}`;
  }

  async fetch() {
    const found = await got(`api/map/${this.node.id}?${this.query}`, "json");
    if (found) {
      this.found = found;
      this.from = this.to = null;
      await this.light(this.spans);
    }
  }

  place(event) {
    const box = this.canvas.getBoundingClientRect();
    const { left, right, top, below } = sides();
    const wide = box.width - left - right, tall = box.height - top - below;
    const share = (value) => Math.min(1, Math.max(0, value));
    return [share((event.clientX - box.left - left) / wide), share(1 - (event.clientY - box.top - top) / tall)];
  }

  async choose() {
    if (!this.from || !this.found) {
      return;
    }
    const [a, b] = [this.from, this.to];
    this.from = null;
    if (Math.abs(a[0] - b[0]) < 0.01 && Math.abs(a[1] - b[1]) < 0.01) {
      this.to = null;
      await this.light([]);
      this.chosen([], "");
      return;
    }
    this.box = [Math.min(a[0], b[0]), Math.max(a[0], b[0]), Math.min(a[1], b[1]), Math.max(a[1], b[1])];
    await this.ask();
  }

  async ask() {
    if (!this.found) {
      return;
    }
    const at = (ends, share) => ends[0] + share * (ends[1] - ends[0]);
    const { x, y } = this.found, [left, right, below, above] = this.box;
    const ends = `left=${at(x, left)}&right=${at(x, right)}&below=${at(y, below)}&above=${at(y, above)}`;
    const chosen = await got(`api/chosen/${this.node.id}?${this.query}&${ends}`, "json");
    if (!chosen) {
      say("What was chosen cannot be shown.");
      return;
    }
    this.spans = [];
    this.lit = [];
    this.draw();
    this.chosen(chosen.spans, `${number(at(x, left))} to ${number(at(x, right))}, ${number(at(y, below))} to ${number(at(y, above))}`);
  }

  // Chooses the bin with the largest error, for those who do not use a mouse.
  worst() {
    if (!this.found) {
      return;
    }
    const { rms, count, bins } = this.found;
    let best = 0, most = -1;
    rms.forEach((value, k) => {
      if (value !== null && value * value * count[k] > most) {
        most = value * value * count[k];
        best = k;
      }
    });
    const column = best % bins, row = Math.floor(best / bins);
    this.box = [column / bins, (column + 1) / bins, row / bins, (row + 1) / bins];
    this.ask();
  }

  // Lights up where the samples of stretches of time lie, [start, end] in s each.
  async light(spans) {
    this.spans = spans;
    this.box = null;
    this.lit = [];
    if (spans.length) {
      const lit = await got(`api/lit/${this.node.id}?${this.query}&spans=${spans.map(([from, to]) => `${from}:${to}`).join()}`, "json");
      if (lit && this.spans === spans) {
        this.lit = lit.bins;
      }
    }
    this.draw();
  }

  draw() {
    if (!this.found || !this.canvas.isConnected) {
      return;
    }
    const size = em(), SIZE = SIDES.size * size, { left, right, top, below } = sides();
    const { found } = this, { paint, width, colour } = drawing(this.canvas, SIZE);
    const wide = width - left - right, tall = SIZE - top - below, { bins } = found;
    const known = found.rms.filter((value) => value !== null).sort((a, b) => a - b);
    const most = known[Math.floor(0.98 * (known.length - 1))] || 1;
    const cell = (k, grown) => [left + ((k % bins) * wide) / bins, top + tall - ((Math.floor(k / bins) + 1) * tall) / bins, wide / bins + grown, tall / bins + grown];
    paint.fillStyle = colour("residual");
    found.rms.forEach((value, k) => {
      if (value !== null) {
        paint.globalAlpha = 0.06 + 0.94 * Math.min(1, value / most);
        paint.fillRect(...cell(k, 0.5));
      }
    });
    paint.globalAlpha = 1;
    paint.strokeStyle = colour("accent");
    paint.lineWidth = 1.5 * size;
    this.lit.forEach((k) => paint.strokeRect(...cell(k, 0)));
    paint.lineWidth = 1;
    paint.strokeStyle = colour("line");
    paint.strokeRect(left, top, wide, tall);
    paint.fillStyle = colour("soft");
    paint.font = `${11 * size}px system-ui, sans-serif`;
    const unit = (name) => (name === "time" ? "s" : QUANTITIES[name.split(":")[0]][1]);
    paint.textAlign = "left";
    paint.fillText(number(found.x[0]), left, SIZE - 18 * size);
    paint.textAlign = "right";
    paint.fillText(`${number(found.x[1])} ${unit(kept.x)}`, width - right, SIZE - 18 * size);
    paint.fillText(number(found.y[1]), left - 4, top + 10 * size);
    paint.fillText(number(found.y[0]), left - 4, top + tall);
    paint.fillText(unit(kept.y), left - 4, top + 24 * size);
    paint.textAlign = "center";
    paint.fillText(`darkest: ${number(most)} N·m`, left + wide / 2, SIZE - 4);
    const box = this.from ? [this.from[0], this.to[0], this.from[1], this.to[1]] : this.box;
    if (box) {
      paint.strokeStyle = colour("accent");
      paint.lineWidth = 2;
      paint.strokeRect(left + wide * Math.min(box[0], box[1]), top + tall * (1 - Math.max(box[2], box[3])), wide * Math.abs(box[1] - box[0]), tall * Math.abs(box[3] - box[2]));
    }
  }
}

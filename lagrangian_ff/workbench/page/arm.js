// The arm as its URDF places its joints, posed at a moment; drag to look from elsewhere.
import { drawing, em, h } from "./dom.js";

const HEIGHT = 260;
const view = { turn: 0.7, tilt: 0.35 };

function multiplied(a, b) {
  const found = new Array(9).fill(0);
  for (let r = 0; r < 3; r++) for (let c = 0; c < 3; c++) for (let k = 0; k < 3; k++) found[3 * r + c] += a[3 * r + k] * b[3 * k + c];
  return found;
}

function applied(m, v) {
  return [0, 1, 2].map((r) => m[3 * r] * v[0] + m[3 * r + 1] * v[1] + m[3 * r + 2] * v[2]);
}

// Rodrigues' formula.
function about(axis, angle) {
  const length = Math.hypot(...axis) || 1;
  const [x, y, z] = axis.map((one) => one / length), c = Math.cos(angle), s = Math.sin(angle), t = 1 - c;
  return [t * x * x + c, t * x * y - s * z, t * x * z + s * y, t * x * y + s * z, t * y * y + c, t * y * z - s * x,
    t * x * z - s * y, t * y * z + s * x, t * z * z + c];
}

const EYE = [1, 0, 0, 0, 1, 0, 0, 0, 1];

// Places of the joints for positions by name.
export function placed(joints, positions) {
  const frames = [];
  for (const joint of joints) {
    const base = joint.parent < 0 ? { place: [0, 0, 0], turn: EYE } : frames[joint.parent];
    const shift = applied(base.turn, joint.origin);
    let place = base.place.map((one, k) => one + shift[k]);
    let turn = multiplied(base.turn, joint.rotation);
    const q = positions[joint.name] || 0;
    if (joint.kind === "prismatic") {
      place = place.map((one, k) => one + applied(turn, joint.axis)[k] * q);
    } else if (joint.kind !== "fixed") {
      turn = multiplied(turn, about(joint.axis, q));
    }
    frames.push({ place, turn, parent: joint.parent, moves: joint.kind !== "fixed" });
  }
  return frames;
}

// A serial arm of equal links, for joints of which only the names are known.
export function stick(names) {
  const axes = [[0, 0, 1], [0, 1, 0], [0, 1, 0], [0, 0, 1], [0, 1, 0], [0, 0, 1]];
  const joints = names.map((name, k) => ({ name, kind: "revolute", parent: k - 1,
    origin: [0, 0, k ? 1 : 0.4], rotation: EYE, axis: axes[k % axes.length] }));
  return [...joints, { name: "", kind: "fixed", parent: names.length - 1, origin: [0, 0, 0.6], rotation: EYE, axis: [0, 0, 1] }];
}

export class Arm {
  constructor(joints) {
    this.joints = joints;
    this.positions = {};
    this.canvas = h("canvas", { tabindex: "0", role: "img", "data-key": "arm", "aria-label": "the arm, posed at the cursor; arrow keys turn the view" });
    this.canvas.addEventListener("pointerdown", (event) => {
      this.canvas.setPointerCapture(event.pointerId);
      this.at = [event.clientX, event.clientY];
    });
    this.canvas.addEventListener("pointermove", (event) => {
      if (this.at && event.buttons) {
        this.look((event.clientX - this.at[0]) / 100, (event.clientY - this.at[1]) / 100);
        this.at = [event.clientX, event.clientY];
      }
    });
    this.canvas.addEventListener("keydown", (event) => {
      const moves = { ArrowLeft: [-0.15, 0], ArrowRight: [0.15, 0], ArrowUp: [0, -0.1], ArrowDown: [0, 0.1] };
      if (event.key in moves) {
        event.preventDefault();
        this.look(...moves[event.key]);
      }
    });
    new ResizeObserver(() => this.draw()).observe(this.canvas);
  }

  look(turn, tilt) {
    view.turn += turn;
    view.tilt = Math.min(1.5, Math.max(-0.2, view.tilt + tilt));
    this.draw();
  }

  pose(positions) {
    this.positions = positions;
    this.draw();
  }

  draw() {
    if (!this.canvas.clientWidth) {
      return;
    }
    const SIZE = HEIGHT * em(), { paint, width, colour } = drawing(this.canvas, SIZE);
    const reach = this.joints.reduce((sum, joint) => sum + Math.hypot(...joint.origin), 0) || 1;
    const size = (0.8 * SIZE) / reach, [a, b] = [view.turn, view.tilt];
    const seen = ([x, y, z]) => {
      const across = x * Math.cos(a) - y * Math.sin(a), deep = x * Math.sin(a) + y * Math.cos(a);
      return [width / 2 + across * size, SIZE * 0.82 - (z * Math.cos(b) - deep * Math.sin(b)) * size];
    };
    paint.strokeStyle = colour("line");
    paint.lineWidth = 1;
    const far = 0.45 * reach;
    for (let k = -2; k <= 2; k++) {
      for (const [from, to] of [[[k * far / 2, -far, 0], [k * far / 2, far, 0]], [[-far, k * far / 2, 0], [far, k * far / 2, 0]]]) {
        paint.beginPath();
        paint.moveTo(...seen(from));
        paint.lineTo(...seen(to));
        paint.stroke();
      }
    }
    const frames = placed(this.joints, this.positions);
    paint.lineCap = "round";
    paint.lineWidth = 7;
    paint.strokeStyle = colour("measured");
    frames.forEach((frame) => {
      paint.beginPath();
      paint.moveTo(...seen(frame.parent < 0 ? [0, 0, 0] : frames[frame.parent].place));
      paint.lineTo(...seen(frame.place));
      paint.stroke();
    });
    paint.fillStyle = colour("accent");
    frames.filter((frame) => frame.moves).forEach((frame) => {
      paint.beginPath();
      paint.arc(...seen(frame.place), 4.5, 0, 2 * Math.PI);
      paint.fill();
    });
  }
}

// Small pictures, as SVG.
import { number, s } from "./dom.js";

// How often each value occurs, as bars.
export function bars(counts, label) {
  const most = Math.max(...counts, 1);
  const wide = 100 / counts.length;
  return s("svg", { viewBox: "0 0 100 20", preserveAspectRatio: "none", role: "img", "aria-label": label },
    counts.map((count, k) => s("rect", { class: "bar", x: k * wide, width: wide * 0.85,
      y: 20 - 20 * Math.sqrt(count / most), height: 20 * Math.sqrt(count / most) })));
}

// The way from the first model to the present one, the first first.
export function line(state) {
  const found = [];
  let node = state.nodes.find((one) => one.id === state.current);
  while (node) {
    found.unshift(node);
    node = state.nodes.find((one) => one.id === node.parent);
  }
  return found;
}

// The error of each step on motion that took no part, as a staircase.
export function stairs(state, width, height) {
  return staircase(line(state).filter((node) => node.compared).map((node) => ({ title: node.title, rmse: node.compared.rmse })), width, height);
}

// The errors of steps, each with a title and its rmse, as a staircase; beside them, dashed, that of another model.
export function staircase(steps, width, height, beside = null) {
  if (!steps.length) {
    return null;
  }
  const errors = steps.map((one) => one.rmse), every = beside ? [...steps, beside] : steps;
  const top = Math.max(...every.map((one) => one.rmse)) * 1.15;
  const left = 4, bottom = height - 16, room = bottom - 14;
  const x = (k) => left + ((width - left * 2) * k) / steps.length;
  const y = (error) => 14 + room * (1 - error / top);
  let path = "";
  errors.forEach((error, k) => {
    path += `${k ? "L" : "M"}${x(k)} ${y(error)}L${x(k + 1)} ${y(error)}`;
  });
  // At the end most room is left, as the error has fallen by then.
  const clear = beside && y(errors.at(-1)) - y(beside.rmse) > 18;
  const words = every.map((one) => `${one.title}: ${number(one.rmse)} N·m`).join("; ");
  return s("svg", { viewBox: `0 0 ${width} ${height}`, width, height, role: "img", "aria-label": `error on unseen motion: ${words}` },
    s("line", { class: "axis", x1: left, x2: width - left, y1: bottom, y2: bottom }),
    beside ? [s("line", { class: "beside", x1: left, x2: width - left, y1: y(beside.rmse), y2: y(beside.rmse) }),
      s("text", { x: clear ? width - left : width / 2, y: y(beside.rmse) - 4, "text-anchor": clear ? "end" : "middle" }, `${beside.title}: ${number(beside.rmse)}`)] : null,
    s("path", { class: "fall", d: path }),
    s("text", { x: left, y: y(errors[0]) - 4 }, number(errors[0])),
    errors.length > 1 ? s("text", { x: width - left, y: y(errors.at(-1)) - 4, "text-anchor": "end" }, number(errors.at(-1))) : null,
    s("text", { x: left, y: height - 3 }, "unseen error [N·m]"));
}

function scale(low, high, from, to) {
  const span = high - low || 1;
  return (value) => from + ((value - low) / span) * (to - from);
}

export function ticks(low, high) {
  const raw = (high - low) / 4 || 1;
  const power = 10 ** Math.floor(Math.log10(raw));
  const step = [1, 2, 5, 10].map((one) => one * power).find((one) => one >= raw);
  const found = [];
  for (let at = Math.ceil(low / step) * step; at <= high + 1e-9 * step; at += step) {
    found.push(at);
  }
  return found;
}

// What the data show of an effect over its own coordinate, and the effect as fitted.
export function curve(found) {
  const { x, residual = [], low = found.curve.effect, high = low, effect, coordinate, unit } = found.curve;
  const width = 560, height = 260, left = 52, right = 10, top = 24, bottom = 40;
  const every = [...low, ...high, ...effect].filter((value) => value !== null);
  const across = scale(Math.min(...x), Math.max(...x), left, width - right);
  const up = scale(Math.min(...every), Math.max(...every), height - bottom, top);
  const path = (values) => values.map((value, k) => (value === null ? "" : `${k ? "L" : "M"}${across(x[k])} ${up(value)}`)).join("");
  const area = path(high) + x.map((_, k) => x.length - 1 - k).map((k) => `L${across(x[k])} ${up(low[k])}`).join("") + "Z";
  return s("svg", { viewBox: `0 0 ${width} ${height}`, role: "img", "aria-label": `torque that the model lacks over ${coordinate}, and ${found.effect} as fitted` },
    ticks(Math.min(...every), Math.max(...every)).map((at) => [
      s("line", { class: "axis", x1: left, x2: width - right, y1: up(at), y2: up(at) }),
      s("text", { x: left - 6, y: up(at) + 4, "text-anchor": "end" }, number(at))]),
    ticks(Math.min(...x), Math.max(...x)).map((at) =>
      s("text", { x: across(at), y: height - bottom + 16, "text-anchor": "middle" }, number(at))),
    s("path", { class: "band", d: area }),
    s("path", { class: "effect", d: path(effect) }),
    residual.map((value, k) => (value === null ? null : s("circle", { class: "rest", cx: across(x[k]), cy: up(value), r: 2.6 }))),
    s("text", { x: (left + width) / 2, y: height - 6, "text-anchor": "middle" }, `${coordinate} [${unit}]`),
    s("text", { x: left, y: top - 12 }, residual.length ? "N·m: what the rest of the model leaves (dots, 90 % band), and the effect as fitted"
      : found.curve.friction ? "N·m: the curve, which changes its sign with the direction" : "N·m: the curve"));
}

// The error of each block of unseen motion, before and after.
export function blocks(found) {
  const { before, after } = found.blocks;
  const width = 560, height = 74, most = Math.max(...before, ...after);
  const wide = width / before.length;
  return s("svg", { viewBox: `0 0 ${width} ${height}`, role: "img", "aria-label": "error of each block of unseen motion before and after adding it" },
    before.map((value, k) => [
      s("rect", { class: "before", x: k * wide, width: wide * 0.42, y: 56 - (50 * value) / most, height: (50 * value) / most }),
      s("rect", { class: "after", x: k * wide + wide * 0.44, width: wide * 0.42, y: 56 - (50 * after[k]) / most, height: (50 * after[k]) / most })]),
    s("text", { x: 0, y: 68 }, "error by block of unseen motion: grey before, coloured after"));
}

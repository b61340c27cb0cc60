// Elements without a library: h("button", {class: "main", onclick: go}, "Learn").
const SVG = "http://www.w3.org/2000/svg";

function filled(element, properties, children) {
  for (const [name, value] of Object.entries(properties || {})) {
    if (name.startsWith("on")) {
      element.addEventListener(name.slice(2), value);
    } else if (value === true) {
      element.setAttribute(name, "");
    } else if (value !== false && value !== null && value !== undefined) {
      element.setAttribute(name, value);
    }
  }
  element.append(...children.flat(Infinity).filter((one) => one !== null && one !== undefined && one !== false));
  return element;
}

export function h(tag, properties, ...children) {
  return filled(document.createElement(tag), properties, children);
}

export function s(tag, properties, ...children) {
  return filled(document.createElementNS(SVG, tag), properties, children);
}

// Three significant digits, as an engineer writes them.
export function number(value) {
  if (value === null || value === undefined || !Number.isFinite(value)) {
    return "–";
  }
  const size = Math.abs(value);
  if (size !== 0 && (size >= 1e5 || size < 1e-4)) {
    return value.toExponential(2);
  }
  return String(Number(value.toPrecision(3)));
}

export function spoken(name) {
  return name.replaceAll("_", " ");
}

export function head(title, lead, ...actions) {
  return h("div", { class: "head" }, h("div", {}, h("h2", {}, title), h("p", {}, lead)),
    h("div", { class: "row" }, actions));
}

// The size of text, in units of that for which drawings are laid out.
export function em() {
  return parseFloat(getComputedStyle(document.documentElement).fontSize) / 15;
}

// Sizes a canvas to its place, sharp on every screen, and returns what to draw with.
export function drawing(canvas, height) {
  const ratio = window.devicePixelRatio || 1, width = canvas.clientWidth;
  canvas.style.height = `${height}px`;
  canvas.width = Math.round(width * ratio);
  canvas.height = Math.round(height * ratio);
  const paint = canvas.getContext("2d"), style = getComputedStyle(document.documentElement);
  paint.scale(ratio, ratio);
  return { paint, width, colour: (name) => style.getPropertyValue("--" + name).trim() };
}

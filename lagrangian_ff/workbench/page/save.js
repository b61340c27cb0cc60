// Figures as files: SVG as it is drawn, a canvas as PNG.
import { h } from "./dom.js";

const KEPT = ["fill", "stroke", "stroke-width", "opacity", "font-size", "font-family"];

function saved(name, blob) {
  const link = h("a", { href: URL.createObjectURL(blob), download: name });
  link.click();
  setTimeout(() => URL.revokeObjectURL(link.href), 1000);
}

function svg(figure, name) {
  const copy = figure.cloneNode(true), from = figure.querySelectorAll("*");
  copy.setAttribute("xmlns", "http://www.w3.org/2000/svg");
  copy.querySelectorAll("*").forEach((one, k) => {
    const style = getComputedStyle(from[k]);
    KEPT.forEach((key) => one.setAttribute(key, style.getPropertyValue(key)));
    one.removeAttribute("class");
  });
  saved(`${name}.svg`, new Blob([new XMLSerializer().serializeToString(copy)], { type: "image/svg+xml" }));
}

function png(canvas, name) {
  canvas.toBlob((blob) => saved(`${name}.png`, blob));
}

// A button that saves the figure beside it.
export function saver(figure, name) {
  const drawn = figure instanceof SVGElement;
  return h("button", { class: "save", "data-key": "save" + name, "aria-label": `save the figure ${name} as ${drawn ? "SVG" : "PNG"}`,
    onclick: () => (drawn ? svg : png)(figure, name) }, drawn ? "SVG" : "PNG");
}

export function download(text, name, label) {
  return h("button", { class: "plain", "data-key": "download" + name, onclick: () => saved(name, new Blob([text], { type: "text/plain" })) }, label);
}

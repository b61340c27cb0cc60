// What to take away: the model, and the commands that repeat it all.
import { h, head } from "./dom.js";
import { current } from "./link.js";
import { line } from "./figures.js";
import { download } from "./save.js";

export const TITLE = "Take away";

export function status(state) {
  return current(state) ? "model, parameters" : "nothing yet";
}

function quoted(text) {
  return /^[\w./+=-]+$/.test(text) ? text : `'${text.replaceAll("'", "'\\''")}'`;
}

const FORMULAS = "formulas.json";

// The options with which a step is added: of a curve what it is over, of a formula the shape that was found.
function form({ form, shape }) {
  const over = form ? ` --over ${form.over.map(quoted).join(" ")}${form.friction ? " --friction" : ""}` : "";
  const values = Object.entries(shape || {}).map(([name, value]) => `${name}=${value}`);
  return over + (values.length ? ` --shape ${values.join(" ")}` : "");
}

// The formulas of the user's own that the model has.
function formulas(state) {
  const used = new Set(line(state).map((node) => node.added.effect));
  return state.formulas.filter((one) => used.has(one.name));
}

// Formulas as a file for --effects-file.
function file(effects) {
  return JSON.stringify({ effects }, null, 2);
}

// The options of reading that make of one scale of the effort another.
function scaled(before, after) {
  const changed = [...new Set([...Object.keys(before), ...Object.keys(after)])].filter((joint) => (before[joint] ?? 1) !== (after[joint] ?? 1));
  return changed.length ? " --effort-scale " + changed.map((joint) => quoted(`${joint}=${after[joint] ?? 1}`)).join(" ") : "";
}

function commands(state) {
  const cards = (role) => state.cards.filter((card) => card.role === role && !card.error);
  const of = (role) => cards(role).map((card) => quoted(card.file)).join(" ");
  const steps = line(state);
  const { effort = "total", effort_delay: delay = 0, asked = "", urdf = "", scales = {}, learned, stretch } = steps[0].settings;
  const sources = Object.keys(scales), [before = {}] = Object.values(scales);
  const options = [asked ? ` --model ${asked}` : "", urdf ? ` --urdf ${quoted(urdf)}` : "", effort === "total" ? "" : ` --effort ${effort}`, delay ? ` --effort-delay ${delay}` : "", scaled({}, before)].join("");
  const found = [`lagrangian_ff identify ${sources.length ? sources.map(quoted).join(" ") : of("learn")}${options} --train ${learned ?? "1.0"} --output model.npz`];
  if (stretch) {
    found.unshift(`# The investigation learned from ${learned} of every ${stretch} s; this learns from the first ${learned} of each recording.`);
  }
  if (Object.values(scales).some((one) => scaled(before, one))) {
    found.unshift("# These recordings were read with different scales of the effort: convert them first.");
  }
  const own = formulas(state);
  const option = own.length ? ` --effects-file ${FORMULAS}` : "";
  if (own.length) {
    found.unshift(`cat > ${FORMULAS} <<'END'\n${file(own)}\nEND`);
  }
  let model = "model.npz";
  steps.slice(1).forEach(({ added }, k) => {
    const next = `model_${k + 1}.npz`;
    found.push(`lagrangian_ff add ${model} ${added.form ? "curve" : quoted(added.effect)} --joint ${quoted(added.joint)}${form(added)}${option} --output ${next}`);
    model = next;
  });
  if (learned && !["confirm", "search"].some(of)) {
    found.push("# The page compares with the parts of each motion that the model has not learned from; this with all of it.");
  }
  const unseen = ["confirm", "search", "learn"].find((role) => of(role)) || "learn";
  const [first] = cards(unseen);
  found.push(`lagrangian_ff compare ${model} ${of(unseen)}${first ? scaled(before, first.scale) : ""}${option} --report compare.html`);
  return found.join("\n");
}

export function view(state) {
  const node = current(state);
  if (!node) {
    return [head("Take away", "The model, for the nodes and the command line."), h("div", { class: "empty" }, h("h3", {}, "No model yet"), "Learn one first.")];
  }
  const parameters = `/**:\n  ros__parameters:\n    model_file: /path/of/model_${node.id}.npz\n    joints: [${node.described.joints.join(", ")}]` +
    (formulas(state).length ? `\n    effects_file: /path/of/${FORMULAS}` : "");
  return [
    head("Take away", `${node.described.name}: ${node.title}`, h("a", { class: "main", href: `api/take/${node.id}`, download: `model_${node.id}.npz` }, "Save the model"),
      node.compared ? h("a", { class: "plain", href: `api/page/compare/${node.id}`, download: "compare.html" }, "Page of the comparison") : null,
      node.diagnosed ? h("a", { class: "plain", href: `api/page/diagnose/${node.id}`, download: "diagnose.html" }, "Page of the diagnosis") : null),
    h("section", { class: "card" }, h("h3", {}, "Parameters of feedforward"), h("pre", { tabindex: "0" }, parameters), download(parameters, "feedforward.yaml", "Save as YAML")),
    state.formulas.length ? h("section", { class: "card" }, h("h3", {}, "Formulas, for --effects-file"), h("pre", { tabindex: "0" }, file(state.formulas)),
      download(file(state.formulas) + "\n", FORMULAS, "Save the formulas")) : null,
    h("section", { class: "card" }, h("h3", {}, "The same in a shell"), h("pre", { tabindex: "0" }, commands(state)), download(commands(state) + "\n", "commands.sh", "Save as a script")),
  ].filter(Boolean);
}

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
  return /^[\w./+-]+$/.test(text) ? text : `'${text.replaceAll("'", "'\\''")}'`;
}

function commands(state) {
  const of = (role) => state.cards.filter((card) => card.role === role && !card.error).map((card) => quoted(card.file)).join(" ");
  const steps = line(state);
  const found = [`lagrangian_ff identify ${of("learn")} --train 1.0 --output model.npz`];
  let model = "model.npz";
  steps.slice(1).forEach((node, k) => {
    const added = node.described.effects.at(-1);
    const [, effect, joint] = node.title.match(/^\+ (.*) on (.*)$/) || [null, added.effect, added.joint];
    const next = `model_${k + 1}.npz`;
    found.push(`lagrangian_ff add ${model} ${effect.replaceAll(" ", "_")} --joint ${joint} --output ${next}`);
    model = next;
  });
  const unseen = of("confirm") || of("search") || of("learn");
  found.push(`lagrangian_ff compare ${model} ${unseen} --report compare.html`);
  return found.join("\n");
}

export function view(state) {
  const node = current(state);
  if (!node) {
    return [head("Take away", "The model, for the nodes and the command line."), h("div", { class: "empty" }, h("h3", {}, "No model yet"), "Learn one first.")];
  }
  const parameters = `/**:\n  ros__parameters:\n    model_file: /path/of/model_${node.id}.npz\n    joints: [${node.described.joints.join(", ")}]`;
  return [
    head("Take away", `${node.described.name}: ${node.title}`, h("a", { class: "main", href: `api/take/${node.id}`, download: `model_${node.id}.npz` }, "Save the model"),
      node.compared ? h("a", { class: "plain", href: `api/page/compare/${node.id}`, download: "compare.html" }, "Page of the comparison") : null,
      node.diagnosed ? h("a", { class: "plain", href: `api/page/diagnose/${node.id}`, download: "diagnose.html" }, "Page of the diagnosis") : null),
    h("section", { class: "card" }, h("h3", {}, "Parameters of feedforward"), h("pre", { tabindex: "0" }, parameters), download(parameters, "feedforward.yaml", "Save as YAML")),
    h("section", { class: "card" }, h("h3", {}, "The same in a shell"), h("pre", { tabindex: "0" }, commands(state)), download(commands(state) + "\n", "commands.sh", "Save as a script")),
  ];
}

// The controls, and what follows from them: pictures and the comparison of all solvers.

import { code, h } from "./dom.js";
import { legend, picture } from "./picture.js";
import { openPoint, recordColumns, settingsNote } from "./point.js";
import { dataTable } from "./table.js";
import { factorText, standing } from "./words.js";

const option = (value, text) => h("option", { value }, text);

function labelled(text, control) {
  return h("label", { class: "control" }, h("span", null, text), control);
}

function errorSlider(page) {
  const { report, state } = page;
  const output = h("output");
  const slider = h("input", { type: "range", min: 0, max: report.errors.length - 1, step: 1, id: "error",
    oninput: () => state.change({ error: Number(slider.value) }) });
  state.follow(() => {
    slider.value = String(state.error);
    const text = state.errorText || "as the verdict asks (1e-4)";
    output.textContent = text;
    slider.setAttribute("aria-valuetext", text);
  });
  return labelled(["Error at most ", output], slider);
}

function contactsSelect(page) {
  const { report, state } = page;
  const select = h("select", { id: "contacts" }, option("all", "all contacts"),
    report.situations.map(({ title, sets }, i) => sets.length > 0 && option(String(i), title)),
    option("own", "a choice of sets …"),
    state.scenes.size > 0 && h("optgroup", { label: "One scene" },
      [...state.scenes.keys()].map((name) => option(`scene ${name}`, name))));
  select.addEventListener("change", () => {
    const scene = state.scenes.get(select.value.replace(/^scene /, ""));
    if (scene) return state.change({ at: "own", sets: scene });
    const own = select.value === "own";
    if (own && !state.sets.length) state.sets = report.situations.find(({ sets }) => sets.length)?.sets.slice() ?? [];
    state.change({ at: own || select.value === "all" ? select.value : Number(select.value) });
  });
  state.follow(() => {
    select.value = state.at === "own" && state.scene() ? `scene ${state.scene()}` : String(state.at);
  });
  return labelled("Contacts", select);
}

function referenceSelect(page) {
  const { report, state } = page;
  const choose = () => state.change({ reference: select.value === "" ? null : Number(select.value) });
  const select = h("select", { id: "over", onchange: choose }, option("", "the recommended solver"),
    report.solvers.map(({ label }, i) => option(String(i), label)));
  state.follow(() => (select.value = state.reference === null ? "" : String(state.reference)));
  return labelled("Factors over", select);
}

/**
 * A fold of checkboxes in groups, with a filter.
 * @param noun     of what is chosen, and the fold's id
 * @param entries  [{name, group}]; chosen(i) says whether entry i is checked, change(indices) takes a new choice
 * @param title    () => the words on the fold
 */
function checkFold(state, noun, entries, title, chosen, change) {
  const tell = () => change([...boxes.keys()].filter((i) => boxes[i].box.checked));
  const boxes = entries.map(({ name, group }) => {
    const box = h("input", { type: "checkbox", onchange: tell });
    return { name, group, box, row: h("label", { class: "check" }, box, code(name)) };
  });
  const filter = h("input", { type: "search", placeholder: `Filter ${noun}`, "aria-label": `Filter ${noun}` });
  const visible = ({ name }) => name.toLowerCase().includes(filter.value.toLowerCase());
  filter.addEventListener("input", () => boxes.forEach((each) => (each.row.hidden = !visible(each))));
  const set = (value) => {
    for (const each of boxes) if (visible(each)) each.box.checked = value;
    tell();
  };
  const groups = boxes.reduce((map, each) => map.set(each.group, [...(map.get(each.group) ?? []), each]), new Map());
  const summary = h("summary");
  state.follow(() => {
    summary.textContent = title();
    boxes.forEach(({ box }, i) => (box.checked = chosen(i)));
  });
  return h("details", { id: noun }, summary, h("div", { class: "checks" },
    h("div", { class: "toolbar" }, filter, h("button", { type: "button", onclick: () => set(true) }, "All"),
      h("button", { type: "button", onclick: () => set(false) }, "None")),
    [...groups].map(([group, members]) => h("fieldset", null, h("legend", null, group),
      members.map(({ row }) => row)))));
}

function setsFold({ report, state }) {
  const entries = report.sets.map(({ name }) => ({ name, group: name.replace(/[/:{].*$/, "") }));
  const details = checkFold(state, "sets", entries, () => `Sets: ${state.sets.length} of ${entries.length}`,
    (i) => state.at === "own" && state.sets.includes(i), (sets) => state.change({ at: "own", sets }));
  state.follow(() => (details.hidden = state.at !== "own"));
  return details;
}

function solversFold({ report, state }) {
  const entries = report.solvers.map(({ label, library }) =>
    ({ name: label, group: library === "native" ? "lcpbench" : library }));
  return checkFold(state, "solvers", entries,
    () => `Solvers: ${state.solvers ? `${state.solvers.size} of` : "all"} ${entries.length}`,
    (i) => !state.solvers || state.solvers.has(i),
    (solvers) => state.change({ solvers: solvers.length === entries.length ? null : new Set(solvers) }));
}

export function controls(page) {
  const { state } = page;
  const start = { error: 0, at: "all", sets: [], solvers: null, reference: null, y: "share" };
  const reset = h("button", { type: "button", onclick: () => state.change(start) }, "Reset");
  return h("form", { class: "controls", "aria-label": "Ask", onsubmit: (event) => event.preventDefault() },
    errorSlider(page), contactsSelect(page), referenceSelect(page), reset, setsFold(page), solversFold(page));
}

/** All solvers on one selection. */
function contenders(page, view, choice) {
  const { report, state, statistics } = page;
  const over = state.reference ?? choice.recommended?.solver ?? null;
  const factor = new Map(choice.records.map((record) => [record,
    over === null || over === record.solver ? null : statistics.factor(view.sets, state.error, over, record.solver)]));
  const columns = [
    { name: "solver", title: "Solver", value: ({ solver }) => report.solvers[solver].label, show: (record) => [
      h("button", { type: "button", class: "link", onclick: () => openPoint(page, view.title, choice, record) },
        code(report.solvers[record.solver].label)), settingsNote(report.solvers[record.solver])] },
    { name: "standing", title: "Standing", value: (record) => standing(record, choice) },
    ...recordColumns(report.rule.least_problems),
    { name: "factor", title: over === null ? "Factor" : `Over ${report.solvers[over].label}`, number: true,
      value: (record) => (factor.get(record)?.shown ? factor.get(record).value : null),
      show: (record) => (factor.get(record) ? factorText(factor.get(record)) : "–") },
  ];
  const { records } = choice;
  return [h("h3", null, `All solvers: ${view.title}`),
    dataTable(columns, records, { name: "solvers", caption: `All solvers: ${view.title}`, few: records.length < 60,
      rowClass: (record) => record === choice.recommended && "recommended" })];
}

/** The pictures and, for one selection, all its solvers. */
export function mountPictures(page, element) {
  const { state } = page;
  const radio = (value, text) => h("label", null,
    h("input", { type: "radio", name: "y", value, onchange: () => state.change({ y: value }) }), text);
  const axis = h("div", { class: "axis", role: "radiogroup", "aria-label": "Upwards" }, "Upwards",
    radio("share", "share solved"), radio("error", "error of 99 % of the answers"));
  const pictures = h("div", { class: "pictures" });
  const rest = h("div");
  element.append(axis, pictures, legend(), rest);
  return (choices) => {
    for (const input of axis.querySelectorAll("input")) input.checked = input.value === state.y;
    const alone = choices.length === 1;
    pictures.replaceChildren(...choices.map(([view, choice]) => picture(page, view, choice, alone)));
    rest.replaceChildren(...(alone ? contenders(page, ...choices[0]) : []));
  };
}

// The controls, and what follows from them: pictures and the comparison of all solvers.

import { code, h, small } from "./dom.js";
import { forms, legend, picture } from "./picture.js";
import { libraryOf, openPoint, origin, ours, recordColumns } from "./point.js";
import { dataTable } from "./table.js";
import { factorText, standing } from "./words.js";

const option = (value, text) => h("option", { value }, text);

function labelled(text, control) {
  return h("label", { class: "control" }, h("span", null, text), control);
}

/** From 1e-1 down; until it is moved it stands at the verdict's 1e-4. */
function errorSlider(page) {
  const { report, state } = page;
  const output = h("output");
  const verdict = report.errors.indexOf(1e-4);
  let moving = false;
  const slider = h("input", { type: "range", min: 1, max: report.errors.length - 1, step: 1, id: "error",
    oninput: () => (state.change({ error: Number(slider.value) }, moving), (moving = true)),
    onchange: () => (moving = false) });
  state.follow(() => {
    slider.value = String(state.error || verdict);
    const text = state.errorText || "1e-4, as the verdict asks";
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

/** A checkbox a library, and a button that leaves our own solvers out. */
function libraries({ report, state }) {
  const names = [...new Set(report.solvers.map(libraryOf))].sort();
  if (names.length < 2) return null;
  const all = [...report.solvers.keys()];
  const isChosen = (i) => !state.solvers || state.solvers.has(i);
  const choose = (chosen) => {
    const solvers = all.filter(chosen);
    state.change({ solvers: solvers.length === all.length ? null : new Set(solvers) });
  };
  const boxes = names.map((name) => {
    const isOurs = (i) => libraryOf(report.solvers[i]) === name;
    const box = h("input", { type: "checkbox", onchange: () => choose((i) => (isOurs(i) ? box.checked : isChosen(i))) });
    state.follow(() => {
      const count = all.filter((i) => isOurs(i) && isChosen(i)).length;
      box.checked = count > 0;
      box.indeterminate = count > 0 && count < all.filter(isOurs).length;
    });
    return h("label", { class: "check" }, box, name);
  });
  return h("fieldset", { class: "libraries" }, h("legend", { class: "offscreen" }, "Libraries"), boxes,
    h("button", { type: "button", onclick: () => choose((i) => libraryOf(report.solvers[i]) !== ours) },
      "Only other libraries"));
}

function solversFold({ report, state }) {
  const entries = report.solvers.map((solver) => ({ name: solver.label, group: libraryOf(solver) }));
  return checkFold(state, "solvers", entries,
    () => `Solvers: ${state.solvers ? `${state.solvers.size} of` : "all"} ${entries.length}`,
    (i) => !state.solvers || state.solvers.has(i),
    (solvers) => state.change({ solvers: solvers.length === entries.length ? null : new Set(solvers) }));
}

export function controls(page) {
  const { state } = page;
  const start = { error: 0, at: "all", sets: [], solvers: null, reference: null, y: "error" };
  const reset = h("button", { type: "button", onclick: () => state.change(start) }, "Reset");
  return h("form", { class: "controls", "aria-label": "Ask", onsubmit: (event) => event.preventDefault() },
    errorSlider(page), contactsSelect(page), referenceSelect(page), reset, libraries(page), setsFold(page),
    solversFold(page));
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
        code(report.solvers[record.solver].label)), small(origin(report.solvers[record.solver]))] },
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
  const axis = h("div", { class: "axis", role: "radiogroup", "aria-label": "Picture" },
    Object.entries(forms).map(([y, [words]]) => h("label", null,
      h("input", { type: "radio", name: "y", value: y, onchange: () => state.change({ y }) }), words)));
  const pictures = h("div", { class: "pictures" });
  const rest = h("div");
  const words = h("div");
  element.append(axis, pictures, words, rest);
  return (choices) => {
    for (const input of axis.querySelectorAll("input")) input.checked = input.value === state.y;
    const alone = choices.length === 1;
    words.replaceChildren(legend(state.y));
    pictures.replaceChildren(...choices.map(([view, choice]) => picture(page, view, choice, alone)));
    rest.replaceChildren(...(alone ? contenders(page, ...choices[0]) : []));
  };
}

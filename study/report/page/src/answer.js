// The first screen: whom to use for what, who said solved and was wrong, and how much of the plan is there.

import { wilson } from "./choice.js";
import { code, fold, h, small } from "./dom.js";
import { count, counted, duration, durationRange, list, percent, percentRange, scientific, share } from "./format.js";
import { openPoint } from "./point.js";
import { dataTable, queryFold, records, tableOf } from "./table.js";
import { areScenes, factorText, withheld } from "./words.js";

/** "a robot's step", "random frictionless contacts" */
function inASentence(report, view) {
  const lower = view.title.charAt(0).toLowerCase() + view.title.slice(1);
  if (!report.situations.includes(view)) return view.title === "Your selection" ? lower : `the scene ${view.title}`;
  if (areScenes(report, view)) return lower;
  return `random ${lower} contacts`;
}

/** "Use auto for piles and other scenes, and contact_lemke for a robot's step." */
function sentence(page, choices) {
  const { report, state } = page;
  const uses = new Map();  // the contacts that each solver is recommended for; undefined: no solver
  for (const [view, { recommended }] of choices) {
    uses.set(recommended?.solver, [...(uses.get(recommended?.solver) ?? []), inASentence(report, view)]);
  }
  const nobody = uses.get(undefined);
  uses.delete(undefined);
  const use = state.errorText ? `For an error of at most ${state.errorText}, use ` : "Use ";
  const before = (i) => (i === 0 ? use : i === uses.size - 1 ? "; and " : "; ");
  const parts = [...uses].flatMap(([solver, contacts], i) =>
    [before(i), code(report.solvers[solver].label), ` for ${list(contacts)}`]);
  if (uses.size) parts.push(". ");
  if (nobody) {
    const at = state.errorText && !uses.size ? ` at an error of at most ${state.errorText}` : "";
    parts.push(`No solver is recommended for ${list(nobody)}${at}.`);
  }
  if (!choices.length) parts.push("The store holds no problems that a recommendation could rest on.");
  return parts;
}

/** Of a scene of its own, or of chosen sets: what is recommended for the contacts that they are a part of. */
function wholeText({ report, state, statistics }, view) {
  const whole = view.sets.length > 0 && !report.situations.includes(view) &&
    report.situations.find(({ sets }) => view.sets.every((set) => sets.includes(set)));
  const best = whole && statistics.choose(whole.sets, state.solvers, state.error).recommended;
  return best ? ` They are a part of "${whole.title}", for which ${report.solvers[best.solver].label} is recommended.` : "";
}

function decisionRow(page, view, choice) {
  const { report, state, statistics } = page;
  const { least_problems: least } = report.rule;
  const names = [...new Set(view.sets.map((set) => report.sets[set].family || report.sets[set].name))];
  const problems = view.sets.reduce((sum, set) => sum + report.sets[set].problems, 0);
  const few = names.length > 3 ? `${names.slice(0, 2).join(", ")} and ${names.length - 2} more` : names.join(", ");
  const first = h("th", { scope: "row", role: "rowheader" }, view.title,
    small(`${counted(problems, "problem")}: `, few));
  const cell = (label, ...content) => h("td", { role: "cell", "data-label": label }, h("div", null, content));
  const others = h("button", { type: "button", class: "link",
    "aria-label": `Compare all ${choice.records.length} solvers: ${view.title}`,
    onclick: () => page.showAll(view) }, `Compare all ${choice.records.length}`);
  const best = choice.recommended;
  if (!best) {
    const asReported = state.error === 0 && !state.solvers && view.withheld;
    const why = asReported || withheld(choice, report.rule, report.solvers);
    const nobody = h("td", { role: "cell", colspan: 5, "data-label": "Use" },
      h("div", null, "nobody yet", small(`${why}.${wholeText(page, view)}`)));
    return h("tr", { role: "row" }, first, nobody, cell("Others", others));
  }
  const ties = choice.records.filter(({ tie }) => tie).map(({ solver }) => report.solvers[solver].label);
  const over = state.reference;
  const speed = over !== null && over !== best.solver &&
    small(factorText(statistics.factor(view.sets, state.error, over, best.solver)), ", against ",
      code(report.solvers[over].label));
  const open = () => openPoint(page, view.title, choice, best);
  return h("tr", { role: "row" }, first,
    cell("Use", h("button", { type: "button", class: "link solver", onclick: open },
      code(report.solvers[best.solver].label)),
      ties.length > 0 && small("a tie with ", ties.flatMap((spec, i) => [i ? ", " : "", code(spec)]))),
    cell("Time per problem", duration(best.time.value), small(durationRange(best.time)), speed),
    cell("Solved", share(best.solved, best.of, least), small(percentRange(best.interval))),
    cell("Relative error, 99 %", scientific(best.p99)),
    cell("Said solved, was wrong", share(best.false, best.taken, least) || "0",
      small(percentRange(wilson(best.false, best.taken)))),
    cell("Others", others));
}

function decisionTable(page, choices) {
  const heads = ["Contacts", "Use", "Time per problem", "Solved", "Relative error, 99 %", "Said solved, was wrong", "Others"];
  return h("table", { class: "decision cards", role: "table" },
    h("caption", { class: "offscreen" }, "Whom to use for what"),
    h("thead", { role: "rowgroup" }, h("tr", { role: "row" },
      heads.map((text) => h("th", { scope: "col", role: "columnheader" }, text)))),
    h("tbody", { role: "rowgroup" }, choices.map(([view, choice]) => decisionRow(page, view, choice))));
}

/** Who said solved and was wrong, on whatever set. */
function caught(page) {
  const { report, state } = page;
  const { least_problems: least } = report.rule;
  const rows = records(report, "caught");
  if (!rows.length) return h("p", null, "No solver at single settings was seen to say solved and be wrong.");
  const open = (solver) => {
    const choice = page.statistics.choose([...report.sets.keys()], null, 0);
    openPoint(page, "All sets", choice, choice.records.find((each) => each.solver === state.solverIndex.get(solver)));
  };
  const columns = [
    { name: "solver", title: "Solver", value: ({ solver }) => solver, show: ({ solver }) =>
      h("button", { type: "button", class: "link", onclick: () => open(solver) }, code(solver)) },
    { name: "false_claims", title: "Said solved, was wrong", number: true, value: (row) => row.false_claims },
    { name: "of", title: "Of problems", number: true, value: (row) => row.of },
    { name: "share", title: "Share", number: true, value: (row) => row.share,
      show: (row) => share(row.false_claims, row.of, least) },
    { name: "interval", title: "95 % interval", number: true, value: (row) => row.share_low,
      show: (row) => percentRange({ low: row.share_low, high: row.share_high }) },
  ];
  return fold([h("strong", { class: "warn" }, counted(rows.length, "solver")), " said solved and ",
    rows.length === 1 ? "was" : "were", " wrong on some problem of the store"],
    () => [h("p", { class: "note" },
      "A simulation that uses such an answer gets a wrong impulse and no warning. Choose a solver to see its failures."),
      dataTable(columns, rows, { name: "caught", caption: "Said solved, was wrong", few: true,
        sql: tableOf(report, "caught").sql })], { id: "caught" });
}

function planText(plan) {
  if (plan.share === null) return "The store does not say how much was planned.";
  if (plan.share >= 1) return `All ${counted(plan.cells_planned, "planned answer")} are there.`;
  const done = `${count(plan.cells_done)} of ${count(plan.cells_planned)} planned answers`;
  return `${percent(plan.share)} of the plan is there: ${done}.`;
}

/** Fills the first screen; the sentence and the table follow the choice. */
export function mountAnswer(page, { text, table, below }) {
  const { report } = page;
  below.append(caught(page), ...report.notes.map((note) => h("p", { class: "note" }, note)),
    h("p", { class: "note plan" }, planText(report.plan)), queryFold(tableOf(report, "decision").sql));
  return (choices) => {
    text.replaceChildren(h("span", null, sentence(page, choices)));
    table.replaceChildren(decisionTable(page, choices));
  };
}

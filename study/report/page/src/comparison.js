// Two stores: what became better, what worse, and is it noise?

import { code, fold, h } from "./dom.js";
import { count, counted, factor } from "./format.js";
import { intervals } from "./picture.js";
import { dataTable } from "./table.js";

/** Three digits: an end of an interval that is not 1 is not shown as 1. */
const ratio = (value) => (value === null ? "–" : String(Number(value.toPrecision(3))));
const change = (a, b) => (a === b ? count(a) : `${count(a)} → ${count(b)}`);

function ratioPicture(cells, width) {
  const timed = cells.filter(({ time }) => time.low !== null && time.high !== null).slice(0, 60);
  if (!timed.length) return null;
  const colour = (cell) => ({ worse: "var(--bad)", better: "var(--best)" })[cell.time.b_is] ?? "var(--quiet)";
  const rows = timed.map((cell) => ({ label: cell.set ? `${cell.set}  ${cell.solver}` : cell.solver, at: cell.time.ratio,
    low: cell.time.low, high: cell.time.high, colour: colour(cell), weight: cell.time.problems }));
  return h("figure", { class: "picture large" },
    h("figcaption", null, h("strong", null, "Time of B over A"), " with 95 % intervals; left of 1 is faster; area: number of problems"),
    intervals(rows, "Time of B over A; the table above has the same numbers",
      { width, ticks: 5, tickFormat: factor, rule: 1 }));
}

export function comparisonSections(report) {
  const { comparison } = report;
  const moved = ({ solved }) => solved.only_a + solved.only_b;
  const byGravity = (rows) => [...rows].sort((a, b) => a.gravity - b.gravity || moved(b) - moved(a));
  const cells = byGravity(comparison.cells);
  const solvers = byGravity(comparison.solvers);
  const told = cells.filter(({ change }) => change !== "tie");
  const columns = [
    { name: "solver", title: "Solver", value: (cell) => cell.solver, show: (cell) => code(cell.solver) },
    { name: "change", title: "B is", value: ({ change, solved }) => (change !== "tie" || !solved.too_few ? change
      : `${solved.only_a > solved.only_b ? "fewer, but " : solved.only_b > solved.only_a ? "more, but " : ""}too few for a test`) },
    { name: "solved", title: "Solved", number: true, value: (cell) => cell.solved.b - cell.solved.a,
      show: (cell) => change(cell.solved.a, cell.solved.b) },
    { name: "time_ratio", title: "Time B/A", number: true, value: (cell) => cell.time.ratio,
      show: (cell) => [ratio(cell.time.ratio), cell.time.low !== null
        && h("small", null, `${ratio(cell.time.low)}–${ratio(cell.time.high)}, ${cell.time.faster} of ${cell.time.problems} faster`)] },
    { name: "lost", title: "Lost", number: true, value: (cell) => cell.solved.only_a },
    { name: "gained", title: "Gained", number: true, value: (cell) => cell.solved.only_b },
    { name: "p", title: "p of solved, corrected", number: true, value: (cell) => cell.solved.p_holm,
      show: (cell) => String(Number(cell.solved.p_holm.toPrecision(2))) },
    { name: "false_claims", title: "Wrong", number: true, value: (cell) => cell.false_claims.b - cell.false_claims.a,
      show: (cell) => change(cell.false_claims.a, cell.false_claims.b) },
    { name: "problems", title: "Problems", number: true, value: (cell) => cell.problems },
  ];
  const width = Math.min(1100, document.documentElement.clientWidth - 48);
  const setColumn = { name: "set", title: "Set", value: (cell) => cell.set, show: (cell) => code(cell.set) };
  const only = (names, store) => names?.length > 0 &&
    fold(`${counted(names.length, "cell")} only in ${store}`, () => h("p", { class: "note" }, `${names.join("; ")}.`));
  return [
    h("h1", null, "Did the change make it better?"),
    h("p", { class: "sentence" }, comparison.conclusion),
    h("p", null, "A is ", code(comparison.a.store), ", B is ", code(comparison.b.store), ". A cell is one solver on one set. ",
      "Where A and B differ, numbers stand as A → B. The column Wrong is the number of answers that the solver said are solved and ",
      "that are not. Time B/A is the geometric mean of the ratios of times on the problems that both solved; below 1, B is faster."),
    h("p", null, comparison.summary),
    h("p", null, `A change counts where its test, corrected for the number of rows, has p below ${comparison.significance}. ` +
      "A time counts under three conditions: the ratio is more than 5 % from 1, its interval does not contain 1, and chance does not " +
      "explain how many problems are faster and how many slower (sign test). All else may be noise."),
    solvers.length > 0 && h("section", { id: "solvers" }, h("h2", null, "Each solver over all sets"),
      dataTable(columns, solvers, { name: "solvers", caption: "Each solver over all sets" }),
      ratioPicture(solvers, width)),
    h("section", { id: "changes" }, h("h2", null, "Set by set"),
      !told.length && h("p", null, "No single set alone shows a change beyond noise."),
      h("p", null, "The most serious changes stand first."),
      dataTable([setColumn, ...columns], cells, { name: "comparison", caption: "Set by set" }),
      ratioPicture(told, width), only(comparison.only_in_a, "A"), only(comparison.only_in_b, "B")),
  ];
}

// The picture of the three errors of soft contacts: one panel a set, from the rows of the table model_errors.

import * as Plot from "@observablehq/plot";
import { h } from "./dom.js";
import { describe } from "./picture.js";
import { records, tableOf } from "./table.js";

const [lowest, highest] = [1e-17, 100];  // m/s
const cost = 1e-3;
const ticks = [1e-15, 1e-11, 1e-7, 1e-3];

/** The set's rows: its own two errors, then that of each solver on its own model. */
function linesOf(steps) {
  const [set] = steps;
  const line = (label, kind, median, largest) => ({ label, kind, median, largest });
  return [
    line("softness", "set", set.softness_median_m_per_s, set.softness_max_m_per_s),
    line("relaxation", "set", set.relaxation_median_m_per_s, set.relaxation_max_m_per_s),
    ...steps.map((row) => line(row.solver, "solver", row.solver_median_m_per_s, row.solver_max_m_per_s)),
  ].filter(({ median }) => median !== null).map((each) => ({ ...each, median: Math.max(lowest, each.median),
    largest: Math.min(Math.max(lowest, each.largest ?? highest), highest) }));
}

function panel(set, steps, width) {
  const lines = linesOf(steps);
  const left = width * 0.42;
  const colour = ({ kind }) => (kind === "set" ? "var(--bad)" : "var(--best)");
  return h("figure", { class: "picture" },
    h("figcaption", null, h("strong", null, set), ` ${Math.max(...steps.map((row) => row.steps))} steps`),
    describe(Plot.plot({
      width, height: 50 + 20 * lines.length, marginLeft: left, marginRight: 16,
      style: { background: "transparent", fontSize: "12px", fontFamily: "inherit" },
      x: { type: "log", domain: [lowest, highest], axis: null },
      y: { label: null, domain: lines.map(({ label }) => label), tickSize: 0,
        tickFormat: (text) => (text.length * 7 > left ? `${text.slice(0, Math.floor(left / 7.4))}…` : text) },
      marks: [Plot.gridX(ticks),
        Plot.axisX(ticks, { anchor: "top", tickSize: 0, label: null,
          tickFormat: (error) => `${error.toExponential(0).replace("e+0", "")} m/s` }),
        Plot.ruleX([cost], { stroke: "var(--ink)", strokeDasharray: "3 3" }),
        Plot.ruleY(lines, { y: "label", x1: "median", x2: "largest", stroke: colour }),
        Plot.dot(lines, { y: "label", x: "median", fill: colour, r: 4 })],
    }), `Errors of ${set}; the table of the three errors has the same numbers`));
}

/** Null where the store has no soft contacts with their hard version. */
export function errorSection(report, width) {
  if (!tableOf(report, "model_errors")?.rows?.length) return null;
  const rows = records(report, "model_errors");
  const sets = [...new Set(rows.map(({ set }) => set))];
  return h("section", { id: "errors" }, h("h2", null, "Three errors of soft contacts"),
    h("p", null, "The dot is the median over the steps, the line goes on to the largest. Red: what softness and the relaxation of",
      " friction change. Blue: how far each solver is from the solution of its own model. The dashed line is 1 mm/s."),
    h("div", { class: "pictures" }, sets.map((set) => panel(set, rows.filter((row) => row.set === set),
      width < 760 ? width : (width - 24) / 2))));
}

// The picture of the three errors of soft contacts: one panel a set, from the rows of the table model_errors.

import { h } from "./dom.js";
import { intervals } from "./picture.js";
import { records, tableOf } from "./table.js";

const [least, largest] = [1e-17, 100];  // m/s, of the axis
const within = (error) => Math.min(Math.max(least, error ?? largest), largest);

/** The set's own two errors, then that of each solver on its own model. */
function rowsOf(steps) {
  const row = (label, colour, median, most) => median !== null
    && { label, colour, weight: 1, at: within(median), low: within(median), high: within(most) };
  return [row("softness", "var(--bad)", steps[0].softness_median_m_per_s, steps[0].softness_max_m_per_s),
    row("relaxation", "var(--bad)", steps[0].relaxation_median_m_per_s, steps[0].relaxation_max_m_per_s),
    ...steps.map((each) => row(each.solver, "var(--best)", each.solver_median_m_per_s, each.solver_max_m_per_s)),
  ].filter(Boolean);
}

/** Null where the store has no soft contacts with their hard version. */
export function errorSection(report, width) {
  if (!tableOf(report, "model_errors")?.rows?.length) return null;
  const all = records(report, "model_errors");
  const panel = (set) => {
    const steps = all.filter((row) => row.set === set);
    return h("figure", { class: "picture" },
      h("figcaption", null, h("strong", null, set), ` ${Math.max(...steps.map((row) => row.steps))} steps`),
      intervals(rowsOf(steps), `Errors of ${set}; the table of the three errors has the same numbers`, {
        width: width < 760 ? width : (width - 24) / 2, domain: [least, largest], ticks: [1e-15, 1e-11, 1e-7, 1e-3],
        tickFormat: (error) => error.toExponential(0), rule: 1e-3 }));
  };
  return h("section", { id: "errors" }, h("h2", null, "Three errors of soft contacts"),
    h("p", null, "In m/s: the dot is the median over the steps, the line goes on to the largest. Red: what softness and the relaxation",
      " of friction change. Blue: how far each solver is from the solution of its own model. The vertical line stands at 1 mm/s."),
    h("div", { class: "pictures" }, [...new Set(all.map(({ set }) => set))].map(panel)));
}

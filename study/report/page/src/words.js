// What the rule found, in words.

import { counted, percent, percentRange, share, speed, threeDigits } from "./format.js";

/** Each ground of choice.js: the group that it belongs to, and why. */
const grounds = {
  reliable: ["reliable", "reliable"],
  false_claims: ["unreliable", "said solved and was wrong"],
  unsolved: ["unreliable", "leaves too many unsolved"],
  behind_the_best: ["unreliable", "solves fewer than the best"],
  few_problems: ["unknown", "too few problems to say"],
  small_sample: ["unknown", "too few problems to say: less than half of what another solver took"],
  short_of_plan: ["unknown", "too few to say: less than half of the plan is done"],
  wide_interval: ["unknown", "too few problems to say: the interval is too wide"],
  other_model: ["partly", "solves the round cone, another problem"],
  no_time: ["partly", "nobody measured its time"],
  some_sets: ["partly", "took problems of only some of these sets"],
  refuses: ["partly", "refuses too many of these problems"],
};

export const groupOf = (record) => grounds[record.ground][0];

/** Whether a selection is of captured steps. */
export const areScenes = (report, { sets }) =>
  ["robots", "stacks", "piles", "scenes"].includes(report.sets[sets[0]]?.kind);

/** Why a solver is, or is not, the one to use. */
export function standing(record, choice) {
  if (record === choice.recommended) return "recommended";
  if (record.tie) return "reliable, and a tie in time";
  if (record.ground === "reliable" && record.refused) return "reliable on what it takes";
  return grounds[record.ground][1];
}

/** "3.10× slower (2.70–3.50, n = 240)"; without enough problems their number. */
export function factorText(factor) {
  if (!factor.shown) return `no factor (n = ${factor.n})`;
  const inverted = factor.value < 1;
  const low = inverted ? 1 / factor.high : factor.low;
  const high = inverted ? 1 / factor.low : factor.high;
  return `${speed(factor.value)} (${threeDigits(low)}–${threeDigits(high)}, n = ${factor.n})`;
}

/** Why no solver is recommended. */
export function withheld(choice, rule, solvers) {
  const { most } = choice;
  if (!choice.records.length) return "no chosen solver took these problems";
  if (most < rule.least_problems) return `${counted(most, "problem")}; it takes ${rule.least_problems} to say`;
  if (choice.plan < rule.plan_at_least && most < rule.ample_problems) {
    return `${percent(choice.plan)} of the plan is done; it takes ${percent(rule.plan_at_least)}`;
  }
  const best = choice.best ?? choice.records.reduce((a, b) => (b.interval.low > a.interval.low ? b : a));
  return `no solver is shown to be reliable here; the best, ${solvers[best.solver].label}, solved ` +
    `${share(best.solved, best.of, rule.least_problems)} (${percentRange(best.interval)})`;
}

// What the rule found, in words.

import { counted, duration, durationRange, percent, percentRange, share, speed, threeDigits } from "./format.js";

export const groups = {
  reliable: "reliable",
  false_claims: "unreliable", unsolved: "unreliable", behind_the_best: "unreliable",
  other_model: "partly", some_sets: "partly", refuses: "partly", no_time: "partly",
  few_problems: "unknown", small_sample: "unknown", short_of_plan: "unknown", wide_interval: "unknown",
};

/** Whether a selection is of captured steps. */
export const areScenes = (report, { sets }) =>
  ["robots", "stacks", "piles", "scenes"].includes(report.sets[sets[0]]?.kind);

const reasons = {
  reliable: "reliable",
  false_claims: "said solved and was wrong",
  unsolved: "leaves too many unsolved",
  behind_the_best: "solves fewer than the best",
  few_problems: "too few problems to say",
  small_sample: "too few problems to say: less than half of what another solver took",
  short_of_plan: "too few to say: less than half of the plan is done",
  wide_interval: "too few problems to say: the interval is too wide",
  other_model: "solves the round cone, another problem",
  no_time: "nobody measured its time",
  some_sets: "met only some of these sets",
  refuses: "refuses too many of these problems",
};

/** Why a solver is, or is not, the one to use. */
export function standing(record, choice) {
  if (record === choice.recommended) return "recommended";
  if (record.tie) return "reliable, and a tie in time";
  if (record.ground === "reliable" && record.refused) return "reliable on what it takes";
  return reasons[record.ground];
}

/** "45 of 45 solved (92.1–100 %)" */
export const solvedText = (record, least) =>
  `${share(record.solved, record.of, least)} solved (${percentRange(record.interval)})`;

export const wrongText = ({ false: wrong, taken }, least) =>
  wrong ? `said solved and was wrong on ${share(wrong, taken, least)}`
    : `no false claim in ${counted(taken, "problem")}`;

export const timeText = ({ time }) => `${duration(time.value)} (${durationRange(time)}, n = ${time.n})`;

/** "3.10× slower (2.70–3.50, n = 240)"; without enough problems their number. */
export function factorText(factor) {
  if (!factor.shown) return `no factor: both solved ${factor.n}`;
  const inverted = factor.value < 1;
  const low = inverted ? 1 / factor.high : factor.low;
  const high = inverted ? 1 / factor.low : factor.high;
  return `${speed(factor.value)} (${threeDigits(low)}–${threeDigits(high)}, n = ${factor.n})`;
}

/** Why no solver is recommended. */
export function withheld(choice, rule, solvers) {
  const { most } = choice;
  if (!choice.records.length) return "no chosen solver met these problems";
  if (most < rule.least_problems) return `${counted(most, "problem")}; it takes ${rule.least_problems} to say`;
  if (choice.plan < rule.plan_at_least && most < rule.ample_problems) {
    return `${percent(choice.plan)} of the plan is done; it takes ${percent(rule.plan_at_least)}`;
  }
  const best = choice.best ?? choice.records.reduce((a, b) => (b.interval.low > a.interval.low ? b : a));
  return `no solver is shown to be reliable here; the best, ${solvers[best.solver].label}, solved ` +
    `${share(best.solved, best.of, rule.least_problems)} (${percentRange(best.interval)})`;
}

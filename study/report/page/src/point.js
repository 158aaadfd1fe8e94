// One dot: a short text where it is pointed at, and a dialog with everything behind it where it is opened.

import { code, copyButton, h, small } from "./dom.js";
import { count, counted, duration, durationRange, percentRange, scientific, share } from "./format.js";
import { dataTable, records } from "./table.js";
import { factorText, standing } from "./words.js";

const worstShown = 10;
export const ours = "lcpbench";

/** The library that a solver belongs to; ours is the program's own name. */
export const libraryOf = ({ library }) => (library === "native" ? ours : library);
export const origin = (solver) => [libraryOf(solver), solver.version].filter(Boolean).join(" ");

/** Where libraries are to be had: an address, and Debian's package. */
const homes = {
  Bullet: ["https://github.com/bulletphysics/bullet3", "libbullet-dev"], ODE: ["https://www.ode.org", "libode-dev"],
  Ipopt: ["https://github.com/coin-or/Ipopt", "coinor-libipopt-dev"], DART: ["https://dartsim.github.io", "libdart-dev"],
  "Siconos numerics": ["https://github.com/siconos/siconos", "libsiconos-numerics-dev"],
  Simbody: ["https://github.com/simbody/simbody", "libsimbody-dev"],
  SuiteSparse: ["https://github.com/DrTimothyAldenDavis/SuiteSparse", "libsuitesparse-dev"],
  PATH: ["https://pages.cs.wisc.edu/~ferris/path.html"],
};

/** What a solver is and where it is to be had, in one sentence. */
function whatItIs(solver) {
  const [address, debian] = homes[solver.library] ?? [];
  const link = address && h("a", { href: address, rel: "noreferrer" }, address.replace(/^https:\/\//, ""));
  const scholar = `https://scholar.google.com/scholar?q=${encodeURIComponent(solver.source)}`;
  const words = solver.summary || "a solver that this program does not know";
  return h("p", null, words.charAt(0).toUpperCase() + words.slice(1), ...(
    solver.library === "native" ? [`; it is a part of ${origin(solver)}, after `,
      h("a", { href: scholar, rel: "noreferrer" }, solver.source), "."]
      : link ? [`; it is a part of ${origin(solver)}, from `, link, debian && [", in Debian the package ", code(debian)], "."]
        : ["."]));
}

/** What a dot says: [[term, text], ...]. */
function pointFacts(page, choice, record) {
  const { least_problems: least } = page.report.rule;
  const { solved, of, interval, time, false: wrong, taken } = record;
  return [
    ["Is", standing(record, choice)],
    ["Solved", `${share(solved, of, least)} solved (${percentRange(interval)})`],
    ["Time", `${duration(time.value)} (${durationRange(time)}, n = ${time.n})`],
    ["Wrong", wrong ? `said solved and was wrong on ${share(wrong, taken, least)}`
      : `no false claim in ${counted(taken, "problem")}`],
    record.refused && ["Refused", `refused ${count(record.refused)} of ${count(record.met)}: not counted as failures`],
    record.gaveUp && ["Gave up", `gave up on ${count(record.gaveUp)}`],
    record.crashed && ["Crashed", `crashed on ${count(record.crashed)}`],
    !Number.isNaN(record.p99) && ["Error", `99 % of its answers on every set: error at most ${scientific(record.p99)}`],
  ].filter(Boolean);
}

/** The same as lines of plain text under the solver's name: for the tip and for screen readers. */
export const pointLines = (page, choice, record) =>
  [page.report.solvers[record.solver].label, ...pointFacts(page, choice, record).map(([, text]) => text)];

/** Columns of a table of records, see Statistics.pool(). */
export const recordColumns = (least) => [
  { name: "solved_share", title: "Solved", number: true, value: ({ solved, of }) => solved / of,
    show: (record) => [share(record.solved, record.of, least), small(percentRange(record.interval))] },
  { name: "false_claims", title: "Wrong", number: true, value: (record) => record.false,
    show: (record) => share(record.false, record.taken, least) },
  { name: "gave_up", title: "Gave up", number: true, value: ({ gaveUp }) => gaveUp,
    show: (record) => share(record.gaveUp, record.taken, least) },
  { name: "refused", title: "Refused", number: true, value: ({ refused }) => refused,
    show: ({ refused, met }) => refused ? `${count(refused)} of ${count(met)}` : "0" },
  { name: "time_s", title: "Time", number: true, value: ({ time }) => time.value,
    show: ({ time }) => duration(time.value) },
  { name: "error_p99", title: "Relative error, 99 %", number: true, value: ({ p99 }) => p99,
    show: ({ p99 }) => scientific(p99) },
];

export class Tip {
  constructor() {
    this.element = h("div", { class: "tip", "aria-hidden": "true", hidden: true });
    document.body.append(this.element);
    window.addEventListener("scroll", () => this.place(), { passive: true });
  }

  show(target, lines) {
    this.element.replaceChildren(h("strong", null, lines[0]), ...lines.slice(1).map((line) => h("div", null, line)));
    this.element.hidden = false;
    this.target = target;
    this.place();
  }

  place() {
    if (this.element.hidden) return;
    const at = this.target.getBoundingClientRect();
    const { offsetWidth: width, offsetHeight: height } = this.element;
    const left = Math.max(8, Math.min(at.x + at.width / 2 - width / 2,
      document.documentElement.clientWidth - width - 8));
    const above = at.y - height - 8;
    this.element.style.left = `${left}px`;
    this.element.style.top = `${above > 8 ? above : at.bottom + 8}px`;
  }

  hide() {
    this.element.hidden = true;
  }
}

/** The problems behind a solver's failures, the gravest first, each with its command. */
function worstList(page, solver, sets) {
  const wanted = new Set(sets.map((set) => page.report.sets[set].name));
  const { label } = page.report.solvers[solver];
  const worst = records(page.report, "worst").filter((entry) => entry.solver === label && wanted.has(entry.set))
    .sort((a, b) => (a.verdict !== "wrong") - (b.verdict !== "wrong") || (b.error ?? Infinity) - (a.error ?? Infinity));
  if (!worst.length) return [h("p", null, "By its verdicts it failed on none of these problems.")];
  return [
    h("p", null, "Each command repeats one failure. Run it in an empty folder, with lcpbench on your PATH. Where it",
      " names a file by a relative path, run it in the folder of the study."),
    h("ol", { class: "worst" }, worst.slice(0, worstShown).map((entry) => h("li", null,
      h("p", null, code(entry.set), `, seed ${entry.seed}, problem ${entry.trial}: said `,
        h("em", null, entry.claim), ", is ", h("em", null, entry.verdict),
        `, error ${entry.error === null ? "without a number" : scientific(entry.error)}, ${duration(entry.time_s)}`),
      entry.command && h("div", { class: "command" }, h("pre", { tabindex: "0" }, entry.command),
        copyButton(entry.command))))),
  ];
}

function setTable(page, record, error) {
  const { report, statistics } = page;
  const name = ({ cells: [{ set }] }) => report.sets[set].name;
  const own = new Map(records(report, "results").filter(({ solver }) => solver === report.solvers[record.solver].label).map((row) => [row.set, row]));
  const median = (title, column, value = (each) => own.get(name(each))?.[column]) =>
    ({ name: column, title, unit: "m/s, median", number: true, value, show: (each) => scientific(value(each)) });
  const columns = [{ name: "set", title: "Set", value: name, show: (each) => code(name(each)) },
    ...recordColumns(report.rule.least_problems), median("Error", "solver_error_median_m_per_s"),
    median("Cone error", "model_error_median_m_per_s")];
  return dataTable(columns, record.cells.map(({ set }) => statistics.pool([set], error, record.solver)),
    { name: "sets", caption: "Set by set", few: record.cells.length < 20 });
}

/** Opens the dialog on one solver's record in a choice. */
export function openPoint(page, title, choice, record) {
  const solver = page.report.solvers[record.solver];
  const over = page.state.reference ?? choice.recommended?.solver ?? null;
  const facts = [
    ["On", `${title}: took ${count(record.taken)} of ${count(record.met)} problems`],
    ...pointFacts(page, choice, record),
    over !== null && over !== record.solver && ["Speed", [
      factorText(page.statistics.factor(choice.sets, choice.error, over, record.solver)), ", against ",
        code(page.report.solvers[over].label)]],
    ["Settings", solver.settings || "the defaults"],
    ["Library", origin(solver)],
  ].filter(Boolean);
  const back = () => dialog.close();
  const dialog = h("dialog", { class: "point", "aria-labelledby": "point-title", onclose: () => {
    dialog.remove();
    removeEventListener("popstate", back);
    if (history.state === "dialog") history.back();
  },
    onclick: (event) => event.target === dialog && dialog.close() },
    h("header", null, h("h2", { id: "point-title" }, code(solver.label)),
      h("button", { type: "button", class: "close", onclick: () => dialog.close() }, "Close")),
    whatItIs(solver), h("dl", null, facts.map(([term, text]) => [h("dt", null, term), h("dd", null, text)])),
    h("h3", null, "Worst problems"), worstList(page, record.solver, choice.sets),
    h("h3", null, "Set by set"), setTable(page, record, choice.error),
    h("p", { class: "note" }, "Cone error: how far an answer is from the conditions of the round friction cone."));
  document.body.append(dialog);
  dialog.showModal();
  history.pushState("dialog", "");  // Back closes it
  addEventListener("popstate", back);
}

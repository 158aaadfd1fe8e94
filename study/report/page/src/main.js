// The page of a report, a comparison or a single step: reads the document that lcpbench put into it, and shows it.

import { mountAnswer } from "./answer.js";
import { controls, mountPictures } from "./ask.js";
import { Statistics } from "./choice.js";
import { h, prose } from "./dom.js";
import { Tip } from "./point.js";
import { comparisonSections } from "./comparison.js";
import { errorSection } from "./errors.js";
import { madeSection, sceneSection, tableSections } from "./sections.js";
import { State } from "./state.js";

const report = JSON.parse(document.getElementById("report").textContent);

const section = (id, title, ...content) => h("section", { id }, h("h2", null, title), content);

function reportPage(main) {
  const page = { report, tip: new Tip(), state: new State(report), statistics: new Statistics(report) };
  page.widthFor = (large) => {
    const width = main.clientWidth;
    return large || width < 760 ? width : (width - 24) / 2;
  };
  page.showAll = (view) => {
    const at = report.situations.indexOf(view);
    page.state.change({ at: at < 0 ? "own" : at });
    document.getElementById("pictures").scrollIntoView();
  };
  const text = h("p", { class: "sentence", role: "status", "aria-live": "polite" });
  const table = h("div");
  const below = h("div");
  const pictures = section("pictures", "Speed, error and success", prose(PROSE.pictures, report.rule));
  main.append(h("h1", null, "Which solver should turn contacts into impulses?"), controls(page), text,
    h("section", { id: "answer", "aria-label": "Whom to use for what" }, table, below), pictures);
  const showAnswer = mountAnswer(page, { text, table, below });
  const showPictures = mountPictures(page, pictures);
  const draw = () => {
    page.tip.hide();
    const choices = page.state.views().map((view) => [view,
      page.statistics.choose(view.sets, page.state.solvers, page.state.error)]);
    showAnswer(choices);
    showPictures(choices);
  };
  page.state.follow(draw);
  let width = main.clientWidth;
  new ResizeObserver(() => {
    if (Math.abs(main.clientWidth - width) > 4) (width = main.clientWidth), draw();
  }).observe(main);
}

function mount() {
  const main = h("main");
  document.body.append(main);
  if (report.kind === "report") reportPage(main);
  if (report.kind === "comparison") main.append(...comparisonSections(report).filter(Boolean));
  const single = report.kind === "view";
  if (single) main.append(h("h1", null, report.scenes?.[0] ? "A step in 3D" : "Replays"));
  main.append(...[
    report.kind === "report" && errorSection(report, main.clientWidth), sceneSection(report, single), ...tableSections(report),
    report.kind === "report" && h("section", { id: "words" }, h("h2", null, "Words and rules"),
      prose(PROSE.words, report.rule), prose(PROSE.limits)),
    madeSection(report),
  ].filter(Boolean));
  const links = [...main.querySelectorAll("section[id] > h2")].map((heading) => h("a",
    { href: `#${heading.parentElement.id}`, onclick: (event) => {
    event.preventDefault();  // the address keeps the choice
    heading.tabIndex = -1;
    heading.focus();
    heading.scrollIntoView();
  } }, heading.textContent));
  if (links.length > 1) main.querySelector("h1").after(h("nav", { "aria-label": "Parts of this page" }, links));
  document.title = `lcpbench: ${main.querySelector("h1").textContent}`;
}

mount();
const target = document.getElementById(location.hash.slice(1));
if (target) (target.open = true), target.scrollIntoView();

// The parts below the pictures: scenes, tables, the paper, where the numbers come from.

import { code, fold, h, prose } from "./dom.js";
import { origin } from "./point.js";
import { reportTable } from "./table.js";

/** A scene in an element of its own, drawn once it comes near the window; three.js wakes with the first one. */
function sceneElement(view) {
  const element = h("div", { class: "scene" });
  const watch = new IntersectionObserver((entries) => {
    if (!entries.some(({ isIntersecting }) => isIntersecting)) return;
    watch.disconnect();
    if (view.kind === "replay") import("./scene3d_film.js").then(({ mountFilm }) => mountFilm(element, view));
    else import("./scene3d.js").then(({ mountStep }) => mountStep(element, view));
  }, { rootMargin: "200px" });
  watch.observe(element);
  return element;
}

/** Steps and films. @param single  on a page that has nothing else */
export function sceneSection(report, single) {
  const views = [...(report.scenes ?? []), ...(report.replays ?? [])];
  if (!views.length) return null;
  return h("section", { id: "scenes", "aria-label": single && "Scenes" },
    !single && [h("h2", null, "Scenes"), prose(PROSE.scenes)], views.map(sceneElement));
}

const tableFold = (table) => fold(h("strong", null, table.title),
  () => [h("p", { class: "note" }, table.about), reportTable(table)], { id: `table-${table.name}` });

/** Two sections, of all tables but the paper's and of the paper's; false for one without tables. Tables of no rows are
 *  left out. */
export function tableSections(report) {
  const inPaper = new Set(report.paper?.tables ?? []);
  const some = (report.tables ?? []).filter(({ rows }) => rows.length > 0);
  const section = (id, title, words, tables) => tables.length > 0 &&
    h("section", { id }, h("h2", null, title), prose(words), tables.map(tableFold));
  return [section("tables", "Tables", PROSE.tables, some.filter(({ name }) => !inPaper.has(name))),
    section("paper", "The paper of 2012", PROSE.paper, some.filter(({ name }) => inPaper.has(name)))];
}

export function madeSection(report) {
  const text = (value) => (Array.isArray(value) ? value.map(text).join("; ") : value && typeof value === "object"
    ? Object.entries(value).map((entry) => entry.join(" ")).join(", ") : String(value ?? ""));
  const solvers = [...new Set((report.solvers ?? []).filter(({ version }) => version).map(origin))].sort();
  const entries = Object.entries({ ...report.made, solvers }).filter(([, value]) => text(value));
  if (!entries.length) return null;
  return h("section", { id: "made" }, h("h2", null, "Where the numbers come from"),
    h("dl", { class: "made" }, entries.map(([name, value]) => [h("dt", null, name.replaceAll("_", " ")),
      h("dd", null, code(text(value)))])));
}

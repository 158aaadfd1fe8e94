// The parts below the pictures: scenes, tables, the paper, where the numbers come from.

import { code, fold, h, prose } from "./dom.js";
import { queryFold, reportTable } from "./table.js";

/** A scene in an element of its own; three.js wakes with the first one. */
function sceneElement(view) {
  const element = h("div", { class: "scene" });
  import("./scene3d.js").then(({ mountScene }) => mountScene(element, view));
  return element;
}

/** Steps and films; each is made when it is opened, or at once on a page that has nothing else. */
export function sceneSection(report, single) {
  const views = [...(report.scenes ?? []), ...(report.replays ?? [])];
  if (!views.length) return null;
  if (single) return h("section", { id: "scenes", "aria-label": "Scenes" }, views.map(sceneElement));
  return h("section", { id: "scenes" }, h("h2", null, "Scenes"), prose(PROSE.scenes), views.map((view) =>
    fold([h("strong", null, view.title), view.kind === "replay" ? ", a film" : ", one step"],
      () => sceneElement(view), { class: "view" })));
}

/** A table; one that is too long for the page has its query here and its rows in a file. */
function tableFold(table) {
  const file = h("p", null, "This table is long: its rows are in ", code(`tables/${table.name}.csv`), ".");
  return fold(h("strong", null, table.title), () => [h("p", { class: "note" }, table.about),
    table.rows ? reportTable(table) : [file, queryFold(table.sql)]],
    { id: `table-${table.name}` });
}

/** Two sections, of all tables but the paper's and of the paper's; false for one without tables. Tables of no rows are
 *  left out; where `rows` is absent, they are in a file. */
export function tableSections(report) {
  const inPaper = new Set(report.paper?.tables ?? []);
  const some = (report.tables ?? []).filter(({ rows }) => rows?.length !== 0);
  const section = (id, title, words, tables) => tables.length > 0 &&
    h("section", { id }, h("h2", null, title), prose(words), tables.map(tableFold));
  return [section("tables", "Tables", PROSE.tables, some.filter(({ name }) => !inPaper.has(name))),
    section("paper", "The paper of 2012", PROSE.paper, some.filter(({ name }) => inPaper.has(name)))];
}

export function madeSection(report) {
  const text = (value) => (Array.isArray(value) ? value.map(text).join("; ") : value && typeof value === "object"
    ? Object.entries(value).map((entry) => entry.join(" ")).join(", ") : String(value ?? ""));
  const entries = Object.entries(report.made ?? {}).filter(([, value]) => text(value));
  if (!entries.length) return null;
  return h("section", { id: "made" }, h("h2", null, "Where the numbers come from"),
    h("dl", { class: "made" }, entries.map(([name, value]) => [h("dt", null, name.replaceAll("_", " ")),
      h("dd", null, code(text(value)))])));
}

// The parts below the pictures: scenes, tables, the paper, where the numbers come from.

import texts from "prose";
import { code, fold, h, prose } from "./dom.js";
import { plain } from "./format.js";
import { reportTable } from "./table.js";

/** Three.js wakes when the first scene is opened. */
async function mountView(element, view) {
  const { mountScene } = await import("./scene3d.js");
  mountScene(element, view);
}

/** Steps and films; each is made when it is opened. */
export function sceneSection(report, single) {
  const views = [...(report.scenes ?? []), ...(report.replays ?? [])];
  if (!views.length) return null;
  if (single) {
    const element = h("div", { class: "scene" });
    mountView(element, views[0]);
    return h("section", { id: "scenes", "aria-label": "Scene" }, element);
  }
  const folds = views.map((view) => {
    const element = h("div", { class: "scene" });
    return fold([h("strong", null, view.title), view.kind === "replay" ? ", a film" : ", one step"], () => {
      mountView(element, view);
      return element;
    }, { class: "view" });
  });
  return h("section", { id: "scenes" }, h("h2", null, "Scenes"), prose(texts.scenes), folds);
}

const tableFold = (table, open) =>
  fold(h("strong", null, table.title), () => [h("p", { class: "note" }, table.about), reportTable(table)], { id: `table-${table.name}`, open });

export function tablesSection(report) {
  const inPaper = new Set(report.paper?.tables ?? []);
  const tables = (report.tables ?? []).filter(({ name, rows }) => !inPaper.has(name) && rows.length);
  if (!tables.length) return null;
  return h("section", { id: "tables" }, h("h2", null, "Tables"), prose(texts.tables), tables.map((table) => tableFold(table)));
}

export function paperSection(report) {
  const { tables: names = [], claims = [] } = report.paper ?? {};
  const tables = report.tables?.filter(({ name, rows }) => names.includes(name) && rows.length) ?? [];
  if (!tables.length && !claims.length) return null;
  const claimItem = (claim) => h("li", null, h("p", null, h("strong", { class: "word" }, plain(claim.word).replaceAll("_", " ")), " ", claim.statement),
    claim.rule && h("p", { class: "note" }, claim.rule));
  return h("section", { id: "paper" }, h("h2", null, "The paper of 2012"), prose(texts.paper),
    claims.length > 0 && [h("h3", null, "Its claims"), h("ol", { class: "claims" }, claims.map(claimItem))], tables.map((table) => tableFold(table)));
}

export function madeSection(report) {
  const entries = Object.entries(report.made ?? {}).filter(([, value]) => value !== null && value !== "");
  if (!entries.length) return null;
  const text = (value) => (typeof value === "object" ? JSON.stringify(value) : String(value));
  return h("section", { id: "made" }, h("h2", null, "Where the numbers come from"),
    h("dl", { class: "made" }, entries.map(([name, value]) => [h("dt", null, name.replaceAll("_", " ")), h("dd", null, code(text(value)))])));
}

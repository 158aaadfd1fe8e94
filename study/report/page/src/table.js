// A table that can be searched, sorted and downloaded, with its query.

import { copyButton, download, fold, h, small } from "./dom.js";
import { counted, plain } from "./format.js";

const firstRows = 50;
const longText = 120;  // a cell of more characters is folded

/** A cell of a CSV table. A text that a spreadsheet would take for a formula gets an apostrophe in front, as by
 *  csv_text() of study/output/csv.h. */
const csvField = (value) => {
  const formula = typeof value === "string" && /^[=+\-@]/.test(value) && Number.isNaN(Number(value));
  const text = value === null || value === undefined || Number.isNaN(value) ? "" : `${formula ? "'" : ""}${value}`;
  return /[",\r\n]/.test(text) ? `"${text.replaceAll('"', '""')}"` : text;
};

const csv = (columns, rows) =>
  [columns.map(({ name }) => csvField(name)), ...rows.map((row) => columns.map(({ value }) => csvField(value(row))))]
    .map((fields) => `${fields.join(",")}\r\n`).join("");

/** The order of two values, ascending for `sign` 1, descending for -1; absent ones come last in both. */
function compare(a, b, sign) {
  const absent = (value) => value === null || value === undefined || value === "" || Number.isNaN(value);
  if (absent(a) || absent(b)) return absent(a) - absent(b);
  if (typeof a === "number" && typeof b === "number") return sign * (a - b);
  return sign * String(a).localeCompare(String(b), "en", { numeric: true });
}

/**
 * @param columns  [{name, title, unit, number, value(row), show(row)}]: `value` is sorted, searched and downloaded, and
 *   displayed where there is no `show`
 * @param options  {name, caption, sql, rowClass(row), few: all rows at once, without a search}: `name` is that of the
 *   downloaded file, which has the rows that the search leaves, in the order of `rows`
 */
export function dataTable(columns, rows, { name, caption, sql, rowClass, few = false }) {
  let shown = rows;
  let sorted = { column: null, sign: 1 };
  let all = few;
  const body = h("tbody");
  const note = h("p", { class: "note", "aria-live": "polite" });
  const headings = columns.map((column) => {
    const sort = () => {
      const first = column.number ? -1 : 1;
      sorted = { column, sign: sorted.column === column ? -sorted.sign : first };
      draw();
    };
    return h("th", { scope: "col", class: column.number && "number" },
      h("button", { type: "button", class: "sort", onclick: sort }, column.title ?? column.name,
        column.unit && small(` ${column.unit}`)));
  });
  const search = h("input", { type: "search", placeholder: "Search", "aria-label": `Search ${caption}` });
  search.addEventListener("input", () => {
    const words = search.value.toLowerCase().split(/\s+/).filter(Boolean);
    shown = rows.filter((row) => {
      const text = columns.map(({ value }) => value(row) ?? "").join("\t").toLowerCase();
      return words.every((word) => text.includes(word));
    });
    draw();
  });
  const more = h("button", { type: "button", onclick: () => ((all = true), draw()) });

  const cellOf = (column, row, i) => {
    const text = column.show ? "" : plain(column.value(row));
    const content = column.show ? column.show(row)
      : text.length <= longText ? text : fold(`${text.slice(0, longText / 2)} …`, () => text);
    return h(i === 0 ? "th" : "td", { scope: i === 0 && "row", class: column.number && "number" }, content);
  };
  function draw() {
    columns.forEach((column, i) => {
      if (sorted.column === column) headings[i].setAttribute("aria-sort", sorted.sign > 0 ? "ascending" : "descending");
      else headings[i].removeAttribute("aria-sort");
    });
    const { column, sign } = sorted;
    const order = column ? [...shown].sort((a, b) => compare(column.value(a), column.value(b), sign)) : shown;
    const visible = all ? order : order.slice(0, firstRows);
    body.replaceChildren(...visible.map((row) =>
      h("tr", { class: rowClass?.(row) }, columns.map((each, i) => cellOf(each, row, i)))));
    note.textContent = shown.length === rows.length ? counted(rows.length, "row")
      : `${shown.length} of ${rows.length} rows`;
    more.hidden = visible.length === order.length;
    more.textContent = `Show all ${order.length} rows`;
  }
  draw();
  const save = () => download(`${name}.csv`, "text/csv", csv(columns, shown));
  return h("div", { class: few ? "data-table" : "data-table long" },
    h("div", { class: "toolbar" }, !few && search, note,
      h("button", { type: "button", onclick: save, "aria-label": `Download ${caption} as CSV` }, "CSV"),
      sql && queryFold(sql)),
    h("div", { class: "scroll", tabindex: "0", role: "region", "aria-label": caption },
      h("table", null, h("caption", { class: "offscreen" }, caption),
        h("thead", null, h("tr", null, headings)), body)),
    more);
}

export const queryFold = (sql) => fold("SQL", () => [
  h("pre", { tabindex: "0" }, sql),
  h("p", null, copyButton(sql, "Copy the query"), " Run it with ", h("code", null, "lcpbench query STORE FILE.sql"),
    "."),
]);

export const tableOf = (report, table) => report.tables.find(({ name }) => name === table);

/** The rows of a table of the report as objects. */
export function records(report, table) {
  const { columns, rows } = tableOf(report, table);
  return rows.map((row) => Object.fromEntries(columns.map(({ name }, i) => [name, row[i]])));
}

/** The element of a table of the report: its `columns` are {name, unit}, its `rows` arrays of values. */
export function reportTable({ name, title, columns, rows, sql }) {
  const described = columns.map(({ name: column, unit }, i) => ({
    name: column, title: column.replaceAll("_", " "), unit,
    number: rows.some((row) => typeof row[i] === "number"),
    value: (row) => row[i],
  }));
  return dataTable(described, rows, { name, caption: title, sql });
}

// The picture of a choice: time per problem against the share solved or against the error. A dot's area is the number
// of problems behind it; thin lines are 95 % intervals. Refusals are listed under the picture.

import * as Plot from "@observablehq/plot";
import { code, h, setAttributes } from "./dom.js";
import { count, counted, duration } from "./format.js";
import { openPoint, pointLines } from "./point.js";
import { areScenes, groupOf } from "./words.js";

const colours = {
  recommended: "var(--best)", reliable: "var(--good)", unreliable: "var(--bad)", partly: "none", unknown: "none",
};
const strokes = { ...colours, recommended: "var(--ink)", partly: "var(--quiet)", unknown: "var(--quiet)" };
const [lowestError, highestError] = [1e-17, 10];

function dotsOf(choice, y) {
  return choice.records.filter(({ time, of }) => time.n && of).map((record) => {
    const group = record === choice.recommended ? "recommended" : groupOf(record);
    const inErrors = y === "error";
    return {
      record, group, x: record.time.value, x1: record.time.low, x2: record.time.high, n: record.of,
      y: inErrors ? Math.min(Math.max(lowestError, record.p99), record.p99 === Infinity ? NaN : highestError)
        : record.solved / record.of,
      y1: inErrors ? NaN : record.interval.low, y2: inErrors ? NaN : record.interval.high,
      symbol: record.false ? "diamond" : "circle",
    };
  }).filter((dot) => Number.isFinite(dot.y)).sort((a, b) => (b.group === "unreliable") - (a.group === "unreliable"));
}

const finite = (...names) => (dot) => names.every((name) => Number.isFinite(dot[name]));

function plot(dots, { width, height, y, target }) {
  const inErrors = y === "error";
  const times = dots.map(({ x }) => x);
  const domain = times.length ? [Math.min(...times) / 1.6, Math.max(...times) * 1.6] : [1e-6, 1];
  const within = (steps) => {
    const ticks = [];
    for (let power = -9; power < 4; ++power) ticks.push(...steps.map((step) => Number(`${step}e${power}`)));
    return ticks.filter((tick) => tick >= domain[0] && tick <= domain[1]);
  };
  const powers = within([1]);
  const ticks = powers.length > 1 ? powers : within([1, 2, 5]);
  const interval = { stroke: (dot) => strokes[dot.group], strokeOpacity: 0.35, clip: true };
  return Plot.plot({
    width, height, marginLeft: 46, marginRight: 16, marginTop: 28, marginBottom: 36,
    style: { background: "transparent", fontSize: "12px", fontFamily: "inherit", overflow: "visible" },
    x: { type: "log", domain, axis: null },
    y: inErrors
      ? { type: "log", domain: [lowestError, highestError], label: "↑ error of 99 % of the answers",
        labelArrow: "none", tickSize: 0,
          grid: true, ticks: [1e-16, 1e-12, 1e-8, 1e-4, 1],
            tickFormat: (error) => error.toExponential(0).replace("e+0", "") }
      : { domain: [0, 1], label: "↑ share solved", labelArrow: "none", tickSize: 0, grid: true, ticks: 4,
        tickFormat: (part) => `${Math.round(100 * part)} %` },
    r: { type: "sqrt", domain: [0, Math.max(1, ...dots.map(({ n }) => n))], range: [0, 8] },
    marks: [
      Plot.gridX(ticks),
      Plot.axisX(ticks, { text: (seconds) => duration(seconds).replace(/\.0+ /, " "), tickSize: 0,
        label: "time per problem →", labelAnchor: "right", labelArrow: "none" }),
      inErrors && target ? Plot.ruleY([target], { stroke: "var(--ink)", strokeDasharray: "3 3", strokeOpacity: 0.6 })
        : null,
      Plot.ruleX(dots.filter(finite("y1", "y2")), { x: "x", y1: "y1", y2: "y2", ...interval }),
      Plot.ruleY(dots.filter(finite("x1", "x2")), { y: "y", x1: "x1", x2: "x2", ...interval }),
      Plot.dot(dots, {
        x: "x", y: "y", r: (dot) => dot.n, symbol: "symbol", strokeWidth: 1.5,
        fill: (dot) => colours[dot.group], stroke: (dot) => strokes[dot.group], fillOpacity: 0.75, clip: false,
      }),
    ],
  });
}

/**
 * Writes names beside at most `most` dots, where there is room: the recommended solver first, then its ties in time,
 * false claims, other reliable ones and the rest. Sizes are in px; the width of a name is estimated.
 */
function nameDots(svg, dots, solvers, most) {
  const [x, y] = [svg.scale("x"), svg.scale("y")];
  const width = svg.viewBox.baseVal.width;
  const centers = dots.map((dot) => [x.apply(dot.x), y.apply(dot.y)]);
  const r = svg.scale("r");
  const radius = dots.map(({ n }) => r.apply(n) + 1);
  const boxes = centers.map(([cx, cy], i) => [cx - radius[i], cy - radius[i], cx + radius[i], cy + radius[i]]);
  const rank = ({ group, record }) => (group === "recommended" ? 0 : record.tie ? 1 : record.false ? 2
    : group === "reliable" ? 3 : 4);
  const order = dots.map((_, i) => i).sort((a, b) => rank(dots[a]) - rank(dots[b]));
  let named = 0;
  for (const i of order) {
    if (named >= most) break;
    const { spec } = solvers[dots[i].record.solver];
    // Of an external solver: its command, from behind the last "/" on.
    const program = /^external\{command=([^,}]*)/.exec(spec)?.[1].replace(/^.*\//, "");
    const short = program ?? spec;
    const name = short.length > 24 ? `${short.slice(0, 23)}…` : short;
    const length = 6.3 * name.length;
    const [cx, cy] = centers[i];
    const away = radius[i] + 4;
    const places = [[cx + away, cy + 4], [cx - away - length, cy + 4], [cx - length / 2, cy + away + 9],
      [cx - length / 2, cy - away],
      [cx + 4, cy + away + 9], [cx - 4 - length, cy + away + 9], [cx + 4, cy - away], [cx - 4 - length, cy - away]];
    const place = places.find(([left, base]) => {
      const [right, top, bottom] = [left + length, base - 10, base + 3];
      if (left < 46 || right > width - 2 || top < 14 || bottom > svg.viewBox.baseVal.height - 32) return false;
      return boxes.every(([l, t, r, b], j) => (j === i) || right < l || left > r || bottom < t || top > b);
    });
    if (!place) continue;
    const text = document.createElementNS("http://www.w3.org/2000/svg", "text");
    setAttributes(text, { x: place[0], y: place[1], class: `dot-name ${dots[i].group}`, "aria-hidden": "true" });
    text.textContent = name;
    svg.append(text);
    boxes.push([place[0], place[1] - 10, place[0] + length, place[1] + 3]);
    named += 1;
  }
}

/** Gives the picture a name; axes, rules and grids stay silent, and have Plot's names as classes. @returns svg */
export function describe(svg, name) {
  setAttributes(svg, { role: "group", "aria-label": name });
  for (const group of svg.querySelectorAll("g[aria-label]")) {
    group.setAttribute("class", `plot-${group.getAttribute("aria-label").replaceAll(" ", "-")}`);
    group.removeAttribute("aria-label");
    if (!group.querySelector("[role]")) group.setAttribute("aria-hidden", "true");
  }
  return svg;
}

/**
 * A row each with a label, a dot and the line from low to high, over a logarithmic axis; `rule` is a vertical line.
 * @param rows  [{label, at, low, high, colour, weight}]: the dot's area is the weight
 */
export function intervals(rows, name, { width, domain, ticks, tickFormat, rule }) {
  const left = Math.min(320, width * 0.45);
  return describe(Plot.plot({
    width, height: 60 + 20 * rows.length, marginLeft: left, marginRight: 20,
    style: { background: "transparent", fontSize: "12px", fontFamily: "inherit" },
    x: { type: "log", domain, axis: null },
    r: { type: "sqrt", domain: [0, Math.max(...rows.map(({ weight }) => weight))], range: [0, 6] },
    y: { label: null, domain: rows.map(({ label }) => label), tickSize: 0,
      tickFormat: (text) => (text.length * 7 > left ? `…${text.slice(-Math.floor(left / 7.4))}` : text) },
    marks: [Plot.gridX({ ticks }), Plot.axisX({ anchor: "top", ticks, tickFormat, tickSize: 0, label: null }),
      Plot.ruleX([rule], { stroke: "var(--ink)" }),
      Plot.ruleY(rows, { y: "label", x1: "low", x2: "high", stroke: "colour" }),
      Plot.dot(rows, { y: "label", x: "at", fill: "colour", r: "weight" })],
  }), name);
}

/** Pointer and keyboard: one tab stop a picture, arrows go from dot to dot in order of time, Enter opens. */
function makeDotsAnswer(page, svg, dots, view, choice) {
  const nodes = [...svg.querySelectorAll("[aria-label=dot] > *")];
  const byTime = nodes.map((node) => [node, dots[node.__data__]]).sort((a, b) => a[1].x - b[1].x);
  byTime.forEach(([node, { record }], i) => {
    const lines = pointLines(page, choice, record);
    const open = () => openPoint(page, view.title, choice, record);
    const show = () => page.tip.show(node, lines);
    const hide = () => page.tip.hide();
    const move = (event) => {
      const step = { ArrowRight: 1, ArrowLeft: -1, ArrowDown: 1, ArrowUp: -1 }[event.key];
      if (event.key === "Enter" || event.key === " ") open();
      else if (step) {
        const next = byTime[(i + step + byTime.length) % byTime.length][0];
        node.setAttribute("tabindex", "-1");
        next.setAttribute("tabindex", "0");
        next.focus();
      } else return;
      event.preventDefault();
    };
    setAttributes(node, { tabindex: i ? "-1" : "0", role: "button", "aria-label": lines.join("; "), class: "dot",
      onpointerenter: show, onfocus: show, onpointerleave: hide, onblur: hide, onclick: open, onkeydown: move });
  });
  describe(svg, `${view.title}: one dot a solver, by time and by ${page.state.y === "error" ? "error"
    : "share solved"}`);
}

function refusals(page, choice) {
  const refused = choice.records.filter((record) => record.refused);
  if (!refused.length) return null;
  return h("p", { class: "note" }, "Refused, and not counted as failures: ", refused.map((record, i) => [
    i ? ", " : "", code(page.report.solvers[record.solver].label),
      ` ${count(record.refused)} of ${count(record.met)}`]), ".");
}

/** A figure of one situation under the page's choice. @param large  alone in its row */
export function picture(page, view, choice, large) {
  const { report, state } = page;
  const dots = dotsOf(choice, state.y);
  const figure = h("figure", { class: `picture ${large ? "large" : ""} ${areScenes(report, view) ? "scenes" : ""}` });
  figure.append(h("figcaption", null, h("strong", null, view.title), ` ${counted(choice.most, "problem")}`));
  const width = Math.max(300, Math.floor(page.widthFor(large)));
  const height = large ? Math.min(480, Math.max(300, width * 0.5)) : 270;
  const target = report.errors[state.error];
  const svg = plot(dots, { width, height, y: state.y, target });
  nameDots(svg, dots, report.solvers, large ? 40 : 8);
  makeDotsAnswer(page, svg, dots, view, choice);
  const missing = choice.records.length - dots.length;
  figure.append(svg, ...[
    missing > 0 && h("p", { class: "note" }, `Not drawn: ${missing} without a time${state.y === "error"
      ? ", an error" : ""} or a problem to solve.`),
    refusals(page, choice),
  ].filter(Boolean));
  return figure;
}

export const legend = () => h("p", { class: "legend" },
  [["best", "recommended"], ["good", "reliable"], ["bad", "unreliable"],
    ["hollow", "too few, or a part of the problems only"]]
    .map(([kind, text]) => h("span", null, h("i", { class: `swatch ${kind}` }), text)),
  h("span", null, h("i", { class: "swatch diamond" }), "said solved and was wrong"),
  h("span", null, "area: number of problems; lines: 95 % intervals"));

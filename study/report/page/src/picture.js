// The picture of a choice in one of three forms: a dot a solver by time and error, or a line a solver: the share solved
// over the error that is asked for, or a performance profile. Refusals are listed under the picture.

import * as Plot from "@observablehq/plot";
import { code, h, setAttributes } from "./dom.js";
import { count, counted, duration } from "./format.js";
import { openPoint, pointLines } from "./point.js";
import { areScenes, groupOf } from "./words.js";

const colours = {
  recommended: "var(--best)", reliable: "var(--good)", unreliable: "var(--bad)", partly: "none", unknown: "none",
};
const strokes = { ...colours, recommended: "var(--ink)", partly: "var(--quiet)", unknown: "var(--quiet)" };
const dashes = ["", "7 3", "2 2", "9 3 2 3", "14 3"];
const [lowestError, highestError] = [1e-17, 10];
const percentTicks = { domain: [0, 1], labelArrow: "none", tickSize: 0, grid: true, ticks: 4,
  tickFormat: (part) => `${Math.round(100 * part)} %` };
const errorTick = (error) => error.toExponential(0).replace("e+0", "");

/** The forms: [words on their button, words of a picture of them, items(page, choice), draw(items, options)]. */
export const forms = {
  error: ["speed against error", "one dot a solver, by time and by error", dotsOf, drawDots],
  share: ["share solved within an error", "one line a solver, the share solved over the error", overErrors, drawLines],
  profile: ["performance profile", "one line a solver, the share solved within a factor of the least time", profiles,
    drawLines],
};

const itemOf = (choice, record) =>
  ({ record, group: record === choice.recommended ? "recommended" : groupOf(record) });

function dotsOf(page, choice) {
  return choice.records.filter(({ time, of }) => time.n && of).map((record) => ({
    ...itemOf(choice, record), x: record.time.value, x1: record.time.low, x2: record.time.high, n: record.of,
    y: Math.min(Math.max(lowestError, record.p99), record.p99 === Infinity ? NaN : highestError),
    symbol: record.false ? "diamond" : "circle",
  })).filter((dot) => Number.isFinite(dot.y)).sort((a, b) => (b.group === "unreliable") - (a.group === "unreliable"));
}

/** Of each solver the share solved at each error, whatever it said of its answers. */
function overErrors({ report }, choice) {
  return choice.records.filter(({ of }) => of).map((record) => ({
    ...itemOf(choice, record), points: report.errors.flatMap((x, i) => (x === null ? []
      : [{ x, y: record.cells.reduce((sum, { solved }) => sum + solved[i], 0) / record.of }])) }));
}

/** Dolan, Moré: Benchmarking optimization software with performance profiles, Math. Program. 91, 2002. Of each solver the
 *  share solved in at most x times the time of the fastest of these solvers. Of a set it counts the problems that all took
 *  which took any of the set. */
function profiles({ state }, choice) {
  const solves = (entry) => (state.error ? (entry & 15) >= state.error : (entry & 16) > 0);  // see choice.h
  const least = new Map();  // by set, then problem
  const taken = new Map();
  for (const { set, profile } of choice.records.flatMap(({ cells }) => cells)) {
    if (!profile.some((entry) => entry !== 0)) continue;
    const best = least.get(set) ?? [], before = taken.get(set);
    profile.forEach((entry, i) => solves(entry) && (best[i] = Math.min(best[i] ?? Infinity, entry >> 5)));
    least.set(set, best);
    taken.set(set, profile.map((entry, i) => entry !== 0 && (before === undefined || before[i] === true)));
  }
  return choice.records.map((record) => {
    const ratios = record.cells.flatMap(({ set, profile }) => profile.map((entry, i) =>
      (!taken.get(set)?.[i] ? -1 : solves(entry) ? (entry >> 5) - least.get(set)[i] : Infinity)).filter((ratio) => ratio >= 0));
    const within = (most) => ratios.filter((ratio) => ratio <= most).length / ratios.length;
    const places = [...new Set(ratios)].filter((ratio) => ratio <= 600).concat(0, 600).sort((a, b) => a - b);
    return { ...itemOf(choice, record), step: true, points: ratios.length === 0 ? []
      : places.map((ratio) => ({ x: 10 ** (ratio / 200), y: within(ratio) })) };
  }).filter(({ points }) => points.length);
}

const finite = (...names) => (dot) => names.every((name) => Number.isFinite(dot[name]));
const style = { background: "transparent", fontSize: "12px", fontFamily: "inherit", overflow: "visible" };

function drawDots(dots, { width, height, target }) {
  const times = dots.map(({ x }) => x);
  const domain = times.length ? [Math.min(...times) / 1.6, Math.max(...times) * 1.6] : [1e-6, 1];
  const within = (steps) => {
    const ticks = [];
    for (let power = -9; power < 4; ++power) ticks.push(...steps.map((step) => Number(`${step}e${power}`)));
    return ticks.filter((tick) => tick >= domain[0] && tick <= domain[1]);
  };
  const powers = within([1]);
  const ticks = powers.length > 1 ? powers : within([1, 2, 5]);
  return Plot.plot({
    width, height, marginLeft: 46, marginRight: 16, marginTop: 28, marginBottom: 36, style,
    x: { type: "log", domain, axis: null },
    y: { type: "log", domain: [lowestError, highestError], label: "↑ error of 99 % of the answers", labelArrow: "none",
      tickSize: 0, grid: true, ticks: [1e-16, 1e-12, 1e-8, 1e-4, 1], tickFormat: errorTick },
    r: { type: "sqrt", domain: [0, Math.max(1, ...dots.map(({ n }) => n))], range: [0, 8] },
    marks: [
      Plot.gridX(ticks),
      Plot.axisX(ticks, { text: (seconds) => duration(seconds).replace(/\.0+ /, " "), tickSize: 0,
        label: "time per problem →", labelAnchor: "right", labelArrow: "none" }),
      target ? Plot.ruleY([target], { stroke: "var(--ink)", strokeDasharray: "3 3", strokeOpacity: 0.6 }) : null,
      Plot.ruleY(dots.filter(finite("x1", "x2")), { y: "y", x1: "x1", x2: "x2", stroke: (dot) => strokes[dot.group],
        strokeOpacity: 0.35, clip: true }),
      Plot.dot(dots, {
        x: "x", y: "y", r: (dot) => dot.n, symbol: "symbol", strokeWidth: 1.5,
        fill: (dot) => colours[dot.group], stroke: (dot) => strokes[dot.group], fillOpacity: 0.75, clip: false,
      }),
    ],
  });
}

/** Lines of shares over errors, or, where they are steps, over factors; names stand at their ends. */
function drawLines(lines, { width, height, target, names }) {
  const steps = lines.some(({ step }) => step);
  const last = steps ? 1000 : 1e-12;
  const stroke = ({ group }) => (group === "recommended" ? "var(--best)" : strokes[group]);
  const order = new Map();  // of each group's lines, for their dashes
  return Plot.plot({
    width, height, marginLeft: 46, marginTop: 28, marginBottom: 36, style,
    marginRight: steps ? 16 : Math.min(width / 2, 28 + Math.max(0, ...names.map(lengthOf))),
    x: { type: "log", domain: [steps ? 1 : 1e-1, last], labelArrow: "none", tickSize: 0, grid: true, labelAnchor: "right",
      label: steps ? "time, in times of the fastest solver of each problem →" : "error of at most →",
      ...(steps ? { ticks: [1, 10, 100, 1000], tickFormat: String }
        : { ticks: [1e-1, 1e-3, 1e-6, 1e-9, 1e-12], tickFormat: errorTick }) },
    y: { ...percentTicks, label: steps ? "↑ share solved so fast" : "↑ share solved" },
    marks: [
      !steps && target ? Plot.ruleX([target], { stroke: "var(--ink)", strokeDasharray: "3 3", strokeOpacity: 0.6 }) : null,
      ...lines.flatMap((item) => {
        const place = order.get(item.group) ?? 0;
        order.set(item.group, place + 1);
        const options = { x: "x", y: "y", curve: item.step ? "step-after" : "linear", stroke: stroke(item) };
        return [Plot.line(item.points, { ...options, strokeDasharray: dashes[place % dashes.length],
          strokeWidth: item.group === "recommended" ? 3 : 1.5 }),
        Plot.line(item.points, { ...options, strokeWidth: 11, strokeOpacity: 0 })];
      }),
    ],
  });
}

const lengthOf = (name) => 6.3 * name.length;  // px, estimated
/** What a solver is called in a picture: an external one by its command, from behind the last "/" on. */
const shortName = ({ label }) => /^external\{command=([^,}]*)/.exec(label)?.[1].replace(/^.*\//, "") ?? label;

/** Where a name may stand beside an item, the best place first: [left, base line, the end of a line to it]. */
function placesFor({ points, step }, [cx, cy], radius, length, at) {
  if (step) {  // along the line
    const most = points.at(-1).y;
    return [0.5, 0.35, 0.65, 0.2, 0.8, 0.95].map((level) => at(points.find(({ y }) => y >= level * most)))
      .flatMap(([x, y]) => [[x + 5, y + 10], [x - length - 5, y - 4]]);
  }
  if (points) {
    return Array.from({ length: 61 }, (_, i) => (i % 2 ? 1 : -1) * Math.ceil(i / 2) * 6.5)
      .map((down) => [cx + 20, cy + 4 + down, [cx, cy]]);
  }
  const away = radius + 4;
  return [[cx + away, cy + 4], [cx - away - length, cy + 4], [cx - length / 2, cy + away + 9],
    [cx - length / 2, cy - away], [cx + 4, cy + away + 9], [cx - 4 - length, cy + away + 9], [cx + 4, cy - away],
    [cx - 4 - length, cy - away]];
}

/**
 * Writes names beside dots, along steps or at the ends of lines, where there is room: the recommended solver first, then
 * its ties in time, false claims, other reliable ones and the rest. @returns the items without a name
 */
function nameItems(svg, items, names) {
  const [x, y, r] = ["x", "y", "r"].map((name) => svg.scale(name));
  const { width, height } = svg.viewBox.baseVal;
  const at = (point) => [x.apply(point.x), y.apply(point.y)];
  const centers = items.map((item) => at(item.points?.at(-1) ?? item));
  const radius = items.map(({ n }) => (n ? r.apply(n) + 1 : 0));
  const boxes = centers.map(([cx, cy], i) => [cx - radius[i], cy - radius[i], cx + radius[i], cy + radius[i]]);
  const rank = ({ group, record }) => (group === "recommended" ? 0 : record.tie ? 1 : record.false ? 2
    : group === "reliable" ? 3 : 4);
  const order = items.map((_, i) => i).sort((a, b) => rank(items[a]) - rank(items[b]));
  const draw = (tag, attributes) =>
    svg.appendChild(setAttributes(document.createElementNS("http://www.w3.org/2000/svg", tag), attributes));
  return order.filter((i) => {
    const length = lengthOf(names[i]);
    const place = placesFor(items[i], centers[i], radius[i], length, at).find(([left, base]) => {
      const [right, top, bottom] = [left + length, base - 10, base + 3];
      if (left < 46 || right > width - 2 || top < 14 || bottom > height - 32) return false;
      return boxes.every(([l, t, r, b], j) => (j === i) || right < l || left > r || bottom < t || top > b);
    });
    if (!place) return true;
    const [left, base, from] = place;
    if (from) draw("line", { x1: from[0], y1: from[1], x2: left - 3, y2: base - 4, class: "leader", "aria-hidden": "true" });
    draw("text", { x: left, y: base, class: `dot-name ${items[i].group}`, "aria-hidden": "true" }).textContent = names[i];
    boxes.push([left, base - 10, left + length, base + 3]);
    return false;
  }).map((i) => items[i]);
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

/** Pointer and keyboard: one tab stop a picture, arrows go from item to item, from dot to dot in order of time, Enter opens. */
function makeItemsAnswer(page, svg, items, view, choice) {
  const nodes = [...svg.querySelectorAll("[aria-label=dot] > *, [stroke-opacity='0'] > path")];
  const itemOfNode = (node, i) => items[Array.isArray(node.__data__) ? i : node.__data__];
  const ordered = nodes.map((node, i) => [node, itemOfNode(node, i)]).sort((a, b) => (a[1].x ?? 0) - (b[1].x ?? 0));
  ordered.forEach(([node, { record }], i) => {
    const lines = pointLines(page, choice, record);
    const open = () => openPoint(page, view.title, choice, record);
    const show = () => page.tip.show(node, lines);
    const hide = () => page.tip.hide();
    const move = (event) => {
      const step = { ArrowRight: 1, ArrowLeft: -1, ArrowDown: 1, ArrowUp: -1 }[event.key];
      if (event.key === "Enter" || event.key === " ") open();
      else if (step) {
        const next = ordered[(i + step + ordered.length) % ordered.length][0];
        node.setAttribute("tabindex", "-1");
        next.setAttribute("tabindex", "0");
        next.focus();
      } else return;
      event.preventDefault();
    };
    setAttributes(node, { tabindex: i ? "-1" : "0", role: "button", "aria-label": lines.join("; "), class: "dot",
      onpointerenter: show, onfocus: show, onpointerleave: hide, onblur: hide, onclick: open, onkeydown: move });
  });
  describe(svg, `${view.title}: ${forms[page.state.y][1]}`);
}

/** A note of some solvers, each with a word behind it; null for none. */
const solversNote = (page, words, records, behind) => records.length > 0 && h("p", { class: "note" }, words,
  records.map((record, i) => [i ? ", " : "", code(page.report.solvers[record.solver].label), behind?.(record)]), ".");

/** A figure of one situation under the page's choice. @param large  alone in its row */
export function picture(page, view, choice, large) {
  const { report, state } = page;
  const [, , itemsOf, draw] = forms[state.y];
  const items = itemsOf(page, choice);
  const figure = h("figure", { class: `picture ${large ? "large" : ""} ${areScenes(report, view) ? "scenes" : ""}` });
  figure.append(h("figcaption", null, h("strong", null, view.title), ` ${counted(choice.most, "problem")}`));
  const width = Math.max(300, Math.floor(page.widthFor(large)));
  const height = large ? Math.min(480, Math.max(300, width * 0.5)) : 270;
  const names = items.map(({ record }) => shortName(report.solvers[record.solver]) +
    (large && state.y === "share" ? `, ${duration(record.time.value)}` : ""));
  const svg = draw(items, { width, height, names, target: report.errors[state.error] });
  const unnamed = nameItems(svg, items, names);
  makeItemsAnswer(page, svg, items, view, choice);
  const missing = choice.records.filter((record) => items.every((item) => item.record !== record));
  figure.append(svg, ...[
    solversNote(page, "Drawn without a name, for want of room: ", unnamed.map(({ record }) => record)),
    solversNote(page, `Not drawn, without a time${state.y === "error" ? ", an error" : ""} or a problem to solve: `, missing),
    solversNote(page, "Refused, and not counted as failures: ", choice.records.filter(({ refused }) => refused),
      ({ refused, met }) => ` ${count(refused)} of ${count(met)}`),
  ].filter(Boolean));
  return figure;
}

export const legend = (form) => h("p", { class: "legend" },
  [["best", "recommended"], ["good", "reliable"], ["bad", "unreliable"],
    ["hollow", "too few, or a part of the problems only"], form === "error" && ["diamond", "said solved and was wrong"]]
    .filter(Boolean).map(([kind, text]) => h("span", null, h("i", { class: `swatch ${kind}` }), text)),
  form === "error" && h("span", null, "area: number of problems; thin lines: 95 % intervals"));

// Replays of one scene as films with one time slider, solvers side by side. See scene3d.js.
import * as Plot from "@observablehq/plot";
import { Quaternion, Vector3 } from "three";
import { code, h } from "./dom.js";
import { count, duration, plain } from "./format.js";
import { describe } from "./picture.js";
import { paint, placedSolids, renderer, solidsOf } from "./scene3d_draw.js";
import {
  colorOf, howTo, keepPainted, noWebGl, orbitButtons, orbitOf, panesOf, rampLegend, themeOf,
} from "./scene3d.js";
import { dataTable } from "./table.js";

const reduced = () => window.matchMedia("(prefers-reduced-motion: reduce)").matches;
const strokes = [["#3f78c4", ""], ["#e0702f", "7 3"], ["#2f9e6e", "2 3"], ["#a367c9", "9 3 2 3"], ["#888888", "4 2"]];
const away = [-4, -1];  // decades of metres that colours stand for

/** The poses of all bodies at a time: between two frames, unless motion is unwanted. */
function posesAt(film, time) {
  const poses = [...film.still];
  const last = film.frames.length - 1;
  if (last < 0) return poses;
  let i = film.times_s.findLastIndex((at) => at <= time);
  i = Math.min(Math.max(i, 0), last);
  const next = Math.min(i + 1, last);
  const span = film.times_s[next] - film.times_s[i];
  const part = reduced() || !(span > 0) ? 0 : Math.min(1, (time - film.times_s[i]) / span);
  film.moving.forEach((body, k) => {
    const [a, b] = [i, next].map((frame) => film.frames[frame].slice(7 * k, 7 * k + 7));
    const at = new Vector3(...a.slice(0, 3)).lerp(new Vector3(...b.slice(0, 3)), part);
    const turn = new Quaternion(a[4], a[5], a[6], a[3]).slerp(new Quaternion(b[4], b[5], b[6], b[3]), part);
    poses[body] = [at.x, at.y, at.z, turn.w, turn.x, turn.y, turn.z];
  });
  return poses;
}

/** "0.1 mm" */
const length = (metres) => {
  const [size, unit] = [[1, "m"], [1e-3, "mm"], [1e-6, "µm"]].find(([least]) => metres >= 0.99 * least) ?? [1e-6, "µm"];
  return `${plain(Number((metres / size).toPrecision(3)))} ${unit}`;
};

const curveNames = { drift_m: "Drift of what should stand", slip_m: "Slip of what is gripped",
  deepest_m: "Deepest penetration", energy_j: "Energy", cost: "Error against processor time" };
// Metres: less is not told apart, and nothing may move so far in a scene that is kept.
const [least, lost] = [1e-6, 0.1];
const errorText = (metres) => (metres >= lost ? "lost" : metres <= least ? `at most ${length(least)}` : length(metres));

/** A measure over time, a line for each film; lengths on a logarithmic axis from 1 micrometre. */
function drawCurves(films, name, end, width) {
  const energy = name === "energy_j";
  const points = films.flatMap((film, i) => film.curves.time_s.map((time, p) => ({ time, film: i, value: film.curves[name][p] })))
    .filter(({ value }) => value !== null).map((point) => ({ ...point, value: energy ? point.value : Math.max(point.value, 1e-6) }));
  const [low, high] = [Math.min, Math.max].map((most) => Math.log10(most(...points.map(({ value }) => value))));
  const [first, last] = [Math.floor(low), Math.max(Math.floor(low) + 1, Math.ceil(high))];
  const powers = Array.from({ length: last - first + 1 }, (_, i) => 10 ** (first + i));
  const svg = Plot.plot({
    width, height: 180, marginLeft: 84, marginBottom: 32, style: { background: "transparent", fontSize: "12px" },
    x: { domain: [0, end], label: "time in s", ticks: 5 },
    y: { ...(energy ? { nice: true, ticks: 4 } : { type: "log", domain: [powers[0], powers.at(-1)], ticks: powers }),
      label: null, grid: true,
      tickFormat: (value) => (energy ? `${plain(value)} J` : value < 1.1e-6 ? "below 1 µm" : length(value)) },
    marks: films.map((_, i) => Plot.lineY(points.filter(({ film }) => film === i), { x: "time", y: "value",
      stroke: strokes[i % strokes.length][0], strokeDasharray: strokes[i % strokes.length][1], strokeWidth: 2 })),
  });
  return describe(svg, `${curveNames[name]} over time, of ${films.map((film) => film.solver).join(", ")}`);
}

/** The error of each replay (slip, else drift, else penetration) against its processor time: a line through the settings of
 *  each stepper, and behind them the frontier, which nothing cheaper is below. */
function drawCost(view, width) {
  const points = view.replays.filter((row) => row.cpu_s_per_s > 0).map((row) => {
    const [name, keys = ""] = row.solver.replace(/=[^,}]*/g, "").split("{");
    const way = row.survived < view.steps ? lost : row.slip_m ?? row.drift_m ?? row.deepest_m;
    const stepper = keys.includes(",") ? `${name}{${keys}` : name;
    return { ...row, stepper, error: Math.min(lost, Math.max(way, least)) };
  }).sort((a, b) => a.cpu_s_per_s - b.cpu_s_per_s);
  const steppers = [...new Set(points.map(({ stepper }) => stepper))];
  const stroke = ({ stepper }) => strokes[steppers.indexOf(stepper) % strokes.length];
  const of = (stepper) => points.filter((point) => point.stepper === stepper);
  const frontier = points.filter((point, i) => points.slice(0, i).every(({ error }) => point.error < error));
  const axes = { x: "cpu_s_per_s", y: "error" };
  const svg = Plot.plot({
    width, height: 320, marginLeft: 58, marginBottom: 38, marginTop: 28, marginRight: 90, style: { background: "transparent", fontSize: "12px" },
    x: { type: "log", label: "processor time for a second of the scene", tickFormat: duration, ticks: Math.max(2, width / 160), grid: true },
    y: { type: "log", label: "error; 100 mm: lost", tickFormat: length, ticks: 5, grid: true, nice: true },
    marks: [
      Plot.lineY(frontier, { ...axes, curve: "step-after", stroke: "currentColor", strokeOpacity: 0.25, strokeWidth: 6 }),
      ...steppers.map((name) => Plot.lineY(of(name), { ...axes, stroke: stroke({ stepper: name })[0],
        strokeDasharray: stroke({ stepper: name })[1], strokeWidth: 1.5 })),
      Plot.dot(points, { ...axes, fill: (point) => stroke(point)[0], r: 3.5,
        title: (row) => `${row.solver}\n${errorText(row.error)}, ${duration(row.cpu_s_per_s)}` }),
      Plot.text(steppers.map((name) => of(name).at(-1)), { ...axes, text: "stepper", textAnchor: "start", dx: 4, dy: -8, fill: "currentColor" }),
    ],
  });
  return describe(svg, `${curveNames.cost}: ` +
    points.map((row) => `${row.solver} ${errorText(row.error)} in ${duration(row.cpu_s_per_s)}`).join(", "));
}

/** The largest values of each replay. */
function numbersTable(view) {
  const way = (metres) => (metres === null ? plain(null) : metres < 1e-6 ? "below 1 µm" : length(metres));
  const swatch = ({ solver }) => {
    const film = view.films.findIndex((each) => each.solver === solver);
    return film >= 0 && h("i", { class: "scene3d-swatch", style: `background:${strokes[film % strokes.length][0]}` });
  };
  const number = (name, title, format, unit) =>
    ({ name, title, unit, number: true, value: (row) => row[name], show: (row) => format(row[name], row) });
  return dataTable([
    { name: "solver", title: "Answers of", value: (row) => row.solver, show: (row) => [swatch(row), code(row.solver)] },
    number("survived", "Steps survived", count),
    number("claimed_solved", "Said solved", (solved, row) =>
      (solved === null ? plain(null) : `${count(solved)} of ${count(row.steps_with_contacts)}`)),
    number("drift_m", "Drift", way), number("slip_m", "Slip", way), number("deepest_m", "Deepest penetration", way),
    number("energy_rise_j", "Energy gained", plain, "J"), number("cpu_s_per_s", "Time for 1 s", duration),
    { name: "end", title: "Ended early", value: (row) => row.end },
  ], view.replays, { name: "replays", caption: `Replays of ${view.title} in numbers`, few: view.replays.length < 20 });
}

export function mountFilm(element, view) {
  const { films } = view;
  const solids = solidsOf(view.shapes, films.flatMap(({ moving }) => moving));
  const end = Math.max(view.steps * view.step_length_s, ...films.flatMap((film) => film.times_s));
  const orbit = orbitOf(view, solids, films.flatMap((film) => [0, ...film.times_s].map((time) => posesAt(film, time))));
  const state = { time: 0, playing: null };
  const curves = Object.keys(curveNames).filter((name) => name === "cost" ? view.replays.some((row) => row.cpu_s_per_s > 0)
    : films.some((film) => film.curves[name].some((v) => v !== null)));

  function drawing(film) {
    const theme = themeOf();
    const poses = posesAt(film, state.time);
    const first = posesAt(films[0], state.time);
    const color = (body) => {
      if (film === films[0] || !poses[body] || !first[body]) return theme.body;
      const distance = Math.hypot(...[0, 1, 2].map((k) => poses[body][k] - first[body][k]));
      return distance < 10 ** away[0] ? theme.body : colorOf(distance, away);
    };
    return { theme, dots: [], arrows: [], solids: placedSolids(solids, poses)
      .map((solid) => ({ solid, pose: poses[solid.body], color: color(solid.body) })) };
  }
  const words = (film, row) => {
    const survived = row.survived < view.steps ? `loses the scene at step ${count(row.survived)} of ${count(view.steps)}`
      : `survives all ${count(view.steps)} steps`;
    return row.end ? `${survived}; ended: ${row.end}` : survived;
  };
  const cursor = h("i", { class: "scene3d-cursor" });
  const chart = h("div", { class: "scene3d-chart" });
  const measure = h("select", { "aria-label": "Curve", onchange: () => resize() }, curves.map((name) =>
    h("option", { value: name }, curveNames[name])));
  const output = h("output", null);
  const slider = h("input", { type: "range", min: 0, max: end, step: end / 300, value: 0, "aria-label": "Time",
    oninput: () => {
      stop();
      seek(Number(slider.value));
    } });
  const button = h("button", { type: "button", class: "play", onclick: () => (state.playing ? stop() : play()) }, "Play");

  const repaint = () => {
    for (const pane of panes) {
      paint(pane.canvas, orbit, drawing(films[pane.choice]));
      pane.words.textContent = words(films[pane.choice], view.replays.find(({ solver }) => solver === films[pane.choice].solver));
    }
    if (state.x) cursor.style.left = `${state.x.apply(state.time)}px`;
    output.textContent = `${state.time.toFixed(2)} s of ${end.toFixed(2)} s`;
    slider.setAttribute("aria-valuetext", output.textContent);
  };
  const resize = () => {
    if (curves.length && chart.clientWidth) {
      const overTime = measure.value !== "cost";
      const plot = overTime ? drawCurves(films, measure.value, end, chart.clientWidth) : drawCost(view, chart.clientWidth);
      state.x = overTime ? plot.scale("x") : null;
      chart.replaceChildren(plot, ...(overTime ? [cursor] : []));
    }
    repaint();
  };
  const seek = (time) => {
    state.time = Math.min(end, Math.max(0, time));
    slider.value = state.time;
    repaint();
  };
  const stop = () => {
    cancelAnimationFrame(state.playing);
    state.playing = null;
    button.textContent = "Play";
  };
  const play = () => {
    if (state.time >= end) seek(0);
    button.textContent = "Pause";
    let before = performance.now();
    const least = reduced() ? 500 : 0;  // ms between pictures
    const tick = (now) => {
      if (!element.isConnected) return stop();
      state.playing = requestAnimationFrame(tick);
      if (now - before < least) return undefined;
      seek(state.time + (now - before) / 1000);
      before = now;
      return state.time >= end ? stop() : undefined;
    };
    state.playing = requestAnimationFrame(tick);
  };
  const { panes, element: pictures } = panesOf(3, films.map(({ solver }) => solver), "Answers of", view.title, orbit, repaint,
    repaint);
  const far = films.length > 1 ? rampLegend(`How far a body is from where the answers of ${films[0].solver} have it:`,
    "0.1 mm", "10 cm or more") : null;
  const figure = h("figure", { class: "scene3d scene3d-films" },
    h("figcaption", null, view.conclusion),
    !renderer() || orbit.empty ? h("p", null, renderer() ? "These replays have no shapes to draw." : noWebGl) : [pictures,
      h("div", { class: "scene3d-controls" }, button, slider, output, orbitButtons(orbit, repaint)), far,
      h("p", { class: "scene3d-readout" }, howTo)],
    curves.length ? [measure, chart] : null, numbersTable(view));
  element.replaceChildren(figure);
  keepPainted(figure, resize);
  resize();
}

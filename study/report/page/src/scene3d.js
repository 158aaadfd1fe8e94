// A captured step in 3D, two solvers' answers to it side by side. Films are in scene3d_film.js.
// docs/schema/view.schema.json describes the data. The styles are in scene3d.css, which page.css imports.
import { Box3, Vector3 } from "three";
import { code, fold, h } from "./dom.js";
import { duration, plain, scientific } from "./format.js";
import { boxOf, Orbit, paint, placedSolids, renderer, solidsOf, vector } from "./scene3d_draw.js";
import { dataTable } from "./table.js";

const dark = () => window.matchMedia("(prefers-color-scheme: dark)");
export const themeOf = () => dark().matches
  ? { ramp: ramps.dark, body: "#4d5869", edge: "#9aa7b8", ground: "#39424f", velocity: "#d9b6ff", motion: "#62d6a0" }
  : { ramp: ramps.light, body: "#c3cddb", edge: "#5d6b7e", ground: "#d9dee5", velocity: "#6b2fb3", motion: "#0d7a4a" };

// From blue to red over decades; told apart also where red and green are not.
const ramps = { light: ["#2c5fa8", "#4fa3d1", "#9fd0c8", "#f2c14e", "#e8743b", "#b3123a"],
  dark: ["#6aaaf5", "#5fc3dd", "#a8dcc9", "#f2c14e", "#f08a50", "#f0476f"] };
const errorDecades = [-8, -1];  // log10 of the least and largest error in m/s that colours tell apart
/** The colour of a value on a logarithmic scale from 10^low to 10^high; that of the largest where it is not known. */
export function colorOf(value, [low, high]) {
  const { ramp } = themeOf();
  if (!Number.isFinite(value)) return ramp.at(-1);
  const part = (Math.log10(Math.max(value, 1e-300)) - low) / (high - low);
  return ramp[Math.round(Math.min(1, Math.max(0, part)) * (ramp.length - 1))];
}
export const rampLegend = (what, low, high) => h("p", { class: "scene3d-legend" }, `${what} ${low} `,
  ramps.light.map((light, i) => h("i", { style: `background: light-dark(${light}, ${ramps.dark[i]})` })), ` ${high}`);

/** A canvas that is turned by mouse, finger and keys, together with the others of its orbit. */
function stage(label, orbit, repaint, onpick) {
  const canvas = h("canvas", { class: "scene3d-stage", tabindex: 0, role: "application", "aria-label": label,
    "aria-roledescription": "3D picture" });
  let from = null;
  const act = (change) => {
    change();
    repaint();
  };
  const keys = {
    ArrowLeft: () => orbit.turn(-0.12, 0), ArrowRight: () => orbit.turn(0.12, 0), ArrowUp: () => orbit.turn(0, 0.12),
    ArrowDown: () => orbit.turn(0, -0.12), "+": () => orbit.scale(1.2), "-": () => orbit.scale(1 / 1.2),
    0: () => orbit.reset(),
  };
  canvas.addEventListener("keydown", (event) => {
    if (!keys[event.key] || event.ctrlKey || event.metaKey) return;
    event.preventDefault();
    act(keys[event.key]);
  });
  canvas.addEventListener("pointerdown", (event) => {
    from = { x: event.clientX, y: event.clientY, moved: 0 };
    canvas.setPointerCapture(event.pointerId);
  });
  canvas.addEventListener("pointermove", (event) => {
    if (!from) return;
    const [x, y] = [event.clientX - from.x, event.clientY - from.y];
    from = { x: event.clientX, y: event.clientY, moved: from.moved + Math.hypot(x, y) };
    act(() => orbit.turn(-0.01 * x, event.pointerType === "touch" ? 0 : 0.01 * y));
  });
  canvas.addEventListener("pointercancel", () => (from = null));
  canvas.addEventListener("pointerup", (event) => {
    if (from?.moved < 4) onpick?.(event.offsetX, event.offsetY);
    from = null;
  });
  canvas.addEventListener("wheel", (event) => {
    if (document.activeElement !== canvas) return;  // else the page scrolls
    event.preventDefault();
    act(() => orbit.scale(Math.exp(-0.001 * event.deltaY)));
  }, { passive: false });
  return canvas;
}

/** Pictures side by side, each with a choice of whose it is. choices: names; label(i) names a picture for screen readers;
    onchange(), onpick(pane, x, y). @returns {panes: [{choice, canvas, words}], element} */
export function panesOf(most, choices, question, label, orbit, repaint, onchange, onpick) {
  const panes = choices.slice(0, most).map((_, i) => {
    const pane = { choice: i, words: h("p", { class: "scene3d-words" }) };
    pane.canvas = stage(`${label}, picture ${i + 1}. ${howTo}`, orbit, repaint, (x, y) => onpick?.(pane, x, y));
    return pane;
  });
  const element = h("div", { class: "scene3d-panes" }, panes.map((pane) => {
    const select = h("select", { onchange: () => {
      pane.choice = Number(select.value);
      onchange();
    } }, choices.map((name, k) => h("option", { value: k, selected: k === pane.choice }, name)));
    return h("div", { class: "scene3d-pane" }, h("label", null, question, " ", select), pane.canvas, pane.words);
  }));
  return { panes, element };
}

export const orbitButtons = (orbit, repaint) => [
  ["−", "Zoom out", () => orbit.scale(1 / 1.3)], ["+", "Zoom in", () => orbit.scale(1.3)],
  ["Reset view", null, () => orbit.reset()],
].map(([text, name, act]) => h("button", { type: "button", "aria-label": name, onclick: () => {
  act();
  repaint();
} }, text));

/** Calls repaint when the size or the colours change. */
export function keepPainted(element, repaint) {
  new ResizeObserver(repaint).observe(element);
  dark().addEventListener("change", repaint);
}

export const noWebGl = "This browser has no WebGL, so that there are no pictures.";
export const howTo = "Drag or use the arrow keys to turn; + and − zoom, 0 resets.";

/** An orbit around all solids but the ground, wherever they stand in one of the poses, and around some points. What flies
 *  off is left out: what comes four times as far from the box of the first poses as this is long. */
export function orbitOf(view, solids, allPoses, points = []) {
  const box = new Box3().setFromPoints(points.map(vector));
  let near = null;
  for (const poses of allPoses) {
    for (const solid of placedSolids(solids, poses)) {
      const own = solid.ground ? null : boxOf(solid, poses[solid.body]);
      if (own && (!near || near.containsPoint(own.getCenter(new Vector3())))) box.union(own);
    }
    near ??= box.clone().expandByScalar(4 * box.getSize(new Vector3()).length());
  }
  return new Orbit(view.gravity, box);
}

/** From the worst contact to the best one, by the worse of the answers; null is an error that is no number. */
function byError(view, answers) {
  const worst = (c) => Math.max(...answers.map(({ residuals: { [c]: error = 0 } }) => error ?? Infinity));
  return Array.from({ length: view.contacts.count }, (_, c) => c).sort((a, b) => worst(b) - worst(a) || a - b);
}

const contactName = (view, c) => {
  const [a, b] = view.contacts.bodies[c] ?? [];
  const pair = a === undefined ? view.contacts.ids[c] ?? "" : `body ${a} on ${b < 0 ? "the world" : `body ${b}`}`;
  return `Contact ${c}${pair === "" ? "" : `, ${pair}`}`;
};
const friction = (numbers) => (numbers ? Math.hypot(numbers[1], numbers[2]) : undefined);

/** The contacts with each answer's numbers, those with the largest errors first. */
function contactTable(view, answers, choose) {
  const quantities = [
    ["Error, m/s", (answer, c) => answer.residuals[c], scientific],
    ["Normal impulse, N s", (answer, c) => answer.impulses[c]?.[0]],
    ["Friction impulse, N s", (answer, c) => friction(answer.impulses[c])],
    ["Normal velocity, m/s", (answer, c) => answer.velocities[c]?.[0]],
    ["Slip, m/s", (answer, c) => friction(answer.velocities[c])],
  ];
  const columns = [{ name: "contact", title: "Contact", value: (c) => contactName(view, c), show: (c) =>
    h("button", { type: "button", class: "link", onclick: () => choose(c) }, contactName(view, c)) },
  ...quantities.flatMap(([title, value, format = plain]) => answers.map((answer) => ({
    name: `${title}, ${answer.solver}`, title, unit: answer.solver, number: true,
    value: (c) => value(answer, c), show: (c) => format(value(answer, c)) })))];
  return dataTable(columns, byError(view, answers), { name: "contacts", caption: "Contacts in numbers" });
}

/** The bounded rows with each answer's impulse, velocity and state. */
function rowTable(view, answers) {
  const unit = (row) => view.rows[row].unit;
  const quantities = [
    ["impulse", "Impulse", (value, row) => `${plain(value)} ${unit(row) === "rad/s" ? "N m s" : "N s"}`],
    ["velocity", "Velocity w", (value, row) => `${plain(value)} ${unit(row)}`],
    ["state", "State"],
  ];
  const columns = [{ name: "row", title: "Bounded row", value: (row) => view.rows[row].name },
  ...quantities.flatMap(([key, title, show]) => answers.map((answer) => ({ name: `${title}, ${answer.solver}`, title,
    unit: answer.solver, number: Boolean(show), value: (row) => answer.rows[row]?.[key],
    show: show && ((row) => (answer.rows[row] ? show(answer.rows[row][key], row) : "")) })))];
  return dataTable(columns, [...view.rows.keys()], { name: "rows", caption: "Bounded rows in numbers" });
}

const claims = { solved: "said solved", unsolvable: "said unsolvable", iteration_limit: "stopped at its limit of iterations",
  time_limit: "stopped at its time limit", numerical_failure: "gave up", unsupported: "refused it", crashed: "crashed" };
const answerWords = ({ claim, verdict, error_m_per_s: error, time_s: time }) => `${claims[claim] ?? claim}; verdict: ` +
  verdict + (error === null ? "" : `; error ${scientific(error)} m/s`) + (time === null ? "" : `; ${duration(time)}`);

export function mountStep(element, view) {
  const { contacts, answers } = view;
  const isAt = ([x, y, z]) => ([a, b, c]) => Math.hypot(x - a, y - b, z - c) < 1e-9;  // view.bodies names no bodies
  const solids = solidsOf(view.shapes, [...view.poses.keys()].filter((body) =>
    view.poses[body] && view.bodies.positions.some(isAt(view.poses[body]))));
  const known = contacts.points.filter(Boolean);
  const orbit = orbitOf(view, solids, [view.poses], known);
  const { box, radius } = orbit;  // of bodies and contacts, without arrows
  const state = { show: { impulses: true, velocities: false, bodies: false }, contact: null };
  const best = answers.reduce((a, b) => ((b.error_m_per_s ?? Infinity) < (a.error_m_per_s ?? Infinity) ? b : a), answers[0]);
  const longest = (rows) => Math.max(0, ...rows.filter(Boolean).map((row) => Math.hypot(...row.slice(0, 3))));
  const scales = best && {  // the length of a full arrow of each kind, from the most accurate answer
    impulses: longest(best.impulses),
    velocities: Math.max(longest(contacts.velocities_before), longest(best.velocities)),
    bodies: Math.max(longest(view.bodies.velocities_before), longest(best.body_velocities)),
  };
  const arrow = (from, direction, largest, width, color) => {
    const part = Math.min(2, direction.length() / largest);  // a wrong answer may be any size
    return part > 0.01 && { from, to: from.clone().addScaledVector(direction.normalize(), 0.45 * part * radius),
      width: width * Math.min(1, Math.sqrt(60 / known.length)) * orbit.radius, color };
  };
  const inWorld = (axes, numbers) => numbers.reduce(
    (sum, number, i) => sum.addScaledVector(vector(axes[i]), number), vector([0, 0, 0]));

  /** What paint() draws of an answer, or of none: solids, a dot on each contact whose point is known, coloured by its
      error, and the arrows that are switched on. Lengths of arrows are relative to `scales`. */
  function drawing(answer) {
    const theme = themeOf();
    const arrows = [];
    const dots = [];
    contacts.points.forEach((point, c) => {
      if (!point) return;
      const at = vector(point);
      const color = answer?.residuals.length ? colorOf(answer.residuals[c], errorDecades) : theme.edge;
      dots.push({ at, size: (state.contact === c ? 0.04 : 0.016) * orbit.radius, color });
      if (!answer?.impulses.length) return;
      const axes = contacts.axes[c];
      if (state.show.impulses) arrows.push(arrow(at, inWorld(axes, answer.impulses[c]), scales.impulses, 0.009, color));
      if (state.show.velocities) {
        arrows.push(arrow(at, inWorld(axes, answer.velocities[c]), scales.velocities, 0.006, theme.velocity));
      }
    });
    if (state.show.bodies && answer) {
      view.bodies.positions.forEach((position, i) => answer.body_velocities[i] && arrows.push(arrow(vector(position),
        vector(answer.body_velocities[i].slice(0, 3)), scales.bodies, 0.009, theme.motion)));
    }
    return { theme, dots, arrows: arrows.filter(Boolean),
      solids: solids.map((solid) => ({ solid, pose: view.poses[solid.body], color: theme.body })) };
  }

  /** Makes room for the arrows of all answers, so that two pictures with any of them have one scale. */
  const frame = () => {
    const ends = answers.flatMap((answer) => drawing(answer).arrows.map(({ to }) => to));
    orbit.surround(ends.reduce((around, end) => around.expandByPoint(end), box.clone()));
  };
  const readout = h("p", { class: "scene3d-readout", "aria-live": "polite" }, howTo);
  const numbers = h("div", { class: "scene3d-numbers" });
  const ofRows = h("div", { class: "scene3d-numbers" });
  const repaint = () => {
    for (const pane of panes) pane.pixel = paint(pane.canvas, orbit, drawing(answers[pane.choice]));
  };
  const choose = (c) => {
    state.contact = c;
    readout.textContent = `${contactName(view, c)}: ` + panes.map(({ choice }) => {
      const { solver, impulses, residuals } = answers[choice];
      return `${solver}: impulse ${plain(impulses[c]?.[0])} N s, friction ${plain(friction(impulses[c]))} N s, error ` +
        `${scientific(residuals[c])} m/s`;
    }).join("; ") + ".";
    repaint();
  };
  const pick = (pane, x, y) => {
    const near = contacts.points.map((point, c) => {
      if (!point) return { c, distance: Infinity };
      const at = pane.pixel(vector(point));
      return { c, distance: Math.hypot(at.x / at.ratio - x, at.y / at.ratio - y) };
    }).reduce((a, b) => (b.distance < a.distance ? b : a), { distance: 20 });
    if (near.c !== undefined) choose(near.c);
  };
  const refresh = () => {
    for (const pane of panes) pane.words.textContent = answerWords(answers[pane.choice]);
    const shown = [...new Set(panes.map(({ choice }) => choice))].map((i) => answers[i]);
    numbers.replaceChildren(contactTable(view, shown, choose));
    if (view.rows.length > 0) ofRows.replaceChildren(rowTable(view, shown));
    if (state.contact !== null) choose(state.contact);
    repaint();
  };
  const { panes, element: pictures } = panesOf(2, answers.map(({ solver }) => solver), "Answer of", view.title, orbit, repaint,
    refresh, pick);
  const drawn = !orbit.empty && renderer() !== null;
  const notes = [...view.notes, renderer() ? "" : noWebGl,
    drawn && known.length > 0 ? "Arrows of one kind have one scale in both pictures." : ""];
  const toggles = [["impulses", "impulses", known.length], ["velocities", "velocities of contacts", known.length],
    ["bodies", "velocities of bodies", view.bodies.positions.length]].filter(([, , count]) => count > 0)
    .map(([key, name]) => h("label", null, h("input", { type: "checkbox", checked: state.show[key], onchange: (event) => {
      state.show[key] = event.target.checked;
      frame();
      repaint();
    } }), ` ${name}`));
  const figure = h("figure", { class: "scene3d" },
    h("figcaption", null, h("strong", null, view.title), " ", code(view.source)),
    drawn && [pictures,
      h("div", { class: "scene3d-controls" },
        toggles.length > 0 && h("fieldset", null, h("legend", null, "Arrows"), toggles), orbitButtons(orbit, repaint)),
      readout, known.length > 0 && rampLegend("Error of a contact:", "1e-8 m/s or less", "0.1 m/s or more")],
    h("p", { class: "scene3d-notes" }, notes.join(" ")),
    fold("Contacts in numbers", () => numbers, { open: !drawn }),
    view.rows.length > 0 && fold("Bounded rows in numbers", () => ofRows, { open: true }));
  element.replaceChildren(figure);
  keepPainted(figure, repaint);
  frame();
  refresh();
}

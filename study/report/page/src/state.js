// The user's choice. The address keeps it, by names, so that a link shows the same in another report of the same sets.

export class State {
  constructor(report) {
    this.report = report;
    this.setIndex = new Map(report.sets.map(({ name }, i) => [name, i]));
    this.solverIndex = new Map(report.solvers.map(({ label }, i) => [label, i]));
    this.listeners = [];
    this.scenes = new Map();  // name: its sets
    report.sets.forEach(({ family, engine }, i) => engine !== null
      && this.scenes.set(family, [...(this.scenes.get(family) ?? []), i]));
    this.read();
    window.addEventListener("hashchange", () => {
      if (location.hash !== this.written && /^(#.*=.*)?$/.test(location.hash)) this.read(), this.tell();
    });
  }

  /** The whole choice from the address; names that this report does not know are left out. */
  read() {
    const asked = new URLSearchParams(location.hash.includes("=") ? location.hash.slice(1) : "");
    const indices = (name, index) =>
      [...new Set(asked.getAll(name).map((text) => index.get(text)).filter((i) => i !== undefined))];
    const none = (name) => asked.get(name) === "";
    const error = this.report.errors.findIndex((value) => value !== null && value === Number(asked.get("error")));
    const situation = this.report.situations.findIndex(({ title }) => title === asked.get("contacts"));
    this.error = Math.max(0, error);
    this.sets = indices("set", this.setIndex);
    this.at = situation >= 0 ? situation : this.sets.length || none("set") ? "own" : "all";
    const solvers = indices("solver", this.solverIndex);
    this.solvers = solvers.length || none("solver") ? new Set(solvers) : null;
    this.reference = indices("over", this.solverIndex)[0] ?? null;
    this.y = ["share", "profile"].find((form) => form === asked.get("y")) ?? "error";
    this.written = location.hash;
  }

  /** Puts the choice into the address: a step of the browser's history, or in place of the present one. */
  write(more) {
    const { sets, solvers, situations } = this.report;
    const asked = new URLSearchParams();
    const append = (name, texts) => (texts.length ? texts : [""]).forEach((text) => asked.append(name, text));
    if (this.error > 0) asked.set("error", this.errorText);
    if (typeof this.at === "number") asked.set("contacts", situations[this.at].title);
    if (this.at === "own") append("set", this.sets.map((set) => sets[set].name));
    if (this.solvers) append("solver", [...this.solvers].map((solver) => solvers[solver].label));
    if (this.reference !== null) asked.set("over", solvers[this.reference].label);
    if (this.y !== "error") asked.set("y", this.y);
    this.written = String(asked) && `#${asked}`;
    history[more ? "replaceState" : "pushState"](null, "", this.written || location.pathname + location.search);
  }

  /** @param more  of the last change, as while a slider moves: Back undoes both */
  change(changes, more = false) {
    Object.assign(this, changes);
    this.write(more);
    this.tell();
  }

  tell() {
    for (const listener of this.listeners) listener();
  }

  /** Calls now and after every change. */
  follow(listener) {
    this.listeners.push(listener);
    listener();
  }

  /** The situations in view: {title, sets, scenes}. */
  views() {
    const { situations } = this.report;
    if (this.at === "own") return [this.own()];
    return this.at === "all" ? situations.filter(({ sets }) => sets.length) : [situations[this.at]];
  }

  own() {
    return { title: this.scene() ?? "Your selection", sets: this.sets };
  }

  /** The scene whose sets, one for each engine, are the chosen ones. */
  scene() {
    const chosen = String([...this.sets].sort((a, b) => a - b));
    return [...this.scenes].find(([, sets]) => String(sets) === chosen)?.[0];
  }

  /** "1e-6" */
  get errorText() {
    const error = this.report.errors[this.error];
    return error === null ? "" : error.toExponential();
  }
}

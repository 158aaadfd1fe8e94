// Which solver to use on some sets at some error: the rule of study/report/choice.cpp, on the same pooled statistics.
// A test gives both 1,000 selections and asks for the same answers.

const normal975 = 1.959963984540054;

/** Wilson's 95 % interval of a share. */
export function wilson(part, whole) {
  if (!whole) return { low: NaN, high: NaN };
  const z2 = (normal975 * normal975) / whole;
  const p = part / whole;
  const center = p + z2 / 2;
  const half = normal975 * Math.sqrt((p * (1 - p)) / whole + z2 / (4 * whole));
  return { low: part === 0 ? 0 : (center - half) / (1 + z2), high: part === whole ? 1 : (center + half) / (1 + z2) };
}

/** The p-value of McNemar's exact two-sided test. Its arguments are the counts of discordant problems. */
function mcnemar(onlyFirst, onlySecond) {
  const n = onlyFirst + onlySecond;
  let term = -n * Math.LN2;
  let tail = 0;
  for (let k = 0; k <= Math.min(onlyFirst, onlySecond); ++k) {
    tail += Math.exp(term);
    term += Math.log(n - k) - Math.log(k + 1);
  }
  return Math.min(1, 2 * tail);
}

/** exp of the mean of logarithms, with its 95 % interval: {n, value, low, high}. */
function geometricMean({ n, sum, squareSum }) {
  if (!n) return { n, value: NaN, low: NaN, high: NaN };
  const mean = sum / n;
  if (n === 1) return { n, value: Math.exp(mean), low: NaN, high: NaN };
  const half = normal975 * Math.sqrt(Math.max(0, (squareSum - sum * mean) / (n - 1)) / n);
  return { n, value: Math.exp(mean), low: Math.exp(mean - half), high: Math.exp(mean + half) };
}

/** Is a ratio of times within 5 % of 1, or its interval around 1? */
const isTie = ({ value, low, high }) => (value < 1.05 && value > 1 / 1.05) || (low <= 1 && high >= 1);

/** One array for each name, as rows: [{name: value, ...}]. */
function rowsOf(columns) {
  const names = Object.keys(columns);
  return columns[names[0]].map((_, i) => Object.fromEntries(names.map((name) => [name, columns[name][i]])));
}

/** The pooled statistics of a report, ready to be asked. */
export class Statistics {
  constructor(report) {
    this.rule = report.rule;
    this.sets = report.sets;
    this.solvers = report.solvers.length;
    this.cells = report.sets.map(() => []);
    for (const cell of rowsOf(report.cells)) {
      cell.taken = cell.met - cell.refused;
      this.cells[cell.set].push(cell);
    }
    this.pairs = new Map();  // each pair's rows, by error: a row holds until the next one
    const { at, ...pairs } = report.pairs;
    const rows = rowsOf(at);
    let first = 0;
    for (const pair of rowsOf(pairs)) {
      this.pairs.set(this.key(pair.set, pair.a, pair.b), rows.slice(first, first += pair.rows));
    }
  }

  key(set, a, b) {
    return (set * this.solvers + a) * this.solvers + b;
  }

  /** What two solvers did on the problems of the sets that both took, seen from `a`. */
  pair(sets, error, a, b) {
    const pooled = { onlyA: 0, onlyB: 0, falseA: 0, falseB: 0, n: 0, sum: 0, squareSum: 0 };
    const ordered = a < b;
    for (const set of sets) {
      const rows = this.pairs.get(this.key(set, Math.min(a, b), Math.max(a, b)));
      const row = rows?.findLast((each) => each.error <= error);
      if (!row) continue;
      pooled.onlyA += ordered ? row.only_a : row.only_b;
      pooled.onlyB += ordered ? row.only_b : row.only_a;
      pooled.falseA += ordered ? row.false_a : row.false_b;
      pooled.falseB += ordered ? row.false_b : row.false_a;
      pooled.n += row.n;
      pooled.sum += ordered ? row.log_sum : -row.log_sum;
      pooled.squareSum += row.log_square_sum;
    }
    return pooled;
  }

  /** Time of b over that of a on the problems that both solved; `shown` where these are enough. */
  factor(sets, error, a, b) {
    const pooled = this.pair(sets, error, a, b);
    return { ...geometricMean(pooled), shown: pooled.n >= this.rule.least_problems };
  }

  /** One solver's numbers over the sets; null where it took no problem of them. */
  pool(sets, error, solver) {
    const record = {
      solver, cells: [], met: 0, refused: 0, taken: 0, unsolvable: 0, crashed: 0, gaveUp: 0, solved: 0, false: 0,
      otherModel: false, p99: NaN,
    };
    const time = { n: 0, sum: 0, squareSum: 0 };
    for (const set of sets) {
      const cell = this.cells[set].find((each) => each.solver === solver);
      if (!cell) continue;
      for (const name of ["met", "refused", "taken", "unsolvable", "crashed"]) record[name] += cell[name];
      if (!cell.taken) continue;
      record.cells.push(cell);
      record.gaveUp += cell.gave_up;
      record.solved += cell.solved[error];
      record.false += cell.false[error];
      record.otherModel ||= cell.other_model;
      time.n += cell.time_n;
      time.sum += cell.time_log_sum;
      time.squareSum += cell.time_log_square_sum;
      const p99 = cell.no_number ? Infinity : cell.error_p99 ?? NaN;  // null: nothing said solved, or two measures
      if (!Number.isNaN(p99) && !(record.p99 >= p99)) record.p99 = p99;
    }
    if (!record.cells.length) return null;
    record.of = record.taken - record.unsolvable;
    record.share = record.of ? record.solved / record.of : NaN;
    record.interval = wilson(record.solved, record.of);
    record.sureShare = wilson(record.solved, record.of + record.refused).low;
    record.time = geometricMean(time);
    record.metAllSets = record.cells.length === sets.length;
    return record;
  }

  /** Judges the solvers on all the sets together: {records, recommended, best, plan, most}; the one to use first. */
  choose(sets, solvers, error) {
    const records = [...(solvers ?? Array(this.solvers).keys())].sort((a, b) => a - b)
      .map((solver) => this.pool(sets, error, solver)).filter(Boolean);
    const mostTaken = Math.max(0, ...records.map(({ taken }) => taken));
    const half = ({ taken }) => 2 * taken >= mostTaken;
    let best = null;
    for (const record of records) {
      if (record.otherModel || !record.time.n || !record.metAllSets || !half(record) || !record.solved) continue;
      if (!best || record.interval.low > best.interval.low) best = record;
    }
    const plan = this.planShare(sets);
    for (const record of records) record.ground = this.ground(record, { best, sets, error, plan, half: half(record) });
    const orLast = (value) => (Number.isNaN(value) ? Infinity : value);
    const compare = (a, b) => (a === b ? 0 : a < b ? -1 : 1);
    records.sort((a, b) =>
      compare(orLast(-a.sureShare), orLast(-b.sureShare)) || compare(orLast(a.time.value), orLast(b.time.value)) ||
      a.solver - b.solver);
    const mayBeUsed = (record) => record.ground === "reliable" && !record.refused;
    let recommended = null;
    for (const record of records) {
      if (mayBeUsed(record) && (!recommended || record.time.value < recommended.time.value)) recommended = record;
    }
    if (recommended) {
      records.splice(records.indexOf(recommended), 1);
      for (const record of records) {
        record.factor = this.factor(sets, error, recommended.solver, record.solver);
        record.tie = mayBeUsed(record) && !record.false && record.factor.shown && isTie(record.factor);
      }
      records.unshift(recommended);
    }
    return { sets, error, records, recommended, best, plan, most: Math.max(0, ...records.map(({ of }) => of)) };
  }

  /** Share of the answers planned for the sets that are there; 1 where nobody knows. */
  planShare(sets) {
    const sum = (name) => sets.reduce((total, set) => total + (this.sets[set][name] ?? 0), 0);
    return sum("planned") > 0 ? sum("done") / sum("planned") : 1;
  }

  /** "reliable", or why not. A false claim that was seen counts at any number of problems. */
  ground(record, { best, sets, error, plan, half }) {
    const { rule } = this;
    const pair = best && best !== record ? this.pair(sets, error, best.solver, record.solver) : null;
    const more = (first, second) => pair !== null && pair[first] > pair[second]
      && mcnemar(pair[first], pair[second]) < rule.paired_test_level;
    const bounded = wilson(record.false, record.taken).high <= rule.false_claims_high_at_most;
    if (record.false > 0 && (more("falseB", "falseA") || !bounded)) return "false_claims";
    if (record.otherModel) return "other_model";
    if (!record.metAllSets) return "some_sets";
    if (!(record.refused / record.met <= rule.refused_at_most)) return "refuses";
    if (!record.time.n) return "no_time";
    if (record.of < rule.least_problems) return "few_problems";
    if (!(record.interval.high >= rule.solved_low_at_least)) return "unsolved";
    if (more("onlyA", "onlyB")) return "behind_the_best";
    if (!half) return "small_sample";
    if (plan < rule.plan_at_least && record.of < rule.ample_problems) return "short_of_plan";
    if (!(record.interval.low >= rule.solved_low_at_least)) return "wide_interval";
    return "reliable";
  }
}

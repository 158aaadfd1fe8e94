// Numbers as people read them. Absent numbers are an en dash.

const absent = "–";
const isNumber = (value) => typeof value === "number" && Number.isFinite(value);

function percentNumber(share) {
  const value = 100 * share;
  if (value <= 0) return "0";
  if (value >= 100) return "100";
  if (value < 0.01) return "<0.01";
  if (value > 99.99) return ">99.99";
  return value.toFixed(value < 1 || value > 99.9 ? 2 : 1);
}

export const percent = (share) => (isNumber(share) ? `${percentNumber(share)} %` : absent);

export const percentRange = ({ low, high }) =>
  isNumber(low) && isNumber(high) ? `${percentNumber(low)}–${percentNumber(high)} %` : absent;

/** A share with its count. Few problems have no percentage: 1 of 5 is not 20 %. */
export function share(part, whole, least) {
  if (!whole) return absent;
  return whole < least ? `${count(part)} of ${count(whole)}` : `${percent(part / whole)} of ${count(whole)}`;
}

export const threeDigits = (value) => value.toFixed(value < 9.995 ? 2 : value < 99.95 ? 1 : 0);

const units = [[1, "s"], [1e-3, "ms"], [1e-6, "µs"], [1e-9, "ns"]];
const unitOf = (seconds) => units.find(([size]) => seconds >= 0.9995 * size) ?? units.at(-1);

export function duration(seconds) {
  if (!isNumber(seconds)) return absent;
  const [size, name] = unitOf(seconds);
  return `${threeDigits(seconds / size)} ${name}`;
}

export function durationRange({ low, high }) {
  if (!isNumber(low) || !isNumber(high)) return absent;
  const [size, name] = unitOf(high);
  if (low < 0.1 * size) return `${duration(low)}–${duration(high)}`;
  return `${threeDigits(low / size)}–${threeDigits(high / size)} ${name}`;
}

/** A ratio, to two digits below 1, else to three: "0.0089", "3.10", "12,300". */
export function factor(value) {
  if (!isNumber(value)) return absent;
  if (value < 1) return String(Number(value.toPrecision(2)));
  return value < 999.5 ? threeDigits(value) : count(Number(value.toPrecision(3)));
}

/** A ratio of times in words: "3.10× slower". */
export function speed(ratio) {
  if (!isNumber(ratio) || ratio <= 0) return absent;
  if (ratio > 1 / 1.05 && ratio < 1.05) return "same time";
  return ratio < 1 ? `${factor(1 / ratio)}× faster` : `${factor(ratio)}× slower`;
}

/** An error, to two digits: "1.5e-11", and without exponent from 0.1 to 1000. Infinity stands for answers that have no
 *  finite error. */
export function scientific(value) {
  if (value === Infinity) return "no number";
  if (!isNumber(value)) return absent;
  if (value === 0 || (value >= 0.1 && value < 1000)) return String(Number(value.toPrecision(2)));
  return value.toExponential(1).replace("e+", "e");
}

/** "1,234" */
export const count = (value) => (isNumber(value) ? value.toLocaleString("en-US", { maximumFractionDigits: 0 })
  : absent);

export const counted = (number, noun) => `${count(number)} ${noun}${number === 1 ? "" : "s"}`;

/** "a, b and c" */
export const list = (words) => new Intl.ListFormat("en-GB").format(words);

/** A value of any table, rounded for reading; its full digits are in the CSV. */
export function plain(value) {
  if (value === null || value === undefined || value === "") return absent;
  if (typeof value === "boolean") return value ? "yes" : "no";
  if (typeof value !== "number") return String(value);
  if (Number.isInteger(value)) return Math.abs(value) < 1e15 ? count(value) : value.toExponential(3);
  const size = Math.abs(value);
  return size < 1e-3 || size >= 1e6 ? value.toExponential(2).replace("e+", "e") : String(Number(value.toPrecision(4)));
}

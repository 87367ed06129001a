/**
 * Formatting of numbers: virtual times, velocities, positions.
 */

const PS = 1e12; // picoseconds of a second
/** @type {[number, string][]} */
const UNITS = [[1e12, "s"], [1e9, "ms"], [1e6, "µs"], [1e3, "ns"], [1, "ps"]];
const THIN = "\u2009";
const MINUS = "\u2212";

/**
 * Return an instant in seconds, to the microsecond, its digits in groups: 12.345 678.
 * @param {number} ps
 * @returns {string}
 */
export function clock(ps) {
  const [whole, part] = (ps / PS).toFixed(6).split(".");
  return `${grouped(whole)}.${part.slice(0, 3)}${THIN}${part.slice(3)}`;
}

/**
 * Return a time in the unit that suits it: 151.996 ms.
 * @param {number} ps
 * @returns {string}
 */
export function readable(ps) {
  const size = Math.abs(ps);
  const [unit, name] = UNITS.find(([one]) => size >= one) ?? UNITS[0];
  return `${Number((ps / unit).toPrecision(6))} ${name}`;
}

/**
 * Return a time in the form of a request.
 * @param {number} ps
 * @returns {string}
 */
export function asTime(ps) {
  return `${Math.max(0, Math.round(ps))} ps`;
}

/**
 * Return a typed time, for a request; a number without a unit is an error.
 * @param {string} text
 * @returns {string}
 */
export function writtenTime(text) {
  const bare = text.trim().replace(",", ".");
  if (/^[\d.]+$/.test(bare)) throw new Error(`time ${text.trim()} has no unit; write ${bare} ms or ${bare} s`);
  return bare.replace(/^([\d.]+)\s*(\D+)$/, "$1 $2").replace("µs", "us");
}

/**
 * Return a typed time in picoseconds; NaN if it is not a time.
 * @param {string} text
 * @returns {number}
 */
export function picoseconds(text) {
  const [, number, name] = writtenTime(text).match(/^([\d.]+) (\D+)$/) ?? [];
  const unit = UNITS.find(([, one]) => one === (name === "us" ? "µs" : name));
  return unit ? Number(number) * unit[0] : NaN;
}

/**
 * Return a whole number with its digits in groups, and a proper minus.
 * @param {number | string} value
 * @returns {string}
 */
export function grouped(value) {
  return String(value).replace(/\B(?=(\d{3})+(?!\d))/g, THIN).replace("-", MINUS);
}

/**
 * Return a value of a register or a reading; null and undefined mean no value.
 * @param {unknown} value
 * @returns {string}
 */
export function shown(value) {
  if (value === null || value === undefined) return "\u2013";
  if (typeof value !== "number") return String(value);
  return Number.isInteger(value) ? grouped(value) : String(Number(value.toPrecision(7))).replace("-", MINUS);
}

/**
 * Return a velocity, in steps per second.
 * @param {unknown} value
 * @returns {string}
 */
export function velocity(value) {
  if (typeof value !== "number") return shown(value);
  const [whole, part] = value.toFixed(Math.abs(value) >= 1000 ? 0 : 1).split(".");
  return `${grouped(whole)}${part ? `.${part}` : ""}`.replace(/^\u22120(\.0)?$/, "0$1");
}

/**
 * Return a rate: 0.01×.
 * @param {number} rate
 * @returns {string}
 */
export function times(rate) {
  return `${grouped(rate)}×`;
}

/**
 * Return a typed whole number; any other text is an error.
 * @param {string} text
 * @param {string} name of the value, for the message
 * @returns {number}
 */
export function wholeNumber(text, name) {
  const number = Number(text.replace("\u2212", "-").replace(/\s/g, "") || NaN);
  if (!Number.isSafeInteger(number)) throw new Error(`${name} ${text.trim()}: expected a whole number, such as 400`);
  return number;
}

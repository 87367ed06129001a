/**
 * Formatting of numbers as on an instrument: times, rates and values with units, and the ticks of a scale.  No drawing here.
 *
 * Times are picoseconds, as on the control port.
 */

export const SECOND = 1e12;
const NARROW = "\u202f"; // a narrow no-break space
const MINUS = "\u2212";

/** @type {[number, string][]} */
const TIMES = [
  [SECOND, "s"],
  [1e9, "ms"],
  [1e6, "\u00b5s"],
  [1e3, "ns"],
  [1, "ps"],
];
/** @type {[number, string][]} */
const SCALES = [
  [1e9, "G"],
  [1e6, "M"],
  [1e3, "k"],
  [1, ""],
  [1e-3, "m"],
];

/**
 * Return a number with `digits` significant digits, without trailing zeros of a fraction.
 * @param {number} value
 * @param {number} digits
 * @returns {string}
 */
export function digitsOf(value, digits) {
  if (value === 0 || !Number.isFinite(value)) return value === 0 ? "0" : "\u2013";
  const size = Math.floor(Math.log10(Math.abs(value)));
  const text = value.toFixed(Math.min(Math.max(digits - 1 - size, 0), 12));
  return (text.includes(".") ? text.replace(/\.?0+$/, "") : text).replace("-", MINUS);
}

/**
 * Return a duration in a suitable unit: 12.5 ms.
 * @param {number} ps
 * @param {number} [digits]
 * @returns {string}
 */
export function timeText(ps, digits = 4) {
  const size = Math.abs(ps);
  const [unit, name] = TIMES.find(([one]) => size >= one) ?? (ps ? TIMES[4] : TIMES[0]);
  return `${digitsOf(ps / unit, digits)} ${name}`;
}

/**
 * Return an instant in seconds, with the decimals of a resolution, in groups of three.
 * @param {number} ps
 * @param {number} resolutionPs
 * @returns {string}
 */
export function instantText(ps, resolutionPs) {
  const decimals = Math.min(Math.max(Math.ceil(-Math.log10(Math.max(resolutionPs, 1) / SECOND) - 1e-9), 0), 12);
  const [whole, part = ""] = (Math.abs(ps) / SECOND).toFixed(decimals).split(".");
  const groups = part.match(/\d{1,3}/g) ?? [];
  const sign = ps < 0 ? MINUS : "";
  return `${sign}${whole}${groups.length ? "." : ""}${groups.join(NARROW)} s`;
}

/**
 * Return the rate, in Hz, kHz or MHz, of an event with a given period.
 * @param {number} ps
 * @returns {string}
 */
export function rateText(ps) {
  return ps ? `${scaledText(SECOND / Math.abs(ps), 4)}Hz` : "\u2013";
}

/**
 * Return a number with a prefix of its unit: "12.5 k".
 * @param {number} value
 * @param {number} digits
 * @returns {string}
 */
function scaledText(value, digits) {
  const [scale, prefix] = SCALES.find(([one]) => Math.abs(value) >= one) ?? SCALES[3];
  return `${digitsOf(value / scale, digits)} ${prefix}`;
}

/**
 * Return a value with its unit.
 * @param {number | null} value
 * @param {string} unit
 * @returns {string}
 */
export function valueText(value, unit) {
  if (value === null || !Number.isFinite(value)) return "\u2013";
  return `${digitsOf(value, Math.abs(value) >= 1e5 ? 12 : 5)}${unit ? ` ${unit}` : ""}`;
}

/**
 * Return the step of a scale, 1, 2 or 5 times a power of ten, that divides a span into at most `parts` parts.
 * @param {number} span
 * @param {number} parts
 * @returns {number}
 */
export function niceStep(span, parts) {
  const raw = span / Math.max(parts, 1);
  if (!(raw > 0)) return 1;
  const power = 10 ** Math.floor(Math.log10(raw) + 1e-9);
  for (const factor of [1, 2, 5]) if (raw <= factor * power * (1 + 1e-9)) return factor * power;
  return 10 * power;
}

/**
 * Return the ticks of a scale from one value to another.
 * @param {number} low
 * @param {number} high
 * @param {number} parts maximum number of ticks
 * @returns {number[]}
 */
export function ticks(low, high, parts) {
  const step = niceStep(high - low, parts);
  const found = [];
  for (let n = Math.ceil(low / step - 1e-9) || 0; n * step <= high + step * 1e-9; n++) found.push(n * step);
  return found;
}

/**
 * Return the ticks of a ruler of time.  If the window is far from 0 for its size, they are relative to a base.
 * @param {number} start
 * @param {number} stop
 * @param {number} parts
 * @returns {{base: number, ticks: {ps: number, text: string}[], minor: number}}
 */
export function timeTicks(start, stop, parts) {
  const step = Math.max(niceStep(stop - start, parts), 1);
  const first = Math.ceil(start / step - 1e-9) || 0; // no -0
  const count = Math.floor(stop / step + 1e-9) - first + 1;
  const far = start > 0 && Math.abs(stop) / step > 2000;
  const base = far ? first * step : 0;
  const found = [];
  for (let n = 0; n < Math.min(count, 200); n++) {
    const ps = (first + n) * step;
    const text = far ? (n ? `+${timeText(n * step)}` : "0") : timeText(ps);
    found.push({ ps, text });
  }
  return { base, ticks: found, minor: step / (String(step)[0] === "2" ? 4 : 5) };
}

/**
 * Return a slightly wider range with round ends; for a single value it is narrow.
 * @param {number} low
 * @param {number} high
 * @returns {[number, number]}
 */
export function roundRange(low, high) {
  if (high - low < 1e-9) return [low - 1, high + 1];
  const step = niceStep(high - low, 4);
  return [Math.floor(low / step + 1e-9) * step, Math.ceil(high / step - 1e-9) * step];
}

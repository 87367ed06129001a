/**
 * Where the pins of a part are: which packages it has, and which pins are on which side of them.  No drawing here.
 *
 *      DIP                     PLCC, counted from the middle of its upper side
 *    1 |‾u‾| 8                    3 2 1 12 11
 *    2 |   | 7                  4 |‾‾‾‾‾‾‾| 10
 *    3 |   | 6                    |       |
 *    4 |___| 5                    5 6 7 8 9
 */

/**
 * @typedef {object} Pin as `describe` has it
 * @property {number} number 0: not known
 * @property {string} name
 * @property {string} way in, out, both, power, none
 * @property {string} says
 * @property {0 | 1 | null} active
 * @property {string} [role]
 * @property {number} [axis]
 * @property {string} [where]
 */

/**
 * @typedef {object} Package
 * @property {string} name empty, if there is one only
 * @property {boolean} numbered are the numbers of its pins known?
 * @property {boolean} square pins on four sides
 * @property {(Pin | number)[][]} sides left, right of a DIP; left, bottom, right, top of a square one: each from top to
 *    bottom or from left to right; a number is a pin that is not in the sheet
 * @property {Pin[]} loose pins whose number is not known, of a package whose numbers are
 */

const SIZES = [8, 14, 16, 18, 20, 24, 28, 38, 40, 44, 48, 64, 68, 84];
const LARGEST_DIP = 40;

/**
 * Return the pins of each package.  A chipset says in `where` to which one a pin belongs; without it, its pins without
 * a signal have the package before their name, and a package ends with the last one of these.
 * @param {Pin[]} pins
 * @returns {Map<string, Pin[]>}
 */
export function byPackage(pins) {
  /** @type {Map<string, Pin[]>} */
  const found = new Map();
  const numbers = pins.map((pin) => pin.number).filter(Boolean);
  if (new Set(numbers).size === numbers.length) return found.set("", pins);
  const prefix = (/** @type {Pin} */ pin) =>
    pin.way === "in" || pin.way === "out" || pin.way === "both" ? "" : (/^([a-z]+)_/.exec(pin.name)?.[1] ?? "");
  pins.forEach((pin, index) => {
    const next = pins.slice(index).find((other) => prefix(other));
    const name = /^(.+? chip)\b/.exec(pin.where ?? "")?.[1] ?? (next ? `${chipName(prefix(next))} chip` : "");
    found.set(name, [...(found.get(name) ?? []), pin]);
  });
  return found;
}

/**
 * @param {string} prefix
 * @returns {string}
 */
function chipName(prefix) {
  return prefix === "io" ? "I/O" : prefix.toUpperCase();
}

/**
 * Return the packages of a part.
 * @param {Pin[]} pins
 * @returns {Package[]}
 */
export function packages(pins) {
  return [...byPackage(pins)].map(([name, own]) => arranged(name, own));
}

/**
 * @param {string} name
 * @param {Pin[]} pins
 * @returns {Package}
 */
function arranged(name, pins) {
  const known = pins.filter((pin) => pin.number > 0);
  const numbered = known.length > 0;
  if (!numbered) {
    const half = Math.ceil(pins.length / 2);
    return { name, numbered, square: false, sides: [pins.slice(0, half), pins.slice(half)], loose: [] };
  }
  const highest = Math.max(...known.map((pin) => pin.number));
  const count = SIZES.find((size) => size >= highest) ?? highest + (highest % 2);
  const at = new Map(known.map((pin) => [pin.number, pin]));
  const one = (/** @type {number} */ number) => at.get(number) ?? number;
  const run = (/** @type {number} */ first, /** @type {number} */ last) => {
    const step = first <= last ? 1 : -1;
    return Array.from({ length: Math.abs(last - first) + 1 }, (_, n) => one(first + step * n));
  };
  const loose = pins.filter((pin) => !pin.number);
  if (count <= LARGEST_DIP) {
    return { name, numbered, square: false, sides: [run(1, count / 2), run(count, count / 2 + 1)], loose };
  }
  const side = count / 4;
  const top = Math.ceil(side / 2); // pin 1 is in the middle of the upper side, the first ones left of it
  const sides = [
    run(top + 1, top + side),
    run(top + side + 1, top + 2 * side),
    run(top + 3 * side, top + 2 * side + 1),
    [...run(top, 1), ...run(count, top + 3 * side + 1)],
  ];
  return { name, numbered, square: true, sides, loose };
}

/**
 * Return the two rows in which a package is drawn where there is no room for four: the same order round it.
 * @param {Package} one
 * @returns {(Pin | number)[][]}
 */
export function twoRows(one) {
  if (!one.square) return one.sides;
  const [left, bottom, right, top] = one.sides;
  const first = Math.ceil(top.length / 2); // pin 1 and the next ones, from right to left
  const below = Math.floor(bottom.length / 2);
  return [
    [...top.slice(0, first).reverse(), ...left, ...bottom.slice(0, below)],
    [...top.slice(first), ...right, ...bottom.slice(below).reverse()],
  ];
}

const WAYS = { in: "input", out: "output", both: "input and output", power: "supply", none: "no signal" };

/**
 * Return the way of a pin in a word or two.
 * @param {Pin} pin
 * @returns {string}
 */
export function wayText(pin) {
  return WAYS[/** @type {keyof typeof WAYS} */ (pin.way)] ?? pin.way;
}

/**
 * Return a level in a word.
 * @param {number | null | undefined} level
 * @returns {string}
 */
export function levelText(level) {
  return level === 1 ? "high" : level === 0 ? "low" : "floating";
}

/**
 * Return whether a pin carries a signal of the model.
 * @param {Pin} pin
 * @returns {boolean}
 */
export function hasSignal(pin) {
  return pin.way === "in" || pin.way === "out" || pin.way === "both";
}

/**
 * Return the level that a press puts on a pin: the active one; where it has that already, or has none, the other one.
 * @param {Pin} pin
 * @param {number | null | undefined} level
 * @returns {0 | 1}
 */
export function pressedLevel(pin, level) {
  if (pin.active !== null && pin.active !== undefined && level !== pin.active) return pin.active;
  return level === 1 ? 0 : 1;
}

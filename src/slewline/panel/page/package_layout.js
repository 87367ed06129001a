/** The positions of the pins on the packages of a part, from `describe`, and their functions.  No drawing here. */

/**
 * @typedef {object} Pin in the format of `describe`
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
 * @property {string} name empty, if there is only one
 * @property {boolean} numbered whether the numbers of its pins are known
 * @property {boolean} square pins on four sides
 * @property {(Pin | number)[][]} sides left, right of a DIP; left, bottom, right, top of a square one: each from top to
 *    bottom or from left to right; a number is a pin that is not in the sheet
 * @property {Pin[]} loose pins with unknown numbers, on a package with otherwise known ones
 */

/**
 * Return the packages of a part, with pins instead of pin names.
 * @param {{pins: Pin[], packages: any[]}} sheet in the format of `describe`
 * @returns {Package[]}
 */
export function packages(sheet) {
  const pins = new Map(sheet.pins.map((pin) => [pin.name, pin]));
  const placed = (/** @type {string | number} */ one) => (typeof one === "number" ? one : pins.get(one));
  return sheet.packages.map((one) => ({
    ...one,
    sides: one.sides.map((/** @type {(string | number)[]} */ side) => side.map(placed)),
    loose: one.loose.map(placed),
  }));
}

/**
 * Return the two rows of a package for a layout too narrow for four sides, in the same order round it.
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

const IN_OUT = { in: "input", out: "output", both: "input and output", power: "supply", none: "no signal" };

/**
 * Return the direction of a pin in a word or two.
 * @param {Pin} pin
 * @returns {string}
 */
export function inOutText(pin) {
  return IN_OUT[/** @type {keyof typeof IN_OUT} */ (pin.way)] ?? pin.way;
}

/**
 * Return the word for a level.
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
 * Return the level that a press drives: the active one, or the opposite of the present level if it is already active or
 * the pin has no active level.
 * @param {Pin} pin
 * @param {number | null | undefined} level
 * @returns {0 | 1}
 */
export function pressedLevel(pin, level) {
  if (pin.active !== null && pin.active !== undefined && level !== pin.active) return pin.active;
  return level === 1 ? 0 : 1;
}

import assert from "node:assert/strict";
import { test } from "node:test";

import { packages, pressedLevel, twoRows } from "../../../src/slewline/panel/page/package_layout.js";

const pin = (number, name = `p${number}`, way = "in", more = {}) => ({ number, name, way, says: "", active: null, ...more });
const many = (count) => Array.from({ length: count }, (_, n) => pin(n + 1));
const numbers = (side) => side.map((one) => (typeof one === "number" ? one : one.number));

test("a package of 40 pins has two rows", () => {
  const [one, ...others] = packages(many(40));
  assert.equal(others.length, 0);
  assert.equal(one.square, false);
  assert.deepEqual(numbers(one.sides[0]).slice(0, 2), [1, 2]);
  assert.deepEqual([numbers(one.sides[1])[0], numbers(one.sides[1]).at(-1)], [40, 21]);
});

test("a package of 68 pins has four sides, pin 1 in the middle of the upper one", () => {
  const [one] = packages(many(68));
  const [left, bottom, right, top] = one.sides.map(numbers);
  assert.deepEqual([left[0], left.at(-1)], [10, 26]);
  assert.deepEqual([bottom[0], bottom.at(-1)], [27, 43]);
  assert.deepEqual([right[0], right.at(-1)], [60, 44]);
  assert.deepEqual([top[0], top[8], top[9], top.at(-1)], [9, 1, 68, 61]);
  assert.deepEqual(twoRows(one).map(numbers), [many(34).map((each) => each.number), many(68).map((each) => each.number).slice(34).reverse()]);
});

test("a chipset has several packages, by what its pins say or by their names", () => {
  const pins = [pin(1, "pulse1"), pin(2, "io_vcc2", "power"), pin(2, "atrest1"), pin(1, "cp_gnd1", "power")];
  assert.deepEqual(packages(pins).map((one) => one.name), ["I/O chip", "CP chip"]);
  const told = pins.map((each, n) => ({ ...each, where: `${n < 2 ? "I/O" : "CP"} chip; pin descriptions` }));
  assert.deepEqual(packages(told).map((one) => one.name), ["I/O chip", "CP chip"]);
});

test("pins without a number are in the order of the manual, or beside the package", () => {
  const [unknown] = packages([pin(0, "a"), pin(0, "b"), pin(0, "c")]);
  assert.equal(unknown.numbered, false);
  assert.deepEqual(unknown.sides.map((side) => side.map((each) => each.name)), [["a", "b"], ["c"]]);
  const [some] = packages([...many(8), pin(0, "late")]);
  assert.deepEqual(some.loose.map((each) => each.name), ["late"]);
});

test("a press puts the active level on a pin, or the other one where it is there", () => {
  assert.equal(pressedLevel(pin(1, "a", "in", { active: 0 }), 1), 0);
  assert.equal(pressedLevel(pin(1, "a", "in", { active: 0 }), 0), 1);
  assert.equal(pressedLevel(pin(1, "a"), 1), 0);
  assert.equal(pressedLevel(pin(1, "a"), null), 1);
});

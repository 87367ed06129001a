import assert from "node:assert/strict";
import { test } from "node:test";

import { packages, pressedLevel, twoRows } from "../../../src/slewline/panel/page/package_layout.js";

const pin = (number, name = `p${number}`, way = "in", more = {}) => ({ number, name, way, says: "", active: null, ...more });
const many = (count) => Array.from({ length: count }, (_, n) => pin(n + 1));
const numbers = (side) => side.map((one) => (typeof one === "number" ? one : one.number));

const placed = (pins, ...some) => packages({ pins, packages: some });
const run = (first, last) => Array.from({ length: Math.abs(last - first) + 1 }, (_, n) => `p${first + Math.sign(last - first) * n}`);

test("pins are in the place of their names, and pins outside the sheet keep their number", () => {
  const [one] = placed(many(3), { name: "", square: false, sides: [["p1", "p2"], [4, "p3"]], loose: ["p2"] });
  assert.deepEqual(one.sides.map(numbers), [[1, 2], [4, 3]]);
  assert.deepEqual(one.loose.map((each) => each.name), ["p2"]);
});

test("a package with four sides is in two rows where there is no room, in the same order round it", () => {
  const sides = [run(10, 26), run(27, 43), run(60, 44), [...run(9, 1), ...run(68, 61)]];
  const [one] = placed(many(68), { name: "", square: true, sides, loose: [] });
  assert.deepEqual(twoRows(one).map(numbers), [many(34).map((each) => each.number), many(68).map((each) => each.number).slice(34).reverse()]);
});

test("a press puts the active level on a pin, or the other one where it is there", () => {
  assert.equal(pressedLevel(pin(1, "a", "in", { active: 0 }), 1), 0);
  assert.equal(pressedLevel(pin(1, "a", "in", { active: 0 }), 0), 1);
  assert.equal(pressedLevel(pin(1, "a"), 1), 0);
  assert.equal(pressedLevel(pin(1, "a"), null), 1);
});

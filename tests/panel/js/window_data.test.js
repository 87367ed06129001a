import assert from "node:assert/strict";
import { test } from "node:test";

import { decoded, extent, lastBefore, levelAt, nearestEdge, valueAt, zoomed } from "../../../src/slewline/panel/page/window_data.js";

const edges = decoded({ kind: "pin", since_ps: 0, times_ps: [0, 10, 20, 30], levels: [0, 1, null, 0] }, 0, 100);
const columns = decoded({ kind: "pin", since_ps: 20, columns: "--01x1" }, 0, 60);
const curve = { kind: "quantity", unit: "steps", held: true, times_ps: [0, 10, 20, 30], values: [1, 5, null, 7] };

test("the level of a pin at an instant, from its edges", () => {
  assert.deepEqual([0, 9, 10, 25, 99].map((ps) => levelAt(edges, ps)), ["0", "0", "1", "-", "0"]);
  assert.equal(levelAt(edges, 101), "");
});

test("the level of a pin at an instant, from columns", () => {
  assert.deepEqual([5, 20, 39, 41, 60].map((ps) => levelAt(columns, ps)), ["", "0", "1", "x", "1"]);
});

test("a pin that is not recorded has no level", () => {
  const trace = decoded({ kind: "pin", error: "not recorded" }, 0, 10);
  assert.equal(levelAt(trace, 5), "");
  assert.equal(nearestEdge(trace, 5, 100), null);
});

test("the nearest edge is one of the pin, and not the start of the window", () => {
  assert.equal(nearestEdge(edges, 2, 5), null);
  assert.equal(nearestEdge(edges, 13, 5), 10);
  assert.equal(nearestEdge(edges, 16, 5), 20);
  assert.equal(nearestEdge(columns, 30, 100), null);
});

test("a value lasts until the next one, a line leads there, a break has none", () => {
  const held = decoded(curve, 0, 40);
  assert.deepEqual([5, 10, 25, 35].map((ps) => valueAt(held, ps)), [1, 5, null, 7]);
  const lines = decoded({ ...curve, held: false }, 0, 40);
  assert.deepEqual([5, 12, 35].map((ps) => valueAt(lines, ps)), [3, 5, 7]);
});

test("the extent of a quantity in a window has what holds at its start", () => {
  const held = decoded(curve, 0, 40);
  assert.deepEqual(extent(held, 5, 8), [1, 1]);
  assert.deepEqual(extent(held, 0, 40), [1, 7]);
  assert.equal(extent(decoded({ kind: "quantity" }, 0, 40), 0, 40), null);
});

test("the last one before an instant", () => {
  assert.deepEqual([-1, 0, 5, 10, 99].map((ps) => lastBefore([0, 10, 20], ps)), [-1, 0, 0, 1, 2]);
});

test("a zoom keeps its place, within the bounds and from 0 on", () => {
  assert.deepEqual(zoomed(100, 200, 0.5, 150, 1, 1e9), [125, 175]);
  assert.deepEqual(zoomed(0, 100, 2, 50, 1, 1e9), [0, 200]);
  assert.deepEqual(zoomed(0, 100, 1e-9, 0, 10, 1e9), [0, 10]);
});

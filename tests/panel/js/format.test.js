import assert from "node:assert/strict";
import { test } from "node:test";

import { picoseconds, wholeNumber, writtenTime } from "../../../src/slewline/panel/page/format.js";

test("a typed time becomes a text for a request and a number of picoseconds", () => {
  for (const [text, written, ps] of [
    ["1.5 s", "1.5 s", 1.5e12], ["1,5 s", "1.5 s", 1.5e12], ["20ms", "20 ms", 2e10], ["3 µs", "3 us", 3e6], ["7 us", "7 us", 7e6],
  ]) {
    assert.equal(writtenTime(text), written);
    assert.equal(picoseconds(text), ps);
  }
});

test("a number without a unit is not a time", () => {
  for (const text of ["500", "1.5", "1,5", " 20 "]) {
    const number = text.trim().replace(",", ".");
    const says = `time ${text.trim()} has no unit; write ${number} ms or ${number} s`;
    assert.throws(() => picoseconds(text), new RegExp(`^Error: ${says.replaceAll(".", "\\.")}$`));
  }
});

test("an invalid time is not a number, so it is never sent", () => {
  for (const text of ["", "soon", "3 miles"]) assert.ok(Number.isNaN(picoseconds(text)));
});

test("a whole number may have blanks and a proper minus; anything else is reported", () => {
  for (const [text, number] of [["400", 400], [" 1 000 ", 1000], ["\u2212 7", -7], ["-7", -7]]) {
    assert.equal(wholeNumber(text, "position"), number);
  }
  for (const text of ["", " ", "abc", "1.5", "1e400", "0x"]) {
    assert.throws(() => wholeNumber(text, "position"), /^Error: position .*: expected a whole number, such as 400$/);
  }
});

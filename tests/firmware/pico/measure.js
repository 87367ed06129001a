// A known program of a PIO, in the PIO of rp2040js and in ours: edges of pin 3 in the first cycles.
//
//     node measure.js RP2040JS CYCLES WORD ...
"use strict";

const path = require("path");
const { Pio } = require("./pio.js");

const [, , place, cycles, ...words] = process.argv;
const { RP2040 } = require(path.resolve(place));
const PINCTRL = 0xdc, MEMORY = 0x48, FOR_PIN_3 = (1 << 26) | (3 << 5);

function load(pio) {
  words.forEach((word, at) => pio.writeUint32(MEMORY + 4 * at, Number(word)));
  pio.writeUint32(PINCTRL, FOR_PIN_3);
}

function theirs() {
  const mcu = new RP2040(), pio = mcu.pio[0], edges = [];
  mcu.logger = { debug() {}, info() {}, warn() {}, error() {} };
  load(pio);
  for (let cycle = 0, last = 0; cycle < cycles; cycle++) {
    pio.machines[0].step();
    const level = pio.pinValues >> 3 & 1;
    if (level !== last) edges.push([cycle, (last = level)]);
  }
  return edges;
}

function ours() {
  const edges = [];
  let last = 0;
  const board = { cycle: 0, interrupt() {}, edges(cycle) {
    const level = pio.pinValues >> 3 & 1;
    if (level !== last) edges.push([cycle, (last = level)]);
  } };
  const pio = new Pio(board, 0);
  load(pio);
  pio.writeUint32(0, 1);
  pio.run(Number(cycles));
  return edges;
}

process.stdout.write(JSON.stringify({ theirs: theirs(), ours: ours() }));

// Boards in an emulator, one request a line, in JSON:
//
//     node emulator.js RP2040JS IMAGE
//
// There is no wall clock, so the same requests always have the same answers.
"use strict";

const fs = require("fs");
const path = require("path");
const readline = require("readline");
const { Board } = require("./board.js");

const RXD = 8;

function answer(boards, make, image, request) {
  const index = request.board || 0;
  if (request.make || !boards[index]) {
    boards[index] = make();
    boards[index].load(image);
  }
  const board = boards[index];
  for (const [at, hex] of request.flash || []) board.flash.bytes.set(Buffer.from(hex, "hex"), at);
  if (request.times) [board.flash.eraseTime, board.flash.programTime] = request.times;
  for (const [pin, level] of request.straps || []) board.inputs[pin] = level;
  if (request.fail !== undefined) board.fail(request.fail);
  if (request.power) board.powerUp();
  for (const [pin, level, cycle] of request.inputs || []) board.set(pin, level, cycle);
  const told = {};
  told.until = (request.send || []).map(({ hex, bit, cycle, ...more }) =>
    board.send(RXD, Buffer.from(hex, "hex"), bit, cycle, more),
  );
  if (request.write) for (const [address, value] of request.write) board.mcu.writeUint32(address, value);
  if (request.run !== undefined) board.run(request.run);
  told.words = (request.words || []).map((address) => board.word(address));
  told.read = (request.read || []).map(([at, length]) => Buffer.from(board.flash.bytes.subarray(at, at + length)).toString("hex"));
  if (request.stack) told.stack = board.stack(...request.stack);
  told.now = board.cycle;
  told.changes = board.changes;
  told.resets = board.resets;
  told.asleep = board.asleep;
  told.fast = board.fast;
  told.refused = board.refused;
  told.notes = board.notes || [];
  told.clk = board.mcu?.clkSys;
  told.operations = board.flash.operations;
  told.pc = board.mcu?.core.PC;
  board.clear();
  return told;
}

function open(place, file) {
  const { RP2040 } = require(path.resolve(place));
  return { image: fs.readFileSync(file), make: () => new Board(RP2040) };
}

if (require.main === module) {
  const { image, make } = open(process.argv[2], process.argv[3]);
  const boards = [];
  readline.createInterface({ input: process.stdin }).on("line", (line) => {
    process.stdout.write(JSON.stringify(answer(boards, make, image, JSON.parse(line))) + "\n");
  });
}

module.exports = { open, answer };

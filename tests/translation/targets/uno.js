// An Arduino Uno in an emulator, for sketches: every change of a pin, with its time.
//
//     node uno.js AVR8JS SKETCH.hex < REQUEST
//
// The request is one object of JSON: `until`, virtual seconds at most; `inputs`, [seconds, pin, level] each, in order of
// time (an input without one is pulled up); `idle`, virtual seconds without a change of an output after which it ends.
// The answer: `changes`, [cycle, pin, level] each, `now`, the cycle at the end, and how many `timers` it has.  Pins have
// the numbers of Arduino: 0 to 13, A0 is 14.
"use strict";

const fs = require("fs");
const path = require("path");

const HZ = 16e6;
const avr = require(path.resolve(process.argv[2]));
const request = JSON.parse(fs.readFileSync(0, "latin1"));

const memory = new Uint8Array(0x8000).fill(0xff);
for (const line of fs.readFileSync(process.argv[3], "latin1").split(/\r?\n/)) {
  const bytes = Buffer.from(line.slice(1), "hex");
  if (line[0] === ":" && bytes[3] === 0) memory.set(bytes.subarray(4, 4 + bytes[0]), bytes.readUInt16BE(1));
}

const cpu = new avr.CPU(new Uint16Array(memory.buffer), 0x800);
const timers = [avr.timer0Config, avr.timer1Config, avr.timer2Config].map((each) => new avr.AVRTimer(cpu, each));
const configs = { 0: avr.portDConfig, 8: avr.portBConfig, 14: avr.portCConfig };
const ports = {};
const changes = [];
let last = 0; // the cycle of the last change of an output

const seen = { 0: 0, 8: 0, 14: 0 }; // what each port drives high
const driven = { 0: 0, 8: 0, 14: 0 }; // what was an output when it was looked at

function record(first, high) {
  for (let bit = 0, changed = high ^ seen[first]; changed >> bit; bit++)
    if ((changed >> bit) & 1) changes.push([cpu.cycles, Number(first) + bit, (high >> bit) & 1]);
  if (high !== seen[first]) last = cpu.cycles;
  seen[first] = high;
}

for (const [first, config] of Object.entries(configs)) {
  const port = (ports[first] = new avr.AVRIOPort(cpu, config));
  for (let bit = 0; bit < 8; bit++) port.setPin(bit, true); // pulled up
  port.addListener((value) => {
    // A pin of any port may have become an output, and high, without a change of its port.
    for (const [other, { PORT, DDR }] of Object.entries(configs)) {
      const fresh = cpu.data[DDR] & ~driven[other];
      driven[other] = cpu.data[DDR];
      if (fresh & cpu.data[PORT]) record(other, seen[other] | (fresh & cpu.data[PORT]));
    }
    record(first, value & cpu.data[config.DDR]); // with what a timer drives
  });
}

const inputs = request.inputs || [];
const end = request.until * HZ;
const idle = (request.idle || Infinity) * HZ;
while (cpu.cycles < end && cpu.cycles - last < idle) {
  while (inputs.length && inputs[0][0] * HZ <= cpu.cycles) {
    const [, pin, level] = inputs.shift();
    const first = pin < 8 ? 0 : pin < 14 ? 8 : 14;
    ports[first].setPin(pin - first, Boolean(level));
    last = cpu.cycles; // whoever waits for it has its time
  }
  avr.avrInstruction(cpu);
  cpu.tick();
}

const answer = { changes, now: cpu.cycles, timers: timers.length };
process.stdout.write(JSON.stringify(answer) + "\n");

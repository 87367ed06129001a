// An Arduino Uno in an emulator, for sketches: every change of a pin, with its time.
//
//     node uno.js AVR8JS SKETCH.hex < REQUEST
//
// The request is one object of JSON: `until`, virtual seconds at most; `inputs`, [seconds, pin, level] each, in order of
// time (an input without one is pulled up); `idle`, virtual seconds without a change of an output after which it ends;
// `serial`, text that the host sends, and `baud` of the line.  The answer: `changes`, [cycle, pin, level] each, `now`, the
// cycle at the end, and `serial`, what the sketch sent.  Pins have the numbers of Arduino: 0 to 13, A0 is 14.
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
const usart = new avr.AVRUSART(cpu, avr.usart0Config, HZ);
const ports = { 0: avr.portDConfig, 8: avr.portBConfig, 14: avr.portCConfig };
const changes = [];
let last = 0; // the cycle of the last change of an output

for (const [first, config] of Object.entries(ports)) {
  const port = (ports[first] = new avr.AVRIOPort(cpu, config));
  for (let bit = 0; bit < 6; bit++) port.setPin(bit, true); // pulled up
  if (first === "0") [6, 7].forEach((bit) => port.setPin(bit, true));
  port.addListener((value, before) => {
    const driven = cpu.data[config.DDR];
    for (let bit = 0; bit < 8; bit++) {
      if (!(((value ^ before) >> bit) & 1) || !((driven >> bit) & 1)) continue;
      changes.push([cpu.cycles, Number(first) + bit, (value >> bit) & 1]);
      last = cpu.cycles;
    }
  });
}

const sent = [];
usart.onByteTransmit = (byte) => sent.push(byte);
const host = [...Buffer.from(request.serial || "", "latin1")];
const aByte = (HZ * 10) / (request.baud || 115200);
let nextByte = 1.5 * HZ; // a boot loader and the start of the sketch take their time

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
  if (host.length && cpu.cycles >= nextByte && usart.rxEnable && !usart.rxBusy) {
    usart.writeByte(host.shift());
    nextByte = cpu.cycles + aByte;
    last = cpu.cycles;
  }
  avr.avrInstruction(cpu);
  cpu.tick();
}

const answer = { changes, now: cpu.cycles, timers: timers.length, serial: Buffer.from(sent).toString("latin1") };
process.stdout.write(JSON.stringify(answer) + "\n");

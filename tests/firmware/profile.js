// Where the cycles of the board go: loaded before emulator.js (node -r), it counts them by windows of 50 ms.
//
//     SLEWLINE_PROFILE=OUT.json SLEWLINE_MAIN=FROM,TO node -r ./profile.js emulator.js ...
//
// Of each window: cycles, cycles in interrupts, and how often each instruction of the main loop was run (FROM to TO, in
// words).  A board that is reset begins anew.
"use strict";

const fs = require("fs");
const Module = require("module");

const WINDOW = 800000;
const RETI = 0x9518;
const [from, to] = process.env.SLEWLINE_MAIN.split(",").map(Number);
let windows = [];
let depth = 0; // of interrupts
let last = 0; // the cycle behind the last instruction
let now = null;

function open(at) {
  now = { at, cycles: 0, interrupts: 0, main: new Array(to - from).fill(0) };
  windows.push(now);
}

function counted(instruction) {
  const does = (cpu) => {
    const begin = cpu.cycles;
    if (begin < last) {
      windows = []; // a reset
      depth = 0;
      last = begin;
      now = null;
    }
    if (now === null || begin >= now.at + WINDOW) open(begin);
    const pc = cpu.pc;
    const taken = begin - last; // four cycles, if an interrupt came in
    if (taken > 0) depth++;
    const leaves = cpu.progMem[pc] === RETI;
    if (depth === 0 && pc >= from && pc < to) now.main[pc - from]++;
    instruction(cpu);
    const spent = cpu.cycles - begin + taken;
    now.cycles += spent;
    if (depth > 0) now.interrupts += spent;
    if (leaves && depth > 0) depth--;
    last = cpu.cycles;
  };
  does.toString = () => ""; // the emulator chooses branches by the text of avr8js, and this is another one
  return does;
}

const load = Module._load;
Module._load = (request, ...more) => {
  const found = load(request, ...more);
  return /avr8js$/.test(request) ? { ...found, avrInstruction: counted(found.avrInstruction) } : found;
};

process.on("exit", () => fs.writeFileSync(process.env.SLEWLINE_PROFILE, JSON.stringify(windows)));

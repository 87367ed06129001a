// The board in an emulator: an ATmega328P at 16 MHz that runs the firmware, in lockstep with a test.
//
//     node emulator.js AVR8JS FIRMWARE.hex
//
// Each line of input is a request in JSON, each line of output its answer; there is no wall clock, so the same requests
// always have the same answers.  All instants are ticks: cycles since the firmware started timer 1.
//
// The instructions are avr8js's.  What is around them is ours, for avr8js 0.21 differs from the chip where it matters
// here:
//   - it tells of edges, and sees matches of a timer, at the end of an instruction; here they have their own cycle, and
//     a register that an instruction writes holds its old value until that instruction's last cycle;
//   - it receives into one byte; the chip has two, and a shift register behind them;
//   - a write to TIFR1 loses flags that it does not name;
//   - it clears UDRE when its interrupt is taken; the chip does when a byte is written;
//   - it takes an interrupt two cycles too fast, and right behind SEI or RETI, where the chip runs one more instruction.
"use strict";

const fs = require("fs");
const path = require("path");
const readline = require("readline");

const BYTE = 320; // cycles of a byte: ten bits at 500 kbaud
const RAM = 0x900; // registers and 2 KB
const PATTERN = 0xa5; // what RAM holds at power-up, so that the stack's depth can be seen

// Registers, as addresses of data.
const PINB = 0x23, DDRB = 0x24, PORTB = 0x25, PINC = 0x26, DDRC = 0x27, PORTC = 0x28, PIND = 0x29, DDRD = 0x2a, PORTD = 0x2b;
const TIFR1 = 0x36, PCIFR = 0x3b, PCICR = 0x68, PCMSK1 = 0x6c, TIMSK1 = 0x6f;
const TCCR0B = 0x45, TCNT0 = 0x46;
const TCCR1A = 0x80, TCCR1B = 0x81, TCCR1C = 0x82, TCNT1L = 0x84, TCNT1H = 0x85, OCR1AL = 0x88, OCR1AH = 0x89;
const UCSR0A = 0xc0, UCSR0B = 0xc1, UDR0 = 0xc6;
const SREG = 0x5f;

const OCF1A = 2, TOV1 = 1, STEP = 2, T0 = 0x10;
const RXC = 0x80, UDRE = 0x20, RXCIE = 0x80, UDRIE = 0x20;
const VECTORS = { pins: 0x08, match: 0x16, overflow: 0x1a, received: 0x24, empty: 0x26 }; // in words

/** Return the program memory that a file in Intel HEX describes. */
function readHex(text) {
  const memory = new Uint8Array(0x8000).fill(0xff);
  for (const line of text.split(/\r?\n/)) {
    const bytes = Buffer.from(line.slice(1), "hex");
    if (line[0] === ":" && bytes[3] === 0) memory.set(bytes.subarray(4, 4 + bytes[0]), bytes.readUInt16BE(1));
  }
  return new Uint16Array(memory.buffer);
}

/** Return what an instruction does, by the place in the program where it stands.
 *
 *  avr8js asks at every step which of some hundred branches is meant, and that is most of its time.  Here each branch is
 *  a function of its own, and is chosen once.  Where its text looks otherwise, it goes on asking.
 */
function decoded(whole, program) {
  const text = whole.toString();
  const [, opcode, asked, end] = text.match(/^    const (\w+) = [^\n]*\n(.*^    \})\n(.*)\}$/ms) || [];
  const branches = [...(asked || "").matchAll(/^    (?:else )?if \((.*?)\) \{\n(.*?)^    \}(?: |\n|$)/gms)];
  if (!asked || asked.match(/^    \}/gm).length !== branches.length) return Array.from(program, () => whole);
  const which = new Function(opcode, branches.map(([, meant], at) => `if (${meant}) return ${at};`).join("\n"));
  const made = branches.map(([, , does]) =>
    new Function("isTwoWordInstruction", `return (cpu, ${opcode}) => {\n${does}${end}};`)(isTwoWords),
  );
  return Array.from(program, (word) => made[which(word)] || whole);
}

/** Return whether LDS, STS, JMP or CALL is meant. */
function isTwoWords(opcode) {
  return (opcode & 0xfc0f) === 0x9000 || (opcode & 0xfe0c) === 0x940c;
}

class Board {
  constructor({ CPU, avrInstruction }, program) {
    this.instructions = decoded(avrInstruction, program);
    this.program = program;
    this.cpu = new CPU(program, RAM - 0x100);
    this.levels = 0x3f; // of the inputs: nothing is connected, pull-ups
    this.looped = false; // STEP to D4
    this.telling = false; // of rounds of the main loop: many
    this.#hook();
    this.powerUp();
  }

  powerUp() {
    const { cpu } = this;
    cpu.data.fill(0, 0, 0x100);
    cpu.data.fill(PATTERN, 0x100);
    cpu.reset();
    cpu.cycles = 0;
    this.origin = null; // the cycle of tick 0
    this.compare = 0; // OCR1A
    this.high = 0; // TEMP of the 16-bit registers
    this.timed = Infinity; // the next match
    this.overflow = Infinity;
    this.flags = 0; // TIFR1
    this.latch = 0; // OC1A
    this.changed = -9; // when STEP changed last
    this.pinFlag = false;
    this.counted = 0; // TCNT0
    this.line = []; // bytes on their way to the board: [cycle of the end, byte]
    this.lineFree = 0;
    this.edges = []; // of inputs to come: [cycle, input, level]
    this.fifo = [];
    this.shift = null; // a third byte, which waits
    this.shiftSince = 0;
    this.overruns = 0;
    this.sending = null; // the byte in the shift register that sends
    this.sendingUntil = Infinity;
    this.waiting = null; // the byte in UDR0
    this.vector = 0; // of the interrupt that is pending and comes first
    this.offSince = 0;
    this.offBy = "reset";
    this.lastRead = null; // the tick that the firmware read last
    this.watched = this.lookTick = null;
    this.off = {}; // longest times without interrupts, by what turned them off
    this.taken = {}; // how often an interrupt was taken
    this.clear();
    cpu.data[PINC] = this.levels;
    this.next = Infinity;
    while (this.origin === null) this.#step();
    this.inSync = true;
  }

  /** Forget what has been told. */
  clear() {
    this.rises = [];
    this.falls = [];
    this.lost = [];
    this.ports = []; // [tick, PORTB, DDRB, PORTD, DDRD]
    this.sent = []; // [tick, byte]
    this.looks = []; // [tick, levels]
    this.rounds = []; // ticks of the main loop
  }

  /** Tell of each look at the inputs, which is where the firmware writes `address`: the tick that it read before. */
  watch(address) {
    this.cpu.writeHooks[address] = (value, before) => {
      if (this.watched !== this.offSince) this.lookTick = this.lastRead;
      this.watched = this.offSince;
      for (let bit = 1; bit < 0x40 && this.lastRead !== null; bit <<= 1) // null: the start of the program
        if ((value ^ before) & bit) this.looks.push([this.lookTick, (before ^= bit)]);
      return false;
    };
  }

  /** Tell of each round of the main loop that looks at the time, and notes it at `address`. */
  watchRounds(address) {
    this.cpu.writeHooks[address] = () => {
      if (this.telling && this.lastRead !== null) this.rounds.push(this.lastRead);
      return false;
    };
  }

  /** Let so many times 65,536 ticks pass at once, in which the processor does nothing: `address` is its count of them. */
  skip(count, address) {
    const { data } = this.cpu;
    while (!(data[SREG] & 0x80)) this.#step(); // it may be reading the time
    const high = (data[address] | (data[address + 1] << 8)) + count;
    data[address] = high & 0xff;
    data[address + 1] = (high >> 8) & 0xff;
    this.origin -= count * 0x10000;
  }

  tick(cycle) {
    return cycle - this.origin;
  }

  #hook() {
    const { cpu } = this;
    const write = cpu.writeHooks;
    const read = cpu.readHooks;
    // All that follow are written by STS, whose second cycle is the one that counts; they must see first what the
    // timer did until then.
    const timed = (address, action) => {
      write[address] = (value) => {
        this.#happen(cpu.cycles + 1);
        action(value, cpu.cycles + 2);
        this.#plan();
        return true;
      };
    };
    timed(TCCR1A, (value) => (cpu.data[TCCR1A] = value));
    timed(TCCR1B, (value, cycle) => {
      cpu.data[TCCR1B] = value;
      if ((value & 7) !== 1) throw new Error(`TCCR1B = ${value}: the harness knows only the plain clock`);
      this.origin = cycle;
      this.overflow = cycle + 0x10000;
      this.#aim(cycle);
    });
    timed(TCCR1C, (value, cycle) => {
      if (value & 0x80) this.#compareOutput(cycle); // FOC1A
    });
    timed(OCR1AH, (value) => (this.high = value));
    timed(OCR1AL, (value, cycle) => {
      this.compare = (this.high << 8) | value;
      cpu.data[OCR1AL] = value;
      cpu.data[OCR1AH] = this.high;
      this.#aim(cycle);
    });
    read[TCNT1L] = () => {
      this.lastRead = this.tick(cpu.cycles + 1);
      const count = this.lastRead & 0xffff;
      this.high = count >> 8;
      return count & 0xff;
    };
    read[TCNT1H] = () => this.high;
    timed(TIMSK1, (value) => (cpu.data[TIMSK1] = value));
    write[TIFR1] = (value, old, address, mask) => {
      this.flags &= ~(value & mask); // SBI names one flag
      this.#plan();
      return true;
    };
    read[TIFR1] = () => this.flags;
    read[TCNT0] = () => this.counted & 0xff;
    write[TCNT0] = (value) => ((this.counted = value), true);

    for (const port of [PORTB, DDRB, PORTD, DDRD])
      write[port] = (value) => {
        if (cpu.data[port] === value) return true;
        cpu.data[port] = value;
        this.ports.push([this.tick(cpu.cycles + 1), cpu.data[PORTB], cpu.data[DDRB], cpu.data[PORTD], cpu.data[DDRD]]);
        return true;
      };
    read[PINB] = () => {
      // Two flip-flops keep what a program sees a cycle and a half behind the pin.
      const latch = cpu.cycles - this.changed < 2 ? this.latch ^ 1 : this.latch;
      return (cpu.data[PORTB] & cpu.data[DDRB] & ~STEP) | (latch ? STEP : 0);
    };
    read[PINC] = () => this.levels;
    const pinRegister = (address) => {
      write[address] = (value) => {
        cpu.data[address] = value;
        this.#plan();
        return true;
      };
    };
    pinRegister(PCICR);
    pinRegister(PCMSK1);
    write[PCIFR] = (value) => {
      if (value & 2) this.pinFlag = false;
      this.#plan();
      return true;
    };

    read[UCSR0A] = () => (this.fifo.length ? RXC : 0) | (this.waiting === null ? UDRE : 0) | (cpu.data[UCSR0A] & 2);
    write[UCSR0A] = (value) => ((cpu.data[UCSR0A] = value & 2), true);
    write[UCSR0B] = (value) => {
      cpu.data[UCSR0B] = value;
      this.#plan();
      return true;
    };
    read[UDR0] = () => {
      const byte = this.fifo.length ? this.fifo.shift() : 0;
      if (this.shift !== null) {
        this.fifo.push(this.shift);
        this.shift = null;
      }
      this.#plan();
      return byte;
    };
    write[UDR0] = (value) => {
      const cycle = cpu.cycles + 2;
      if (this.sending === null) {
        this.sending = value;
        this.sendingUntil = cycle + BYTE;
      } else {
        this.waiting = value;
      }
      this.#plan();
      return true;
    };
  }

  /** OC1A does what COM1A says, at a match or by force. */
  #compareOutput(cycle) {
    const mode = this.cpu.data[TCCR1A] >> 6;
    const level = mode === 3 ? 1 : mode === 2 ? 0 : this.latch;
    if (level === this.latch) return;
    this.latch = level;
    this.changed = cycle;
    (level ? this.rises : this.falls).push(this.tick(cycle));
    const counts = (this.cpu.data[TCCR0B] & 7) === 7;
    if (level && this.looped && counts && !(this.cpu.data[DDRD] & T0)) this.counted++;
  }

  /** Find the next match that can come from `cycle` on. */
  #aim(cycle) {
    const behind = (this.compare - (cycle - this.origin)) & 0xffff;
    this.timed = this.origin === null ? Infinity : cycle + behind;
  }

  /** Let happen what falls at or before `cycle`. */
  #happen(cycle) {
    while (this.timed <= cycle) {
      this.#compareOutput(this.timed);
      this.flags |= OCF1A;
      this.timed += 0x10000;
    }
    while (this.overflow <= cycle) {
      this.flags |= TOV1;
      this.overflow += 0x10000;
    }
    while (this.line.length && this.line[0][0] <= cycle) {
      const [end, byte] = this.line.shift();
      if (this.fifo.length < 2) this.fifo.push(byte);
      else if (this.shift === null) {
        this.shift = byte;
      } else {
        this.overruns++; // no place was left when this byte began
        this.lost.push(this.tick(end));
      }
    }
    if (this.sendingUntil <= cycle) {
      this.sent.push([this.tick(this.sendingUntil), this.sending]);
      if (this.waiting === null) {
        this.sending = null;
        this.sendingUntil = Infinity;
      } else {
        this.sending = this.waiting;
        this.waiting = null;
        this.sendingUntil += BYTE;
      }
    }
    while (this.edges.length && this.edges[0][0] <= cycle) {
      const [, input, level] = this.edges.shift();
      const levels = level ? this.levels | (1 << input) : this.levels & ~(1 << input);
      if ((levels ^ this.levels) & this.cpu.data[PCMSK1]) this.pinFlag = true;
      this.levels = levels;
    }
  }

  /** Find out when something happens next, and which interrupt is pending. */
  #plan() {
    const { data } = this.cpu;
    let next = this.timed < this.overflow ? this.timed : this.overflow;
    if (this.line.length && this.line[0][0] < next) next = this.line[0][0];
    if (this.sendingUntil < next) next = this.sendingUntil;
    if (this.edges.length && this.edges[0][0] < next) next = this.edges[0][0];
    this.next = next;
    const timer = this.flags & data[TIMSK1];
    if (this.pinFlag && data[PCICR] & 2) this.vector = VECTORS.pins;
    else if (timer & OCF1A) this.vector = VECTORS.match;
    else if (timer & TOV1) this.vector = VECTORS.overflow;
    else if (this.fifo.length && data[UCSR0B] & RXCIE) this.vector = VECTORS.received;
    else if (this.waiting === null && data[UCSR0B] & UDRIE) this.vector = VECTORS.empty;
    else this.vector = 0;
  }

  #step() {
    const { cpu } = this;
    const { data } = cpu;
    const before = data[SREG] & 0x80;
    this.instructions[cpu.pc](cpu, this.program[cpu.pc]);
    if (cpu.cycles >= this.next) {
      this.#happen(cpu.cycles);
      this.#plan();
    }
    const after = data[SREG] & 0x80;
    if (before !== after) this.#note(after);
    // Behind an instruction that lets interrupts in, one more is run.
    if (before && after && this.vector) this.#interrupt();
  }

  #note(after) {
    if (after) {
      const time = this.cpu.cycles - this.offSince;
      if (!(this.off[this.offBy] >= time)) this.off[this.offBy] = time;
    } else {
      this.offSince = this.cpu.cycles;
      this.offBy = "program";
    }
  }

  #interrupt() {
    const { cpu } = this;
    const vector = this.vector;
    this.offSince = cpu.cycles;
    cpu.data[cpu.SP] = cpu.pc & 0xff;
    cpu.data[cpu.SP - 1] = cpu.pc >> 8;
    cpu.SP -= 2;
    cpu.data[SREG] &= 0x7f;
    cpu.pc = vector;
    cpu.cycles += 4;
    if (vector === VECTORS.match) this.flags &= ~OCF1A;
    else if (vector === VECTORS.overflow) this.flags &= ~TOV1;
    else if (vector === VECTORS.pins) this.pinFlag = false;
    for (const name in VECTORS) if (VECTORS[name] === vector) this.offBy = name;
    this.taken[this.offBy] = (this.taken[this.offBy] || 0) + 1;
    this.#plan();
  }

  /** Put bytes on the line, the first no sooner than at `tick`; they follow each other without a gap. */
  receive(bytes, tick) {
    let cycle = Math.max(this.lineFree, tick + this.origin);
    for (const byte of bytes) {
      cycle += BYTE;
      this.line.push([cycle, byte]);
    }
    this.lineFree = cycle;
    return this.tick(cycle);
  }

  setInput(input, level, tick) {
    const cycle = Math.max(tick + this.origin, this.cpu.cycles);
    this.edges.push([cycle, input, level]);
    this.edges.sort((a, b) => a[0] - b[0]);
  }

  run(tick) {
    const goal = tick + this.origin;
    this.#plan();
    while (this.cpu.cycles < goal) this.#step();
  }

  /** Return how many bytes of RAM have never been written, from `end` on, where the stack cannot come from below. */
  unused(end) {
    let address = end;
    while (address < RAM && this.cpu.data[address] === PATTERN) address++;
    return address - end;
  }
}

function answer(board, request) {
  const told = {};
  if (request.power) board.powerUp();
  if (request.watch !== undefined) board.watch(request.watch);
  if (request.rounds !== undefined) board.watchRounds(request.rounds);
  if (request.telling !== undefined) board.telling = request.telling;
  if (request.loop !== undefined) board.looped = request.loop;
  if (request.skip !== undefined) board.skip(...request.skip);
  for (const [input, level, tick] of request.inputs || []) board.setInput(input, level, tick);
  told.until = (request.bytes || []).map(([hex, tick]) => board.receive(Buffer.from(hex, "hex"), tick));
  if (request.run !== undefined) board.run(request.run);
  if (request.end !== undefined) told.unused = board.unused(request.end);
  if (request.counts) {
    told.off = board.off;
    told.taken = board.taken;
    board.off = {};
    board.taken = {};
  }
  told.now = board.tick(board.cpu.cycles);
  told.rises = board.rises;
  told.falls = board.falls;
  told.ports = board.ports;
  told.sent = board.sent;
  told.looks = board.looks;
  told.rounds = board.rounds;
  told.overruns = board.overruns;
  told.lost = board.lost;
  return told;
}

function open(place, hex) {
  return new Board(require(path.resolve(place)), readHex(fs.readFileSync(hex, "latin1")));
}

if (require.main === module) {
  const board = open(process.argv[2], process.argv[3]);
  readline.createInterface({ input: process.stdin }).on("line", (line) => {
    process.stdout.write(JSON.stringify(answer(board, JSON.parse(line))) + "\n");
    board.clear();
  });
}

module.exports = { open, BYTE };

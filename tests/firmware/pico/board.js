// A Pico in an emulator: an RP2040 that runs the firmware from its second stage on, in lockstep with a test.
//
// The processor, the RAM, the pins and the clock tree are rp2040js's.  What is around them is ours, for rp2040js 1.4
// differs from the chip where it matters here:
//   - its PIO does not wait for delays (pio.js has one that does);
//   - its timer, SysTick and watchdog count nanoseconds of a clock in floating point; here everything counts cycles;
//   - it takes an interrupt in no time, where a Cortex-M0+ needs fifteen cycles;
//   - it has no flash memory behind the SSI (flash.js), and there is no image of the boot ROM: what the ROM does with the
//     second stage is done here.
//
// All instants are cycles of 132 MHz from the first instruction of the second stage on; a board that runs on its ring
// oscillator, until the PLL is on, makes the same count of cycles in a longer time (`slow`).
"use strict";

const { Pio } = require("./pio.js");
const { Flash, Ssi, SelectPin } = require("./flash.js");

const US = 132;
const ENTRY = 15; // cycles to take an interrupt
const RAM = 0x20000000, BOOT2_AT = 0x20041f00, PATTERN = 0xa5;
const PINS = 30;

/** Return the CRC-32 that the boot ROM computes over the second stage. */
function bootChecksum(bytes) {
  let crc = 0xffffffff;
  for (const byte of bytes) {
    crc ^= byte << 24;
    for (let bit = 0; bit < 8; bit++) crc = crc & 0x80000000 ? (crc << 1) ^ 0x04c11db7 : crc << 1;
  }
  return crc >>> 0;
}

/** Registers that only remember; `special` maps an offset to a function that reads it. */
class Memory {
  constructor(special = {}, written = {}) {
    this.values = {};
    this.special = special;
    this.written = written;
  }

  readUint32(offset) {
    return (offset in this.special ? this.special[offset]() : this.values[offset] || 0) >>> 0;
  }

  writeUint32(offset, value) {
    this.values[offset] = value;
    if (offset in this.written) this.written[offset](value);
  }

  writeUint32Atomic(offset, value, kind) {
    const before = this.values[offset] || 0;
    this.writeUint32(offset, kind === 0 ? value : kind === 1 ? before ^ value : kind === 2 ? before | value : before & ~value);
  }
}

class Board {
  /** `RP2040` is rp2040js's; `flash` lasts longer than a board. */
  constructor(RP2040, flash = new Flash()) {
    this.RP2040 = RP2040;
    this.flash = flash;
    this.inputs = {}; // levels at its input pins, which whoever drives them goes on driving
    this.edgesToCome = [];
    this.cycle = 0;
    this.clear();
  }

  /** Forget what has been told. */
  clear() {
    this.changes = []; // [cycle, pin, level] of pins that it drives; level 2: it has let go of it
    this.resets = [];
  }

  load(image) {
    this.flash.bytes.set(image, 0);
  }

  /** The supply comes, or the watchdog resets: everything but flash and RAM begins anew. */
  powerUp(reason = 0, pull = {}) {
    const board = this, kept = this.mcu && reason ? this.mcu.sram : null;
    const mcu = (this.mcu = new this.RP2040());
    mcu.logger = { debug() {}, info() {}, warn: (name, text) => this.note(`${name}: ${text}`), error: (name, text) => this.note(`${name}: ${text}`) };
    this.notes = [];
    if (kept) mcu.sram.set(kept);
    else mcu.sram.fill(PATTERN);
    mcu.flash = this.flash.bytes;
    mcu.flashView = new DataView(this.flash.bytes.buffer);
    this.flash.powerUp();
    this.since = this.cycle;
    this.asleep = 0;
    this.fast = null; // the cycle at which the PLL became the clock
    this.busy = 0; // cycles that a peripheral has taken from the processor
    this.last = {};
    this.alarm = Infinity;
    this.dog = Infinity;
    this.dogLeft = 0;
    this.started = null; // of SysTick
    this.pios = [new Pio(this, 0), new Pio(this, 1)];
    mcu.pio[0] = this.pios[0];
    mcu.pio[1] = this.pios[1];
    const p = mcu.peripherals;
    p[0x50200] = this.pios[0];
    p[0x50300] = this.pios[1];
    p[0x18000] = new Ssi(this, this.flash);
    p[0x40018] = new SelectPin(this, this.flash);
    p[0x40024] = new Memory({ 0x04: () => 0x80001000 }); // XOSC: it is stable
    const resets = new Memory({ 0x08: () => ~resets.readUint32(0) });
    resets.values[0] = 0x1ffffff;
    p[0x4000c] = resets;
    p[0x40064] = new Memory();
    p[0x40010] = new Memory();
    const timer = new Memory(
      { 0x28: () => Math.floor((this.cycle - this.since) / US), 0x34: () => timer.raised, 0x20: () => Number(this.alarm < Infinity) },
      {
        0x10: (value) => {
          const now = Math.floor((this.cycle - this.since) / US);
          this.alarm = this.since + (now + ((value - now) >>> 0)) * US;
        },
        0x34: (value) => {
          timer.raised &= ~value;
          this.interrupt(0, Boolean(timer.raised & timer.values[0x38]));
        },
        0x38: () => this.interrupt(0, Boolean(timer.raised & timer.values[0x38])),
      },
    );
    timer.raised = 0;
    this.timer = timer;
    p[0x40054] = timer;
    p[0x40058] = new Memory(
      { 0x08: () => (reason === "watchdog" ? 1 : 0) },
      {
        0x00: (value) => {
          this.dog = value & 0x40000000 ? this.cycle + (this.dogLeft * US) / 2 : Infinity;
        },
        0x04: (value) => {
          this.dogLeft = value & 0xffffff;
          if (this.dog < Infinity) this.dog = this.cycle + (this.dogLeft * US) / 2; // two counts a microsecond: E1
        },
      },
    );
    const ppb = mcu.ppb, read = ppb.readUint32.bind(ppb), write = ppb.writeUint32.bind(ppb);
    ppb.readUint32 = (offset) => {
      if (offset !== 0x18) return read(offset);
      return this.started === null ? 0 : (0x1000000 - ((this.cycle - this.started) % 0x1000000)) % 0x1000000;
    };
    ppb.writeUint32 = (offset, value) => {
      if (offset === 0x10) this.started = value & 1 ? this.cycle : null;
      else if (offset !== 0x18 && offset !== 0x14) write(offset, value);
    };
    mcu.addClockListener && mcu.addClockListener(() => { this.fast ??= this.cycle; });
    for (let pin = 0; pin < PINS; pin++) {
      const gpio = mcu.gpio[pin];
      gpio.addListener(() => board.edge(pin, this.cycle));
      gpio.setInputValue(Boolean(this.inputs[pin] ?? 1));
    }
    for (const pio of this.pios) pio.seen = this.#levels();
    // What the boot ROM does.
    const stage = this.flash.bytes.subarray(0, 256);
    this.refused = bootChecksum(stage.subarray(0, 252)) !== new DataView(stage.buffer).getUint32(252, true);
    mcu.sram.set(stage, BOOT2_AT - RAM);
    mcu.core.PC = BOOT2_AT;
    mcu.core.LR = 0;
    mcu.core.SP = 0x20041f00;
  }

  note(text) {
    if (this.notes.length < 20) this.notes.push(text);
  }

  #levels() {
    let levels = 0;
    for (let pin = 0; pin < PINS; pin++) if (this.inputs[pin] ?? 1) levels |= 1 << pin;
    return levels;
  }

  // ------------------------------------------------------------------------------------------- what peripherals call
  interrupt(number, level) {
    this.mcu.core.setInterrupt(number, level);
  }

  delay(cycles) {
    this.busy += cycles;
  }

  edge(pin, cycle) {
    const value = this.mcu.gpio[pin].value;
    const level = value > 1 ? 2 : value;
    if (this.last[pin] === level) return;
    this.last[pin] = level;
    this.changes.push([cycle, pin, level]);
  }

  /** A PIO may have changed its pins at a cycle. */
  edges(cycle) {
    for (const pio of this.pios) {
      const changed = (pio.pinValues ^ pio.oldValues) | (pio.pinDirections ^ pio.oldDirections);
      if (!changed) continue;
      pio.oldValues = pio.pinValues;
      pio.oldDirections = pio.pinDirections;
      for (let pin = 0; pin < PINS; pin++) {
        if (!(changed >>> pin & 1)) continue;
        const gpio = this.mcu.gpio[pin];
        if (gpio.value !== gpio.lastValue) {
          gpio.lastValue = gpio.value;
          this.edge(pin, cycle);
        }
      }
    }
  }

  // ----------------------------------------------------------------------------------------------------------- time
  /** Let an input change at a cycle. */
  set(pin, level, cycle) {
    const list = this.edgesToCome, entry = [Math.max(cycle, this.cycle), pin, level];
    let at = list.length;
    while (at && list[at - 1][0] > entry[0]) at--;
    list.splice(at, 0, entry);
  }

  /** Put characters on RXD, the first start bit at a cycle; return the cycle at which the last stop bit ends. */
  send(pin, bytes, bit, cycle, { parity = false, framing = false, stops = 2 } = {}) {
    let begin = cycle;
    for (const byte of bytes) {
      let odd = 1;
      const bits = [0];
      for (let n = 0; n < 7; n++) bits.push(byte >> n & 1), (odd ^= byte >> n & 1);
      bits.push(parity ? 1 - odd : odd, framing ? 0 : 1, 1);
      let before = 1;
      bits.forEach((level, n) => {
        if (level !== before) this.set(pin, level, Math.round(begin + n * bit));
        before = level;
      });
      begin += (9 + stops) * bit;
    }
    return Math.round(begin);
  }

  #next() {
    let next = Math.min(this.alarm, this.dog, this.pios[0].next, this.pios[1].next);
    if (this.edgesToCome.length && this.edgesToCome[0][0] < next) next = this.edgesToCome[0][0];
    return next;
  }

  /** Do what is due up to the present cycle, in its order. */
  #happen() {
    for (let next = this.#next(); next <= this.cycle; next = this.#next()) {
      for (const pio of this.pios) pio.run(next);
      while (this.edgesToCome.length && this.edgesToCome[0][0] <= next) {
        const [cycle, pin, level] = this.edgesToCome.shift();
        if ((this.inputs[pin] ?? 1) === level) continue;
        this.inputs[pin] = level;
        this.mcu.gpio[pin].setInputValue(Boolean(level));
        const levels = this.#levels();
        for (const pio of this.pios) pio.input(levels, cycle);
      }
      if (this.alarm <= next) {
        this.alarm = Infinity;
        this.timer.raised |= 1;
        this.interrupt(0, Boolean(this.timer.raised & this.timer.values[0x38]));
      }
      if (this.dog <= next) {
        this.resets.push([next, "watchdog"]);
        this.flash.fail(next, next);
        this.powerUp("watchdog");
        for (let pin = 0; pin < PINS; pin++) this.edge(pin, this.cycle);
        return;
      }
    }
  }

  run(goal) {
    if (this.refused) {
      this.cycle = Math.max(this.cycle, goal);
      return;
    }
    while (this.cycle < goal) {
      const core = this.mcu.core;
      if (core.waiting) {
        const to = Math.max(this.cycle, Math.min(this.#next(), goal));
        this.asleep += to - this.cycle;
        this.cycle = to;
        this.#happen();
        if (core === this.mcu.core && core.waiting && to === goal) return;
        continue;
      }
      const level = core.IPSR;
      this.cycle += core.executeInstruction();
      if (core.IPSR && core.IPSR !== level) this.cycle += ENTRY;
      if (this.busy) {
        this.cycle += this.busy;
        this.busy = 0;
      }
      if (core.waiting && core.pendingInterrupts & core.enabledInterrupts) core.waiting = false; // WFI passes
      if (this.#next() <= this.cycle) this.#happen();
    }
  }

  /** The supply fails now. */
  fail(seed) {
    this.flash.fail(this.cycle, seed);
    this.mcu.core.waiting = false;
    for (const pin of Object.keys(this.last)) {
      if (this.last[pin] === 2) continue;
      this.last[pin] = 2;
      this.changes.push([this.cycle, Number(pin), 2]);
    }
  }

  word(address) {
    return this.mcu.sramView.getUint32(address - RAM, true);
  }

  /** Return how many bytes below the top of the stack have been written. */
  stack(bottom, top) {
    let at = bottom;
    while (at < top && this.mcu.sram[at - RAM] === PATTERN) at++;
    return top - at;
  }
}

module.exports = { Board, US };

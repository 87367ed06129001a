// A flash memory of 2 MB on the SSI of an RP2040: what a W25Q16 does with the six commands that the firmware sends.
// Its power can fail at any cycle: an erase or a program that is in progress is then done in part, by chance.
"use strict";

const SIZE = 2 << 20, SECTOR = 4096, PAGE = 256;
const READ = 0x03, PROGRAM = 0x02, ENABLE = 0x06, STATUS = 0x05, ERASE = 0x20;
const US = 132; // cycles

/** Return a function that gives numbers from 0 to 1, the same for the same seed. */
function chance(seed) {
  let state = seed >>> 0 || 1;
  return () => {
    state ^= state << 13;
    state ^= state >>> 17;
    state ^= state << 5;
    return (state >>> 0) / 2 ** 32;
  };
}

class Flash {
  constructor() {
    this.bytes = new Uint8Array(SIZE).fill(0xff);
    this.eraseTime = 45_000 * US; // typical of a W25Q16; 400 ms at most
    this.programTime = 400 * US; // 3 ms at most
    this.operations = []; // [cycle, name, address] of all that was erased or programmed
    this.powerUp();
  }

  powerUp() {
    this.selected = false;
    this.sent = [];
    this.enabled = false;
    this.busy = null; // the operation that is in progress
  }

  select(on, cycle) {
    if (on === this.selected) return;
    this.selected = on;
    if (on) this.sent = [];
    else this.#obey(cycle);
  }

  /** Exchange a byte while it is selected; return what it answers. */
  exchange(byte, cycle) {
    const place = this.sent.push(byte) - 1;
    this.#finish(cycle);
    if (this.sent[0] === STATUS) return place ? Number(Boolean(this.busy)) | (Number(this.enabled) << 1) : 0xff;
    if (this.sent[0] === READ && place > 3) {
      return this.busy ? 0xff : this.bytes[(this.#address + place - 4) % SIZE];
    }
    return 0xff;
  }

  get #address() {
    return ((this.sent[1] << 16) | (this.sent[2] << 8) | this.sent[3]) % SIZE;
  }

  #obey(cycle) {
    const [command] = this.sent;
    this.#finish(cycle);
    if (this.busy) return; // it takes nothing but STATUS
    if (command === ENABLE) this.enabled = true;
    else if (command === ERASE && this.enabled && this.sent.length === 4) {
      const address = this.#address & ~(SECTOR - 1);
      this.#begin({ name: "erase", address, begin: cycle, end: cycle + this.eraseTime });
    } else if (command === PROGRAM && this.enabled && this.sent.length > 4) {
      this.#begin({
        name: "program", address: this.#address, data: this.sent.slice(4), begin: cycle, end: cycle + this.programTime,
      });
    }
  }

  #begin(operation) {
    this.busy = operation;
    this.operations.push([operation.begin, operation.name, operation.address, operation.end]);
  }

  #finish(cycle) {
    if (this.busy && cycle >= this.busy.end) {
      this.#apply(this.busy, 1, null);
      this.busy = null;
      this.enabled = false;
    }
  }

  #apply({ name, address, data }, part, random) {
    if (name === "erase") {
      for (let at = address; at < address + SECTOR; at++) {
        if (!random) this.bytes[at] = 0xff;
        else for (let bit = 1; bit < 256; bit <<= 1) if (random() < part) this.bytes[at] |= bit;
      }
      return;
    }
    data.forEach((byte, place) => {
      const at = (address & ~(PAGE - 1)) | ((address + place) & (PAGE - 1)); // it wraps within its page
      let cleared = ~byte & 0xff;
      if (random) for (let bit = 1; bit < 256; bit <<= 1) if (random() >= part) cleared &= ~bit;
      this.bytes[at] &= ~cleared;
    });
  }

  /** The power fails at a cycle: each bit of what is in progress has changed or not. */
  fail(cycle, seed) {
    this.#finish(cycle);
    if (this.busy) {
      const { begin, end } = this.busy;
      this.#apply(this.busy, (cycle - begin) / (end - begin), chance(seed));
    }
    this.powerUp();
  }
}

const CS = 0x0c; // GPIO_QSPI_SS_CTRL of IO_QSPI

/** SSI and the chip select of its flash. */
class Ssi {
  constructor(board, flash) {
    this.board = board;
    this.flash = flash;
    this.registers = {};
    this.answers = [];
  }

  readUint32(offset) {
    if (offset === 0x28) return 0x06 | (this.answers.length ? 8 : 0); // SR: room, empty, not busy
    if (offset === 0x60) return this.answers.length ? this.answers.shift() : 0;
    if (offset === 0x24) return this.answers.length;
    if (offset === 0x20) return 0;
    return this.registers[offset] || 0;
  }

  writeUint32(offset, value) {
    if (offset === 0x60) {
      if (!(this.registers[8] & 1)) throw new Error("SSI: data while it is off");
      // Eight clocks of SCK each: the time that a byte takes.
      this.board.delay(8 * (this.registers[0x14] || 2));
      if (this.answers.length > 15) throw new Error("SSI: its FIFO has run over");
      this.answers.push(this.flash.exchange(value & 0xff, this.board.cycle));
    } else {
      this.registers[offset] = value;
      if (offset === 8) this.answers = [];
    }
  }

  writeUint32Atomic(offset, value, kind) {
    const before = this.registers[offset] || 0;
    this.writeUint32(offset, kind === 0 ? value : kind === 1 ? before ^ value : kind === 2 ? before | value : before & ~value);
  }
}

class SelectPin {
  constructor(board, flash) {
    this.board = board;
    this.flash = flash;
    this.registers = {};
  }

  readUint32(offset) {
    return this.registers[offset] || 0;
  }

  writeUint32(offset, value) {
    this.registers[offset] = value;
    if (offset === CS) this.flash.select((value >>> 8 & 3) === 2, this.board.cycle);
  }

  writeUint32Atomic(offset, value, kind) {
    const before = this.registers[offset] || 0;
    this.writeUint32(offset, kind === 0 ? value : kind === 1 ? before ^ value : kind === 2 ? before | value : before & ~value);
  }
}

module.exports = { Flash, Ssi, SelectPin, chance, SECTOR };

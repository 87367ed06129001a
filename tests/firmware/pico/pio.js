// A PIO block of the RP2040, exact to the cycle: every instruction takes one cycle and its delay.
//
// rp2040js 1.4 has a PIO, but its step() neither waits for delays nor divides the clock (test_pio.py measures it), so a
// pulse has no defined length there.  This one goes from event to event: a state machine that counts down in a loop of
// one instruction, or waits, costs nothing until the loop or the wait ends.
//
// Not here, because the firmware does not use it (an error says so): clock dividers, side-set, OUT EXEC, MOV EXEC.
"use strict";

const CTRL = 0x00, FSTAT = 0x04, FDEBUG = 0x08, FLEVEL = 0x0c, TXF0 = 0x10, RXF0 = 0x20, IRQ = 0x30, IRQ_FORCE = 0x34;
const BYPASS = 0x38, PADOUT = 0x3c, PADOE = 0x40, MEMORY = 0x48, MACHINES = 0xc8, INTR = 0x128, INTE = 0x12c;
const SYNCHRONISER = 2; // cycles from a pin to a state machine
const AUTOPUSH = 1 << 16, AUTOPULL = 1 << 17, IN_RIGHT = 1 << 18, OUT_RIGHT = 1 << 19, JOIN_TX = 1 << 30;

class Machine {
  constructor(pio, index) {
    this.pio = pio;
    this.index = index;
    this.enabled = false;
    this.x = this.y = this.isr = this.osr = this.pc = 0;
    this.inCount = 0;
    this.outCount = 32;
    this.clkdiv = 0x10000;
    this.execctrl = 0x1f << 12;
    this.shiftctrl = 3 << 18;
    this.pinctrl = 5 << 26;
    this.tx = [];
    this.rx = [];
    this.next = Infinity; // the cycle of its next instruction; Infinity: it is stopped or stalled
    this.stalled = false;
    this.loop = null; // a count-down that is in progress: [cycle of its first instruction, x or y, cycles each]
    this.held = null; // it looks at a pin in each round: [cycle of its first instruction, cycles each]
  }

  get depth() {
    return this.shiftctrl & JOIN_TX ? 8 : 4;
  }

  /** Pass the rounds of a loop with a look at a pin, up to a cycle at which the pin may change. */
  #skip(cycle) {
    const [begin, each] = this.held;
    const rounds = Math.min(this.x, cycle === Infinity ? this.x : Math.max(0, Math.ceil((cycle - begin) / each)));
    this.loop = [begin, "x", this.x, each];
    this.next = begin + rounds * each;
    if (cycle !== Infinity) this.held = null;
  }

  /** A level will change at a cycle. */
  foresee(cycle) {
    if (this.held && this.loop) {
      this.x = this.loop[2];
      this.loop = null;
      this.#skip(cycle);
    }
  }

  /** Bring a counter that is counting down to what it is at a cycle. */
  settle(cycle) {
    if (!this.loop) return;
    const [begin, name, from, each] = this.loop;
    const rounds = Math.max(0, Math.min(from, Math.floor((cycle - begin) / each)));
    this[name] = from - rounds;
    this.loop = null;
    this.held = null;
    return begin + rounds * each;
  }

  enable(on, cycle) {
    if (on === this.enabled) return;
    this.enabled = on;
    if (!on) {
      this.settle(cycle);
      this.next = Infinity;
    } else {
      this.stalled = false;
      this.next = cycle + 1;
    }
  }

  restart() {
    this.inCount = 0;
    this.outCount = 32;
    this.isr = 0;
    this.stalled = false;
  }

  wake(cycle) {
    if (this.enabled && this.stalled) this.next = Math.min(this.next, cycle + 1);
  }

  #out(destination, value, count) {
    if (destination === 0) this.pio.setPins(value, this.pinctrl & 31, this.pinctrl >>> 20 & 63);
    else if (destination === 1) this.x = value >>> 0;
    else if (destination === 2) this.y = value >>> 0;
    else if (destination === 4) this.pio.setDirections(value, this.pinctrl & 31, this.pinctrl >>> 20 & 63);
    else if (destination === 5) return (this.pc = value & 31), true;
    else if (destination === 6) (this.isr = value >>> 0), (this.inCount = count);
    else if (destination !== 3) throw new Error(`PIO: out to ${destination}`);
    return false;
  }

  #source(number) {
    if (number === 0) return this.pio.seen >>> (this.pinctrl >>> 15 & 31);
    if (number === 1) return this.x;
    if (number === 2) return this.y;
    if (number === 3) return 0;
    if (number === 6) return this.isr;
    if (number === 7) return this.osr;
    throw new Error(`PIO: source ${number}`);
  }

  #push(cycle) {
    this.rx.push(this.isr >>> 0);
    this.isr = 0;
    this.inCount = 0;
    this.pio.changed(cycle);
  }

  /** Execute an instruction; return whether it was done ("stall": not yet). `jumped` says that it set the place. */
  execute(word, cycle) {
    const argument = word & 0xff;
    this.jumped = false;
    switch (word >>> 13) {
      case 0: {
        const to = argument & 31;
        let taken = true;
        switch (argument >>> 5) {
          case 1: taken = this.x === 0; break;
          case 2: taken = this.x !== 0; this.x = (this.x - 1) >>> 0; break;
          case 3: taken = this.y === 0; break;
          case 4: taken = this.y !== 0; this.y = (this.y - 1) >>> 0; break;
          case 5: taken = this.x !== this.y; break;
          case 6: taken = Boolean(this.pio.seen >>> (this.execctrl >>> 24 & 31) & 1); break;
          case 7: taken = this.outCount < (this.shiftctrl >>> 25 & 31 || 32); break;
        }
        if (taken) (this.pc = to), (this.jumped = true);
        return true;
      }
      case 1: {
        const wanted = argument >>> 7, source = argument >>> 5 & 3;
        let index = argument & 31;
        if (source === 2) {
          if (index & 16) index = (index & 4) | ((index + this.index) & 3);
          const bit = 1 << (index & 7);
          if (Number(Boolean(this.pio.irq & bit)) !== wanted) return false;
          if (wanted) this.pio.irq &= ~bit;
          return true;
        }
        if (source === 1) index = (index + (this.pinctrl >>> 15 & 31)) & 31;
        return (this.pio.seen >>> index & 1) === wanted;
      }
      case 2: {
        const count = argument & 31 || 32;
        if (this.shiftctrl & AUTOPUSH && this.inCount >= (this.shiftctrl >>> 20 & 31 || 32)) {
          if (this.rx.length >= 4) return false;
          this.#push(cycle);
        }
        const value = this.#source(argument >>> 5) & (count === 32 ? -1 : (1 << count) - 1);
        if (count === 32) this.isr = value >>> 0;
        else if (this.shiftctrl & IN_RIGHT) this.isr = ((this.isr >>> count) | (value << (32 - count))) >>> 0;
        else this.isr = ((this.isr << count) | value) >>> 0;
        this.inCount = Math.min(32, this.inCount + count);
        if (this.shiftctrl & AUTOPUSH && this.inCount >= (this.shiftctrl >>> 20 & 31 || 32) && this.rx.length < 4)
          this.#push(cycle);
        return true;
      }
      case 3: {
        const count = argument & 31 || 32;
        if (this.shiftctrl & AUTOPULL && this.outCount >= (this.shiftctrl >>> 25 & 31 || 32)) {
          if (!this.tx.length) return false;
          this.osr = this.tx.shift();
          this.outCount = 0;
          this.pio.changed(cycle);
        }
        let value;
        if (count === 32) (value = this.osr), (this.osr = 0);
        else if (this.shiftctrl & OUT_RIGHT) (value = this.osr & ((1 << count) - 1)), (this.osr >>>= count);
        else (value = this.osr >>> (32 - count)), (this.osr = (this.osr << count) >>> 0);
        this.outCount = Math.min(32, this.outCount + count);
        this.jumped = this.#out(argument >>> 5, value, count);
        return true;
      }
      case 4: {
        const block = argument & 32;
        if (argument & 128) {
          if (this.tx.length) {
            this.osr = this.tx.shift();
            this.pio.changed(cycle);
          } else {
            this.pio.fdebug |= 1 << (24 + this.index);
            if (block) return false;
            this.osr = this.x;
          }
          this.outCount = 0;
        } else {
          if (this.rx.length < 4) this.#push(cycle);
          else {
            this.pio.fdebug |= 1 << this.index;
            if (block) return false;
            (this.isr = 0), (this.inCount = 0);
          }
        }
        return true;
      }
      case 5: {
        let value = this.#source(argument & 7);
        const way = argument >>> 3 & 3;
        if (way === 1) value = ~value;
        else if (way) throw new Error("PIO: mov reversed");
        value >>>= 0;
        const destination = argument >>> 5;
        if (destination === 6) (this.isr = value), (this.inCount = 0);
        else if (destination === 7) (this.osr = value), (this.outCount = 0);
        else if (destination === 5) (this.pc = value & 31), (this.jumped = true);
        else if (destination <= 2) this.#out(destination, value, 32);
        else throw new Error(`PIO: mov to ${destination}`);
        return true;
      }
      case 6: {
        let index = argument & 31;
        if (index & 16) index = (index & 4) | ((index + this.index) & 3);
        const bit = 1 << (index & 7);
        if (argument & 32) throw new Error("PIO: irq wait");
        if (argument & 64) this.pio.irq &= ~bit;
        else this.pio.irq |= bit;
        this.pio.changed(cycle);
        return true;
      }
      default: {
        const value = argument & 31;
        if (argument >>> 5 === 0) this.pio.setPins(value, this.pinctrl >>> 5 & 31, this.pinctrl >>> 26 & 7);
        else if (argument >>> 5 === 1) this.x = value;
        else if (argument >>> 5 === 2) this.y = value;
        else if (argument >>> 5 === 4) this.pio.setDirections(value, this.pinctrl >>> 5 & 31, this.pinctrl >>> 26 & 7);
        return true;
      }
    }
  }

  /** Execute what is due at a cycle. */
  step(cycle) {
    this.settle(cycle);
    const at = this.pc, word = this.pio.memory[at], delay = word >>> 8 & 31;
    if (!this.execute(word, cycle)) {
      this.stalled = true;
      this.next = Infinity;
      return;
    }
    this.stalled = false;
    if (!this.jumped) this.pc = at === (this.execctrl >>> 12 & 31) ? this.execctrl >>> 7 & 31 : (at + 1) & 31;
    this.next = cycle + 1 + delay;
    // A jump to itself that counts down: the next time that anything else happens is when its counter is 0.
    if (this.jumped && this.pc === at && word >>> 13 === 0) {
      const condition = word >>> 5 & 7, name = condition === 2 ? "x" : condition === 4 ? "y" : "";
      if (name && this[name] > 1) {
        this.loop = [this.next, name, this[name], 1 + delay];
        this.next += this[name] * (1 + delay);
      }
    }
    // The same with a look at a pin in each round: it ends when a level changes, or at 0.
    if (this.jumped && word >>> 13 === 0 && (word >>> 5 & 7) === 2 && this.pc === at - 1) {
      const look = this.pio.memory[this.pc];
      if (look >>> 13 === 0 && (look >>> 5 & 7) === 6 && !(this.pio.seen >>> (this.execctrl >>> 24 & 31) & 1)) {
        const each = 2 + delay + (look >>> 8 & 31);
        const coming = this.pio.coming.length ? this.pio.coming[0][0] : Infinity;
        this.held = [this.next, each];
        this.#skip(coming);
      }
    }
  }
}

class Pio {
  /** `board` has `cycle`, `edges()` (pins may have changed) and `interrupt(number, level)`. */
  constructor(board, number) {
    this.board = board;
    this.number = number;
    this.memory = new Uint16Array(32);
    this.machines = [];
    this.states = [0, 1, 2, 3].map((index) => new Machine(this, index));
    this.pinValues = this.pinDirections = 0;
    this.seen = 0; // levels of pins behind the synchroniser
    this.coming = []; // [cycle, levels] that the state machines will see
    this.irq = this.fdebug = this.inte = 0;
    this.stepping = false;
  }

  /** The cycle at which something happens next. */
  get next() {
    let next = this.coming.length ? this.coming[0][0] : Infinity;
    for (const state of this.states) if (state.next < next) next = state.next;
    return next;
  }

  /** Do what is due up to a cycle, and no further. */
  run(cycle) {
    for (let next = this.next; next <= cycle; next = this.next) {
      while (this.coming.length && this.coming[0][0] <= next) {
        this.seen = this.coming.shift()[1];
        for (const state of this.states) state.stalled && state.enabled && (state.next = Math.min(state.next, next));
      }
      this.stepping = true;
      for (const state of this.states) if (state.next <= next) state.step(next);
      this.stepping = false;
      this.board.edges(next);
    }
  }

  /** Levels of pins have changed at a cycle. */
  input(levels, cycle) {
    this.coming.push([cycle + SYNCHRONISER, levels]);
    for (const state of this.states) state.foresee(cycle + SYNCHRONISER);
  }

  setPins(value, base, count) {
    const mask = (count > 31 ? -1 : (1 << count) - 1) << base;
    this.pinValues = (this.pinValues & ~mask) | ((value << base) & mask);
  }

  setDirections(value, base, count) {
    const mask = (count > 31 ? -1 : (1 << count) - 1) << base;
    this.pinDirections = (this.pinDirections & ~mask) | ((value << base) & mask);
  }

  get intr() {
    let bits = (this.irq & 15) << 8;
    for (const state of this.states) {
      if (state.rx.length) bits |= 1 << state.index;
      if (state.tx.length < state.depth) bits |= 16 << state.index;
    }
    return bits;
  }

  /** A FIFO or a flag has changed. */
  changed(cycle) {
    for (const state of this.states) state.wake(cycle);
    this.board.interrupt(7 + 2 * this.number, Boolean(this.intr & this.inte));
  }

  readUint32(offset) {
    if (offset >= MACHINES && offset < MACHINES + 96) {
      const state = this.states[Math.floor((offset - MACHINES) / 24)];
      return [state.clkdiv, state.execctrl, state.shiftctrl, state.pc, this.memory[state.pc], state.pinctrl][
        ((offset - MACHINES) % 24) / 4
      ] >>> 0;
    }
    if (offset >= RXF0 && offset < RXF0 + 16) {
      const state = this.states[(offset - RXF0) / 4], value = state.rx.length ? state.rx.shift() : 0;
      this.changed(this.board.cycle);
      return value;
    }
    let bits = 0;
    switch (offset) {
      case CTRL:
        return this.states.reduce((all, state) => all | (Number(state.enabled) << state.index), 0);
      case FSTAT:
        for (const state of this.states) {
          if (!state.tx.length) bits |= 1 << (24 + state.index);
          if (state.tx.length >= state.depth) bits |= 1 << (16 + state.index);
          if (!state.rx.length) bits |= 1 << (8 + state.index);
          if (state.rx.length >= 4) bits |= 1 << state.index;
        }
        return bits >>> 0;
      case FDEBUG:
        return this.fdebug >>> 0;
      case FLEVEL:
        for (const state of this.states) bits |= (state.tx.length | (state.rx.length << 4)) << (8 * state.index);
        return bits >>> 0;
      case IRQ:
        return this.irq;
      case PADOUT:
        return this.pinValues >>> 0;
      case PADOE:
        return this.pinDirections >>> 0;
      case BYPASS:
        return 0;
      case INTR:
        return this.intr;
      case INTE:
        return this.inte;
      case INTE + 8:
        return this.intr & this.inte;
    }
    throw new Error(`PIO: read of ${offset.toString(16)}`);
  }

  writeUint32(offset, value, raw) {
    const cycle = this.board.cycle;
    if (offset >= MEMORY && offset < MEMORY + 128) {
      this.memory[(offset - MEMORY) / 4] = value;
      return;
    }
    if (offset >= MACHINES && offset < MACHINES + 96) {
      const state = this.states[Math.floor((offset - MACHINES) / 24)];
      switch ((offset - MACHINES) % 24) {
        case 0:
          if (value !== 0x10000) throw new Error("PIO: a clock divider");
          break;
        case 4: state.execctrl = value; break;
        case 8: state.shiftctrl = value; break;
        case 16:
          state.settle(cycle);
          state.execute(value & 0xffff, cycle);
          if (state.jumped) {
            state.stalled = false;
            if (state.enabled) state.next = cycle + 1;
          }
          this.board.edges(cycle);
          break;
        case 20: state.pinctrl = value; break;
      }
      return;
    }
    if (offset >= TXF0 && offset < TXF0 + 16) {
      const state = this.states[(offset - TXF0) / 4];
      if (state.tx.length < state.depth) state.tx.push(value >>> 0);
      else this.fdebug |= 1 << (16 + state.index);
      this.changed(cycle);
      return;
    }
    switch (offset) {
      case CTRL:
        for (const state of this.states) {
          if (value >>> (4 + state.index) & 1) state.restart();
          state.enable(Boolean(value >>> state.index & 1), cycle);
        }
        return;
      case FDEBUG:
        this.fdebug &= ~raw;
        return;
      case IRQ:
        this.irq &= ~raw;
        this.changed(cycle);
        return;
      case IRQ_FORCE:
        this.irq |= raw;
        this.changed(cycle);
        return;
      case BYPASS:
        return;
      case INTE:
        this.inte = value & 0xfff;
        this.changed(cycle);
        return;
    }
    throw new Error(`PIO: write of ${offset.toString(16)}`);
  }

  writeUint32Atomic(offset, value, kind) {
    let after = value;
    if (kind) {
      const before = offset === FDEBUG || offset === IRQ || offset === IRQ_FORCE ? 0 : this.readUint32(offset);
      after = kind === 1 ? before ^ value : kind === 2 ? before | value : before & ~value;
    }
    this.writeUint32(offset, after >>> 0, value);
  }
}

module.exports = { Pio };

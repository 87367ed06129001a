"""A host gone mad at the host port of an MC1451A or a sister of it: packets that are right, misuse that has a name,
noise; switches, shafts and resets at random.

    python -m tests.laws.fuzz_mc 1000000        run it, print what was found, the hash, and the hash of its replay

Most operations are calls of the port; one in ten is done by strobes on its wires, which a journal keeps.  After every
block a few commands end whatever is going on, and every axis moves as it did in the beginning, to the clock.
"""

from __future__ import annotations

import hashlib
import sys
import tempfile
import time
from collections import Counter
from pathlib import Path
from random import Random
from typing import Any
from unittest.mock import patch

import slewline
from slewline.language import packets

from .fuzz import digest
from .mc_hands import MS, NS, US, Calls, Wires
from .mc_misuse import GET_VRSN, MISUSES, OF_WIRES, Misuse

PARTS = ("mc1151a", "mc1251a", "mc1451a", "mc1151a-e", "mc1251a-e", "mc1451a-e")
CRYSTALS = (25_000_000, 25_000_000, 20_000_000, 6_700_001)
INPUTS = ("poslimit", "neglimit", "home", "quad")
BLOCK = 2500  # operations between two recoveries
ONE, CYCLE = 1 << 16, 8192
GEAR = 3 << 11  # profile mode, in the mode word
ROUNDS, HEAP, STRETCHES = 20, 50, 12  # most rounds of an instant, entries of the heap, stretches of a plain move
DONE = {"right": 40, "start": 5, "misuse": 20, "noise": 3, "happen": 15, "pause": 16, "reset": 1}  # how often what
OFTEN = ("UPDATE",) * 12 + ("MULTI_UPDATE", "SET_POS", "SET_VEL", "SET_ACC", "CLR_STATUS", "MTR_ON") * 3
PLAIN = (  # ends whatever an axis does
    "SET_BRK_OFF", "SET_AUTO_UPDATE_ON", "SET_AUTO_STOP_OFF", "SET_STEP_RATIO 0", "SET_INTRPT_MASK 0", "RST_INTRPT 0",
    "SET_OUTPUT_STNDRD", "MTR_ON", "STOP", "UPDATE",
)  # fmt: skip
THERE = (
    "SET_PRFL_TRAP", "CLR_STATUS", "SET_ACTL_POS 0", "SET_POS 9", "SET_VEL 98304", "SET_ACC 20000", "SET_START_VEL 0",
)  # fmt: skip
BACK = ("SET_PRFL_S_CRV", "CLR_STATUS", "SET_POS 0", "SET_MAX_ACC 20000", "SET_JERK 500000000")


class Mad(Misuse):
    """One run of the fuzz."""

    def __init__(self, part: str, seed: int, *, wires: bool = False, journal: str | None = None) -> None:
        rnd = Random(seed)
        bench = slewline.Bench(journal=journal)
        chip: Any = bench.add(part, "x", rnd.choice(CRYSTALS))
        self.axes = range(1, chip.sheet.axes + 1)
        self.shaft: Any = None
        turned = ""
        if chip.sheet.encoder:
            self.shaft = bench.part("quadrature", "shaft", chip, axis=self.axes[-1])
            turned = f"quad{self.axes[-1]}"
        bench.run(0)
        super().__init__(bench, chip, (Wires if wires else Calls)(bench, chip), rnd)
        self.inputs = [
            row.name for row in self.sheet.pins if row.name.startswith(INPUTS) and row.name[:4] + row.name[-1] != turned
        ]
        self.often = [row for row in self.rows for _ in range(1 + OFTEN.count(row.name))]
        self.misuses = (*MISUSES, *(OF_WIRES if wires else ()))
        self.bag: list[str] = []  # of misuses: each comes once before one comes again
        self.hash, self.told = hashlib.sha256(), hashlib.sha256()
        self.findings: Counter[str] = Counter()
        self.done: Counter[str] = Counter()
        self.steps = 0
        self.moved = self.moves()
        self.size = self.sizes()

    # --------------------------------------------------------------------------------------------------- what is done
    def value(self, low: int, high: int) -> int:
        """A number of a range: an end of it, a small one, any."""
        rnd = self.rnd
        most = min(high, rnd.choice((3, 100, ONE, 20 * ONE, high)))
        return rnd.choice((low, high, max(low, 0), max(low, -1), 1, rnd.randrange(max(low, -most), most + 1)))

    def right(self) -> None:
        """A command of which nothing is wrong; most of what it says is read, and sometimes more."""
        rnd, row = self.rnd, self.rnd.choice(self.often)
        self.hand.ready()  # the mode is what the last command has made it
        values = [self.value(arg.low, arg.high) for arg in row.args]
        if row.name == "SET_ACC" and self.chip.state.axis.mode == 0:
            values = [max(abs(value) - 1, 0) for value in values]
        words, reads = packets.words(row, values), packets.counted(row.reads)
        with self.finds():
            if rnd.random() < 0.3:
                self.hand.command(row.code)
                self.hand.send(*words)
                self.hand.fetch(rnd.randrange(reads + 1))
            else:
                self.exchange(row.code, *words, reads=reads)
                assert rnd.random() < 0.9 or self.hand.fetch(2) == [0, 0]

    def start(self) -> None:
        """Something that moves, unless something else holds it back."""
        rnd = self.rnd
        speed = rnd.choice((100, ONE, 16 * ONE, rnd.randrange(1, 512 * ONE)))
        ramp = speed // rnd.randrange(1, 50) + 1
        far = rnd.choice((1, -1)) * rnd.choice((1, 100, speed // ONE * 50, 1 << 29))
        with self.finds():
            self.do(f"SET_{rnd.choice(self.axes)}")
            if rnd.random() < 0.4:
                self.do(rnd.choice(("SET_PRFL_TRAP", "SET_PRFL_S_CRV", "SET_PRFL_VEL", "SET_PRFL_GEAR")))
                self.do(f"SET_RATIO {rnd.choice((ONE, -ONE // 3, 100 * ONE, (1 << 30) - 1))}")
            self.do(f"SET_VEL {speed}")
            self.do(f"SET_ACC {ramp}")
            self.do(f"SET_MAX_ACC {min(ramp, 32767)}")
            self.do(f"SET_JERK {rnd.choice((1, ONE, 1 << 30))}")
            self.do(f"SET_POS {far}")
            self.do("UPDATE")

    def misuse(self) -> None:
        """Something that is wrong, and has a name."""
        if not self.bag:
            self.bag = self.rnd.sample(self.misuses, len(self.misuses))
        self.try_out(self.bag.pop())

    def try_out(self, name: str) -> None:
        self.done[name] += 1
        getattr(self, name)()

    def noise(self) -> None:
        """Any operations at any time; then a packet, which may find what they have left."""
        rnd, hand = self.rnd, self.hand
        for _ in range(rnd.randrange(1, 30)):
            if rnd.random() < 0.9:
                hand.ready()
            does, number = rnd.choice("ccccwwwrrr"), rnd.choice((1, 2, 2, 2, 2))
            if does == "r":
                hand.read(number)
            else:
                hand.write(rnd.randbytes(1 if does == "c" else number), command=does == "c")
        if isinstance(hand, Wires):
            hand.fumble(rnd)
        self.do("GET_VRSN")

    def happen(self) -> None:
        """Something on the inputs."""
        rnd, pin = self.rnd, self.chip.pin(self.rnd.choice(self.inputs))
        if self.shaft is not None and rnd.random() < 0.3:
            self.shaft.run(rnd.choice((0, 0, 1, -1000, 100_000, -1_250_000, 2_000_000)))
        elif rnd.random() < 0.3:
            pins = [pin, self.chip.pin(rnd.choice(self.inputs))]
            for _ in range(rnd.randrange(1, 30)):
                for pin in pins[: rnd.randrange(1, 3)]:
                    pin.drive(rnd.randrange(2))
                self.bench.run(rnd.choice((0, 100 * NS, 500 * NS, US, 328 * US)))
        elif rnd.random() < 0.4:
            pin.drive(rnd.randrange(2))
        else:
            pin.release()

    def pause(self) -> None:
        """Nothing."""
        self.bench.run(self.rnd.choice((US, 10 * US, 328 * US, MS, MS, 10 * MS, 100 * MS)))

    def reset(self) -> None:
        """RESET, as it should be and not, a supply that fails, or a long time without anything."""
        rnd = self.rnd
        kind = rnd.choice(("short_reset", "early_reset", "command", "pin", "power", "age", "age"))
        if kind.endswith("_reset"):
            self.try_out(kind)
        elif kind == "command":
            self.hand.command(self.sheet.commands["RESET"].code)
            assert self.hand.fetch() == [0]
        elif kind == "pin":
            self.pull_reset(rnd.choice((4 * US, 10 * MS)))
        elif kind == "power":
            self.chip.power(False)
            self.bench.run(rnd.choice((0, US, 1000 * MS)))
            self.chip.power(True)
            self.hand.ready()
        else:
            self.rest()
            for axis in self.axes:  # a gear works every cycle, as long as it has steps to make up for
                self.do(f"SET_{axis}")
                if self.do("GET_MODE") & GEAR == GEAR:
                    self.do("SET_PRFL_TRAP")
            self.bench.run(rnd.choice((1000, 1_000_000)) * MS)

    # ------------------------------------------------------------------------------------------------------- one block
    def block(self, operations: int) -> None:
        """So many operations, and what happens meanwhile; then the recovery."""
        last, began = self.hand.operations + operations, self.bench.now_ps
        while self.hand.operations < last:
            self.try_out(*self.rnd.choices((*DONE,), (*DONE.values(),)))
        cycles = self.chip.clock.ticks_until(self.bench.now_ps - began) // CYCLE
        for each in (*self.chip.axes, *(one.pulses for one in self.chip._motion.trajectories)):
            assert len(each.past) <= cycles + 2, "a cycle leaves more behind than one stretch"
        self.recover()
        self.note()

    def recover(self) -> None:
        """A few commands, and everything works as ever; nothing has grown."""
        self.rest()
        assert self.exchange(GET_VRSN, reads=1) == self.version[:1]
        assert self.moves() == self.moved
        assert len(self.bench.kernel.heap) < HEAP and self.sizes() == self.size

    def rest(self) -> None:
        """The inputs as they were in the beginning."""
        for name in self.inputs:
            self.chip.pin(name).release()
        if self.shaft is not None:
            self.shaft.run(0)

    def sizes(self) -> list[int]:
        """How many watch the wires."""
        nets = {id(pin.net): pin.net for pin in self.chip.pins.values()}.values()
        return [len(each) for net in nets for each in (net.before_change, net.observers, net.waiters or ())]

    def moves(self) -> list[list[int]]:
        """Two moves of every axis: the clocks of all steps, since the begin of the cycle of the first one."""
        with self.finds():
            for command in ("LMTS_ON", "SET_LMT_SENSE 0"):
                self.do(command)
            for axis in self.axes:
                for command in (f"SET_{axis}", *PLAIN):
                    self.do(command)
            self.bench.run(4 * MS)
            return [*self.move(THERE, 9), *self.move(BACK, 0)]

    def move(self, commands: tuple[str, ...], position: int) -> list[list[int]]:
        """One move of every axis, at the same time."""
        chip, since = self.chip, self.bench.now_ps
        for axis in self.axes:
            for command in (f"SET_{axis}", *commands):
                self.do(command)
        pasts = [each.past for each in (*chip.axes, *(one.pulses for one in chip._motion.trajectories))]
        before = [len(past) for past in pasts]
        self.do(f"MULTI_UPDATE {(1 << len(self.axes)) - 1}")
        self.bench.run_until_idle("1 s")
        found = []
        assert all(len(past) <= length + STRETCHES for past, length in zip(pasts, before, strict=True))
        for number, axis in zip(self.axes, chip.axes, strict=True):
            times = axis.times(since, self.bench.now_ps)
            ticks = [chip.clock.ticks_from(ps) - chip._cycle_clock.origin for ps in times.tolist()]
            found.append([tick - ticks[0] // CYCLE * CYCLE for tick in ticks])
            assert axis.position == position
            assert self.do(f"SET_{number}") & 0x7FF == 0x0301 and self.do("GET_TRGT_POS") == position
        return found

    def note(self) -> None:
        """What has happened so far goes into the hash, and is forgotten."""
        self.hash.update(repr((self.hand.words, seen(self.bench))).encode())
        digest(self.told, self.chip.findings)
        self.findings.update(found.code for found in self.chip.findings)
        self.chip.findings.clear()
        self.hand.words.clear()
        for axis in self.chip.axes:
            self.hash.update(axis.times(self.bench.now_ps - 500 * MS, self.bench.now_ps).tobytes())
            self.steps += axis.count(axis.past[0].start, self.bench.now_ps)
            axis.forget(self.bench.now_ps)

    def digest(self) -> str:
        """Everything that happened, in one hash."""
        return self.hash.hexdigest()[:32] + self.told.hexdigest()[:32]

    def end_state(self) -> str:
        """What the replay of the journal must end with."""
        return state(self.bench, self.told)


def seen(bench: slewline.Bench) -> tuple[Any, ...]:
    """What can be asked at the end of a run."""
    chip: Any = bench["x"]
    axes = range(1, chip.sheet.axes + 1)
    levels = [pin.level for pin in chip.pins.values()]
    return (bench.now_ps, [(chip.registers_of(n), chip.axes[n - 1].travel) for n in axes], levels)


def state(bench: slewline.Bench, told: hashlib._Hash) -> str:
    """That and a digest of all findings, in one hash."""
    return hashlib.sha256(repr((seen(bench), told.hexdigest())).encode()).hexdigest()


def replayed(path: str) -> str:
    """The state at the end of a journal's replay."""
    bench = slewline.replay(path)
    told = hashlib.sha256()
    digest(told, bench["x"].findings)
    return state(bench, told)


def run(part: str, operations: int, seed: int, *, wires: bool = False, journal: str | None = None) -> Mad:
    """Run until so many operations are done."""
    with patch("slewline.core.time.kernel.ROUNDS_LIMIT", ROUNDS):
        mad = Mad(part, seed, wires=wires, journal=journal)
        while mad.hand.operations < operations:
            mad.block(min(BLOCK, operations))
    return mad


def main() -> None:
    wanted = int(sys.argv[1]) if len(sys.argv) > 1 else 60_000
    each = wanted // len(PARTS) // 10
    done: Counter[str] = Counter()
    findings: Counter[str] = Counter()
    with tempfile.TemporaryDirectory() as folder:
        for part in PARTS:
            journal = str(Path(folder, part))
            for operations, wires in ((9 * each, False), (each, True)):
                start = time.perf_counter()
                one = run(part, operations, 1, wires=wires, journal=journal if wires else None)
                wall = time.perf_counter() - start
                how = f"{one.hand.operations:,} operations by {'strobes' if wires else 'calls'}"
                print(f"{part}: {how}, {one.steps:,} steps, {one.bench.now_ps / 1e12:.0f} s virtual in {wall:.0f} s")
                done += one.done
                findings += one.findings
                two = run(part, operations, 1, wires=wires)
                print("hash      ", one.digest(), "\nagain     ", two.digest())
                assert one.digest() == two.digest()
            print("end state ", one.end_state(), "\nreplayed  ", replayed(journal))
            assert one.end_state() == replayed(journal)
    print("done:", ", ".join(f"{name} {count}" for name, count in done.most_common()))
    print("findings:", ", ".join(f"{code} {count}" for code, count in findings.most_common()))


if __name__ == "__main__":
    main()

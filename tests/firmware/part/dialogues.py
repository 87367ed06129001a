"""Random dialogues: a host, hands at the inputs, noise, a failing supply; the same seed gives the same dialogue.

    seed ----> Dialogue ----> modules of the model, then the core: outcomes to compare

Boundaries are reached on purpose: a full memory, moves of 0, 1 and 2 steps, ramps of 1 and 999 steps, commands and
inputs at the very instant at which something else is due.
"""

from __future__ import annotations

import random
import warnings
from collections.abc import Callable, Sequence
from dataclasses import dataclass

import slewline
from slewline.chips.gs_c200.sheet import GS_C200, GS_C200S
from slewline.core.datasheet.command_rows import LineRow
from slewline.core.datasheet.table import Arg
from slewline.language.lines import framed

from . import library, witness
from .witness import BAUDS, Module

US, MS, S = 10**6, 10**9, 10**12
PARTS = ("gs-c200", "gs-c200s")
SHEETS = dict(zip(PARTS, (GS_C200, GS_C200S), strict=True))
ODD = (
    "P", "Po", "P0", "Px", "X9", "+0", "-0", "S0", "S1001", "T1001", "R1000", "R0", "foo", "G", "F", "V", "V0",
    "V3", "jc1", "L256", "+", "-", "f5", "g1", "g+4", "g+0", "G+2", "G-", "g-", "Q", "K", "A", "A0", "A4",
    "A22", "D0", "D256", "-9999999", "L00", "G+-3", "j119", "jc8,0", "jc1,119", "jc1;0", "h", "H0", "H+-", "E1",
    "M1", "po", "PX", "", " ", "S 1", "Lo", "l0", "+1000000", "-1000000", "G10000000", "G9999999", "G-8388609",
    "f-8388609", "f+8388608", "I0", "I4", "U0", "U4", "W0", "W4", "+999999", "A1 ", "jc01,02", "L", "D", "S",
    "U", "W", "I", "j", "jc", "jc1,", "jc,1", "G+", "g", "LO", "L0o", "l", "f+0", "A3", "C3", "D255", "T1",
    "S1000", "R999", "S0001", "+0000001", "g+01", "f+", "f-", "J0", "JC1,1", "R", "T", "V01", "x", "z", "k",
    "12345678901", "123456789012", "G00000001",
)  # fmt: skip


@dataclass
class Result:
    """What a dialogue showed: how the core differs, empty if it does not; and how much there was to compare."""

    difference: str = ""
    answers: int = 0
    steps: int = 0
    edges: int = 0


class Dialogue:
    """A dialogue of a seed."""

    def __init__(self, seed: int, part: str | None = None) -> None:
        self.rng = rng = random.Random(seed)
        self.seed = seed
        self.bench = slewline.Bench()
        self.kernel = self.bench.kernel
        several = rng.random() < 0.12
        self.modules: dict[str, Module] = {}
        self.rate = rng.choices(range(8), (60, 6, 4, 3, 2, 2, 1, 1))[0]
        self.checks = rng.random() < 0.3
        self.rec = rng.random() < 0.12
        addresses = (
            rng.sample(range(1, 8), rng.randint(2, 3)) if several else [rng.choice((0, 0, 0, rng.randint(1, 7)))]
        )
        for number, address in enumerate(addresses):
            name = f"m{number}"
            self.modules[name] = self._module(name, part or rng.choice(PARTS), address)
        self.addresses = dict(zip(self.modules, addresses, strict=True))
        self.baud_at: dict[str, dict[int, int]] = {name: {} for name in self.modules}
        self.to = next(iter(self.modules))
        self.scenes: dict[Callable[[], None], int] = {  # and how often
            self.program_and_run: 50,
            self.homing: 9,
            self.keeping: 8,
            self.filling: 5,
            self.chatter: 9,
            self.power_cycle: 5,
            self.position: 5,
            self.skipping: 5,
            self.to_the_end: 4,
        }

    def _module(self, name: str, part: str, address: int) -> Module:
        straps = {"br0": self.rate & 1, "br1": self.rate >> 1 & 1, "br2": self.rate >> 2 & 1, "chs": int(self.checks)}
        if self.rec or self.rng.random() < 0.02:
            straps["rec"] = 0
        sel = {f"sel{n}": (7 - address) >> (2 - n) & 1 for n in range(3)} if address else {}
        kept = self.kept(part) if self.rng.random() < 0.15 else b""
        return Module(self.bench, name, part, straps, sel, kept, self.rng.choice((0, 0, 0, 0, 1, 3)))

    def kept(self, part: str) -> bytes:
        """Return what an EEPROM may hold: a program, one of the other part, or none."""
        rng = self.rng
        rows = SHEETS[rng.choice((part, part, part, *PARTS))].rows(LineRow)
        speeds = [row for form in "STR" for row in rows if row.form == form]
        chosen = [
            *speeds[: rng.choice((3, 3, 3, 2, 0))],
            *rng.choices([row for row in rows if row.stored], k=rng.randint(0, 6)),
        ]
        data = b"".join(row.pack([self.value(arg) for arg in row.args]) for row in chosen)
        spoil = rng.random()
        if spoil < 0.1:
            data = data[: rng.randint(0, len(data))]
        elif spoil < 0.15:
            data = b"\xff" + data
        elif spoil < 0.2 and data:
            data = data[:-1] + b"\x00?"
        return data

    def value(self, arg: Arg) -> int:
        """Return a value that an argument may be, small if it can."""
        if arg.sign == "alone":
            return self.rng.choice((-1, 1))
        return self.rng.randint(max(arg.low, -99), min(arg.high, 99)) or 1

    # ------------------------------------------------------------------------------------------------------ play it
    def play(self) -> None:
        """Play it on the model."""
        with warnings.catch_warnings(), witness.tapped(self.modules):
            warnings.simplefilter("ignore")
            self._play()

    def _play(self) -> None:
        rng = self.rng
        self.wait(rng.randint(1, 3 * MS))
        self.start()
        for _ in range(rng.choice((1, 1, 2, 3))):
            self.to = rng.choice(list(self.modules))
            rng.choices(list(self.scenes), list(self.scenes.values()))[0]()
        for name in self.modules:
            self.to = name
            for text in ("F", rng.choice(("K", "Z", "K")), "V1", "V2", "F"):
                self.ask(text)

    def start(self) -> None:
        """Switch every module on that is off."""
        rng = self.rng
        if rng.random() < 0.08:
            for module in self.modules.values():
                module.put(1)  # RXD positive: H- of a stand-alone start
        for name, module in self.modules.items():
            if not module.x.powered:
                module.power(True)
                self.baud_at[name][self.kernel.now] = BAUDS[self.rate]
        self.wait(rng.choice((500 * US, 400 * US, rng.randint(0, 2 * MS))))
        for module in self.modules.values():
            module.put(0)

    # ---------------------------------------------------------------------------------------------------- what is said
    @property
    def is_200s(self) -> bool:
        """Is the module that is spoken to a GS-C200S?"""
        return self.modules[self.to].part == "gs-c200s"

    def instruction(self) -> str:
        """Return an instruction of a program, or something odd."""
        rng, s = self.rng, self.is_200s
        velocity = "g" if s else "G"
        kinds: list[tuple[int, Callable[[], str]]] = [
            (40, lambda: f"{rng.choice('+-')}{self.distance()}"),
            (9, lambda: f"G{rng.randint(-800, 800)}" if s else f"G{rng.randint(0, 900)}"),
            (8, lambda: f"{rng.choice('AC')}{rng.randint(1, 3)}"),
            (4, lambda: f"D{rng.choice((1, 1, 2, 3))}"),
            (5, lambda: "L0"),
            (6, lambda: f"L{rng.randint(1, 3)}"),
            (5, self.speed),
            (4, lambda: f"{velocity}{rng.choice('+-')}"),
            (7, lambda: f"{velocity}{rng.choice('+-')}{rng.randint(1, 3)}"),
            (5, lambda: f"W{rng.randint(1, 3)}"),
            (4, lambda: f"U{rng.randint(1, 3)}"),
            (3, lambda: f"I{rng.randint(1, 3)}"),
            (3, lambda: f"f{rng.randint(-9, 9) if rng.random() < 0.5 else rng.randint(-(1 << 23), (1 << 23) - 1):+d}"),
            (4, lambda: f"jc{rng.randint(0, 7)},{2 * rng.randint(0, 20)}"),
            (2, lambda: f"j{rng.randint(0, 40)}"),
            (4, lambda: rng.choice(ODD)),
        ]
        weights, makers = zip(*kinds, strict=True)
        return rng.choices(makers, weights)[0]()

    def distance(self) -> int:
        """Return a number of steps, often one at a boundary."""
        rng = self.rng
        return rng.choice((1, 2, 3, rng.randint(1, 20), rng.randint(1, 60), rng.randint(1, 400), rng.randint(1, 1500)))

    def speed(self) -> str:
        """Return a command S, T or R."""
        rng = self.rng
        letter = rng.choice("STR")
        if letter == "R":
            return f"R{rng.choice((1, 2, 999, rng.randint(1, 30), rng.randint(1, 300)))}"
        return f"{letter}{rng.choice((1, 1000, rng.randint(20, 300), rng.randint(100, 1000)))}"

    def speeds(self) -> list[str]:
        """Return S, T and R, most often all of them."""
        rng = self.rng
        found = [
            f"S{rng.randint(20, 300)}",
            f"T{rng.randint(50, 1000)}",
            f"R{rng.choice((1, 2, 7, rng.randint(1, 200), 999))}",
        ]
        if rng.random() < 0.12:
            found.pop(rng.randrange(3))
        if rng.random() < 0.1:
            rng.shuffle(found)
        if rng.random() < 0.1:
            found.insert(0, f"U{rng.randint(1, 3)}")
        return found

    def program_and_run(self) -> None:
        """Enter a program, let it run, interfere."""
        rng = self.rng
        self.enter()
        few = rng.randint(1, 9)
        for text in [*self.speeds(), *(self.instruction() for _ in range(few))]:
            self.ask(text)
        if rng.random() < 0.15:
            self.ask(rng.choice(("Q", "V1", "V2", "F", "X", "M", "H+", "K", "Z", "I1")))
        self.ask(rng.choice(("E", "E", "E", "E", "E", "Px" if self.is_200s else "E", "E")))
        self.interfere(rng.randint(1, 7))
        if rng.random() < 0.25:
            self.ask(rng.choice(("E", "Q", "H-")))
            self.interfere(rng.randint(0, 3))

    def enter(self) -> None:
        """Begin program entry."""
        self.ask("Po" if self.is_200s else "P")

    def interfere(self, times: int) -> None:
        """Let time pass, ask, change inputs, stop."""
        rng = self.rng
        for _ in range(times):
            what = rng.random()
            if what < 0.38:
                self.hands()
            elif what < 0.42:
                self.power_cycle()
            elif what < 0.62:
                self.aimed(rng.choice(("Z", "Z", "K", "F", "V1", "Q")))
            else:
                self.ask(
                    rng.choice(("F", "F", "V1", "V2", "Q", "S5", "+5", "E", "I3", "H", "Po", "Z", "K", rng.choice(ODD)))
                )
            self.wait(self.pause())
        self.settle()

    def pause(self) -> int:
        """Return a time of any order of magnitude."""
        return int(10 ** self.rng.uniform(3, 11.7))

    def settle(self) -> None:
        """End what runs, at times only after it has ended by itself."""
        rng = self.rng
        if rng.random() < 0.5:
            self.wait(rng.choice((MS, 100 * MS, 3 * S)))
        for pin in ("enable", "ui1", "ui2", "ui3"):
            if rng.random() < 0.7:
                self.modules[self.to].drive(pin, 1)
        self.aimed(rng.choice(("K", "K", "Z", "F")))
        self.wait(rng.choice((0, 10 * MS, rng.randint(0, 500 * MS))))
        self.ask("K")

    def homing(self) -> None:
        """Home, with switches that come when they come."""
        rng, module = self.rng, self.modules[self.to]
        if rng.random() < 0.5:
            self.enter()
            for text in self.speeds():
                self.ask(text)
            self.ask(rng.choice(("E", "Px", "E")))
        for pin in ("eot", "home"):
            if rng.random() < 0.25:
                module.drive(pin, 0)
        self.ask(rng.choice(("H", "H+", "H-")))
        for _ in range(rng.randint(1, 5)):
            self.wait(self.pause())
            self.hands(rng.choice(("eot", "home", "eot", "home", "enable")))
            if rng.random() < 0.25:
                self.ask(rng.choice(("F", "Z", "K", "V1")))
        for pin in ("eot", "home"):
            self.wait(rng.randint(0, 30 * MS))
            module.drive(pin, rng.choice((0, 0, 1)))
        self.wait(200 * MS)
        self.ask("F")
        self.ask(rng.choice(("K", "Z", "Q", "E")))
        for pin in ("eot", "home"):
            module.drive(pin, 1)

    def keeping(self) -> None:
        """M and X, with failures, a look at what is kept, and starts without a host."""
        rng, module = self.rng, self.modules[self.to]
        self.enter()
        for text in (*self.speeds(), *(self.instruction() for _ in range(rng.randint(0, 4)))):
            self.ask(text)
        if rng.random() < 0.2:
            module.fail(True)
        self.ask("M", wait=rng.random() < 0.6)
        if rng.random() < 0.3:
            self.wait(rng.randint(0, 300 * MS))
            self.ask(rng.choice(("F", "K", "Q", "M", "zz")), wait=rng.random() < 0.5)
        if rng.random() < 0.35:
            self.wait(rng.choice((0, rng.randint(0, 400 * MS))))
            self.power_cycle()
        else:
            self.wait(rng.choice((0, S)))
        module.fail(False)
        for _ in range(rng.randint(1, 4)):
            self.ask(rng.choice(("X", "Q", "Po", "M", "X", "F", "A1", "Px", "E", "K")))
            self.wait(rng.choice((0, 500 * MS)))
        if rng.random() < 0.5:
            for pin in ("eot", "home", "rec"):
                module.drive(pin, int(rng.random() < 0.35))
            self.power_cycle()
            self.interfere(rng.randint(1, 3))
            for pin in ("eot", "home", "rec"):
                module.drive(pin, 1)

    def filling(self) -> None:
        """Fill the memory to the last locations, then list and run it."""
        rng = self.rng
        self.enter()
        texts, taken, full = self.speeds(), 0, rng.randint(105, 119)
        while taken < full:
            texts.append(rng.choice(("A1", "C2", "+1", "-2", "+3", "L0", "L1", "R5", "A3")))
            taken = sum(4 if text[0] in "+-RST" else 2 for text in texts)
        for text in texts:
            self.ask(text)
        for text in rng.sample(("A1", "+1", "C1", "A2", "S50", "A1", "C3", "C2", "+2", "-1"), rng.randint(2, 10)):
            self.ask(text)
        self.ask(rng.choice(("Q", "F")))
        self.ask("E")
        self.interfere(2)

    def chatter(self) -> None:
        """Lines without a program, and damaged ones."""
        rng = self.rng
        for _ in range(rng.randint(2, 12)):
            text = rng.choice(
                (*ODD, "V1", "V2", "F", "I1", "I2", "I3", "f+7", "f-8388608", "Q", "X", "H", "E", "K", "Z", "M", "A1")
            )
            self.ask(text, wait=rng.random() < 0.7)
            if rng.random() < 0.15:
                self.noise()
            if rng.random() < 0.1:
                self.modules[self.to].drive("chs", rng.randint(0, 1))
                self.checks = bool(rng.getrandbits(1)) if rng.random() < 0.3 else self.checks
            self.wait(rng.choice((0, 0, rng.randint(0, 20 * MS))))

    def position(self) -> None:
        """Go to the ends of the position counter."""
        rng = self.rng
        self.enter()
        for text in (f"S{rng.randint(100, 900)}", f"T{rng.randint(100, 1000)}", f"R{rng.choice((1, 3, 40))}"):
            self.ask(text)
        if self.is_200s:
            self.ask(rng.choice(("f+8388607", "f-8388608", "f+8388600", "f-8388600", "f-8388590", "f+0")))
        for _ in range(rng.randint(1, 4)):
            velocity = "g" if self.is_200s else "G"
            self.ask(
                rng.choice(
                    (
                        "+1",
                        "-1",
                        f"+{self.distance()}",
                        f"-{self.distance()}",
                        "G0",
                        "G1",
                        "G5",
                        velocity + "-",
                        velocity + "-1",
                    )
                )
            )
        self.ask("E")
        self.interfere(rng.randint(1, 4))
        self.ask("V1")
        self.ask("F")

    def skipping(self) -> None:
        """Jump over S, T or R."""
        rng = self.rng
        self.power_cycle()
        self.enter()
        texts = [rng.choice(("S50", "T300", "R7")) for _ in range(rng.randint(0, 3))]
        over = ["S80", "T200", "R5"]
        rng.shuffle(over)
        velocity = "g" if self.is_200s else "G"
        at = 2 + 4 * len(texts) + 4 * rng.choice((1, 2, 3, 3))
        jump = f"j{at}" if self.is_200s else "A1"
        motion = rng.choice(("+3", "G5", "G0", f"{velocity}+", f"{velocity}-1", f"{velocity}+1"))
        for text in (*texts, jump, *over, motion, "A2", rng.choice(("+2", "D1"))):
            self.ask(text)
        self.ask("E")
        self.interfere(rng.randint(1, 3))

    def to_the_end(self) -> None:
        """Come to rest at the very end of the position counter, or a step before or after it."""
        rng, velocity, number = self.rng, "g" if self.is_200s else "G", self.rng.randint(4, 30)
        self.ask("I1")
        self.enter()
        speed = rng.randint(20, 60)
        for text in (
            f"S{speed}",
            f"T{speed + rng.randint(-1, 60)}",
            f"R{rng.randint(1, 40)}",
            f"+{number}",
            f"{velocity}-{rng.choice(('', '1'))}",
        ):
            self.ask(text)
        self.ask("E")
        self.kernel.run_while(lambda: self.modules[self.to].x.position >= number, self.kernel.now + 5 * S)
        wanted = number - rng.randint(1, number)
        self.kernel.run_while(lambda: self.modules[self.to].x.position == wanted, self.kernel.now + 5 * S)
        if rng.random() < 0.5:
            self.modules[self.to].drive("ui1", 0)
        self.aimed(rng.choice(("Z", "Z", "F")))
        self.wait(rng.choice((20 * MS, S)))
        self.modules[self.to].drive("ui1", 1)
        self.ask("F")
        self.ask("F")

    def power_cycle(self) -> None:
        """Switch a module, or all of them, off and on again, with other straps at times."""
        rng = self.rng
        chosen = [self.modules[self.to]] if rng.random() < 0.7 else list(self.modules.values())
        if rng.random() < 0.3 and (at := self.due()) is not None:
            self.wait(at - self.kernel.now)
        for module in chosen:
            module.power(False)
        self.wait(rng.choice((1, rng.randint(1, 50 * MS))))
        if rng.random() < 0.1:
            self.rate = rng.choice((0, 0, rng.randrange(8)))
            for module in self.modules.values():
                for bit in range(3):
                    module.drive(f"br{bit}", self.rate >> bit & 1)
            for module in self.modules.values():
                module.power(False)
            self.wait(MS)
        self.start()

    # --------------------------------------------------------------------------------------------------------- inputs
    def due(self) -> int | None:
        """Return an instant at which something is due as things stand, if there is any."""
        rng, now = self.rng, self.kernel.now
        train = self.modules[self.to].x._interpreter.motion.playing
        times = [entry[0] for entry in self.kernel.heap if entry[2].token == entry[3] and entry[0] > now]
        if train is not None:
            count = train.train.count(now)
            times += [train.train.end(count + more) for more in range(rng.randint(0, 3))]
            times += [train.train.end(count) + 1_700_000] if count else []
        times = [at for at in times if now < at < now + 3 * S]
        return rng.choice(times) if times else None

    def hands(self, pin: str = "") -> None:
        """Change inputs, some of them at the very instant of something else."""
        rng, module = self.rng, self.modules[self.to]
        pin = pin or rng.choice(("enable", "enable", "ui1", "ui2", "ui3", "eot", "home"))
        level = rng.choice((0, 0, 1))
        at = self.due() if rng.random() < 0.5 else None
        at = (
            self.kernel.now + rng.choice((0, rng.randint(0, 5 * MS)))
            if at is None
            else max(at + rng.choice((0, 0, -1, 1)), 0)
        )
        if rng.random() < 0.3:
            self.wait(max(at - self.kernel.now, 0))
            at = self.kernel.now
        module.drive(pin, level, at)
        if rng.random() < 0.6:
            width = rng.choice((1, 1_000_000, 5_000_000, 4_999_999, rng.randint(1, 20 * MS)))
            module.drive(pin, 1 - level, max(at, self.kernel.now) + width)

    def noise(self) -> None:
        """A break, a spike, or characters of another rate on RXD."""
        rng = self.rng
        baud = BAUDS[rng.choice((self.rate, rng.randrange(8)))]
        data = bytes(rng.randrange(128) for _ in range(rng.randint(1, 4)))
        wave = witness.characters_of(data, baud, self.kernel.now, {0: rng.getrandbits(10)})
        for module in self.modules.values():
            module.put(wave)
        self.wait(rng.choice((rng.randint(0, 10 * MS), witness.length_of(len(data) + 1, baud))))

    # ---------------------------------------------------------------------------------------------------------- lines
    def wait(self, ps: int) -> None:
        """Let time pass (ps)."""
        if ps > 0:
            self.kernel.run(self.kernel.now + ps)

    def line(self, text: str) -> bytes:
        """Return a line as it goes to the module, with address and checksum, or what should be there."""
        rng, address = self.rng, self.addresses[self.to]
        if address and rng.random() > 0.02:
            text = f"{address}{text}"
        data = text.encode("ascii")
        if self.checks:
            return framed(data) if rng.random() > 0.02 else data + bytes([rng.randrange(128)]) + b"\r"
        return data + b"\r"

    def send(self, data: bytes) -> None:
        """Put characters on RXD, at times with damage."""
        rng = self.rng
        damage = {}
        if rng.random() < 0.03:
            damage = {rng.randrange(len(data)): 1 << rng.randrange(10)}
        elif rng.random() < 0.01:
            damage = {rng.randrange(len(data)): rng.getrandbits(10)}
        baud = BAUDS[self.rate]
        wave = witness.characters_of(data, baud, self.kernel.now, damage)
        for module in self.modules.values():
            module.put(wave)
        cut = rng.random() < 0.006
        self.wait(rng.randint(0, witness.length_of(len(data), baud)) if cut else witness.length_of(len(data), baud))

    def ask(self, text: str, wait: bool = True) -> None:
        """Send a line, and wait for its answer."""
        rng = self.rng
        self.send(self.line(text))
        if wait and rng.random() > 0.05:
            modules = [module.x for module in self.modules.values()]
            self.kernel.run_while(lambda: not any(x.line.answering for x in modules), self.kernel.now + 40 * S)
            self.wait(rng.choice((0, 0, 0, rng.randint(0, MS))))

    def aimed(self, text: str) -> None:
        """Send a line so that it is obeyed at the very instant of something else, if there is time for that."""
        at, data = self.due(), self.line(text)
        if at is not None and self.rng.random() < 0.7:
            self.wait(at - MS - witness.length_of(len(data), BAUDS[self.rate]) - self.kernel.now)
        self.send(data)
        self.wait(2 * MS)

    # -------------------------------------------------------------------------------------------------------- compare
    def compare(self, core: library.Library, since: int = 0) -> Result:
        """Give all that came in to the core, and compare what goes out.

        Args:
            since: as of `library.Library.play`.
        """
        result = Result()
        for name, module in self.modules.items():
            model, found = module.went(), core.play(module.part, module.came(), since, module.kept, module.looks)
            baud_at = self.baud_at[name]
            result.answers += sum(code == 0x0D for _, code in found.characters)
            result.steps += len(model.times)
            result.edges += sum(map(len, model.edges.values()))
            if wrong := witness.difference(model, found, baud_at, module.rests):
                result.difference = f"seed {self.seed}, {name} ({module.part}): {wrong}"
                break
        return result


def converse(core: library.Library, seed: int, part: str | None = None) -> Result:
    """Play the dialogue of a seed on the model and on the core; return what it showed."""
    dialogue = Dialogue(seed, part)
    dialogue.play()
    return dialogue.compare(core, since=seed * 0x9E3779B97F4A7C15 % 2**64)


def run(core: library.Library, seeds: Sequence[int]) -> Result:
    """Play many dialogues; stop at the first difference."""
    whole = Result()
    for seed in seeds:
        found = converse(core, seed)
        whole.answers += found.answers
        whole.steps += found.steps
        whole.edges += found.edges
        if found.difference:
            whole.difference = found.difference
            break
    return whole

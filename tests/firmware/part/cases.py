"""Boundaries: dialogues that lead to one place of the core, for what chance reaches too seldom."""

from __future__ import annotations

import random
from collections.abc import Callable, Iterator

from slewline.language.lines import framed

from . import witness
from .dialogues import MS, PARTS, US, Dialogue, S
from .witness import BAUDS

Script = Callable[["Case"], None]
CASES: list[tuple[str, Script]] = []


class Case(Dialogue):
    """A dialogue without chance."""

    def __init__(self, part: str, script: Script) -> None:
        self.script, self.part = script, part
        self.set_up = dict(getattr(script, "set_up", {}))
        super().__init__(0, part)

    def _module(self, name: str, part: str, address: int) -> witness.Module:
        given = self.set_up
        self.rng = random.Random(0)
        self.rate, self.checks = given.get("rate", 0), given.get("checks", False)
        straps = {"br0": self.rate & 1, "br1": self.rate >> 1 & 1, "br2": self.rate >> 2 & 1, "chs": int(self.checks)}
        straps |= {pin: 0 for pin in given.get("low", ())}
        address = given.get("address", 0)
        fixed = {f"sel{n}": (7 - address) >> (2 - n) & 1 for n in range(3)} if address else {}
        self.address = address
        return witness.Module(self.bench, name, part, straps, fixed, given.get("kept", b""), given.get("looks", 0))

    def _play(self) -> None:
        self.addresses = dict.fromkeys(self.modules, self.address)
        self.wait(MS)
        self.start()
        self.script(self)

    def start(self) -> None:
        for name, module in self.modules.items():
            module.put(self.set_up.get("rxd", 0))
            module.power(True)
            self.baud_at[name][self.kernel.now] = BAUDS[self.rate]
            self.wait(500 * US)
            module.put(0)

    @property
    def module(self) -> witness.Module:
        """The module."""
        return self.modules["m0"]

    def line(self, text: str) -> bytes:
        text = f"{self.address or ''}{text}"
        return framed(text.encode("ascii"), self.checks)

    def send(self, data: bytes, damage: dict[int, int] | None = None) -> None:
        baud = BAUDS[self.rate]
        self.module.put(witness.characters_of(data, baud, self.kernel.now, damage))
        self.wait(witness.length_of(len(data), baud))

    def ask(self, text: str, wait: bool = True) -> None:
        self.send(self.line(text))
        if wait:
            self.kernel.run_while(lambda: not self.module.x.answering, self.kernel.now + 200 * S)

    def says(self, *lines: str) -> None:
        """Send lines, each after the answer to the one before."""
        for text in lines:
            self.ask(text)

    def runs(self, *lines: str, during: int = 2 * S) -> None:
        """Enter a program and let it run for a time (ps)."""
        self.says("Po" if self.is_200s else "P", *lines, "E")
        self.wait(during)

    def acts(self, text: str, at: int) -> None:
        """Send a line so that it is obeyed at an instant (ps)."""
        data = self.line(text)
        begin = at - MS - witness.length_of(len(data), BAUDS[self.rate])
        assert begin >= self.kernel.now
        self.until(begin)
        self.send(data)
        self.wait(20 * MS)

    def until(self, at: int) -> None:
        """Let time pass up to an instant (ps), if it is not over."""
        self.wait(at - self.kernel.now)

    def executes(self) -> int:
        """Send E; return the instant at which it is obeyed."""
        self.ask("E", wait=False)
        self.kernel.run_while(lambda: self.module.x._interpreter.running, self.kernel.now + S)
        return self.kernel.now

    def moves(self, *lines: str) -> list[int]:
        """Enter a program and start it; return the instants of the steps of its first motion, 200 at most."""
        self.runs(*lines, during=0)
        motion = self.module.x._interpreter.motion
        self.kernel.run_while(lambda: motion.moving and not motion.fresh, self.kernel.now + 3 * S)
        train = motion.playing.train
        return [train.end(k) for k in range(min(train.steps, 200))]

    def gone(self, letter: str) -> str:
        """Return the letter of an endless run."""
        return letter.lower() if self.is_200s else letter.upper()


def case(**set_up: object) -> Callable[[Script], Script]:
    """Make a function a case, of both parts."""

    def marked(script: Script) -> Script:
        script.set_up = set_up  # type: ignore[attr-defined]
        CASES.append((script.__name__, script))
        return script

    return marked


def all_cases() -> Iterator[tuple[str, Case]]:
    """Yield all cases on both parts."""
    for name, script in CASES:
        for part in PARTS:
            yield f"{name}, {part}", Case(part, script)


# ------------------------------------------------------------------------------------------------------------ language
@case()
def every_command_and_its_ranges(d: Case) -> None:
    d.says(
        "F",
        "V1",
        "V2",
        "Q",
        "K",
        "Z",
        "H",
        "X",
        "E",
        "Px",
        "I1",
        "I2",
        "I3",
        "I0",
        "I4",
        "f+1",
        "f-1",
        "f0",
        "V0",
        "V3",
    )
    d.says("Po", "P", "P0")
    for text in ("A", "C", "U", "W"):
        d.says(*(f"{text}{n}" for n in ("", 0, 1, 3, 4)), "Po", "P")
    for text, top in (("D", 255), ("L", 255), ("S", 1000), ("T", 1000), ("R", 999), ("j", 118)):
        d.says(*(f"{text}{n}" for n in (0, 1, top, top + 1, "01", "+1")), "Po", "P")
    d.says(
        "G0", "G+0", "G-1", "G9999999", "G10000000", "G8388607", "G8388608", "G-8388608", "G-8388609", "Q", "Po", "P"
    )
    for letter in ("g", "G"):
        d.says(*(f"{letter}{rest}" for rest in ("+", "-", "+0", "+1", "-3", "+4", "", "1", "+1,")), "Q", "Po", "P")
    d.says("jc0,0", "jc7,118", "jc8,0", "jc0,119", "jc,1", "jc1", "jc1,", "jc11", "j,1", "Q", "Po", "P")
    d.says("+0", "-0", "+1", "-1", "+999999", "+1000000", "-999999", "-1000000", "1", "+", "-", "Q", "Po", "P")
    d.says("f+8388607", "f+8388608", "f-8388608", "f-8388609", "f5", "L0", "Lo", "L", "L00", "Q", "Po", "P")
    d.says("f", "G", "g", "Po1", "Px1", "P01", "jcx", "jc1,1,", "E1", "L0", "Lo", "Lo1", "Q", "Po", "P")
    d.says("F", "V1", "V2", "M", "X", "H", "K", "Z", "I1", "I2", "A1", "Px", "A1", "E")


FORMS = (
    *(
        "A1",
        "C1",
        "D1",
        "L0",
        "L2",
        "R5",
        "S5",
        "T5",
        "U1",
        "W1",
        "+1",
        "-1",
        "G1",
        "G+",
        "G+1",
        "g+",
        "g+1",
        "j0",
        "jc7,0",
    ),
    *("f+1", "I1", "I2", "V1", "V2", "F", "Q", "X", "M", "H", "Px", "P", "Po", "Q", "E", "K", "Z"),
)


@case()
def every_command_in_every_state(d: Case) -> None:
    d.says(*FORMS)
    d.wait(S)
    d.says("P", "Po", *FORMS, "F")
    d.wait(S)
    d.runs("S50", "T60", "R3", f"{d.gone('g')}+")
    for text in FORMS:
        d.ask(text)
        d.runs("S50", "T60", "R3", f"{d.gone('g')}+", during=20 * MS)


# -------------------------------------------------------------------------------------------------------------- memory
@case()
def a_full_memory(d: Case) -> None:
    d.says("Po" if d.is_200s else "P", *["+1"] * 29, "A1", "C1", "A2", "+5", "Q", "E")


@case()
def four_more_than_fit(d: Case) -> None:
    d.says("Po" if d.is_200s else "P", *["-12345"] * 28, "A1", "+5", "+5", "A2", "Q")


@case(looks=2)
def an_eeprom_that_takes_longer(d: Case) -> None:
    d.says("Po" if d.is_200s else "P", "A1", "M", "F", "X", "Q", "Px", "M", "F")
    d.module.fail(True)
    d.says("M", "F", "X", "Q", "M")
    d.module.fail(False)
    d.says("X", "M", "X", "Q")


@case(looks=3)
def a_supply_that_fails_as_a_write_ends_after_one_that_failed(d: Case) -> None:
    for after in (-10 * MS, -1, 0, 1, 5 * MS, 10 * MS, 30 * MS):
        d.says("Po" if d.is_200s else "P", "A1", "A2", "Px" if d.is_200s else "E")
        d.module.fail(True)
        d.ask("M")
        d.module.fail(False)
        d.ask("M", wait=False)
        d.kernel.run_while(lambda: not d.module.x._eeprom.writing, d.kernel.now + S)
        d.wait(50 * MS + after)
        d.module.power(False)
        d.wait(MS)
        d.start()
        d.says("X", "Q")


@case(checks=True)
def an_eeprom_that_fails_and_checksums(d: Case) -> None:
    d.says("Po" if d.is_200s else "P", "A1", "M", "F", "X", "Q", "Px", "M", "F")
    d.module.fail(True)
    d.says("M", "F", "X", "Q", "M")
    d.module.drive("chs", 0)
    d.checks = False
    d.says("X", "M", "X", "Q")


@case()
def an_overflow_that_the_next_run_forgets(d: Case) -> None:
    d.runs("S50", "T90", "R3", "-5", "A1")
    d.runs("S50", "T90", "R3", "G+", "A1", during=MS)
    d.says("K", "F")
    d.runs("S50", "T90", "R3", "+20", "G10", "-15")
    d.says("F", "F", "E", "F", "F", "V1")


@case()
def every_instruction_in_the_eeprom(d: Case) -> None:
    d.says("Po" if d.is_200s else "P", *FORMS[:21])
    d.says("M", "Po" if d.is_200s else "P", "X", "Q")


@case(kept=b"A\1\0\0")
def no_whole_program(d: Case) -> None:
    d.says("X", "Q")


@case(kept=b"A\1C")
def an_instruction_that_is_cut_off(d: Case) -> None:
    d.says("X", "Q")


# -------------------------------------------------------------------------------------------------------------- motion
SLOW = ("S10", "T30", "R4")
AFTER = (-1, 0, 1, 1_000_000, 1_699_999, 1_700_000, 1_700_001, 50 * MS)  # a step


@case()
def moves_of_few_steps(d: Case) -> None:
    for ramp in ("R1", "R2", "R3", "R4"):
        d.runs("S20", "T90", ramp, *(f"+{n}" for n in range(1, 12)), "G0", "G0", "G1", "-1")
    for speeds in (("S90", "T90"), ("S90", "T20"), ("S1000", "T1000"), ("S999", "T1000")):
        d.runs(*speeds, "R3", "+1", "-2", "+9", "G4", "G4")


@case()
def ramps_of_1_and_999_steps(d: Case) -> None:
    d.runs(
        "S100",
        "T1000",
        "R999",
        "+1997",
        "-1998",
        "+1999",
        "-2000",
        "+2001",
        "R1",
        "+1",
        "+2",
        "+3",
        "-4",
        "-5",
        during=9 * S,
    )


@case()
def intervals_half_way_between_two_picoseconds(d: Case) -> None:
    d.runs("S1", "T9", "R777", "+1600", during=90 * S)
    d.runs("S31", "T279", "R777", "+1600", during=9 * S)
    d.runs("S32", "T135", "R999", "+2100", during=9 * S)
    d.ask("F")


@case()
def a_run_of_a_million_steps(d: Case) -> None:
    d.runs("S900", "T1000", "R7", d.gone("G") + "+", during=101 * S)
    d.says("Z", "F", "V1")
    d.runs("S1000", "A1")
    d.ask("H")
    d.wait(101 * S)
    d.says("F", "K", "V1")


@case()
def k_around_a_step(d: Case) -> None:
    for step in (1, 3, 8, 9):
        for after in AFTER:
            d.acts("K", d.moves(*SLOW, "+10", "A1")[step] + after)
            d.says("F", "V1")


@case()
def z_around_a_step(d: Case) -> None:
    for step in (1, 2, 3, 4, 5, 7, 8, 9):
        for after in (-1, 0, 1_700_000, 50 * MS):
            d.acts("Z", d.moves(*SLOW, "+10", "A1")[step] + after)
            d.wait(S)
            d.says("F", "V1")


@case()
def z_and_k_before_the_first_step(d: Case) -> None:
    for end in ("Z", "K"):
        for after in (-10_000_001, -10_000_000, -9_999_999, -1, *AFTER[1:-1]):
            d.says("Po" if d.is_200s else "P", *SLOW, "D1", "+10", "A1")
            d.acts(end, d.executes() + 105 * MS + 10_000_000 + after)
            d.says("F", "V1")


@case()
def z_at_the_slew_rate(d: Case) -> None:
    for line in ("+60", d.gone("g") + "+", d.gone("g") + "-1", "-40"):
        for step in (1, 3, 4, 5, 6, 20, 30):
            d.says("I1")
            start = "+100" if line[-2:] == "-1" or line == "-40" else "+1"
            d.runs("S90", "T90", "R1", start, during=2 * S)
            steps = d.moves(*SLOW, line, "A1")
            d.acts("Z", steps[step])
            d.wait(2 * S)
            d.says("V1", "F")


@case()
def enable_around_a_step(d: Case) -> None:
    for step in (0, 1, 4, 8, 9):
        for after in (-1, 0, 1, 1_700_000):
            for width in (1, 4_999_999, 5_000_000, 90 * MS):
                at = d.moves(*SLOW, "+10", "A1")[step] + after
                if at > d.kernel.now:
                    d.module.drive("enable", 0, at)
                    d.module.drive("enable", 1, at + width)
                    d.module.drive("enable", 0, at + width + 200 * MS)
                    d.module.drive("enable", 1, at + width + 200 * MS + 3)
                    d.module.drive("enable", 0, at + width + 200 * MS + 5_000_003)
                    d.module.drive("enable", 1, at + width + 200 * MS + 5_000_004)
                d.wait(2 * S)


@case()
def orders_while_enable_holds(d: Case) -> None:
    for end in ("Z", "K", "F"):
        for step in (0, 1, 3, 6, 9):
            for line in ("+10", d.gone("g") + "+1", d.gone("g") + "+"):
                at = d.moves(*SLOW, line, "A1", "C1")[step]
                d.until(at - 1)
                d.module.drive("enable", 0)
                d.wait(100 * MS)
                d.ask(end)
                d.module.drive("ui1", 0)
                d.wait(3 * MS)
                d.module.drive("enable", 1)
                d.wait(S)
                d.module.drive("ui1", 1)
                d.says("K", "V1")


@case()
def inputs_that_end_a_run(d: Case) -> None:
    for number in (1, 2, 3):
        for at in (0, 1, MS - 1, MS, MS + 1, 10_000_000, 77 * MS):
            first = d.moves(*SLOW, f"{d.gone('g')}+{number}", "A1", "C1")[0] - 10_000_000
            d.module.drive(f"ui{number}", 0, max(first + 100 * MS + at, d.kernel.now))
            d.module.drive(f"ui{number}", 1, max(first + 100 * MS + at, d.kernel.now) + MS - 1)
            d.wait(S)
            d.module.drive(f"ui{number}", 0)
            d.wait(S)
            d.runs(*SLOW, f"{d.gone('g')}-{number}", "A2")
            d.module.drive(f"ui{number}", 1)
            d.says("V1", "F")


@case()
def a_run_without_ramps_that_an_input_ends(d: Case) -> None:
    for speeds in (("S50", "T20"), ("S20", "T20"), ("S10", "T90")):
        for number in (1, 2):
            d.runs(*speeds, "R3", f"{d.gone('g')}+{number}", "D1", "A1", "D1", "C1", during=80 * MS)
            d.module.drive(f"ui{number}", 0)
            d.wait(S)
            d.module.drive(f"ui{number}", 1)
            d.module.drive("enable", 0)
            d.runs(*speeds, "R3", f"{d.gone('g')}+{number}", "D1", "A1", "D1", "C1", during=80 * MS)
            d.module.drive(f"ui{number}", 0)
            d.wait(S)
            d.module.drive("enable", 1)
            d.module.drive(f"ui{number}", 1)
            d.says("F", "V1", "V2")


@case()
def a_run_that_an_input_ended_does_not_end_the_next_motion(d: Case) -> None:
    for end in ("Z", "K"):
        for line in (f"{d.gone('g')}+1", f"{d.gone('g')}-1"):
            d.module.drive("ui1", 1)
            d.runs("S40", "T90", "R3", "+30", line, "A1", during=S)
            d.ask(end)
            d.wait(S)
            d.runs("S4", "T9", "R3", "+80", "-20", during=300 * MS)
            d.module.drive("ui1", 0)
            d.wait(2 * S)
            d.says("V1", "F")
    d.module.drive("ui1", 1)
    d.ask("I1")
    d.runs("S90", "T90", "R1", "+5", f"{d.gone('g')}-1", "A1", during=S)  # to the end of the counter of a GS-C200
    d.ask("F")
    d.runs("S4", "T9", "R3", "+80", during=300 * MS)
    d.module.drive("ui1", 0)
    d.wait(2 * S)
    d.says("K", "V1", "F")


@case()
def z_and_k_in_the_time_of_an_instruction(d: Case) -> None:
    for end in ("Z", "K"):
        for after in (1, 300_000_000, 999_999_999):
            d.says("Po" if d.is_200s else "P", *SLOW, "D1", "+10", "A1", "+3")
            d.acts(end, d.executes() + 104 * MS + after)
            d.wait(2 * S)
            d.says("F", "V1", "V2")


@case()
def enable_while_k_waits_for_the_end_of_a_pulse(d: Case) -> None:
    for step in (1, 4, 9):
        for level, again in ((0, 1), (1, 0), (0, 0)):
            at = d.moves(*SLOW, "+10", "A1")[step]
            d.module.drive("enable", level, at + 700_000)
            d.module.drive("enable", again, at + 900_000)
            d.acts("K", at + 500_000)
            d.module.drive("enable", 1)
            d.says("F", "V1")


# -------------------------------------------------------------------------------------------------------------- homing
@case()
def homing_with_switches_around_a_step(d: Case) -> None:
    d.runs("S10", "T30", "R4", "+3")
    for direction in ("H", "H+", "H-"):
        for after in (-1, 0, 1):
            for home in (-1, 0, 1):
                d.ask(direction)
                d.wait(55 * MS)
                step = d.module.x._interpreter.motion.playing.train.end(1) + 10 * 10**10
                d.module.drive("eot", 0, step + after)
                d.module.drive("home", 0, step + 10_000_000 + 3 * 10**10 + home)
                d.wait(S)
                d.module.drive("eot", 1)
                d.module.drive("home", 1)
                d.says("F", "V1", "Q")
                d.runs("S10", "T30", "R4", "+3")


@case()
def homing_that_begins_or_turns_at_a_switch(d: Case) -> None:
    for eot, home in ((0, 0), (0, 1), (1, 0)):
        d.runs("S10", "T30", "R4", "+3")
        d.module.drive("eot", eot)
        d.module.drive("home", home)
        d.says("H+", "F", "V1")
        d.wait(55 * MS)
        d.module.drive("eot", 0)
        d.wait(55 * MS)
        d.module.drive("home", 0)
        d.wait(55 * MS)
        d.says("F", "V1", "Q", "H-", "F")
        d.module.drive("eot", 1)
        d.module.drive("home", 1)


@case()
def homing_that_is_ended_or_held(d: Case) -> None:
    for end in ("K", "Z"):
        for after in AFTER[:-1]:
            d.runs("S10", "T30", "R4", "+3", "-7")
            d.ask("H-")
            step = d.module.x._interpreter.motion.playing.train.end(4)
            d.acts(end, step + after)
            d.says("F", "V1", "Q")
    d.runs("S10", "T30", "R4", "+3")
    d.ask("H")
    d.module.drive("enable", 0)
    d.wait(30 * MS)
    d.module.drive("eot", 0)
    d.wait(30 * MS)
    d.module.drive("enable", 1)
    d.wait(30 * MS)
    d.module.drive("enable", 0)
    d.module.drive("home", 0)
    d.wait(30 * MS)
    d.ask("F")
    d.module.drive("enable", 1)
    d.wait(30 * MS)
    d.says("F", "V1")


PROGRAM = b"S\x14\0\0T\x28\0\0R\3\0\0+\5\0\0A\1"


@case(kept=PROGRAM, low=("rec", "eot", "home"))
def a_stand_alone_start_at_home(d: Case) -> None:
    d.wait(S)
    d.says("F", "V1", "V2", "Q")


@case(kept=PROGRAM, low=("rec",), rxd=1)
def a_stand_alone_start_that_goes_the_other_way(d: Case) -> None:
    for pin in ("eot", "home"):
        d.wait(55 * MS)
        d.module.drive(pin, 0)
    d.wait(S)
    d.says("F", "V1", "V2", "Q")


@case(kept=PROGRAM[4:], low=("rec",))
def a_stand_alone_start_without_s(d: Case) -> None:
    d.wait(100 * MS)
    d.says("F", "Q", "E")


@case(kept=PROGRAM[:4] + PROGRAM[12:], low=("rec",))
def a_stand_alone_start_without_t(d: Case) -> None:
    d.wait(100 * MS)
    d.says("F", "Q", "E")


@case(low=("rec",))
def a_stand_alone_start_without_a_program(d: Case) -> None:
    d.wait(100 * MS)
    d.says("F", "Q", "E")


# ------------------------------------------------------------------------------------------------------------ programs
@case()
def inputs_in_programs(d: Case) -> None:
    for number in (1, 2, 3):
        for level in (0, 1):
            d.module.drive(f"ui{number}", level)
            d.runs("S20", "T40", "R3", f"W{number}", "+2", f"U{number}", "A1", during=300 * MS)
            d.module.drive(f"ui{number}", 1 - level)
            d.wait(300 * MS)
            d.says("F", "V2", "K")
            d.module.drive(f"ui{number}", level)
            d.runs(f"U{number}", "S20", "T40", "R3", "A2", "+2", "C2", during=300 * MS)
            d.module.drive(f"ui{number}", 0)
            d.wait(300 * MS)
            d.says("F", "V2", "K")
            d.module.drive(f"ui{number}", 1)


@case()
def waits_that_end_at_a_sample(d: Case) -> None:
    for at in (-1, 0, 1):
        d.module.drive("ui2", 0)
        d.runs("A1", "W2", "C1", during=0)
        rises = d.kernel.now
        d.kernel.run_while(lambda: d.module.x.pins["uo1"].level == 1, rises + S)
        sample = d.kernel.now + MS + 7 * MS
        d.module.drive("ui2", 1, sample + at)
        d.module.drive("ui2", 0, sample + at + MS // 2)
        d.wait(20 * MS)
        d.ask("F")
        d.module.drive("ui2", 1)
        d.wait(5 * MS)


@case()
def loops_and_jumps(d: Case) -> None:
    d.runs("S90", "T90", "R1", "L0", "+1", "L3", "-2", "L2", "A1", during=2 * S)
    d.runs("S90", "T90", "R1", "+1", "L2", "-2", "L3", "A1", during=2 * S)
    d.runs("L0", "A1", "L0", "C1", "L2", "L2", "L1", "L255", "A1", during=3 * S)
    if d.is_200s:
        for levels in range(8):
            for bit in range(3):
                d.module.drive(f"ui{bit + 1}", levels >> bit & 1)
            d.runs("jc0,6", "jc3,12", "j14", "A1", "A2", "j18", "A3", "D1", "j99", "C1", during=300 * MS)
            d.says("V2", "I2")
        d.runs("j3", "A1")
        d.runs("A1", "j118")
        d.runs("A1", "j4", "j118", "A2")
        d.runs("L0", "A1", "jc7,8", "L5", "C1", "L2", "A2")
        d.runs("A1", "f+5", "I1", "A2", "I3", "C1", "I2", "G-7")


@case()
def a_loop_that_is_killed(d: Case) -> None:
    d.runs("A1", "L0", "C1", "A1", "L200", during=30 * MS)
    d.ask("K")
    d.runs("A2", "L3", "C2", during=100 * MS)
    d.says("V2", "F")


@case()
def the_end_of_the_reset_pulse_of_a_command(d: Case) -> None:
    for text in ("I1", "I3", "I2"):
        for gap in (0, 100 * US, 399 * US):
            d.ask(text, wait=False)
            d.wait(MS + gap)
            d.module.drive("enable", 1)
            d.ask("F")


# ----------------------------------------------------------------------------------------------------------- the line
@case()
def lines_that_come_too_soon(d: Case) -> None:
    for lines in (
        ("V1", "V2", "F"),
        ("V1", "", "F"),
        ("Q", "F", "V1", "F"),
        ("M", "F", "V2", "F"),
        ("", "F"),
        ("K", "Z", "F"),
    ):
        d.send(b"".join(d.line(text) for text in lines))
        d.wait(S)
    for number in range(2, 9):
        d.send(b"F\rV1\r" + b"V2\r" * number)
        d.wait(S)


@case(rate=7)
def answers_to_m_that_wait(d: Case) -> None:
    d.says("Po" if d.is_200s else "P", "A1", "M")
    for gap in range(0, 500, 60):
        for lines in (("M", "F"), ("M", "M", "F"), ("F", "M", "V2"), ("M", "Q", "F")):
            for text in lines:
                d.ask(text, wait=False)
                d.wait(gap * MS)
            d.wait(4 * S)


@case(address=3)
def a_line_of_several_modules(d: Case) -> None:
    d.says("V2", "F", "Q")
    for text in (
        b"3\r",
        b"\r",
        b"3V1\r",
        b"2V1\r",
        b"V1\r",
        b"33V1\r",
        b"4F\r",
        b"0F\r",
        b"3123456789A\r",
        b"31234567890\r",
        b"312345678901\r",
    ):
        d.send(text)
        d.wait(20 * MS)
    for number in range(4):
        for bit in range(10):
            d.send(b"3V1\r", {number: 1 << bit})
            d.wait(30 * MS)


@case(checks=True)
def checksums(d: Case) -> None:
    d.says("V1", "F", "Q", "V2")
    for text in (
        b"\r",
        b"\x10\r",
        b"\x11\r",
        b"F\r",
        b"FV\r",
        b"V\r",
        b"FF\r",
        b"1234567890\x10\r",
        b"12345678901\r",
        b"A2s\r",
        b"f-8388608\x7f\r",
    ):
        d.send(text)
        d.wait(20 * MS)
    for number in range(3):
        for bit in range(10):
            d.send(b"FV\r", {number: 1 << bit})
            d.wait(30 * MS)
    d.module.drive("chs", 0)
    d.send(b"FV\r")
    d.wait(20 * MS)
    d.send(b"F\r")
    d.wait(20 * MS)


@case(checks=True, address=7)
def checksums_and_addresses(d: Case) -> None:
    d.says("V1", "F", "Q", "V2", "A1", "E")
    for text in (b"7\r", b"77\r", b"7F\r", b"7F}\r", b"17\r", b"7G\x17\r"):
        d.send(text)
        d.wait(20 * MS)


@case()
def damaged_characters(d: Case) -> None:
    for number in range(3):
        for bit in range(10):
            d.send(b"V1\r", {number: 1 << bit})
            d.wait(30 * MS)
    d.send(b"12345678901\r" + b"1" * 12 + b"\r")
    d.wait(30 * MS)
    d.send(b"1" * 13 + b"\r", {12: 1 << 3})
    d.wait(30 * MS)
    d.ask("F")


def rate_case(rate: int) -> None:
    """Make the case of a rate."""

    @case(rate=rate)
    def script(d: Case) -> None:
        d.says("F", "V2", "Q")

    CASES[-1] = f"rate_{BAUDS[rate]}", script


for _rate in BAUDS:
    rate_case(_rate)


def address_case(address: int) -> None:
    """Make the case of an address."""

    @case(address=address)
    def script(d: Case) -> None:
        d.says("F", "V2")
        for other in range(10):
            d.send(b"%dF\r" % other)
            d.wait(10 * MS)

    CASES[-1] = f"address_{address}", script


for _address in range(1, 8):
    address_case(_address)


# ------------------------------------------------------------------------------------------------ the position counter
@case()
def the_ends_of_the_counter(d: Case) -> None:
    if d.is_200s:
        for start in (8388607, 8388606, -8388608, -8388607):
            for move in ("+1", "-1", "+3", "-3", "G0", "G-8388608", "G8388607"):
                d.says("I2", f"f{start:+d}")
                d.runs("S1000", "T1000", "R1", move, during=100 * MS)
                d.says("V1", "Z", "V1", "K", "V1")
    else:
        for lines in (
            ("-1",),
            ("+3", "-3", "-1"),
            ("+3", "-4"),
            ("+3", "G-"),
            ("+3", "G-1"),
            ("G9999999",),
            ("G3", "G0"),
            ("+999999",),
        ):
            d.says("I1")
            d.runs("S90", "T300", "R4", *lines, "A1", during=S)
            d.says("F", "F", "Z", "V1", "V2", "K", "I3", "V1")


@case()
def a_stop_at_the_end_of_the_counter(d: Case) -> None:
    if d.is_200s:
        return d.ask("F")
    for limit in range(2, 14):
        for step in range(limit):
            d.says("I1")
            d.runs("S90", "T90", "R1", f"+{limit}", during=S)
            steps = d.moves("S20", "T60", "R4", "G-", "A1")
            d.acts("Z", max(steps[step] + 1, d.kernel.now + 10 * MS))
            d.wait(S)
            d.says("F", "V1")
    return None


@case()
def power_cuts(d: Case) -> None:
    for step in (0, 3, 9):
        for after in AFTER:
            at = d.moves(*SLOW, "+10", "A1")[step] + after
            if at > d.kernel.now:
                d.until(at)
            d.module.power(False)
            d.wait(MS)
            d.start()
            d.says("F", "V1")
    for after in (0, MS, 10 * MS, 15 * MS, 20 * MS, 29 * MS, 30 * MS, 40 * MS, 50 * MS):
        d.says("Po" if d.is_200s else "P", f"A{1 + after // MS % 3}", "C1", "M", "Px" if d.is_200s else "E")
        d.says("Po" if d.is_200s else "P", "D5", "C2")
        d.send(d.line("M"))
        d.wait(MS + after)
        d.module.power(False)
        d.wait(MS)
        d.start()
        d.says("X", "Q", "M", "X", "Q")


def _kept(name: str, content: bytes) -> None:
    """Add a case: a memory whose content could not be entered, or just so."""

    @case(kept=content, low=("rec", "eot", "home"))
    def script(d: Case) -> None:
        d.wait(S)
        d.says("K", "X", "Q", "F", "E", "F")

    script.__name__ = CASES[-1][0]
    CASES[-1] = (f"kept_{name}", script)


for _name, _content in {
    "a_direction_and_what_nobody_reads": b"g\1\7\7",
    "a_direction_an_input_and_what_nobody_reads": b"x\1\2\7",
    "a_start_of_a_loop_and_what_nobody_reads": b"l\7L\2",
    "a_start_of_a_loop_that_is_cut_off": b"l",
    "a_speed_of_65546": b"S\x0a\0\1",
    "a_top_speed_of_65546": b"T\x0a\0\1",
    "a_ramp_of_65546": b"R\x0a\0\1",
    "a_move_of_65546": b"+\x0a\0\1",
    "direction_0": b"g\0\0\0",
    "direction_0_to_an_input": b"x\0\1\0",
    "direction_2": b"g\2\0\0",
    "input_4": b"x\1\4\0",
    "input_0": b"W\0",
    "output_0": b"A\0",
    "delay_0": b"D\0",
    "passes_0": b"L\0",
    "no_start_stop_speed": b"S\0\0\0",
    "a_start_stop_speed_too_high": b"S\xe9\3\0",
    "the_highest_start_stop_speed": b"S\xe8\3\0",
    "a_ramp_of_1000": b"R\xe8\3\0",
    "a_ramp_of_999": b"R\xe7\3\0",
    "a_move_of_0": b"+\0\0\0",
    "a_move_of_a_million": b"+\x40\x42\x0f",
    "a_move_of_a_million_back": b"+\xc0\xbd\xf0",
    "a_position_of_the_other_part": b"G\xe1\xff\xff",
    "a_position_of_10_million": b"G\x80\x96\x98",
    "the_highest_position": b"G\x7f\x96\x98",
    "a_jump_to_119": b"j\x77",
    "a_jump_to_118": b"j\x76",
}.items():
    _kept(_name, PROGRAM[:12] + _content)


# ------------------------------------------------------------------------------------------------------------- program
@case()
def every_jump_on_every_input(d: Case) -> None:
    d.says(
        "Po" if d.is_200s else "P",
        *(f"jc{number},{4 * number + 4}" if n else f"A{1 + number % 3}" for number in range(8) for n in (1, 0)),
    )
    for levels in range(8):
        for n in range(3):
            d.module.drive(f"ui{n + 1}", levels >> n & 1)
        d.module.drive("home", levels & 1)
        d.module.drive("eot", 1 - (levels & 1))
        for number in range(8):
            d.runs(f"jc{number},4", "A1", "A2", during=20 * MS)
            d.says("V2", "I2")


@case()
def outputs_that_are_cleared(d: Case) -> None:
    for what in ("I1", "I2", "I3"):
        d.runs("A1", "A2", "A3", during=20 * MS)
        d.says("V2", what, "V2")
        d.runs("A1", "A2", "A3", what, "D1", during=S)
        d.says("V2", "C1", "I2")
        for number in (1, 2, 3):
            d.runs(f"A{number}", during=20 * MS)
            d.says("V2", what, "V2", "I2")


@case()
def a_program_does_not_repeat_what_another_one_has_repeated(d: Case) -> None:
    for end in ("K", "Z"):
        d.runs("U1", "A1", "D1", "C1", during=S)
        d.says("F", end, "F")
        d.runs("A2", "D1", "C2", during=S)
        d.says("F", "V2", "K")


@case()
def motions_without_speeds(d: Case) -> None:
    for line in ("+1", "G5", *(d.gone("g") + rest for rest in ("+", "-", "+1", "-3"))):
        for speeds in ((), ("S50",), ("S50", "T60"), ("T60", "R3"), ("S50", "R3")):
            d.says("Po" if d.is_200s else "P", *speeds, line, "E", "F", "K")


@case()
def every_command_in_every_spelling(d: Case) -> None:
    heads = ("A", "C", "D", "E", "F", "G", "H", "I", "K", "L", "M", "P", "Q", "R", "S", "T", "U", "V", "W", "X", "Z")
    rests = (
        "",
        "1",
        "+1",
        "-1",
        "01",
        "+01",
        "+",
        "-",
        "0",
        "+0",
        "1,1",
        "+1,1",
        "1+",
        "+,1",
        "o",
        "0o",
        "1o",
        "x",
        " 1",
    )
    for entering in (False, True):
        for head in (*heads, "", "f", "g", "j", "jc"):
            for rest in rests:
                if head in ("P", "M", "E", "X", "H") and not rest.strip("+-"):
                    continue
                if entering:
                    d.ask("Po" if d.is_200s else "P")
                d.ask(head + rest)
            d.ask("Q")
    d.ask("Po" if d.is_200s else "P")
    for code in (*range(1, 10), 11, 12, *range(14, 32)):
        d.ask(f"L{chr(code)}")

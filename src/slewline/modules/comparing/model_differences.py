"""Differences between a module and its model, in every answer and every delay of a dialogue.

Delays differ if their difference exceeds a tolerance: a fixed part for the transfer of a character into
a computer, and a fraction of the time for the errors of both clocks (docs/howto/proxy_and_compare.md has
their sources).  An answer that depends on the instant of its query, such as the state of a motion,
agrees if the model gives the same answer to a query that is earlier or later by no more than the
tolerance.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass, field
from statistics import median
from typing import TYPE_CHECKING, Any, Literal, NamedTuple

from ...core.messages.whole import counted
from ..deviations import deviations
from ..dialogue import RecordedDialogue
from ..spoken import Speech
from .exchanges import RecordedExchange, commands, exchanges_of
from .replay import ModelAnswer, ModelReplay
from .shown_memory import memory_of

if TYPE_CHECKING:
    from ...core.chip import Chip

ADAPTER_US = 16_000  # longest delay of a character in a USB adapter
SYSTEM_US = 4_000  # two frames of USB, a proxy, and the wake-up of a program
FIFO_CHARACTERS = 4  # silence after which a UART reports a FIFO below its trigger level
RESONATOR, CRYSTAL = 0.005, 0.0002  # error of a part's clock: a ceramic resonator, a known crystal
LATER = 20  # differing answers per dialogue whose queries are tried earlier and later
SHOWN = 60  # characters of an answer per line of the report

Kind = Literal["answer", "listing", "delay", "duration"]


class Tolerance(NamedTuple):
    """The allowed difference between two times: a number of µs, plus a fraction of the longer time."""

    fixed_us: float
    share: float

    def allows(self, one_us: float, other_us: float) -> bool:
        """Return whether the difference between two times (µs) is within the tolerance."""
        return abs(one_us - other_us) <= self.fixed_us + self.share * max(one_us, other_us)

    def __str__(self) -> str:
        return f"{self.fixed_us / 1000:g} ms plus {self.share:.2%}"


def usual_tolerance(speech: Speech, crystal_hz: int | None) -> Tolerance:
    """Return the tolerance for a USB adapter, at the rate of the line; a known crystal makes it smaller."""
    fixed_us = ADAPTER_US + SYSTEM_US + FIFO_CHARACTERS * speech.character_s * 1e6
    return Tolerance(round(fixed_us), RESONATOR if crystal_hz is None else CRYSTAL)


class DialogueDifference(NamedTuple):
    """A difference between module and model.

    `line` counts the lines of a listing from 1; it is 0 for an answer of one line.  `module` and `model` are answers,
    or times in µs.
    """

    exchange: int
    at_us: int
    command: str
    kind: Kind
    module: str | float
    model: str | float
    line: int = 0

    def __str__(self) -> str:
        where = f"exchange {self.exchange} at {self.at_us / 1e6:.3f} s, {self.command}"
        if isinstance(self.module, str):
            of = f", line {self.line} of the answer" if self.line else ""
            return f"{where}{of}: module {_shown(self.module)}, model {_shown(str(self.model))}"
        what = "answer" if self.kind == "delay" else "whole answer"
        module_ms, model_ms = self.module / 1000, float(self.model) / 1000
        return f"{where}: {what} of the module after {module_ms:.1f} ms, of the model after {model_ms:.1f} ms"


def _shown(answer: str) -> str:
    if not answer:
        return "no answer"
    text = answer if len(answer) <= SHOWN else f"{answer[:SHOWN]}..."
    return text.encode("unicode_escape").decode("ascii")


@dataclass
class Differences:
    """The result of a comparison.

    `is_timed`: whether times are compared; `moments`: the number of answers that agree only if the query is
    shifted within the tolerance; `delays_us`: the delays of the module minus those of the model, for each
    exchange that both have answered.  `deviations` are the module's deviations from the sheet, each with the
    numbers of its exchanges; `from_before` are queries for values that the module may have held since before
    the dialogue; `shown` counts the bytes of memory loaded into the model because the dialogue lists them.
    """

    part: str
    tolerance: Tolerance
    exchanges: int
    is_timed: bool = True
    rows: list[DialogueDifference] = field(default_factory=list)
    moments: int = 0
    delays_us: list[float] = field(default_factory=list)
    findings: list[tuple[int, str, str]] = field(default_factory=list)  # exchange, code and text
    deviations: dict[str, list[int]] = field(default_factory=dict)
    from_before: list[str] = field(default_factory=list)
    shown: int = 0

    @property
    def agree(self) -> bool:
        """True if there is no difference."""
        return not self.rows

    def as_json(self) -> dict[str, Any]:
        """Return the result as data for JSON."""
        delays: dict[str, Callable[[Iterable[float]], float]] = {"least": min, "median": median, "greatest": max}
        return {
            "part": self.part,
            "exchanges": self.exchanges,
            "agree": self.agree,
            "tolerance_us": self.tolerance.fixed_us,
            "tolerance_share": self.tolerance.share,
            "differences": [row._asdict() for row in self.rows],
            "agree_at_another_moment": self.moments,
            "module_less_model_us": {
                name: round(what(self.delays_us), 1) if self.delays_us else None for name, what in delays.items()
            },
            "deviations": [{"exchanges": numbers, "text": deviation} for deviation, numbers in self.deviations.items()],
            "held_before": self.from_before,
            "memory_bytes": self.shown,
            "findings": [{"exchange": number, "code": code, "text": text} for number, code, text in self.findings],
        }

    def __str__(self) -> str:
        times = (
            f"times may differ by {self.tolerance}"
            if self.is_timed
            else "times are those of the adapter, and are not compared"
        )
        rows = [
            f"{self.part}: {self.exchanges} exchanges, {counted(len(self.rows), 'difference')}; {times}",
            *map(str, self.rows),
        ]
        if self.moments:
            answers = counted(self.moments, "answer")
            rows.append(f"{answers} would agree if the model were queried slightly earlier or later")
        if self.delays_us:
            least, middle, most = (
                round(what(self.delays_us) / 1000, 1) + 0.0 for what in (min, median, max)
            )  # no -0.0
            rows.append(f"answers of the module later by {least:.1f} to {most:.1f} ms, median {middle:.1f} ms")
        for deviation, numbers in self.deviations.items():
            more = f" and {len(numbers) - 1} more" if len(numbers) > 1 else ""
            rows.append(f"exchange {numbers[0]}{more}, the module: {deviation}")
        if self.from_before:
            rows.append(
                f"{', '.join(self.from_before)}: no earlier line sets this value; the module may have kept an "
                "older value, and the model begins as after power-up"
            )
        if self.shown:
            rows.append(
                f"the model's memory has {self.shown} bytes from listings of the dialogue; --memory replaces it"
            )
        rows += [f"exchange {number}, the model: {code}: {text}" for number, code, text in self.findings]
        return "\n".join(rows)


class DialogueComparison:
    """A comparison of a dialogue with the model.

    Args:
        dialogue: the recorded dialogue.
        speech: the protocol of the module.
        tolerance: the allowed difference of times; None: `usual_tolerance`.
        options: the options of the model.
        memory: a file with an image of the memory of the chip; None: the bytes that the dialogue lists.
        cls: the class of the chip, as for `ModelLine`.
        progress: called from time to time with the number of the current exchange.

    Raises:
        UsageError: the model does not have such straps, crystal or options.
    """

    def __init__(
        self,
        dialogue: RecordedDialogue,
        speech: Speech,
        tolerance: Tolerance | None = None,
        options: Mapping[str, Any] | None = None,
        memory: str | None = None,
        cls: type[Chip] | None = None,
        progress: Callable[[int], object] = lambda _number: None,
    ) -> None:
        self.cls = cls
        self.header, self.speech, self.options, self.memory = dialogue.header, speech, options, memory
        self.tolerance = tolerance or usual_tolerance(speech, dialogue.header.crystal_hz)
        self.exchanges = exchanges_of(dialogue.entries, speech)
        self.shown = memory_of(self.exchanges, speech) if memory is None else b""
        self.progress = progress
        self.asked_again = 0

    def compare(self) -> Differences:
        """Play the dialogue to the model, and return the differences."""
        found = Differences(self.header.part, self.tolerance, len(self.exchanges), self.speech.is_timed)
        found.shown = len(self.shown)
        answers = self.played(len(self.exchanges))
        for exchange, answer in zip(self.exchanges, answers, strict=True):
            found.findings += dict.fromkeys((exchange.number, each.code, each.text) for each in answer.findings)
            if exchange.answer != answer.answer:
                if self._at_another_moment(exchange):
                    found.moments += 1
                else:
                    found.rows += self._answer_rows(exchange, answer)
                    self._explain(exchange, found)
            if self.speech.is_timed and exchange.delay_us is not None and answer.delay_us is not None:
                found.delays_us.append(exchange.delay_us - answer.delay_us)
                found.rows += self._time_rows(exchange, answer)
        return found

    def played(self, count: int, shift_us: float = 0) -> list[ModelAnswer]:
        """Return the model's answers to the first `count` exchanges; the last one is sent `shift_us` late."""
        replay = ModelReplay(self.header, self.speech, self.options, self.memory, self.cls, self.shown)
        replay.progress = self.progress
        return replay.play(self.exchanges[:count], lambda *both: bool(self._time_rows(*both)), shift_us)

    # ---------------------------------------------------------------------------------------------------------- times
    def _time_rows(self, exchange: RecordedExchange, answer: ModelAnswer) -> list[DialogueDifference]:
        """Return the difference in time between the module's answer and the model's, as a list of at most one row.

        The row contains the delays if they differ by more than the tolerance.  Otherwise it contains the
        durations, if they differ by more than the tolerance although the answers are equal.  The list is empty
        if both agree, for a part with an adapter, or if an answer is missing.
        """
        delay_us, model_us = exchange.delay_us, answer.delay_us
        if delay_us is None or model_us is None or not self.speech.is_timed:
            return []
        if not self.tolerance.allows(delay_us, model_us):
            return [self._row(exchange, "delay", round(delay_us, 1), round(model_us, 1))]
        if exchange.answer == answer.answer and not self.tolerance.allows(exchange.duration_us, answer.duration_us):
            return [self._row(exchange, "duration", exchange.duration_us, round(answer.duration_us, 1))]
        return []

    def _row(
        self, exchange: RecordedExchange, kind: Kind, module: str | float, model: str | float, line: int = 0
    ) -> DialogueDifference:
        command = " ".join(commands(self.speech, exchange.sent)) or "an empty line"
        return DialogueDifference(exchange.number, exchange.at_us, command, kind, module, model, line)

    # -------------------------------------------------------------------------------------------------------- answers
    def _answer_rows(self, exchange: RecordedExchange, answer: ModelAnswer) -> list[DialogueDifference]:
        """Return the differences, line by line, between the module's answer and the model's."""
        module, model = (
            data.decode("latin-1").replace("\r\n", "\r").removesuffix("\r").split("\r")
            for data in (exchange.answer, answer.answer)
        )
        if len(module) == len(model) == 1 and module != model:
            return [self._row(exchange, "answer", module[0], model[0])]
        if module == model:  # except the ends of their lines
            return [self._row(exchange, "answer", exchange.answer.decode("latin-1"), answer.answer.decode("latin-1"))]
        lines = max(len(module), len(model))
        pairs = zip(_filled(module, lines), _filled(model, lines), strict=True)
        return [
            self._row(exchange, "listing", own, theirs, number)
            for number, (own, theirs) in enumerate(pairs, start=1)
            if own != theirs
        ]

    def _explain(self, exchange: RecordedExchange, found: Differences) -> None:
        """Record the cause of a differing answer: a deviation from the sheet, or a value set before the dialogue."""
        sent = commands(self.speech, exchange.sent)
        if not sent or not exchange.answer:
            return
        deviation = deviations(self.speech, sent[-1], exchange.answer)
        if deviation:
            found.deviations.setdefault(deviation, []).append(exchange.number)
        elif self._is_from_before(exchange.number, sent[-1]) and sent[-1] not in found.from_before:
            found.from_before.append(sent[-1])

    def _is_from_before(self, number: int, command: str) -> bool:
        """Return whether a query reads a register that no earlier line of the dialogue can have changed."""
        names = {register.letter for register in self.speech.sheet.registers}
        letter = command[-1:]
        row = self.speech.row(command)
        if row is None or row.role != "question" or letter not in names:
            return False
        before = [each for one in self.exchanges[: number - 1] for each in commands(self.speech, one.sent)]
        return not any(each.startswith(letter) or self.speech.moves(each) for each in before)

    def _at_another_moment(self, exchange: RecordedExchange) -> bool:
        """Return whether the model gives the module's answer if the query comes earlier or later by the tolerance."""
        if not exchange.answer or self.asked_again >= LATER:
            return False
        self.asked_again += 1
        allowed_us = self.tolerance.fixed_us + self.tolerance.share * self._since_motion_us(exchange)
        early, late = (self.played(exchange.number, shift_us)[-1].answer for shift_us in (-allowed_us, allowed_us))
        return exchange.answer in (early, late)

    def _since_motion_us(self, exchange: RecordedExchange) -> float:
        """Return the time (µs) from the last command that may have started motion to an exchange.

        It is 0 if there is no such command.  Clock errors accumulate over this time.
        """
        before = [
            each.at_us
            for each in self.exchanges[: exchange.number]
            if any(self.speech.moves(command) for command in commands(self.speech, each.sent))
        ]
        return exchange.at_us - before[-1] if before else 0


def _filled(lines: list[str], count: int) -> list[str]:
    return [*lines, *[""] * (count - len(lines))]

"""Replay of a recorded dialogue to the model of a part; the host's lines are sent in virtual time.

A line is sent at its time in the dialogue, but not before the model has answered the previous line.  If
the time of an answer from the model differs from that in the dialogue by more than the tolerance, all
later lines are shifted by this difference, so that it is reported once, not for each of these lines.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from itertools import groupby
from typing import TYPE_CHECKING

from ..spoken import CR
from .exchanges import RecordedExchange, TimedAnswer
from .model import PAUSE_PS, ModelLine

if TYPE_CHECKING:
    from ...core.component import Finding

PS_PER_US = 10**6
LATE_US = 10_000_000  # longest wait for an answer of the model after the time of the module's


@dataclass(eq=False)
class ModelAnswer(TimedAnswer):
    """The model's answer to a line of a dialogue, with the times of a `TimedAnswer` in µs of virtual time."""

    over_us: float = 0.0
    answer: bytes = b""
    first_us: float | None = None
    last_us: float | None = None
    findings: list[Finding] = field(default_factory=list)


class ModelReplay(ModelLine):
    """The model of a part, to which a dialogue is sent; each replay needs a new `ModelReplay`.

    `progress` is called repeatedly during a replay, with the number of the current exchange.
    """

    progress: Callable[[int], object] = staticmethod(lambda _number: None)

    def play(
        self,
        exchanges: Sequence[RecordedExchange],
        differs: Callable[[RecordedExchange, ModelAnswer], bool],
        shift_us: float = 0,
    ) -> list[ModelAnswer]:
        """Send all lines of a dialogue to the model, from the first one on; return the model's answer to each line.

        Args:
            differs: returns whether the times of a recorded exchange and of the model's answer differ so much
                that all later lines are shifted.
            shift_us: an additional delay of the last line, because the answer to that line may depend on its
                time; negative: that line is sent earlier.
        """
        answers: list[ModelAnswer] = []
        offset_us = self.kernel.now / PS_PER_US - exchanges[0].at_us if exchanges else 0.0
        if self.speech.wake and not b"".join(each.sent for each in exchanges[:2]).startswith(self.speech.wake):
            self.wake()  # the module was woken before the dialogue began
            offset_us += PAUSE_PS / PS_PER_US
        for number, exchange in enumerate(exchanges, start=1):
            answer = ModelAnswer()
            self._send(exchange, answer, offset_us + shift_us * (number == len(exchanges)), answers)
            self._wait(exchange, answer, offset_us)
            if answer.last_us is not None and exchange.last_us is not None and differs(exchange, answer):
                offset_us = answer.last_us - exchange.last_us
        self.run(self.kernel.now + PAUSE_PS)
        self._take(answers)
        return answers

    def _send(
        self, exchange: RecordedExchange, answer: ModelAnswer, offset_us: float, answers: list[ModelAnswer]
    ) -> None:
        """Send the characters of a line, each at its time in the dialogue plus `offset_us`.

        Data that the model has sent before the first of these characters is added to the previous answer.
        """
        character_us = self.speech.character_s * 1e6
        for at_us, group in groupby(exchange.characters, key=lambda pair: pair[0]):
            data = bytes(code for _, code in group)
            self.run(round((at_us + offset_us) * PS_PER_US))
            if answers[-1:] != [answer]:
                self._take(answers)
                del self.received[:], self.found[:]
                answers.append(answer)
            answer.over_us = max(answer.over_us, self.kernel.now / PS_PER_US) + len(data) * character_us
            self.port.write(data)

    def _wait(self, exchange: RecordedExchange, answer: ModelAnswer, offset_us: float) -> None:
        """Run the model until its answer has as many lines as the recorded answer, or is `LATE_US` late.

        If no answer was recorded, the model is not run.
        """
        if exchange.last_us is not None:
            limit_us = max(exchange.last_us + offset_us, answer.over_us) + LATE_US
            lines = exchange.answer.count(CR)
            self.kernel.run_while(lambda: self._has(lines, exchange.number), round(limit_us * PS_PER_US))
            self.run(self.received[-1].end_ps if self.received else 0)
        self._take([answer])

    def _has(self, lines: int, number: int) -> bool:
        self.progress(number)
        return sum(each.byte == CR[0] for each in self.received) >= lines

    def _take(self, answers: list[ModelAnswer]) -> None:
        for answer in answers[-1:]:
            answer.findings = list(self.found)
            answer.answer = bytes(each.byte for each in self.received)
            if self.received:
                answer.first_us, answer.last_us = (self.received[at].end_ps / PS_PER_US for at in (0, -1))

"""Communication with a real module; a command that may step the motor is only sent if motion is allowed."""

from __future__ import annotations

import re
from collections.abc import Callable, Iterator
from time import monotonic_ns
from typing import NamedTuple, Protocol

from .deviations import deviations, in_words
from .failures import DamagedAnswer, EndlessInput, MotionRefused, NoAnswer, RefusedCommand
from .module_port import SLICE_S, Chunk, ModulePort
from .spoken import CR, Speech

TRIES = 4
NOISE = "check cable, rate and format for noise, and try again"
BUSY_S = 0.2  # interval of queries to a busy module
REPORT_S = 2.0  # time after which a message shows the received characters, or that there are none
TIDY_S = 0.05  # silence that ends unsolicited characters


class DialogueRecord(Protocol):
    """A recorder of a dialogue, such as `DialogueFile`."""

    def host(self, data: bytes, first_ns: int, last_ns: int | None = None) -> None:
        """Record characters sent to the module, with the instants (ns) of the first and the last character."""

    def module(self, data: bytes, first_ns: int, last_ns: int | None = None) -> None:
        """Record characters received from the module, with the instants (ns) of the first and the last character."""

    def note(self, text: str) -> None:
        """Record a remark."""


class NoRecord:
    """A recorder that records nothing."""

    def host(self, data: bytes, first_ns: int, last_ns: int | None = None) -> None:
        """Do nothing."""

    def module(self, data: bytes, first_ns: int, last_ns: int | None = None) -> None:
        """Do nothing."""

    def note(self, text: str) -> None:
        """Do nothing."""


class ModuleAnswer(NamedTuple):
    """A module's answer, without checksums, and its instants (ns of `time.monotonic_ns`).

    `sent_ns` is the instant just before the command was sent, `first_ns` and `last_ns` are the instants of
    the first and the last character of the answer.  For a command that is never answered, `lines` is empty,
    and all three instants are equal.
    """

    lines: tuple[str, ...]
    sent_ns: int
    first_ns: int
    last_ns: int

    @property
    def text(self) -> str:
        r"""Answer as text, with "\r" between its lines."""
        return "\r".join(self.lines)


class Module:
    """A module on a port.

    Args:
        port: the port of the module.
        speech: the protocol of the module.
        transcript: records the dialogue.
        may_move: whether commands that may step the motor are also sent.
        report: called with a message for the user at the first exchange that takes a long time.

    Attributes:
        port, speech, transcript, may_move, report: the arguments.
        entering: whether this session has begun program entry and not ended it.
    """

    def __init__(
        self,
        port: ModulePort,
        speech: Speech,
        transcript: DialogueRecord | None = None,
        *,
        may_move: bool = False,
        report: Callable[[str], object] = lambda _text: None,
    ) -> None:
        self.port, self.speech, self.may_move, self.report = port, speech, may_move, report
        self.transcript: DialogueRecord = NoRecord() if transcript is None else transcript
        self.entering = self._is_reported = False

    @property
    def name(self) -> str:
        """Name of the part and of its port, for messages."""
        return f"{self.speech.sheet.part} at {self.port.where}"

    # ------------------------------------------------------------------------------------------------------- commands
    def ask(self, command: str) -> ModuleAnswer:
        """Send a command; return its answer.

        A command is sent again if the module reports that it arrived damaged.  A query is also sent again if it
        is refused for a reason other than "busy", or if its answer is damaged or missing.

        Raises:
            MotionRefused: the command may step the motor, which is not allowed.
            RefusedCommand: the module has refused the command.
            NoAnswer, DamagedAnswer: there is no valid answer; a command other than a query may have been executed.
            EndlessInput: characters still arrive after the time that the longest answer takes.
            PortLost: the port is gone.
        """
        repeatable = self.speech.is_question(command)
        for tries_left in reversed(range(TRIES)):
            try:
                answer = self.once(command, again=tries_left < TRIES - 1)
            except (NoAnswer, DamagedAnswer) as failure:
                if not repeatable or not tries_left:
                    raise
                self.transcript.note(f"query repeated: {failure}")
                self.report_once(f"no complete answer to {command} so far; the query is being repeated")
                continue
            last = answer.lines[-1] if answer.lines else ""
            # undetected noise has changed a query that is refused
            refused = repeatable and last != self.speech.busy and bool(self.speech.refusal(last))
            if not (refused or self.speech.is_garbled(last)) or not tries_left:
                break
            self.transcript.note(f"sent again: {command} was answered with {last}")
        self._check(command, last)
        return answer

    def once(
        self,
        command: str,
        data: bytes | None = None,
        *,
        again: bool = False,
        enough: Callable[[bytes], bool] | None = None,
        longest: int | None = None,
        wait_s: float = 0.0,
    ) -> ModuleAnswer:
        """Send a command once; return its answer, even if the module refuses the command.

        Args:
            data: the characters to send; None: the command in the format of the part.
            again: whether the command was sent before, and not answered.
            enough: returns whether the data received so far is enough, so that the wait may end.
            longest: the maximum number of characters in the answer; None: the maximum of the protocol.
            wait_s: the minimum time to wait for an answer (s), even if the timeout of the protocol is shorter.

        Raises:
            MotionRefused, NoAnswer, EndlessInput, DamagedAnswer, PortLost: as for `ask`.
        """
        self.check_motion(command)
        self.tidy()
        if data is None:
            data = self.speech.again(command) if again else self.speech.framed(command)
        sent_ns = self.send(data)
        if not self.speech.answers(command):
            self._note_entry(command)
            return ModuleAnswer((), sent_ns, sent_ns, sent_ns)
        received, first_ns, last_ns = b"", 0, 0
        timeout_s = max(self.speech.answer_timeout(command), wait_s)
        characters = len(data) + (self.speech.longest(command) if longest is None else longest)
        for chunk in self.chunks(timeout_s, self.speech.seconds(characters, timeout_s), f"the answer to {command}"):
            received += chunk.data
            first_ns, last_ns = first_ns or chunk.ns, chunk.ns
            if self.speech.is_complete(command, received) or (enough is not None and enough(received)):
                break
        else:
            raise NoAnswer(self._silence(command, received, timeout_s), received)
        try:
            lines = tuple(self.speech.lines(received))
        except DamagedAnswer as damaged:
            why = deviations(self.speech, command, received) or damaged
            raise DamagedAnswer(f"{self.name}: the answer to {command} is damaged: {why}; {NOISE}") from None
        if not (lines and self.speech.refusal(lines[-1])):
            self._note_entry(command)
        return ModuleAnswer(lines, sent_ns, first_ns, last_ns)

    def value(self, what: str) -> str:
        """Return the value in the answer to a query; `what` is a key of `speech.questions`.

        Raises:
            DamagedAnswer: even after several attempts, the answer is not one that this part can give.
            RefusedCommand, NoAnswer, PortLost: as for `ask`.
        """
        command, shape = self.speech.questions[what]
        for _ in range(TRIES):
            answer = self.ask(command).text
            if found := re.fullmatch(shape, answer):
                return self.speech.value(what, found[1])
            self.transcript.note(f"query repeated: {answer!r} is not an answer to {command}")
        why = deviations(self.speech, command, answer.encode("latin-1") + CR)
        raise DamagedAnswer(
            f"{self.name}: {command} was answered with {answer!r}{': ' * bool(why)}{why}; allowed {in_words(shape)}; "
            f"{self._strange(command, answer)}"
        )

    def wait_until_ready(self, seconds: float) -> None:
        """Query the module until it no longer answers that it is busy.

        Raises:
            RefusedCommand: the module is still busy after `seconds`.
            NoAnswer, DamagedAnswer, PortLost: as for `ask`.
        """
        for waits_left in reversed(range(round(seconds / BUSY_S) + 1)):
            try:
                self.ask(self.speech.probe)
            except RefusedCommand as refused:
                if refused.code != self.speech.busy or not waits_left:
                    raise
                self.port.pause(BUSY_S)
            else:
                return

    # ----------------------------------------------------------------------------------------------------- characters
    def send(self, data: bytes) -> int:
        """Send characters unmodified; return the instant (ns) just before they were written."""
        sent_ns = self.port.write(data)
        self.transcript.host(data, sent_ns)
        return sent_ns

    def chunks(self, silence: float, seconds: float, what: str = "unsolicited data") -> Iterator[Chunk]:
        """Yield received characters until there is silence.

        Every exchange with a module waits in this method, and nowhere else.

        Args:
            silence: the time without a character, in seconds, after which the wait ends.
            seconds: the longest wait, in seconds, even if characters still arrive.  Time for which this process
                was stopped does not count.
            what: the expected data, for messages.

        Raises:
            EndlessInput: characters still arrive after `seconds`.
            PortLost: the port is gone.
        """
        received, waited, before = b"", 0.0, self.port.clock()
        while (chunk := self.port.read(silence)).data:
            self.transcript.module(*chunk)
            received += chunk.data
            yield chunk
            now = self.port.clock()
            waited += min(now - before, silence + SLICE_S)
            before = now
            if waited > seconds:
                raise EndlessInput(
                    f"{self.name}: {what} has not ended after {seconds:.1f} s: {received[-40:]!r} came last, of "
                    f"{len(received)} characters; allowed: a port that is silent without a query; check "
                    "the port and --baud",
                    received,
                )
            if waited > REPORT_S:
                self.report_once(
                    f"{what} has not ended; received so far: {len(received)} characters, ending in {received[-40:]!r}"
                )

    def report_once(self, text: str) -> None:
        """Report the reason for a long wait to the user, unless this method has already reported one."""
        if not self._is_reported:
            self._is_reported = True
            self.report(f"{self.name}: {text}")

    def listen(self, silence: float, longest: int = 0) -> bytes:
        """Return the characters received until there is silence for `silence` seconds.

        Args:
            longest: the maximum number of characters expected.

        Raises:
            EndlessInput: characters still arrive after the time allowed for this number of characters.
        """
        return b"".join(chunk.data for chunk in self.chunks(silence, self.speech.seconds(longest, silence)))

    def tidy(self, longest: int = 0) -> None:
        """If unsolicited characters have arrived, such as a late answer, record them and wait for silence.

        Args:
            longest: the maximum number of characters expected.

        Raises:
            EndlessInput: as for `listen`.
        """
        if data := self.port.waiting():
            self.transcript.module(data, monotonic_ns())
            self.transcript.note("unsolicited")
            self.listen(TIDY_S, longest)

    def check_motion(self, command: str) -> None:
        """Check that a command may be sent.

        Raises:
            MotionRefused: the command may step the motor, which is not allowed.
        """
        row = self.speech.row(command)
        stored = self.entering and self.speech.shows_entry and row is not None and row.stored
        if self.may_move or stored or not self.speech.moves(command):
            return
        if row is None:
            what = f"{command!r} is not a command of the {self.speech.sheet.part.upper()}, so its effect is unknown"
        else:
            what = f"{command} may step the motor: {row.description}"
        raise MotionRefused(f"{self.name}: {what}; {command} was not sent; leave it out, or allow motion with --move")

    # --------------------------------------------------------------------------------------------------------- inside
    def _note_entry(self, command: str) -> None:
        """Update `entering` if a command begins or ends program entry."""
        row = self.speech.row(command)
        if row is not None and row.role in ("enter", "leave"):
            self.entering = row.role == "enter"

    def _check(self, command: str, line: str) -> None:
        meaning = self.speech.refusal(line)
        if meaning:
            raise RefusedCommand(
                f"{self.name}: {command} was answered with {line}: {meaning}; {self._remedy(line)}", line, meaning
            )

    def _remedy(self, line: str) -> str:
        if line == self.speech.busy:
            return "a program or a motion is in progress; wait until it ends, or end it by hand"
        return NOISE if self.speech.is_garbled(line) else "see the manual for this answer"

    def _silence(self, command: str, received: bytes, timeout_s: float) -> str:
        setting = self.speech.setting.in_full
        if received:
            stops = f"stops after {received[-40:]!r}, {len(received)} characters"
            why = deviations(self.speech, command, received)
            if why:
                return f"{self.name}: the answer to {command} {stops}; it deviates from the data sheet: {why}"
            return f"{self.name}: the answer to {command} {stops}; allowed: a complete answer; {NOISE}"
        return (
            f"{self.name}: no answer to {command} within {timeout_s:.1f} s, at {setting}; check the part, "
            "its supply, and --baud, --checksum and --address"
        )

    def _strange(self, command: str, answer: str) -> str:
        if command in answer and not answer.startswith(f"{command} "):
            return (
                "this line echoes, as an adapter for two wires (RS-485) or a modem does; give --echo, or name the port "
                "of the module"
            )
        return "check the port and --chip"

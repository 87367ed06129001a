"""A user's conversation with a module: each line and its answer, the manual's text for both, and findings.

The lines are also sent to a model of the part, at the same times; its findings are printed with the line
that caused them.  The model begins in the state after power-up, not in the current state of the module.
"""

from __future__ import annotations

import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from functools import cached_property
from typing import TYPE_CHECKING, NamedTuple

from ..core.time.timebase import PS_PER_S
from ..errors import SlewlineError
from ..language.describe import describe_command, syntax
from ..language.dialect import dialect_of
from ..language.lookup import SIGNED
from .failures import DamagedAnswer, EndlessInput, ModuleFailure, NoAnswer
from .module import TIDY_S

if TYPE_CHECKING:
    from .comparing.model import ModelLine
    from .module import Module

VERB = ":"  # no command of a part begins with it
VERBS = {
    ":help": "show the manual's text for a command, such as :help R; alone: all commands",
    ":values": "query all values that can be read",
    ":send": "send unmodified characters, such as :send V1\\r",
    ":quit": "leave; so does Ctrl-D",
}
SHOWN_S = 1.0  # time after which received characters are shown, even if more arrive
MEANT = {"exit": ":quit", "bye": ":quit", **{verb[1:]: verb for verb in VERBS}}  # without the colon
LONGEST_S = 600  # virtual time that the model may catch up per line


@dataclass
class Reply:
    """The result of a line from the user: the lines of the module's answer, their meaning, and findings.

    `findings` are about this line, `since` are about the time between the previous line and this one.
    """

    lines: Sequence[str] = ()
    meaning: str = ""
    findings: Sequence[str] = ()
    since: Sequence[str] = ()
    failure: str = ""
    text: str = ""  # output of a verb
    over: bool = False  # the user leaves
    answered_ms: float | None = None


class Suggestion(NamedTuple):
    """A possible completion of a partly typed line, with its meaning."""

    text: str
    description: str


@dataclass
class ShadowModel:
    """A model of the part, which receives each line when the module does; the model's answers are ignored.

    Args:
        line: the model.
        clock: returns the wall-clock time in seconds.
    """

    line: ModelLine
    clock: Callable[[], float] = time.monotonic
    began_s: float = field(init=False)
    began_ps: int = field(init=False)

    def __post_init__(self) -> None:
        self.line.wake()
        self.began_s, self.began_ps = self.clock(), self.line.kernel.now

    def take(self, data: bytes) -> tuple[list[str], list[str]]:
        """Send data to the model, too; return its findings since the previous data, and those about this data."""
        self.catch_up()
        since = self._found()
        line_ps = round((len(data) + 4) * self.line.speech.character_s * PS_PER_S)
        self.line.port.write(data)
        self.line.run(self.line.kernel.now + line_ps + PS_PER_S // 100)
        return since, self._found()

    def _found(self) -> list[str]:
        """Return the model's findings since the last call, as text, each only once."""
        found = [f"{each.code}: {each.text}" for each in self.line.found]
        self.line.found.clear()
        return list(dict.fromkeys(found))

    def catch_up(self) -> None:
        """Run the model up to the wall-clock time, but not longer than `LONGEST_S`; skip any time beyond that."""
        due_ps = self.began_ps + round((self.clock() - self.began_s) * PS_PER_S)
        now_ps = self.line.kernel.now
        self.line.run(min(due_ps, now_ps + LONGEST_S * PS_PER_S))
        if due_ps > self.line.kernel.now:  # the rest is left out
            self.began_ps -= due_ps - self.line.kernel.now


class Conversation:
    """A conversation, in which a user's lines are sent to a module.

    Args:
        module: the module; lines may step its motor, and the user is responsible for that.
        shadow: the model that receives the same lines; None: there are no findings.
    """

    def __init__(self, module: Module, shadow: ShadowModel | None = None) -> None:
        self.module, self.shadow = module, shadow
        self.speech = module.speech
        self.sheet = module.speech.sheet

    # ---------------------------------------------------------------------------------------------------------- a line
    def say(self, line: str) -> Reply:
        """Send a line to the module, or execute it if it is a verb such as `:help`; return the result.

        Raises:
            PortLost: the port is gone.
        """
        line = line.strip()
        if not line:
            return Reply()
        if line.startswith(VERB):
            return self._verb(*line.partition(" ")[::2])
        if verb := MEANT.get(line.split()[0].lower()):
            return Reply(failure=f"not sent: {line!r} is not a command of a part; {verb} is a verb of this terminal")
        try:
            data = self.speech.framed(line)
        except SlewlineError as error:
            return Reply(failure=str(error))
        since, findings = self._odd(data)
        try:
            answer = self.module.once(line)
        except (NoAnswer, EndlessInput, DamagedAnswer) as failure:
            return Reply(findings=findings, since=since, failure=str(failure))
        answered_ms = (answer.first_ns - answer.sent_ns) / 1e6 if answer.lines else None
        return Reply(answer.lines, self.meaning(answer.lines), findings, since, answered_ms=answered_ms)

    def _odd(self, data: bytes) -> tuple[list[str], list[str]]:
        return ([], []) if self.shadow is None else self.shadow.take(data)

    def meaning(self, lines: Sequence[str]) -> str:
        """Return the manual's text for the last line of an answer; empty if the manual has none."""
        return dialect_of(self.sheet).answers.get(lines[-1], "") if lines else ""

    def unasked(self) -> str:
        """Return unsolicited characters from the module; empty if there are none."""
        data, came_ns = self.module.port.waiting(), time.monotonic_ns()
        if not data:
            return ""
        self.module.transcript.module(data, came_ns)
        return (data + self._until_silence(TIDY_S)).decode("latin-1")

    def _until_silence(self, silence: float) -> bytes:
        """Return the characters received until the module is silent for `silence` seconds, or `SHOWN_S` has passed."""
        try:
            return b"".join(chunk.data for chunk in self.module.chunks(silence, SHOWN_S))
        except EndlessInput as endless:
            return endless.received

    # --------------------------------------------------------------------------------------------------------- verbs
    def _verb(self, verb: str, rest: str) -> Reply:
        if verb == ":help":
            return Reply(text=self.manual(rest.strip()))
        if verb == ":values":
            return Reply(text=self._values())
        if verb == ":send":
            return self._send(rest)
        if verb == ":quit":
            return Reply(over=True)
        return Reply(failure=f"{verb}: there is no such verb; allowed {', '.join(VERBS)}")

    def _values(self) -> str:
        rows = []
        for what, (command, _) in self.speech.questions.items():
            try:
                rows.append(f"{what}: {self.module.value(what)}")
            except ModuleFailure as failure:
                rows.append(f"{what}: {failure} ({command})")
        return "\n".join(rows)

    def _send(self, text: str) -> Reply:
        try:
            data = text.encode("ascii").decode("unicode_escape").encode("latin-1")
        except UnicodeError:
            return Reply(failure=f":send {text}: allowed ASCII, and \\r, \\n, \\x41 for other characters")
        since, findings = self._odd(data)
        self.module.send(data)
        answer = self._until_silence(self.speech.answer_timeout(self.speech.probe))
        lines = answer.decode("latin-1").removesuffix("\r").split("\r") if answer else []
        return Reply([each.encode("unicode_escape").decode() for each in lines], "", findings, since)

    # ---------------------------------------------------------------------------------------------- text of the manual
    def manual(self, command: str = "") -> str:
        """Return the manual's text for a command; without a command, a table with a row for each command and verb."""
        if command:
            try:
                return describe_command(self.sheet, command)
            except SlewlineError as error:
                return str(error)
        rows = [*((syntax(row), row.description) for row in self.sheet.commands), *VERBS.items()]
        width = max(len(name) for name, _ in rows)
        return "\n".join(f"{name:<{width}}  {description}" for name, description in rows)

    def hint(self, line: str) -> str:
        """Return the manual's text for the line being typed; empty if it does not begin with a command or verb yet."""
        line = line.strip()
        if line.startswith(VERB):
            return VERBS.get(line.partition(" ")[0], "")
        heads = [head for head in self.heads if line.startswith(head)]
        return self.heads[max(heads, key=len)] if heads else ""

    @cached_property
    def heads(self) -> dict[str, str]:
        """Descriptions of commands, keyed by their first characters, and of queries, keyed by their whole text."""
        found: dict[str, str] = {}
        for row in self.sheet.commands:
            description = f"{syntax(row)}: {row.description}"
            for head in ("+", "-") if row.head == SIGNED else (row.head,):
                found[head] = f"{found[head]}; {description}" if head in found else description
        return found | {command: f"queries {what}" for what, (command, _) in self.speech.questions.items()}

    def suggestions(self, begun: str) -> list[Suggestion]:
        """Return the possible completions of a partly typed line."""
        verb, space, rest = begun.partition(" ")
        if begun.startswith(VERB) and not space:
            return [Suggestion(name, description) for name, description in VERBS.items() if name.startswith(begun)]
        if begun.startswith(VERB):
            return [
                Suggestion(f"{verb} {each.text}", each.description)
                for each in self.suggestions(rest)
                if verb == ":help"
            ]
        return [
            Suggestion(head, description)
            for head, description in self.heads.items()
            if head.lower().startswith(begun.lower())
        ]

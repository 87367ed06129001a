"""slewline terminal: an interactive terminal connected to a module."""

from __future__ import annotations

import sys
from collections.abc import Callable, Iterator
from contextlib import ExitStack, contextmanager, suppress
from dataclasses import dataclass
from importlib import import_module
from threading import Event, Lock, Thread
from typing import Any

import click

from ...chips import sheet_of
from ...extras import needs
from ...modules.comparing.model import ModelLine
from ...modules.conversation import Conversation, Reply, ShadowModel
from ...modules.dialogue import DialogueFile, DialogueHeader
from ...modules.speech import speech_of
from .. import Terminated
from ..files import read_options
from ..live.serve import remark
from .pull_push import PortOptions, performed, raw_record

LISTEN_S = 0.05  # interval of checks for unsolicited characters
LEAVE = "Ctrl-D leaves, :help lists the commands"


@dataclass
class TerminalCommand(PortOptions):
    """The module and the options of a terminal."""

    plain: bool
    model: bool
    strap: tuple[tuple[str, int], ...]
    options: str | None

    def perform(self) -> int:
        """Run the terminal until the user leaves it; return the exit status."""
        part = str(self.part)  # required on the command line
        sheet = sheet_of(part)
        speech_of(sheet, self.baud, self.checksum, self.address)  # a mistake here opens no port
        options = read_options(self.options, part)
        return performed(lambda: self._converse(part, options))

    def _converse(self, part: str, options: dict[str, Any]) -> None:
        with ExitStack() as stack:
            raw = stack.enter_context(raw_record(self.dialogue or f"terminal.{part}"))
            module = self.found(self.port, sheet_of(part), raw, may_move=True)
            stack.enter_context(module.port)
            speech = module.speech
            header = DialogueHeader(
                part,
                markings=self.markings or "",
                crystal_hz=self.crystal_hz,
                baud=speech.baud,
                checksum=speech.checked,
                address=speech.address,
                straps=dict(self.strap),
            )
            if self.dialogue is not None:
                module.transcript = stack.enter_context(DialogueFile(self.dialogue, header, remark))
            shadow = ShadowModel(ModelLine(header, speech, options)) if self.model else None
            goes = f"raw characters are recorded in {raw.path}"
            remark(f"{module.name}, {speech.setting}{', with checksums' * speech.checked}; {goes}; {LEAVE}")
            converse(Conversation(module, shadow), self.lines)

    def lines(self, conversation: Conversation, lock: Lock) -> Iterator[str]:
        """Return an iterator over the user's lines, typed at a prompt or piped into standard input."""
        if not sys.stdin.isatty():
            return piped(conversation)
        if not self.plain:
            with suppress(ModuleNotFoundError):
                return prompted(conversation, lock)
            remark(needs("completion with the manual's text needs", "terminal"))
        return typed(conversation)


Lines = Callable[[Conversation, Lock], Iterator[str]]


def converse(conversation: Conversation, lines: Lines) -> None:
    """Send lines to a module and print its answers, until the lines end or the user leaves.

    Raises:
        PortLost: the port is gone.
    """
    lock = Lock()
    for line in lines(conversation, lock):
        with lock:
            show_unasked(conversation)
            try:
                reply = conversation.say(line)
            except Terminated:
                raise
            except KeyboardInterrupt:
                reply = Reply(failure="the wait was interrupted")
        show(reply)
        if reply.over:
            break


def show(reply: Reply) -> None:
    """Print the result of a line: findings marked with !, and the answer with its meaning and its delay."""
    for text in reply.since:
        click.echo(f"  ! meanwhile, {text}")
    if reply.text:
        click.echo(reply.text)
    for number, line in enumerate(reply.lines, start=1):
        last = number == len(reply.lines)
        took = f"{reply.answered_ms:.0f} ms" if reply.answered_ms is not None else ""
        message = ", ".join(filter(None, (reply.meaning, took))) if last else ""
        click.echo(f"{line}  ({message})" if message else line)
    for text in reply.findings:
        click.echo(f"  ! {text}")
    if reply.failure:
        click.echo(f"  ! {reply.failure}")


def show_unasked(conversation: Conversation) -> None:
    """Print any characters that the module has sent without a command."""
    if text := conversation.unasked():
        click.echo(f"unsolicited: {text.encode('unicode_escape').decode()}")


# --------------------------------------------------------------------------------------------------------------- input
def piped(conversation: Conversation) -> Iterator[str]:
    """Yield the lines of standard input, which is a file or pipe; echo each line, because it was not typed."""
    for line in sys.stdin:
        click.echo(f"{conversation.sheet.part}> {line.rstrip()}")
        yield line


def typed(conversation: Conversation) -> Iterator[str]:
    """Yield lines that the user types at Python's `input`, with history and tab completion if available."""
    with completed(conversation):
        while True:
            try:
                yield input(f"{conversation.sheet.part}> ")
            except EOFError:
                click.echo()
                return
            except Terminated:
                raise
            except KeyboardInterrupt:  # the line is cancelled
                click.echo()


@contextmanager
def completed(conversation: Conversation) -> Iterator[None]:
    """Enable tab completion of lines within a `with` block, if a readline library is available."""
    try:
        readline: Any = import_module("readline")
    except ModuleNotFoundError:
        yield
        return

    def complete(begun: str, number: int) -> str | None:
        found = conversation.suggestions(begun)
        return found[number].text if number < len(found) else None

    readline.set_completer(complete)
    readline.set_completer_delims("")
    readline.parse_and_bind("tab: complete")
    try:
        yield
    finally:
        readline.set_completer(None)


def prompted(conversation: Conversation, lock: Lock) -> Iterator[str]:
    """Return an iterator over lines typed at a prompt with completion, with the manual's text shown below it.

    Raises:
        ModuleNotFoundError: prompt_toolkit, the package for the prompt, is not installed.
    """
    from prompt_toolkit import PromptSession
    from prompt_toolkit.completion import Completer, Completion
    from prompt_toolkit.patch_stdout import patch_stdout

    class ManualCompleter(Completer):
        """A completer of lines that shows a description from the manual with each suggestion."""

        def get_completions(self, document: Any, _event: Any) -> Iterator[Completion]:
            begun = document.text_before_cursor
            for text, description in conversation.suggestions(begun):
                yield Completion(text, -len(begun), display_meta=description)

    def below() -> str:
        return conversation.hint(session.default_buffer.text) or LEAVE

    session: PromptSession[str] = PromptSession(
        f"{conversation.sheet.part}> ", completer=ManualCompleter(), bottom_toolbar=below, complete_while_typing=False
    )

    def lines() -> Iterator[str]:
        with patch_stdout(raw=True), listening(conversation, lock):
            while True:
                try:
                    yield session.prompt()
                except EOFError:
                    return
                except Terminated:
                    raise
                except KeyboardInterrupt:  # the line is cancelled
                    continue

    return lines()


@contextmanager
def listening(conversation: Conversation, lock: Lock) -> Iterator[None]:
    """Print unsolicited characters from a module, in a second thread, during a `with` block."""
    over = Event()

    def listen() -> None:
        with suppress(Exception):  # a port that is gone is reported with the next line
            while not over.wait(LISTEN_S):
                with lock:
                    show_unasked(conversation)

    thread = Thread(target=listen, daemon=True)
    thread.start()
    try:
        yield
    finally:
        over.set()
        thread.join()

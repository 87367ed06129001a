"""slewline drive: a virtual chip replaces a failed one, and a board steps the motor."""

from __future__ import annotations

import os
import signal
import sys
from collections.abc import Iterator
from contextlib import ExitStack, contextmanager
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from shutil import rmtree
from typing import TYPE_CHECKING, Any

import click

from ...errors import UsageError
from ...temporary import TemporaryFolder
from ..files import report_replaced
from .serve import ServeCommand, remark, say, show, show_again, signals, state_directory

if TYPE_CHECKING:
    from ...bench import Bench
    from ...core.chip import Chip
    from ...drive.motor_drive import Drive
    from ...links.lines.pace import Pace
    from ...links.server import Server

CHECK_S = 10.0
WORDS = "clear: continue after a halt; clear homing, clear homed: and energise it; stop: stop the motor; status; end"


@dataclass(kw_only=True)
class DriveCommand(ServeCommand):
    """The options of a drive, and of the ports on which its chip is served."""

    board: str
    of: str | None
    enable: bool
    pulses: bool
    driver: str | None
    enable_off: str
    enable_hold: str
    invert_dir: bool
    filter: int
    input: tuple[tuple[str, str], ...]
    output: tuple[tuple[str, str], ...]
    horizon: str
    start_stop: str | None
    stop: str | None
    self_start: bool
    keep_count: bool
    homed: bool
    check: bool
    black_box: str | None
    no_black_box: bool
    rate: str | None = None
    lockstep: bool = False
    panel: str | None = None

    def perform(self) -> int:
        ports = [] if self.check else self.check_options()
        with ExitStack() as stack:
            folder = self._folder(stack)
            with kept_if_it_begins(folder):
                self.journal = self.journal or str(folder / "journal.jsonl")
                report_replaced(self.journal)
                stores = stack.enter_context(state_directory(self.state))
                bench = self.new_bench(stores)
                drive = self.new_drive(bench, folder)
                if self.check:
                    return check_up(drive)
                server = self.server(bench, drive)
                stack.enter_context(signals(server))
                self.open_ports(server, ports, None)  # their lines are parts of the bench, which must be complete
                drive.go_back_by(server.past)
                self._open(stack, server, drive)
            if not (self.no_black_box or self.check):
                remark(f"black box: {folder}")
            server.past.remember()
            self._join(server, drive)
            if self.status:
                server.loop.ask(lambda: show_again(server))
            server.run()
        return 0

    def check_options(self) -> list[tuple[str, str]]:
        if self.control and self.allow_remote:
            raise click.UsageError(
                "--control and --allow-remote: any client that reaches the control port can move a real motor; leave "
                "one out"
            )
        if self.black_box is not None and self.no_black_box:
            raise click.UsageError("--black-box and --no-black-box: leave one out")
        if self.serial is not None and os.path.realpath(self.serial) == os.path.realpath(self.board):
            raise click.UsageError(
                f"--board and --serial: both are {self.serial}; the board and the host each need their own serial port"
            )
        return super().check_options()

    def _folder(self, stack: ExitStack) -> Path:
        """Return the folder of the black box; without a black box, a temporary folder for the session history."""
        from ...drive.blackbox import new_folder

        if self.no_black_box or self.check:
            return Path(stack.enter_context(TemporaryFolder()))
        return new_folder(self.black_box)

    def new_drive(self, bench: Bench, folder: Path) -> Drive:
        """Return a new drive for the motor; it is not open yet."""
        from ...drive.motor_drive import Drive

        chip, axis = self._motor(bench)
        return Drive(
            bench,
            chip,
            self.board,
            axis=axis,
            horizon=self.horizon,
            enable=self.enable,
            pulses=self.pulses or self.check,
            driver=self.driver,
            enable_off=self.enable_off,
            enable_hold=self.enable_hold,
            invert_dir=self.invert_dir,
            filter=self.filter,
            inputs=dict(self.input),
            outputs=dict(self.output) or None,
            start_stop=self.start_stop,
            stop=self.stop,
            self_start=self.self_start,
            keep_count=self.keep_count,
            homed=self.homed,
            black_box=False if self.no_black_box or self.check else folder,
        )

    def _motor(self, bench: Bench) -> tuple[Chip, int]:
        """Return the chip that controls the motor, and the number of the motor's axis."""
        there = [f"{name}.{number}" for name, chip in bench.chips.items() for number in range(1, len(chip.axes) + 1)]
        wanted = self.of
        if wanted is None and len(bench.chips) == 1:
            wanted = f"{next(iter(bench.chips))}.1"
        name, _, number = (wanted or "").partition(".")
        if f"{name}.{number or 1}" not in there:
            found = "no motor given" if wanted is None else f"{wanted!r} has no motor"
            raise UsageError(f"--of: {found}; allowed: {', '.join(there)}")
        return bench.chips[name], int(number or 1)

    def server(self, bench: Bench, drive: Drive | None = None) -> Server:
        """Return the server, without ports; if a drive is given, its board's crystal sets the pace of time."""
        from ...links.lines.pace import Paced
        from ...links.server import Server

        pace: Pace = Paced(bench, "1", *([drive.nanoseconds] if drive is not None else []))
        return Server(bench, pace, self.log, self.allow_remote, remark)

    def _open(self, stack: ExitStack, server: Server, drive: Drive) -> None:
        """Open the session with the board; if that fails, close the server's ports."""
        try:
            stack.enter_context(drive)
        except BaseException:
            server.close()
            raise

    def _join(self, server: Server, drive: Drive) -> None:
        """Make the server's loop call the drive, and delay output to hosts until the motor has caught up."""
        from ...links.sockets.system import be_prompt

        for line in server.lines.values():
            line.gate = drive.gate

        watched: list[int] = []
        turns = [0]

        def again(ordered: int | None = None) -> None:
            if ordered not in (None, turns[0]):
                return  # an input from outside came before this was due
            drive.turn()
            number = drive.port.fileno()  # a new one after a cable was unplugged and reconnected
            if watched != ([] if number is None else [number]):
                for old in watched:
                    server.loop.watch(old)
                watched[:] = [] if number is None else [number]
                for new in watched:
                    server.loop.watch(new, drive.turn)
            turns[0] += 1
            server.loop.after(drive.due(), partial(again, turns[0]))

        def begin() -> None:
            drive.align()  # the server started later than the board was opened
            again()

        server.loop.ask(begin)
        drive.on_wake.add(lambda: server.loop.ask(again))
        server.notes.append(drive.status)
        self._watch_user(server, drive, f"slewline: {drive.introduction()}; {be_prompt()}")

    def _watch_user(self, server: Server, drive: Drive, introduction: str) -> None:
        """Print the introduction, obey commands that the user types, and make SIGUSR2 act like a typed `clear`."""
        from ...drive.board.rehearsal import TwinPort
        from ...links.sockets.system import numbers

        def clear(homed: bool = False, homing: bool = False) -> None:
            drive.clear(homed=homed, homing=homing)
            off = self.enable and not drive.power.on
            remark(f"the drive continues{'; the driver is off' if off else ''}")

        words: dict[str, Any] = {
            "clear": clear,
            "clear homed": lambda: clear(homed=True),
            "clear homing": lambda: clear(homing=True),
            "stop": drive.stop,
            "status": lambda: show(server),
            "end": server.stop,
        }

        def typed() -> None:
            line = sys.stdin.readline()
            if not line:  # closed
                server.loop.watch(sys.stdin.fileno())
            elif word := " ".join(line.lower().split()):
                work(word)

        def work(word: str) -> None:
            name, equals, level = word.partition("=")
            try:
                if equals and isinstance(drive.port, TwinPort) and level in ("0", "1"):
                    drive.port.set_input(name, int(level))
                else:
                    words.get(word, lambda: remark(f"{word!r}; allowed: {WORDS}"))()
            except UsageError as error:
                remark(str(error))

        for number in numbers("SIGUSR2"):
            signal.signal(number, lambda *_: server.loop.ask(lambda: work("clear")))
        say(introduction)
        if sys.stdin is not None and sys.stdin.isatty():
            server.loop.watch(sys.stdin.fileno(), typed)
            remark(f"type {WORDS}")


@contextmanager
def kept_if_it_begins(folder: Path) -> Iterator[None]:
    """Remove the folder of a session that fails to start, so that the black box of an earlier session is kept."""
    try:
        yield
    except BaseException:
        rmtree(folder, ignore_errors=True)
        raise


def check_up(drive: Drive) -> int:
    """Check the link, the machine and the board; return the exit status."""
    from ...links.sockets.system import be_prompt

    remark(drive.introduction())
    with drive:
        found = drive.check(CHECK_S, be_prompt(), say)
    for line in found.lines:
        click.echo(line)
    return 0 if found.good else 1

"""slewline drive: a chip in the place of the one that failed, with a board that steps a real motor."""

from __future__ import annotations

import sys
from contextlib import ExitStack
from dataclasses import dataclass, field
from typing import TYPE_CHECKING

import click

from ...errors import UsageError
from ..files import say_replaced
from .serve import ServeCommand, say, show_again, signals, state_directory

if TYPE_CHECKING:
    from ...bench import Bench
    from ...core.chip import Chip
    from ...drive.drive import Drive
    from ...links.server import Server

TURN_S = 0.005
CHECK_S = 10.0


@dataclass
class DriveCommand(ServeCommand):
    """What is to be driven, and what is to be served beside it."""

    board: str = ""
    horizon: str = "100 ms"
    of: str | None = None  # chip, or chip and axis, of a bench file
    enable: bool = False
    driver: str | None = None
    input: tuple[tuple[str, str], ...] = ()
    output: tuple[tuple[str, str], ...] = ()
    start_stop: str | None = None
    stop: str = "abort"
    self_start: bool = False
    check: bool = False
    black_box: str | None = None
    no_black_box: bool = False
    drive: Drive = field(init=False)

    def perform(self) -> int:
        """Do it, until a signal ends it; returns the exit status."""
        from ...drive.promptness import be_prompt

        ports = [] if self.check else self.check_options()
        say_replaced(self.journal)
        with ExitStack() as stack, state_directory(self.state) as stores:
            bench = self.new_bench(stores)
            self.drive = stack.enter_context(self.new_drive(bench))
            if self.check:
                return self.check_up()
            server = self.server(bench)
            self.join(server)
            say(f"slewline: {self.drive.introduction}; {be_prompt()}")
            with signals(server):
                self.open_ports(server, ports, None)
                if self.status:
                    server.loop.ask(lambda: show_again(server))
                server.run()
        return 0

"""The server: a bench, a pace, and the ports on which the outside finds the chips.

    server = Server(bench, Lockstep(bench))
    port = server.tcp(server.line(x), "127.0.0.1:0")
    print(port.where)                                   # socket://127.0.0.1:40001
    server.run()                                        # until server.stop()

Everything happens in the one thread that calls `run`: it lets virtual time pass as far as it may, then sleeps until
the next event or the next byte.  `call` brings a function from another thread into it.
"""

from __future__ import annotations

from collections.abc import Callable
from concurrent.futures import Future
from contextlib import suppress
from os import PathLike
from typing import TYPE_CHECKING, Any, Protocol

from ..core.chip import Chip, Finding
from ..core.table import Port
from ..errors import UsageError
from .line import Line, SerialLine
from .log import Log
from .loop import Loop
from .pace import Pace
from .tcp import TcpPort

if TYPE_CHECKING:
    from ..bench import Bench

KEPT_FINDINGS = 1000  # of each chip and part; a server runs for months
KEPT_STRETCHES = 10_000  # of the past of each axis
TIDY_S = 5.0


class Opened(Protocol):
    """A port, of whatever kind."""

    @property
    def where(self) -> str:
        """Where it is found."""

    def close(self) -> None:
        """Close it."""


class Server:
    """Serves the chips of a bench.

    Args:
        bench: furnished; no time may have passed.
        pace: Paced(bench) or Lockstep(bench).
        log: a file for the transcript.
        allow_remote: other machines may connect.
    """

    def __init__(
        self, bench: Bench, pace: Pace, log: str | PathLike[str] | None = None, allow_remote: bool = False
    ) -> None:
        self.bench, self.pace, self.allow_remote = bench, pace, allow_remote
        self.log = Log(bench.kernel, log)
        self.loop = Loop()
        self.lines: dict[str, Line] = {}
        self.ports: list[Opened] = []
        self.found = 0  # findings since the beginning
        self.over = False
        bench.on_finding = self._finding

    # ---------------------------------------------------------------------------------------------------- furnishing
    def line(self, *chips: Chip) -> SerialLine:
        """A line to a chip, or to several that share it.

        Raises:
            UsageError: they have no serial ports, or ports of different kinds.
        """
        ports = {strapped_line(chip) for chip in chips}
        if len(ports) != 1:
            raise UsageError(f"{', '.join(chip.name for chip in chips)}: their lines differ in speed or format")
        baud, bits, parity, stop = ports.pop()
        part = self.bench.part("serial_port", name=f"{chips[0].name}_line", baud=baud, bits=bits, parity=parity, stop=stop)
        for chip in chips:
            self.bench.wire(f"{part.name}.txd", f"{chip.name}.rxd")
            self.bench.wire(f"{part.name}.rxd", f"{chip.name}.txd")
        return self._added(SerialLine("+".join(chip.name for chip in chips), chips, self.pace, self.log, part))

    def _added(self, line: Any) -> Any:
        self.lines[line.name] = line
        return line

    def tcp(self, line: Line, address: str) -> TcpPort:
        """Serve a line on a raw TCP socket."""
        return self._opened(TcpPort(self.loop, line, address, self.allow_remote))

    def _opened(self, port: Any) -> Any:
        self.ports.append(port)
        return port

    # ------------------------------------------------------------------------------------------------------- running
    def run(self) -> None:
        """Serve until `stop`; everything is closed then."""
        self.bench.run(0)
        self.pace.start()
        self.loop.after(TIDY_S, self._tidy)
        try:
            while not self.over:
                done = self.pace.pass_time()
                self.loop.turn(self.pace.pause() if done else 0)
        finally:
            self.close()

    def stop(self) -> None:
        """End `run`; may be called in a signal handler and in other threads."""
        self.loop.ask(self._end)

    def _end(self) -> None:
        self.over = True

    def close(self) -> None:
        """Close every port; the bench stays as it is."""
        for port in self.ports:
            port.close()
        self.ports.clear()
        self.bench.run(0)  # the journal learns how far it went
        self.log.close()
        self.loop.close()

    def call(self, function: Callable[[], Any], timeout: float | None = None) -> Any:
        """Call a function in the thread that runs the server, from another thread; returns what it returns."""
        future: Future[Any] = Future()

        def answer() -> None:
            try:
                future.set_result(function())
            except BaseException as error:
                future.set_exception(error)

        self.loop.ask(answer)
        return future.result(timeout)

    # -------------------------------------------------------------------------------------------------- housekeeping
    def _finding(self, found: Finding) -> None:
        self.found += 1
        self.log.event(found.source, f"{found.code}: {found.text}")
        findings = self.bench[found.source].findings
        if len(findings) > 2 * KEPT_FINDINGS:
            del findings[:-KEPT_FINDINGS]

    def _tidy(self) -> None:
        """Forget the distant past of axes that have moved often."""
        for chip in self.bench.chips.values():
            for axis in chip.axes:
                if len(axis.past) > 2 * KEPT_STRETCHES:
                    axis.forget(axis.past[-KEPT_STRETCHES].start)
        self.loop.after(TIDY_S, self._tidy)


def strapped_line(chip: Chip) -> tuple[int, int, str, int]:
    """Speed and format of a chip's serial port, as its pins are strapped: baud, bits, parity, stop bits."""
    port: Port | None = chip.sheet.port
    if port is None:
        raise UsageError(f"{chip.name}: a {chip.sheet.part.upper()} has no serial port")
    levels = tuple(0 if chip.pins[pin].level == 0 else 1 for pin in port.baud_pins)
    return port.bauds[levels], port.bits, port.parity, port.stop

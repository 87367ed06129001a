"""The past of a server: one class for both methods of recreating it.

    past.at(t).rerun(inputs, now)     a shadow, in this process: an up-to-date bench, for `past.go_on`
    past.at(t).world(order, arrived)  a checkpoint, in a separate process: a second server at t, paused

A motor drive whose inputs arrive late needs the first method: the past is repeated in this process, with
these inputs at their own instants, and the run continues from there.  A debugger needs the second: the
current run is kept, and any instant is reached quickly, however long the run was; this method needs
`fork`.  Only this file uses both; a bench without a server uses the first (`bench/past.py`).
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable
from typing import TYPE_CHECKING, Any

from ...bench.past import Instant, Past
from ...core.time.timebase import readable
from ...errors import UsageError
from ..lines.served_line import Acts, ConnectorLine, HostLine
from .bench_exchange import LineTap, LineTaps, limit_kept, record_same
from .checkpoints import Checkpoints

if TYPE_CHECKING:
    from ...bench import Bench
    from ...core.time.kernel import Kernel
    from ..face import ServerFace


class ServedInstant(Instant):
    """An instant (ps) in the past of a server."""

    past: ServedPast

    def world(
        self, order: dict[str, Any], shared_ps: int, shared: int, arrived: Callable[[dict[str, Any]], object]
    ) -> bool:
        """Start a paused server at this instant, in a separate process.

        Args:
            order: the data that the server needs (`worlds.World`), without `begin`, which the checkpoint sets.
            shared_ps, shared: the journal named in `order` is the same as that of the first run up to this
                instant (ps) and this number of bytes.
            arrived: called with the server's address, or with an error.

        Returns:
            False if this instant is not recorded.
        """
        return self.past.checkpoints.world(self.ps, order, shared_ps, shared, arrived)


class ServedPast(Past):
    """The past of a server, which can change to another bench without interrupting its hosts and clients."""

    def __init__(self, server: ServerFace) -> None:
        super().__init__(server.bench)
        self.server, self.checkpoints = server, Checkpoints(server)
        self.taps: dict[Kernel, dict[str, LineTap]] = {}  # recorders of benches that play the past
        limit_kept(server.bench)

    def at(self, ps: int) -> ServedInstant:
        return ServedInstant(self, ps)

    # --------------------------------------------------------------------------------------------------- preparations
    def begin(self) -> bool:
        """Start to make checkpoints, before any time has passed; return whether checkpoints are possible."""
        return self.checkpoints.begin()

    def look(self, worked_s: float) -> None:
        """Make a checkpoint if one is due; called in every turn, with the seconds of work in the last turn."""
        self.checkpoints.look(worked_s)

    def close(self) -> None:
        """End all checkpoints."""
        self.checkpoints.close()

    def remember(self) -> None:
        """Start to record the data needed to recreate the past, before the first shadow (replaying bench) begins."""
        server = self.server
        for line in server.lines.values():
            line.outlet.remember(server.bench.now_ps)
            if line.acts is None and not isinstance(line, ConnectorLine):
                line.acts = Acts(line.part.name)
                server.bench.on_input.add(line.acts.on_input)

    def listen(self, bench: Bench) -> LineTaps:
        self.remember()
        limit_kept(bench)
        taps = self.taps[bench.kernel] = {name: LineTap(line, bench) for name, line in self.server.lines.items()}
        return LineTaps(taps)

    def follow(self, to_ps: int, enough: Callable[[], bool] = lambda: False) -> bool:
        """Let the shadows replay up to an instant (ps), or until `enough` returns True.

        Returns:
            True if all shadows have reached the instant; older data is then discarded.
        """
        done = super().follow(to_ps, enough)
        if done:
            for line in self.server.lines.values():
                line.outlet.forget(to_ps)
                if line.acts is not None:
                    line.acts.forget(to_ps)
            benches = [shadow.player.bench for shadow in self.shadows if shadow.player is not None]
            self.taps = {bench.kernel: self.taps[bench.kernel] for bench in benches}
            for bench in benches:
                record_same(bench, self.server.bench)
                for tap in self.taps[bench.kernel].values():
                    tap.sent = [sent for sent in tap.sent if sent.ps > to_ps]
        return done

    # ----------------------------------------------------------------------------------------------------- the exchange
    def go_on(self, bench: Bench, since_ps: int = 0) -> None:
        """Start to serve another bench, which is at the same instant and has chips and parts of the same names.

        Hosts and clients stay connected; pace, log, views, breakpoints and waits of clients continue on the new
        bench.

        Raises:
            UsageError: the bench is at another instant, or lacks a chip or part; or clients are shown a branch
                instead of the served bench.  Nothing has changed.
            OSError: the file of an external memory could not be written; nothing has changed.
        """
        server, old = self.server, self.server.bench
        self._check(bench)
        before = [found for found in old.findings if found.time_ps >= since_ps]
        super().go_on(bench, since_ps)
        taps = self.taps.pop(bench.kernel, None) or {name: LineTap(line, bench) for name, line in server.lines.items()}
        limit_kept(bench)
        record_same(bench, old)
        server.bench = bench
        server.pace.move(bench)
        server.log.move(bench.kernel)
        for name, line in server.lines.items():
            self._move(line, bench, taps[name])
        server.furnish(bench)
        server.views.move(bench)
        server.breakpoints.move(bench)
        self.checkpoints.move(since_ps)
        for wait in server.pace.waits:
            if wait.renew is not None:
                wait.end()
                wait.renew()
                wait.begin()
        known = Counter((found.source, found.code, found.text) for found in before)
        for found in [each for each in bench.findings if each.time_ps >= since_ps]:
            key = found.source, found.code, found.text
            known[key] -= 1
            if known[key] < 0:
                server.finding(found)

    def _check(self, bench: Bench) -> None:
        """Check that a bench can replace the served one.

        Raises:
            UsageError: the bench is at another instant, or lacks a chip or part; or clients are shown a branch
                instead of the served bench.
        """
        old, shown = self.server.bench, self.server.branches.current
        if bench.now_ps != old.now_ps:
            raise UsageError(
                f"exchange: the new bench is at {readable(bench.now_ps)}; expected the present time of the served "
                f"bench, {readable(old.now_ps)}"
            )
        missing = [name for name in (*old.chips, *old.parts) if name not in bench]
        if missing:
            raise UsageError(
                f"exchange: the new bench lacks {', '.join(missing)}; it must have all chips and parts of the "
                "served bench"
            )
        if shown:
            raise UsageError(
                f"exchange: branch {shown} is shown, and the served bench (branch 0) is paused; show branch 0 first"
            )

    def _move(self, line: HostLine, bench: Bench, tap: LineTap) -> None:
        """Connect a line to another bench, and send its host the output that the host has not received yet."""
        now = bench.now_ps
        if line.acts is not None:
            bench.on_input.add(line.acts.on_input)
            line.acts.inputs = max(line.acts.inputs, tap.inputs)
        tap.live = True
        line.move(bench, [sent for sent in tap.sent if sent.ps > now])
        unsent = line.outlet.resend([sent for sent in tap.sent if sent.ps <= now])
        if unsent:
            self.server.log.event(line.name, f"the host has already received withdrawn data: {unsent!r}")

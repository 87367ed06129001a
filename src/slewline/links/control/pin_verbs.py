"""Handlers of the requests for pins, faults and the state of a server."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, TypeVar

from ...core.messages.near import hint
from ...core.time.timebase import moment, picoseconds
from ...errors import UsageError
from ..lines.served_line import ConnectorLine, HostLine
from ..views.server_status import status
from .requests import schema
from .value_kinds import MAX_FINDINGS, MAX_STEPS, Data

if TYPE_CHECKING:
    from ...core.chip import Chip
    from ...core.motion.one_axis import OneAxis
    from ..face import ClientFace, ServerFace


Line = TypeVar("Line", bound=HostLine)


class Verbs:
    """Handlers of requests: `do_drive` handles `drive`, and so on; a handler that returns None replies later."""

    def __init__(self, server: ServerFace, client: ClientFace) -> None:
        self.server, self.client, self.bench = server, client, server.bench

    def limit(self, request: Data) -> int:
        """Return the instant (ps) at which the wait of a request times out, by default 60 s from now."""
        return self.bench.now_ps + picoseconds(request.get("timeout", "60 s"))

    def chip(self, name: str) -> Chip:
        """Return a chip by its name.

        Raises:
            UsageError: there is no such chip.
        """
        chips = self.bench.chips
        if name not in chips:
            raise UsageError(f"no chip {name!r}; allowed: {', '.join(chips)}{hint(name, chips)}")
        return chips[name]

    def axis(self, request: Data) -> OneAxis:
        """Return an axis of the chip in a request: the axis that the request names or, by default, the first axis."""
        return self.chip(request["chip"]).axis(request.get("axis", 1))


class PinVerbs(Verbs):
    """Handlers for pins, faults, and the state of a server."""

    def do_drive(self, request: Data) -> Data:
        """Drive a pin, as external hardware would."""
        self.bench.pin(request["pin"]).drive(request["level"])
        return {}

    def do_release(self, request: Data) -> Data:
        """Release a pin, as external hardware would."""
        self.bench.pin(request["pin"]).release()
        return {}

    def do_pulse(self, request: Data) -> Data:
        """Drive a pin for a given time."""
        self.bench.pin(request["pin"]).pulse(request["level"], request["width"])
        return {}

    def do_read(self, request: Data) -> Data:
        """Reply with the levels of the requested pins."""
        return {"levels": {name: self.bench.pin(name).level for name in request["pins"]}}

    def line(self, name: str) -> ConnectorLine:
        """Return a serial line by its name, or by the name of any chip on it.

        Raises:
            UsageError: there is no such line.
        """
        return self._named(name, [line for line in self._lines if isinstance(line, ConnectorLine)], "serial line")

    @property
    def _lines(self) -> list[HostLine]:
        return [*self.server.lines.values()]

    def _named(self, name: str, lines: Sequence[Line], kind: str) -> Line:
        for line in lines:
            if name == line.name or name in (chip.name for chip in line.chips):
                return line
        names = [line.name for line in lines]
        raise UsageError(f"no {kind} {name!r}; allowed: {', '.join(names) or 'none'}{hint(name, names)}")

    def do_unplug(self, request: Data) -> Data:
        """Close the ports of a line, as if its adapter were unplugged."""
        self.server.adapters.unplug(self._named(request["line"], self._lines, "line"))
        return {}

    def do_plug(self, request: Data) -> Data:
        """Open the ports of a line again, at the same addresses."""
        self.server.adapters.plug(self._named(request["line"], self._lines, "line"))
        return {}

    def eeprom(self, request: Data, fails: bool) -> Data:
        """Make writes to the EEPROM of a chip fail, or succeed again if `fails` is False."""
        chip = self.chip(request["chip"])
        if not hasattr(chip, "eeprom_fault"):
            raise UsageError(f"chip {chip.name!r}: a {chip.sheet.part} has no EEPROM")
        chip.eeprom_fault = fails
        return {}

    def do_fault(self, request: Data) -> Data:
        """Plan faults in the next characters of a line, or make writes to a chip's EEPROM fail."""
        if "chip" in request:
            return self.eeprom(request, True)
        line = self.line(request["line"])
        noise = line.to_chip if request["to"] == "chip" else line.to_host
        noise.plan(request["kind"], request.get("count", 1), request.get("chance", 1), request.get("seed", 0))
        return {}

    def do_clear(self, request: Data) -> Data:
        """End the faults of an EEPROM or of a line.

        For a line, reply with the number of affected characters in each direction.
        """
        if "chip" in request:
            return self.eeprom(request, False)
        line = self.line(request["line"])
        line.to_chip.clear()
        line.to_host.clear()
        return {"hits": {"chip": line.to_chip.done, "host": line.to_host.done}}

    def do_power(self, request: Data) -> Data:
        """Switch the supply of a chip on or off."""
        self.chip(request["chip"]).power(request["on"])
        return {}

    def do_status(self, _request: Data) -> Data:
        """Reply with the state of the server, its chips and its lines."""
        return status(self.server)

    def do_findings(self, request: Data) -> Data:
        """Reply with the latest findings, since `start` if given, of one chip or part, or of all chips and parts."""
        start = picoseconds(request.get("start", 0))
        owner = self.bench[request["source"]] if "source" in request else self.bench
        found = [one for one in owner.findings if one.time_ps >= start]
        shown = [
            {"time_ps": one.time_ps, "source": one.source, "code": one.code, "text": one.text}
            for one in found[-MAX_FINDINGS:]
        ]
        return {"findings": shown, "omitted": len(found) - len(shown)}

    def do_schema(self, _request: Data) -> Data:
        """Reply with the schema of requests and replies."""
        return {"schema": schema()}

    def do_steps(self, request: Data) -> Data:
        """Reply with the steps of an axis in a window of time."""
        axis = self.axis(request)
        start, stop = request.get("start", axis.motor.since), request.get("stop", self.bench.now_ps)
        count = axis.motor.count(moment(start), min(moment(stop), self.bench.now_ps))
        if count > MAX_STEPS:
            raise UsageError(f"steps: {count} steps in this window; request a window of at most {MAX_STEPS} steps")
        steps = axis.steps(start, stop)
        return {name: getattr(steps, name).tolist() for name in ("times_ps", "directions", "positions")}

    def do_quit(self, _request: Data) -> Data:
        """End the server."""
        self.server.stop()
        return {}

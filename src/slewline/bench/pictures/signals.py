"""The signals of a bench: the recorded pins, and their edges."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping
from functools import partial
from typing import TYPE_CHECKING

from ...core.messages.near import hint
from ...core.time.timebase import Time, picoseconds, readable, window
from ...core.wires.net import Bus, Net
from ...core.wires.pin import Terminal
from ...errors import NotRecorded, UnknownName, UsageError
from ...parts.base.part import check_kept
from ..circuit import Circuit
from .named_curves import axes_of

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray

    from ...core.motion.quantity import Quantity
    from ...record.recording.recorder import Recorder, TextLog


class Signals:
    """The recorded signals of a circuit."""

    def __init__(self, circuit: Circuit) -> None:
        self.circuit = circuit
        self.recorded: dict[str, Net | Terminal] = {}
        self.commands: dict[str, TextLog] = {}  # by the name of the chip
        self._recorder: Recorder | None = None

    @property
    def recorder(self) -> Recorder:
        """The recorder, created on first use."""
        if self._recorder is None:
            from ...record.recording.recorder import Recorder

            self._recorder = Recorder()
        return self._recorder

    def record(self, *pins: str, keep: Time | None = None) -> None:
        """Start recording pins; without names, all signal pins and buses of all chips.

        Clock outputs (CLK/15 of the CY525, CLKOUT of the MC1451A family) are recorded only when named: they never stop
        toggling, and would fill every file.

        Args:
            pins: full names, such as "x.slew".
            keep: how far back changes are kept, for endless runs; None: as set by `Bench(keep=)`, where the default
                keeps all changes.

        Raises:
            UnknownName: there is no such pin, chip or part.
            TimeError: `keep` is not a time.
        """
        keep_ps = self.circuit.keep_ps if keep is None else picoseconds(keep)
        if pins and isinstance(pins[0], (list, tuple)):
            raise UnknownName(f"record({pins[0]!r}): pass the names as separate arguments: bench.record(*names)")
        for name in pins or self._all_pins():
            probe = self._probe(name)
            self.recorder.record(probe, keep_ps)
            self.recorded[name] = probe
            self._record_commands(name.split(".")[0], keep_ps)

    def _record_commands(self, owner: str, keep_ps: int | None) -> None:
        """Also record which command is in progress, if the owner of a recorded pin is a chip."""
        from ...record.recording.recorder import TextLog

        if owner in self.commands:
            self.commands[owner].log.keep(keep_ps)
        elif owner in self.circuit.chips:
            self.commands[owner] = TextLog(self.circuit.kernel, self.circuit.chips[owner].on_command, keep_ps)

    def _probe(self, name: str) -> Net | Terminal:
        """Return the object to be recorded for a name: a net, a whole bus, or, for one wire of a bus, the pin."""
        net = self.circuit.net(name)
        if not isinstance(net, Bus):
            return net
        try:
            pin = self.circuit.pin(name)
        except UnknownName:  # the bus itself
            return net
        return net if pin.bit is None else pin

    def _all_pins(self) -> Iterator[str]:
        for chip in self.circuit.chips.values():
            for row in chip.sheet.pins:
                signal = row.in_out in ("in", "out", "both") and row.role != "clock"
                if signal and not isinstance(chip.pins[row.name].net, Bus):
                    yield f"{chip.name}.{row.name}"
            if any(isinstance(terminal.net, Bus) for terminal in chip.pins.values()):
                yield f"{chip.name}.{chip.sheet.bus}"

    def window_of(self, nets: Mapping[str, Net | Terminal], start: Time | None, stop: Time | None) -> tuple[int, int]:
        """Return the window (ps); by default from the earliest instant at which all nets are recorded, up to now.

        Raises:
            NotRecorded: no `start` is given, and the window would be empty, since the recording of a net begins now.
        """
        now = self.circuit.kernel.now
        first, last = window(start, stop, now)
        if start is not None:
            return first, last
        since = {name: self.recorder.since(net) for name, net in nets.items()}
        begun = max(since.values(), default=first)
        if nets and begun == now > self.circuit.since:
            name = max(since, key=lambda each: since[each])
            raise NotRecorded(
                f"the recording of {name} starts only now, at {readable(now)}, so it has no edges yet; call "
                f"bench.record({name!r}) before time passes"
            )
        return begun, last

    def chosen(self, pins: Iterable[str] | None) -> dict[str, Net | Terminal]:
        """Return recorded pins, keyed by full name; all of them if `pins` is None.

        Raises:
            UnknownName: there is no such pin.
            NotRecorded: a pin is not recorded; or `pins` is None, and nothing is recorded.
        """
        if pins is None:
            if not self.recorded:
                raise NotRecorded("nothing is recorded; call bench.record() before time passes")
            return dict(self.recorded)
        names = [pins] if isinstance(pins, str) else list(pins) if isinstance(pins, Iterable) else [pins]
        if wrong := [name for name in names if not isinstance(name, str)]:
            known = next(iter(self.recorded), "x.slew")
            raise UnknownName(f"pin {wrong[0]!r}: expected the name of a recorded pin, such as {known!r}")
        return {name: self.recorded[name] if name in self.recorded else self._recorded_wire(name) for name in names}

    def _recorded_wire(self, name: str) -> Net | Terminal:
        """Return one wire of a bus that is recorded as a whole; raise NotRecorded for any other pin."""
        wire, net = self._probe(name), self.circuit.net(name)
        if wire is not net and net in self.recorded.values():
            return wire
        raise NotRecorded(f"{name} is not recorded; call bench.record({name!r}) before time passes")

    def full_name(self, name: str) -> str:
        """Return the full name of a recorded pin; `name` may omit the owner if only one recorded pin fits.

        Raises:
            UsageError: `name` omits the owner, and several owners have a recorded pin with that name.
            NotRecorded: the pin is not recorded.
        """
        if not isinstance(name, str) or "." in name or not name:
            self.chosen([name])
            return name
        found = [full for full in self.chosen(None) if full.partition(".")[2] == name]
        if len(found) > 1:
            raise UsageError(f"pin {name!r}: this could be {' or '.join(found)}; write one of them")
        if not found:
            owners = list(self.circuit.chips)
            full = f"{owners[0]}.{name}" if len(owners) == 1 else name
            self.chosen([full])  # raises the right error
        return found[0]

    def edges(
        self, pin: str, start: Time | None = None, stop: Time | None = None
    ) -> tuple[NDArray[np.int64], NDArray[np.int8]]:
        """Return the changes of a recorded pin in start <= t <= stop; by default all recorded ones up to now.

        Returns:
            times: (n,) int64, picoseconds, ascending; levels: (n,), the level after each change: int8, -1 if floating,
                or for a bus int16, 0 to 255.

        Raises:
            UnknownName: there is no such pin.
            NotRecorded: the pin is not recorded, or its past is no longer kept that far back.
            TimeError: `start` or `stop` is not a time, or `stop` comes before `start`.
        """
        nets = self.chosen([pin])
        return self.recorder.edges(nets[pin], *self.window_of(nets, start, stop))  # type: ignore[return-value]

    def quantities(self) -> dict[str, Quantity]:
        """Return all quantities of axes and parts, by their full names, such as "x.velocity"."""
        chips, parts = self.circuit.chips, self.circuit.parts
        return {
            f"{scope}.{quantity.name}": quantity
            for scope, quantities in [
                *((scope, axis.quantities()) for chip in chips.values() for scope, axis in axes_of(chip)),
                *((part.name, part.quantities()) for part in parts.values()),
            ]
            for quantity in quantities
        }

    def quantity(self, name: str) -> Quantity:
        """Return a quantity, which has a value at every instant: `bench.quantity("driver.current").at("3 ms")`.

        Args:
            name: the full name, such as "x.velocity" or "m.axis2.position" for an axis, "driver.current" for a part.

        Raises:
            UnknownName: there is no such quantity; the message lists the existing ones.
        """
        chips, parts = self.circuit.chips, self.circuit.parts
        known = self.quantities()
        owner, _, what = name.partition(".") if isinstance(name, str) else ("", "", "")
        full = f"{owner}.axis1.{what}" if owner in chips and chips[owner].sheet.axes > 1 and "." not in what else name
        if full not in known:
            own = [each for each in known if each.partition(".")[0] == owner] or list(known)
            raise UnknownName(f"no quantity {name!r}; available: {', '.join(own) or 'none yet'}{hint(name, own)}")
        if owner in parts:
            known[full].check_kept = partial(check_kept, parts[owner])
        return known[full]

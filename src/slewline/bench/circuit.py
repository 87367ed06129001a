"""The circuit of a bench: chips, parts and the wires between them, all of which can be added at any time."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from functools import partial
from typing import TYPE_CHECKING, Any

from ..chips import CATALOGUE as CHIPS
from ..chips import chip_class, sheet_of
from ..core.chip import Chip
from ..core.component import Finding, forget_findings
from ..core.memory.store import JournaledStore
from ..core.messages.calls import answering
from ..core.messages.near import hint
from ..core.motion.kept import keep_more
from ..core.motion.one_axis import OneAxis
from ..core.time.hook import Hook
from ..core.time.kernel import Kernel
from ..core.time.timebase import hertz
from ..core.wires.net import Bus, Net
from ..core.wires.pin import Terminal
from ..errors import UnknownName, UsageError, WiringError
from ..parts import CATALOGUE as PARTS
from ..parts import KINDS, make_part, part_class
from ..parts.base.part import Part, forget_all, limit_kept
from .wiring import as_needed, free_name, joints, stem_of

if TYPE_CHECKING:
    from ..core.datasheet.table import Sheet
    from ..parts.shafts.shaft import Shaft


class Circuit:
    """Chips, parts and wires.

    Args:
        stores: a function that returns the non-volatile memory of a chip or part, given the name of that chip or part.
        keep_ps: the length (ps) of the past that chips, parts and hosts keep; None for everything.
    """

    def __init__(self, kernel: Kernel, stores: Callable[[str], Any] | None, keep_ps: int | None) -> None:
        self.kernel, self.stores, self.keep_ps = kernel, stores, keep_ps
        self.outside = kernel.outside
        self.chips: dict[str, Chip] = {}
        self.parts: dict[str, Part] = {}
        self.on_finding: Hook[[Finding]] = Hook()  # of any chip or part
        self._new: list[Chip | Part] = []  # chips and parts added since time last passed

    def add(
        self,
        /,
        part: str | type[Chip],
        name: str | None = None,
        crystal: str | int | None = None,
        straps: Mapping[str, int] | None = None,
        bare: bool = False,
        **options: Any,
    ) -> Chip:
        """Put a chip on the bench, at any time; it powers up immediately.

        Unconnected strap pins read as the data sheet states: GS-C modules communicate at 110 baud, with checksums.
        The command line, slewline:// and the pytest plugin strap modules for 9600 baud (table: docs/reference/api.md).

        Args:
            part: the part number in lower case, such as "cy525"; for a chip of your own, the name of its entry point
                (in the group slewline.chips), or "my_lab.mx10:Mx10" (the module is imported), or the class itself.
            name: the name on the bench; by default the part number, with a number if there are several.
            crystal: "11 MHz", or a number of hertz; by default the usual crystal of the data sheet.
            straps: fixed levels, 0 or 1, of input pins, by name.
            bare: leave out the standard wiring (ABORT high, STEP INHIBIT low ...).
            options: options of the part, such as rate=80 or stepwise=True.

        Raises:
            UnknownName: there is no such part, or the part lacks a pin to strap; the message lists the existing ones.
            UsageError: the name is taken, a crystal, strap or option is out of range, or the module cannot be imported.
        """
        if not isinstance(bare, bool):
            raise UsageError(f"add({part!r}): bare {bare!r}; allowed True, False")
        try:
            cls = chip_class(part) if isinstance(part, str) else part
        except UnknownName as error:
            if str(part) not in PARTS.ours:
                raise
            raise UnknownName(f"{error}; {part} is a part: use bench.part({part!r})") from None
        if not (isinstance(cls, type) and issubclass(cls, Chip)):
            raise UsageError(f"add({part!r}): expected a part number such as 'cy525', or the class of a chip")
        sheet_of(cls)  # the neighbour is required
        name = self.new_name(name, cls.sheet.part.replace("-", "_"))
        hz = None if crystal is None else crystal_for(cls.sheet, crystal)
        if self.stores is not None and cls.sheet.keeps:
            options.setdefault("store", self.stores(name))
        kept = self._witnessed(name, options)
        with self.outside.nested():  # it may switch on the chip's supply
            chip = cls(self.kernel, name, hz, bare=bare, straps=straps, **options)
        if self.outside.on_input or self.outside.write:
            self.outside.record(
                "add",
                part=CHIPS.name_of(cls),
                behaviour=cls.sheet.behaviour,
                name=name,
                crystal_hz=hz,
                straps=dict(straps or {}),
                bare=bare,
                options=options | kept(),
            )
        self.chips[name] = chip
        for number in range(1, len(chip.axes) + 1) if self.keep_ps is not None else ():
            axis = chip.axis(number)
            axis.motor.kept.limit(axis.name, self.keep_ps)
        self._adopt(chip)
        self.kernel.settle()
        return chip

    def part(
        self,
        /,
        kind: str | type[Part],
        name: str | None = None,
        to: Chip | Part | str | None = None,
        on: Part | str | None = None,
        **options: Any,
    ) -> Part:
        """Make a part and put it on the bench, at any time; it starts working at this instant.

        Args:
            kind: the kind of part, such as "uart"; `slewline.parts.KINDS` lists the built-in ones.  For a part
                of your own, the name of its entry point (in the group slewline.parts), or "my_lab.lamp:Lamp"
                (the module is imported), or the class itself.
            name: the name on the bench; by default the kind, or the name of the class in lower case, with a number if
                there are several.
            to: a chip or part; the pins of the new part are wired to the pins of `to` with matching roles.
            on: the part on whose shaft the new part is mounted: a motor, a gear, a carriage.
            options: options of the part.

        Raises:
            UnknownName: there is no such kind, or no such chip or part on the bench.
            UsageError: the name is taken, the kind lacks an option or does not allow its value, the part cannot be
                mounted on `on`, or the module cannot be imported.
            WiringError: the chip or part given as `to` lacks a pin that is needed; nothing is added to the bench then.
        """
        try:
            cls = kind if isinstance(kind, type) else part_class(kind)
        except UnknownName as error:
            if str(kind) not in CHIPS.ours:
                raise
            raise UnknownName(f"{error}; {kind} is a chip: use bench.add({kind!r})") from None
        if not issubclass(cls, Part):
            raise UsageError(f"part({kind!r}): expected a kind such as 'uart', or the class of a part")
        kind = kind if isinstance(kind, str) and kind in KINDS else PARTS.name_of(cls)
        fixed = KINDS[kind].fixed if kind in KINDS else {}
        name = self.new_name(name, stem_of(kind, cls))
        neighbour = None if to is None else self._there(to)
        if self.stores is not None and cls.keeps:
            options.setdefault("store", self.stores(name))
        if "image" in options:
            from .files.images import image_given  # most benches read no file

            options["image"] = image_given(name, options["image"])
        kept = self._witnessed(name, options) if cls.keeps else dict
        part = make_part(cls, self.kernel, name, options, fixed, **self._mounted(kind, cls.sits, name, on))
        pairs = [] if neighbour is None else joints(kind, part, neighbour)
        lists = (bytes, bytearray, set, frozenset)
        plain = {key: list(value) if isinstance(value, lists) else value for key, value in options.items()}
        self.outside.record(
            "part",
            kind=kind,
            name=name,
            to=neighbour and neighbour.name,
            options=plain | kept(),
            **{} if on is None else {"on": on if isinstance(on, str) else on.name},
        )
        self.place(part)
        self.kernel.settle()
        for own, theirs in pairs:
            theirs.net.join(own.net)
            self.kernel.settle()
        for own, theirs in pairs:
            part.attached(own.row.name, as_needed(theirs.row))
        self.kernel.settle()
        return part

    def _witnessed(self, name: str, options: dict[str, Any]) -> Callable[[], dict[str, Any]]:
        """Return a function that reads the store in `options` and returns {"store": content}.

        The function returns {} if there is no store, or if inputs are neither recorded nor observed.  It may only be
        called when the owner of the store is ready.  If there is a journal, the store in `options` is replaced by one
        that also records its faults in the journal.
        """
        store = options.get("store")
        if store is None or not (self.outside.on_input or self.outside.write):
            return dict
        if self.outside.write is not None:
            options["store"] = store = JournaledStore(store, partial(self._record_journal, name))
            return lambda: {"store": list(store.begin())}
        return lambda: {"store": list(store.read())}

    def _record_journal(self, name: str, **what: Any) -> None:
        """Record a fault of a store in the current journal."""
        if self.outside.write is not None:
            self.outside.write("store", {"of": name} | what)

    def _mounted(self, kind: str, sits: str, name: str, on: Part | str | None) -> dict[str, Shaft]:
        """Return {"on": shaft}, the constructor argument for a new part on the shaft of `on`; {} if `on` is None."""
        if on is None:
            if sits == "must":
                raise UsageError(f"{name}: this {kind} needs a shaft; name its owner: on=motor or on='its name'")
            return {}
        if not sits:
            raise UsageError(f"{name}: this {kind} is not mounted on a shaft; leave out on=")
        from ..parts.shafts.shaft import Shaft

        carrier = self._there(on)
        shaft = getattr(carrier, "shaft", None)
        if not isinstance(shaft, Shaft):
            having = [other.name for other in self.parts.values() if isinstance(getattr(other, "shaft", None), Shaft)]
            there = ", ".join(having) or "none yet; a motor or a translator has one"
            raise UsageError(f"{name}: {carrier.name} has no shaft; parts with a shaft: {there}")
        return {"on": shaft}

    def _there(self, neighbour: Chip | Part | str) -> Chip | Part:
        """Return a chip or part of this bench, given by its name or as the object itself."""
        if isinstance(neighbour, str):
            return self[neighbour]
        if not any(neighbour is owner for owner in self.owners()):
            raise UnknownName(f"{getattr(neighbour, 'name', neighbour)!r} is not a chip or part of this bench")
        return neighbour

    def place(self, part: Part) -> Part:
        """Put an existing part on the bench; its pins can then be wired.

        Raises:
            UsageError: the name of the part is taken.
        """
        self.new_name(part.name, part.name)
        self.parts[part.name] = part
        self._adopt(part)
        return part

    def _adopt(self, owner: Chip | Part) -> None:
        if isinstance(owner, Part):
            limit_kept(owner, self.keep_ps)
        owner.on_finding.add(self.on_finding)
        if not self._new and self.kernel.running:  # added during a run: it takes part from the next round
            self.kernel.call_at(self.kernel.now, self.finish_wiring)
        self._new.append(owner)

    def finish_wiring(self) -> None:
        """Notify new chips and parts that their wiring is complete, before time passes."""
        if not self._new:
            return
        new, self._new = self._new, []
        for owner in new:
            if isinstance(owner, Part):
                owner.rewired()
        for owner in new:
            if isinstance(owner, Chip):
                owner.check_wiring()

    def new_name(self, name: str | None, stem: str) -> str:
        """Return an unused name: the requested one, or by default the stem, with a number appended if necessary."""
        taken = {**self.chips, **self.parts}
        if name is None:
            name = free_name(stem, taken)
        if not isinstance(name, str) or not name.replace("_", "a").isalnum():
            meant = f"; a neighbour is to={name.name}" if isinstance(name, Chip | Part) else ""
            raise UsageError(f"name {name!r}: allowed letters, digits and underscores{meant}")
        if name in taken:
            raise UsageError(f"the bench has a {name!r} already; give another name")
        return name

    def __getitem__(self, name: str) -> Chip | Part:
        """Return a chip or part by name."""
        for owners in (self.chips, self.parts):
            if name in owners:
                return owners[name]
        names = [*self.chips, *self.parts]
        raise UnknownName(f"the bench has no {name!r}; available: {', '.join(names) or 'none yet'}{hint(name, names)}")

    def pin(self, name: str) -> Terminal:
        """Return a pin by its full name, for example "x.slew".

        Raises:
            UnknownName: there is no such chip, part or pin; the message lists the existing ones.
        """
        owner, dot, pin = name.partition(".") if isinstance(name, str) else (repr(name), "", "")
        if not dot:
            raise UnknownName(f"pin {name!r}: give owner and pin, such as {self._pin_like(name)!r}")
        return self[owner].pin(pin)

    def _pin_like(self, name: str) -> str:
        """Return the full name of a pin with the given short name, or of any pin if none has this short name."""
        pins = [f"{owner.name}.{pin}" for owner in self.owners() for pin in owner.pins]
        return next((full for full in pins if full.endswith(f".{name}")), next(iter(pins), "x.slew"))

    @answering("wire()", "; two pins, such as bench.wire('x.run', 'y.wait')")
    def wire(self, a: str, b: str, invert: bool = False) -> None:
        """Connect two pins, at any time; if `invert` is true, an inverter drives `b` from `a`.

        "x.db" and "y.db" are whole buses ("x.hostdata" on a chip whose manual uses that name).

        Raises:
            UnknownName: there is no such pin; the message lists the existing ones.
            WiringError: one is a bus and the other a single pin, both are the same, or a pin carries no signal.
        """
        if not isinstance(invert, bool):
            raise UsageError(f"wire {a} to {b}: invert {invert!r}; allowed True, False")
        first, second = self.net(a), self.net(b)
        if first is second:
            raise WiringError(f"wire {a} to {b}: both ends are the same pin or bus; give two different ones")
        if isinstance(first, Bus) != isinstance(second, Bus):
            raise WiringError(f"wire {a} to {b}: a bus of eight wires does not fit a single pin; wire bus to bus")
        self.outside.record("wire", a=a, b=b, invert=invert)
        if invert:
            from ..parts.logic.gates import WireInverter

            second.tie = None
            WireInverter(self.kernel, f"inverter of {a}", first, second).rewired()
        else:
            first.join(second)
        self.kernel.settle()

    def net(self, name: str) -> Net:
        """Return the net of a pin, or the net of a whole bus, given the full name of the pin or bus."""
        for chip in self.chips.values():
            if name == f"{chip.name}.{chip.sheet.bus}":
                return chip.bus
        terminal = self.pin(name)
        if (row := terminal.row).in_out in ("power", "none"):
            raise WiringError(f"{name} (pin {row.number}: {row.description}) carries no signal; leave it unconnected")
        return terminal.net

    @property
    def findings(self) -> list[Finding]:
        """The findings of all chips and parts, in chronological order; parts that compute on demand catch up first."""
        return sorted((found for owner in self.owners() for found in owner.findings), key=lambda found: found.time_ps)

    @property
    def title(self) -> str:
        """The chips and their part numbers: the default title of a picture."""
        parts = [(chip.name, chip.sheet.part.upper()) for chip in self.chips.values()]
        return parts[0][1] if len(parts) == 1 else ", ".join(f"{name}: {part}" for name, part in parts)

    def owners(self) -> list[Chip | Part]:
        """Return all parts and chips."""
        return [*self.parts.values(), *self.chips.values()]

    def axes(self) -> Iterator[tuple[Chip, int, OneAxis]]:
        """Yield every axis of every chip, with its number."""
        for chip in self.chips.values():
            for number in range(1, chip.sheet.axes + 1):
                yield chip, number, chip.axis(number)

    @property
    def since(self) -> int:
        """The earliest instant of the past that is kept, ps."""
        return 0 if self.keep_ps is None else max(self.kernel.seen - self.keep_ps, 0)

    def forget(self) -> None:
        """Drop data that is too old to be kept.

        A moving axis does so by itself; an axis at rest, whose encoder may turn or register be loaded, needs this call.
        """
        if self.keep_ps is None:
            return
        before, remedy = self.since, keep_more(self.keep_ps)
        for chip in self.chips.values():
            for axis in chip.axes:
                axis.forget(before)
        for part in self.parts.values():
            forget_all(part, before)
        for owner in self.owners():
            forget_findings(owner, before, remedy)

    def catch_up(self) -> None:
        """Let parts that compute only on demand catch up to now; listeners are called with the resulting findings.

        It is called by `findings`, before a picture or file is made, and at the end of a replay.
        """
        for part in self.parts.values():
            part.be_caught_up()


def crystal_for(sheet: Sheet, crystal: str | int) -> int:
    """Return a crystal frequency in hertz, after checking that the chip allows it.

    Raises:
        UsageError: the part has no selectable crystal, or the frequency is far outside the range in the data sheet.
    """
    if not sheet.crystal_high_hz:
        raise UsageError(f"crystal {crystal!r}: the {sheet.part} has no selectable crystal; {sheet.manual}")
    hz = hertz(crystal)
    low, high = sheet.crystal_low_hz // 2, sheet.crystal_high_hz * 12 // 11
    if not low <= hz <= high:
        raise UsageError(
            f"crystal {crystal!r}: {sheet.part.upper()} takes {sheet.crystal_low_hz / 1e6:g} to "
            f"{sheet.crystal_high_hz / 1e6:g} MHz (up to {high / 1e6:g} with a finding); {sheet.manual}"
            + (f"; a bare number is hertz: write '{hz} MHz'" if low <= hz * 10**6 <= high else "")
        )
    return hz

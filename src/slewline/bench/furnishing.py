"""Furnishing a bench: chips and parts are put on it, and wired, before time passes or later."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from itertools import chain, count
from os import PathLike
from random import Random
from typing import TYPE_CHECKING, Any

from ..chips import CATALOGUE as CHIPS
from ..chips import chip_class, sheet_of
from ..core.chip import Chip
from ..core.component import Finding
from ..core.memory.store import Witnessed
from ..core.messages.calls import answering
from ..core.messages.near import hint
from ..core.messages.whole import whole
from ..core.time.hook import Hook
from ..core.time.kernel import Kernel
from ..core.time.timebase import Time, hertz, picoseconds, readable
from ..core.wires.net import Bus, Net
from ..core.wires.pin import Terminal
from ..errors import UnknownName, UsageError, WiringError
from ..parts import CATALOGUE as PARTS
from ..parts import make_part, part_class
from ..parts.base.part import Part
from .by_name import adds, makes
from .pictures.drawing import Drawing
from .wiring import as_needed, joints

if TYPE_CHECKING:
    from ..core.datasheet.table import Sheet
    from ..parts.shafts.shaft import Shaft
    from .files.journal import Journal


SHOWN = 8  # chips and parts in the text of a bench


def _check_made_with(journal: object, shuffle: object, stores: object) -> None:
    """Check what a bench is made with, beside its seed."""
    for name, given, fits, allowed in (
        ("journal", journal, isinstance(journal, (str, PathLike)), "the name of a file"),
        ("shuffle", shuffle, whole(shuffle) is not None, "a whole number, the seed of the order"),
        ("stores", stores, callable(stores), "a function that is given a name and returns a memory"),
    ):
        if given is not None and not fits:
            raise UsageError(f"Bench({name}={given!r}): allowed {allowed}, None")


class Furnished(Drawing):
    """A bench with things on it; `Bench` lets time pass."""

    @answering("Bench()", '; a chip is put on it by add("cy525")')
    def __init__(
        self,
        seed: int = 0,
        journal: str | PathLike[str] | None = None,
        shuffle: int | None = None,
        stores: Callable[[str], Any] | None = None,
        keep: Time | None = None,
    ) -> None:
        _check_made_with(journal, shuffle, stores)
        super().__init__(Kernel(None if shuffle is None else Random(shuffle)))
        self.stores = stores
        self.keep_ps = None if keep is None else picoseconds(keep)
        number = whole(seed)
        if number is None:
            raise UsageError(
                f"Bench({seed!r}): allowed a whole number, the seed of chance; add() puts a chip on a bench"
            )
        self.seed = seed = number
        self.random = Random(seed)
        self.chips = {}
        self.parts = {}
        self.outside = self.kernel.outside
        self.outside.let_pass = self._wait_for
        self.journal: Journal | None = None
        if journal is not None:
            from .files.journal import Journal

            self.journal = Journal(journal, self.kernel, seed)
            self.outside.write = self.journal.write
        self._fresh: list[Chip | Part] = []  # what has been put on the bench since time passed last
        self.on_finding: Hook[[Finding]] = Hook()  # of any chip or part
        self.on_input, self.on_commit = self.outside.on_input, self.kernel.on_commit

    # ---------------------------------------------------------------------------------------------------- furnishing
    @adds
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
        """Put a chip on the bench, at any time; it powers up at once.

        Open strap pins read as the sheet says: a GS-C module listens at 110 baud, with checksums.  `slewline run`,
        `serve`, slewline:// and the pytest plugin strap it for 9600 baud (a table in docs/reference/api.md).

        Args:
            part: part number in lower case, for example "cy525"; a chip of one's own by the name of its entry point
                (slewline.chips), as "my_lab.mx10:Mx10", which imports the module, or the class itself.
            name: defaults to the part number, numbered when there are several.
            crystal: "11 MHz", or hertz; the sheet's own by default.
            straps: fixed levels of input pins.
            bare: leave out the standard wiring (ABORT high, STEP INHIBIT low ...).
            options: of the part, for example rate=80 or stepwise=True.

        Raises:
            UnknownName: no such part, or a strap that is no pin of it; the message lists those there are.
            UsageError: a name that is taken, a crystal, strap or option out of range, a module that cannot be imported.
        """
        if not isinstance(bare, bool):
            raise UsageError(f"add({part!r}): bare {bare!r}; allowed True, False")
        cls = chip_class(part) if isinstance(part, str) else part
        if not (isinstance(cls, type) and issubclass(cls, Chip)):
            raise UsageError(f"add({part!r}): expected a part number such as 'cy525', or the class of a chip")
        sheet_of(cls)  # which it must have
        name = self._new_name(name, cls.sheet.part.replace("-", "_"))
        hz = None if crystal is None else crystal_for(cls.sheet, crystal)
        if self.stores is not None and cls.sheet.keeps:
            options.setdefault("store", self.stores(name))
        kept = self._witnessed(name, options)
        with self.outside.nested():  # it may switch its supply on
            chip = cls(self.kernel, name, hz, bare=bare, straps=straps, **options)
        if self.outside.on_input or self.outside.write:
            self.outside.tell(
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

    @makes
    def part(
        self,
        /,
        kind: str | type[Part],
        name: str | None = None,
        to: Chip | Part | str | None = None,
        on: Part | str | None = None,
        **options: Any,
    ) -> Part:
        """Make a part and put it on the bench, at any time; it works from this instant on.

        Args:
            kind: for example "uart"; slewline.parts.KINDS lists ours.  A part of one's own by the name of its entry
                point (slewline.parts), as "my_lab.lamp:Lamp", which imports the module, or the class itself.
            name: defaults to the kind, or the class in lower case; numbered when there are several.
            to: chip or part to whose pins those of the new part are wired in the standard way: by their roles.
            on: part on whose shaft the new part sits: a motor, a gear, a carriage.
            options: of the part.

        Raises:
            UnknownName: no such kind or neighbour.
            UsageError: a name that is taken, an option that the kind does not have or allow; it does not sit there; a
                module that cannot be imported.
            WiringError: the neighbour lacks a pin that the part needs; nothing has been put on the bench then.
        """
        cls = kind if isinstance(kind, type) else part_class(kind)
        if not issubclass(cls, Part):
            raise UsageError(f"part({kind!r}): expected a kind such as 'uart', or the class of a part")
        kind = PARTS.name_of(cls)
        name = self._new_name(name, cls.__name__.lower() if ":" in kind else kind.replace("-", "_"))
        neighbour = None if to is None else self._there(to)
        if self.stores is not None and cls.keeps:
            options.setdefault("store", self.stores(name))
        if "image" in options:
            from .files.images import image_given  # most benches read no file

            options["image"] = image_given(name, options["image"])
        kept = self._witnessed(name, options) if cls.keeps else dict
        part = make_part(cls, self.kernel, name, options, **self._mounted(kind, cls.sits, name, on))
        pairs = [] if neighbour is None else joints(kind, part, neighbour)
        lists = (bytes, bytearray, set, frozenset)
        plain = {key: list(value) if isinstance(value, lists) else value for key, value in options.items()}
        self.outside.tell(
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
        """What returns the content of a store among options, for those who hear of inputs; a journal hears its faults.

        It is asked when the owner of the store is ready.
        """
        store = options.get("store")
        if store is None or not (self.outside.on_input or self.outside.write):
            return dict
        if self.journal is not None:
            journal = self.journal
            options["store"] = store = Witnessed(store, lambda **what: journal.write("store", {"of": name} | what))
            return lambda: {"store": list(store.begin())}
        return lambda: {"store": list(store.read())}

    def _mounted(self, kind: str, sits: str, name: str, on: Part | str | None) -> dict[str, Shaft]:
        """The shaft that a new part sits on, as an argument of its constructor; none, if it sits on none."""
        if on is None:
            if sits == "must":
                raise UsageError(
                    f"{name}: a {kind} sits on a shaft; say on which: on=motor, or on='the name of a part'"
                )
            return {}
        if not sits:
            raise UsageError(f"{name}: a {kind} sits on no shaft; leave out on=")
        from ..parts.shafts.shaft import Shaft

        carrier = self._there(on)
        shaft = getattr(carrier, "shaft", None)
        if not isinstance(shaft, Shaft):
            having = [other.name for other in self.parts.values() if isinstance(getattr(other, "shaft", None), Shaft)]
            there = ", ".join(having) or "none yet; a motor or a translator has one"
            raise UsageError(f"{name}: {carrier.name} has no shaft; parts that do: {there}")
        return {"on": shaft}

    def _there(self, neighbour: Chip | Part | str) -> Chip | Part:
        """A chip or part of this bench, which is named or given itself."""
        if isinstance(neighbour, str):
            return self[neighbour]
        if not any(neighbour is owner for owner in self._owners()):
            raise UnknownName(f"{getattr(neighbour, 'name', neighbour)!r} is no chip and no part of this bench")
        return neighbour

    def place(self, part: Part) -> Part:
        """Put a part on the bench; its pins can be wired from now on."""
        self._new_name(part.name, part.name)
        self.parts[part.name] = part
        self._adopt(part)
        return part

    def _adopt(self, owner: Chip | Part) -> None:
        owner.on_finding.add(self.on_finding)
        if not self._fresh and self.kernel.running:  # furnished in mid-run: it counts from the next round on
            self.kernel.call_at(self.kernel.now, self._begin)
        self._fresh.append(owner)

    def _begin(self) -> None:
        """Time is about to pass: what is new on the bench is wired."""
        if not self._fresh:
            return
        fresh, self._fresh = self._fresh, []
        for owner in fresh:
            if isinstance(owner, Part):
                owner.rewired()
        for owner in fresh:
            if isinstance(owner, Chip):
                owner.check_wiring()

    def _owners(self) -> list[Chip | Part]:
        """Everything that stands on the bench."""
        return [*self.parts.values(), *self.chips.values()]

    def _new_name(self, name: str | None, stem: str) -> str:
        taken = {**self.chips, **self.parts}
        if name is None:
            name = next(n for n in chain((stem,), (f"{stem}_{i}" for i in count(2))) if n not in taken)
        if not isinstance(name, str) or not name.replace("_", "a").isalnum():
            raise UsageError(f"name {name!r}: letters, digits and underscores, please")
        if name in taken:
            raise UsageError(f"the bench has a {name!r} already; names are unique")
        return name

    def __contains__(self, name: object) -> bool:
        return any(name in owners for owners in (self.chips, self.parts))

    def __iter__(self) -> Iterator[str]:
        """The names of chips and parts, in the order in which they came."""
        return iter([*self.chips, *self.parts])

    def __repr__(self) -> str:
        names = [f"{chip.name} ({chip.sheet.part})" for chip in self.chips.values()] + [*self.parts]
        if len(names) > SHOWN:
            names[SHOWN:] = [f"{len(names) - SHOWN} more"]
        return f"<Bench: {', '.join(names) or 'empty'}; {readable(self.kernel.now)}>"

    def __getitem__(self, name: str) -> Chip | Part:
        """A chip or part by name."""
        for owners in (self.chips, self.parts):
            if name in owners:
                return owners[name]
        names = [*self.chips, *self.parts]
        raise UnknownName(f"the bench has no {name!r}; there are: {', '.join(names) or 'none yet'}{hint(name, names)}")

    def pin(self, name: str) -> Terminal:
        """Return a pin by its full name, for example "x.slew".

        Raises:
            UnknownName: no such chip, part or pin; the message lists those there are.
        """
        owner, dot, pin = name.partition(".") if isinstance(name, str) else (repr(name), "", "")
        if not dot:
            raise UnknownName(f"pin {name!r}: give owner and pin, such as {self._pin_like(name)!r}")
        return self[owner].pin(pin)

    def _pin_like(self, name: str) -> str:
        """The full name of a pin of this bench that is called so, or of any."""
        pins = [f"{owner.name}.{pin}" for owner in self._owners() for pin in owner.pins]
        return next((full for full in pins if full.endswith(f".{name}")), next(iter(pins), "x.slew"))

    # ------------------------------------------------------------------------------------------------------- wiring
    def wire(self, a: str, b: str, invert: bool = False) -> None:
        """Connect two pins, at any time; with `invert` an inverter drives the second from the first.

        "x.db" and "y.db" are whole buses ("x.hostdata", where the chip calls it so).

        Raises:
            UnknownName: no such pin.
            WiringError: a bus and a single pin, or a pin that carries no signal.
        """
        if not isinstance(invert, bool):
            raise UsageError(f"wire {a} to {b}: invert {invert!r}; allowed True, False")
        one, two = self._net(a), self._net(b)
        if one is two:
            raise WiringError(f"wire {a} to {b}: that is one and the same; give two pins")
        if isinstance(one, Bus) != isinstance(two, Bus):
            raise WiringError(f"wire {a} to {b}: a bus of eight wires does not fit a single pin; wire bus to bus")
        self.outside.tell("wire", a=a, b=b, invert=invert)
        if invert:
            from ..parts.logic.gates import WireInverter

            two.tie = None
            WireInverter(self.kernel, f"inverter of {a}", one, two).rewired()
        else:
            one.join(two)
        self.kernel.settle()

    def _net(self, name: str) -> Net:
        for chip in self.chips.values():
            if name == f"{chip.name}.{chip.sheet.bus}":
                return chip.bus
        terminal = self.pin(name)
        if terminal.row.way in ("power", "none"):
            raise WiringError(
                f"{name} (pin {terminal.row.number}: {terminal.row.says}) carries no signal and stays unconnected"
            )
        return terminal.net

    def _wait_for(self, met: Callable[[], bool], what: str, timeout: Time) -> None:
        """Let time pass until something is met."""
        raise NotImplementedError

    # ------------------------------------------------------------------------------------------------------ findings
    @property
    def findings(self) -> list[Finding]:
        """What hosts did wrong, of all chips and parts, in order of time; parts that are lazy catch up first."""
        return sorted((found for owner in self._owners() for found in owner.findings), key=lambda found: found.time_ps)


def crystal_for(sheet: Sheet, crystal: str | int) -> int:
    """Return a crystal that a part can be fitted with, in hertz.

    Raises:
        UsageError: the part has none to choose, or it is far outside the sheet's range.
    """
    if not sheet.crystal_high_hz:
        raise UsageError(f"crystal {crystal!r}: the {sheet.part} has none to choose; {sheet.manual}")
    hz = hertz(crystal)
    low, high = sheet.crystal_low_hz // 2, sheet.crystal_high_hz * 12 // 11
    if not low <= hz <= high:
        raise UsageError(
            f"crystal {crystal!r}: {sheet.part.upper()} takes {sheet.crystal_low_hz / 1e6:g} to "
            f"{sheet.crystal_high_hz / 1e6:g} MHz (up to {high / 1e6:g} with a finding); {sheet.manual}"
            + (f"; a bare number is hertz: write '{hz} MHz'" if low <= hz * 10**6 <= high else "")
        )
    return hz

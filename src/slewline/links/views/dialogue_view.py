r"""Data sent by hosts and chips, with findings and events: entries with numbers, oldest first.

    12  0.012292 s  x_line  sent     F\r
    13  0.017729 s  x_line  got      E1\r
    14  0.017729 s  x       finding  parity: ...

A host on the bench sends whole commands; on the line of an outside host, characters come one by one, and share an entry
up to a carriage return.  A chip with registers reports the command that it executes.
"""

from __future__ import annotations

from collections import OrderedDict, deque
from collections.abc import Iterable, Iterator, Mapping
from functools import partial
from itertools import islice, takewhile
from typing import TYPE_CHECKING, Any

from ...core.component import Finding
from ...parts.boards.board import Board
from ...parts.hosts.host import Host

if TYPE_CHECKING:
    from ...bench import Bench
    from ...core.wires.receiver import Character

KEPT = 10_000  # entries
LONGEST = 64  # characters that share an entry
RETURN = 0x0D
SENT, GOT, FINDING, COMMAND, EVENT = "sent", "got", "finding", "command", "event"

Entry = dict[str, Any]


class Dialogue:
    """The dialogue entries of a bench, recorded from the creation of this object.

    Args:
        names: the names to show as senders; each is keyed by the name of the part in which a line ends.
    """

    def __init__(self, bench: Bench, names: Mapping[str, str]) -> None:
        self.bench, self.kernel, self.names = bench, bench.kernel, names
        self.entries: deque[Entry] = deque(maxlen=KEPT)
        self.number = 0  # number of the next entry
        self.touched = 0  # count, incremented by every change
        self.grown: OrderedDict[int, Entry] = OrderedDict()  # entries that have grown, the last one at the end
        self.growing: dict[str, tuple[Entry, bytearray]] = {}  # current entry, by sender
        for found in bench.findings:
            self.finding(found)
        self._listen(bench)

    def move(self, bench: Bench) -> None:
        """Stop observing the current bench, and observe another one."""
        self.bench.on_finding.remove(self.finding)
        self.bench.on_input.remove(self._input)
        self.bench, self.kernel = bench, bench.kernel
        self._listen(bench)

    def _listen(self, bench: Bench) -> None:
        names = self.names
        bench.on_finding.add(self.finding)
        bench.on_input.add(self._input)
        for part in bench.parts.values():
            if isinstance(part, Host) and part.name not in names:
                part.on_event.add(partial(self._event, part))
            elif (on_character := getattr(part, "on_character", None)) is not None:
                on_character.add(partial(self._character, part.name))
        registers = any(isinstance(part, Board) for part in bench.parts.values())
        for chip in bench.chips.values():
            chip.on_command.add(partial(self._command, chip.name) if registers else ignore)

    def add(self, who: str, kind: str, text: str, at: int | None = None, **more: Any) -> Entry:
        """Add an entry at an instant (ps; None: now), with `more` as additional fields; return the entry."""
        time = self.kernel.now if at is None else at
        entry: Entry = {"number": self.number, "time_ps": time, "who": who, "kind": kind, "text": text, **more}
        self.number += 1
        self.touched += 1
        entry["touched"] = self.touched
        self.entries.append(entry)
        return entry

    def since(self, number: int) -> tuple[list[Entry], int]:
        """Return the stored entries numbered `number` or higher, and the number of such entries already dropped."""
        first = self.number - len(self.entries)
        return [plain(entry) for entry in islice(self.entries, max(number - first, 0), None)], max(first - number, 0)

    def changed(self, touched: int, number: int) -> Iterator[Entry]:
        """Yield the entries numbered `number` or higher, and older ones whose change count is above `touched`.

        The newest entries come first.
        """
        for entry in islice(reversed(self.entries), self.number - number):
            yield plain(entry)
        before = takewhile(lambda entry: entry["touched"] > touched, reversed(self.grown.values()))
        for entry in sorted(before, key=lambda entry: -int(entry["number"])):
            if entry["number"] < number:
                yield plain(entry)

    # ----------------------------------------------------------------------------------------------------- listeners
    def finding(self, found: Finding) -> None:
        """Add a finding, and end the growing entries, so that the finding directly follows the byte that caused it."""
        self.growing.clear()
        self.add(found.source, FINDING, found.text, found.time_ps, code=found.code)

    def _event(self, host: Host, text: str) -> None:
        """Record a command from a host on the bench, and the answer to the command."""
        who = host.chip.name
        sent, arrow, got = text.partition(" -> ")
        self.add(who, SENT, sent)
        if arrow:
            self.add(who, GOT, got)

    def _command(self, who: str, text: str) -> None:
        if text:
            self.add(who, COMMAND, text)

    def _input(self, do: str, what: dict[str, Any]) -> None:
        """Record a byte or text written by an outside host, or the switching of a chip's power."""
        if do == "input" and what["verb"] == "write":
            for byte in written(what["args"]):
                self._grow(what["part"], SENT, byte)
        elif do == "power":
            self.add(what["chip"], EVENT, f"power {'on' if what['on'] else 'off'}")

    def _character(self, who: str, character: Character) -> None:
        """Record a character sent by a chip."""
        self._grow(who, GOT, character.byte)

    def _grow(self, who: str, kind: str, byte: int) -> None:
        who = self.names.get(who, who)
        entry, data = self.growing.get(who, ({}, bytearray()))
        if entry.get("kind") != kind:
            data = bytearray()
            entry = self.add(who, kind, "")
            self.growing[who] = entry, data
        data.append(byte)
        entry["text"] = data.decode("latin-1").encode("unicode_escape").decode("ascii")
        self.touched += 1
        entry["touched"] = self.touched
        self.grown[entry["number"]] = entry
        self.grown.move_to_end(entry["number"])
        if len(self.grown) > KEPT:
            self.grown.popitem(last=False)
        if byte == RETURN or len(data) >= LONGEST:
            del self.growing[who]


def ignore(_text: str) -> None:
    """Do nothing with a command; a chip reports its commands only while a function such as this is registered."""


def written(args: list[Any]) -> Iterable[int]:
    """Return the bytes written by an input, given its arguments: a list of bytes, or a text; empty if neither."""
    for arg in args:
        if isinstance(arg, list):
            return arg
    return args[0].encode() if args and isinstance(args[0], str) else ()


def plain(entry: Entry) -> Entry:
    """Return an entry without its change count, as sent to a client."""
    return {key: value for key, value in entry.items() if key != "touched"}

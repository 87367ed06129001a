"""The board of a GS-C200S with a Pico: read its netlist (hardware/gs_c200s), check it by rules, list its parts.

    python tools/netlist.py            print the bill of materials, and the violations of the rules

A rule compares the two ends of a wire: voltages, levels, currents.  Rules cannot prove that the circuit works.
"""

from __future__ import annotations

import sys
import tomllib
from collections import Counter
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

from slewline.chips.gs_c200.sheet import GS_C200S

ROOT = Path(__file__).resolve().parent.parent
FOLDER = ROOT / "hardware" / "gs_c200s"
MODULE = "J"
MOST_PICO_MA = 50  # of all its outputs
LOADS_MA = {"v5_20": 100, "vsl_plus": 10, "vsl_minus": 10}  # that the sheet allows a user to take
LEVELS_V = (0.8, 2.0, 5.0)  # of the module's pins: low up to, high from, at most
LINE_V = 15.0  # of RS-232, either way
LOGIC_V = 5.5  # an input of the module takes


@dataclass(frozen=True)
class Terminal:
    """A pin of a part: its number, its kind, and the figures that parts.toml explains."""

    number: str
    what: str
    figures: tuple[float, ...] = ()

    @property
    def most_v(self) -> float:
        """The maximum voltage at this pin; infinite for an output or a ground."""
        if self.what in ("in", "io", "open", "passive"):
            return self.figures[0]
        return self.figures[1] if self.what == "supply" else float("inf")


@dataclass(frozen=True)
class Board:
    """The parts, each with its pins, and the nets, each with the names of pins."""

    kinds: dict[str, str]
    pins: dict[str, Terminal]
    nets: dict[str, tuple[str, ...]]
    supplies: dict[str, float]
    values: dict[str, float]
    texts: dict[str, dict[str, str]]

    def net_of(self, pin: str) -> str:
        """Return the net of a pin; "" for none."""
        return next((name for name, pins in self.nets.items() if pin in pins), "")


def terminals(name: str, text: str) -> Iterator[tuple[str, Terminal]]:
    """Yield the pins of an entry: one, or one for each number of its range."""
    number, _, rest = text.partition(", ")
    what, *figures = rest.split()
    if ".." not in number:
        yield name, Terminal(number, what, tuple(map(float, figures)))
        return
    first, last = map(int, number.split(".."))
    step = 1 if last >= first else -1
    for count, at in enumerate(range(first, last + step, step), 1):
        yield f"{name}{count}", Terminal(str(at), what, tuple(map(float, figures)))


def read(folder: Path = FOLDER) -> Board:
    """Return the board described by two files."""
    parts = tomllib.loads((folder / "parts.toml").read_text("utf-8"))
    nets = tomllib.loads((folder / "nets.toml").read_text("utf-8"))["net"]
    kinds = dict(parts["part"]) | dict.fromkeys(parts["resistor"], "resistor")
    kinds |= dict.fromkeys(parts["capacitor"], "capacitor")
    pins: dict[str, Terminal] = {}
    for name, kind in kinds.items():
        about = parts["kind"][kind]
        for pin, text in about["pins"].items():
            pins |= {f"{name}.{each}": terminal for each, terminal in terminals(pin, text)}
        for pin, number in about.get("gpio", {}).get("number", {}).items():
            pins |= {
                f"{name}.{each}": terminal for each, terminal in terminals(pin, f"{number}, {about['gpio']['each']}")
            }
    return Board(
        kinds,
        pins,
        {name: tuple(net["pins"]) for name, net in nets.items()},
        {name: float(net["supply"]) for name, net in nets.items() if "supply" in net},
        {**parts["resistor"], **parts["capacitor"]},
        {kind: {"what": about["what"], "price": about["price"]} for kind, about in parts["kind"].items()},
    )


# ----------------------------------------------------------------------------------------------------------- the rules
def module_pins(board: Board) -> Iterator[str]:
    """Yield violations: each pin of the sheet needs a net of its own name or of a supply, unless unconnected."""
    wired = Counter(pin for pins in board.nets.values() for pin in pins)
    for pin in GS_C200S.pins:
        count = wired[f"{MODULE}.{pin.name}"]
        if count != (0 if pin.in_out == "none" else 1):
            yield f"pin {pin.number} ({pin.name}) of the module is in {count} nets"
    names = {f"{MODULE}.{pin.name}" for pin in GS_C200S.pins}
    yield from (
        f"{pin}: the module has no such pin" for pin in wired if pin.startswith(f"{MODULE}.") and pin not in names
    )


def every_pin(board: Board) -> Iterator[str]:
    """Yield violations: each pin of each part is in one net; unused outputs of buffers are in none."""
    wired = Counter(pin for pins in board.nets.values() for pin in pins)
    yield from (f"{pin} is in {count} nets" for pin, count in wired.items() if count > 1)
    yield from (f"{pin}: no part has it" for pin in wired if not pin.startswith(f"{MODULE}.") and pin not in board.pins)
    for pin, terminal in board.pins.items():
        if not wired[pin] and terminal.what not in ("out", "source"):
            yield f"{pin} is in no net"
    yield from (f"net {name} has one pin" for name, pins in board.nets.items() if len(pins) < 2)


def is_resistor(board: Board, pin: str) -> bool:
    """Return whether a pin belongs to a resistor."""
    return board.kinds.get(pin.partition(".")[0]) == "resistor"


def pulls(board: Board, net: str) -> list[tuple[float, float]]:
    """Return the resistors from a net to a supply: its voltage, and ohms."""
    found = []
    for pin in board.nets[net]:
        part, _, end = pin.partition(".")
        if is_resistor(board, pin):
            other = board.net_of(f"{part}.{'2' if end == '1' else '1'}")
            found += [(board.supplies[other], board.values[part])] if other in board.supplies else []
    return found


def reached_v(board: Board, net: str) -> float:
    """Return the highest voltage of a net without its own supply, from its drivers."""
    if net in board.supplies:
        return board.supplies[net]
    found = [LINE_V] if net in ("rxd", "txd") else []
    for pin in board.nets[net]:
        terminal = board.pins.get(pin)
        part = pin.partition(".")[0]
        if pin.startswith(f"{MODULE}.") and net not in ("rxd", "txd", "txpd"):
            found.append(LOGIC_V)
        elif terminal and terminal.what in ("out", "io"):
            rails = [board.net_of(f"{part}.{name}") for name in ("VCC", "3V3") if f"{part}.{name}" in board.pins]
            found += [board.supplies.get(rail, 0.0) for rail in rails]
    found += [rail for rail, _ in pulls(board, net)]
    return max(map(abs, found), default=0.0)


def voltages(board: Board) -> Iterator[str]:
    """Yield pins whose voltage may exceed their rating: above all, 5 V at a Pico."""
    for net, pins in board.nets.items():
        volts = reached_v(board, net)
        for pin in pins:
            terminal = board.pins.get(pin)
            if terminal is None:
                continue
            if abs(volts) > terminal.most_v:
                yield f"net {net} has up to {volts:g} V, and {pin} takes {terminal.most_v:g}"
            if terminal.what == "supply" and abs(volts) < terminal.figures[0]:
                yield f"net {net} has {volts:g} V, and {pin} needs {terminal.figures[0]:g}"
            if terminal.what == "source" and board.supplies.get(net) != terminal.figures[0]:
                yield f"{pin} gives {terminal.figures[0]:g} V, and net {net} is for {board.supplies.get(net)}"
            if terminal.what == "ground" and board.supplies.get(net) != 0:
                yield f"{pin} is a ground, and net {net} is none"


def driven(board: Board, net: str) -> list[str]:
    """Return the pins that drive a net in both directions; of two GPIOs one is an input, as in pins.h."""
    return [pin for pin in board.nets[net] if board.pins.get(pin, Terminal("", "")).what == "out"]


def levels(board: Board) -> Iterator[str]:
    """Yield violations: a net has one output, or one source, with levels that each input accepts."""
    for net, pins in board.nets.items():
        outputs, sources = (
            driven(board, net),
            [pin for pin in pins if board.pins.get(pin, Terminal("", "")).what == "source"],
        )
        if len(outputs) > 1 or len(sources) > 1 or (outputs and sources):
            yield f"net {net} is driven by {', '.join(outputs + sources)}"
        ends = [(pin, board.pins[pin]) for pin in pins if pin in board.pins]
        gives = [(terminal.figures[-3], terminal.figures[-2]) for _, terminal in ends if terminal.what in ("out", "io")]
        takes = [(pin, terminal.figures[1:3]) for pin, terminal in ends if terminal.what in ("in", "io")]
        if any(pin.startswith(f"{MODULE}.") for pin in pins) and outputs:
            takes.append((f"the module's {net}", LEVELS_V[:2]))
        for low, high in gives:
            for pin, (below, above) in takes:
                if low > below or high < above:
                    yield f"net {net}: {pin} needs {below:g} and {above:g} V, and gets {low:g} and {high:g}"


def currents(board: Board) -> Iterator[str]:
    """Yield overloads: of a source by all loads on its net, of a transistor or a Pico by resistors."""
    for net, pins in board.nets.items():
        for pin in pins:
            terminal = board.pins.get(pin)
            if terminal is None or terminal.what != "source":
                continue
            taken = sum(
                board.pins[each].figures[2] for each in pins if each in board.pins and board.pins[each].what == "supply"
            )
            taken += sum(LOADS_MA.get(each.partition(".")[2], 0) for each in pins if each.startswith(f"{MODULE}."))
            ohms = [board.values[each.partition(".")[0]] for each in pins if is_resistor(board, each)]
            taken += sum(2000 * abs(board.supplies[net]) / each for each in ohms)  # at most, to the other supply
            if taken > terminal.figures[1]:
                yield f"net {net}: {pin} gives {terminal.figures[1]:g} mA, and {taken:.0f} are taken"
    total = 0.0
    for net, pins in board.nets.items():
        for pin in pins:
            terminal = board.pins.get(pin)
            if terminal is None or terminal.what not in ("open", "io"):
                continue
            brought = sum(1000 * rail / ohms for rail, ohms in pulls(board, net))
            if "U8.CATHODE" in pins:
                brought += 2100 / board.values["R8"]  # 3.3 V less the light-emitting diode
            total += brought if pin.startswith("U1.") else 0
            if brought > terminal.figures[-1]:
                yield f"net {net}: {pin} sinks {terminal.figures[-1]:g} mA, and {brought:.1f} are brought"
    if total > MOST_PICO_MA:
        yield f"the Pico has {total:.0f} mA at its pins, and takes {MOST_PICO_MA} in all"


RULES = (module_pins, every_pin, voltages, levels, currents)


def broken(board: Board) -> list[str]:
    """Return the violations of the rules."""
    return [found for rule in RULES for found in rule(board)]


# ----------------------------------------------------------------------------------------------------- list of parts
def value(board: Board, name: str) -> str:
    """Return the type of a part, with its value."""
    kind = board.kinds[name]
    if kind == "resistor":
        ohms = board.values[name]
        return f"resistor {ohms / 1000:g} kilohm" if ohms >= 1000 else f"resistor {ohms:g} ohm"
    return f"capacitor {board.values[name]:g} uF" if kind == "capacitor" else board.texts[kind]["what"]


def bill(board: Board) -> list[tuple[str, str, str]]:
    """Return the bill of materials, equal parts in one row: number, type, and designators."""
    found: dict[str, list[str]] = {}
    for name in board.kinds:
        found.setdefault(value(board, name), []).append(name)
    return [(str(len(names)), what, " ".join(names)) for what, names in found.items()]


def main() -> int:
    """Print the bill of materials, and the violations of the rules; return the exit status."""
    board = read()
    for count, what, names in bill(board):
        print(f"{count:>3}  {what:<80} {names}")
    wrong = broken(board)
    print(*wrong, sep="\n", file=sys.stderr)
    return bool(wrong)


if __name__ == "__main__":
    sys.exit(main())

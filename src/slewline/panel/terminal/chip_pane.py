"""The pane of a chip: its motor positions, its registers, and the levels of its pins, under the manual's names."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from textual.content import Content

from ...core.time.timebase import PS_PER_S
from .panes import OfChip
from .session import CURVE_PS
from .text_drawing import LEVELS, Part, figure, line, pair, strip

SHOWN = (  # roles of the pins shown, in this order
    *("ready", "running", "moving", "slewing", "ramping", "motion_complete", "program_entry", "direction", "step"),
    *("output1", "output2", "output3", "input1", "input2", "input3", "interrupt", "enable", "abort"),
    *("end", "end_plus", "end_minus", "home", "jog", "flow", "display_select", "text", "select", "reset"),
)
STRIP_ROWS = {False: 2, True: 5}  # height of the velocity strip, on a wide and a narrow screen
NAME = 13  # columns of the names next to a table of axes
EXPLAINED = 26  # columns of a name and its value, next to the text of the manual
DIM = "dim"


class ChipPane(OfChip):
    """The registers, status and pins of a chip; a chip with several axes has a column for each."""

    top = 0

    def move(self, rows: int) -> None:
        """Scroll by a number of rows."""
        self.top = max(self.top + rows, 0)

    @property
    def state(self) -> dict[str, Any]:
        """State of the chip."""
        return self.session.chip_state(self.chip)

    @property
    def sheet(self) -> dict[str, Any]:
        """Data sheet of the chip."""
        return self.session.sheets[self.chip]

    def lines(self, width: int, height: int) -> list[Content]:
        found = self.of_axes(width) if self.axes > 1 else self.of_chip(width)
        if self.app.has_class("wide"):
            found += self.parts(width)
        self.top = max(min(self.top, len(found) - height), 0)
        return found[self.top : self.top + height]

    # ------------------------------------------------------------------------------------------------------- one axis
    def of_chip(self, width: int) -> list[Content]:
        """Return all rows for a chip with one motor."""
        axis = self.state["axes"][0]
        rows = [line(width, *self.motion(axis, width))]
        rows += [line(width, (row, "$text-primary")) for row in self.curve(0, width)]
        rows += self.work(width)
        if self.app.has_class("wide") and not self.app.has_class("two"):
            return [*rows, *self.explained(axis, width)]
        left = self.registers(axis) + self.levels([pin for pin in self.shown() if pin["way"] == "in"])
        right = self.levels([pin for pin in self.shown() if pin["way"] != "in"])
        half = (width - 3) // 2
        for at in range(max(len(left), len(right))):
            one = pair(half, *left[at]) if at < len(left) else [(" " * half, "")]
            two = pair(width - 3 - half, *right[at]) if at < len(right) else []
            rows.append(line(width, *one, (" │ ", DIM), *two))
        return rows

    def explained(self, axis: dict[str, Any], width: int) -> list[Content]:
        """Return a row for each register and each pin shown, with its description from the manual, under headings."""
        rows = [line(width), line(width, ("registers", "bold $text-primary"))]
        sheet = self.sheet
        for (name, value, _, style), row in zip(self.registers(axis), sheet["registers"], strict=True):
            note = ", ".join(each for each in (row["unit"], row["says"]) if each)
            rows.append(line(width, *pair(EXPLAINED, name, value, "", style), (f"  {note}", DIM)))
        for title, outputs in (("outputs", True), ("inputs", False)):
            rows += [line(width), line(width, (title, "bold $text-primary"))]
            pins = [pin for pin in self.shown() if (pin["way"] != "in") == outputs]
            for pin, (name, value, _, style) in zip(pins, self.levels(pins), strict=True):
                rows.append(line(width, *pair(EXPLAINED, name, value, "", style), (f"  {pin['says']}", DIM)))
        return rows

    def motion(self, axis: dict[str, Any], width: int) -> list[Part]:
        """Return the parts of a row: position, velocity, and whether the motor moves or the supply is off."""
        value = f"{figure(axis['velocity'])} steps/s"
        position = f"position {axis['position']}"
        note = "moving" if axis["moving"] else "at rest"
        note = note if self.state.get("powered", True) else "supply off"
        style = "bold $text-success" if axis["moving"] else "bold"
        gap = max(width - len(position) - len(value) - len(note), 2)
        return [(position, style), (" " * (gap // 2), ""), (value, style), (" " * (gap - gap // 2), ""), (note, style)]

    @property
    def scale(self) -> str:
        """Text with the time span of the velocity strips and, if there is only one strip, its highest velocity."""
        tops = [peak(self.session.curves.get(name, [])) for name in self.session.velocities(self.chip)]
        up_to = f", up to {figure(tops[0])} steps/s" if len(tops) == 1 and tops[0] else ""
        return f"last {CURVE_PS // PS_PER_S} s{up_to}"

    def curve(self, axis: int, width: int, height: int | None = None) -> list[str]:
        """Return the velocity strip of an axis (0: the first) as rows of text.

        If `height` is None, the layout determines the number of rows.
        """
        names = self.session.velocities(self.chip)
        values = self.session.curves.get(names[axis], []) if axis < len(names) else []
        return strip(values, width, height or STRIP_ROWS[self.app.has_class("wide")], peak(values))

    def work(self, width: int) -> list[Content]:
        """Return rows: the chip's command, the condition it waits for, breakpoints that are not on instructions."""
        waiting = self.state.get("waiting") or ""
        current = self.session.row_at(self.chip)
        instruction = "" if current is None else self.session.listings[self.chip][current]["text"]
        working = self.state.get("working") or instruction
        waiting = waiting.removeprefix(f"{self.chip}: ").removeprefix(f"{working} ")
        stops = [points_out(point) for point in self.session.breakpoints if "address" not in point]
        others = [line(width, ("● ", "bold $text-error"), ", ".join(stops))] if stops else []
        if not self.app.has_class("wide"):
            around = [line(width, "  ".join(self.around()))] if self.around() else []
            return [line(width, (working, "bold"), ": " * bool(working), waiting), *others, *around]
        return [line(width, ("command  ", DIM), (working, "bold")), line(width, ("state    ", DIM), waiting), *others]

    def registers(self, axis: dict[str, Any]) -> list[tuple[str, str, str, str]]:
        """Return the name and the value of each register, then the style of the name and that of the value."""
        values = {**self.state["registers"], **axis.get("registers", {})}
        found = []
        for row in self.sheet["registers"]:
            letter = row["letter"] if len(row["letter"] or "") == 1 else ""
            found.append((f"{letter or ' '} {row['name']}", str(values.get(row["name"], "")), "", "bold"))
        return found

    def shown(self) -> list[dict[str, Any]]:
        """Return the pins to show: those with important roles, in the order of `SHOWN`, then the user bits."""
        pins = [pin for pin in self.sheet["pins"] if pin["role"] in SHOWN or (pin["way"] == "both" and not pin["role"])]
        return sorted(pins, key=lambda pin: SHOWN.index(pin["role"]) if pin["role"] in SHOWN else len(SHOWN))

    def levels(self, pins: list[dict[str, Any]]) -> list[tuple[str, str, str, str]]:
        """Return the name and the level of each of these pins, then the style of the name and that of the level."""
        found = []
        for pin in pins:
            level = self.state["levels"].get(pin["name"])
            found.append((spoken(pin["name"]), LEVELS.get(level, "?"), "", active_style(pin, level)))
        return found

    def parts(self, width: int) -> list[Content]:
        """Return rows with the state of the displays, switches, shafts and other parts around the chips."""
        rows = [line(width, row) for row in self.around()]
        return [line(width), line(width, ("around the chips", "bold $text-primary")), *rows] if rows else []

    def around(self) -> list[str]:
        """Return one line of text for each part that has a state to show: its name and its state."""
        shown = {name: part.get("shows") or {} for name, part in self.session.client.view.get("parts", {}).items()}
        return [
            f"{name} {', '.join(shown_value(key, value) for key, value in shows.items())}"
            for name, shows in shown.items()
            if shows
        ]

    # ----------------------------------------------------------------------------------------------------- several axes
    def of_axes(self, width: int) -> list[Content]:
        """Return all rows for a chip with several motors: a table with a column for each motor."""
        axes = self.state["axes"]
        room = max((width - NAME) // len(axes), 4)

        def row(name: str, cells: list[Part]) -> Content:
            parts: list[Part] = [(f"{name[: NAME - 1]:<{NAME}}", DIM)]
            parts += [(f"{text[: room - 1]:>{room}}", style) for text, style in cells]
            return line(width, *parts)

        def style(axis: dict[str, Any]) -> str:
            return "bold $text-success" if axis["moving"] else "bold"

        rows = [row("", [(f"axis {number}", "bold $text-primary") for number in range(1, len(axes) + 1)])]
        rows.append(row("position", [(str(axis["position"]), style(axis)) for axis in axes]))
        rows.append(row("steps/s", [(figure(axis["velocity"]), style(axis)) for axis in axes]))
        curves = [self.curve(at, room - 2) for at in range(len(axes))]
        for drawn in zip(*curves, strict=True):
            rows.append(line(width, " " * NAME, *((f"  {cell}", "$text-primary") for cell in drawn)))
        rows += self.work(width)
        for role in dict.fromkeys(pin["role"] for pin in self.shown() if self.many(pin)):
            pins = {pin["axis"]: pin for pin in self.shown() if pin["role"] == role}
            cells = [self.levels([pins[at]])[0] if at in pins else ("", "", "", "") for at in range(1, len(axes) + 1)]
            rows.append(row(spoken(pins[1]["name"].rstrip("1")), [(cell[1], cell[3]) for cell in cells]))
        for register in self.sheet["registers"]:
            name = register["name"]
            rows.append(row(name, [(str(axis.get("registers", {}).get(name, "")), "") for axis in axes]))
        whole = [pin for pin in self.shown() if not self.many(pin)]
        for pin, (name, level, _, how) in zip(whole, self.levels(whole), strict=True):
            del pin
            rows.append(line(width, (f"{name[: NAME - 1]:<{NAME}}", DIM), (level.rjust(room), how)))
        return rows

    def many(self, pin: dict[str, Any]) -> bool:
        """Return whether a pin with the same role as this pin is also shown on an axis other than the first."""
        return bool(pin["role"]) and any(other["role"] == pin["role"] and other["axis"] > 1 for other in self.shown())


def peak(values: Sequence[float | None]) -> float:
    """Return the greatest magnitude of these velocities; 0 if there are none."""
    return max((abs(value) for value in values if value is not None), default=0.0)


def spoken(name: str) -> str:
    """Return a pin name as the manuals write it: in capitals, with spaces instead of underscores."""
    return name.upper().replace("_", " ")


def active_style(pin: dict[str, Any], level: int | None) -> str:
    """Return the style for the level of a pin: highlighted if this is the pin's active level, otherwise dim."""
    return "bold $text-success" if level is not None and level == pin.get("active") else DIM


def shown_value(key: str, value: Any) -> str:
    """Return a value of a part's state as text: `key` and the value or, for a display text, its rows."""
    if key == "text" and isinstance(value, list):
        return "│".join(["", *map(str, value), ""])
    return f"{key} {value:.6g}" if isinstance(value, float) else f"{key} {value}"


def points_out(point: dict[str, Any]) -> str:
    """Return a description of a breakpoint that is not on an instruction."""
    if "pin" in point:
        return f"{point['pin']} {'changes' if point['edge'] == 'any' else point['edge']}"
    if "finding" in point:
        return f"finding {point['finding']}".strip()
    axis = f" axis {point['axis']}" if point.get("axis", 1) > 1 else ""
    if "position" in point:
        return f"{point['chip']}{axis} at {point['position']}"
    value = f" = {point['value']}" if "value" in point else " changes"
    return f"{point['chip']}.{point['register']}{value}"

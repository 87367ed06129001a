"""Layouts: files next to a waveform that make a viewer show a group per chip, and quantities as curves.

    weld.vcd       the waveform
    weld.gtkw      for GTKWave: gtkwave weld.gtkw
    weld.sucl      for Surfer: surfer --command-file weld.sucl weld.vcd

For Surfer, the layout is a command file that contains documented commands, because a state file suits
only one version of Surfer.  A version that does not support a command reports this and continues.  File
names are relative, so that the folder can be moved.  The same run produces the same bytes.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from itertools import groupby
from math import log2
from operator import itemgetter
from pathlib import Path
from typing import NamedTuple

from ...core.messages.plain import ascii_of
from ...errors import UsageError
from ..whole_file import WholeFile
from .vcd_sources import Variable

# Trace flags of GTKWave: one bit each.
HEX, RIGHT, BLANK, SIGNED, ASCII, STEP, STRETCH, GROUP, END = 2, 32, 512, 1024, 2048, 1 << 15, 1 << 17, 1 << 23, 1 << 24
CURVE_ROWS = 3  # extra rows of a curve, compared with a pin
# GTKWave's window, and a little more than the width of its waves: a view that would go beyond the end of the file
# makes it begin at 0.
SIZE, WAVES_PX = "1400 900", 1150
FRAME_PX = 200  # at zoom z these show 2^-z units
LETTERS = "ABCDEFGHIJKLMNOPQRSTUVWXYZ"  # of GTKWave's named markers
DIGITS = "abcdefghijklmnop"  # in which Surfer counts the rows


class ViewerSetup(NamedTuple):
    """The initial view in a viewer: the window from `begin` to `end`, and the marks in it.

    `begin` and `end` are in time units of the file.  Each mark is a pair: its time, in the same units, and
    its text.  `scale` is the number in the timescale (1, 10 or 100), such as 10 in "10 us".  GTKWave needs
    times multiplied by `scale`, because GTKWave counts in ns or us.
    """

    begin: int
    end: int
    marks: Sequence[tuple[int, str]] = ()
    scale: int = 1


def layout_paths(path: str | Path) -> tuple[Path, Path]:
    """Return the paths of a waveform's layout files: GTKWave's, then Surfer's.

    Raises:
        UsageError: the waveform file has the name of one of these layout files.
    """
    paths = Path(path).with_suffix(".gtkw"), Path(path).with_suffix(".sucl")
    if Path(path) in paths:
        raise UsageError(f"{path}: its layout file would have the same name; end the name in .vcd")
    return paths


def save_layouts(path: str | Path, variables: Sequence[Variable], view: ViewerSetup) -> None:
    """Write the layout files of a waveform file into the same folder.

    Raises:
        UsageError: a file cannot be written.
    """
    gtkwave, surfer = layout_paths(path)
    lines_of = (
        (gtkwave, gtkwave_lines(Path(path).name, gtkwave.name, variables, view)),
        (surfer, surfer_lines(variables, view)),
    )
    for layout, lines in lines_of:
        with WholeFile(layout, own=True) as file:
            file.write("".join(f"{line}\n" for line in lines).encode())


# --------------------------------------------------------------------------------------------------------- GTKWave
def gtkwave_lines(dump: str, name: str, variables: Sequence[Variable], view: ViewerSetup) -> Iterator[str]:
    """Yield the lines of GTKWave's save file.

    Args:
        dump: the file name of the waveform.
        name: the file name of the save file itself; GTKWave needs both names to find the waveform.
    """
    span = max(view.end - view.begin, 1) * view.scale
    marks = [(at, ascii_of(text)) for at, text in view.marks][: len(LETTERS)]
    instants = [str(at * view.scale) for at, _ in marks] + ["-1"] * (len(LETTERS) - len(marks))
    yield from ("[*] slewline", f'[dumpfile] "{dump}"', f'[savefile] "{name}"', f"[size] {SIZE}")
    yield f"[timestart] {view.begin * view.scale}"
    yield f"*{-log2(span * FRAME_PX / WAVES_PX):.6f} -1 {' '.join(instants)}"
    yield from (f"[markername] {letter}{text}" for letter, (_, text) in zip(LETTERS, marks, strict=False))
    yield from ("[sst_expanded] 0", "[signals_width] 200")
    groups = list(grouped(variables))
    one_chip = len({scope.split(".")[0] for scope, _ in groups}) == 1
    for scope, rows in groups:
        yield from (f"@{GROUP | BLANK:x}", f"-{scope}")
        for row in rows:
            yield from _gtkwave_row(row, _whose(scope, one_chip))
        yield from (f"@{END | BLANK:x}", f"-{scope}")


def _whose(scope: str, one_chip: bool) -> str:
    """Return a prefix for the names in a group, such as "axis2", "x" or "x axis2"; "" if none is needed.

    The prefix distinguishes these names from the same names in other groups.
    """
    return (scope.partition(".")[2] if one_chip else scope).replace(".", " ")


def _gtkwave_row(row: ViewerRow, whose: str) -> Iterator[str]:
    """Yield the lines of the save file for one row.

    GTKWave labels the row with the text in +{}.  Without such a text, it uses the last part of the name.
    """
    first = row.variables[0]
    alias = f"+{{{whose} {row.name.rpartition('.')[2]}}} " if whose else ""
    if first.kind == "real":
        yield from (f"@{STEP | SIGNED | RIGHT:x}", f"{alias}{row.name}", f"@{STRETCH | BLANK:x}", *["-"] * CURVE_ROWS)
    elif first.kind == "string":
        yield from (f"@{ASCII | RIGHT:x}", f"{alias}{row.name}")
    elif len(row.variables) > 1:
        wires = " ".join(variable.name for variable in reversed(row.variables))
        yield from (f"@{HEX | RIGHT:x}", f"{alias}#{{{row.name}[{len(row.variables) - 1}:0]}} {wires}")
    else:
        bits = f"[{first.size - 1}:0]" if first.size > 1 else ""  # GTKWave adds a range to every vector
        yield from (f"@{HEX | RIGHT:x}", f"{alias}{row.name}{bits}")


# ---------------------------------------------------------------------------------------------------------- Surfer
def surfer_lines(variables: Sequence[Variable], view: ViewerSetup) -> Iterator[str]:
    """Yield the lines of Surfer's command file."""
    number, curves = 0, []
    yield "# slewline"
    for scope, rows in grouped(variables):
        yield f"divider_add {scope}"
        number += 1
        for row in rows:
            for variable in reversed(row.variables):
                if variable.kind == "real":
                    curves.append((number, variable.name))
                yield f"variable_add {variable.name}"
                number += 1
    for number, name in curves:
        yield from (f"item_focus {_letters(number)}_{name}", "item_set_analog step", "item_set_height 4")
    yield from ("item_unfocus", "zoom_fit", f"zoom_to {view.begin} {view.end}")


def _letters(number: int) -> str:
    return "".join(DIGITS[int(digit, 16)] for digit in f"{number:x}")


# ------------------------------------------------------------------------------------------------------------ rows
class ViewerRow(NamedTuple):
    """A row in a viewer: a variable, or the wires of a bus."""

    name: str
    variables: list[Variable]


def grouped(variables: Sequence[Variable]) -> Iterator[tuple[str, list[ViewerRow]]]:
    """Yield the name and the rows of each group (an axis or a chip): first texts, then curves, then pins.

    The wires of a bus are left out if the bus is also included as a whole.
    """
    named = {variable.name for variable in variables}
    shown = [variable for variable in variables if not (variable.bus and variable.bus in named)]
    ranks = {"string": 0, "real": 1, "wire": 2}
    chips = list(dict.fromkeys(_scope(variable).split(".")[0] for variable in shown))
    scopes = dict.fromkeys(_scope(variable) for variable in shown)
    for scope in sorted(scopes, key=lambda scope: (chips.index(scope.split(".")[0]), "." not in scope)):
        inside = sorted((v for v in shown if _scope(v) == scope), key=lambda variable: ranks[variable.kind])
        yield scope, list(_rows(inside))


def _scope(variable: Variable) -> str:
    return variable.name.rpartition(".")[0] or "slewline"


def _rows(variables: Iterable[Variable]) -> Iterator[ViewerRow]:
    keyed = ((variable.bus or variable.name, variable) for variable in variables)
    for name, of in groupby(keyed, itemgetter(0)):
        yield ViewerRow(name, [variable for _, variable in of])

"""Layouts beside a waveform: every name in them is in the file, curves are curves, a bus is one row."""

from __future__ import annotations

import io

import pytest
from vcd.gtkw import GTKWFlag, GTKWSave

from slewline.errors import UsageError
from slewline.record.waveforms.vcd_sources import Variable
from slewline.record.waveforms.viewer_layouts import (
    ViewerSetup,
    gtkwave_lines,
    layout_paths,
    save_layouts,
    surfer_lines,
)

WIRES = [Variable(f"x.db{bit}", bus="x.db") for bit in range(8)]
VARIABLES = [
    Variable("x.slew"),
    *WIRES,
    Variable("y.wait"),
    Variable("x.finding", "string"),
    Variable("x.axis1.velocity", "real", 64),
]
VIEW = ViewerSetup(100, 100 + 1150, [(150, "P 300"), (200, "late µs")])


def by_pyvcd() -> str:
    """The same layout through pyvcd's writer."""
    file = io.StringIO()
    save = GTKWSave(file)
    save.comment("slewline")
    save.dumpfile("weld.vcd", abspath=False)
    save.savefile("weld.gtkw", abspath=False)
    save.size(1400, 900)
    save.timestart(100)
    save.zoom_markers(-7.643856, -1, a=150, b=200)  # 200 units in 200 pixels: 2 to the 7.643856
    print("[markername] AP 300\n[markername] Blate us", file=file)
    save.sst_expanded(False)
    save.signals_width(200)
    with save.group("x.axis1"):
        analog = GTKWFlag.analog_step
        save.trace("x.axis1.velocity", alias="x axis1 velocity", datafmt="signed", extraflags=analog)
        for _ in range(3):
            save.blank(analog_extend=True)
    with save.group("x"):
        save.trace("x.finding", alias="x finding", datafmt="ascii")
        save.trace("x.slew", alias="x slew")
        save.trace("+{x db} #{x.db[7:0]} x.db7 x.db6 x.db5 x.db4 x.db3 x.db2 x.db1 x.db0")
    with save.group("y"):
        save.trace("y.wait", alias="y wait")
    return file.getvalue()


def rows(text: str) -> list[tuple[str, str]]:
    """Lines that say something, each with the flags that are in force."""
    flags, found = "", []
    for line in text.splitlines():
        if line.startswith("@"):
            flags = line
        else:
            found.append((flags, line))
    return found


def test_a_layout_for_gtkwave_is_the_one_that_pyvcd_writes():
    ours = "\n".join(gtkwave_lines("weld.vcd", "weld.gtkw", VARIABLES, VIEW))
    assert rows(ours) == rows(by_pyvcd())


def test_no_two_rows_of_gtkwave_read_alike():
    """It shows the last part of a name only: an axis stands before it, and of several chips the chip."""
    curves = [Variable(f"m.axis{axis}.velocity", "real", 64) for axis in (1, 2)]
    one = list(gtkwave_lines("a.vcd", "a.gtkw", [Variable("m.pulse1"), *curves], VIEW))
    assert [line for line in one if line.endswith(("velocity", "pulse1"))] == [
        "+{axis1 velocity} m.axis1.velocity",
        "+{axis2 velocity} m.axis2.velocity",
        "m.pulse1",
    ]
    two = list(gtkwave_lines("a.vcd", "a.gtkw", [Variable("m.pulse1"), Variable("n.pulse1")], VIEW))
    assert [line for line in two if line.endswith("pulse1")] == ["+{m pulse1} m.pulse1", "+{n pulse1} n.pulse1"]


def test_a_layout_for_surfer_line_by_line():
    wires = "\n".join(f"variable_add x.db{bit}" for bit in reversed(range(8)))
    assert (
        "\n".join(surfer_lines(VARIABLES, VIEW))
        == f"""\
# slewline
divider_add x.axis1
variable_add x.axis1.velocity
divider_add x
variable_add x.finding
variable_add x.slew
{wires}
divider_add y
variable_add y.wait
item_focus b_x.axis1.velocity
item_set_analog step
item_set_height 4
item_unfocus
zoom_fit
zoom_to 100 1250"""
    )


def test_rows_beyond_the_sixteenth_are_counted_in_two_letters():
    many = [*(Variable(f"c{n}.clock") for n in range(9)), Variable("y.v", "real", 64)]
    assert "item_focus bd_y.v" in list(surfer_lines(many, VIEW)), "row 19: 1 and 3 of sixteen letters"


def test_gtkwave_counts_in_the_name_of_the_unit():
    """A file in units of 100 ns has times in ns there; Surfer counts in units."""
    view = ViewerSetup(100, 200, [(150, "P")], 100)
    lines = list(gtkwave_lines("a.vcd", "a.gtkw", VARIABLES, view))
    (zoom,) = (line for line in lines if line.startswith("*"))
    assert "[timestart] 10000" in lines
    assert zoom.split()[:3] == ["*-10.764150", "-1", "15000"]
    assert "zoom_to 100 200" in list(surfer_lines(VARIABLES, view))


def test_a_bus_that_is_there_as_a_whole_is_shown_so_and_alone():
    both = [Variable("x.db", size=8), *WIRES]
    lines = list(gtkwave_lines("a.vcd", "a.gtkw", both, VIEW))
    assert [line for line in lines if "db" in line] == ["x.db[7:0]"]
    assert [line for line in surfer_lines(both, VIEW) if "db" in line] == ["variable_add x.db"]


def test_marks_stop_at_the_last_letter():
    view = ViewerSetup(0, 100, [(n, f"m{n}") for n in range(40)])
    lines = list(gtkwave_lines("a.vcd", "a.gtkw", VARIABLES, view))
    assert [line for line in lines if line.startswith("[markername]")][-1] == "[markername] Zm25"
    (zoom,) = (line for line in lines if line.startswith("*"))
    assert zoom.split()[1:] == ["-1", *map(str, range(26))]


def test_they_are_next_to_the_file_and_name_it_without_its_folder(tmp_path):
    folder = tmp_path / "here"
    folder.mkdir()
    save_layouts(folder / "my.weld.vcd", VARIABLES, VIEW)
    assert sorted(path.name for path in folder.iterdir()) == ["my.weld.gtkw", "my.weld.sucl"]
    assert '[dumpfile] "my.weld.vcd"\n[savefile] "my.weld.gtkw"\n' in (folder / "my.weld.gtkw").read_text()
    assert not any(str(tmp_path) in path.read_text() for path in folder.iterdir())
    with pytest.raises(UsageError, match=r"its layout file would have the same name; end the name in \.vcd"):
        layout_paths(folder / "my.gtkw")


def test_a_window_without_time_is_shown(tmp_path):
    save_layouts(tmp_path / "a.vcd", VARIABLES, ViewerSetup(7, 7))
    assert "zoom_to 7 7" in (tmp_path / "a.sucl").read_text()

"""What a notebook shows: cards in which nothing of a stranger runs, the plot, short texts, and names for Tab."""

from __future__ import annotations

import re
from dataclasses import replace
from html.parser import HTMLParser
from itertools import pairwise
from xml.etree import ElementTree

import numpy as np
import pytest

import slewline
from slewline.chips import PARTS, chip_class
from slewline.core.datasheet.table import Pin
from slewline.core.messages.instead import Instead
from slewline.core.motion.axis import Steps
from slewline.core.notebook.markup import STYLE, element
from slewline.parts import KINDS, part_class
from tests.motors import with_motor
from tests.rows import rows
from tests.system.test_faces import GIVEN, everything

HOSTILE = "<script>alert(1)</script>\"'><img src=x onerror=alert(2)>"
TAGS = {"div", "style", "b", "table", "thead", "tbody", "tr", "th", "td", "pre"} | {
    *("svg", "g", "rect", "circle", "path", "text", "title")
}
ATTRIBUTES = {
    *("class", "role", "aria-label", "viewbox", "width", "height", "x", "y", "rx", "r", "cx", "cy", "d", "transform"),
    *("fill", "stroke", "stroke-width", "stroke-dasharray", "stroke-linejoin", "opacity", "text-anchor"),
    *("text-decoration", "font-size", "font-weight", "letter-spacing"),
}
THREE_STEPS = "A 0\rF 3\rR 3\rS 240\rN 3\rG\r"
FRAMES = re.compile(  # of a shaft that turns
    r"@keyframes (slewline-[0-9a-f]{8})\{(?:(?:[\d.]+%|to)\{transform:rotate\(-?[\d.]+deg\)\})+\}"
    r"@media \(prefers-reduced-motion: no-preference\)\{\.\1\{animation:\1 [\d.]+s linear infinite\}\}"
)


class Read(HTMLParser):
    """The elements and the text of a card; it fails at one that can do more than show something."""

    def __init__(self, markup):
        super().__init__()
        self.open, self.tags, self.cells, self.titles, self.text, self.attributes = [], [], [], [], "", []
        self.feed(markup)
        self.close()
        assert not self.open

    def handle_starttag(self, tag, attrs):
        assert tag in TAGS, tag
        assert {name for name, _ in attrs} <= ATTRIBUTES, attrs
        self.open.append(tag)
        self.tags.append(tag)
        self.attributes.append(dict(attrs))
        if tag in ("td", "th"):
            self.cells.append("")

    def handle_endtag(self, tag):
        assert self.open.pop() == tag

    def handle_data(self, data):
        if self.open[-1] == "style":
            assert data == STYLE or FRAMES.fullmatch(data), data
            return
        self.text += data
        if self.open[-1] == "title":
            self.titles.append(data)
        if self.open[-1] in ("td", "th", "pre"):
            self.cells[-1] += data


@pytest.fixture
def moved():
    """A bench on which a program has begun to move a motor."""
    bench = slewline.Bench()
    x = bench.add("cy525", name="x")
    bench.host(x).send("A 0\rF 10\rR 80\rS 240\rE\rN 100\rG\rN 20\rG\r0\rQ\rX\r")
    bench.run("40 ms")
    return bench, x


# ------------------------------------------------------------------------------------------------------------- a chip
def test_a_chip_shows_its_package_its_registers_and_the_instruction_that_it_is_at(moved):
    _, x = moved
    read = Read(x._repr_html_())
    assert f"CY525 x: position {x.position}, in motion, 40 ms" in read.text
    for pin in x.sheet.pins:
        level = {0: "low", 1: "high", None: "floating"}[x.pin(pin.name).level]
        (said,) = (title for title in read.titles if title.startswith(f"{pin.number} {pin.name}: "))
        assert (f", {level}. " in said) is (pin.in_out in ("in", "out", "both")), said
    registers = {read.cells[n]: read.cells[n + 1] for n, cell in enumerate(read.cells) if cell in x.registers}
    assert registers == {name: str(value) for name, value in x.registers.items()}
    at = read.cells.index("\u25b6")
    assert read.cells[at + 1 : at + 4] == ["0003", "47", "G"]
    assert [attrs["class"] for attrs in read.attributes if attrs.get("class") == "now"] == ["now"]


def test_a_level_is_drawn_at_its_present_value():
    bench = slewline.Bench()
    x = bench.add("cy525", name="x")
    before = x._repr_html_()
    x.pin("abort").drive(0)
    after = x._repr_html_()
    assert "6 abort: input, active low, high." in before
    assert "6 abort: input, active low, low." in after


def package_of(part):
    """The drawing of a part's package: its body, and each other thing with its place, pins by name."""
    svg = re.search("<svg.*?</svg>", slewline.Bench().add(part)._repr_html_(), re.DOTALL)[0]
    body, *others = ElementTree.fromstring(svg)
    return body, [(each, [float(n) for n in re.findall(r"[-.\d]+", each.get("transform", ""))]) for each in others]


@rows("part", ["cy525", "mc1451a"])
def test_the_name_of_a_part_is_printed_in_the_middle_of_its_package(part):
    body, others = package_of(part)
    x, y, wide, high = (float(body.get(name)) for name in ("x", "y", "width", "height"))
    (printed,) = (place for each, place in others if each.get("text-anchor") == "middle")
    assert printed[:2] == pytest.approx([x + wide / 2, y + high / 2])


@rows("part", ["cy525", "mc1451a"])
def test_names_of_pins_run_away_from_the_package_and_levels_are_in_the_middle_of_their_boxes(part):
    body, others = package_of(part)
    middle = float(body.get("x")) + float(body.get("width")) / 2
    beside = levels = 0
    for each, place in others:
        name = each.findall("text")[-1] if each.find("title") is not None else None
        if name is not None and not name.get("transform"):
            beside += 1
            assert name.get("text-anchor") == ("end" if place[0] < middle else "start")
            assert (float(name.get("x")) < 0) is (place[0] < middle)
        box = each.find("rect")
        if name is not None and box is not None:
            levels += 1
            x, y, wide, high = (float(box.get(key)) for key in ("x", "y", "width", "height"))
            text = each.find("text")
            assert float(text.get("x")) == x + wide / 2
            assert y < float(text.get("y")) < y + high
    assert beside > 20 and levels > 20


def test_of_a_long_program_a_few_instructions_around_the_counter_are_shown():
    bench = slewline.Bench()
    x = bench.add("cy525", name="x")
    bench.host(x).send("A 0\rF 10\rR 80\rS 240\rN 2\rE\r" + "G\r" * 50 + "0\rQ\rX\r")
    bench.run("100 ms")
    read = Read(x._repr_html_())
    rows = [cell for cell in read.cells if re.fullmatch("[0-9A-F]{4}", cell)]
    assert len(rows) == 20
    assert f"{x.program_counter:04X}" == rows[6]
    assert "31 more instructions" in read.text


@rows("part", PARTS)
def test_every_chip_has_a_card_with_all_its_axes(part):
    x = slewline.Bench().add(part)
    read = Read(x._repr_html_())
    assert read.text.count("\u25b6") == 0
    axes = [cell for cell in read.cells if cell.startswith("axis ")]
    assert axes == ([f"axis {n}" for n in range(1, len(x.axes) + 1)] if len(x.axes) > 1 else [])


def test_a_finding_is_shown_and_the_last_three_of_many():
    x = slewline.Bench().add("cy525", name="x")
    for n in range(5):
        x.motor_report("lost", f"number {n}")
    read = Read(x._repr_html_())
    assert "5 findings" in read.cells
    assert [re.search(r"number \d", cell)[0] for cell in read.cells if "number" in cell and "lost" in cell] == [
        *("number 2", "number 3", "number 4")
    ]


# ------------------------------------------------------------------------------------------------- steps, parts, shafts
def test_steps_are_a_table_of_the_first_and_the_last_and_a_thumbnail(moved):
    bench, x = moved
    bench.run_until_idle()
    steps = x.steps()
    read = Read(steps._repr_html_())
    assert read.cells[:4] == ["step", "time", "direction", "position"]
    assert [read.cells[n] for n in range(4, len(read.cells), 4)] == ["0", "1", "2", "\u22ee", "118", "119"]
    assert read.tags.count("svg") == 1
    line = next(attrs["d"] for attrs in read.attributes if attrs.get("stroke-width") == "2")
    assert (line.startswith("M0.0 90.0"), line.endswith("240.0V0.0"), line.count("H")) == (True, True, 119)


@rows("count", [0, 1, 2, 6, 7, 300])
def test_any_number_of_steps_is_shown(count):
    steps = Steps(np.arange(count) * 10**9, np.ones(count, np.int8), np.arange(count))
    read = Read(steps._repr_html_())
    assert ("\u22ee" in read.cells) is (count > 6)
    assert len(read.cells) == (0 if not count else 4 + 4 * min(count, 6))


def test_the_thumbnail_of_steps_has_the_same_margin_on_all_sides():
    steps = Steps(np.arange(3) * 10**9, np.ones(3, np.int8), np.arange(3))
    (svg,) = (attrs for attrs in Read(steps._repr_html_()).attributes if "viewbox" in attrs)
    assert svg["viewbox"] == "-4 -4 248 98"  # around 240 by 90
    assert (svg["width"], svg["height"]) == ("248", "98")


def test_a_shaft_turns_as_it_has_turned_and_stays_where_it_is_without_motion():
    bench = slewline.Bench()
    x = bench.add("cy525", name="x")
    motor = bench.part("translator", "motor", to=x)
    host = bench.host(x)
    assert "@keyframes" not in motor._repr_html_()
    host.send("A 0\rF 10\rR 80\rS 240\rN 250\rG\r")
    bench.run_until_idle()
    markup = motor._repr_html_()
    read = Read(markup)
    assert "1.25 turns in 0.078 s, 50 times slower" in read.text
    angles = [float(each) for each in re.findall(r"%\{transform:rotate\(([-\d.]+)deg", markup)]
    assert (angles[0], angles[-1]) == (0, 450)
    assert all(0 <= b - a <= 360 for a, b in pairwise(angles))
    assert [attrs["transform"] for attrs in read.attributes if "class" in attrs and "transform" in attrs] == [
        "rotate(90.0)"
    ]
    host.send("-\rN 3000\rG\r")
    bench.run_until_idle()
    angles = [float(each) for each in re.findall(r"%\{transform:rotate\(([-\d.]+)deg", motor._repr_html_())]
    assert 9 * 360 < angles[0] - angles[-1] <= 10 * 360  # no more than the last ten turns


def test_the_same_run_gives_the_same_markup():
    def shown():
        _, x, motor = with_motor("stepper", THREE_STEPS)
        return x._repr_html_() + x.steps()._repr_html_() + motor._repr_html_()

    assert shown() == shown()


@pytest.mark.parametrize("keep", [None, "1 ms"])
def test_a_stepper_shows_its_shaft_also_where_the_past_is_not_kept(keep):
    bench, _, motor = with_motor("stepper", THREE_STEPS, keep=keep)
    bench.run("100 ms")
    assert ("@keyframes" in motor._repr_html_()) is (keep is None)
    read = Read(motor._repr_html_())
    assert {"angle", "per_turn", "lag"} <= {*read.cells}
    assert f"{motor.place:.6g}" in read.cells
    assert read.tags.count("svg") == 1


def test_every_part_has_a_card_or_shows_nothing():
    bench = slewline.Bench()
    shaft = bench.part("motor", "shaft")
    for kind in KINDS:
        on = shaft if part_class(kind).sits == "must" else None
        part = bench.part(kind, on=on, **GIVEN.get(kind, {}))
        markup = part._repr_html_()
        assert (markup is None) is (part.shows() == {}), kind
        if markup:
            Read(markup)


# ------------------------------------------------------------------------------------------------------------- a bench
def test_a_bench_shows_its_plot_once_something_has_moved_and_few_of_its_pins():
    bench = slewline.Bench()
    assert bench._repr_svg_() is None
    x = bench.add("cy525", name="x")
    host = bench.host(x)
    bench.run("1 ms")
    assert bench._repr_svg_() is None
    bench.record("x.pulse", "x.run")
    host.send("A 0\rF 10\rR 80\rS 240\rN 3\rG\r")
    bench.run_until_idle()
    svg = bench._repr_svg_()
    assert ElementTree.fromstring(svg).tag.endswith("svg")
    assert "Velocity" in svg
    assert ">pulse<" in svg
    bench.record()
    svg = bench._repr_svg_()
    assert "Velocity" in svg
    assert ">pulse<" not in svg


def test_without_matplotlib_a_bench_shows_its_text(moved, monkeypatch):
    import sys

    monkeypatch.setitem(sys.modules, "matplotlib", None)
    assert moved[0]._repr_svg_() is None


def test_tables_of_times_and_readings_are_tables(moved):
    bench, _ = moved
    bench.record()
    bench.run("20 ms")
    read = Read(bench.readings(["50 ms", "60 ms"])._repr_html_())
    assert read.cells[:4] == ["", "1", "2", "2 \u2212 1"]
    assert {"data sheet", "shortest"} <= {*Read(bench.check_timing()._repr_html_()).cells}


# ------------------------------------------------------------------------------------------------------------- escaped
def nothing_runs(svg):
    """Check that a picture has no script and asks for nothing from elsewhere."""
    for each in ElementTree.fromstring(svg).iter():
        assert each.tag.rpartition("}")[2] not in ("script", "foreignObject", "image", "a")
        for name, value in each.items():
            assert not name.lower().startswith("on")
            assert not name.endswith("href") or value.startswith("#")


def test_text_is_escaped_wherever_it_comes_in():
    assert element("td", HOSTILE, class_=HOSTILE).count("<") == 2
    assert element("td", [HOSTILE, element("b", HOSTILE)]).count("<") == 4
    assert element("td", "\udcff").encode("utf-8") == b"<td>?</td>"
    assert element("td", "a < b", class_=None, stroke_width=2) == '<td stroke-width="2">a &lt; b</td>'


def test_an_untrusted_journal_runs_no_code(tmp_path):
    bench = slewline.Bench(journal=tmp_path / "run.jsonl")
    x = bench.add("cy525", name="x")
    host = bench.host(x)
    host.send("A 0\rF 10\rR 80\rS 240\rN 30\rG\r")
    bench.run("20 ms")
    x.motor_report(HOSTILE, HOSTILE)
    host.send(HOSTILE)
    bench.run_until_idle()
    bench.journal.close()
    replayed = slewline.replay(tmp_path / "run.jsonl")
    read = Read(replayed["x"]._repr_html_())
    assert any(HOSTILE in cell for cell in read.cells)
    svg = replayed._repr_svg_()
    assert "&lt;script" in svg
    nothing_runs(svg)
    for part in replayed.parts.values():
        if markup := part._repr_html_():
            Read(markup)


def test_an_untrusted_sheet_runs_no_code():
    own = chip_class("cy525")
    first, *pins = own.sheet.pins
    first = replace(first, name=HOSTILE, description=HOSTILE)
    loose = Pin(0, f"{HOSTILE}2", "none", HOSTILE)
    registers = tuple(replace(row, description=HOSTILE, unit=HOSTILE, letter=HOSTILE) for row in own.sheet.registers)
    sheet = replace(own.sheet, part=HOSTILE, pins=(first, *pins, loose), registers=registers)
    card = slewline.core.notebook.chip_card.ChipCard(
        HOSTILE, sheet, {HOSTILE: 1}, [dict.fromkeys((row.name for row in registers), HOSTILE)], [], None, [HOSTILE]
    )
    read = Read(card.markup())
    assert HOSTILE in read.cells
    assert read.text.count(HOSTILE) > 10


def test_displays_of_parts_run_no_code():
    class Sign(slewline.parts.base.part.Part):
        """A sign on which anything may stand."""

        def shows(self):
            return {HOSTILE: HOSTILE, "text": [HOSTILE, HOSTILE], "none": None}

    bench = slewline.Bench()
    read = Read(bench.part(Sign)._repr_html_())
    assert read.cells == [HOSTILE, HOSTILE, "text", f"{HOSTILE}\n{HOSTILE}"]


# ----------------------------------------------------------------------------------------------------- texts and names
def test_texts_are_short_and_say_what_it_is(moved):
    bench, x = moved
    bench.record("x.pulse")
    bench.run_until_idle()
    velocity, position = x.quantities()
    texts = {
        "<Bench: x (cy525), host;": bench,
        "<CY525 x: position 120, idle, ": x,
        "<BusHost host of x: nothing to send>": bench["host"],
        "<pin x.pulse=1>": x.pin("pulse"),
        "<Axis: position 120, at rest>": x.axes[0],
        "<Velocity: velocity, steps/s>": velocity,
        "<Position: position, steps>": position,
        "<Steps: 120, ": x.steps(),
        "<Hook: 0 listeners>": x.on_power,
        "<ReachesCondition: x at position 40>": x.reaches(40),
        "<Table: 26 commands>": x.sheet.commands,
        "<TimingTable: 12 limits, 0 violated>": bench.check_timing(),
        "<Readings: 3 rows at 50 ms>": bench.readings("50 ms"),
        "<Ramp F=3, R=80, S=200, Z=1, ": slewline.ramp("cy525", F=3, R=80, S=200),
        "<Move of 1000 steps: up ": slewline.ramp("cy525", F=3, R=80, S=200).move(1000),
        "<m axis 2: position 0, at rest>": slewline.Bench().add("mc1451a", name="m").axis(2),
    }
    for text, one in texts.items():
        assert repr(one).startswith(text)
        assert len(repr(one)) < 160


def test_ideals_and_journals_have_short_texts(tmp_path):
    bench = slewline.Bench(journal=tmp_path / "run.jsonl")
    x = bench.add("cy525", name="x")
    bench.host(x).send("A 0\rF 3\rR 80\rS 200\rZ 1\rN 100\rG\r")
    bench.run_until_idle()
    (motion,) = x.motions()
    assert re.fullmatch(r"<Ideal: [\d.]+ ms to [\d.]+ ms, \+100 steps>", repr(motion.ideal))
    assert repr(bench.journal) == f"<Journal {tmp_path / 'run.jsonl'}>"


def test_waveforms_traces_and_comparisons_have_short_texts(moved, tmp_path):
    bench, _ = moved
    bench.record("x.pulse")
    bench.run_until_idle()
    bench.save_vcd(tmp_path / "run.vcd")
    waves = slewline.read_vcd(tmp_path / "run.vcd")
    assert repr(waves).startswith("<Waveforms of ")
    edges = bench.edges("x.pulse")
    assert repr(waves.trace("x.pulse")) == f"<Trace pulse: {len(edges[0])} changes>"
    assert repr(slewline.compare_edges(edges, edges)).endswith("agree>")


def test_tab_hides_names_that_only_list_alternatives(moved):
    bench, x = moved
    bench.run_until_idle()
    others = [x.steps(), x.motions()[0], bench.findings, slewline.ramp("cy525", F=3, R=80, S=200), x.on_power]
    for one in [*everything(), *others]:
        for name in dir(one):
            assert not isinstance(vars(type(one)).get(name), Instead), (one, name)
    assert "times_ps" in dir(x.steps())
    assert "time" not in dir(x.steps())
    assert bench._ipython_key_completions_() is not None
    assert [*bench._ipython_key_completions_()] == ["x", "host"]


def test_a_notebook_requests_the_data_that_it_shows(moved):
    formatters = pytest.importorskip("IPython.core.formatters")
    bench, x = moved
    bench.run_until_idle()
    show = formatters.DisplayFormatter()
    for one, kinds in (
        (slewline.Bench(), set()),
        (x, {"text/html"}),
        (x.steps(), {"text/html"}),
        (bench["host"], set()),
    ):
        data, _ = show.format(one)
        assert {*data} == {"text/plain"} | kinds
        assert data["text/plain"] == repr(one)

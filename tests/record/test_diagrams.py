"""Timing diagrams: where everything stands, and what is drawn."""

from __future__ import annotations

from itertools import combinations, pairwise

import numpy as np
import pytest

from slewline.core.datasheet.table import Limit
from slewline.errors import UsageError
from slewline.record.measuring.intervals import Bound, Interval, SignalEdges
from slewline.record.pictures.diagram import Diagram, DiagramLayout, Lane, LaneText, TimeScale
from slewline.record.pictures.picture_files import save
from slewline.record.pictures.timing_diagram import draw

US, MS = 10**6, 10**9


def lane(name: str, *times: int, level: int = 1, levels=None, bus: bool = False, **more) -> Lane:
    levels = [(level + n + 1) % 2 for n in range(len(times))] if levels is None else levels
    return Lane(
        f"x.{name}", name, SignalEdges(np.array(times, np.int64), np.array(levels, np.int16), level, bus), **more
    )


def texts(figure) -> list[str]:
    return [text.get_text() for text in figure.axes[0].texts if text.get_text()]


def bursts(**more) -> Diagram:
    times = [*range(10 * US, 20 * US, US), *range(10 * MS, 10 * MS + 10 * US, US)]
    return Diagram("Two bursts", 0, 20 * MS, [lane("a", *times)], **more)


# --------------------------------------------------------------------------------------------------------------- scale
def test_time_is_linear_where_nothing_is_quiet():
    scale = TimeScale(Diagram("", 0, 100, [lane("a", 20, 40, 60, 80)]), 1, 9)
    assert scale.cuts == []
    assert scale([0, 50, 100]).tolist() == [1, 5, 9]


def test_long_quiet_stretches_are_cut_short_and_nothing_else():
    scale = TimeScale(bursts(), 0, 8)
    assert len(scale.cuts) == 3
    places = scale([*range(10 * US, 20 * US, US)])
    apart = np.diff(places)
    assert np.allclose(apart, US / scale.ps_per_inch)  # as everywhere outside of the cuts
    assert apart[0] > 0.1
    assert all(begin > 0 and end - begin > 9 * MS for begin, end in scale.cuts[1:])
    assert scale([0, 20 * MS]).tolist() == [0, 8]


def test_each_cut_is_drawn_as_long_as_the_others():
    scale = TimeScale(bursts(), 0, 8)
    drawn = [np.diff(scale(list(cut)))[0] * scale.ps_per_inch for cut in scale.cuts]
    assert drawn == pytest.approx([scale.room] * 3)


def test_how_long_a_stretch_must_be_can_be_chosen():
    assert TimeScale(bursts(quiet=0), 0, 8).cuts == []
    assert len(TimeScale(bursts(quiet=5 * MS), 0, 8).cuts) == 2


def test_order_is_kept_everywhere():
    scale = TimeScale(bursts(), 0, 8)
    assert (np.diff(scale(np.linspace(0, 20 * MS, 5000).astype(np.int64))) >= 0).all()


def test_a_character_is_not_cut():
    words = [LaneText(1 * MS, 9 * MS, "A")]
    scale = TimeScale(
        Diagram("", 0, 100 * MS, [lane("a", 1 * MS, 2 * MS, 3 * MS, words=words)], quiet=8 * MS + 1), 0, 8
    )
    assert all(begin >= 9 * MS for begin, _ in scale.cuts)


# -------------------------------------------------------------------------------------------------------------- layout
def test_arrows_and_their_texts_do_not_overlap():
    times = list(range(US, 40 * US, US))
    intervals = [Interval("x.a falls", "x.a rises", a, b) for a, b in combinations(times[::6], 2)]
    diagram = Diagram("", 0, 41 * US, [lane("a", *times)], intervals)
    layout = DiagramLayout.of(diagram, TimeScale(diagram, 1, 9))
    assert len(layout.arrows) == len(intervals) == 21
    rows: dict[int, list[tuple[float, float]]] = {}
    for arrow in layout.arrows:
        ends = [arrow.first, arrow.second]
        wide = len(arrow.text) * 0.06
        if arrow.beside:
            ends += [arrow.place + (wide if arrow.beside == "right" else -wide)]
        rows.setdefault(arrow.row, []).append((min(ends), max(ends)))
    assert len(rows) > 3
    for extents in rows.values():
        assert all(a[1] <= b[0] for a, b in pairwise(sorted(extents)))
    assert layout.height > 0.2 * len(rows)


def test_the_text_of_a_long_arrow_is_in_the_middle_of_it():
    diagram = Diagram("", 0, 100, [lane("a", 20, 90)], [Interval("x.a falls", "x.a rises", 20, 90)])
    (arrow,) = DiagramLayout.of(diagram, TimeScale(diagram, 1, 11)).arrows
    assert (arrow.first, arrow.second, arrow.place, arrow.beside) == pytest.approx((3, 10, 6.5, ""))


def test_an_arrow_is_under_the_lower_one_of_its_lanes():
    lanes = [lane("a", 10), lane("b", 20), lane("c", 30)]
    diagram = Diagram("", 0, 40, lanes, [Interval("x.b falls", "x.a falls", 10, 20), Interval("x.c", "x.c", 1, 2)])
    layout = DiagramLayout.of(diagram, TimeScale(diagram, 1, 9))
    assert sorted(arrow.under for arrow in layout.arrows) == [1, 2]
    assert layout.feet == tuple(sorted(layout.feet, reverse=True))


# ------------------------------------------------------------------------------------------------------------- drawing
def test_levels_cross_the_middle_at_the_instants_of_their_edges():
    diagram = Diagram("", 0, 100, [lane("a", 20, 60)])
    line = draw(diagram).axes[0].lines[0]
    across, up = line.get_xdata(), line.get_ydata()
    middle = (up.min() + up.max()) / 2
    crossings = [
        a + (b - a) * (middle - c) / (d - c) for (a, c), (b, d) in pairwise(zip(across, up, strict=True)) if c != d
    ]
    left = 0.16 + 0.012 * 8.5 + 0.08
    scale = TimeScale(diagram, left, 9.6 - 0.28)
    assert crossings == pytest.approx(scale([20, 60]).tolist())


def test_edges_are_slanted_unless_a_level_is_too_narrow_for_it():
    def width(first, last):
        across = draw(Diagram("", 0, 1000, [lane("a", first, last)])).axes[0].lines[0].get_xdata()
        return across[2] - across[1]

    assert width(200, 600) == pytest.approx(0.045)
    assert width(200, 210) == 0


def test_a_floating_pin_is_a_line_in_the_middle():
    line = draw(Diagram("", 0, 100, [lane("a", 50, levels=[-1], level=0)])).axes[0].lines[0]
    low, high = line.get_ydata()[0], line.get_ydata()[-1]
    assert high - low == pytest.approx(0.1)


def test_a_bus_shows_its_values_and_their_meaning():
    bus = lane("db", 20, 60, levels=[0x45, -1], level=-1, bus=True, describe=lambda value, end: f"'{chr(value)}' {end}")
    assert "45 'E' 60" in texts(draw(Diagram("", 0, 100, [bus])))
    narrow = lane("db", 20, 21, 60, levels=[0x45, 0x46, -1], level=-1, bus=True)
    shown = texts(draw(Diagram("", 0, 100, [narrow])))
    assert "46" in shown
    assert "45" not in shown


def test_dense_edges_are_a_band():
    axes = draw(Diagram("", 0, 10 * MS, [lane("a", *range(MS, 9 * MS, US), level=0)])).axes[0]
    (band,) = axes.patches
    assert len(axes.lines[0].get_xdata()) < 20
    corners = band.get_xy()[:, 0]
    assert 6 < corners.max() - corners.min() < 8


def test_times_at_arrows_say_what_is_printed_and_are_coloured():
    limit = Limit("a falls", "b falls", "", "", least=50 * US, symbol="t1")
    for last, says, dark in (
        (60, "t1 = 50 µs  (min. 50 µs: met)", False),
        (59, "t1 = 49 µs  (min. 50 µs: violated)", True),
    ):
        arrow = Interval("x.a falls", "x.b falls", 10 * US, last * US, (Bound.of(limit, 1),))
        diagram = Diagram("", 0, 100 * US, [lane("a", 10 * US), lane("b", last * US)], [arrow], [arrow])
        shown = [text for text in draw(diagram, dark=dark).axes[0].texts if text.get_text() == says]
        assert [text.get_color() for text in shown] == ["#ff7b72" if dark else "#0b7a4b"]
        assert says.split("  ")[0] in " ".join(texts(draw(diagram, width="phone")))


def test_a_picture_mentions_its_omissions():
    diagram = bursts(quiet=5 * MS)
    figure = draw(diagram)
    shown = texts(figure)
    across = figure.axes[0].lines[0].get_xdata()  # of the lane, from end to end
    scale = TimeScale(diagram, across[0] + 0.08, across[-1] - 0.08)
    left_out = sum(float(text.split()[0]) for text in shown if text.endswith(" ms"))
    assert left_out == pytest.approx((diagram.stop - (scale.right - scale.left) * scale.ps_per_inch) / MS, abs=0.02)
    assert sum(text.endswith(" ms") for text in shown) == len(scale.cuts) == 2
    assert any("a zigzag marks omitted time" in text for text in shown)
    assert any("Time in ms" in text for text in texts(draw(bursts(quiet=0))))


@pytest.mark.parametrize("width", ["page", "phone"])
def test_a_long_title_takes_several_lines(width):
    words = " ".join(f"word{n}" for n in range(30))
    figure = draw(Diagram(words, 0, 100, [lane("a", 50)]), width=width)
    short = draw(Diagram("word", 0, 100, [lane("a", 50)]), width=width)
    lines = [text for text in figure.axes[0].texts if text.get_text().startswith("word")]
    lines.sort(key=lambda text: -text.get_position()[1])
    assert " ".join(text.get_text() for text in lines) == words
    assert figure.get_figheight() - short.get_figheight() == pytest.approx(0.2 * (len(lines) - 1))
    figure.canvas.draw()
    assert all(text.get_window_extent().x1 < figure.bbox.x1 for text in lines)
    assert lines[0].get_window_extent().y1 < figure.bbox.y1


def test_the_same_diagram_gives_the_same_bytes_again(tmp_path):
    diagram = bursts(measured=[Interval("x.a falls", "x.a rises", 10 * US, 11 * US)])
    for suffix in ("svg", "png"):
        for number in (1, 2):
            save(draw(diagram), tmp_path / f"{number}.{suffix}", diagram.title, diagram.description)
        assert (tmp_path / f"1.{suffix}").read_bytes() == (tmp_path / f"2.{suffix}").read_bytes()
    svg = (tmp_path / "1.svg").read_text("utf-8")
    assert "<title>Two bursts</title>" in svg
    assert "<desc>Timing diagram of a, from 0 ps to 20 ms. From x.a falls to x.a rises: t = 1 µs.</desc>" in svg


@pytest.mark.parametrize("diagram", [Diagram("", 5, 5, [lane("a")]), Diagram("", 0, 5, [])])
def test_nothing_cannot_be_drawn(diagram):
    with pytest.raises(UsageError, match="nothing to draw"):
        draw(diagram)

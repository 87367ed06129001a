"""A drawing in fewer bytes is the same drawing."""

from __future__ import annotations

import re

from slewline.record.pictures.svg import compact
from tests.rows import rows


def points(path):
    """The points of a path, M l h v z, as (x, y); z as None."""
    x, y, found = 0.0, 0.0, []
    for letter, numbers in re.findall(r"([Mlhvz])([^Mlhvz]*)", path):
        values = [float(number) for number in re.findall(r"-?[0-9.]+", numbers)]
        if letter == "M":
            x, y = values
        else:
            x += values[0] if letter in "lh" else 0
            y += values[-1] if letter in "lv" else 0
        found.append(None if letter == "z" else (x, y))
    return found


@rows(
    ("drawn", "short"),
    [
        ("M 1.25 2 \nL 3.5 2 \nL 3.5 7.125001 \nL 4 8 \nz\n", "M1.25 2h2.25v5.13l.5 .87z"),
        ("M 0 0 \nL 0 0 \n", "M0 0h0"),  # a dot
        ("M 1.001 1 \nL 1.004 9 \nL 5 9.004 \n", "M1 1v8h4"),  # what is level to a hundredth
        ("M 1 2 \nL 3 2 \nM 3 2 \nL 9 2 \n", "M1 2h2M3 2h6"),  # another piece begins where the last one ended
        ("M -0.001 100 \nL 20 100 \n", "M0 100h20"),
        ("M 5 5 \nL 3.01 4.98 \nL 4.01 4.5 \n", "M5 5l-1.99-.02l1-.48"),
        ("M 1.23456 2 \nC 1 2 3 4 5 6 \n", "M 1.23456 2 \nC 1 2 3 4 5 6 \n"),
    ],
)
def test_lines_are_short_and_curves_stay(drawn, short):
    assert compact(f'<path id="a" d="{drawn}" style="x: 1.23456"/>'.encode()).decode() == (
        f'<path id="a" d="{short}" style="x: 1.23456"/>'
    )


def test_a_picture_is_the_same_to_a_hundredth(tmp_path):
    import random

    chance = random.Random(7)
    drawn = [(chance.choice("MLL"), chance.choice((1.0, 2.123456, 300.98765)), 9 * chance.random()) for _ in range(500)]
    drawn[0] = ("M", 0.0, 0.0)
    path = "".join(f"{letter} {x:.6f} {y:.6f} \n" for letter, x, y in drawn)
    short = re.search(r' d="(.*)"', compact(f'<path d="{path}"/>'.encode()).decode())[1]
    assert len(short) < 0.8 * len(path)
    for (x, y), (_, drawn_x, drawn_y) in zip(points(short), drawn, strict=True):
        assert abs(x - drawn_x) <= 0.005001 and abs(y - drawn_y) <= 0.005001


def dot(x, y, style="fill: #123"):
    return f'<use xlink:href="#m1" x="{x}" y="{y}" style="{style}"/>'


def test_many_dots_have_their_style_and_each_place_once():
    dots = dot("1.004", "200.126"), dot("2.5", "3"), dot("2.499", "3"), dot("0.25", "-4.000001")
    drawn = '<g clip-path="url(#p)">\n ' + "\n ".join(dots) + "\n</g>"
    assert compact(drawn.encode()).decode() == (
        '<g clip-path="url(#p)" style="fill: #123">\n <use xlink:href="#m1" x="1" y="200.13"/>\n'
        ' <use xlink:href="#m1" x="2.5" y="3"/>\n <use xlink:href="#m1" x=".25" y="-4"/>\n</g>'
    )
    for other in (f"<g>{dot(1, 2)}{dot(3, 4)}</g>", f"<g>{dot(1, 2)}{dot(3, 4)}{dot(5, 6, 'fill: #456')}</g>"):
        assert compact(other.encode()).decode() == other  # few, or not all alike


def text(says, font="Sans", turned="-0 1.5 2"):
    return f'<text style="font-size: 8px; font-family: {font}; fill: #123" transform="rotate({turned})">{says}</text>'


def test_text_has_its_font_once_and_only_turned_text_is_turned():
    drawn = f"<style>*{{a: b}}</style>{text(1)}{text(2, turned='-90 1 2')}"
    assert compact(drawn.encode()).decode() == (
        '<style>*{a: b}text{font-family: Sans}</style><text style="font-size: 8px; fill: #123">1</text>'
        '<text style="font-size: 8px; fill: #123" transform="rotate(-90 1 2)">2</text>'
    )
    two = f"<style></style>{text(1, turned='9 1 2')}{text(2, 'Serif', turned='9 1 2')}"
    assert compact(two.encode()).decode() == two

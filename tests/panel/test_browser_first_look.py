"""What a page shows at first: a program that waits, the machine above the fold, nothing cut off."""

from __future__ import annotations

import pytest

from slewline.bench.files.shipped_files import named

from .walking import DESKTOP, PHONE, Walk, running

pytestmark = pytest.mark.system

SMALL = (360, 780)
SIZES = [DESKTOP, PHONE, SMALL]
MOVES = "A 0\nF 20\nR 40\nS 200\nZ 1\nN 60000\n+\nG\n"
JOGGED = """
[[chip]]
part = "cy545b"
name = "x"

[[host]]
chips = ["x"]
script = ["F 3", "R 100", "S 200"]
"""
CUT = """[...document.querySelectorAll('.pin-name, .lamps li, .register-name, .unit, .bench-title, .jump button')]
  .filter((one) => one.offsetParent && getComputedStyle(one).display !== 'inline')
  .filter((one) => one.scrollWidth > one.clientWidth + 1)
  .map((one) => one.textContent)"""
BLANK = """[...document.querySelectorAll('canvas')].filter((one) => one.offsetParent).filter((one) =>
  !one.width || !one.getContext('2d').getImageData(0, 0, one.width, one.height).data.some((value) => value)).length"""


@pytest.fixture
def file(tmp_path):
    """Write a file, and return where it is."""

    def file(text, name):
        (tmp_path / name).write_text(text)
        return tmp_path / name

    return file


@pytest.fixture
def walk(browser, tmp_path):
    """Open a page of a size."""
    return lambda url, size=DESKTOP, scheme="light": Walk(browser, url, tmp_path, size, scheme)


def test_a_program_waits_for_its_reader(walk, file):
    with running("panel", file(MOVES, "moves.cy525"), "--no-browser") as command:
        page = walk(command.port("panel"))
        start = page.button("Run the program")
        start.wait_for()
        page.page.wait_for_timeout(500)
        assert page.seconds() < 0.01 and not page.button("Go").is_visible() and not page.button("Pause").is_visible()
        start.click()
        page.until(lambda: page.position() > 0)
        page.until(lambda: not start.is_visible() and page.button("Pause").is_visible())
        page.button("Pause").click()
        page.button("Go").wait_for()
        assert not start.is_visible()  # it has begun
        page.close()


def test_it_waits_in_a_bench_file_too_and_for_no_host_on_a_port(walk, file):
    served = '[[chip]]\npart = "gs-c200s"\n[[serve]]\nchips = ["gs_c200s"]\ntcp = "127.0.0.1:0"\n'
    for name, text, options, waits in (
        ("jog.toml", JOGGED, (), True),
        ("run.toml", JOGGED, ("--run",), False),
        ("served.toml", served, (), False),
    ):
        with running("panel", file(text, name), *options, "--no-browser") as command:
            page = walk(command.port("panel"))
            page.button("Run the program" if waits else "Pause").wait_for()
            page.until(lambda page=page, waits=waits: waits or page.seconds() > 0.1)
            assert page.button("Run the program").is_visible() == waits
            page.close()


def test_machine_and_velocity_are_above_the_fold(walk, file):
    with running("panel", named()["programs/weld.cy525"], "--no-browser") as command:
        page = walk(command.port("panel"))
        for place in (".shaft-dial", ".strips"):
            page.page.locator(place).first.wait_for()
            box = page.page.locator(place).first.bounding_box()
            assert box["y"] + box["height"] < DESKTOP[1] / 2, (place, box)
        page.close()


@pytest.mark.parametrize("scheme", ["light", "dark"])
@pytest.mark.parametrize("size", SIZES, ids=lambda size: str(size[0]))
def test_nothing_is_cut_off_or_blank(walk, size, scheme):
    with running("panel", named()["programs/weld.cy525"], "--run", "--no-browser") as command:
        page = walk(command.port("panel"), size, scheme)
        for place in (".strips", "#scope canvas"):
            page.page.locator(place).first.wait_for(state="attached")
        page.page.locator(".pin-name", has_text="programmable_output").wait_for(state="attached")
        assert page.page.evaluate(CUT) == []
        rows = page.page.locator(".registers tbody tr")
        heights = {round(rows.nth(n).bounding_box()["height"]) for n in range(rows.count())}
        assert max(heights) - min(heights) <= 1, heights  # no unit takes two lines
        page.until(lambda: page.page.evaluate(BLANK) == 0)  # also of what lies far below
        page.picture(f"first_{size[0]}_{scheme}")
        page.close()


@pytest.mark.parametrize("size", [PHONE, SMALL], ids=lambda size: str(size[0]))
def test_on_a_phone_every_part_is_one_tap_away(walk, size):
    with running("panel", named()["programs/weld.cy525"], "--run", "--no-browser") as command:
        page = walk(command.port("panel"), size)
        page.page.locator("#place-scope").wait_for()
        for name, place in (
            ("To the conversation", "#conversation"),
            ("To the machine", "#machine"),
            ("To the scope", "#scope"),
            ("To the chips and their pins", ".chip-card header"),
            ("To the editor", "#editor"),
        ):
            page.button(name).click()

            def there(place=place):
                box = page.page.locator(place).first.bounding_box()
                return box is not None and 0 <= box["y"] < size[1] / 2

            page.until(there)
        page.close()


def test_on_a_desktop_there_is_no_bar(walk, file):
    with running("panel", file(MOVES, "moves.cy525"), "--no-browser") as command:
        page = walk(command.port("panel"))
        assert not page.page.locator("#jump").is_visible()
        page.close()


def test_a_chip_with_a_jog_input_is_jogged_while_a_button_is_pressed(walk, file):
    with running("panel", file(JOGGED, "jog.toml"), "--run", "--no-browser") as command:
        page = walk(command.port("panel"))
        clockwise, back = page.button("jog of x: jog clockwise"), page.button("jog of x: jog counter-clockwise")
        clockwise.hover()
        page.page.mouse.down()
        page.until(lambda: page.position() > 3)
        clockwise.hover()
        page.page.mouse.up()
        page.until(
            lambda: (
                not page.pin("jog").get_attribute("data-held") and page.pin("jog").get_attribute("data-level") == "z"
            )
        )
        there = page.position()
        page.page.wait_for_timeout(500)
        assert page.position() == there
        back.focus()
        page.page.keyboard.down(" ")
        page.until(lambda: page.position() < there - 3)
        page.page.keyboard.up(" ")
        page.close()

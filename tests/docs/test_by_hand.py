"""The page with sliders, opened as a file: it moves, and says what `slewline ramp` says."""

from __future__ import annotations

import base64
import json
import random
import re
import shlex
import zlib
from itertools import pairwise

import pytest

import slewline

from .blocks import called

pytestmark = pytest.mark.system

PAGE = "tutorial/ramps_by_hand"
PARTS = ("CY525", "GS-C200", "MC1451A")
HEAVIEST = 500_000  # bytes of all that the page loads
LATEST = 5000  # ms from its address to the sliders, on a machine that does other things as well
PLACES = 25  # of the sliders of a part, by chance


@pytest.fixture
def page(opened):
    """The page with its sliders, on a wide screen."""
    one = opened(PAGE, viewport={"width": 1400, "height": 900})
    one.wait_for_selector(".by-hand path.curve")
    return one


@pytest.fixture(scope="module")
def parts(built):
    """The runs that the page shows, of every part."""
    text = (built / "_static/by_hand.js").read_text("utf-8")
    packed = re.search(r'^begin\("(.*)"\);$', text, re.MULTILINE)[1]
    return json.loads(zlib.decompress(base64.b64decode(packed)))


def put(page, places):
    """Put the sliders somewhere."""
    for slider, place in zip(page.locator(".by-hand input[type=range]").all(), places, strict=True):
        slider.fill(str(place))


def shown(page):
    """Return the command that the page shows, and what it shows as its output."""
    rows = zip(*(page.locator(f".by-hand {tag}").all_text_contents() for tag in ("dt", "dd")), strict=True)
    return page.locator(".by-hand .command").text_content(), [f"{label:<13} {says}" for label, says in rows]


def sizes(page):
    """Return how many places each slider has."""
    return [int(slider.get_attribute("max")) + 1 for slider in page.locator(".by-hand input[type=range]").all()]


# -------------------------------------------------------------------------------------------------------------- numbers
@pytest.mark.parametrize("part", PARTS)
def test_the_page_shows_the_output_of_the_command(page, part):
    page.get_by_role("radio", name=part).check()
    ends, chance = sizes(page), random.Random(part)
    corners = [[(end - 1) * (corner >> n & 1) for n, end in enumerate(ends)] for corner in range(8)]
    seen = set()
    for places in corners + [[chance.randrange(end) for end in ends] for _ in range(PLACES)]:
        put(page, places)
        command, lines = shown(page)
        assert called(shlex.split(command)).splitlines()[1:] == lines
        seen.add(command)
    assert len(seen) > PLACES


@pytest.mark.parametrize(("part", "straps"), [("CY525", {}), ("GS-C200", {"chs": 0})])
def test_the_host_commands_shown_produce_that_move(page, part, straps):
    page.get_by_role("radio", name=part).check()
    values = dict(word.split("=") for word in shlex.split(shown(page)[0]) if "=" in word)
    bench = slewline.Bench()
    x = bench.add(part.lower(), straps=straps)
    bench.host(x).send("".join(f"{line}\r" for line in page.locator(".by-hand .host").text_content().split("; ")))
    bench.run_until_idle()
    times = x.steps().times_ps
    assert (abs(times - times[0] - slewline.ramp(part.lower(), **values).move(1000).times()) <= 1).all()  # ps


def test_the_area_below_every_curve_is_the_distance(parts):
    for part in parts["parts"]:
        for curve in part["curves"]:
            points = [*zip(curve[::2], curve[1::2], strict=True)]
            area = sum((b[0] - a[0]) * (a[1] + b[1]) / 2 for a, b in pairwise(points))
            assert area / parts["perSecond"] == pytest.approx(1000, rel=0.02), part["title"]


# --------------------------------------------------------------------------------------------------------------- moving
def test_a_slider_moves_its_own_and_the_neighbouring_curves(page):
    def curves():
        return [one.get_attribute("d") for one in page.locator(".by-hand path").all()]

    before = curves()
    page.locator(".by-hand input[type=range]").nth(2).press("ArrowRight")
    same, moved = curves(), curves()[-1]
    assert same[:-1] == before[:-1]  # what the slider may make of it is what it was
    assert moved != before[-1] and moved in same[:-1]
    page.locator(".by-hand input[type=range]").nth(0).press("ArrowRight")
    assert len({*curves()} & {*before}) == 0


def test_the_keyboard_reaches_everything(page):
    page.get_by_role("radio", name="CY525").focus()
    page.keyboard.press("ArrowRight")
    assert page.get_by_role("radio", name="GS-C200").is_checked()
    for name in ("S", "T", "R"):
        page.keyboard.press("Tab")
        page.keyboard.press("Home")
        assert f" {name}=" in shown(page)[0]
    assert " S=5 T=40 R=10 " in shown(page)[0]
    page.keyboard.press("Tab")
    page.keyboard.press("Enter")
    assert page.locator(".by-hand path.kept").count() == 1


def test_the_first_curve_has_its_final_width(page):
    page.add_init_script(
        """
        window.curves = new Set();
        const note = () => document.querySelectorAll(".by-hand path.curve")
            .forEach((one) => window.curves.add(one.getAttribute("d")));
        new MutationObserver(note).observe(document, { childList: true, subtree: true, attributes: true });
        """
    )
    page.reload()
    page.wait_for_selector(".by-hand path.curve")
    page.wait_for_timeout(300)
    assert page.evaluate("window.curves.size") == 1


def test_a_curve_that_is_kept_stays_until_another_part_is_chosen(page):
    drawn = page.locator(".by-hand path.curve").get_attribute("d")
    page.get_by_role("button", name="Keep this curve").click()
    assert page.locator(".by-hand .kept-note").text_content() == "F 3, R 60, S 200: 1.029143 s"
    page.locator(".by-hand input[type=range]").nth(2).press("ArrowRight")
    assert page.locator(".by-hand path.kept").get_attribute("d") == drawn
    page.get_by_role("radio", name="MC1451A").check()
    assert page.locator(".by-hand path.kept").count() == 0


def test_a_slider_announces_its_parameter_and_value_to_a_screen_reader(page):
    slider = page.get_by_role("slider", name="S: acceleration, 255 is steepest")
    slider.press("End")
    assert slider.get_attribute("aria-valuetext") == "S 250"
    assert (
        page.locator(".by-hand svg").get_attribute("aria-label").startswith("Velocity over time: 300 to 5140 steps/s")
    )


# --------------------------------------------------------------------------------------------------------------- weight
def test_the_page_is_light_and_starts_immediately(opened, built):
    page = opened("index")
    page.wait_for_load_state("networkidle")  # what is asked for and then left is an error, too
    loaded = []
    page.on("request", lambda asked: loaded.append(asked.url))
    page.goto((built / f"{PAGE}.html").as_uri())
    page.wait_for_selector(".by-hand path.curve")
    weight = sum((built / url.removeprefix(f"{built.as_uri()}/").partition("?")[0]).stat().st_size for url in {*loaded})
    start = page.evaluate("performance.getEntriesByName('by-hand')[0].startTime")
    print(f"{weight} bytes in {len(loaded)} files, {start:.0f} ms")
    assert 200_000 < weight < HEAVIEST
    assert start < LATEST


def test_no_other_page_loads_it(opened):
    page = opened("howto/ramps")
    assert page.locator("script[src*=by_hand], link[href*=by_hand]").count() == 0


def test_without_javascript_there_is_a_picture(browser, built):
    page = browser.new_page(java_script_enabled=False)
    page.goto((built / f"{PAGE}.html").as_uri())
    assert page.locator(".by-hand img").bounding_box()["width"] > 300
    assert page.locator(".by-hand input").count() == 0
    page.close()


@pytest.mark.parametrize("width", [390, 320])
def test_on_a_phone_it_fits_and_can_be_touched(opened, width):
    page = opened(PAGE, viewport={"width": width, "height": 844}, has_touch=True)
    page.wait_for_selector(".by-hand path.curve")
    page.get_by_role("radio", name="MC1451A").check()
    assert page.evaluate("document.querySelector('.content').scrollWidth") <= width
    for control in page.locator(".by-hand input[type=range], .by-hand button, .by-hand .parts label").all():
        box = control.bounding_box()
        assert box["height"] >= 24 and box["x"] >= 0 and box["x"] + box["width"] <= width
    figure = page.locator(".by-hand svg").bounding_box()
    sliders = page.locator(".by-hand .sliders").bounding_box()
    assert (
        sliders["y"] + sliders["height"] - figure["y"] < 844 - 64
    )  # both are seen at once, below the head of the page

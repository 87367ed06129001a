"""What a notebook shows, in a browser: a stranger's text runs nothing, the shaft turns, nothing is cut off."""

from __future__ import annotations

import pytest

from tests.motors import with_motor

pytestmark = pytest.mark.check
HOSTILE = (
    "</style></svg><script>document.title='ran'</script><img src=http://127.0.0.1:9/x onerror=document.title='ran'>"
)
CUT_OFF = """() => [...document.querySelectorAll('.slewline, .slewline *')].filter(each => {
    const box = each.getBoundingClientRect();
    return box.right > innerWidth + 1 && !each.closest('.scrolls');
}).map(each => each.outerHTML.slice(0, 80))"""


@pytest.fixture(scope="module")
def cards():
    """The cards of chips, of their steps and of a motor, with findings of a stranger."""
    bench, x, motor = with_motor("translator", "A 0\rF 10\rR 80\rS 240\rE\rN 250\rG\r0\rQX\r")
    x.motor_report(HOSTILE, HOSTILE)
    chipset = bench.add("mc1451a", name="m")
    svg = bench._repr_svg_()
    plot = (
        f"<div style='overflow:auto'>{svg[svg.index('<svg') :]}</div>"  # a notebook scrolls a picture that is too wide
    )
    return "".join([*(one._repr_html_() for one in (x, chipset, x.steps(), motor)), plot])


def shown(browser, cards, **how):
    """A page with the cards, and what it has asked for and said."""
    page = browser.new_page(**how)
    asked = []
    page.on("request", lambda request: asked.append(request.url))
    page.on("console", lambda message: asked.append(message.text))
    page.on("dialog", lambda dialog: asked.append(dialog.message))
    page.set_content(f"<title>quiet</title><body>{cards}")
    return page, asked


def test_an_untrusted_card_runs_nothing_and_fetches_nothing(browser, cards):
    page, asked = shown(browser, cards)
    page.wait_for_timeout(200)
    assert page.title() == "quiet"
    assert asked == []
    assert page.locator("script, img").count() == 0
    assert HOSTILE in page.inner_text("body")


def test_the_shaft_turns_where_motion_is_welcome(browser, cards):
    angle = """ms => {
        document.getAnimations()[0].currentTime = ms;
        const {a, b} = new DOMMatrix(getComputedStyle(document.querySelector('[class^=slewline-]')).transform);
        return Math.round(Math.atan2(b, a) * 180 / Math.PI);
    }"""
    page, _ = shown(browser, cards, reduced_motion="no-preference")
    assert page.evaluate("() => document.getAnimations().length") == 1
    assert page.evaluate(angle, 0) == 0
    assert 0 < page.evaluate(angle, 700) < 90
    assert page.evaluate(angle, 4500) == 90  # a turn and a quarter
    page, _ = shown(browser, cards, reduced_motion="reduce")
    assert page.evaluate("() => document.getAnimations().length") == 0
    assert (
        page.evaluate("() => document.querySelector('[class^=slewline-]').getAttribute('transform')") == "rotate(90.0)"
    )


@pytest.mark.parametrize("width", [1400, 390])
def test_nothing_is_cut_off(browser, cards, width):
    page, _ = shown(browser, cards, viewport={"width": width, "height": 800})
    assert page.evaluate(CUT_OFF) == []
    assert page.evaluate("() => document.documentElement.scrollWidth") == width


def test_the_ink_is_that_of_the_page(browser, cards):
    page, _ = shown(browser, f"<div style='color:rgb(200, 210, 220)'>{cards}</div>")
    for what in ("td", "svg text", ".says"):
        style = page.evaluate(f"() => getComputedStyle(document.querySelector('.slewline {what}'))")
        assert "rgb(200, 210, 220)" in (style["fill"] if "svg" in what else style["color"])

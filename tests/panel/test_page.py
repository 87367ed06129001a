"""The page in Chromium: it shows the chip, does what is asked, and asks nobody but the panel."""

from __future__ import annotations

import time
from pathlib import Path

import pytest

import slewline.panel
from tests.ensembles import few

SIZES = {"desktop": (1440, 900), "phone": (390, 844)}
PAGE = Path(slewline.panel.__file__).with_name("page")
UNANSWERED = """
const send = WebSocket.prototype.send;
WebSocket.prototype.send = function (text) { if (!text.includes('"said"')) send.call(this, text); };
"""
CONNECTIONS = """() => {
    const place = document.getElementById("connection");
    window.connections = [];
    new MutationObserver(() => window.connections.push(place.className)).observe(place, { attributes: true });
}"""
LATE_FRAMES = "window.requestAnimationFrame = (draw) => setTimeout(() => draw(performance.now()), 150);"
PRESSES = """async (keys) => {  // each as soon as the page shows the level of the one before
    const pin = document.querySelector(".pin[aria-label*=' abort, ']");
    const shows = (level) => new Promise((resolve, reject) => {
        const timer = setTimeout(() => reject(new Error(`abort is ${pin.dataset.level}, not ${level}`)), 15000);
        new MutationObserver((_, observer) => {
            if (pin.dataset.level !== level) return;
            clearTimeout(timer);
            observer.disconnect();
            resolve();
        }).observe(pin, { attributes: true });
    });
    for (const key of keys) {
        const shown = shows(key);
        pin.dispatchEvent(new KeyboardEvent("keydown", { key, bubbles: true }));
        await shown;
    }
}"""
HEAVIEST = 300_000  # bytes of the whole page
pytestmark = pytest.mark.system
at_both_sizes = pytest.mark.parametrize("size", SIZES, indirect=True)


@pytest.fixture(params=few(SIZES, 1))
def size(request):
    """A desktop; in long runs a phone, too.  Tests of what a small screen changes have both."""
    return dict(zip(("width", "height"), SIZES[request.param], strict=True))


@pytest.fixture
def opened(browser, panel, size):
    """Open the page at a size, with the address that is printed or another one; no error may show on its console."""
    pages, wrong = [], []

    def page(url=panel.url, script="", **more):
        one = browser.new_page(viewport=size, **more)
        one.add_init_script(script)
        pages.append(one)
        one.set_default_timeout(60_000)
        one.on("pageerror", lambda error: wrong.append(str(error)))
        one.on("console", lambda said: wrong.append(said.text) if said.type in ("error", "warning") else None)
        one.on("request", lambda asked: wrong.append(asked.url) if panel.host not in asked.url else None)
        one.goto(url)
        one.wait_for_selector(".chip-card .figure")
        one.wait_for_selector(".clock:not(:empty)")  # a card may be drawn before all else
        return one

    yield page
    for one in pages:
        one.close()
    assert wrong == []


def steps(page):
    """Open the controls that a phone hides."""
    if page.locator(".opens-steps").is_visible():
        page.click(".opens-steps")


def until(met, seconds=15):
    """Wait until something is true."""
    end = time.monotonic() + seconds
    while not met():
        assert time.monotonic() < end
        time.sleep(0.02)


def test_the_page_is_light_enough():
    assert sum(path.stat().st_size for path in PAGE.iterdir()) < HEAVIEST


def test_a_chip_is_shown_and_worked(opened, served):
    page = opened()
    page.get_by_label("Command for x").fill("A 100")
    page.keyboard.press("Enter")
    page.get_by_role("listitem").filter(has_text="A 100").first.wait_for()
    until(lambda: served.do(lambda: served.bench.chips["x"].position) == 100)
    page.locator(".axis-reading .figure", has_text="100").first.wait_for()


def test_time_is_paused_and_let_go(opened, served):
    page = opened()
    page.get_by_role("button", name="Pause", exact=True).click()
    page.get_by_role("button", name="Go", exact=True).first.wait_for()
    assert served.do(lambda: served.server.pace.paused)
    page.keyboard.press("F8")
    page.get_by_role("button", name="Pause", exact=True).wait_for()
    assert not served.do(lambda: served.server.pace.paused)


def test_the_last_change_is_shown_even_if_frames_are_late(opened):
    """While time is paused no other view follows, so a level that is not drawn would stay so."""
    page = opened(script=LATE_FRAMES)
    page.get_by_role("button", name="Pause", exact=True).click()
    page.get_by_role("button", name="Go", exact=True).first.wait_for()
    page.evaluate(PRESSES, ["0", "1"] * 10)


def test_without_the_token_nothing_can_be_worked(opened, panel):
    page = opened(panel.origin)
    assert "read-only" in page.locator("#connection").text_content()
    assert page.locator("[data-writes]:enabled").count() == 0


@at_both_sizes
def test_nothing_is_wider_than_the_screen(opened, size):
    page = opened()
    assert page.evaluate("document.documentElement.scrollWidth") <= size["width"]


@at_both_sizes
def test_every_control_has_a_name(opened):
    page = opened()
    steps(page)
    nameless = page.evaluate("""() => [...document.querySelectorAll("button, input, select, textarea, [role=listbox]")]
        .filter((one) => !(one.getAttribute("aria-label") || one.getAttribute("aria-labelledby") ||
            one.labels?.length || one.textContent.trim() || one.title)).map((one) => one.outerHTML)""")
    assert nameless == []


def test_messages_are_text_and_not_markup(opened, served):
    page = opened()
    page.get_by_label("Command for x").fill("<img src=x onerror=alert(1)>")
    page.keyboard.press("Enter")
    page.locator(".entry, .notice:visible").filter(has_text="<img").first.wait_for()
    assert page.locator("#conversation img, .notice img").count() == 0


def test_a_program_is_assembled_with_its_problems_in_place(opened):
    page = opened()
    page.get_by_role("tab", name="Editor").click()
    page.get_by_role("textbox", name="Program", exact=True).fill("E\nR 100\nR 900\nQ")
    page.locator(".problems li").first.wait_for()
    assert page.locator(".problems .place").first.text_content().startswith("3:")
    assert page.locator(".gutter-line").nth(2).get_attribute("class") == "gutter-line error"


def test_a_program_is_loaded_and_a_breakpoint_set_with_the_keyboard(opened, served, size):
    page = opened()
    last = f"S {size['height'] // 10}"  # the listing may still show the program of the other size
    page.get_by_role("tab", name="Editor").click()
    page.get_by_role("textbox", name="Program", exact=True).fill(f"E\nR 100\n{last}\nQ")
    page.get_by_role("button", name="Load").click()
    listing = page.get_by_role("listbox", name="Program of x")
    listing.get_by_role("option", name=last).wait_for()
    listing.focus()
    page.keyboard.press("Home")
    page.keyboard.press("Enter")
    page.locator(".listing-row[aria-selected=true]").wait_for()
    page.keyboard.press("Enter")
    page.locator(".listing-row[aria-selected=true]").wait_for(state="detached")


@pytest.mark.parametrize("script", ["", UNANSWERED], ids=["at rest", "while it waits"])
def test_a_page_that_was_cut_off_comes_back(opened, served, script):
    page = opened(script=script)
    control = served.server.ports[0]
    page.evaluate(CONNECTIONS)  # it is off for a quarter of a second
    served.do(lambda: [client.gone("") for client in list(control.clients)])
    page.wait_for_function("() => window.connections.includes('connection off')")
    page.locator("#connection.on").wait_for()
    before = page.locator(".clock").text_content()
    page.wait_for_function("text => document.querySelector('.clock').textContent !== text", arg=before)


WRONG_PLACES = [  # what is chosen, what is typed, the answer
    ("time", "500", "time 500 has no unit; write 500 ms or 500 s"),
    ("time", "next tuesday", "'next tuesday'; expected text with a unit such as"),
    ("time", "-5 ms", "'-5 ms': virtual time does not run backwards"),
    ("position", "", "Run to: write the position, such as 400"),
    ("position", "abc", "position abc: expected a whole number, such as 400"),
    ("position", "99999999", "position 99999999; allowed 0..65535"),
    ("address", "abc", "line abc: expected a whole number, such as 400"),
    ("address", "58", "line 58: no instruction begins there; "),  # whatever program another test has left
]


def test_an_invalid_position_to_run_to_is_answered_immediately(opened, served):
    page = opened()
    page.get_by_role("button", name="Pause", exact=True).click()
    page.get_by_role("button", name="Go", exact=True).first.wait_for()
    steps(page)
    before = served.do(lambda: served.bench.now_ps)
    for place, text, says in WRONG_PLACES:
        page.get_by_label("Run to", exact=True).select_option(place)
        page.get_by_label("Target of the run").fill(text)
        page.get_by_role("button", name="Run there").click()
        page.locator("[role=alert]").filter(has_text=says).first.wait_for(timeout=20_000)
    assert served.do(lambda: served.bench.now_ps) == before


def test_an_unreached_position_is_reported_with_the_cause_of_waiting(opened, served):
    page = opened()
    page.get_by_role("tab", name="Editor").click()
    page.get_by_role("textbox", name="Program", exact=True).fill("E\nD 65535\nD 65535\nS 200\nQ\nX\n")
    page.get_by_role("button", name="Run", exact=True).click()
    page.get_by_role("listbox", name="Program of x").get_by_role("option", name="6: S 200").wait_for()
    steps(page)
    page.get_by_label("Run to", exact=True).select_option("address")
    page.get_by_label("Target of the run").fill("6")
    page.get_by_role("button", name="Run there").click()
    page.locator(".stopped").filter(has_text="not within 60 s; x: ").wait_for(timeout=60_000)

"""What the built pages offer to eyes and hands: copy buttons, colours that can be read, our own icon."""

from __future__ import annotations

import re

import pytest

READABLE = 4.5  # the contrast that WCAG asks of text


@pytest.fixture
def page(browser):
    """A page of the browser, in which what is copied is kept."""
    page = browser.new_page()
    page.add_init_script("document.addEventListener('copy', () => { window.copied = document.activeElement.value; })")
    yield page
    page.close()


@pytest.mark.parametrize(
    ("name", "block", "copied"),
    [
        ("index", ".highlight-console", "make demo\n. .venv/bin/activate"),  # the prompts stay behind
        ("howto/gsc_programs", ".highlight-console", None),  # and so does what is printed
        ("howto/ramps", ".highlight-python", None),
    ],
)
def test_a_copy_button_copies_what_is_typed(built, page, name, block, copied):
    page.goto((built / f"{name}.html").as_uri())
    first = page.locator(block).first
    shown = first.locator("pre").inner_text()
    first.hover()
    first.locator("button.copybtn").click()
    page.wait_for_function("window.copied !== undefined")
    typed = "\n".join(re.findall(r"^\$ (.*)$", shown, re.MULTILINE)) or shown
    assert page.evaluate("window.copied").rstrip() == (copied or typed.rstrip())


def luminance(colour):
    """The relative luminance of a colour as CSS has it, by WCAG."""
    parts = (int(part) / 255 for part in re.findall(r"\d+", colour)[:3])
    red, green, blue = (part / 12.92 if part <= 0.04045 else ((part + 0.055) / 1.055) ** 2.4 for part in parts)
    return 0.2126 * red + 0.7152 * green + 0.0722 * blue


@pytest.mark.parametrize("scheme", ["light", "dark"])
def test_text_links_and_code_can_be_read_in_both_palettes(built, browser, scheme):
    page = browser.new_page(color_scheme=scheme)
    page.goto((built / "howto/serve.html").as_uri())
    ground = page.evaluate("getComputedStyle(document.body).backgroundColor")
    assert (luminance(ground) > 0.5) == (scheme == "light")
    for selector in ("article p", "article p a", "article h2", ".sidebar-tree a", "article pre span:not(:empty)"):
        element = page.locator(selector).first
        colour = element.evaluate("one => getComputedStyle(one).color")
        dark, bright = sorted((luminance(ground), luminance(colour)))
        assert (bright + 0.05) / (dark + 0.05) >= READABLE, f"{selector}: {colour} on {ground}"
    page.close()


def test_the_icon_is_the_one_of_the_panel(built):
    links = re.findall(r'<link rel="(?:shortcut )?icon" href="([^"]+)"', (built / "index.html").read_text("utf-8"))
    assert [(built / link.partition("?")[0]).name for link in links] == ["icon.svg"]
    assert b"<svg" in (built / links[0].partition("?")[0]).read_bytes()

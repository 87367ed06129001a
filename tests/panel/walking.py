"""What the walks through the page have in common: the command in a process of its own, and a page that is watched."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
import time
from contextlib import contextmanager
from urllib.parse import urlsplit

from tests.links.conftest import PATIENCE

COMMAND = [sys.executable, "-m", "slewline"]
TELLS = 'addEventListener("securitypolicyviolation", (event) => console.error("policy", event.violatedDirective));'
DESKTOP, PHONE = (1440, 900), (390, 844)
# What assistive technology is told of each control: its role and its name, as the browser works them out.
CONTROLS = ("button", "checkbox", "combobox", "listbox", "searchbox", "slider", "spinbutton", "tab", "textbox", "link")


CROWDED = "virtual time"  # what the command says of a machine that is too slow; other tests fill it


class Running:
    """The command, with the ports that it has told of, by name."""

    def __init__(self, *arguments, may_say=()):
        self.may_say = may_say
        self.process = subprocess.Popen(
            [*COMMAND, *map(str, arguments)],
            stdout=subprocess.PIPE,
            stderr=subprocess.PIPE,
            text=True,
            env=os.environ | {"PYTHONFAULTHANDLER": "1"},
        )
        self.ports = {}

    def port(self, name):
        """Return where a port is, as soon as the command tells of it."""
        while name not in self.ports:
            line = self.process.stdout.readline()
            assert line, self.process.stderr.read()
            told, _, where = line.strip().partition(": ")
            self.ports[told.partition(" ")[0]] = where
        return self.ports[name]

    def end(self):
        """End it as a user does; it has said nothing of errors."""
        self.process.send_signal(signal.SIGTERM)
        try:
            self.process.wait(PATIENCE)
        except subprocess.TimeoutExpired:
            self.process.send_signal(getattr(signal, "SIGABRT", signal.SIGTERM))  # it writes where it hangs
            raise AssertionError(self.process.stderr.read()) from None
        said = self.process.stderr.read().splitlines()
        wrong = [line for line in said if not any(text in line for text in (CROWDED, *self.may_say))]
        assert (self.process.returncode, wrong) == (0, []), "\n".join(said)

    def close(self):
        """Leave nothing behind, whatever has happened."""
        self.process.kill()
        self.process.wait()
        self.process.stdout.close()
        self.process.stderr.close()


@contextmanager
def running(*arguments, may_say=()):
    """Yield the command, and end it with a signal; lines with a text of `may_say` in them are no errors."""
    command = Running(*arguments, may_say=may_say)
    try:
        yield command
        command.end()
    finally:
        command.close()


class Walk:
    """A page, by what is seen on it; whatever goes wrong behind its back is kept in `wrong`.

    Args:
        browser: Chromium.
        url: as the command prints it.
        folder: of the pictures.
        size: of the screen.
        scheme: dark or light.
    """

    def __init__(self, browser, url, folder, size=DESKTOP, scheme="light"):
        self.folder, self.wrong = folder, []
        origin = urlsplit(url).netloc
        self.page = page = browser.new_page(
            viewport={"width": size[0], "height": size[1]}, color_scheme=scheme, has_touch=size == PHONE
        )
        page.set_default_timeout(PATIENCE * 1000)
        page.on("pageerror", lambda error: self.wrong.append(str(error)))
        page.on("console", lambda said: self.wrong.append(said.text) if said.type in ("error", "warning") else None)
        page.on("request", lambda asked: self.wrong.append(asked.url) if origin != urlsplit(asked.url).netloc else None)
        page.add_init_script(TELLS)
        page.goto(url)
        page.locator(".chip-card .figure").first.wait_for()
        page.locator(".clock:not(:empty)").wait_for()  # a card may be drawn before all else

    def button(self, name, within=None):
        """Return a button by its whole name."""
        return (within or self.page).get_by_role("button", name=name, exact=True)

    def card(self, chip):
        """Return the card of a chip."""
        return self.page.get_by_role("article", name=chip, exact=True)

    def part(self, name):
        """Return the card of a part of the machine."""
        return self.page.get_by_role("region", name=name)

    def pin(self, name, chip=None):
        """Return a pin of the package, by its name."""
        return (self.card(chip) if chip else self.page).locator(f".pin[aria-label*=' {name}, ']")

    def position(self, chip=None, axis=0):
        """Return the position that is shown."""
        text = (self.card(chip) if chip else self.page).locator(".axis-reading").nth(axis).locator(".figure").first
        return int(text.text_content().replace("\u2009", "").replace("\u2212", "-"))

    def seconds(self):
        """Return the time that is shown."""
        return float(self.page.locator(".clock").text_content().replace("\u2009", ""))

    def current(self):
        """Return the text of the instruction that the listing marks."""
        row = self.page.locator("[aria-current=step]")
        return row.locator(".text").text_content() if row.count() else ""

    def send(self, chip, *lines):
        """Type lines into the command line of a chip."""
        for line in lines:
            self.page.get_by_label(f"Command for {chip}").fill(line)
            self.page.keyboard.press("Enter")

    def tab_to(self, name, back=False):
        """Go to a control with the Tab key; within a package, with its arrows."""
        keys, focus = self.page.keyboard, "document.activeElement.getAttribute('aria-label') ?? ''"
        for _ in range(120):
            keys.press("Shift+Tab" if back else "Tab")
            if self.page.evaluate(focus) == name:
                return
            if name.startswith("pin") and self.page.evaluate("document.activeElement.classList.contains('pin')"):
                break
        else:
            raise AssertionError(f"the Tab key does not reach {name!r}")
        keys.press("Home")
        for _ in range(60):
            if self.page.evaluate(focus) == name:
                return
            keys.press("ArrowDown")
        raise AssertionError(f"the arrows do not reach {name!r}")

    def until(self, met, seconds=PATIENCE):
        """Wait until something is true on the page, which goes on meanwhile."""
        end = time.monotonic() + seconds
        while not met():
            if time.monotonic() > end:
                self.picture("given_up")
                raise AssertionError("it has not come; the picture given_up shows what there is instead")
            self.page.wait_for_timeout(100)

    def picture(self, name):
        """Keep a picture of all of the page, as high as it is, so that what lies below the fold is drawn too."""
        width = self.page.viewport_size["width"]
        before = self.page.viewport_size
        height = self.page.evaluate("document.documentElement.scrollHeight")
        self.page.set_viewport_size({"width": width, "height": min(height + 40, 6000)})
        self.page.wait_for_timeout(400)
        self.page.screenshot(path=self.folder / f"{name}.png")
        self.page.set_viewport_size(before)

    def names(self):
        """Return the role and the name of every control that is shown, as assistive technology has them."""
        client = self.page.context.new_cdp_session(self.page)
        nodes = client.send("Accessibility.getFullAXTree")["nodes"]
        client.detach()
        told = [(node["role"]["value"], node.get("name", {}).get("value", "")) for node in nodes if not node["ignored"]]
        return [(role, name) for role, name in told if role in CONTROLS]

    def close(self):
        """Close the page; nothing has gone wrong on it, and nothing is wider than the screen."""
        names = self.names()
        wide, screen = self.page.evaluate("document.documentElement.scrollWidth"), self.page.viewport_size["width"]
        self.page.close()
        assert self.wrong == []
        assert wide <= screen
        assert [role for role, name in names if not name.strip()] == []
        assert sorted({one for one in names if names.count(one) > 1}) == []

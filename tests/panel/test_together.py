"""A host program, a panel and a log at once: none of them loses a finding."""

from __future__ import annotations

import json
import threading

import pytest

from tests.links.conftest import PATIENCE, STRAPS, Client, Process

from .conftest import PanelProcess, ask

pytestmark = pytest.mark.system
WRONG = (b"HELLO", b"+100", b"po", b"R50", b"W", b"S 10")
COUNT = 120


@pytest.fixture
def module(tmp_path):
    """A served module with a log and a control port."""
    straps = [f"--strap={pin}={level}" for pin, level in STRAPS.items()]
    ports = ("--tcp", "127.0.0.1:0", "--control", "127.0.0.1:0")
    options = ("--rate", "20", "--log", tmp_path / "log", "--journal", tmp_path / "journal")
    process = Process("gs-c200s", *straps, *ports, *options, ports=2)
    process.log = tmp_path / "log"
    yield process
    process.end()


def test_nobody_loses_a_finding(module):
    panel = PanelProcess(module.ports["control"], token=None)
    host = Client(module.ports["gs_c200s"])
    seen, found = {}, []

    def watch(page):
        """Keep what a page is told, entry by entry, until all findings are there, and what the bench has of them."""
        for text in page:
            event = json.loads(text)
            for entry in event.get("entries", ()):
                seen[entry["number"]] = entry
            if event.get("id") == "end":
                found.extend(event["findings"])
            if found and sum("code" in entry for entry in seen.values()) >= len(found):
                return

    with panel.connect(token=panel.token) as page:
        assert "view" in ask(page, do="subscribe", every="33 ms")
        watcher = threading.Thread(target=watch, args=(page,))
        watcher.start()
        for number in range(COUNT):
            assert host.ask(WRONG[number % len(WRONG)] + b"\r") != b"Y\r"
        page.send(json.dumps({"do": "findings", "id": "end"}))
        watcher.join(PATIENCE)
    host.close()
    panel.close()
    entries = [(each["time_ps"], each["code"], each["text"]) for _, each in sorted(seen.items()) if "code" in each]
    assert len(found) == COUNT
    assert entries == [(each["time_ps"], each["code"], each["text"]) for each in found]
    assert sorted(seen) == list(range(len(seen)))  # no entry is left out
    module.end()
    logged = [line for line in module.log.read_text("ascii").splitlines() if " gs_c200s ! E" in line]
    assert len(logged) == COUNT

"""Modules to speak to: a URL in virtual time, whose bench a test can look into."""

from __future__ import annotations

from contextlib import ExitStack

import pytest

import slewline.testing  # noqa: F401  # pySerial knows slewline://
from slewline.chips import sheet_of
from slewline.modules.finding import find
from slewline.modules.module import Module
from slewline.modules.module_port import ModulePort
from slewline.modules.speech import speech_of
from tests.links.conftest import client, serve  # noqa: F401


def rarely(name, values, quick=()):
    """Parametrize by many values, of which a quick run takes these alone."""
    rows = [pytest.param(each, marks=[] if each in quick else [pytest.mark.long]) for each in values]
    return pytest.mark.parametrize(name, rows)


class Taken:
    """A transcript in lists."""

    def __init__(self):
        self.entries, self.notes = [], []

    def host(self, data, first_ns, last_ns=None):
        self.entries.append(("host", data))

    def module(self, data, first_ns, last_ns=None):
        self.entries.append(("module", data))

    def note(self, text):
        self.notes.append(text)

    @property
    def sent(self):
        return b"".join(data for who, data in self.entries if who == "host")


@pytest.fixture
def module():
    """Return a module behind a URL in virtual time, as the tools speak to it."""
    with ExitStack() as stack:

        def make(url, *, may_move=False, **speech):
            part = url.partition("?")[0]
            spoken = speech_of(sheet_of(part), **speech)
            port = stack.enter_context(ModulePort(f"slewline://{url}", spoken.setting))
            port.write(spoken.wake)
            return Module(port, spoken, Taken(), may_move=may_move)

        yield make


def chip_of(module):
    return module.port.line.chip


def noise(module, to="host"):
    """What spoils characters in one direction."""
    line = module.port.line.rig.line
    return line.to_host if to == "host" else line.to_chip


@pytest.fixture
def found():
    """Look for a module behind a URL in virtual time, as the commands do."""
    with ExitStack() as stack:

        def look(url, **given):
            x = find(f"slewline://{url}", sheet_of(url.partition("?")[0]), transcript=Taken(), **given)
            stack.enter_context(x.port)
            return x

        yield look


@pytest.fixture
def stores(tmp_path):
    """Return what keeps programs without power, by part, to be added to a URL: of a memory that is not all erased."""

    def made(part):
        if part.startswith("cy"):
            (tmp_path / "image").write_bytes(b"0\r")
        return (
            f"chs=0&store={tmp_path}/kept"
            if part.startswith("gs")
            else f"store={tmp_path}/kept&memory={tmp_path}/image"
        )

    return made

"""The command line called in this process, in an empty directory."""

from __future__ import annotations

import importlib.metadata
import json
from functools import cache
from pathlib import Path
from typing import Any, NamedTuple

import pytest

from slewline.cli.main import invoke


class Called(NamedTuple):
    """What a command line came to."""

    status: int
    out: str
    err: str

    @property
    def json(self) -> Any:
        return json.loads(self.out)


@pytest.fixture(autouse=True)
def folder(tmp_path, monkeypatch):
    """An empty directory, in which the command runs."""
    monkeypatch.chdir(tmp_path)
    return tmp_path


ENTRY_POINTS = cache(importlib.metadata.entry_points)


@pytest.fixture(autouse=True)
def installed(monkeypatch):
    """What is installed does not change here, and to look through it takes longer than most of these tests."""
    monkeypatch.setattr(importlib.metadata, "entry_points", ENTRY_POINTS)


@pytest.fixture
def call(capfd):
    """Call the command line."""

    def call(*arguments: str) -> Called:
        status = invoke(arguments)
        return Called(status, *capfd.readouterr())

    return call


@pytest.fixture
def write(folder):
    """Write a text file, a line an argument."""

    def write(path: str, *lines: str) -> str:
        Path(path).write_text("".join(f"{line}\n" for line in lines))
        return path

    return write


@pytest.fixture
def five(write):
    """A program that takes five steps; every register is set."""
    return write("five.cy525", "F 3", "R 100", "S 254", "Z 1", "A 0", "N 5", "G")


@pytest.fixture
def endless(write):
    """A program that shuttles between 0 and 4 for ever."""
    return write("endless.cy525", "F 3", "R 10", "S 255", "Z 1", "A 0", "E", "P 4", "P 0", "J 0", "QX")

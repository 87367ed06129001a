"""GTKWave reads our VCD files and their layouts."""

from __future__ import annotations

import re
import subprocess

import pytest

from .programs import find
from .waveform import read

pytestmark = pytest.mark.long
FAMILIES = ["cy525", "gsc", "mc1451a"]
SCRIPT = 'puts "shown [gtkwave::getDisplayedSignals]"\nexit\n'


@pytest.mark.parametrize("family", FAMILIES)
def test_its_reader_finds_the_same_changes(family, tmp_path, request):
    """Over FST and back: wires, reals and texts.  It writes 16 digits of a real; a double may need 17."""
    ours, fst, theirs = (tmp_path / name for name in ("ours.vcd", "a.fst", "theirs.vcd"))
    request.getfixturevalue(family).save_vcd(ours, values=True)
    subprocess.run([find("vcd2fst"), ours, fst], check=True, capture_output=True)
    subprocess.run([find("fst2vcd"), fst, "-o", theirs], check=True, capture_output=True)
    assert rounded(theirs) == rounded(ours)


def rounded(path):
    _, changes = read(path)
    return {name: [(at, same(value)) for at, value in seen] for name, seen in changes.items()}


def same(value):
    """A value as both write it: a space of a text is \\x20 in one file, \\040 in the other."""
    if isinstance(value, float):
        return f"{value:.16g}"
    return re.sub(r"\\x([0-9A-Fa-f]{2})|\\([0-7]{3})", unescaped, value) if isinstance(value, str) else value


def unescaped(match):
    return chr(int(match[1], 16) if match[1] else int(match[2], 8))


@pytest.mark.parametrize("family", FAMILIES)
def test_layout_shows_every_row_in_its_order(family, tmp_path, request):
    bench = request.getfixturevalue(family)
    bench.save_vcd(tmp_path / "a.vcd", values=True, layout=True)
    (tmp_path / "shown.tcl").write_text(SCRIPT)
    command = [find("xvfb-run"), "-a", find("gtkwave"), "-S", "shown.tcl", "a.gtkw"]
    ran = subprocess.run(command, check=True, capture_output=True, text=True, cwd=tmp_path, timeout=60)
    shown = next(line for line in ran.stdout.splitlines() if line.startswith("shown")).split()[1:]
    variables, _ = read(tmp_path / "a.vcd")
    assert sorted(shown) == sorted(variables)
    kinds = [variables[name][0].name for name in shown]
    first_pin = kinds.index("wire")
    assert set(kinds[:first_pin]) == {"string", "real"} and set(kinds[first_pin:]) == {"wire"}

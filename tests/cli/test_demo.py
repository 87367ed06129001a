"""slewline demo: the welding machine, what it prints and what it leaves behind."""

from __future__ import annotations

import os
import re
import shutil
import subprocess
import sys
from contextlib import chdir, redirect_stderr, redirect_stdout
from io import StringIO
from pathlib import Path
from types import SimpleNamespace

import pytest

import slewline
from slewline.chips.cy525.sheet import SHEET
from slewline.cli.demo import HERE, MACHINE, PROGRAM, called_as
from slewline.cli.main import invoke
from slewline.language.assemble import assemble

FILES = ["weld.cy525", "weld.gtkw", "weld.png", "weld.sucl", "weld.svg", "weld.toml", "weld.vcd"]


@pytest.fixture(scope="module")
def once(tmp_path_factory):
    """The demo, run once for all tests that look at what it leaves: where, and what it said."""
    place = tmp_path_factory.mktemp("demo")
    with chdir(place), redirect_stdout(StringIO()) as out, redirect_stderr(StringIO()) as err:
        status = invoke(["demo"])
    return place, SimpleNamespace(status=status, out=out.getvalue(), err=err.getvalue())


@pytest.fixture
def ran(once, folder):
    """What it said; its files are here, to be changed."""
    place, called = once
    shutil.copytree(place, folder, dirs_exist_ok=True)
    return called


def test_six_spots_on_each_of_two_workpieces(ran):
    assert (ran.status, ran.err) == (0, "")
    spots = re.findall(r"^ +([\d.]+) +(\d+) +spot (\d)", ran.out, re.MULTILINE)
    assert [int(position) for _, position, _ in spots] == [700 * n for n in range(6)] * 2
    assert [int(number) for *_, number in spots] == [1, 2, 3, 4, 5, 6] * 2
    times = [float(time) for time, *_ in spots]
    assert times == sorted(times)
    assert "12 spots, 16,800 steps, up to 5,978 steps/s; 6." in ran.out
    assert ran.out.index("workpiece 1 is in place") < ran.out.index("spot 6") < ran.out.index("workpiece 2 is in place")
    assert ran.out.index("workpiece 2 is in place") < ran.out.index("no other workpiece: the program ends")


def test_the_files_are_in_the_reported_place(ran):
    assert sorted(path.name for path in Path("build/demo").iterdir()) == FILES
    assert all(f"build/demo/{name} " in ran.out for name in FILES)
    assert Path("build/demo/weld.png").read_bytes().startswith(b"\x89PNG")
    svg = Path("build/demo/weld.svg").read_text()
    assert all(word in svg for word in ("R = 80", "F = 5", "S = 240", "N = 700", ">output<"))
    waveform = Path("build/demo/weld.vcd").read_text()
    assert "$scope module x" in waveform
    assert "$timescale 1 us" in waveform, "in nanoseconds PulseView would take a thousand times the samples"
    assert not re.search(r"\$var wire (?!1 )", waveform), "libsigrok, and with it PulseView, refuses a file with a bus"
    assert "x.velocity" in Path("build/demo/weld.gtkw").read_text()
    assert "variable_add x.velocity" in Path("build/demo/weld.sucl").read_text()


def test_the_machine_can_be_changed_and_run(ran, call):
    machine = Path("build/demo/weld.toml")
    machine.write_text(machine.read_text().replace("pieces = 2", "pieces = 3"))
    found = call("run", str(machine), "--json").json["chips"]["x"]
    assert (found["steps"]["count"], found["position"], found["findings"]) == (3 * 2 * 4200, 0, [])


@pytest.fixture
def shell(folder):
    """Call a line in a folder that has a .venv, as in a clone."""
    (folder / ".venv").symlink_to(sys.prefix)

    def shell(line, *path, **variables):
        environ = {name: value for name, value in os.environ.items() if not name.startswith("UV_")}
        environ |= {"PATH": os.pathsep.join([*path, "/usr/bin", "/bin"])} | variables
        return subprocess.run(line, shell=True, env=environ, capture_output=True, text=True, check=False)

    return shell


@pytest.mark.posix  # a link to a folder; elsewhere it takes a right that few have
@pytest.mark.check
def test_its_last_lines_can_be_typed(shell):
    *_, run, panel = shell(".venv/bin/python -m slewline demo").stdout.splitlines()
    typed = run.partition(", then: ")[2]
    assert typed == ".venv/bin/slewline run build/demo/weld.toml"
    assert panel.endswith(": .venv/bin/slewline panel build/demo/weld.toml")
    again = shell(typed)
    assert (again.returncode, again.stderr) == (0, "")
    assert "0 findings" in again.stdout


@pytest.fixture
def script(folder, monkeypatch):
    """The script of an environment in a folder, which is the current one; it is not on the PATH."""

    def script(place):
        path = folder / place / "slewline"
        path.parent.mkdir(parents=True)
        monkeypatch.setenv("PATH", "")
        monkeypatch.delenv("UV_RUN_RECURSION_DEPTH", raising=False)
        monkeypatch.setattr("sysconfig.get_path", lambda _: str(path.parent))
        return path

    return script


def test_the_bare_name_is_shown_only_where_the_next_shell_finds_it(script, monkeypatch):
    path = script(".venv/bin")
    path.touch(0o755)
    assert called_as() == str(Path(".venv/bin/slewline"))
    monkeypatch.setenv("PATH", str(path.parent))  # an activated environment
    assert called_as() == "slewline"
    monkeypatch.setenv("UV_RUN_RECURSION_DEPTH", "1")
    assert called_as() == str(Path(".venv/bin/slewline"))


def test_elsewhere_it_names_the_whole_path_as_one_word(script, folder, monkeypatch):
    path = script("a b")
    (folder / "here").mkdir()
    monkeypatch.chdir(folder / "here")
    for python, word in (("/usr/bin/python3", "/usr/bin/python3"), ("/a b/python3", '"/a b/python3"')):
        monkeypatch.setattr(sys, "executable", python)
        assert called_as() == f"{word} -m slewline"
    path.touch(0o755)
    assert called_as() == f'"{path}"'


def test_another_folder(call, monkeypatch):
    monkeypatch.setattr(slewline.Bench, "plot", lambda _, path, *__, **___: Path(path).touch())  # seen above
    assert call("demo", "--output", "here/and there").status == 0
    assert sorted(path.name for path in Path("here/and there").iterdir()) == FILES


@pytest.mark.parametrize("name", FILES)
def test_a_link_in_the_place_of_a_file_is_not_followed(call, name):
    Path("here").mkdir()
    Path("here", name).symlink_to("../victim")
    ran = call("demo", "--output", "here")
    assert (
        ran.status == 2
        and f"{name} is a symbolic link, which is not followed here; move it away, or use another folder" in ran.err
    )
    assert not Path("victim").exists()
    assert [path.name for path in Path("here").iterdir()] == [name]


def test_the_program_is_the_one_of_the_manual_with_other_numbers(call):
    stored = assemble((HERE / PROGRAM).read_text(), SHEET).stored
    assert len(stored) == 20
    assert (stored[0:2] + stored[5:6] + stored[9:12] + stored[14:15]).decode() == "W+BCGLP"
    ran = call("lint", str(HERE / PROGRAM), "--strict")
    assert ran.out.endswith("no problems found\n")
    assert f'file = "{PROGRAM}"' in (HERE / MACHINE).read_text()

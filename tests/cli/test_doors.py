"""Small doors: `python -m slewline`, examples, completion by the shell, NO_COLOR, names that are nearly right."""

from __future__ import annotations

import os
import shlex
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

import slewline
from slewline.bench.files import shipped_files as module
from slewline.cli.main import invoke
from slewline.cli.version_line import version_line
from slewline.core.messages.near import hint

ROOT = Path(__file__).parents[2]
EXAMPLES = ROOT / "examples"
LESSONS = ROOT / "docs/lessons"
SLEWLINE = Path(sys.executable).with_name("slewline")


@pytest.mark.real("process")
def test_the_script_is_the_command(call, write):
    program = write("p.cy525", "R 200")
    ran = subprocess.run([SLEWLINE, "lint", program], capture_output=True, text=True, check=False)
    assert (ran.returncode, ran.stdout, ran.stderr) == call("lint", program)
    assert ran.returncode == 1 and "RATE 200: allowed 0..127" in ran.stdout


@pytest.mark.system
def test_the_module_is_the_command():
    ran = subprocess.run([sys.executable, "-m", "slewline", "chps"], capture_output=True, text=True, check=False)
    assert ran.returncode == 2 and ran.stderr.startswith("Usage: slewline [OPTIONS]")
    ran = subprocess.run([sys.executable, "-m", "slewline", "--version"], capture_output=True, text=True, check=True)
    assert ran.stdout == f"{version_line()}\n"


# ------------------------------------------------------------------------------------------------------------ examples
def test_every_example_is_listed_with_its_description(call):
    out = call("examples").out.split("\n\n")[0].splitlines()
    there = {path.relative_to(EXAMPLES).as_posix() for path in EXAMPLES.rglob("*") if path.is_file()}
    there |= {f"lessons/{path.name}" for path in LESSONS.glob("*.ipynb")}
    listed = [line.split(maxsplit=1) for line in out]
    assert {row[0] for row in listed} == {place for place in there if not place.endswith((".out", ".pyc"))}
    assert all(len(row) == 2 and len(row[1]) > 12 for row in listed)


@pytest.mark.parametrize(
    ("name", "written"),
    [
        ("closed_loop", ["closed_loop.py"]),
        ("uart.py", ["uart.py"]),
        ("weld", ["programs/weld.cy525"]),
        ("programs/weld.cy525", ["programs/weld.cy525"]),
        ("programs\\weld.cy525", ["programs/weld.cy525"]),
        ("looped", [f"drill/{name}" for name in sorted(os.listdir(EXAMPLES / "drill"))]),
        ("drill/", [f"drill/{name}" for name in sorted(os.listdir(EXAMPLES / "drill"))]),
        ("4_resonance", ["lessons/4_resonance.ipynb"]),
        ("lessons", [f"lessons/{path.name}" for path in sorted(LESSONS.glob("*.ipynb"))]),
    ],
)
def test_an_example_is_copied_out(call, name, written):
    for _ in range(2):  # the same file may be there
        ran = call("examples", name, "-o", "here")
        assert (ran.status, ran.out) == (0, "".join(f"wrote {Path('here', place)}\n" for place in written))
    for place in written:
        kept = EXAMPLES / place if (EXAMPLES / place).exists() else LESSONS / Path(place).name
        assert Path("here", place).read_bytes() == kept.read_bytes()


def test_an_example_that_was_copied_out_runs(call):
    call("examples", "as_printed")
    assert call("run", "drill/as_printed.toml", "-q").status == 0


def test_another_file_is_not_overwritten(call):
    Path("drill").mkdir()
    Path("drill/looped.toml").write_text("mine")
    ran = call("examples", "drill")
    assert ran.status == 2 and "this file exists and differs; give another folder with --output" in ran.err
    assert os.listdir("drill") == ["looped.toml"] and Path("drill/looped.toml").read_text() == "mine"


@pytest.mark.parametrize("same", [True, False])
def test_a_link_in_the_place_of_an_example_is_not_followed(call, same):
    Path("drill").mkdir()
    Path("victim").write_bytes((EXAMPLES / "drill/looped.toml").read_bytes() if same else b"")
    Path("drill/looped.toml").symlink_to("../victim")
    before = Path("victim").stat()
    ran = call("examples", "drill")
    assert ran.status == 2 and "this file exists and differs" in ran.err
    assert os.listdir("drill") == ["looped.toml"] and Path("victim").stat() == before


def test_an_unknown_example_is_reported_with_the_nearest(call):
    ran = call("examples", "hand_of")
    assert (ran.status, ran.err) == (
        2,
        "slewline: no example 'hand_of'; `slewline examples` lists them; did you mean handoff?\n",
    )


@pytest.mark.parametrize("place", [".ipynb_checkpoints/1_ramps-checkpoint.ipynb", "drill/looped.out", "index.md"])
def test_files_next_to_the_examples_are_left_out(tmp_path, monkeypatch, place):
    for each in ("drill/looped.toml", "1_ramps.ipynb", place):
        (tmp_path / each).parent.mkdir(exist_ok=True)
        (tmp_path / each).touch()
    monkeypatch.setitem(module.SOUGHT, "examples", ({"": tmp_path},))
    assert [*module.named()] == ["1_ramps.ipynb", "drill/looped.toml"]


def test_a_package_without_examples_reports_it(call, monkeypatch):
    monkeypatch.setitem(module.SOUGHT, "examples", ())
    assert "no examples are installed" in call("examples").err


def test_the_wheel_brings_them():
    """What is built is told in one place; the wheel itself is made and tried where a network is."""
    import tomllib

    wheel = tomllib.loads((ROOT / "pyproject.toml").read_text("utf-8"))["tool"]["hatch"]["build"]["targets"]["wheel"]
    lessons = {f"docs/lessons/{path.name}" for path in LESSONS.glob("*.ipynb")}
    assert wheel["force-include"] == {name: f"slewline/{name}" for name in module.SOUGHT} | {
        lesson: f"slewline/examples/lessons/{Path(lesson).name}" for lesson in lessons
    }
    assert all(sought[0][""] == module.PACKAGE / name for name, sought in module.SOUGHT.items())


# ---------------------------------------------------------------------------------------------------------- completion
def completed(line, capsys, monkeypatch):
    """What click's script for bash is told: the words, and those that a file may follow."""
    words = line.split(" ")
    monkeypatch.setenv("_SLEWLINE_COMPLETE", "bash_complete")
    monkeypatch.setenv("COMP_WORDS", line)
    monkeypatch.setenv("COMP_CWORD", str(len(words) - 1))
    with pytest.raises(SystemExit):
        sys.exit(invoke([]))
    return [row.partition(",")[2] for row in capsys.readouterr().out.splitlines() if row]


COMPLETED = [
    ("slewline serve gs", ["gs-c200", "gs-c200s"]),
    ("slewline describe MC11", ["mc1151a", "mc1151a-e"]),
    ("slewline run x.cy525 --chip cy52", ["cy525"]),
    ("slewline serve gs-c200s --strap ch", ["chs=0", "chs=1"]),
    ("slewline serve gs-c200s --option eeprom_t", ["eeprom_time="]),
    ("slewline run x.cy525 --drive ab", ["abort=0", "abort=1"]),
    ("slewline run x.cy525 --pins pulse,dire", ["pulse,direction"]),
    ("slewline run x --chip cy525 --pins sl", ["slew"]),
    ("slewline describe mc1451a set_vel", ["SET_VEL"]),
    ("slewline ramp gs-c200 la", ["law="]),
    ("slewline examples hand", ["handoff.py"]),
    ("slewline examples dri", ["drill", "drilling_machine.py", "drill/as_printed.toml"]),
    ("slewline serve none:X --strap a", []),
    ("slewline run x.txt --pins a", []),
]


def test_names_are_completed(capsys, monkeypatch, subtests):
    for line, words in COMPLETED:
        with subtests.test(line=line, words=words):
            found = completed(line, capsys, monkeypatch)
            assert found[: len(words)] == words and (words or not found)


@pytest.mark.parametrize("line", ["run x", "lint a", "serve --bench b", "run x.cy525 --vcd o", "compare a"])
def test_files_are_left_to_the_shell(line, capsys, monkeypatch):
    assert completed(f"slewline {line}", capsys, monkeypatch) == [line.split()[-1]]


def shell(program, script):
    """What a shell prints, with slewline among its programs."""
    if shutil.which(program) is None:
        pytest.skip(f"no {program} here")
    path = f"{SLEWLINE.parent}{os.pathsep}{os.environ['PATH']}"
    command = [program, "-c", script]
    ran = subprocess.run(command, env={**os.environ, "PATH": path}, capture_output=True, text=True, check=False)
    return ran.stdout


@pytest.mark.system
@pytest.mark.posix
@pytest.mark.parametrize(
    "source",
    [
        'eval "$(_SLEWLINE_COMPLETE=bash_source slewline)"',
        f". {shlex.quote(str(ROOT / 'share/bash-completion/completions/slewline'))}",
    ],
)
def test_bash_itself_completes(source):
    found = shell(
        "bash",
        f"""
{source}
COMP_WORDS=(slewline serve gs-c200s --strap ch) COMP_CWORD=4
_slewline_completion slewline ch --strap 2>/dev/null
printf '%s\\n' "${{COMPREPLY[@]}}"
""",
    )
    assert found.split() == ["chs=0", "chs=1"]


@pytest.mark.system
@pytest.mark.posix
def test_fish_itself_completes():
    script = shlex.quote(str(ROOT / "share/fish/vendor_completions.d/slewline.fish"))
    found = shell("fish", f"source {script}; complete -C 'slewline serve gs-c200s --strap ch'")
    assert [line.split()[0] for line in found.splitlines()] == ["chs=0", "chs=1"]


# -------------------------------------------------------------------------------------------------------------- colour
def on_a_terminal(*arguments, **environment):
    """What the command writes to a terminal."""
    ours, theirs = os.openpty()
    process = subprocess.Popen([SLEWLINE, *arguments], stdout=theirs, env=os.environ | {"TERM": "xterm"} | environment)
    os.close(theirs)
    found = b""
    try:
        while data := os.read(ours, 4096):
            found += data
    except OSError:  # Linux tells the end so
        pass
    os.close(ours)
    assert process.wait(30) == 0
    return found


@pytest.mark.system
@pytest.mark.posix
def test_no_color_is_obeyed(five):
    arguments = ("run", five)
    assert b"\033[" in on_a_terminal(*arguments)
    assert b"\033[" in on_a_terminal(*arguments, NO_COLOR="")  # empty means nothing, as no-color.org has it
    assert b"\033[" not in on_a_terminal(*arguments, NO_COLOR="1")


# ------------------------------------------------------------------------------------------------------- nearest names
def test_the_nearest_name_keeps_its_case():
    assert hint("pulze", ["slew", "pulse"]) == "; did you mean pulse?"
    assert hint("set_vle", ["SET_VEL", "GET_VEL"]) == "; did you mean SET_VEL?"
    assert hint("quite else", ["slew", "pulse"]) == hint("x", []) == ""
    assert hint(1451, ["m1451"]) == "; did you mean m1451?"


def bench():
    made = slewline.Bench()
    made.add("cy525", name="x")
    made.record()
    return made


@pytest.mark.parametrize(
    ("ask", "meant"),
    [
        (lambda bench: bench["x"].pin("pulze"), "pulse"),
        (lambda bench: bench["X"], "x"),
        (lambda bench: bench.add("cy52"), "cy525"),
        (lambda bench: bench.add("cy525", rampunit=1), "ramp_unit"),
        (lambda bench: bench.plot("x.svg", axes="xx"), "x"),
        (lambda bench: bench.check_timing(["X"]), "x"),
        (lambda bench: slewline.ramp("cy525", ramp_unot=3), "ramp_unit"),
    ],
)
def test_a_name_that_is_nearly_right_is_met_by_the_right_one(ask, meant):
    with pytest.raises(slewline.SlewlineError, match=rf"; did you mean {meant}\?$"):
        ask(bench())


@pytest.mark.parametrize(
    ("words", "meant"),
    [
        (("rnu", "x.cy525"), "'run'"),
        (("chips", "--jsn"), "'--json'"),
        (("serve", "gs-c20s", "--tcp", "127.0.0.1:0"), "gs-c200s"),
        (("serve", "gs-c200s", "--strap", "cs=1", "--tcp", "127.0.0.1:0"), "chs"),
        (("serve", "gs-c200s", "--option", "eprom_time=1", "--tcp", "127.0.0.1:0"), "eeprom_time"),
        (("describe", "gs-c200s", "ACTIVAT"), "ACTIVATE"),
    ],
)
def test_the_command_line_names_the_nearest(call, words, meant):
    ran = call(*words)
    assert ran.status == 2 and f"id you mean {meant}?" in ran.err

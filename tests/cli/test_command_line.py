"""The command line as such: what it loads, how it ends, and what it says to bad input."""

from __future__ import annotations

import os
import shlex
import subprocess
import sys
import tomllib
from importlib.machinery import EXTENSION_SUFFIXES
from pathlib import Path
from types import SimpleNamespace

import click
import pytest

import slewline
from slewline import folders
from slewline.cli.commands import cli
from slewline.cli.options.command_kinds import EXAMPLES
from slewline.cli.version_line import build, is_compiled
from slewline.core.time import kernel
from slewline.extras import EXTRAS

ROOT = Path(__file__).parents[2]
COMMANDS = ("chips", "run", "asm", "dis", "lint", "describe", "ramp", "calibrate", "serve", "demo", "examples")
PYTHON = [sys.executable, "-W", "error", "-c"]


def python(code, *arguments, **options):
    """Run Python code in a process of its own, with `invoke` at hand."""
    code = f"import sys; from slewline.cli.main import invoke; {code}"
    return subprocess.run([*PYTHON, code, *arguments], check=False, capture_output=True, text=True, **options)


def loaded_by(arguments):
    """The modules that a command line loads."""
    ran = python(f"assert invoke({arguments!r}) == 0; print(*sys.modules, file=sys.stderr)")
    assert ran.returncode == 0, ran.stderr
    return set(ran.stderr.split())


@pytest.mark.system
def test_help_loads_click_and_nothing_heavy():
    loaded = loaded_by(["--help"])
    assert "click" in loaded
    assert not loaded & {"numpy", "rich", "matplotlib", "msgspec", "slewline.bench", "slewline.core.time.kernel"}


LIGHT = [
    ["run", "--help"],
    ["demo", "--help"],
    ["chips"],
    ["describe", "cy525", "G"],
    ["ramp", "cy525", "F=3", "R=9", "S=200"],
]


@pytest.mark.system
@pytest.mark.parametrize("arguments", LIGHT)
def test_commands_without_arrays_load_no_array_library(arguments):
    assert not loaded_by(arguments) & {"numpy", "rich", "matplotlib"}


def test_every_command_has_help_that_describes_its_exit(call):
    shown = call("--help")
    for command in COMMANDS:
        assert f"\n  {command} " in shown.out
        help_ = call(command, "--help")
        assert (help_.status, help_.err) == (0, "")
        assert "Exit status: 0 success, 1 a problem" in " ".join(help_.out.split())


def test_the_help_of_run_holds_the_guide_to_scripts(call):
    from slewline.bench.scripts import script

    assert script.__doc__ in call("run", "--help").out


def test_version(call):
    assert call("--version").out == f"slewline, version {slewline.__version__} ({build()})\n"


def test_the_build_is_recognised_by_the_file_that_the_kernel_is_loaded_from():
    of = SimpleNamespace(__file__="/lib/slewline/core/time/kernel.py")
    assert not is_compiled(of)
    of.__file__ = f"/lib/slewline/core/time/kernel{EXTENSION_SUFFIXES[0]}"
    assert is_compiled(of)
    assert build() == ("plain Python", "compiled core")[is_compiled(kernel)]


@pytest.fixture
def lacks(monkeypatch):
    """Take packages away, as where they were never installed; what has imported them is loaded anew."""

    def lacks(*names, anew=()):
        for name in names:
            monkeypatch.setitem(sys.modules, name, None)
        for name in {"slewline.cli.commands", *anew} & {*sys.modules}:
            package, _, module = name.rpartition(".")
            monkeypatch.delitem(sys.modules, name)
            monkeypatch.delattr(sys.modules[package], module)

    return lacks


def test_without_click_the_message_names_the_package_to_install(call, lacks):
    lacks("click")
    assert call("chips") == (2, "", "slewline: the command line needs click: pip install click\n")


def test_without_rich_the_same(call, lacks, monkeypatch):
    lacks("rich.console")
    monkeypatch.setattr("sys.stdout.isatty", lambda: True)
    says = "slewline: the command line needs click and rich: pip install click rich\n"
    assert call("describe", "cy525", "A") == (2, "", says)


def test_users_without_one_extra_get_a_list_of_all_that_are_missing(call, lacks):
    lacks("click", "rich", "msgspec", "matplotlib", "serial")
    ran = call("demo")
    assert (ran.status, ran.err) == (
        2,
        "slewline: the command line needs click and rich: pip install click rich; also missing: msgspec (files), "
        "matplotlib (plot), pyserial (serial); everything together: "
        "pip install click rich msgspec matplotlib pyserial\n",
    )


LACKING = {  # packages that a process lacks from its beginning: the command
    "click": "chips",
    "click rich msgspec matplotlib serial": "demo",
    "rich.console": "describe cy525 A",
    "msgspec": "run five.cy525",
}


@pytest.mark.system
@pytest.mark.parametrize(("names", "line"), LACKING.items(), ids=LACKING)
def test_nothing_else_requires_the_missing_packages(call, five, lacks, names, line):
    code = f"sys.modules |= dict.fromkeys({names.split()!r}); sys.stdout.isatty = lambda: {'rich' in names};"
    ran = python(f"{code} sys.exit(invoke({line.split()!r}))")
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr("sys.stdout.isatty", lambda: "rich" in names)
        lacks(*names.split())
        assert (ran.returncode, ran.stdout, ran.stderr) == call(*line.split())


def test_the_extras_are_those_of_the_package():
    declared = tomllib.loads((ROOT / "pyproject.toml").read_text("utf-8"))["project"]["optional-dependencies"]
    ours = {extra: [name for name, _ in rows] for extra, rows in EXTRAS.items()}
    own = {extra: [name for name in declared[extra] if not name.startswith("slewline[")] for extra in ours}
    assert own == ours
    assert declared["all"] == [f"slewline[{','.join(ours)}]"]


def test_without_msgspec_programs_run_and_bench_files_say_what_to_install(call, five, write, lacks):
    write("bench.toml", "[[chip]]", 'part = "cy525"')
    lacks("msgspec", anew=("slewline.bench.file", "slewline.bench.files.tables"))
    assert call("run", five).status == 0
    ran = call("run", "bench.toml")
    assert (ran.status, ran.err) == (2, "slewline: bench files need msgspec: pip install msgspec\n")


@pytest.mark.system
@pytest.mark.parametrize(("encoding", "shown"), [("utf-8", "375 µs"), ("cp1252", "375 µs"), ("cp866", "375 us")])
def test_where_an_encoding_has_no_micro_its_output_has_a_u(encoding, shown):
    code = "import sys; from slewline.cli.main import main; sys.argv[1:] = ['describe', 'cy525', 'A']; main()"
    environment = os.environ | {"PYTHONIOENCODING": encoding}
    ran = subprocess.run([*PYTHON, code], check=False, capture_output=True, encoding=encoding, env=environment)
    assert (ran.returncode, ran.stderr) == (0, "")
    assert shown in ran.stdout


# ------------------------------------------------------------------------------------------------------- closed outputs
@pytest.mark.system
def test_a_closed_pipe_ends_the_run_quietly_and_leaves_no_file(endless, folder):
    reader, writer = os.pipe()
    os.close(reader)
    command = "import sys; from slewline.cli.main import main; main()"
    arguments = ["run", endless, "--until", "1 s", "--vcd", "x.vcd", "--journal", "j"]
    ran = subprocess.run([*PYTHON, command, *arguments], stdout=writer, stderr=subprocess.PIPE, text=True, check=False)
    os.close(writer)
    assert (ran.returncode, ran.stderr) == (1, "")
    assert [path.name for path in folder.iterdir()] == [endless]


@pytest.mark.system
@pytest.mark.skipif(not Path("/dev/full").exists(), reason="needs /dev/full")
def test_a_full_disk_at_the_standard_output(five):
    command = "import sys; from slewline.cli.main import main; main()"
    with open("/dev/full", "w") as full:
        ran = subprocess.run(
            [*PYTHON, command, "run", five], stdout=full, stderr=subprocess.PIPE, text=True, check=False
        )
    assert (ran.returncode, ran.stderr) == (1, "slewline: output: No space left on device\n")


@pytest.mark.system
@pytest.mark.parametrize("module", ["click", "slewline.cli.commands", "slewline.errors"])
def test_interrupts_while_modules_are_loaded_are_reported_without_traceback(module):
    code = f"""
import signal, sys

class Finder:
    def find_spec(self, name, path=None, target=None):
        if name == {module!r}:
            signal.raise_signal(signal.SIGINT)
            signal.raise_signal(signal.SIGINT)

sys.meta_path.insert(0, Finder())
from slewline.cli.main import main
main()
"""
    ran = subprocess.run([sys.executable, "-c", code, "--version"], check=False, capture_output=True, text=True)
    assert (ran.returncode, ran.stdout, ran.stderr) == (
        1,
        "",
        "slewline: interrupted; unfinished files are unchanged\n",
    )


@pytest.mark.system
@pytest.mark.parametrize("at", ["before", "behind"])
def test_an_interrupt_outside_the_command_shows_no_traceback(at):
    code = f"""
import signal, sys
from slewline.cli import main

def invoke(arguments, invoke=main.invoke):
    if {at!r} == "behind":
        invoke(arguments)
    signal.raise_signal(signal.SIGINT)

main.invoke = invoke
main.main()
"""
    ran = subprocess.run([sys.executable, "-c", code, "--version"], check=False, capture_output=True, text=True)
    assert (ran.returncode, ran.stderr) == (1, "slewline: interrupted; unfinished files are unchanged\n")


@pytest.mark.system
def test_an_interrupt_when_all_is_done_changes_nothing():
    code = """
import atexit, signal
from slewline.cli.main import main

atexit.register(signal.raise_signal, signal.SIGINT)
main()
"""
    ran = subprocess.run([sys.executable, "-c", code, "--version"], check=False, capture_output=True, text=True)
    assert (ran.returncode, ran.stderr) == (0, "")


def test_an_interrupt_leaves_no_file(call, five, folder, monkeypatch):
    def interrupt(bench, _timeout):
        bench.run("1 ms")
        raise KeyboardInterrupt

    monkeypatch.setattr(slewline.Bench, "run_until_idle", interrupt)
    ran = call("run", five, "--journal", "j", "--vcd", "x.vcd", "--json", "x.json")
    assert (ran.status, ran.err.split("\n")[-2]) == (
        1,
        "slewline: interrupted; unfinished files are unchanged",
    )
    assert [path.name for path in folder.iterdir()] == [five]


# ------------------------------------------------------------------------------------------------------------ bad input
BAD_FILES = {
    "empty.cy525": b"",
    "comment.cy525": b"; nothing else\n\n",
    "garbage.cy525": bytes(range(128, 256)) * 20,
    "zeros.cy525": b"A 0\nR 20\0\n",
    "long.cy525": b"A 0\n" + b"9" * 1_000_000,
    "umlaut.cy525": "A 0\n  R \u00e4\n".encode(),
    "directive.cy525": b"A 0\n @wiat 20 ms\n",
    "good.cy525": b"A 0\nN 5\nG\n",
    "good.txt": b"A 0\n",
    "odd.hex": b"43 00\n4\n",
    "big.hex": b"43 " * 61,
}
BAD = {  # what is called: (exit status, what the message holds: place, and remedy)
    "run missing.cy525": (2, "missing.cy525 cannot be read: No such file"),
    "run .": (2, ". is a directory; give a regular file"),
    "run empty.cy525": (2, "empty.cy525 has no commands; write one command per line, such as R 100"),
    "run comment.cy525": (2, "comment.cy525 has no commands"),
    "run garbage.cy525": (
        2,
        "garbage.cy525: byte 80 in line 1 is not UTF-8 text; save it as UTF-8, or name the right file",
    ),
    "run zeros.cy525": (2, "zeros.cy525: contains NUL bytes"),
    "run long.cy525": (2, "long.cy525, line 2: 1000000 characters; allowed up to 1000"),
    "run umlaut.cy525": (
        2,
        "umlaut.cy525, line 2, column 3: '\u00e4' at character 3 is not printable ASCII; @bytes",
    ),
    "run directive.cy525": (2, "directive.cy525, line 2, column 2: no directive @wiat; available: @wait @until"),
    "run good.txt": (2, "good.txt: no chip given; give --chip cy525, or a file name ending in .cy525"),
    "run good.txt --chip|cy999": (2, "no chip 'cy999'; available: cy525"),
    "run good.cy525 --chip|cy999": (2, "no chip 'cy999'; available: cy525"),
    "run odd.hex --chip|cy525": (2, "odd.hex, line 2, column 1: '4': bytes are pairs of hexadecimal digits"),
    "run good.cy525 --crystal|99 MHz": (2, "crystal '99 MHz': CY525 takes 1 to 11 MHz"),
    "run good.cy525 --crystal|fast": (2, "'--crystal': frequency 'fast': expected a number and a unit"),
    "run good.cy525 --until|-3 s": (2, "'--until': time '-3 s': virtual time does not run backwards; give 0 or more"),
    "run good.cy525 --until|0.5": (2, "'--until': time '0.5': expected a number and a unit (ps, ns, us"),
    "run good.cy525 --timeout|3 parsecs": (2, "'--timeout': time '3 parsecs': expected a number and a unit"),
    "run good.cy525 --drive|abort": (2, "'--drive': 'abort': give pin, level and instant, such as 'abort=0@12 ms'"),
    "run good.cy525 --drive|abort=2": (
        2,
        "'--drive': 'abort=2': '2' is not a level; levels are 0 (low) and 1 (high), such as 'abort=0'",
    ),
    "run good.cy525 --drive|abort=0@-1 s": (2, "'--drive': time '-1 s': virtual time does not run backwards"),
    "run good.cy525 --drive|bell=0": (2, "has no pin 'bell'; its pins: io_request"),
    "run good.cy525 --vcd|.": (2, ". is a directory"),
    "run good.cy525 --vcd|no/x.vcd": (2, "no/x.vcd: there is no directory 'no'"),
    "run good.cy525 --journal|good.txt/x": (2, "good.txt/x: "),
    "run good.cy525 --plot|x.txt": (2, "x.txt: give a name that ends in .svg, .png or .pdf"),
    "run good.cy525 --json|x --steps|./x": (2, "./x: this command already uses the file"),
    "run good.cy525 --json|good.cy525": (2, "good.cy525: this command already uses the file"),
    "run": (2, "give exactly one of these: a program, a bench file, --replay JOURNAL"),
    "run good.cy525 --replay|good.txt": (2, "give exactly one of these: a program, a bench file, --replay"),
    "run --replay|good.txt": (2, "journal good.txt, line 1: not a journal entry"),
    "run --replay|missing": (2, "journal missing cannot be read: No such file"),
    "run --replay|good.txt --timeout|1 s": (2, "--replay repeats a run unchanged; leave out --timeout"),
    "run good.cy525 --jason": (2, "No such option '--jason'"),
    "asm missing.cy525": (2, "missing.cy525 cannot be read"),
    "asm umlaut.cy525": (1, "umlaut.cy525, line 2, column 5: RATE \u00e4: allowed 0..127 (CY525 manual, T.V)"),
    "asm good.cy525 --output|.": (2, ". is a directory"),
    "asm good.cy525 --output|good.cy525": (2, "good.cy525: this command already uses the file"),
    "dis missing.hex --chip|cy525": (2, "missing.hex cannot be read"),
    "dis odd.hex --chip|cy525": (2, "odd.hex, line 2, column 1: '4': bytes are pairs of hexadecimal digits"),
    "dis big.hex --chip|cy525": (2, "big.hex: 61 bytes; the program buffer has 60; for host data, give --stream"),
    "dis empty.cy525": (2, "empty.cy525 is empty"),
    "lint missing.cy525": (2, "missing.cy525 cannot be read"),
    "lint long.cy525": (2, "long.cy525, line 2: 1000000 characters"),
    "lint": (2, "Missing argument 'FILE...'"),
    "describe cy999": (2, "no chip 'cy999'; available: cy525"),
    "describe cy525 K": (2, "cy525 has no command 'K'; it has A (ABSOLUTE)"),
    "demo --output|good.txt": (
        2,
        "good.txt: cannot create this folder (File exists); give another folder with --output",
    ),
    "frobnicate": (2, "No such command 'frobnicate'"),
    "chips extra": (2, "unexpected extra argument (extra)"),
}


def test_bad_input_gets_a_message_with_place_and_remedy(call, folder, subtests):
    for name, data in BAD_FILES.items():
        (folder / name).write_bytes(data)
    for line, (status, message) in BAD.items():
        with subtests.test(line):
            ran = call(*(word for part in line.split(" --") for word in split(part, line)))
            assert (ran.status, ran.out) == (status, "")
            assert message in ran.err
            assert "Traceback" not in ran.err and len(ran.err) < 1500
            assert {path.name: path.read_bytes() for path in folder.iterdir()} == BAD_FILES


def split(part, line):
    """The words of "run good.cy525", and of "drive|abort=0@12 ms", which lost its dashes."""
    if line.startswith(part):
        return part.split()
    name, *value = part.split("|")
    return [f"--{name}", *value]


@pytest.mark.system
def test_refused_lines_leave_no_warning_of_the_interpreter(five):
    ran = python("sys.exit(invoke(sys.argv[1:]))", "run", five, "--drive", "bell=0")
    assert (ran.returncode, ran.stderr.count("\n")) == (2, 1)


@pytest.mark.skipif(os.name != "posix", reason="a user of Windows has a home")
def test_a_user_without_home_and_name_gets_the_variables_to_set(call, monkeypatch):
    for variable in ("HOME", "XDG_STATE_HOME", "XDG_CACHE_HOME", "SLEWLINE_CACHE"):
        monkeypatch.delenv(variable, raising=False)
    monkeypatch.setattr(os, "getuid", lambda: 54321)
    found = call("drive", "gs-c200s", "--board", "twin", "--tcp", "127.0.0.1:0")
    variables = "HOME" if sys.platform == "darwin" else "HOME or XDG_STATE_HOME"
    says = f"HOME is not set, and the system does not know the user; set {variables}, "
    says += "or give a folder (--black-box DIR)\n"
    assert (found.status, found.err.endswith(says)) == (2, True)
    assert folders.keep_source("x = 1") is None


@pytest.mark.parametrize("name", EXAMPLES)
def test_all_that_is_missing_is_named_with_an_example_that_has_it(call, name):
    command = cli.commands[name]
    needed = [each for each in command.params if each.required]
    said = call(name, *(["cy525"] if command.params[0].name == "chip" else [])).err
    for each in needed:
        if each.name != "chip":
            assert each.human_readable_name in said or each.opts[0] in said
    assert f"slewline {name} {EXAMPLES[name]}" in said
    context = command.make_context(name, shlex.split(EXAMPLES[name]))
    assert all(context.params[each.name] not in (None, ()) for each in needed)


def test_every_command_that_needs_options_has_an_example():
    need = {
        name
        for name, each in cli.commands.items()
        if any(p.required and isinstance(p, click.Option) for p in each.params)
    }
    assert need == set(EXAMPLES)


@pytest.mark.parametrize("name", ["pull", "push", "compare", "proxy", "terminal", "epics"])
def test_the_part_of_a_module_is_named_by_chip_and_by_its_old_name(call, name):
    command = cli.commands[name]
    words = shlex.split(EXAMPLES.get(name, "here there"))
    words = [word for at, word in enumerate(words) if "--chip" not in words[max(at - 1, 0) : at + 1]]
    for option in ("--chip", "--part"):
        assert command.make_context(name, [*words, option, "cy545"], resilient_parsing=True).params["part"] == "cy545"
    said = call(name, "--help").out
    assert "--chip" in said and "--part" not in said

"""Chips and parts that are not ours: the MX10 of the tutorial in a package of its own, wherever a part is named."""

from __future__ import annotations

import json
import os
import socket
import subprocess
import sys
from pathlib import Path
from threading import Thread

import pytest
import serial

import slewline
import slewline.testing  # pySerial knows slewline:// from now on
from slewline.bench.file import BenchFile
from slewline.chips import CATALOGUE, checks_of, chip_class, quirks_of, ramps_of, sheet_of
from slewline.cli.main import invoke
from slewline.errors import BenchFileError, UnknownName, UsageError
from slewline.links.clients.chipset_host import ChipsetHost
from slewline.parts import part_class
from slewline.testing.endpoints import running
from slewline.testing.rig import NAMED
from tests.links.conftest import PATIENCE

PAGE = Path(__file__).parents[2] / "docs/tutorial/a_chip_of_your_own.md"
MX10 = "\n\n".join(block.split("```")[0] for block in PAGE.read_text("utf-8").split("```python\n")[1:3])
NAME, LAMP = "my_lab.mx10:Mx10", "my_lab.lamp:Lamp"
MODULES = {
    "__init__": "",
    "mx10": MX10,
    "lamp": """
from slewline.core.datasheet.option import Option
from slewline.parts.base.part import Part

class Lamp(Part):
    wiring = {"on": "output1"}
    options = (Option("watts", "int", 5, "of the bulb", low=1, high=100),)

    def __init__(self, kernel, name, watts):
        super().__init__(kernel, name)
        self.watts = watts
        self.add_pin("on", "in", "lit while high")

    @property
    def lit(self):
        return self.pins["on"].level == 1
""",
    "careful": """
from slewline.chips import ramps_of, sheet_of
from slewline.core.datasheet.quirk import Quirk
from .mx10 import Mx10

def slow(source):
    for statement in source.statements:
        if statement.row.name == "SPEED" and statement.values[0] > 9000:
            source.report(statement, "fast", "warning", "faster than the motor")

class Careful(Mx10):
    checks = (slow,)
    ramps = ramps_of("cy525")  # of another chip: who asks for it gets what the class names
    quirks = (Quirk("MX-1", "p. 2", "it stops dead", "the sheet is silent", "test_it"),)

class Wrong(Mx10):
    checks, ramps = slow, "none"
""",
    "broken": "x = 1\nimport numpy_of_another_kind\n",
    "raising": "def deep():\n    raise RuntimeError('the lab is closed')\n\ndeep()\n",
    "leaving": "raise SystemExit(3)\n",
    "syntax": "x = (\n",
    "bare": "from slewline import Chip\n\nclass Bare(Chip):\n    pass\n\nclass Odd(Chip):\n    sheet = 'mx10'\n",
    "ours": "from slewline.chips.cy525.firmware import Cy525\n\nclass Mine(Cy525):\n    pass\n",
}
FEED = "V500\nN40\nG\n@until position=40\nP\n"
BENCH = f"""
[[chip]]
part = "{NAME}"
name = "x"

[[part]]
kind = "{LAMP}"
to = "x"

[[host]]
script = ["V500", "N40", "O1", "G"]
"""


@pytest.fixture
def lab(tmp_path, monkeypatch):
    """A directory on Python's path with the package my_lab; the tests run in another one."""
    folder = tmp_path / "lab"
    (folder / "my_lab").mkdir(parents=True)
    for name, text in MODULES.items():
        (folder / "my_lab" / f"{name}.py").write_text(text, "utf-8")
    (tmp_path / "work").mkdir()
    monkeypatch.chdir(tmp_path / "work")
    monkeypatch.setattr(sys, "path", [str(folder), *sys.path])
    yield folder
    for name, module in [*sys.modules.items()]:
        if str(getattr(module, "__file__", None) or "").startswith(str(tmp_path)):
            del sys.modules[name]


def install(folder, package="my-lab", chips="", parts=""):
    """An installed package with entry points, as far as Python looks at it."""
    info = folder / f"{package.replace('-', '_')}-1.5.dist-info"
    info.mkdir()
    (info / "METADATA").write_text(f"Metadata-Version: 2.1\nName: {package}\nVersion: 1.5\n")
    (info / "entry_points.txt").write_text(f"[slewline.chips]\n{chips}\n\n[slewline.parts]\n{parts}\n")


@pytest.fixture
def installed(lab):
    """The package installed, with entry points for a chip and a part."""
    install(lab, chips=f"mx10 = {NAME}", parts=f"lab-lamp = {LAMP}")
    return lab


@pytest.fixture
def call(capfd):
    """Call the command line: exit status, output, errors."""

    def call(*arguments):
        return invoke(arguments), *capfd.readouterr()

    return call


def written(name, text):
    Path(name).write_text(text, "utf-8")
    return name


# --------------------------------------------------------------------------------------------------------- by its name
def test_a_chip_and_a_part_are_added_by_module_and_class(lab):
    bench = slewline.Bench()
    x, lamp = bench.add(NAME), bench.part(LAMP, to="mx10", watts=20)
    assert (x.name, type(x).__name__, lamp.name, lamp.watts) == ("mx10", "Mx10", "lamp", 20)
    assert bench.host(x).ask("O1") == "OK" and lamp.lit
    assert bench.add(type(x)).name == "mx10_2" and bench.part(type(lamp)).name == "lamp_2"
    with pytest.raises(UsageError, match=r"lamp_3: watts 0; allowed 1..100"):
        bench.part(LAMP, watts=0)


def test_an_entry_point_is_a_name_like_ours(installed, call):
    assert sheet_of("MX10") is sheet_of(NAME) and part_class("lab-lamp") is part_class(LAMP)
    bench = slewline.Bench()
    assert bench.add("mx10").name == "mx10" and bench.part("lab-lamp", to="mx10").name == "lab_lamp"
    status, out, _ = call("chips")
    assert status == 0 and out.splitlines()[-1] == "mx10        MX10 stepper controller"
    assert json.loads(call("chips", "--json")[1])[-1] == {"chip": "mx10", "title": "MX10 stepper controller"}
    with pytest.raises(UnknownName, match=r"no chip 'mx11'; available: cy525, .*, mx10; did you mean mx10\?"):
        bench.add("mx11")


def test_no_package_replaces_a_built_in_chip(lab):
    install(lab, chips=f"cy525 = {NAME}\nCY_525 = {NAME}\ngs_c200 = {NAME}")
    assert {chip_class(name).__module__.split(".")[0] for name in ("cy525", "gs-c200", "GS_C200")} == {"slewline"}
    assert CATALOGUE.names()[-1] == "cy-525"  # a name as ours are spelled


def test_two_packages_with_the_same_name_are_distinguished(lab):
    install(lab, "my-lab", chips=f"mx10 = {NAME}")
    install(lab, "other-lab", chips=f"mx10 = {NAME}")
    assert chip_class("mx10").__name__ == "Mx10"  # they mean the same
    install(lab, "third-lab", chips="mx10 = my_lab.careful:Careful")
    says = r"chip 'mx10': several packages provide it: .*third-lab 1.5 \(my_lab.careful:Careful\).*; give module:Class"
    with pytest.raises(UsageError, match=says):
        chip_class("mx10")


def test_an_entry_point_that_leads_nowhere_is_reported_with_its_package(lab, call):
    install(lab, chips="mx10 = my_lab.mx11:Mx10\nnone = my_lab")
    status, out, err = call("chips")
    assert status == 1 and "gs-c200s" in out
    assert "slewline: chip 'mx10' of my-lab 1.5 (my_lab.mx11:Mx10): no module 'my_lab.mx11'; install" in err
    assert "slewline: chip 'none' of my-lab 1.5 (my_lab): expected module:Class" in err


# -------------------------------------------------------------------------------------------------- what is wrong use
NO_CHIPS = [
    ("your_lab.mx10:Mx10", "no module 'your_lab'; install its package, or add its directory to PYTHONPATH"),
    ("my_lab.mx11:Mx10", "no module 'my_lab.mx11'; install"),
    ("my_lab.mx10:Mx11", "my_lab.mx10 has no 'Mx11'; its chips: Mx10"),
    ("my_lab.mx10:Mx10.Inner", "my_lab.mx10 has no 'Mx10.Inner'"),
    ("my_lab.mx10:MX10", "MX10 is of type Sheet; expected a subclass of slewline.core.chip.Chip; its chips: Mx10"),
    ("my_lab.lamp:Lamp", "Lamp is a class; expected a subclass of slewline.core.chip.Chip"),
    ("my_lab.broken:X", "importing my_lab.broken failed: ModuleNotFoundError: No module named 'numpy_of_another_"),
    ("my_lab.broken:X", "broken.py, line 2)"),
    ("my_lab.raising:X", "importing my_lab.raising failed: RuntimeError: the lab is closed ("),
    ("my_lab.raising:X", "raising.py, line 2)"),
    ("my_lab.leaving:X", "importing my_lab.leaving failed: SystemExit: 3 ("),
    ("my_lab.syntax:X", "importing my_lab.syntax failed: SyntaxError: '(' was never closed ("),
    ("my_lab.syntax:X", "syntax.py, line 1)"),
    ("my_lab.bare:Bare", "my_lab.bare:Bare: no sheet; set it in the class"),
    ("my_lab.bare:Odd", "my_lab.bare:Odd: sheet: found 'mx10'; set it in the class"),
    ("my_lab.mx10:", "chip 'my_lab.mx10:': expected module:Class, such as my_lab.mx10:Mx10"),
    (":Mx10", "expected module:Class"),
    ("my lab:Mx10", "expected module:Class"),
    ("my_lab:mx10:Mx10", "expected module:Class"),
    (".mx10:Mx10", "expected module:Class"),
]


def test_an_unknown_chip_is_reported_with_the_remedy(lab, call, subtests):
    for name, says in NO_CHIPS:
        with subtests.test(name=name, description=says):
            with pytest.raises(UsageError) as error:
                slewline.Bench().add(name)
            assert says in str(error.value)
            status, out, err = call("describe", name)
            assert (status, out) == (2, "") and err.startswith("slewline: ") and says in err


def test_a_class_without_a_sheet_is_reported_as_a_class_too(lab):
    with pytest.raises(UsageError, match=r"my_lab.bare:Bare: no sheet"):
        slewline.Bench().add(__import__("my_lab.bare").bare.Bare)


def test_a_bare_module_is_unknown_and_the_remedy_shows_its_proper_form(lab):
    with pytest.raises(UnknownName, match=r"a class of your own is module:Class, such as my_lab.mx10:Class"):
        slewline.Bench().add("my_lab.mx10")


# ------------------------------------------------------------------------------------------------ on the command line
def test_the_command_line_takes_a_plug_in_wherever_it_takes_a_chip(lab, call):
    written("feed.txt", FEED)
    status, out, _ = call("run", "feed.txt", "--chip", NAME)
    assert status == 0 and "P -> 40" in out and "mx10 (mx10): position 40, 40 steps" in out
    assert call("lint", "feed.txt", "--chip", NAME)[:2] == (0, "feed.txt: no problems found\n")
    status, out, err = call("asm", "feed.txt", "--chip", NAME)
    assert status == 1 and "the MX10 stores no programs: its host sends the lines, as slewline run does" in err
    assert call("describe", NAME, "V")[1].startswith("# SPEED: steps/s\n")
    written("far.txt", "V500\nN0\n")
    status, out, _ = call("lint", "far.txt", "--chip", NAME)
    assert status == 1 and "far.txt, line 2, column 2: error: NUMBER 0: allowed 1..999999" in out
    written("long.txt", f"V{'0' * 300}\n")  # its sheet sets no limit
    assert "error: SPEED 0: allowed 1..20000" in call("lint", "long.txt", "--chip", NAME)[1]


def test_names_of_a_class_in_addition_to_its_sheet_are_used(lab, call):
    careful = "my_lab.careful:Careful"
    written("fast.txt", "V9001\n")
    assert "warning: faster than the motor" in call("lint", "fast.txt", "--chip", careful)[1]
    assert "no problems found" in call("lint", "fast.txt", "--chip", NAME)[1]
    assert call("ramp", careful, "F=3", "R=127", "S=200")[1] == call("ramp", "cy525", "F=3", "R=127", "S=200")[1]
    assert slewline.ramp(careful, F=3, R=127, S=200).steps == slewline.ramp("cy525", F=3, R=127, S=200).steps
    assert [quirk.id for quirk in quirks_of(careful)] == ["MX-1"] and quirks_of(NAME) == ()
    status, _, err = call("ramp", NAME, "F=3")
    assert status == 2 and "my_lab.mx10:Mx10: no ramp calculator; set `ramps` of the class" in err
    with pytest.raises(UsageError, match=r"Wrong.checks: found <function slow.*; expected a tuple of functions"):
        checks_of("my_lab.careful:Wrong")
    with pytest.raises(UsageError, match="Wrong: ramps: found 'none'; set `ramps` of the class"):
        ramps_of("my_lab.careful:Wrong")


def test_a_file_extension_names_an_installed_part(installed, call):
    written("feed.mx10", FEED)
    assert "mx10 (mx10): position 40" in call("run", "feed.mx10")[1]
    status, _, err = call("run", written("feed.mx11", FEED))
    assert status == 2 and "or a file name ending in .cy525, " in err and ".mx10; did you mean mx10?\n" in err


def test_modules_are_found_in_the_current_directory_after_all_others(lab, call, monkeypatch):
    written("stranger.py", MX10)
    Path("my_lab").mkdir()
    written("my_lab/__init__.py", "raise RuntimeError('the wrong one')")
    assert call("describe", "stranger:Mx10", "V")[0] == 0
    assert call("describe", NAME, "V")[0] == 0
    monkeypatch.setattr(sys, "path", [place for place in sys.path if place != os.getcwd()])
    assert call("describe", "cy525", "N")[0] == 0 and os.getcwd() not in sys.path


# ------------------------------------------------------------------------------------------------- bench and journal
def run_of(bench):
    bench.run_until_idle()
    return bench["x"].steps().times_ps.tolist()


def test_a_bench_file_and_its_journal_are_run_and_replayed(lab, call):
    written("b.toml", BENCH)
    status, out, _ = call("run", "b.toml", "--allow-code", "--journal", "j.jsonl")
    assert status == 0 and "x (mx10): position 40, 40 steps" in out
    entries = [json.loads(line) for line in Path("j.jsonl").read_text().splitlines()]
    assert [entry["part"] for entry in entries if entry["do"] == "add"] == [NAME]
    assert [entry["kind"] for entry in entries if entry["do"] == "part"] == [LAMP]
    played = run_of(slewline.load("b.toml", allow_code=True))
    assert len(played) == 40 and slewline.replay("j.jsonl", allow_code=True)["x"].steps().times_ps.tolist() == played
    assert "position 40, 40 steps" in call("run", "--replay", "j.jsonl", "--allow-code")[1]
    assert call("lint", "b.toml", "--allow-code")[0] == 0


def test_installed_parts_need_no_permission_in_files(installed, call):
    written("b.toml", BENCH.replace(NAME, "mx10").replace(LAMP, "lab-lamp"))
    assert call("run", "b.toml", "--journal", "j.jsonl")[0] == 0
    added = [line for line in Path("j.jsonl").read_text().splitlines() if '"do":"add"' in line]
    assert len(added) == 1 and json.loads(added[0])["part"] == "mx10"
    assert slewline.replay("j.jsonl")["x"].position == 40 and slewline.replay("j.jsonl")["lab_lamp"].lit
    assert call("lint", "b.toml")[0] == 0


def test_a_class_that_is_installed_is_kept_by_the_name_of_its_entry_point(installed):
    bench = slewline.Bench(journal="j.jsonl")
    bench.add(NAME, "x")
    bench.part(part_class(LAMP))
    assert set(slewline.replay("j.jsonl").chips) == {"x"}


def test_a_class_derived_from_ours_is_not_replayed_as_ours(lab):
    bench = slewline.Bench(journal="j.jsonl")
    bench.add("my_lab.ours:Mine", "x")
    assert type(slewline.replay("j.jsonl", allow_code=True)["x"]).__name__ == "Mine"


def test_a_class_inside_a_function_is_not_found_again(lab):
    class Inner(chip_class(NAME)):
        pass

    slewline.Bench(journal="j.jsonl").add(Inner)
    with pytest.raises(
        BenchFileError, match=r"line 2: chip .*Inner': a class within a function cannot be found by name"
    ):
        slewline.replay("j.jsonl", allow_code=True)


def test_a_plug_in_whose_behaviour_has_changed_is_not_replayed(lab):
    bench = slewline.Bench(journal="j.jsonl")
    bench.add(NAME, "x")
    module = sys.modules["my_lab.mx10"]
    module.Mx10.sheet = __import__("dataclasses").replace(module.MX10, behaviour=9)
    with pytest.raises(BenchFileError, match=rf"{NAME} had behaviour \d and now has 9"):
        slewline.replay("j.jsonl", allow_code=True)


# ------------------------------------------------------------------------------------------------------ URL and tests
def asked(port):
    """Steps of a feed through a port."""
    for line in (b"V500", b"N40", b"G"):
        port.write(line + b"\r")
        assert port.read_until(b"\r") == b"OK\r"
    port.sleep(0.1)
    port.write(b"P\r")
    return port.read_until(b"\r")


def test_a_url_opens_a_plug_in_where_the_caller_allows_it(lab):
    with serial.serial_for_url(f"slewline://{NAME}?name=guest", 9600, timeout=1, allow_code=True) as port:
        assert asked(port) == b"40\r" and port.chip.sheet.part == "mx10"
        rig = NAMED["guest"]
    try:
        with serial.serial_for_url(f"slewline://{NAME}?name=guest", 9600, timeout=1) as again:
            assert again.rig is rig  # nothing is imported: it is there
        with pytest.raises(ValueError, match=r"'guest' is already the name of slewline://my_lab.mx10:Mx10\?name=guest"):
            serial.serial_for_url("slewline://gs-c200?name=guest")
    finally:
        NAMED.pop("guest").close()


def test_a_url_opens_what_is_installed(installed):
    with serial.serial_for_url("slewline://MX10", 9600, timeout=1) as port:
        assert asked(port) == b"40\r"


@pytest.mark.parametrize("on", ["url", pytest.param("tcp", marks=pytest.mark.system)])
def test_a_test_names_a_plug_in_or_its_class(lab, on):
    for part in (NAME, chip_class(NAME)):
        module = running(part, on)
        try:
            with serial.serial_for_url(module.url, 9600, timeout=60) as port:  # who is tested need not know
                for line in (b"V500", b"N40", b"G"):
                    port.write(line + b"\r")
                    assert port.read_until(b"\r") == b"OK\r"
            module.until_idle()
            module.assert_steps(40, direction=+1)
            module.assert_reply("P", "40")
            assert module.label == f"{NAME} on {on}"
        finally:
            module.close()


@pytest.mark.system
def test_a_plug_in_is_served(lab):
    written("b.toml", f'[[chip]]\npart = "{NAME}"\n[[serve]]\ntcp = "127.0.0.1:0"\n')
    command = [sys.executable, "-W", "error", "-c", "from slewline.cli.main import main; main()", "serve"]
    environment = os.environ | {"PYTHONPATH": str(lab)}
    servers = [
        subprocess.Popen([*command, *words, "--lockstep"], env=environment, stdout=subprocess.PIPE, text=True)
        for words in ([NAME, "--tcp", "127.0.0.1:0"], ["--bench", "b.toml", "--allow-code"])
    ]
    for server in servers:
        with server:
            name, where = server.stdout.readline().split(": ")
            host, port = where.strip().rpartition("//")[2].rsplit(":", 1)
            with socket.create_connection((host, int(port)), timeout=PATIENCE) as client:
                client.sendall(b"V500\r")
                with client.makefile("rb") as answers:
                    assert (name, answers.read(3)) == ("mx10", b"OK\r")
            server.terminate()
        assert server.returncode == 0


# ----------------------------------------------------------------------------------------------------------- hostile
@pytest.fixture
def evil(lab):
    """A module that leaves a file when its code runs; the file."""
    mark = lab / "it-ran"
    (lab / "evil.py").write_text(f"open({str(mark)!r}, 'w').close()\n")
    return mark


JOURNAL = '{"do":"journal","t":0,"version":1,"seed":0}\n'
ADD = '{"do":"add","t":0,"part":"evil:X","name":"x","crystal_hz":null,"straps":{},"bare":false,"options":{}}\n'
PART = '{"do":"part","t":0,"kind":"evil:X","name":"x","to":null,"options":{}}\n'
SERVE = '[[serve]]\ntcp = "127.0.0.1:0"\n'
FILES = {
    "chip.toml": '[[chip]]\npart = "evil:X"\n',
    "part.toml": '[[part]]\nkind = "evil:X"\n',
    "serve.toml": '[[chip]]\npart = "evil:X"\n' + SERVE,
    "add.jsonl": JOURNAL + ADD,
    "part.jsonl": JOURNAL + PART,
    "round.jsonl": JOURNAL + ADD.replace('"t":0', '"t":0,"round":1'),
    "late.jsonl": JOURNAL + PART.replace('"t":0', '"t":1000'),
}
HOSTILE = {
    "load a chip": lambda: slewline.load("chip.toml"),
    "load a part": lambda: slewline.load("part.toml"),
    "stage it": lambda: BenchFile("chip.toml").staged(),
    "replay a chip": lambda: slewline.replay("add.jsonl"),
    "replay a part": lambda: slewline.replay("part.jsonl"),
    "replay in a first round": lambda: slewline.replay("round.jsonl"),
    "replay up to before it": lambda: slewline.replay("late.jsonl", until=0),
    "open a URL": lambda: serial.serial_for_url("slewline://evil:X"),
    "open a named URL": lambda: serial.serial_for_url("slewline://evil:X?name=x&allow_code=1"),
    "ask a server": lambda: ChipsetHost(*greeting("evil:X")),
}
COMMANDS = (
    ("run", "chip.toml"),
    ("run", "part.toml"),
    ("lint", "chip.toml"),
    ("lint", "part.toml"),
    ("serve", "--bench", "serve.toml"),
    ("run", "--replay", "add.jsonl"),
    ("run", "--replay", "part.jsonl"),
)


def greeting(part):
    """The address of a server that says it has this part."""
    server = socket.create_server(("127.0.0.1", 0))

    def serve():
        client, _ = server.accept()
        with client, server:
            client.sendall(f"slewline registers 1 {part} 1\r\n".encode())

    Thread(target=serve, daemon=True).start()
    return server.getsockname()[:2]


@pytest.fixture
def files(evil):
    for name, text in FILES.items():
        written(name, text)
    return evil


@pytest.mark.parametrize("way", HOSTILE)
def test_untrusted_files_run_no_module(files, way):
    with pytest.raises(slewline.SlewlineError, match="'evil:X': names a module, and importing it would run its code; "):
        HOSTILE[way]()
    assert not files.exists()


@pytest.mark.parametrize("words", COMMANDS, ids=" ".join)
def test_a_command_runs_a_module_of_a_file_only_where_it_may(files, call, words):
    status, _, err = call(*words)
    assert status == 2 and "names a module" in err and "--allow-code" in err and not files.exists()
    status, _, err = call(*words, "--allow-code")
    assert status == 2 and "evil has no 'X'" in err and files.exists()


def test_place_and_line_of_a_module_that_is_refused_are_reported(files):
    with pytest.raises(BenchFileError, match=r"^chip.toml, line 1: \[\[chip\]\] 1: chip 'evil:X': names a module"):
        slewline.load("chip.toml")
    with pytest.raises(BenchFileError, match=r"^journal part.jsonl, line 2: part 'evil:X': names a module"):
        slewline.replay("part.jsonl")


@pytest.mark.parametrize(
    "words",
    [("run", "f.cy525"), ("lint", "f.cy525"), ("serve", "cy525", "--tcp", "127.0.0.1:0")],
    ids=" ".join,
)
def test_leave_for_a_file_that_there_is_not_is_wrong_use(lab, call, words):
    written("f.cy525", "N 5\n")
    status, _, err = call(*words, "--allow-code")
    assert status == 2 and "--allow-code needs " in err

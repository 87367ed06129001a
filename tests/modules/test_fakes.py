"""The tools on fake modules that were written from the data sheets: deviations, kills, unplugged cables, a full disk.

What a module answers is kept or has a name, no step is made, and what a tool says is what the fake holds then.
"""

from __future__ import annotations

import io
import json
import re
import signal
import subprocess
import sys
import threading
import time
from pathlib import Path
from random import Random

import pytest

from slewline.chips import sheet_of
from slewline.cli.main import invoke
from slewline.language.assemble import assemble
from slewline.modules import finding, spoken
from tests.modules.fakes import DEVIATIONS, FakeCy545, FakeGsc

pytestmark = [pytest.mark.posix, pytest.mark.system]
OLD = {"gs-c200s": ["S11", "T99", "R9", "-5"], "cy545": ["R 11", "F 9", "G", "0"]}
NEW = {"gs-c200s": ["S10", "T100", "R40", "W1", "+250", "D5", "-120"], "cy545": ["R 100", "N 17", "G", "R 5", "0"]}
KEPT = ["S7", "+70"]  # in the EEPROM of the GS-C200S
FAKES = {
    "gs-c200s": lambda deviation="", **more: FakeGsc(deviation, OLD["gs-c200s"], KEPT, **more),
    "cy545": lambda deviation="", **more: FakeCy545(deviation, OLD["cy545"], **more),
}
NOT_OF = {"cy545": ("no V", "no end", "address", "checksums")}
NAMES = {
    "cr lf": "its lines end in CR LF instead of CR",
    "lf": "its lines end in LF instead of CR",
    "lf cr": "its lines end in LF CR instead of CR",
    "no cr": "it does not end in CR",
    "empty lines": "it has empty lines",
    "blank behind": "it has spaces before or after it",
    "blank inside": "it has spaces inside",
    "small letters": "it has lower-case letters instead of capitals",
    "bit 7": "bit 7 of its 7-bit characters is 1",
    "prompt": "it is surrounded by a prompt",
    "banner": "it is preceded by other lines",
    "echo": "this line echoes, as an adapter",
    "checksums": "its lines end in checksums (--checksum)",
    "address": "it begins with the address",
    "no V": "it lacks the V at its start",
    "digits": "its number has a different number of digits",
    "no end": "the listing has no END",
    "wrapped": "lines of the listing are wrapped",
}
TOOLS = ("pull", "push", "compare", "terminal")
CASES = [(part, name) for part in FAKES for name in DEVIATIONS if name not in NOT_OF.get(part, ())]


PATIENT_S = finding.LOOK_S


@pytest.fixture(autouse=True)
def folder(tmp_path, monkeypatch):
    """An empty folder, with a program and a dialogue; nobody waits long for a fake."""
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr(finding, "LOOK_S", 0.25)
    monkeypatch.setattr(spoken, "ANSWER_S", 0.5)
    for part in FAKES:
        write(part)
    return tmp_path


def write(part):
    sheet = sheet_of(part)
    end = {"gs-c200s": "Px", "cy545": "Q"}[part]
    Path(f"new.{part}").write_text("".join(f"{line}\n" for line in (sheet.enter.form, *NEW[part], end)))
    asked = {"gs-c200s": ("V2", "Q"), "cy545": ("? P", "? M,1")}[part]
    head = {"slewline": "dialogue 1", "part": part, "baud": 9600, "checksum": False}
    rows = [
        {"at_us": n * 1000, "last_us": n * 1000, "from": "host", "text": f"{line}\r"} for n, line in enumerate(asked)
    ]
    Path(f"asked.{part}").write_text("".join(f"{json.dumps(row, separators=(',', ':'))}\n" for row in (head, *rows)))


def words(tool, fake, part):
    return {
        "pull": ["pull", fake.port, "-o", f"saved.{part}"],
        "push": ["push", fake.port, f"new.{part}"],
        "compare": ["compare", f"asked.{part}", "--port", fake.port, "--report", f"report.{part}"],
        "terminal": ["terminal", fake.port, "--part", part, "--plain", "--no-model"],
    }[tool]


def raw_of(tool, part):
    name = {"pull": "saved", "push": "new", "compare": "report", "terminal": "terminal"}[tool]
    return Path(f"{name}.{part}.raw")


def came(path):
    """The characters that a raw file says have come."""
    lines = [line.split(" < ", 1)[1] for line in path.read_text("ascii").splitlines()[1:] if " < " in line]
    return "".join(lines).encode().decode("unicode_escape").encode("latin-1")


def deviating():
    """Every deviation with every tool; in a quick run with pull, and three of them with the others."""
    for part, name in CASES:
        for tool in TOOLS:
            quick = tool == "pull" or name in ("cr lf", "echo", "no end")
            yield pytest.param(part, name, tool, marks=[] if quick else [pytest.mark.long])


@pytest.mark.parametrize(("part", "name", "tool"), [*deviating()])
def test_a_deviation_has_a_name_or_the_raw_text_is_there(monkeypatch, capfd, part, name, tool):
    with FAKES[part](name) as fake:
        before = held(fake)
        monkeypatch.setattr(sys, "stdin", io.StringIO(""))
        status = invoke(words(tool, fake, part))
        captured = capfd.readouterr()
        said = captured.out + captured.err
        raw = came(raw_of(tool, part))
        assert raw and fake.answered.startswith(raw), said
        assert fake.steps == []
        if NAMES[name] in said:
            assert status == 1 and str(raw_of(tool, part)) in said
            assert held(fake) == before and not Path(f"saved.{part}").exists()
        else:
            assert tool not in ("pull", "push") or (part, name) in UNNAMED, said


def held(fake):
    """What a fake holds."""
    return [*fake.ram, "kept", *fake.eeprom] if isinstance(fake, FakeGsc) else bytes(fake.memory)


UNNAMED = [("cy545", "wrapped")]  # a line of a memory that is wrapped is two lines


def test_a_module_as_in_the_sheet_is_read_and_written(capfd):
    for part, made in FAKES.items():
        with made() as fake:
            assert invoke(words("push", fake, part)) == 0, capfd.readouterr().err
            assert invoke(words("pull", fake, part)) == 0
            assert stored(f"new.before.{part}") == OLD[part] and stored(f"saved.{part}") == NEW[part]
            assert fake.steps == []


def stored(path):
    """The instructions of a program in a file, which the assembler takes."""
    part = Path(path).suffix[1:]
    assembly = assemble(Path(path).read_text(), sheet_of(part), path)
    return [statement.text for statement in assembly.statements]


def test_a_dialogue_is_compared_with_the_memory_that_it_shows(capfd):
    """The model's memory is erased: it would send all 64K of it in place of the first line."""
    with FAKES["cy545"]() as fake:
        assert invoke(words("pull", fake, "cy545")) == 0
    capfd.readouterr()
    began_s = time.monotonic()
    assert invoke(["compare", "saved.cy545.dialogue", "--tolerance", "60 s", "--json"]) == 1
    assert time.monotonic() - began_s < 20
    found = json.loads(capfd.readouterr().out)
    differing = {row["command"] for row in found["differences"]}
    assert differing - set(found["held_before"]) == {"? B"}  # the levels of pins
    assert {"? R", "? F", "? S"} <= differing
    assert (found["memory_bytes"], found["findings"]) == (len("R 11 F 9 G 0 "), [])


@pytest.mark.parametrize("part", FAKES)
@pytest.mark.parametrize("more", [(), ("--baud", "9600")])
def test_a_module_may_start_when_its_port_is_opened(monkeypatch, part, more):
    """An interface that resets it by DTR, say: what comes in the first 1.5 s is lost."""
    monkeypatch.setattr(finding, "LOOK_S", PATIENT_S)
    monkeypatch.setattr(spoken, "ANSWER_S", 1.0)
    with FAKES[part](deaf_s=1.5) as fake:
        assert invoke([*words("pull", fake, part), *more]) == 0
        assert fake.steps == []


# ------------------------------------------------------------------------------------------------- what is put back
@pytest.mark.parametrize("unended", [2, 8, pytest.param(1000, marks=pytest.mark.long)])
def test_ram_is_put_back_also_when_the_other_program_could_not_be_read(capfd, unended):
    """Of so many listings after X none has an end; the program must be put back, or what stands there be said."""
    with FAKES["gs-c200s"](unended=unended) as fake:
        status = invoke([*words("pull", fake, "gs-c200s"), "--eeprom"])
        said = capfd.readouterr().err
        check_said(said, fake, "gs-c200s")
        assert (status, fake.steps, fake.eeprom) == (int(unended > 2), [], KEPT)
        assert stored("saved.gs-c200s") == OLD["gs-c200s"]
        assert Path("saved.eeprom.gs-c200s").exists() == (unended == 2)
        assert ("the listing has no END" in said) == (unended > 2)
        assert ("was not restored" in said) == (unended == 1000)
        assert fake.ram == OLD["gs-c200s"]


def check_said(said, fake, part):
    """What a tool says of the module is what it holds."""
    if part == "cy545":
        if "its program is unchanged" in said:
            assert fake.program == OLD[part], said
        if "the module holds the program (verified)" in said:
            assert fake.program == NEW[part], said
        return
    at_end = said.splitlines()[-3:]
    if "its program is unchanged" in said:
        assert fake.ram == OLD[part], said
    if any("the program in its EEPROM is unchanged" in line for line in at_end):
        assert fake.eeprom == KEPT, said
    if found := re.search(r"it holds ([0-9]+) of [0-9]+ instructions; program entry is open", said):
        assert fake.entering and len(fake.ram) in (int(found[1]), int(found[1]) + 1), said
    if any("the module holds the program (verified)" in line and "not known" not in line for line in at_end):
        assert fake.ram == (OLD if "restoring the old program" in said else NEW)[part], said
    if any("and has stored it" in line for line in at_end):
        assert fake.eeprom == NEW[part], said
    if "its RAM has the stored program" in said:
        assert fake.ram == fake.eeprom, said
    if "its RAM has either of its two programs" in said:
        assert fake.ram in (fake.eeprom, OLD[part]), said


# ------------------------------------------------------------------------------------------- kills, cables, full disks
CODE = """
import sys
from slewline.cli.main import main
from slewline.modules import finding, spoken
finding.LOOK_S, spoken.ANSWER_S = 2.0, 5.0
main()
"""
SPAN_S = {"pull": 0.6, "push": 1.2, "compare": 0.5, "terminal": 0.4}


def often(number, few):
    """So many seeds, of which a quick run takes a few."""
    return [pytest.param(seed, marks=[] if seed < few else [pytest.mark.long]) for seed in range(number)]


def started(tool, fake, part, *more, **options):
    return subprocess.Popen(
        [sys.executable, "-c", CODE, *words(tool, fake, part), *more],
        stdin=subprocess.PIPE,
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
        **options,
    )


def check_files(tool, fake, part):
    """Files are whole: programs, dialogues up to their last line, and the raw text."""
    assert not list(Path().glob(".*.part")) or tool == "killed"
    for path in [*Path().glob(f"*before*.{part}"), *Path().glob(f"saved*.{part}")]:
        assert stored(path) in (OLD[part], KEPT) or "before-" in path.name, path
    for path in Path().glob("*.dialogue"):
        assert all(json.loads(line) for line in path.read_bytes().split(b"\n")[:-1])
    for path in Path().glob("*.raw"):
        assert path.read_bytes().startswith(b"; slewline raw 1: ")
    assert fake.steps == []


@pytest.mark.parametrize("seed", often(50, 1))
@pytest.mark.parametrize("tool", TOOLS)
@pytest.mark.parametrize("part", FAKES)
@pytest.mark.parametrize("how", ["kill", "unplug", "SIGTERM"])
def test_a_kill_and_a_cut_cable_lose_nothing_and_cause_no_false_report(part, tool, how, seed):
    random = Random(f"{part} {tool} {how} {seed}")
    with FAKES[part](delay_s=0.005) as fake:
        more = ["--eeprom"] if (tool, part) == ("pull", "gs-c200s") else []
        more += ["--store"] if (tool, part) == ("push", "gs-c200s") else []
        process = started(tool, fake, part, *more)
        deadline = time.monotonic() + 30
        while not fake.answered and process.poll() is None and time.monotonic() < deadline:
            time.sleep(0.005)
        time.sleep(random.uniform(0, SPAN_S[tool]))
        if how == "unplug":
            fake.unplug()
            process.stdin.close()
            process.stdin = None
        elif how == "kill":
            process.kill()
        else:
            process.send_signal(signal.SIGTERM)
        _, said = process.communicate(timeout=60)
        assert "Traceback" not in said, said
        check_files("killed" if how == "kill" else tool, fake, part)
        if how != "kill":
            check_said(said, fake, part)
        if process.returncode == 1 and how == "unplug" and tool in ("pull", "push"):
            assert "the port is gone" in said, said
        if tool == "push" and "wrote new.before" not in said and not Path(f"new.before.{part}").exists():
            assert (fake.ram if part == "gs-c200s" else fake.program) == OLD[part]


@pytest.mark.parametrize("obeyed", [False, True])
@pytest.mark.parametrize("command", ["Q", "X", "Po", "S11", "-5", "Px", "M"])
@pytest.mark.parametrize("tool", ["pull", "push"])
def test_a_cable_that_is_cut_in_an_answer_causes_no_false_report(tool, command, obeyed):
    """Whether the module has obeyed the command that is not answered, nobody knows who was cut off from it."""

    class Cut(FakeGsc):
        def answer(self, text):
            if text != command:
                return super().answer(text)
            if obeyed:
                super().answer(text)
            threading.Thread(target=self.unplug).start()
            raise OSError("cut")

    with Cut("", OLD["gs-c200s"], KEPT) as fake:
        process = started(tool, fake, "gs-c200s", {"pull": "--eeprom", "push": "--store"}[tool])
        _, said = process.communicate("", timeout=60)
        assert "Traceback" not in said, said
        assert process.returncode == (1 if fake.wake < 0 else 0), said
        check_files(tool, fake, "gs-c200s")
        check_said(said, fake, "gs-c200s")


@pytest.mark.parametrize("room", [0, 200, 600, 1200])
@pytest.mark.parametrize("tool", ["pull", "push", "compare"])
@pytest.mark.parametrize("part", FAKES)
def test_a_full_disk_leaves_no_partial_file_and_no_false_report(part, tool, room):
    """No file may be larger than so many bytes: to a program that is a disk that is full."""
    import resource

    def limited():
        resource.setrlimit(resource.RLIMIT_FSIZE, (room, room))

    with FAKES[part]() as fake:
        process = started(tool, fake, part, preexec_fn=limited)
        _, said = process.communicate("", timeout=60)
        assert "Traceback" not in said, said
        assert fake.steps == [] and not list(Path().glob(".*.part"))
        check_said(said, fake, part)
        for path in [*Path().glob(f"*before*.{part}"), *Path().glob(f"saved.{part}")]:
            assert stored(path) == OLD[part]
        if not list(Path().glob(f"*before*.{part}")):
            assert (fake.ram if part == "gs-c200s" else fake.program) == OLD[part]

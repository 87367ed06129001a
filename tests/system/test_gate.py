"""What a file names passes one gate: files, links, devices, code, sizes, times."""

from __future__ import annotations

import json
import os
import sys
from pathlib import Path

import pytest

import slewline
from slewline.bench.file import BenchFile
from slewline.chips import sheet_of
from slewline.cli.live.serve import open_bench_file
from slewline.errors import BenchFileError, SlewlineError, UsageError
from slewline.gate import MAX_VALUES, FileGate, LinkPlace, from_json, lines_of, opened
from slewline.links.ports.symbolic_link import DeviceLink
from slewline.modules.comparing.model_differences import DialogueComparison
from slewline.modules.dialogue import DialogueHeader, RecordedDialogue
from slewline.modules.speech import speech_of
from tests.cli.conftest import call, installed  # noqa: F401  (fixtures)
from tests.mutated import READERS, Samples
from tests.rows import rows


@pytest.fixture(scope="module")
def samples(tmp_path_factory):
    """A file of every kind, each in a folder of its own."""
    return Samples(tmp_path_factory.mktemp("samples"))


# ------------------------------------------------------------------------------------------------------ what is no file
@pytest.mark.posix
@pytest.mark.parametrize("kind", [kind for kind in READERS if kind != "tune log"])  # which is written to
def test_an_irregular_file_is_refused(samples, kind, tmp_path):
    """A FIFO would be waited for, a device may do anything, and a folder is none."""
    for path in samples.paths[kind]:
        target = tmp_path / path.name
        for make in (os.mkfifo, os.mkdir, lambda at: os.symlink("/dev/zero", at)):
            make(target)
            with pytest.raises(
                SlewlineError, match=r"is a (FIFO|directory|device)|symbolic link|not a regular file|Is a directory"
            ):
                READERS[kind][1](target)
            target.rmdir() if target.is_dir() else target.unlink()


BAD_JSON = [
    (b"[" * 100_000, "nested too deeply"),
    (b"1e999", "not a finite number"),
    (b"NaN", "not a finite number"),
    (b"-Infinity", "not a finite number"),
    (b'"\\ud800"', "surrogates not allowed"),
    (b"9" * 5000, "integer string conversion"),
    (b"[" + b"[]," * MAX_VALUES + b"1]", f"more than {MAX_VALUES} values"),
    (b"\xff", "can't decode"),
    ('"x"'.encode("utf-16-be"), "Expecting value"),  # no codec is loaded for another code
]


@rows(["line", "says"], BAD_JSON)
def test_json_has_bounds(line, says):
    with pytest.raises(ValueError, match=says):
        from_json(line)


def test_json_within_its_bounds_is_read():
    assert from_json(b'{"a": [1, 2.5, "\\u00e9", null]}') == {"a": [1, 2.5, "é", None]}
    many = b"[" + b"1," * (MAX_VALUES // 2) + b"1]"
    assert len(from_json(many)) == MAX_VALUES // 2 + 1
    long = json.dumps([",[{" * MAX_VALUES]).encode()  # text has no values
    assert len(from_json(long)[0]) == 3 * MAX_VALUES


def test_a_line_without_end_is_not_read(tmp_path):
    path = tmp_path / "x.dialogue"
    path.touch()
    os.truncate(path, 1 << 24)
    with opened(path) as file, pytest.raises(BenchFileError, match="line 1: more than 1048576 bytes"):
        [*lines_of(path, file)]


def test_a_memory_of_a_journal_is_a_list_of_bytes(tmp_path):
    """A number would be taken for so many bytes."""
    head = {"do": "journal", "t": 0, "version": 1, "seed": 0}
    sheet = sheet_of("gs-c200s")
    add = {"do": "add", "t": 0, "part": sheet.part, "behaviour": sheet.behaviour, "name": "x", "crystal_hz": None}
    add |= {"straps": {}, "bare": False}
    allowed = "(expected a list of at most 65536 bytes, 0 to 255|allowed 0 to 255|allowed a list$)"
    for store in (10, 3_000_000_000, 10**12, "text", {"a": 1}, [256], [-1], [0.5], [True], ["x"], [0] * 65537):
        path = tmp_path / "j.jsonl"
        path.write_text("".join(json.dumps(each) + "\n" for each in (head, add | {"options": {"store": store}})))
        with pytest.raises(BenchFileError, match=rf"line 2: (add: )?store: found .*; {allowed}"):
            slewline.replay(path)
        fault = {"do": "store", "t": 0, "of": "x", "call": 1, "content": store}
        path.write_text("".join(json.dumps(each) + "\n" for each in (head, add | {"options": {}}, fault)))
        with pytest.raises(BenchFileError, match=rf"line 3: store: .*found .*; {allowed}"):
            slewline.replay(path)


# ---------------------------------------------------------------------------------------------------------------- links
@pytest.fixture
def folder(tmp_path):
    """The folder of a bench file, with links out of it and within it."""
    folder = tmp_path / "mine"
    for each in ("below/deeper", "bin", ".git/hooks", "hooks"):
        (folder / each).mkdir(parents=True)
    (folder / "out").symlink_to(tmp_path)
    (folder / "round").symlink_to(folder / "below")
    return folder


def place(folder, name, **leave):
    """Return where a bench file wants a link."""
    return FileGate(folder / "bench.toml", **leave).link(name)


OUTSIDE = ["../x", "../../x", "below/../x", "/tmp/x", "/home/you/.profile", "~/../../x/..", "below/../../x", "/"]
RUN = [
    ".profile", ".bash_login", ".x", "x.py", "x.sh", "conftest.py", "Makefile", "makefile", "GNUmakefile", "Dockerfile",
    "Jenkinsfile", "configure", "SConstruct", "x.mk", "x.pth", "x.service", "x.desktop", "x.toml", "x.cy525", "x.bat",
    "Makefile.pty", "BUILD", "a b", "x\n", "x\0", "é", "-x", "", ".", "below/x.py", "below/.x", "x.pty.py", "$(x)",
]  # fmt: skip
IN_THESE = ["bin/tool", ".git/hooks/pre-commit", "hooks/x", "below/bin/x", "BIN/x"]


@rows(
    ["name", "says"],
    [(name, "outside the folder") for name in OUTSIDE]
    + [(name, "the name of a file that a tool may run") for name in RUN]
    + [(name, "may be executed; name a link in another folder") for name in IN_THESE]
    + [(7, "allowed text"), (["x"], "allowed text")],
)
def test_a_link_has_a_harmless_name_in_the_folder(tmp_path, name, says):
    with pytest.raises(SlewlineError, match=says):
        place(tmp_path, name)


@pytest.mark.posix
def test_a_link_in_the_folder_or_below_is_made_there(folder):
    names = ("x", "x.pty", "y_1.tty", "A-2", "below/x", "below/deeper/x.port", str(folder / "z"), "./w")
    for name in names:
        found = place(folder, name)
        link = DeviceLink(found, "/dev/pts/99999")
        assert os.readlink(folder / name) == "/dev/pts/99999" == link.target and str(found) == str(folder / name)
        link.remove()
        assert not os.path.lexists(folder / name)


@pytest.mark.posix
@pytest.mark.parametrize("name", ["out/x", "round/x", "round/deeper/x", "out/mine/x", "nowhere/x"])
def test_no_link_in_the_path_to_a_link_is_followed(folder, name):
    with pytest.raises(UsageError, match="put the link in a writable directory, and not in one that is itself a link"):
        DeviceLink(place(folder, name), "/dev/pts/99999")
    assert not [path for path in folder.parent.rglob("*") if path.name == "x"]


@pytest.mark.posix
def test_a_folder_that_becomes_a_link_after_it_was_checked_is_not_followed(folder):
    found = place(folder, "below/x")
    (folder / "below/deeper").rmdir()
    (folder / "below").rmdir()
    (folder / "below").symlink_to(folder.parent)
    with pytest.raises(UsageError, match="not in one that is itself a link"):
        DeviceLink(found, "/dev/pts/99999")
    assert not os.path.lexists(folder.parent / "x")


@pytest.mark.posix
def test_a_link_is_removed_where_it_was_made_whatever_its_folder_is_called_then(folder):
    link = DeviceLink(place(folder, "below/x"), "/dev/pts/99999")
    (folder / "below").rename(folder / "moved")
    (folder / "below").mkdir()
    (folder / "below/x").symlink_to("/dev/pts/99999")  # of somebody else
    link.remove()
    assert not os.path.lexists(folder / "moved/x") and os.path.lexists(folder / "below/x")


@pytest.mark.posix
def test_a_link_replaces_only_an_old_link_of_slewline(folder):
    (folder / "data").write_text("precious")
    (folder / "other").symlink_to("/etc/hostname")
    for name in ("data", "other", "below"):
        with pytest.raises(UsageError, match="not an old link made by slewline"):
            DeviceLink(place(folder, name), "/dev/pts/99999")
    (folder / "old").symlink_to("/dev/pts/99998")
    DeviceLink(place(folder, "old"), "/dev/pts/99999").remove()
    assert (folder / "data").read_text() == "precious" and not os.path.lexists(folder / "old")


@pytest.mark.posix
def test_with_leave_a_link_may_be_anywhere(folder):
    for name in ("../x", "out/x", "round/x", "bin/tool", "x.py", str(folder.parent / "y")):
        link = DeviceLink(place(folder, name, anywhere=True), "/dev/pts/99999")
        assert os.readlink(folder / name) == "/dev/pts/99999"
        link.remove()


SERVED = '[[chip]]\npart = "cy545"\nname = "z"\n[[serve]]\nover = "serial"\n'


@pytest.mark.posix
@pytest.mark.parametrize("name", ["../x", ".profile", "x.sh", "bin/tool", "Makefile"])
@pytest.mark.parametrize("command", [("serve", "--bench"), ("panel", "--no-browser")])
def test_a_bench_file_makes_no_link_that_is_run(folder, monkeypatch, call, command, name):  # noqa: F811
    """A shell that reads such a link runs what the chip says."""
    monkeypatch.chdir(folder)
    monkeypatch.setattr("slewline.cli.live.panel.PanelProcess.beside", NoPanel)
    (folder / "b.toml").write_text(f'{SERVED}pty = "{name}"\n')
    before = sorted(folder.parent.rglob("*"))
    ran = (
        call(command[0], *command[1:], "b.toml") if command[0] == "serve" else call(command[0], "b.toml", *command[1:])
    )
    assert ran.status == 2 and "b.toml, line 6: [[serve]] 1, pty: found " in ran.err
    assert "--anywhere" in ran.err and sorted(folder.parent.rglob("*")) == before


class NoPanel:
    """No panel."""

    def __init__(self, *_):
        self.url = "http://127.0.0.1:1"

    def __enter__(self):
        return self

    def __exit__(self, *_):
        pass


# -------------------------------------------------------------------------------------------------------------- devices
@pytest.mark.posix
def test_a_serial_port_of_a_file_is_a_serial_port(tmp_path):
    gate = FileGate(tmp_path / "b.toml")
    for name in ("/dev/ttyUSB0", "/dev/ttyACM1", "/dev/ttyS0", "/dev/ttymxc2", "/dev/rfcomm0", "COM3", r"\\.\COM12"):
        if os.name == "nt" or name[0] == "/":
            assert gate.device(name) == name
    for name in (
        "/dev/watchdog", "/dev/tty", "/dev/tty1", "/dev/pts/3", "/dev/sda", "/dev/null", "/dev/../etc/passwd", "x",
        "/dev/ttyUSB0/../sda", "socket://127.0.0.1:22", "", "/dev/ttyprintk", 3, None,
    ):  # fmt: skip
        with pytest.raises(SlewlineError, match=r"is not a serial port|allowed text"):
            gate.device(name)
    (tmp_path / "ttyUSB0").symlink_to("/dev/watchdog")
    with pytest.raises(SlewlineError, match=r"is not a serial port; .*--anywhere"):
        gate.device(str(tmp_path / "ttyUSB0"))
    assert FileGate(tmp_path / "b.toml", anywhere=True).device("/dev/pts/3") == "/dev/pts/3"


def test_a_serial_port_of_a_file_is_announced_before_it_is_opened(tmp_path, capfd):
    file = BenchFile(bench_with(tmp_path, 'serial = "/dev/ttyUSB77"'))
    opened_at = []

    class Counting:
        """A server that opens nothing."""

        bench = file.load()

        def line(self, *chips, **_):
            """Return a line."""
            return NamedLine(chips)

        def serial(self, _line, where):
            """Open a port, if what was said names it."""
            assert (
                f"slewline: {file.path}: opens the serial port {where} of this machine for z" in capfd.readouterr().err
            )
            opened_at.append(where)
            raise UsageError("no such port")

    with pytest.raises(BenchFileError, match="no such port"):
        open_bench_file(Counting(), file)
    assert opened_at == ["/dev/ttyUSB77"]


class NamedLine:
    """A line with a name."""

    def __init__(self, chips):
        self.chips, self.name = chips, chips[0].name


def bench_with(folder, port):
    """Write a bench file with a port."""
    (folder / "b.toml").write_text(f"{SERVED}{port}\n")
    return folder / "b.toml"


# ----------------------------------------------------------------------------------------------------------------- code
HEADER = {"slewline": "dialogue 1", "part": "evil:Evil"}


def compact(entry):
    """Return a line as `DialogueFile` writes it."""
    return json.dumps(entry, separators=(",", ":")) + "\n"


@pytest.fixture
def evil(tmp_path, monkeypatch):
    """A module that leaves a file when its code runs, where Python finds it; the file."""
    monkeypatch.chdir(tmp_path)
    monkeypatch.syspath_prepend(str(tmp_path))
    (tmp_path / "evil.py").write_text(
        "open('it-ran', 'w').close()\nfrom slewline.chips import chip_class\nEvil = chip_class('gs-c200s')\n"
    )
    (tmp_path / "s.dialogue").write_text(compact(HEADER))
    yield tmp_path / "it-ran"
    sys.modules.pop("evil", None)


@pytest.mark.parametrize("part", ["evil:Evil", "antigravity:x", "os:system", "evil"])
def test_a_dialogue_imports_no_module(evil, call, part):  # noqa: F811
    Path("s.dialogue").write_text(compact(HEADER | {"part": part}))
    ran = call("compare", "s.dialogue")
    assert ran.status == 2 and "dialogue s.dialogue, line 1: part: " in ran.err
    assert ("--allow-code" in ran.err) == (":" in part)
    assert not evil.exists() and not {"evil", "antigravity"} & sys.modules.keys()


def test_a_dialogue_in_python_imports_no_module(evil):
    speech = speech_of(sheet_of("gs-c200s"))
    with pytest.raises(UsageError, match="allow_code"):
        DialogueComparison(RecordedDialogue(DialogueHeader("evil:Evil")), speech).compare()
    assert not evil.exists()


@pytest.mark.parametrize("words", [("--allow-code",), ("--part", "evil:Evil")])
def test_with_leave_or_on_the_word_of_the_user_it_does(evil, call, words):  # noqa: F811
    ran = call("compare", "s.dialogue", *words)
    assert "s.dialogue: nothing to compare: no host has sent data" in ran.err and evil.exists()


def test_allow_code_is_for_a_dialogue(call, tmp_path):  # noqa: F811
    ran = call("compare", "a.vcd", "b.vcd", "--allow-code")
    assert ran.status == 2 and "--allow_code: not an option for two waveforms" in ran.err.replace(
        "allow-code", "allow_code"
    )


def test_names_given_in_python_are_trusted(tmp_path):
    assert isinstance(place(tmp_path, "x"), LinkPlace)
    assert FileGate("b.toml").file("x") == Path("x")


# ---------------------------------------------------------------------------------------------------------- dialogues
HEAD = {"slewline": "dialogue 1", "part": "gs-c200s"}
ENTRY = '{"at_us":%s,"last_us":%s,"from":"host","text":%s}'


@rows(
    ["line", "says"],
    [
        (ENTRY % ("1e999", "1", '"F"'), "line 2: .* is not an entry .*finite"),
        (ENTRY % ("1", "1e999", '"F"'), "line 2: .* is not an entry .*finite"),
        (ENTRY % (10**12 * 10, "1", '"F"'), "line 2: .* is not an entry .*at_us: expected a whole number"),
        (ENTRY % ("1.5", "1", '"F"'), "line 2: .* is not an entry .*at_us: expected a whole number"),
        (ENTRY % ("1", "1", '["x"]'), "line 2: .* is not an entry .*text: expected a string"),
        ("[" * 100_000, r"line 2: .* is not an entry \(nested too deeply\)"),
    ],
)
def test_a_malformed_dialogue_is_reported(tmp_path, line, says):
    path = tmp_path / "s.dialogue"
    path.write_text(f"{json.dumps(HEAD)}\n{line}\n")
    with pytest.raises(UsageError, match=says):
        RecordedDialogue.read(path)


@rows(
    "wrong",
    [
        {"part": ["gs-c200s"]}, {"part": None}, {"markings": 3}, {"crystal_hz": "fast"}, {"crystal_hz": -1},
        {"crystal_hz": 1.5}, {"baud": "9600"}, {"baud": True}, {"checksum": 1}, {"address": "1"}, {"address": -1},
        {"straps": []}, {"straps": {"br0": "0"}}, {"straps": {"br0": True}},
    ],
)  # fmt: skip
def test_a_malformed_header_is_reported(tmp_path, wrong):
    path = tmp_path / "s.dialogue"
    path.write_text(json.dumps(HEAD | wrong) + "\n")
    (name,) = wrong
    with pytest.raises(
        UsageError, match=rf"dialogue .*s.dialogue, line 1: {name}: found .*; allowed .*; correct the line"
    ):
        RecordedDialogue.read(path)

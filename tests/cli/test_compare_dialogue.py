"""slewline compare DIALOGUE: the report, as text, as data and as a file to send; and what it refuses."""

from __future__ import annotations

import json
from pathlib import Path

import pytest

from slewline.modules import finding, spoken
from slewline.modules.dialogue import DialogueFile, RecordedDialogue
from tests.links.conftest import PATIENCE, serve  # noqa: F401
from tests.modules.recorded import GSC, recorded


@pytest.fixture
def dialogue(folder):
    """A dialogue in a file, with the remark of a tool."""

    def make(lines=("F", "V1", "S0"), part="gs-c200s", name="x.dialogue", planted=None, **options):
        found = recorded(part, lines, **options)
        with DialogueFile(name, found.header, clock=lambda: 0) as file:
            file.note("C:\\secret")
            for number, said in enumerate(found.entries):
                data = planted.get(number, said.data) if planted else said.data
                write = file.host if said.speaker == "host" else file.module
                write(data, said.at_us * 1000, said.last_us * 1000)
        return name

    return make


def test_a_module_like_its_model(call, dialogue):
    found = call("compare", dialogue())
    assert found.status == 0
    assert found.out.splitlines() == [
        "gs-c200s: 3 exchanges, 0 differences; times may differ by 24.583 ms plus 0.50%",
        "answers of the module later by 0.0 to 0.0 ms, median 0.0 ms",
        "exchange 3, the model: E2: S0: speed 0, allowed 1..1000; the nearest is 1",
    ]


def test_a_difference(call, dialogue):
    found = call("compare", dialogue(planted={3: b"V+7\r"}), "--tolerance", "1 ms")
    assert (found.status, found.err) == (1, "")
    assert "1 difference; times may differ by 1 ms" in found.out
    assert "V1: module V+7, model V+0\n" in found.out


def test_as_data(call, dialogue):
    found = call("compare", dialogue(planted={3: b"V+7\r"}), "--json").json
    assert (found["part"], found["exchanges"], found["agree"]) == ("gs-c200s", 3, False)
    assert found["tolerance_us"] == 24583
    (row,) = found["differences"]
    assert {name: row[name] for name in ("exchange", "kind", "command", "module", "model")} == {
        "exchange": 2,
        "kind": "answer",
        "command": "V1",
        "module": "V+7",
        "model": "V+0",
    }


def test_the_file_to_send_has_the_dialogue_and_the_facts_of_the_module_and_nothing_else(call, dialogue):
    name = dialogue()
    found = call("compare", name, "--report", "send", "--markings", "GS-C200S 9431")
    assert found.status == 0
    first, *rest = map(json.loads, Path("send").read_text().splitlines())
    assert first == {
        "slewline": "dialogue 1",
        "part": "gs-c200s",
        "markings": "GS-C200S 9431",
        "crystal_hz": None,
        "baud": 9600,
        "checksum": False,
        "address": 0,
        "straps": {},
    }
    assert [set(row) for row in rest] == [{"at_us", "last_us", "from", "text"}] * 6
    assert "secret" not in Path("send").read_text()
    assert call("compare", "send").out == found.out
    again = call("compare", name, "--report", "send")
    assert (again.status, "this file exists" in again.err) == (2, True)


def test_checksums_are_found_in_the_dialogue(call, dialogue):
    name = dialogue(checksum=True)
    lines = Path(name).read_text().replace('"checksum":true', '"checksum":null')
    Path(name).write_text(lines)
    assert call("compare", name).status == 0
    assert call("compare", name, "--no-checksum").status == 1


def test_another_part_differs(call, dialogue):
    found = call("compare", dialogue(("Po", "f+5", "Px")), "--part", "gs-c200")
    assert found.status == 1
    assert "Po: module Y, model E4" in found.out


def test_a_model_with_options(call, dialogue, write):
    name = dialogue(["Po", "S10", "T100", "R50", "+800", "E", *["F"] * 30], pause_us=50_000, law="linear in steps")
    assert call("compare", name).status == 1
    assert call("compare", name, "--options", write("o.toml", 'law = "linear in steps"')).status == 0


def test_a_torn_dialogue_is_compared_as_far_as_it_goes(call, dialogue):
    name = dialogue()
    Path(name).write_bytes(Path(name).read_bytes()[:-5])
    found = call("compare", name)
    assert "the last line is truncated, and is left out" in found.err
    assert found.status == 1
    assert "S0: module no answer, model E2" in found.out


WRONG = {
    "no file": (
        ["nowhere"],
        "dialogue nowhere cannot be read: No such file or directory; name a file that can be read",
    ),
    "not a dialogue": (["text"], "text is not a dialogue; name MODEL.vcd and MEASURED.vcd, or a dialogue"),
    "options of waveforms": (["x.dialogue", "--map", "a=b"], "--map: not an option for a dialogue; leave it out"),
    "options of a dialogue": (["x.vcd", "y.vcd", "--port", "p"], "--port: not an option for two waveforms"),
    "rate": (["x.dialogue", "--baud", "9601"], "--baud 9601: not a rate of the GS-C200S; allowed 9600, 4800"),
    "crystal": (["x.dialogue", "--crystal", "6 MHz"], "the gs-c200s has no selectable crystal"),
    "address": (
        ["x.dialogue", "--address", "3"],
        "x.dialogue: nothing to compare: none of its",
    ),
    "address that it has not": (["x.dialogue", "--address", "3"], "lines is for address 3; name another dialogue"),
    "strap": (["x.dialogue", "--strap", "nope=1"], "nope"),
    "port": (["x.dialogue", "--port", "/dev/ttyUSB77"], "/dev/ttyUSB77: No such file or directory; name a serial port"),
}


@pytest.mark.parametrize("arguments, says", WRONG.values(), ids=WRONG)
def test_refused_arguments(call, dialogue, write, arguments, says):
    dialogue()
    write("text", "hello")
    found = call("compare", *arguments)
    assert found.status == 2
    assert says in found.err
    assert found.out == ""


# ----------------------------------------------------------------------------------------------- played to a module now
@pytest.fixture
def patient(monkeypatch):
    """A server that is kept from running for a while is no module that does not answer."""
    monkeypatch.setattr(finding, "LOOK_S", 5.0)
    monkeypatch.setattr(spoken, "ANSWER_S", PATIENCE)


@pytest.mark.system
@pytest.mark.usefixtures("patient")
def test_a_dialogue_is_played_to_a_module_now(call, dialogue, serve):  # noqa: F811
    served = serve("gs-c200s", "--tcp", "127.0.0.1:0", "--strap", "chs=0")
    name = dialogue(["F", "V1", "Q", "V2"], planted={3: b"V+7\r"})
    found = call("compare", name, "--port", served.where, "--report", "now", "--tolerance", "60 s")
    assert (found.status, found.err) == (0, "slewline: the raw characters received are in now.raw\n"), found.out
    assert found.out.startswith("gs-c200s: 4 exchanges, 0 differences")
    said = RecordedDialogue.read("now").entries
    assert [each.text for each in said] == ["F\r", "R\r", "V1\r", "V+0\r", "Q\r", "END\r", "V2\r", "V70\r"]


@pytest.mark.system
@pytest.mark.usefixtures("patient")
def test_commands_that_move_are_not_played(call, dialogue, serve):  # noqa: F811
    served = serve("gs-c200s", "--tcp", "127.0.0.1:0", "--strap", "chs=0")
    name = dialogue(["F", *GSC[2:12]])
    found = call("compare", name, "--port", served.where, "--report", "now")
    assert found.status == 2
    assert "E may step the motor; no command was sent; allow motion with --move" in found.err
    assert not Path("now").exists()
    found = call("compare", name, "--port", served.where, "--report", "now", "--move")
    assert "Po would replace the module's program; no command was sent; save that program" in found.err
    found = call(
        "compare", name, "--port", served.where, "--report", "now", "--move", "--replace", "--tolerance", "60 s"
    )
    assert found.status == 0, found.out


@pytest.mark.system
@pytest.mark.usefixtures("patient")
def test_a_module_of_another_kind_is_recognised(call, dialogue, serve):  # noqa: F811
    served = serve("gs-c200", "--tcp", "127.0.0.1:0", "--strap", "chs=0")
    name = dialogue(["F", "V1", "V2"])
    found = call("compare", name, "--port", served.where)
    assert found.status == 1
    assert "V1: module V0, model V+0" in found.out

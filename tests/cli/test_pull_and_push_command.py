"""slewline pull and push, as they are typed: files, messages and exit statuses."""

from __future__ import annotations

from pathlib import Path

import slewline.testing  # noqa: F401  # pySerial knows slewline://
from slewline.modules.dialogue import RecordedDialogue

WELD = ("Po", "S10", "T100", "R5", "+50", "Px")
URL = "slewline://gs-c200s?chs=0&name={}"


def test_a_program_goes_in_and_comes_out_with_its_dialogues(call, write):
    url = URL.format("cli1")
    sent = call("push", url, write("weld.gs-c200s", *WELD), "--store", "--markings", "GS-C200S 9431")
    assert (sent.status, sent.out) == (0, "")
    assert sent.err.splitlines() == [
        f"slewline: gs-c200s at {url}, 9600 7O2; the dialogue is recorded in weld.gs-c200s.dialogue, raw characters in "
        "weld.gs-c200s.raw",
        "slewline: wrote weld.before.gs-c200s: 0 instructions, 0 locations",
        "slewline: verified: 4 instructions",
        "slewline: M: program to EEPROM ...",
        "slewline: the module holds the program (verified) and has stored it in its EEPROM",
    ]
    saved = call("pull", url, "-o", "saved.gs-c200s", "--eeprom", "--no-checksum", "--baud", "9600")
    assert saved.status == 0
    assert Path("saved.gs-c200s").read_text().splitlines()[3:] == [*WELD]
    dialogue = RecordedDialogue.read("weld.gs-c200s.dialogue")
    header = dialogue.header
    assert (header.part, header.markings, header.baud, header.checksum) == ("gs-c200s", "GS-C200S 9431", 9600, False)
    sent = [each.text for each in dialogue.entries if each.speaker == "host"]
    assert sent[-9:] == [f"{line}\r" for line in (*WELD[:-1], "Q", "Q", "Px", "M")]


def test_a_dialogue_is_not_replaced_but_has_a_number(call, write):
    url = URL.format("cli2")
    for _ in range(2):
        assert call("push", url, write("weld.gs-c200s", *WELD)).status == 0
    assert sorted(path.name for path in Path().glob("*.dialogue")) == [
        "weld.gs-c200s-2.dialogue",
        "weld.gs-c200s.dialogue",
    ]
    assert call("push", url, "weld.gs-c200s", "--dialogue", "weld.gs-c200s.dialogue").status == 2


CANNOT_BE = [
    (("pull", "/dev/nowhere", "-o", "a.gs-c200s"), 2, "/dev/nowhere: No such file or directory; name"),
    (("pull", "slewline://gs-c200s", "-o", "a"), 2, "a: no chip given"),
    (("pull", "slewline://gs-c200s", "-o", "no/a.gs-c200s"), 2, "no/a.gs-c200s: there is no directory 'no'"),
    (("pull", "slewline://gs-c200s", "-o", "here.gs-c200s"), 2, "here.gs-c200s: this file exists; name a new file"),
    (("pull", "slewline://cy545", "-o", "a.cy545", "--eeprom"), 2, "--eeprom: the CY545 has one program"),
    (("pull", "slewline://cy500", "-o", "a.cy500"), 2, "cy500 is on a bus and cannot be read back"),
    (("push", "slewline://cy525", "p.cy525"), 2, "might be executed instead of stored"),
    (("pull", "slewline://gs-c200s", "-o", "a.gs-c200s", "--baud", "19200"), 2, "--baud 19200: not a rate of the"),
    (("pull", "slewline://gs-c200s", "-o", "a.gs-c200s", "--from", "5"), 2, "--from 5: the program of a"),
    (
        ("pull", "slewline://gs-c200", "-o", "a.gs-c200s"),
        1,
        "V1 was answered with 'V0'; allowed V, a sign, 1 to 7 digits",
    ),
    (("pull", "slewline://gs-c200s?br0=1", "-o", "a.gs-c200s", "--baud", "9600"), 1, "nothing answers V2"),
    (
        ("pull", "loop://", "-o", "a.gs-c200s"),
        1,
        "this line echoes, as an adapter",
    ),
    (("backup",), 2, "slewline pull PORT -o FILE"),
    (("push", "slewline://cy545", "p.cy545", "--store"), 2, "--store: the CY545 has no command for this"),
    (("push", "slewline://gs-c200s", "here.gs-c200s"), 2, "has no program"),
    (("push", "slewline://gs-c200s", "runs.gs-c200s"), 1, "runs.gs-c200s, line 4: H+ may step the motor"),
]


def test_impossible_requests_are_reported_and_nothing_is_written(call, write, subtests):
    write("here.gs-c200s", "f+5")
    write("p.cy545", "E", "R 5", "0", "Q")
    write("p.cy525", "E", "R 5", "0", "Q")
    write("runs.gs-c200s", "Po", "S10", "Px", "H+")
    before = {path: path.read_bytes() for path in Path().iterdir()}
    for words, status, says in CANNOT_BE:
        with subtests.test(words=words, status=status):
            called = call(*words)
            assert (called.status, called.out) == (status, "")
            assert says in called.err
            after = {path: path.read_bytes() for path in Path().iterdir() if path.suffix not in (".dialogue", ".raw")}
            assert after == before

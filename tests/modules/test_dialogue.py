"""The dialogue file: what was said is in it line by line, whatever ends its writing."""

from __future__ import annotations

import json
import subprocess
import sys

import pytest

from slewline.errors import UsageError
from slewline.modules.dialogue import LONGEST, DialogueEntry, DialogueFile, DialogueHeader, RecordedDialogue

HEADER = DialogueHeader("gs-c200s", "GS-C200S 9431", 6_000_000, 9600, True, 2, {"chs": 1})


@pytest.fixture
def path(tmp_path):
    return tmp_path / "x.dialogue"


def new_file(path, failed=None):
    return DialogueFile(path, HEADER, failed or pytest.fail, clock=lambda: 0)


def test_a_written_dialogue_is_read_again(path):
    with new_file(path) as file:
        file.host(b"V1\r", 1_000_000, 3_000_000)
        file.module(b"\xff\x00\r", 5_000_999)
        file.note("µ")
        file.host(b"F", 6_000_000)
    found = RecordedDialogue.read(path)
    assert found.header == HEADER
    assert not found.torn
    assert found.entries == (
        DialogueEntry(1000, 3000, "host", b"V1\r"),
        DialogueEntry(5000, 5000, "module", b"\xff\x00\r"),
        DialogueEntry(0, 0, "tool", b"\xb5"),
        DialogueEntry(6000, 6000, "host", b"F"),
    )


def test_characters_share_a_line_up_to_a_carriage_return_or_until_the_other_side_speaks(path):
    with new_file(path) as file:
        for number, byte in enumerate(b"+1\rE"):
            file.host(bytes([byte]), number * 1_000_000)
        file.module(b"Y\rV", 10_000_000, 12_000_000)
        file.host(b"1\r", 20_000_000)
    found = [(said.at_us, said.last_us, said.speaker, said.text) for said in RecordedDialogue.read(path).entries]
    assert found == [
        (0, 2000, "host", "+1\r"),
        (3000, 3000, "host", "E"),
        (10_000, 11_000, "module", "Y\r"),
        (12_000, 12_000, "module", "V"),
        (20_000, 20_000, "host", "1\r"),
    ]


def test_a_line_without_end_does_not_grow_without_end(path):
    with new_file(path) as file:
        file.module(b"x" * (2 * LONGEST + 1), 0)
        assert [len(said.data) for said in RecordedDialogue.read(path).entries] == [LONGEST, LONGEST]


def test_a_line_is_in_the_file_when_it_is_over(path):
    with new_file(path) as file:
        file.host(b"F\r", 0)
        assert RecordedDialogue.read(path).entries == (DialogueEntry(0, 0, "host", b"F\r"),)


@pytest.mark.parametrize("cut", [1, 20])
def test_a_torn_last_line_is_left_out(path, cut):
    with new_file(path) as file:
        file.host(b"F\r", 0)
        file.module(b"R\r", 0)
    path.write_bytes(path.read_bytes()[:-cut])
    found = RecordedDialogue.read(path)
    assert found.torn
    assert found.entries == (DialogueEntry(0, 0, "host", b"F\r"),)


def test_files_sent_to_others_have_no_remarks(path, tmp_path):
    with new_file(path) as file:
        file.host(b"F\r", 7_000_000, 8_000_000)
        file.note("/home/somebody/secret")
        file.module(b"R\r", 9_000_000)
    RecordedDialogue.read(path).write(tmp_path / "sent")
    assert "secret" not in (tmp_path / "sent").read_text()
    found = RecordedDialogue.read(tmp_path / "sent")
    assert found.header == HEADER
    assert found.entries == (DialogueEntry(7000, 8000, "host", b"F\r"), DialogueEntry(9000, 9000, "module", b"R\r"))


def test_a_file_that_exists_is_not_touched(path):
    path.write_text("precious")
    with pytest.raises(UsageError, match="this file exists; name a new file"):
        new_file(path)
    assert path.read_text() == "precious"


def test_a_file_that_cannot_be_written_is_refused(tmp_path):
    with pytest.raises(UsageError, match=r"dialogue .*nowhere.*; give a file that can be written"):
        new_file(tmp_path / "nowhere" / "x")


HALF = '{"at_us":0,"from":"host"'
BAD = {
    "empty": ("", "begins with b''; expected"),
    "other": ("GIF89a\n", "begins with b'GIF89a'; expected"),
    "version": (
        '{"slewline":"dialogue 2","part":"x"}\n',
        "is a 'dialogue 2'; this version of slewline reads dialogue 1",
    ),
    "kind": ('{"slewline":"memory 1"}\n', "is a 'memory 1'"),
    "no part": ('{"slewline":"dialogue 1"}\n', "names no part"),
    "line": ('{"slewline":"dialogue 1","part":"x"}\n\n{}\n', "line 2: b'' is not an entry"),
    "list": ('{"slewline":"dialogue 1","part":"x"}\n[]\n', r"line 2: b'\[\]' is not an entry \(expected an object\)"),
    "who": ('{"slewline":"dialogue 1","part":"x"}\n' + HALF.replace("host", "me") + "}\n", "'from' 'me'|from: 'me'"),
    "text": ('{"slewline":"dialogue 1","part":"x"}\n' + HALF + "}\n", "not an entry"),
    "letters": ('{"slewline":"dialogue 1","part":"x"}\n' + HALF + ',"text":"\\u0100"}\n', "not an entry"),
}


@pytest.mark.parametrize("text, says", BAD.values(), ids=BAD)
def test_an_invalid_dialogue_is_refused(path, text, says):
    path.write_text(text)
    with pytest.raises(UsageError, match=says):
        RecordedDialogue.read(path)


def test_a_file_that_is_not_there_is_refused(path):
    with pytest.raises(UsageError, match="name a file that can be read"):
        RecordedDialogue.read(path)


FULL = """
import resource, signal, sys
from slewline.modules.dialogue import *
signal.signal(signal.SIGXFSZ, signal.SIG_IGN)
resource.setrlimit(resource.RLIMIT_FSIZE, (1000, 1000))
with DialogueFile(sys.argv[1], DialogueHeader("gs-c200s"), print) as file:
    for number in range(100):
        file.host(b"V1\\r", number)
"""


@pytest.mark.system
@pytest.mark.posix
def test_a_full_disk_is_reported_once_and_complete_lines_stay(path):
    done = subprocess.run([sys.executable, "-c", FULL, path], capture_output=True, text=True, check=True)
    found = RecordedDialogue.read(path)
    assert not found.torn
    assert 5 < len(found.entries) < 100
    kept = f"the {len(found.entries)} lines before are kept"
    assert done.stdout == f"dialogue {path}: File too large; it ends here, {kept}\n"


def test_an_entry_of_a_later_version_may_have_more(path):
    with new_file(path) as file:
        file.host(b"F\r", 0)
    lines = [json.loads(line) | {"new": 1} for line in path.read_text().splitlines()]
    path.write_text("".join(json.dumps(line) + "\n" for line in lines))
    assert RecordedDialogue.read(path).header == HEADER

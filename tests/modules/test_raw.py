"""What a module answers is kept raw; the names of deviations; the memory that a dialogue shows."""

from __future__ import annotations

import errno

import pytest

from slewline.chips import sheet_of
from slewline.modules import raw
from slewline.modules.comparing.exchanges import RecordedExchange
from slewline.modules.comparing.shown_memory import memory_of
from slewline.modules.deviations import deviations, in_words
from slewline.modules.raw import RawRecord
from slewline.modules.speech import speech_of

MS = 1_000_000


def lines(path):
    return [line[12:] for line in path.read_text().splitlines()[1:]]


def test_sent_and_received_bytes_with_the_rate_and_only_if_any_were_received(tmp_path):
    record = RawRecord(tmp_path / "x.raw")
    record.note("9600 7O2")
    record.sent(b"V2\r", MS)
    assert not (tmp_path / "x.raw").exists() and not record.is_kept
    record.came(b"\\V70\r\n\x00\xff", 2 * MS)
    assert lines(tmp_path / "x.raw") == [" = 9600 7O2", " > V2\\r", " < \\\\V70\\r\\n\\x00\\xff"]  # before it is closed
    record.close()
    record.came(b"late", 3 * MS)
    assert len(lines(tmp_path / "x.raw")) == 3


def test_no_more_than_some_megabytes_are_kept_and_that_is_reported(tmp_path, monkeypatch):
    monkeypatch.setattr(raw, "LARGEST", 1000)
    said = []
    record = RawRecord(tmp_path / "x.raw", said.append)
    for _ in range(100):
        record.came(b"V70\r", MS)
    assert (tmp_path / "x.raw").stat().st_size <= 1000
    assert (tmp_path / "x.raw").read_text().splitlines()[-1] == raw.FULL
    assert said == [f"{tmp_path / 'x.raw'}: 16 MB are full; the record ends here"]


@pytest.mark.parametrize("room", [0, 1])
def test_a_full_disk_ends_it_at_a_complete_line_and_is_reported_once(tmp_path, room):
    said = []
    record = RawRecord(tmp_path / "x.raw", said.append)

    class Full:
        def write(self, data):
            raise OSError(errno.ENOSPC, "No space left on device")

        def truncate(self, size):
            assert size == record._size

        def close(self):
            pass

    for _ in range(room):
        record.came(b"V70\r", MS)
    if room:
        record._file.close()
        record._file = Full()
    else:
        record.path = tmp_path / "nowhere" / "x.raw"
    record.came(b"V70\r", MS)
    record.came(b"V70\r", MS)
    assert len(said) == 1 and ("the record ends here" if room else "characters are not recorded") in said[0]


def test_two_deviations_have_both_names_and_noise_has_none():
    gsc = speech_of(sheet_of("gs-c200s"))
    assert deviations(gsc, "V2", b"V2\rV70\r\n") == (
        "it echoes sent characters, as a modem or a console does and its lines end in CR LF instead of CR"
    )
    for command, received in (("V2", b"V70\r"), ("V2", b"E1\r"), ("Q", b"S10\rEND\r"), ("V2", b"\x00x?\r"), ("F", b"")):
        assert deviations(gsc, command, received) == ""


def test_the_pattern_of_an_answer_in_words():
    gsc, cy545 = (speech_of(sheet_of(part)).questions for part in ("gs-c200s", "cy545"))
    assert in_words(gsc["position"][1]) == "V, a sign, 1 to 7 digits"
    assert in_words(gsc["inputs and outputs"][1]) == "V, 2 digits of 0 to 7"
    assert in_words(cy545["position"][1]) == "P=, 8 digits"


def exchange(number, sent, answer=b""):
    return RecordedExchange(number, number, number, [(number, code) for code in sent], answer)


def test_the_memory_that_a_dialogue_shows_is_what_was_there_before_the_host_wrote():
    cy545 = speech_of(sheet_of("cy545"))
    dialogue = [
        exchange(1, b"Y 4\r"),
        exchange(2, b"? M,1\r", b"Y=00004\rR 11\r"),
        exchange(3, b"Y 9\r"),
        exchange(4, b"E\r"),
        exchange(5, b"G\r"),
        exchange(6, b"Q? M,2\r", b"Y=00009\rG\rF 9\r"),
        exchange(7, b"? M,1\r", b"Y=00100\r\xff\xff"),
    ]
    assert memory_of(dialogue, cy545) == b"\xff" * 4 + b"R 11\r\xff\xffF 9\r"
    assert memory_of(dialogue, speech_of(sheet_of("gs-c200s"))) == b""

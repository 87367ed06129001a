"""A module is found at its rate; and what is sent to find it is no command at any other rate."""

from __future__ import annotations

from itertools import product

import pytest

from slewline.chips import sheet_of
from slewline.core.datasheet.channel import AdaptiveLine, SerialLine
from slewline.language.dialect import Command
from slewline.language.lines import parse
from slewline.modules.failures import DamagedAnswer, NoAnswer
from slewline.modules.finding import LOOKS_FOR, find
from slewline.modules.module import Module
from slewline.modules.module_port import ModulePort
from slewline.modules.speech import QuerySpeech, speech_of

from .conftest import rarely

RATES = [(levels, rate) for levels, rate in sheet_of("gs-c200s").through(SerialLine).bauds.items()]


def found(url, **given):
    return find(f"slewline://{url}", sheet_of(url.partition("?")[0]), **given)


@pytest.mark.parametrize("checked", [0, 1])
@pytest.mark.parametrize(("levels", "rate"), RATES)
def test_rate_and_checksums_are_found(levels, rate, checked):
    straps = "&".join(f"br{n}={level}" for n, level in enumerate(levels))
    with found(f"gs-c200s?chs={checked}&{straps}").port as port:
        assert port.setting.baud == rate
        x = port.line.chip
        assert (len(x.steps()), x.program_rows(), x.position) == (0, [], 0)


def test_checksums_of_old_firmware_are_found():
    x = found("gs-c200?firmware=2.1")
    with x.port:
        assert x.ask("P").lines == ("Y",)


def test_a_module_among_others_is_found_by_its_address():
    url = "gs-c200s?chs=0&sel2=0&sel1=0&sel0=1&br0=1"
    with found(url, address=3).port as port:
        assert port.setting.baud == 4800
    with pytest.raises(NoAnswer, match=r"nothing answers V2 at 9600 to 110 baud, 7O2; .*give --address"):
        found(url)


@pytest.mark.parametrize("part", ["cy545", "cy545b"])
def test_a_part_that_finds_the_rate_is_queried_at_9600_baud_or_the_given_rate(part):
    for baud in (None, 600, 19200):
        with found(part, baud=baud).port as port:
            assert port.line.chip.baud == (baud or 9600)


def test_another_rate_than_the_detected_one_is_reported():
    with pytest.raises(
        NoAnswer, match=r"no answer to \? P .* keeps the rate that it detected first.*--baud \(now 9600"
    ):
        found("cy545?fixed_baud=1200")


def test_program_entry_that_another_session_has_left_open_is_ended():
    x = found("cy545?name=open_entry")
    with x.port:
        x.ask("E")
        x.send(b"R 1")
    x = found("cy545?name=open_entry")
    with x.port as port:
        assert x.value("position") == "00000000"
        assert not port.line.chip.steps()


def test_the_wrong_part_is_reported():
    with pytest.raises(NoAnswer, match="nothing answers V2"):
        find("slewline://cy545?fixed_baud=9600", sheet_of("gs-c200s"))
    with pytest.raises((NoAnswer, DamagedAnswer), match=r"\? P"):
        find("slewline://gs-c200s?chs=0", sheet_of("cy545"))


@rarely("straps", ["chs=0", "chs=1", "chs=0&sel0=1&sel1=0&sel2=0"], quick=["chs=0"])
@rarely("part", ["gs-c200", "gs-c200s"], quick=["gs-c200s"])
@rarely("address", [0, 3], quick=[0])
def test_at_no_other_rate_is_the_question_a_command(part, straps, address):
    sheet = sheet_of(part)
    for (levels, rate), sent, checked in product(RATES, RATES, (False, True)):
        if rate == sent[1]:
            continue
        speech = speech_of(sheet, sent[1], checked, address)
        urls = "&".join(f"br{n}={level}" for n, level in enumerate(levels))
        with ModulePort(f"slewline://{part}?{straps}&{urls}", speech.setting) as port:
            taken = []
            chip = port.line.chip
            chip.on_command.add(taken.append)
            for _ in range(3):
                port.write(speech.framed(speech.probe))
                port.read(0.1)
            port.pause(1)
            assert [text for text in taken if isinstance(parse(sheet, text), Command)] == []


@rarely("part", ["cy545", "cy545b"], quick=["cy545"])
def test_at_no_other_rate_is_what_is_sent_to_a_part_with_queries_a_command_that_steps(part):
    rates = sheet_of(part).through(AdaptiveLine).bauds
    for rate, sent in product(rates, rates):
        if rate == sent:
            continue
        taken = []
        speech = speech_of(sheet_of(part), sent)
        with ModulePort(f"slewline://{part}?fixed_baud={rate}", speech.setting) as port:
            chip = port.line.chip
            chip.on_command.add(taken.append)
            with pytest.raises((NoAnswer, DamagedAnswer)):
                LOOKS_FOR[QuerySpeech](Module(port, speech), sent, None)
            port.pause(1)
            assert not len(chip.steps()), (rate, sent)
            assert [text for text in taken if text and speech.moves(text)] == [], (rate, sent)


@pytest.mark.parametrize("part", ["gs-c200", "gs-c200s"])
@pytest.mark.parametrize("baud", [None, 9600])
def test_checksums_that_a_module_does_not_have_are_the_mistake_and_no_other_rate_is_tried(part, baud):
    raised = []
    for _ in range(2):
        with pytest.raises(DamagedAnswer) as caught:
            find(f"slewline://{part}?chs=0", sheet_of(part), baud=baud, checked=True)
        raised.append(str(caught.value))
    assert raised[0] == raised[1]
    assert "V2 with a checksum was answered with b'E2\\r' at 9600 baud" in raised[0]
    assert raised[0].endswith("without a checksum: this module has no checksums; leave out --checksum")
    find(f"slewline://{part}?chs=1", sheet_of(part), baud=baud, checked=True).port.close()

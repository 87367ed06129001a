"""What becomes of the mistakes of a CY525's host: where the manual is silent, the choice and its finding."""

from __future__ import annotations

import pytest

import slewline
from slewline.chips.cy525.sheet import SHEET

US = 1_000_000  # picoseconds
KNOWN = "A 0\rN 3\rS 250\rR 10\rF 3\rZ 1\r"  # every register set, so that a motion has nothing to complain about
OUTPUTS = tuple(pin.name for pin in SHEET.pins if pin.reset is not None and pin.in_out in ("out", "both"))


@pytest.mark.fact("LANG-SET-1", "UND-LETTER", "UND-LOWERCASE", "UND-LF")
@pytest.mark.parametrize("letter", ["K", "M", "Y", "7", "n", "b", "?", "\n", "$"])
def test_an_unknown_letter_swallows_its_line_only(rig, letter):
    r = rig(record=("instrobe",))
    line = f"{letter} 5\r"
    r.send(f"N 7\rE\r{line}Q{line}")
    assert r.codes == ["line-feed" if letter == "\n" else "unknown-command"] * 2
    assert r.x.registers["number"] == 7 and r.x.program == b""
    assert len(r.falls("instrobe")) == 4 + 2 + 4 + 1 + 4
    r.send("N 8\r")
    assert r.x.registers["number"] == 8


def test_a_host_that_ends_its_lines_with_a_line_feed_is_reported_once(rig):
    r = rig()
    r.host.send("A 0\nF 10\n")
    r.bench.run_until_idle()
    assert r.codes == ["line-end", "unfinished"]
    assert (
        r.x.findings[0].text == "the host ends its lines with LF, but this part expects CR: send \\r alone, without \\n"
    )
    assert r.x.waiting.endswith(r"'A 0\nF 10\n' has arrived without its carriage return")
    with pytest.raises(
        slewline.Timeout, match=r"waiting for the rest of a command since .* has arrived without its carriage return"
    ):
        r.bench.run_until(r.x.reaches(5), "1 s")


def test_the_chip_waits_for_the_return_of_a_last_line(rig):
    r = rig()
    r.host.send("N 5\rR 100")
    r.bench.run_until_idle()
    assert r.codes == ["unfinished"] and r.x.waiting.endswith("'R 100' has arrived without its carriage return")
    r.host.send("\r")
    r.bench.run_until_idle()
    assert "return" not in r.x.waiting


@pytest.mark.fact("UND-LF")
def test_a_line_feed_after_the_return_costs_the_next_command(rig):
    r = rig()
    r.send("C\r\nB\r\nN 5\r")
    assert r.codes == ["line-feed"] * 2
    assert r.level("programmable_output") == 0 and r.x.registers["number"] == 0


@pytest.mark.fact("UND-Q-CR")
def test_a_return_after_quit_is_an_empty_line(rig):
    r = rig()
    r.send("E\rB\rQ\rN 5\r")
    assert r.codes == ["q-terminated"]
    assert r.x.program == b"B" and r.x.registers["number"] == 5


@pytest.mark.fact("UND-Q-COMMAND", "UND-EMPTY-LINE")
def test_quit_outside_entry_and_an_empty_line_do_nothing(rig):
    r = rig(record=OUTPUTS)
    r.send("\r")
    assert r.codes == ["empty-line"]
    r.send("Q")
    assert r.codes == ["empty-line", "quit-outside-entry"]
    r.send("E\r\rB\rQ")
    assert r.codes[2:] == ["empty-line"] and r.x.program == b"B"
    quiet = set(OUTPUTS) - {"ready", "instrobe", "prog"}
    assert all(not r.edges(pin) for pin in quiet) and [level for _, level in r.edges("prog")] == [0, 1]


@pytest.mark.parametrize(
    ("line", "code", "number", "stored"),
    [
        pytest.param("N40", "spacing", 40, "4E 28 00", marks=pytest.mark.fact("UND-NOSPACE")),
        pytest.param("N   40", "spacing", 40, "4E 28 00", marks=pytest.mark.fact("UND-NOSPACE")),
        pytest.param("N 40  ", "spacing", 40, "4E 28 00", marks=pytest.mark.fact("UND-NOSPACE")),
        pytest.param("N", "missing-argument", 7, "", marks=pytest.mark.fact("UND-NOARG")),
        pytest.param("N ", "missing-argument", 7, "", marks=pytest.mark.fact("UND-NOARG")),
        pytest.param("L 3", "missing-argument", 7, "", marks=pytest.mark.fact("UND-NOARG")),
        pytest.param("N -40", "bad-number", 7, "", marks=pytest.mark.fact("UND-NONDIGIT")),
        pytest.param("N 4.5", "bad-number", 7, "", marks=pytest.mark.fact("UND-NONDIGIT")),
        pytest.param("N 4F", "bad-number", 7, "", marks=pytest.mark.fact("UND-NONDIGIT")),
        pytest.param("N A", "bad-number", 7, "", marks=pytest.mark.fact("UND-NONDIGIT")),
        pytest.param("N 65536", "range", 0, "4E 00 00", marks=pytest.mark.fact("UND-RANGE16")),
        pytest.param("N 65576", "range", 40, "4E 28 00", marks=pytest.mark.fact("UND-RANGE16")),
        pytest.param("N 0", "range", 0, "4E 00 00", marks=pytest.mark.fact("CON-N-RANGE")),
    ],
)
def test_a_badly_written_number(rig, line, code, number, stored):
    r = rig()
    r.send(f"N 7\r{line}\r")
    assert r.codes == [code] and r.x.registers["number"] == number
    r.send(f"E\r{line}\rQ")
    assert r.codes == [code, code] and r.x.program == bytes.fromhex(stored)


@pytest.mark.fact("UND-RANGE8")
@pytest.mark.parametrize(
    ("line", "kept"), [("S 261", 5), ("S 65541", 5), ("S 300", 44), ("R 255", 255), ("F 128", 128), ("Z 512", 0)]
)
def test_a_one_byte_number_is_cut_to_a_byte(rig, line, kept):
    r = rig()
    r.send(f"{line}\r")
    assert r.codes == ["range"]
    assert r.host.verify(3)["SRFZ".index(line[0]) + 2] == kept


@pytest.mark.fact("UND-EXTRAARG")
def test_a_surplus_argument_is_ignored(rig):
    r = rig()
    r.send("C 5\r")
    assert r.level("programmable_output") == 0 and r.codes == ["extra-argument"]
    r.send("E\rB 5\rQ")
    assert r.x.program == b"B" and r.codes == ["extra-argument"] * 2


@pytest.mark.fact("UND-LT-COMMAND")
@pytest.mark.parametrize(
    ("dowhile", "line", "code"),
    [
        (0, "T 2", "til-command"),
        (1, "T 2", ""),
        (1, "L 2,2", "loop-command"),
        (1, "L 0,2", "loop-command"),
        (1, "L 1,2", ""),
    ],
)
def test_branches_given_as_commands_start_the_program_or_do_nothing(rig, dowhile, line, code):
    r = rig(record=("run", "programmable_output"))
    r.drive("dowhile", dowhile)
    r.send(f"E\rB\r0\rC\r0\rQ{line}\r")
    assert [level for _, level in r.edges("run")] == ([0, 1] if code else [])
    assert [level for _, level in r.edges("programmable_output")] == ([0] if code else [])
    assert [found for found in r.codes if found != "range"] == ([code] if code else [])


@pytest.mark.fact("UND-UW-COMMAND")
@pytest.mark.parametrize(("letter", "held", "wanted"), [("U", 1, 0), ("W", 0, 1)])
def test_waits_given_as_commands_keep_ready_low_until_the_pin_has_its_level(rig, letter, held, wanted):
    r = rig()
    r.drive("wait", held)
    r.host.send(f"{letter}\r")
    r.bench.run("1 s")
    assert r.level("ready") == 0
    r.drive("wait", wanted)
    r.bench.run("10 us")
    assert r.level("ready") == 1 and r.codes == []
    r.send(f"{letter}\r")  # passes at once


@pytest.mark.fact("UND-UW-COMMAND", "UND-UW-BYTE")
def test_only_a_new_request_ends_a_wait_and_it_is_not_a_byte(rig):
    r = rig(record=("instrobe", "ready"))
    r.drive("wait", 1)
    r.host.send("U")
    r.pull_request("50 ms", b"\r", ready=True)  # the terminator's own request, held for long
    r.bench.run("40 ms")
    assert r.level("ready") == 0
    r.bench.run("60 ms")
    assert r.level("ready") == 0
    r.pull_request("1 ms", b"N")
    r.bench.run("900 us")
    assert r.level("ready") == 0  # not before the request is over
    r.bench.run("10 ms")
    assert r.level("ready") == 1 and len(r.falls("instrobe")) == 2 and r.codes == []
    r.send("N 8\r")
    assert r.x.registers["number"] == 8


@pytest.mark.fact("UND-D0")
def test_a_delay_of_0_takes_the_command_time(rig):
    r = rig(record=("ready",))
    r.send("D 0\r")
    assert r.rises("ready")[-1] - r.falls("ready")[-1] == (100 + 40) * US
    assert set(r.codes) == {"range"}


@pytest.mark.fact("UND-N0")
def test_go_with_no_steps_completes_without_a_step(rig):
    r = rig(record=("pulse", "motion_complete"))
    r.send(KNOWN + "N 0\r")
    assert r.codes == ["range"]  # and 0 is kept all the same
    r.send("G\r")
    assert r.codes == ["range", "no-steps"]
    assert not r.edges("pulse") and [level for _, level in r.edges("motion_complete")] == [0]


@pytest.mark.fact("UND-PARAM-POWERUP")
def test_a_motion_reports_every_unset_register_once(rig):
    r = rig()
    position = 0xA55A
    assert r.x.registers == dict(number=0, slope=255, rate=3, firstrate=3, divisor=1, position=position)
    r.send(f"F 3\rP {position + 1}\rP {position}\r")
    assert r.codes == ["uninitialised"] * 4
    assert {found.text.split(" uses the ")[1].split()[0] for found in r.x.findings} == {
        "slope",
        "rate",
        "divisor",
        "position",
    }

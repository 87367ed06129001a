"""What a module holds is saved and put back: whole, verified, without a step, whatever happens on the line."""

from __future__ import annotations

from itertools import count

import pytest

from slewline.chips import sheet_of
from slewline.errors import UsageError
from slewline.language.assemble import assemble
from slewline.modules.failures import ModuleFailure, MotionRefused, PortLost, RefusedCommand
from slewline.modules.programs.backup import Unfinished, pull, push
from slewline.modules.programs.contents import read_contents
from slewline.modules.programs.restore import ProgramText

from .conftest import chip_of, noise, rarely
from .random_programs import program, text

PARTS = ("gs-c200", "gs-c200s", "cy545", "cy545b")
ONE_OF_EACH = ("gs-c200s", "cy545b")  # kinds of parts, which are spoken to in the same way
NAMES = count()
DRILL = ["S10", "T100", "R40", "W1", "+250", "L0", "A2", "D1", "C2", "W2", "+120", "L4", "A1", "D5", "C1"]
WELD = ["R 100", "F 20", "S 200", "A 0", "P 700", "/W 1", "N 55", "+", "G", '"Quit?"', "L 3,18", "0"]


def lines_of(part):
    return DRILL if part.startswith("gs") else WELD


def wanted(part, lines=None):
    sheet = sheet_of(part)
    if lines is None:
        lines = lines_of(part)
        lines = lines[:-1] if lines[-1] == "0" else lines
    return ProgramText.read(text(sheet, lines), sheet, "weld")


def stored(x):
    """What the module has in its memory, from the inside."""
    memory = x.port.line.rig.bench.parts.get("memory")
    return chip_of(x).program if memory is None else memory.content


def kept(x):
    """What a module keeps without power, from the inside."""
    return chip_of(x).store.read()


def steps(x):
    return len(chip_of(x).steps())


def holds(x, program):
    return stored(x)[: len(program.stored)] == program.stored


def filled(found, part, url, lines=None):
    x = found(f"{part}?{url}")
    push(x, wanted(part, lines), "unused", keep="/dev/null")
    return x


# ---------------------------------------------------------------------------------------------------------------- pull
@pytest.mark.fact("GSC-CMD-Q-3", "CY545-QUERY-5")
@pytest.mark.parametrize("part", PARTS)
def test_a_saved_program_assembles_to_the_unchanged_content_of_the_module(found, stores, tmp_path, part):
    x = filled(found, part, stores(part))
    before = stored(x)
    x.transcript.entries.clear()
    contents = pull(x, tmp_path / f"weld.{part}")
    saved = (tmp_path / f"weld.{part}").read_text()
    assert assemble(saved, sheet_of(part), "weld").stored == wanted(part).stored == contents.stored
    assert (stored(x), steps(x)) == (before, 0)
    assert saved.startswith(f"; {part}, as read by slewline pull\n")


def test_the_text_of_a_module_has_its_program_and_the_readable_settings(found, tmp_path):
    x = filled(found, "gs-c200s", "chs=0", ["S10", "L0", "+5", "L20"])
    x.ask("f-17")
    assert pull(x, tmp_path / "a").text.splitlines() == [
        "; gs-c200s, as read by slewline pull",
        "; position -17",
        "; inputs and outputs 70",
        *("Po", "S10", "L0", "+5", "L20", "Px"),
    ]


@pytest.mark.fact("GSC-CMD-P-1", "GSC-CMD-E-2")
def test_the_text_of_a_gs_c200_has_no_e(found, tmp_path):
    x = filled(found, "gs-c200", "chs=0", ["S10", "+5"])
    assert pull(x, tmp_path / "a").text.splitlines()[3:] == [
        *("P", "S10", "+5"),
        "; E: run the program from location 0; ends programming",
    ]
    assert b"E\r" not in x.transcript.sent


def test_the_text_of_a_part_with_registers_sets_them(found, tmp_path):
    (tmp_path / "image").write_bytes(b"0\r")
    url = f"cy545?memory={tmp_path}/image"
    x = filled(found, "cy545", f"memory={tmp_path}/image", ["R 5", "+", "G"])
    for command in ("N 321", "R 7", "A 4711"):
        x.ask(command)
    saved = pull(x, tmp_path / "a").text
    lines = "N 321|R 7|F 14|S 220|O 128|A 4711|E|R 5|+|G|0|Q|Y 0"
    assert saved.splitlines()[2:] == lines.split("|")
    y = found(url)
    push(y, ProgramText.read(saved, sheet_of("cy545"), "a"), "unused", keep="/dev/null")
    assert pull(y, tmp_path / "b").text == saved


def test_a_program_is_read_as_far_as_it_goes_and_no_further(found, tmp_path):
    image = b"R 5\rJ 12\r0\rN 1\rT 3,21\r0\rF 1\r0\rjunk" + bytes([0xFF]) * 100
    (tmp_path / "image").write_bytes(image)
    x = found(f"cy545?memory={tmp_path}/image")
    contents = read_contents(x)
    assert contents.program == ("R 5", "J 12", "0", "N 1", "T 3,21", "0")  # T 3 goes to 21, the 0
    assert read_contents(x, 24).program == ("F 1", "0")
    assert x.value("pointer") == "00000"


def test_erased_memory_holds_no_program_and_that_is_reported_before_it_takes_a_minute(found):
    said = []
    contents = read_contents(found("cy545"), 65000, said.append)
    assert (contents.program, contents.stored) == ((), b"")
    assert "erased from 65000 on; the module is listing the rest of it, which takes at most 1 s" in said[0]


def test_an_unknown_instruction_ends_a_program_and_is_noted(found, tmp_path):
    (tmp_path / "image").write_bytes(b"R 5\rxyz\r")
    contents = read_contents(found(f"cy545?memory={tmp_path}/image"))
    assert contents.program == ("R 5",)
    assert contents.text.splitlines()[-1] == "; at 4 is b'xyz\\r', not an instruction: the rest was not read"


def test_content_without_a_text_form_is_in_an_image_next_to_it(found, tmp_path):
    (tmp_path / "image").write_bytes(b'R 5 \r"a;b"\r0\r')
    x, said = found(f"cy545?memory={tmp_path}/image"), []
    pull(x, tmp_path / "a.cy545", report=said.append)
    assert "cannot represent all of the program" in said[-1]
    image = (tmp_path / "a.cy545.ihx").read_text()
    assert image.startswith(":0D00000052203520") and image.endswith(":00000001FF\n")


@rarely("part", PARTS, quick=ONE_OF_EACH)
@rarely("seed", range(20), quick=[1])
def test_noise_changes_nothing_in_what_is_saved(found, stores, tmp_path, part, seed):
    x = filled(found, part, stores(part))
    for kind, to in (("parity", "host"), ("garbled", "host"), ("lost", "host"), ("lost", "chip")):
        noise(x, to).plan(kind, 1000, 0.004, seed)
    contents = pull(x, tmp_path / "a")
    assert contents.stored == wanted(part).stored
    assert (holds(x, wanted(part)), steps(x)) == (True, 0)


def test_a_line_that_is_too_noisy_saves_nothing(found, tmp_path):
    x = filled(found, "gs-c200s", "chs=0")
    noise(x).plan("parity", 10000, 0.1)
    with pytest.raises(ModuleFailure, match="noise"):
        pull(x, tmp_path / "a")
    assert not [*tmp_path.iterdir()]


@pytest.mark.fact("GSC-EEPROM-4", "GSC-UND-M-REPLY")
def test_a_module_that_saves_for_a_session_that_was_cut_off_is_waited_for(found, tmp_path):
    x = filled(found, "gs-c200s", "chs=0&eeprom_time=3 s", ["T100"] * 25)
    x.send(x.speech.framed("M"))
    assert pull(x, tmp_path / "a").stored == stored(x)
    assert ("module", b"B\r") in x.transcript.entries, "it was not busy"


def test_a_busy_module_is_not_disturbed(found, tmp_path):
    x = filled(found, "gs-c200s", "chs=0", ["S10", "T100", "R5", "+5000"])
    x.may_move = True
    x.ask("E")
    with pytest.raises(RefusedCommand, match=r"V2 was answered with B: busy; a program or a motion is in progress"):
        pull(x, tmp_path / "a")
    x.port.pause(10)
    assert (steps(x), [*tmp_path.iterdir()]) == (5000, [])


# --------------------------------------------------------------------------------------- what is kept without power
@pytest.mark.fact("GSC-CMD-X-1", "GSC-CMD-X-2")
@pytest.mark.parametrize("part", ["gs-c200", "gs-c200s"])
@pytest.mark.parametrize("ram", [DRILL, []])
def test_the_program_of_the_eeprom_is_saved_and_ram_is_put_back(found, tmp_path, part, ram):
    x = filled(found, part, "chs=0", ["S99", "+5"])
    x.ask("M")
    push(x, wanted(part, ram), "unused", keep="/dev/null")
    before, other = stored(x), kept(x)
    pull(x, tmp_path / f"weld.{part}", recall=True)
    assert (stored(x), kept(x), steps(x)) == (before, other, 0)
    assert "\nS99\n+5\n" in (tmp_path / f"weld.eeprom.{part}").read_text()
    assert "".join(f"{line}\n" for line in ram) in (tmp_path / f"weld.{part}").read_text()


def test_an_eeprom_that_holds_nothing_valid_leaves_ram_alone(found, tmp_path):
    x, said = filled(found, "gs-c200s", "chs=0"), []
    chip_of(x).store.write(b"\xff")
    pull(x, tmp_path / "weld", recall=True, report=said.append)
    assert "X was answered with E6: the EEPROM failed; no program was saved from the EEPROM" in said[-1]
    assert holds(x, wanted("gs-c200s"))


def test_ram_that_cannot_be_restored_is_in_its_file_and_that_is_reported(found, tmp_path):
    x = filled(found, "gs-c200s", "chs=0", ["S99"])
    x.ask("M")
    push(x, wanted("gs-c200s"), "unused", keep="/dev/null")
    write, sent = x.port.write, []

    def cut(data):
        sent.append(data)
        if data == b"T100\r":
            raise PortLost("the cable is gone")
        return write(data)

    x.port.write = cut
    with pytest.raises(
        Unfinished, match=r"cable is gone\n.*was not restored.*answers show: it holds 1 of 15 instructions; program"
    ):
        pull(x, tmp_path / "weld", recall=True)
    assert "\nW2\n" in (tmp_path / "weld").read_text()
    assert "\nS99\n" in (tmp_path / "weld.eeprom").read_text()


def test_a_part_with_one_program_has_no_eeprom_to_save(found, tmp_path):
    with pytest.raises(UsageError, match="--eeprom: the CY545 has one program"):
        pull(found("cy545"), tmp_path / "a", recall=True)


# --------------------------------------------------------------------------------------------------------------- files
def test_an_existing_file_is_not_replaced_unless_requested(found, tmp_path):
    x = filled(found, "gs-c200s", "chs=0")
    (tmp_path / "weld.eeprom").write_text("mine")
    with pytest.raises(UsageError, match=r"weld\.eeprom: this file exists; name a new file, or give --replace"):
        pull(x, tmp_path / "weld", recall=True)
    assert not (tmp_path / "weld").exists()
    pull(x, tmp_path / "weld", recall=True, replace=True)


@pytest.mark.skipif(not __import__("os").path.exists("/dev/full"), reason="has no disk that is always full")
def test_a_full_disk_lets_nothing_be_sent(found):
    x = filled(found, "gs-c200s", "chs=0", ["S10"])
    x.transcript.entries.clear()
    with pytest.raises(UsageError, match="/dev/full cannot be written: No space left"):
        pull(x, "/dev/full", replace=True)
    with pytest.raises(UsageError, match="/dev/full "):
        push(x, wanted("gs-c200s"), "weld", keep="/dev/full", store=True)
    assert {line for line in x.transcript.sent.split(b"\r") if line} == {b"V1", b"V2", b"Q"}
    assert x.ask("Q").lines == ("S10", "END")


def test_the_old_content_is_saved_under_a_name_that_is_free(found, tmp_path):
    x, weld = filled(found, "gs-c200s", "chs=0", ["S1"]), tmp_path / "weld.gs-c200s"
    for number, lines in ((2, ["S2"]), (3, ["S3"]), (4, ["S2"])):
        push(x, wanted("gs-c200s", lines), weld)
        assert x.ask("Q").lines == (*lines, "END"), number
    names = sorted(path.name for path in tmp_path.iterdir())
    assert names == ["weld.before-2.gs-c200s", "weld.before-3.gs-c200s", "weld.before.gs-c200s"]
    assert "\nS1\n" in (tmp_path / "weld.before.gs-c200s").read_text()
    assert "\nS2\n" in (tmp_path / "weld.before-2.gs-c200s").read_text()


def test_a_given_name_for_the_old_content_must_be_free(found, tmp_path):
    x = filled(found, "gs-c200s", "chs=0", ["S1"])
    (tmp_path / "mine").write_text("mine")
    with pytest.raises(UsageError, match="mine: this file exists"):
        push(x, wanted("gs-c200s"), "weld", keep=tmp_path / "mine")
    assert x.ask("Q").lines == ("S1", "END")


# ---------------------------------------------------------------------------------------------------------------- push
@pytest.mark.parametrize("part", PARTS)
def test_a_program_is_sent_and_verified_without_a_step(found, stores, tmp_path, part):
    x, said = found(f"{part}?{stores(part)}"), []
    push(x, wanted(part), tmp_path / "weld", report=said.append)
    assert holds(x, wanted(part))
    assert steps(x) == 0
    assert any(line.startswith("verified: ") for line in said)
    assert said[-1].startswith("the module holds the program (verified)")


@pytest.mark.fact("GSC-CMD-M-1", "GSC-CMD-M-2")
@pytest.mark.parametrize("part", ["gs-c200", "gs-c200s"])
def test_m_is_sent_only_after_the_listing_has_agreed(found, tmp_path, part):
    x = found(f"{part}?chs=0")
    push(x, wanted(part), tmp_path / "weld", store=True)
    assert kept(x) == wanted(part).stored
    sent = x.transcript.sent.split(b"\r")
    assert sent.index(b"M") > len(sent) - 4
    assert b"E" not in sent
    assert b"Q" in sent[sent.index(b"C1") : sent.index(b"M")]


@pytest.mark.parametrize("part", ["gs-c200", "gs-c200s"])
def test_a_listing_that_never_agrees_lets_nothing_be_stored(found, tmp_path, part):
    x = found(f"{part}?chs=0")
    chip = chip_of(x)
    query = type(chip._commands).do_query

    async def wrong(self):
        return (await query(self)).replace("T100", "T101")

    chip._commands.handlers["Q"] = wrong.__get__(chip._commands)
    with pytest.raises(
        Unfinished, match=r"instruction 2 is listed as T101, but was sent as T100; the program was not stored"
    ) as how:
        push(x, wanted(part), tmp_path / "weld", store=True)
    assert "the program in its EEPROM is unchanged" in str(how.value)
    assert b"M\r" not in x.transcript.sent
    assert kept(x) == b""


def test_a_module_that_refuses_a_line_in_the_middle_is_reported_with_its_content(found, tmp_path):
    x = filled(found, "gs-c200s", "chs=0", ["S99"])
    x.ask("M")
    take, taken = chip_of(x)._stored.store, []

    def full(command):
        taken.append(command)
        return len(taken) <= 3 and take(command)

    chip_of(x)._stored.store = full
    with pytest.raises(Unfinished, match=r"answered with E3: program memory full.*\n.*it holds 3 of 15 instr") as told:
        push(x, wanted("gs-c200s"), tmp_path / "weld", store=True)
    assert f"the old program is in {tmp_path}/weld.before" in str(told.value)
    assert (kept(x), b"M\r" in x.transcript.sent.partition(b"W1")[2]) == (wanted("gs-c200s", ["S99"]).stored, False)


@pytest.mark.parametrize("store", [False, True])
def test_existing_content_is_not_sent_again(found, tmp_path, store):
    x, said = filled(found, "gs-c200s", "chs=0"), []
    x.transcript.entries.clear()
    push(x, wanted("gs-c200s"), tmp_path / "weld", store=store, report=said.append)
    assert "the module already holds this program" in said
    assert set(x.transcript.sent.split(b"\r")) - {b""} == {b"V1", b"V2", b"Q", *([b"M"] if store else [])}
    assert not [*tmp_path.iterdir()]


def test_an_eeprom_that_fails_is_reported_and_the_program_stays_in_ram(found, tmp_path):
    x = found("gs-c200s?chs=0&eeprom_fault=true")
    with pytest.raises(Unfinished, match=r"M was answered with E6.*\n.*was not stored \(E6: the EEPROM fa"):
        push(x, wanted("gs-c200s"), tmp_path / "weld", store=True)
    assert holds(x, wanted("gs-c200s"))


@rarely("part", PARTS, quick=ONE_OF_EACH)
@rarely("seed", range(20), quick=[0])
def test_noise_stops_no_push_and_causes_no_step(found, stores, tmp_path, part, seed):
    x = found(f"{part}?{stores(part)}")
    kinds = ("parity", "garbled", "lost") if part.startswith("gs") else ("lost",)
    for kind in kinds:
        for to in ("host", "chip"):
            noise(x, to).plan(kind, 1000, 0.004, seed)
    push(x, wanted(part), tmp_path / "weld", store=part.startswith("gs"))
    assert (holds(x, wanted(part)), steps(x)) == (True, 0)


def test_a_register_that_reads_back_another_value_is_set_again(found, stores, tmp_path):
    x = found(f"cy545?{stores('cy545')}")
    ask, altered = x.ask, []

    def ask_altered(command):
        if command == "N 321" and not altered:
            altered.append(command)
            command = "N 322"
        return ask(command)

    x.ask = ask_altered
    push(x, ProgramText.read("N 321\nE\nR 5\n0\nQ\n", sheet_of("cy545"), "a"), tmp_path / "a")
    assert (altered, int(x.value("number"))) == (["N 321"], 321)


def test_program_entry_that_was_not_begun_is_noticed_before_a_command_that_steps_is_sent(found, stores, tmp_path):
    x = found(f"cy545?{stores('cy545')}")
    put, lost = x.port.write, []

    def write(data):
        if data == b"E" and len(lost) < 5:
            lost.append(data)
            return put(b"")
        return put(data)

    x.port.write = write
    push(x, wanted("cy545"), tmp_path / "weld")
    assert (len(lost), steps(x), holds(x, wanted("cy545"))) == (5, 0, True)


@pytest.mark.parametrize("first", ["G", "P 300", "H 1", "J 0"])
def test_a_program_that_begins_with_a_step_is_sent_as_safely(found, stores, tmp_path, first):
    x = found(f"cy545?{stores('cy545')}")
    put, lost = x.port.write, []

    def write(data):
        if data == b"E" and len(lost) < 3:
            lost.append(data)
            return put(b"")
        return put(data)

    x.port.write = write
    program = wanted("cy545", [first, "R 5", "G"])
    push(x, program, tmp_path / "weld")
    assert (len(lost), steps(x), holds(x, program)) == (3, 0, True)


def test_a_program_that_begins_with_a_step_needs_room_for_a_question(found, tmp_path):
    (tmp_path / "image").write_bytes(b"R 5\r0\r".ljust(65528, b"\xff") + b"R 1\rR 2\r")
    x = found(f"cy545?memory={tmp_path}/image")
    before = stored(x)
    with pytest.raises(Unfinished, match=r"begins with G, which would step the motor .*no room at 65528 for a query"):
        push(x, wanted("cy545", ["G"]), tmp_path / "weld")
    assert stored(x) == before


@pytest.mark.parametrize("part", ["cy545", "cy545b"])
def test_a_slow_eeprom_loses_nothing(found, stores, tmp_path, part):
    x = found(f"{part}?{stores(part)}")
    push(x, wanted(part), tmp_path / "weld")
    assert holds(x, wanted(part))
    assert not [each for each in chip_of(x).findings if each.code == "serial-overrun"]


@pytest.mark.parametrize("line", ["E", "H+"])
def test_a_command_outside_the_program_that_may_step_is_refused_before_anything_is_sent(found, tmp_path, line):
    sheet = sheet_of("gs-c200s")
    x = found("gs-c200s?chs=0")
    x.transcript.entries.clear()
    program = ProgramText.read(f"Po\nS10\n{'E' if line == 'E' else 'Px'}\n{line}\n", sheet, "weld")
    with pytest.raises(MotionRefused, match=rf"weld, line 4: {line[0]}\S* may step the motor.*no command was sent"):
        push(x, program, tmp_path / "weld")
    assert not x.transcript.entries


@pytest.mark.parametrize(
    ("text", "says"),
    [
        (
            "Po\nS10\nPx\n@wait 5 ms\n",
            "weld, line 4: @wait 5 ms is only for slewline run; allowed: commands of the GS-C200S",
        ),
        ("f+5\n", "has no program; write Po before"),
        ("Po\n+50,\n", "50, does not fit"),
    ],
)
def test_an_invalid_program_text_is_refused(text, says):
    with pytest.raises(Exception, match=says.replace("+", r"\+")):
        ProgramText.read(text, sheet_of("gs-c200s"), "weld")


# ---------------------------------------------------------------------------------------------------------------- cuts
class Cut:
    """A cable that is cut before the number-th writing."""

    def __init__(self, x, number):
        self.write, self.left, self.x = x.port.write, number, x
        x.port.write = self

    def __call__(self, data):
        self.left -= 1
        if self.left < 0:
            raise PortLost(f"{self.x.port.where}: the port is gone")
        return self.write(data)


@rarely("part", PARTS, quick=ONE_OF_EACH)
@rarely("at", range(0, 160, 4), quick=[0, 40])
def test_a_cut_cable_is_reported_with_the_content_of_the_module_and_the_next_push_resumes(
    found, stores, tmp_path, part, at
):
    url = f"{part}?{stores(part)}&name=cut{next(NAMES)}"
    x = found(url)
    push(x, wanted(part, lines_of(part)[:3]), tmp_path / "old", store=part.startswith("gs"))
    old = kept(x) if part.startswith("gs") else None
    before = stored(x)
    Cut(x, at)
    try:
        push(x, wanted(part), tmp_path / "weld", store=part.startswith("gs"))
    except Unfinished as cut:
        assert f"contents of {part} at slewline://{url}, as far as its answers show: " in str(cut)
        assert f"the old program is in {tmp_path}/weld.before" in str(cut)
        if "keeps" not in str(cut):
            assert before[:5] == stored(x)[:5]
        if old is not None and "it is unknown whether it was stored" not in str(cut):
            assert kept(x) == old
    except PortLost:
        assert stored(x) == before
    assert steps(x) == 0
    x.port.close()
    y = found(url)
    push(y, wanted(part), tmp_path / "weld", store=part.startswith("gs"))
    assert (holds(y, wanted(part)), steps(y)) == (True, 0)
    saved = (tmp_path / "weld.before").read_text() if (tmp_path / "weld.before").exists() else ""
    assert "".join(f"{line}\n" for line in lines_of(part)[:3]) in saved
    if old is not None:
        assert kept(y) == wanted(part).stored


# ------------------------------------------------------------------------------------------------------ the same bytes
@rarely("part", PARTS, quick=ONE_OF_EACH)
@pytest.mark.parametrize("seeds", [range(1), pytest.param(range(1, 200), marks=pytest.mark.long)])
@pytest.mark.timeout(3600)
def test_a_program_pulled_and_pushed_into_another_module_is_the_same_there(found, stores, tmp_path, part, seeds):
    sheet = sheet_of(part)
    for seed in seeds:
        image = f"memory={tmp_path}/image" if part.startswith("cy") else stores(part)
        (tmp_path / "image").write_bytes(text_bytes(sheet, program(sheet, seed)))
        x = found(f"{part}?{image}")
        if part.startswith("gs"):
            push(x, ProgramText.read(text(sheet, program(sheet, seed)), sheet, "a"), "a", keep="/dev/null")
        one = pull(x, tmp_path / "one", replace=True)
        (tmp_path / "image").write_bytes(b"0\r")
        y = found(f"{part}?{image}")
        push(y, ProgramText.read(one.text, sheet, "one"), "one", keep="/dev/null", pace=0.0005)
        pull(y, tmp_path / "two", replace=True)
        assert (tmp_path / "one").read_bytes() == (tmp_path / "two").read_bytes(), seed
        assert one.stored, seed
        assert steps(x) == steps(y) == 0
        x.port.close()
        y.port.close()


def text_bytes(sheet, lines):
    return "".join(f"{line}\r" for line in [*lines, "0"]).encode()

"""Run scripts for a chipset that takes packets: commands with what they return, waits for status bits, expectations."""

from __future__ import annotations

from contextlib import suppress

import pytest

import slewline
from slewline.bench import load
from slewline.bench.scripts.script import read_script, run_script
from tests.rows import rows

NS, US, MS = 10**3, 10**6, 10**9  # picoseconds
MOVE = "SET_POS 50\nSET_VEL 65536\nSET_ACC 8192\nUPDATE\n"


class Played:
    """A script on a bench with one chipset, x: `said` is (ps, what) of every line and note."""

    def __init__(self, text, part="mc1451a", timeout="60 s", **options):
        self.bench = slewline.Bench(**options)
        self.x = self.bench.add(part, name="x")
        self.host = self.bench.host(self.x)
        self.said = []
        self.host.on_event.add(lambda text: self.said.append((self.bench.now_ps, text)))
        run_script(self.bench, self.host, text)
        self.bench.run_until_idle(timeout)

    @property
    def texts(self):
        return [text for _, text in self.said]

    def when(self, text):
        """The only instant at which something was said."""
        (time,) = [time for time, said in self.said if said == text]
        return time

    @property
    def codes(self):
        return [found.code for found in self.bench.findings]


# ------------------------------------------------------------------------------------------------------------ commands
def test_commands_print_their_return_values():
    played = Played(
        "GET_VRSN\nSET_2\nset_pos $3039\nGET_POS  ; back\nSET_RATIO -5\nGET_RATIO\nGET_MODE\nGET_STATUS\nUPDATE"
    )
    assert played.texts == [
        "GET_VRSN -> 0x5C11",
        "SET_2 -> 0x1300 (motor_on axis_on axis=2)",
        "set_pos $3039",
        "GET_POS -> 12345",
        "SET_RATIO -5",
        "GET_RATIO -> -5",
        "GET_MODE -> 0x0000",
        "GET_STATUS -> 0x1300 (motor_on axis_on axis=2)",
        "UPDATE",
    ]
    assert [tuple(result) for result in played.host.results] == [
        (1, "GET_VRSN", 0x5C11),
        (2, "SET_2", 0x1300),
        (2, "GET_POS", 12345),
        (2, "GET_RATIO", -5),
        (2, "GET_MODE", 0),
        (2, "GET_STATUS", 0x1300),
    ]


def test_a_script_takes_exactly_the_time_of_a_host_that_sends_the_same():
    played = Played(MOVE + "GET_STATUS")
    bench = slewline.Bench()
    x = bench.add("mc1451a", name="x")
    host = bench.host(x)
    host.send(MOVE)
    host.query("GET_STATUS")
    assert played.said[-1][0] == bench.now_ps
    bench.run_until_idle()
    assert played.host.received == host.received
    assert (played.x.steps().times_ps == x.steps().times_ps).all() and len(x.steps()) == 50


# ----------------------------------------------------------------------------------------------------------- directives
@pytest.mark.parametrize("steps", [900, 40])
@pytest.mark.parametrize("part", ["mc1151a", "mc1451a-e"])
def test_omitted_status_queries_change_neither_steps_nor_times(part, steps):
    found = {}
    for sparse in (False, True):
        bench = slewline.Bench()
        x = bench.add(part, name="x")
        host = bench.host(x)
        host.port.sparse = sparse
        run_script(bench, host, f"SET_VEL 9000\nSET_ACC 90\nSET_POS {steps}\nUPDATE\nwait motion_complete\nGET_POS")
        for _ in range(20):  # the wait continues from run to run
            with suppress(slewline.Timeout):
                bench.run_until_idle("137 ms")
                break
        found[sparse] = (bench.now_ps, x.steps().times_ps.tolist(), host.received[-4:], len(host.received))
    *one, all_words = found[False]
    *two, few_words = found[True]
    assert one == two and len(one[1]) == steps
    assert few_words < all_words / 10


@pytest.mark.parametrize("at", ["", "@"])
def test_wait_for_a_status_bit_queries_the_current_axis(at):
    played = Played(f"SET_2\n{MOVE}{at}wait motion_complete\nGET_TRGT_POS\nSET_1\n{at}wait !in_motion")
    assert played.texts[5:] == [
        "wait motion_complete -> 0x1301 (motion_complete motor_on axis_on axis=2)",
        "GET_TRGT_POS -> 50",
        "SET_1 -> 0x0300 (motor_on axis_on axis=1)",
        "wait !in_motion -> 0x0300 (motor_on axis_on axis=1)",
    ]


def test_wait_not_in_motion_after_an_update_waits_for_the_motion():
    played = Played(f"{MOVE}wait !in_motion\nGET_TRGT_POS\nexpect 50")
    assert played.texts[-1] == "GET_TRGT_POS -> 50" and not played.codes


NEVER = "and no event is pending, so the bit cannot change"


@pytest.mark.parametrize(
    ("text", "found"),
    [
        (
            "SET_POS 50\nSET_VEL 65536\nUPDATE\n",
            f"wait motion_complete: axis 1 is at rest {NEVER}; "
            "no-start at 4.26084 ms: axis 1: UPDATE while acceleration is 0: no motion starts; send SET_ACC before it",
        ),
        ("SET_2\nSET_POS 50\nSET_VEL 65536\n", f"wait motion_complete: axis 2 is at rest {NEVER}"),
    ],
)
def test_wait_for_a_motion_that_cannot_complete_is_given_up_immediately(text, found):
    played = Played(f"{text}wait motion_complete\nGET_TRGT_POS")
    (expected,) = [each for each in played.bench.findings if each.code == "expect"]
    assert expected.text == found and played.bench.now_ps < 10 * MS
    assert played.texts[-1] == "GET_TRGT_POS -> 0"  # and the script goes on


@pytest.mark.parametrize("part", ["mc1151a", "mc1451a"])
def test_a_wait_that_is_given_up_names_no_finding_after_which_the_axis_has_moved(part):
    late = "SET_POS 50\nSET_VEL 65536\nUPDATE\nwait 2 ms\nSET_ACC 8192\nUPDATE\nwait motion_complete\nCLR_STATUS\n"
    played = Played(f"{late}wait motion_complete", part)
    assert played.codes == ["no-start", "expect"]
    assert played.bench.findings[-1].text == f"wait motion_complete: axis 1 is at rest {NEVER}"


@pytest.mark.parametrize(
    ("text", "complete"),
    [
        ("SET_BRK_PNT 100\nSET_TIME_BRK\n", 0x305),  # a breakpoint that waits for a time ...
        ("SET_EXT_BRK\n@drive home1=0@40 ms\n", 0x305),  # ... or for HOME
        ("@drive poslimit1=1@40 ms\n", 0x321),  # an input that somebody will drive
    ],
)
def test_wait_is_not_given_up_while_something_may_come(text, complete):
    move = MOVE.replace("UPDATE\n", text)
    played = Played(f"{move}wait motion_complete")
    assert played.texts[-1].startswith(f"wait motion_complete -> 0x{complete:04X}") and "expect" not in played.codes


def test_wait_is_not_given_up_while_a_breakpoint_waits_for_an_input():
    bench = slewline.Bench()
    x = bench.add("mc1451a", name="x")
    host = bench.host(x)
    run_script(bench, host, MOVE.replace("UPDATE\n", "SET_EXT_BRK\nwait motion_complete\n"))
    bench.run("50 ms")
    x.pin("home1").drive(0)
    bench.run_until_idle()
    assert x.position == 50 and not bench.findings


def test_a_rate_with_its_unit_shows_the_number_that_is_sent():
    played = Played("SET_VEL 12345 steps/s\nGET_VEL\nexpect 265107\nSET_ACC 0.5 steps/cycle2")
    assert played.texts == ["SET_VEL 12345 steps/s = 265107", "GET_VEL -> 265107", "SET_ACC 0.5 steps/cycle2 = 32768"]
    assert played.codes == ["no-update"]


@pytest.mark.parametrize("at", ["", "@"])
def test_wait_for_a_time(at):
    played = Played(f"GET_VRSN\n{at}wait 20 ms\n@note over")
    assert played.when("over") - played.when("GET_VRSN -> 0x5C11") == 20 * MS


def test_wait_in_capitals_is_not_a_command():
    assert Played("WAIT 1 ms\nWait motor_on").texts == ["wait motor_on -> 0x0300 (motor_on axis_on axis=1)"]


@rows("expected", ["-5", "0xFFFFFFFB", "$fffffffb", "-0x5"])
def test_an_expected_value_may_have_any_notation(expected):
    assert Played(f"SET_POS -5\nGET_POS\nexpect {expected}\n@expect {expected}").codes == ["no-update"]


def test_anything_else_is_a_finding_and_the_script_continues():
    played = Played("SET_POS 5\nGET_POS\nexpect 6\nexpect 5\nGET_STATUS\n@expect 0x0301\nGET_POS")
    assert [found.text for found in played.host.findings] == [
        "GET_POS of axis 1 returned 5, expected 6",
        "GET_STATUS of axis 1 returned 0x0300 (motor_on axis_on axis=1), expected 0x0301",
    ]
    assert played.texts[-1] == "GET_POS -> 5"


def test_nothing_can_be_expected_before_a_query():
    with pytest.raises(slewline.ProgramError, match=r"line 2, column 1: no command above has returned a value"):
        Played("SET_POS 5\nexpect 5")


def test_bytes_are_sent_unchanged():
    played = Played("@bytes 11 00 02 c0 00\nGET_VEL\nSET_2\n@bytes 01\nGET_STATUS\n@bytes 10 00 00\nGET_VEL")
    assert played.texts == [
        "bytes 11 00 02 C0 00",
        "GET_VEL -> 180224",
        "SET_2 -> 0x1300 (motor_on axis_on axis=2)",
        "bytes 01",
        "GET_STATUS -> 0x0300 (motor_on axis_on axis=1)",
        "bytes 10 00 00",
        "GET_VEL -> 180224",
    ]
    assert [result.axis for result in played.host.results] == [1, 2, 1, 1]


def test_pins_and_positions_as_with_other_chips():
    played = Played(
        f"SET_2\n{MOVE}@until atrest2=0\n@note begun\n@until position=20\n@note there\n@drive home2=0\n"
        "@wait 1 ms\nGET_HOME\n@release home2\n@wait 1 ms\nGET_HOME"
    )
    times = played.x.axis(2).steps().times_ps
    assert played.when("begun") < times[0]
    assert played.when("there") == times[19]
    assert [text for text in played.texts if "HOME" in text] == ["GET_HOME -> 0x000D", "GET_HOME -> 0x000F"]


class Turned:
    """A script on a bench with an encoder, shaft, that turns with axis 1 of x: a count for a step."""

    def __init__(self, text, **options):
        self.bench = slewline.Bench(**options)
        self.x = self.bench.add("mc1151a-e", name="x")
        self.bench.part("encoder", name="shaft", to=self.x, counts=400, steps=400)
        self.host = self.bench.host(self.x)
        run_script(self.bench, self.host, text)


BLOCKED = (
    f"{MOVE}@until position=20\n@tell shaft block\nwait motion_complete\n@tell shaft push -3\n@wait 1 ms\nGET_ACTL_POS"
)


def test_a_part_can_receive_a_message(tmp_path):
    turned = Turned(BLOCKED, journal=tmp_path / "run.jsonl")
    turned.bench.run_until_idle()
    assert turned.x.position == 50 and turned.host.results[-1].value == 17
    again = slewline.replay(tmp_path / "run.jsonl")
    assert again["host"].results == turned.host.results


@rows(
    ("line", "found"),
    [
        ("@tell motor block", "the bench has no part 'motor'; available: shaft, host"),
        ("@tell shaft turn 5", "tell shaft 'turn'; allowed 'block', 'free', 'slip', 'push'"),
        ("@tell host wait", "tell host 'wait'; a script cannot operate this part"),
        ("@tell shaft slip five", "'shaft slip five'; expected PART VERB or PART VERB NUMBER"),
        ("@tell shaft", "'shaft'; expected PART VERB"),
    ],
)
def test_commands_unknown_to_every_part_are_refused_before_anything_is_sent(line, found):
    with pytest.raises(slewline.ProgramError) as raised:
        Turned(f"SET_POS 5\n{line}")
    assert str(raised.value).startswith("script, line 2, column 1: ") and found in str(raised.value)


def test_reset_and_power():
    played = Played(
        "SET_2\nSET_POS 5\n@reset\nGET_STATUS\nGET_POS\nSET_POS 7\n@power off\n@wait 1 ms\n@power on\nGET_POS"
    )
    assert played.texts[2:] == [
        "GET_STATUS -> 0x0300 (motor_on axis_on axis=1)",
        "GET_POS -> 0",
        "SET_POS 7",
        "power off",
        "power on",
        "GET_POS -> 0",
    ]


def test_two_chipsets_of_one_bus():
    bench = slewline.Bench()
    x, y = bench.add("mc1451a", name="x"), bench.add("mc1151a", name="y")
    host = bench.host(x, y)
    run_script(bench, host, "SET_3\nSET_POS 1\n@to y\nSET_POS 2\nGET_VRSN\nexpect 0x4411\n@to x\nGET_POS\nexpect 1")
    bench.run_until_idle()
    assert (x.axis(3).registers["pos"], y.registers["pos"]) == (1, 2)
    assert [found.code for found in bench.findings] == ["no-update"] * 2


# ----------------------------------------------------------------------------------------------------------- mistakes
@rows(
    ("line", "column", "found"),
    [
        ("SET_PO 5", 3, "SET_PO is not a command of the MC1151A"),
        ("SET_POS", 10, "SET_POS without position"),
        ("SET_POS 5e3", 11, "SET_POS position 5e3"),
        ("SET_VEL 0x40000000", 11, "SET_VEL velocity 0x40000000: allowed 0..1073741823"),
        ("SET_2", 3, "SET_2 is not a command of the MC1151A"),
        ("wait 20", 3, "time '20': expected a number and a unit"),
        ("wait", 3, "@wait needs an argument"),
        ("wait moving", 3, "no status bit 'moving'"),
        ("@wait !moving", 3, "no status bit 'moving'"),
        ("expect five", 3, "'five': expected a decimal number, or a hexadecimal number after 0x or $"),
        ("@live B", 3, "a directive for a chip that takes letters; x (mc1151a) takes packets"),
        ("@rate 60", 3, "takes packets"),
        ("@read position", 3, "takes packets"),
        ("@verify 0", 3, "takes packets"),
        ("@ask V1", 3, "a directive for a module on a serial line; x (mc1151a) has a bus"),
        ("@until position=1073741824", 3, "1073741824: allowed -1073741824..1073741823"),
        ("@drive home2=0", 3, "x (mc1151a) has no pin 'home2'"),
    ],
)
def test_unsuitable_commands_are_refused_with_their_place_before_anything_is_sent(line, column, found):
    bench = slewline.Bench()
    host = bench.host(bench.add("mc1151a", name="x"))
    with pytest.raises(slewline.ProgramError) as raised:
        run_script(bench, host, f"SET_POS 5\n  {line}\nUPDATE", "x.mc1151a")
    assert str(raised.value).startswith(f"x.mc1151a, line 2, column {column}: ")
    assert found in str(raised.value)
    assert host.idle and len(raised.value.problems) == 1


@pytest.mark.parametrize("line", ["@wait motion_complete", "@expect 5"])
def test_other_chips_have_no_status_bits(line):
    bench = slewline.Bench()
    host = bench.host(bench.add("cy525", name="x"))
    with pytest.raises(slewline.ProgramError, match=r"for a chipset that takes packets; x \(cy525\) takes none"):
        run_script(bench, host, line)


def test_to_other_chips_wait_without_an_at_is_bytes():
    bench = slewline.Bench()
    x = bench.add("cy525", name="x")
    run_script(bench, bench.host(x), "wait 1 ms\nexpect 5")
    bench.run_until_idle()
    assert {found.code for found in x.findings} == {"unknown-command"}


def test_a_script_is_read_without_knowing_the_chip():
    assert read_script("SET_POS 5\nwait 20\nwait motion_complete").problems == ()


# -------------------------------------------------------------------------------------------------- journal, bench file
def test_a_journal_plays_a_script_again(tmp_path):
    path = tmp_path / "run.jsonl"
    text = (
        f"SET_2\n{MOVE}wait motion_complete\nGET_TRGT_POS\nexpect 51\n@bytes 01\n@drive home1=0\n@wait 1 ms\nGET_HOME"
    )
    played = Played(text, journal=path)
    again = slewline.replay(path)
    assert again["host"].results == played.host.results and again["host"].received == played.host.received
    assert again.findings == played.bench.findings and len(again.findings) == 1
    assert (again["x"].axis(2).steps().times_ps == played.x.axis(2).steps().times_ps).all()


def test_a_bench_file_gives_the_host_its_script(tmp_path):
    path = tmp_path / "two.toml"
    (tmp_path / "x.mc1451a").write_text(f"{MOVE}wait motion_complete\nGET_TRGT_POS\n")
    path.write_text('[[chip]]\npart = "mc1451a"\nname = "x"\n[[host]]\nfile = "x.mc1451a"\ndelay = "10 us"\n')
    bench = load(path)
    bench.run_until_idle()
    assert bench["x"].position == 50
    assert bench["host"].results[-1].value == 50


def test_a_host_whose_script_was_refused_continues_with_the_next_one():
    bench = slewline.Bench()
    x = bench.add("mc1151a", name="x")
    host = bench.host(x)
    run_script(bench, host, "SET_POS 5\nwait motion_complete\nGET_POS")
    bench.run("3277.8 us")  # the checksum of the first packet is about to be read
    x.reset()
    with pytest.raises(slewline.ProgramError, match="checksum"):
        bench.run("100 ms")
    assert host.idle  # what stood behind the refused line is gone
    bench.run("100 ms")
    host.command("SET_POS", 7)
    assert host.query("GET_POS") == 7

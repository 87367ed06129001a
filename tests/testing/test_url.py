"""A pySerial program that opens slewline://gs-c200s, in virtual time: exact bytes at exact instants."""

from __future__ import annotations

import ast
import subprocess
import sys
import warnings
from itertools import cycle
from pathlib import Path
from threading import Event, Thread
from time import perf_counter

import pytest
import serial
import serial.threaded

import slewline.testing  # makes pySerial know the URL
from slewline.errors import StoreError, Timeout, UsageError
from slewline.language.lines import framed
from slewline.testing import protocol_slewline, rig

SETTINGS = {"baudrate": 9600, "bytesize": 7, "parity": "O", "stopbits": 2, "timeout": 1}
CHARACTER_PS = 11 * 10**12 // 9600
PROGRAM = ("Po", "S10", "T100", "R50", "+200")


@pytest.fixture
def opened():
    """Opens ports; named modules are forgotten at the end."""
    ports = []

    def make(url="slewline://gs-c200s", **changes):
        ports.append(serial.serial_for_url(url, **{**SETTINGS, **changes}))
        return ports[-1]

    yield make
    for port in ports:
        port.close()


def ask(port, command):
    """What comes back for a command, checksum and carriage return included."""
    port.write(framed(command))
    return port.read_until(b"\r")


# ------------------------------------------------------------------------------------------------------------ programs
def asleep(port, real_s):
    """A program that was away for so many seconds of the wall clock."""
    clock = port.rig.pace.clock
    port.rig.pace.clock = lambda: clock() + int(real_s * 1e9)


def test_a_program_that_sleeps_while_the_module_is_busy_is_warned_once(opened):
    port = opened()
    asleep(port, 5)  # before anything has been sent
    for command in (*PROGRAM, "E"):
        ask(port, command)
    asleep(port, 2)
    with pytest.warns(UserWarning, match=r": 2.0 s of real time have passed, but no virtual time") as seen:
        assert ask(port, "V1") == b"BR\r"
    assert seen[0].filename == __file__
    assert "call port.sleep(...) instead of time.sleep(...), or give a rate in the URL, rate=1." in str(seen[0].message)
    asleep(port, 2)
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        ask(port, "V1")


@pytest.mark.parametrize(("url", "real_s"), [("?rate=1", 2), ("", 0.5)])
def test_a_program_that_is_away_shortly_or_has_a_rate_is_not_warned(opened, url, real_s):
    port = opened(f"slewline://gs-c200s{url}")
    for command in (*PROGRAM, "E"):
        ask(port, command)
    asleep(port, real_s)
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        ask(port, "V1")


def test_a_program_is_entered_run_polled_and_saved(opened):
    port = opened()
    assert [ask(port, command) for command in (*PROGRAM, "E")] == [b"YY\r"] * 6
    polls = 0
    while ask(port, "F") == b"BR\r":
        polls += 1
    assert polls > 20
    assert ask(port, "V1") == framed("V+200")
    assert (port.chip.position, len(port.chip.steps())) == (200, 200)
    port.timeout = 2
    assert ask(port, "M") == b"YY\r"
    assert ask(port, "X") == b"YY\r"
    assert port.bench.findings == []


def test_an_exchange_takes_the_time_of_the_line_and_no_other(opened):
    port = opened()
    ask(port, "F")
    port.flush()
    began = port.bench.now_ps
    assert ask(port, "F") == b"RR\r"
    # three characters, the turnround, three characters
    assert port.bench.now_ps - began == pytest.approx(6 * CHARACTER_PS + 10**9, abs=10)


def test_a_port_with_a_type():
    with slewline.testing.open_url("slewline://gs-c200s", bytesize=7, parity="O", stopbits=2, timeout=1) as port:
        assert ask(port, "F") == b"RR\r"
        port.sleep(0.1)
        assert (port.chip.position, port.baudrate, type(port)) == (0, 9600, protocol_slewline.Serial)
    with pytest.raises(UsageError, match=r"'socket://localhost:1': expected slewline://PART; open other ports"):
        slewline.testing.open_url("socket://localhost:1")


def test_each_opening_without_a_name_is_a_new_module(opened):
    one, other = opened(), opened()
    assert [ask(one, command) for command in PROGRAM] == [b"YY\r"] * 5
    assert ask(other, "Q") == framed("END")
    assert one.bench is not other.bench


def test_a_name_is_the_same_module_whenever_it_is_opened(opened):
    port = opened("slewline://gs-c200s?name=left&chs=0")
    port.write(b"Po\rS10\r")
    assert port.read_until(b"S\r", size=4) == b"Y\rY\r"
    port.close()
    now = port.bench.now_ps
    again = opened("slewline://gs-c200s?name=left")
    assert again.chip is port.chip
    assert again.bench.now_ps == now
    again.write(b"Q\r")
    assert again.read_until(b"END\r") == b"S10\rEND\r"


def test_two_hosts_cannot_have_one_module(opened):
    opened("slewline://gs-c200s?name=left")
    with pytest.raises(serial.SerialException, match="it is open in another program"):
        opened("slewline://gs-c200s?name=left")


def test_a_name_stands_for_one_module(opened):
    opened("slewline://gs-c200s?name=left&chs=0").close()
    for url in ("slewline://gs-c200?name=left", "slewline://gs-c200s?name=left&chs=1"):
        says = r"'left' is already the name of slewline://gs-c200s\?name=left&chs=0;"
        with pytest.raises(UsageError, match=says) as wrong:
            opened(url)
        assert "give the new module another name" in str(wrong.value)


def test_the_url_that_is_advised_is_one_that_opens(opened):
    opened("slewline://gs-c200s?name=left&chs=0").close()
    with pytest.raises(UsageError) as refused:
        opened("slewline://gs-c200?name=left")
    assert opened(str(refused.value).rpartition("one: ")[2]).chip.sheet.part == "gs-c200s"


@pytest.mark.parametrize(
    ("query", "says"),
    [
        ("name=", "name '': allowed letters"),
        ("store=no/dir/x.eeprom", "store no/dir/x.eeprom: expected a file in a directory that exists"),
        ("seed=x", "seed 'x'; expected a whole number"),
        ("eeprom_time=20", "gs_c200s: eeprom_time 20; time 20: a bare number is picoseconds; write its unit"),
        ("nonsense=1", "gs-c200s: no option 'nonsense'"),
        ("chs=2", "gs_c200s"),
    ],
)
def test_mistakes_in_a_url_are_reported_with_the_url(opened, query, says):
    with pytest.raises(UsageError) as refused:
        opened(f"slewline://gs-c200s?{query}")
    assert str(refused.value).startswith(f"slewline://gs-c200s?{query}: {says}")


def test_straps_and_options_of_the_query(opened):
    port = opened("slewline://gs-c200s?chs=0&br0=1&eeprom_time=2.4 s&sel0=1&early_y=false", baudrate=4800)
    port.write(b"M\r")
    assert port.read_until(b"\r") == b"Y\r"
    # two characters, the turnround, a byte into the EEPROM, two characters
    assert 20 * 10**9 < port.bench.now_ps < 32 * 10**9


def test_a_port_that_is_closed_and_opened_again_finds_its_module(opened, tmp_path):
    port = opened(f"slewline://gs-c200s?log={tmp_path}/log")
    assert [ask(port, command) for command in (*PROGRAM, "E")] == [b"YY\r"] * 6
    port.sleep(5)
    chip, now = port.chip, port.bench.now_ps
    port.close()
    port.open()
    assert port.chip is chip and port.bench.now_ps == now
    assert [ask(port, command) for command in ("V1", "M", "E")] == [framed("V+200"), b"YY\r", b"YY\r"]
    port.close()
    assert "> V+200" in (tmp_path / "log").read_text()
    port.port = "slewline://gs-c200s"  # another module
    port.open()
    assert port.chip is not chip and ask(port, "V1") == framed("V+0")


def test_the_eeprom_can_fail_by_the_url(opened):
    port = opened("slewline://gs-c200s?eeprom_fault=true")
    assert [ask(port, command) for command in ("M", "X")] == [framed("E6")] * 2
    port.chip.eeprom_fault = False
    assert [ask(port, command) for command in ("M", "X")] == [b"YY\r"] * 2


def test_the_eeprom_of_a_file_outlives_the_port(opened, tmp_path):
    url = f"slewline://gs-c200s?store={tmp_path}/x.eeprom&eeprom_time=20 ms"
    port = opened(url)
    assert [ask(port, command) for command in (*PROGRAM, "M")] == [b"YY\r"] * 6
    port.close()
    port = opened(url)
    assert (ask(port, "X"), port.chip.listing().split()[1::2]) == (b"YY\r", ["S10", "T100", "R50", "+200"])
    (tmp_path / "x.eeprom").write_text("something else")
    assert ask(port, "M") == framed("E6")
    assert "not a slewline memory" in port.bench.findings[-1].text
    assert issubclass(StoreError, OSError)


def test_a_transcript_is_whole_when_the_port_is_closed(opened, tmp_path):
    with opened(f"slewline://gs-c200s?log={tmp_path}/log") as port:
        assert ask(port, "F") == b"RR\r"
        port.write(b"V")
    lines = [line.split(maxsplit=1)[1] for line in (tmp_path / "log").read_text().splitlines()]
    assert lines == [
        "gs_c200s ! pySerial is connected",
        r"gs_c200s < FV\r",
        r"gs_c200s > RR\r",
        "gs_c200s < V",
        "gs_c200s ! pySerial: closed",
    ]
    assert port.rig.log.file is None


# ---------------------------------------------------------------------------------------------------------- the line
@pytest.mark.parametrize(
    "changes",
    [{"baudrate": 4800}, {"baudrate": 19200}, {"parity": "E"}, {"parity": "N", "bytesize": 8}, {"bytesize": 8}],
    ids=str,
)
def test_wrong_settings_give_what_a_wire_gives(opened, changes):
    port = opened(**changes)
    assert ask(port, "F") != b"RR\r"
    port.apply_settings(SETTINGS)
    port.write(b"\r")  # ends whatever the module has made of it
    port.read(100)
    assert ask(port, "F") == b"RR\r"
    codes = {found.code for found in port.bench.findings}
    assert codes == {"E1", "format"} if "baudrate" not in changes else "format" in codes


def test_settings_that_change_on_an_open_port_hold_from_the_next_character_on(opened):
    port = opened()
    assert ask(port, "F") == b"RR\r"
    port.baudrate = 300
    port.write(b"F")
    port.flush()
    port.baudrate = 9600
    port.write(b"\r")
    port.read(10)
    assert ask(port, "F") == b"RR\r"


def test_a_break_is_a_character_without_stop_bit(opened):
    port = opened()
    assert ask(port, "F") == b"RR\r"
    began = port.bench.now_ps
    port.send_break(0.05)
    assert port.bench.now_ps - began == 50 * 10**9
    port.write(b"\r")
    assert port.read_until(b"\r") == framed("E1")
    assert port.bench.findings[-1].text.startswith(r"b'\x00': a parity or framing error: this module is set to 9600")


def test_a_break_follows_the_written_bytes(opened):
    port = opened()
    port.write(framed("F"))
    port.send_break()
    port.write(b"\r")
    assert port.read(7) == b"RR\r" + framed("E1")


def test_modem_lines_are_bridged(opened):
    port = opened(rtscts=True, dsrdtr=True)
    assert (port.cts, port.dsr, port.cd, port.ri) == (True, True, True, False)
    port.rts, port.dtr = False, False
    assert (port.cts, port.dsr, port.cd, port.ri) == (False, False, False, False)
    assert ask(port, "F") == b"RR\r"


# ------------------------------------------------------------------------------------------------ reading and timeouts
def test_a_read_lets_its_timeout_pass_and_no_more(opened):
    port = opened(timeout=0.25)
    began = port.bench.now_ps
    assert port.read(5) == b""
    assert port.bench.now_ps - began == 250 * 10**9


def test_a_read_ends_with_the_character_that_was_missing(opened):
    port = opened(timeout=1000)
    port.write(framed("F"))
    assert port.read(2) == b"RR"
    assert port.bench.now_ps < 10**11
    assert port.read(1) == b"\r"


def test_read_until_ends_with_the_timeout_of_the_whole(opened):
    port = opened(timeout=0.1)
    port.write(framed("F") * 100)
    began = port.bench.now_ps
    assert b"never" not in port.read_until(b"never")
    assert 100 * 10**9 <= port.bench.now_ps - began <= 110 * 10**9


def test_lines_and_lists_as_pyserial_gives_them(opened):
    port = opened("slewline://gs-c200s?chs=0", timeout=0.1)
    port.write(b"Po\rS10\rT100\rPx\rQ\r")
    assert list(port.iread_until(b"\r")) == [b"Y\r"] * 4 + [b"S10\r", b"T100\r", b"END\r"]
    port.write(b"V1\r")
    assert port.readline() == b"V+0\r"
    buffer = bytearray(3)
    port.write(b"F\r")
    assert (port.readinto(buffer), buffer) == (2, b"R\r\0")
    port.write(b"F\r")
    port.sleep(0.01)
    assert port.read_all() == b"R\r"


def test_time_between_characters(opened):
    port = opened(timeout=10, inter_byte_timeout=0.01)
    port.write(framed("F"))
    assert port.read(100) == b"RR\r"
    assert port.bench.now_ps < 100 * 10**9


def test_timeout_zero_reads_the_available_bytes_and_polling_progresses(opened):
    port = opened(timeout=0)
    port.write(framed("F"))
    got, polls = b"", 0
    while not got.endswith(b"\r"):
        got += port.read(100)
        polls += 1
    assert (got, polls) == (b"RR\r", pytest.approx(8, abs=1))


def test_a_loop_that_waits_for_in_waiting_ends(opened):
    port = opened()
    port.write(framed("F"))
    while port.in_waiting < 3:
        pass
    assert port.read(3) == b"RR\r"


def test_a_read_without_timeout_waits_as_long_as_something_is_coming(opened):
    port = opened("slewline://gs-c200s?eeprom_time=3600 s", timeout=None)
    assert ask(port, "M") == b"YY\r"
    assert port.bench.now_ps > 30 * 10**12


def test_a_read_without_timeout_reports_that_nothing_is_coming(opened):
    port = opened(timeout=None)
    port.write(framed("F"))
    with pytest.raises(
        Timeout, match=r"read\(4\) without a timeout received 3 bytes, .* can arrive \(gs_c200s: waiting for a command"
    ):
        port.read(4)
    assert port.read(3) == b"RR\r"


def test_buffers_can_be_emptied(opened):
    port = opened()
    port.write(framed("F"))
    port.sleep(0.1)
    port.reset_input_buffer()
    assert port.in_waiting == 0
    port.write(framed("F") * 100)
    assert port.out_waiting == 300
    port.reset_output_buffer()
    assert port.out_waiting < 20
    port.sleep(1)
    assert port.out_waiting == 0
    assert 0 < port.in_waiting < 30


def test_written_bytes_are_sent_before_the_port_is_closed(opened):
    port = opened()
    for command in (*PROGRAM, "E"):
        ask(port, command)
    port.flush()
    began = port.bench.now_ps
    port.write(framed("K"))
    port.close()
    assert port.bench.now_ps - began == pytest.approx(3 * CHARACTER_PS, abs=10)
    port.bench.run("100 ms")
    assert port.chip.idle
    with pytest.raises(serial.SerialException, match="not open"):
        port.read(1)


def test_context_manager_and_delayed_opening(opened):
    port = opened(do_not_open=True)
    assert not port.is_open
    with port:
        assert ask(port, "F") == b"RR\r"
    assert not port.is_open


@pytest.mark.system
def test_a_rate_follows_the_wall_clock(opened):
    port = opened("slewline://gs-c200s?rate=50", timeout=1000)
    began = port.bench.now_ps
    for command in (*PROGRAM, "E"):
        assert ask(port, command) == b"YY\r"
    assert port.bench.now_ps - began > 50 * 10**9  # the exchanges themselves; the machine may take any time on top
    port.sleep(5)
    assert (ask(port, "F"), port.chip.position) == (b"RR\r", 200)


def test_one_thread_reads_for_as_long_as_another_one_takes_to_write(opened):
    port = opened("slewline://gs-c200s?rate=100", timeout=None)
    got = []
    reader = Thread(target=lambda: got.append(port.read_until(b"\r")))
    reader.start()
    while port.bench.now_ps < 3 * 10**12:
        assert port.in_waiting == 0
    port.write(framed("F"))
    reader.join(60)
    assert got == [b"RR\r"]


def read_beside(port, size):
    """A thread that waits in a read, and what it gets."""
    got = []
    reader = Thread(target=lambda: got.append(port.read(size)), daemon=True)
    reader.start()
    while not port.rig.pace.waits:
        assert reader.is_alive()
    return reader, got


@pytest.mark.system
@pytest.mark.parametrize("timeout", [3600, None])
def test_a_read_notices_immediately_a_request_of_another_thread(opened, timeout):
    port = opened("slewline://gs-c200s?rate=0.02", timeout=timeout)  # nothing would happen for 50 s of the wall clock
    reader, got = read_beside(port, 3)
    port.write(framed("F"))
    reader.join(40)
    assert got == [b"RR\r"]


@pytest.mark.system
def test_a_reader_thread_of_pyserial_gets_lines_and_ends(opened):
    answered = Event()

    class Lines(serial.threaded.LineReader):
        TERMINATOR = b"\r"

        def handle_line(self, line):
            assert line == "RR"
            answered.set()

    port = opened("slewline://gs-c200s?rate=0.02", timeout=None)
    thread = serial.threaded.ReaderThread(port, Lines)
    thread.start()
    _, lines = thread.connect()
    while not port.rig.pace.waits:
        assert thread.is_alive()
    lines.transport.write(framed("F"))
    assert answered.wait(40)
    thread.close()
    assert not thread.is_alive()
    assert port.timeout is None  # it would have been changed, could a read not be cancelled


@pytest.mark.parametrize("end", ["cancel_read", "close"])
def test_a_read_that_waits_can_be_ended_by_another_thread(opened, end):
    port = opened("slewline://gs-c200s?rate=0.02", timeout=None)
    port.rig.line.give(b"R")
    reader, got = read_beside(port, 2)
    getattr(port, end)()
    reader.join(40)
    assert got == [b"R"]


def test_a_read_that_was_cancelled_before_it_began_ends_and_no_other(opened):
    port = opened()
    port.cancel_read()
    began = port.bench.now_ps
    assert (port.read(1), port.bench.now_ps) == (b"", began)
    assert (port.read(1), port.bench.now_ps) == (b"", began + 10**12)
    port.cancel_read()
    port.close()
    port.open()
    assert ask(port, "F") == b"RR\r"


def test_a_character_that_comes_while_others_are_taken_is_not_lost(opened):
    class Growing(bytearray):
        def __getitem__(self, key):
            found = bytes(super().__getitem__(key))
            self.append(0x52)
            return found

    port = opened(timeout=0)
    port._end.buffer = Growing(b"V+")
    assert port.read(100) == b"V+"
    assert port._end.buffer == b"R"


def test_no_write_waits_so_that_its_timeout_is_never_over(opened):
    port = opened(write_timeout=0.001)
    assert port.write(framed("F") * 1000) == 3000
    assert port.bench.now_ps < 10**10
    port.cancel_write()
    assert port.out_waiting == 3000


@pytest.fixture
def late():
    """A port of which nobody has looked for more than 10 s of virtual time, and how late it is."""
    with serial.serial_for_url("slewline://gs-c200s?rate=1000", **SETTINGS) as port:
        port.write(framed("F"))
        began, virtual = perf_counter(), port.bench.now_ps
        while perf_counter() < began + 0.01:
            pass
        yield port, virtual + int((perf_counter() - began) * 0.99 * 1000 * 10**12)


def test_with_a_rate_characters_begin_when_they_are_written(late):
    port, present = late
    port.write(framed("F"))
    assert port.bench.now_ps > present


def test_with_a_rate_the_present_is_reached_though_a_slice_is_not_enough(opened, monkeypatch):
    rig = opened("slewline://gs-c200s?rate=50").rig
    rig.line.take(framed("F"))
    pace = rig.pace
    late_ns = pace.origin_ns + pace.nanoseconds(rig.bench.now_ps - pace.origin_ps) + 100_000
    with monkeypatch.context() as patch:
        patch.setattr(pace, "clock", lambda: late_ns)
        patch.setattr("slewline.links.lines.pace.SLICE_NS", 0)  # as on a machine that is busy: an event each
        patch.setattr(pace, "_enough", cycle((False, True)).__next__)
        assert rig.present() >= pace.goal()


@pytest.mark.system
@pytest.mark.parametrize("wait", [lambda port: port.read(10), lambda port: port.sleep(100)], ids=["read", "sleep"])
def test_with_a_rate_a_time_counts_from_the_present_and_is_virtual(late, wait):
    port, present = late
    port.timeout = 100
    wait(port)
    assert present + 10**14 <= port.bench.now_ps < present + 90 * 10**15  # 0.1 s of the wall clock, not 100


# ------------------------------------------------------------------------------------------------------------ mistakes
NOT_OPENED = [
    (
        "slewline://gs-c300",
        {},
        "no chip 'gs-c300'; available: cy525, cy500, cy512, cy545, cy545b, gs-c200, gs-c200s",
    ),
    ("slewline://gs-c200s/extra?chs=0", {}, "unexpected 'extra'; expected slewline://gs-c200s"),
    ("slewline://gs-c200s#x", {}, "unexpected 'x'; expected slewline://gs-c200s"),
    ("slewline://", {}, "no chip ''; available: cy525, cy500, cy512, cy545, cy545b, gs-c200, gs-c200s"),
    ("slewline://cy525", {}, r"cy525 has no serial line; command it through bench\.host"),
    ("slewline://gs-c200s?sel9=0", {}, "no option 'sel9'; its options: store, cold, firmware"),
    ("slewline://gs-c200s?chs=2", {}, "strap chs=2; a strap sets an input to 0 or 1"),
    ("slewline://gs-c200s?rate=fast", {}, "rate 'fast'; expected virtual seconds per second"),
    ("slewline://gs-c200s?chs=0&chs=1", {}, r"\?chs=0&chs=1: chs is given twice; give it once"),
    ("slewline://gs-c200s?seed=x", {}, "seed 'x'; expected a whole number"),
    ("slewline://gs-c200s?store=/nowhere/x", {}, "store /nowhere/x: expected a file in a directory that exists"),
    ("slewline://gs-c200s?store=/", {}, "store /: expected a file in a directory that exists"),
    ("slewline://gs-c200s?store=", {}, "store : expected a file in a directory that exists"),
    ("slewline://gs-c200s", {"xonxoff": True}, "xonxoff=True; a checksum byte may equal XON or XOFF"),
    ("slewline://gs-c200s", {"parity": "M"}, "parity 'M'; allowed N, O, E"),
    ("slewline://gs-c200s", {"baudrate": 0}, "baud 0; expected a rate such as 9600"),
]


def test_a_failed_open_is_reported_with_the_reason(opened, subtests):
    for url, changes, says in NOT_OPENED:
        with subtests.test(url=url, changes=changes):
            with pytest.raises(UsageError, match=says) as refused:
                opened(url, **changes)
            assert isinstance(refused.value, ValueError)  # which pySerial has for a wrong URL


@pytest.mark.parametrize("changes", [{"xonxoff": True}, {"parity": "M"}, {"baudrate": 0}], ids=str)
def test_settings_that_cannot_be_make_no_module(opened, tmp_path, changes):
    with pytest.raises(UsageError):
        opened(f"slewline://gs-c200s?log={tmp_path}/log&name=left", **changes)
    assert not (tmp_path / "log").exists()
    assert rig.NAMED == {}


def test_a_str_is_not_bytes(opened):
    with pytest.raises(TypeError):
        opened().write("F\r")


@pytest.mark.system
def test_without_the_import_pyserial_does_not_know_the_url():
    code = "import serial; serial.serial_for_url('slewline://gs-c200s')"
    ran = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=False)
    assert "protocol 'slewline' not known" in ran.stderr
    ran = subprocess.run([sys.executable, "-W", "error", "-c", f"import slewline.testing; {code}"], check=False)
    assert ran.returncode == 0


# --------------------------------------------------------------------------------------- what programs call on a port
ELSEWHERE = {  # of pySerial's ports, not of ours
    "open": "opens",
    "close": "closes, also a second time",
    "fileno": "raises, and says what to use instead",
    "cancel_read": "has nothing to end where nothing is open",
    "cancel_write": "likewise",
    "nonblocking": "deprecated, without effect",
    "exclusive": "a setting",
}


def methods_of_pyserial():
    """The public methods of pySerial's ports of all systems; the sources are read, since each is for its own system."""
    for name in ("serialposix.py", "serialwin32.py"):
        tree = ast.parse((Path(serial.__file__).parent / name).read_text())
        for each in ast.walk(tree):
            if isinstance(each, ast.ClassDef) and each.name in ("Serial", "PlatformSpecific"):
                yield from (one.name for one in each.body if isinstance(one, ast.FunctionDef) and one.name[0] != "_")


def test_a_port_has_the_methods_of_every_system_and_is_closed_alike(opened, subtests):
    arguments = {"read": (1,), "write": (b"F\r",), "set_low_latency_mode": (True,)}
    names = set(methods_of_pyserial()) - ELSEWHERE.keys()
    assert {"set_buffer_size", "set_low_latency_mode", "set_output_flow_control", "cts", "out_waiting"} <= names

    def call(port, name):
        got = getattr(port, name)
        return got(*arguments.get(name, ())) if callable(got) else got

    for name in sorted(names):
        with subtests.test(name):
            port = opened("slewline://gs-c200s?chs=0")
            if name.endswith("flow_control"):
                with pytest.raises(UsageError, match="xonxoff=True; a checksum byte may equal XON or XOFF"):
                    call(port, name)
            else:
                call(port, name)
            port.write(b"\rV1\r")
            assert port.read(100).endswith(b"V+0\r")
            port.close()
            with pytest.raises(serial.PortNotOpenError):
                call(port, name)

"""`slewline drive` as a process, on a board that is firmware in an emulator, behind a port, in real time."""

from __future__ import annotations

import json
import os
import random
import re
import signal
import subprocess
import sys
import threading
import time
from concurrent.futures import ThreadPoolExecutor
from contextlib import contextmanager
from itertools import pairwise
from pathlib import Path

import pytest

from slewline.cli.main import invoke
from slewline.drive.blackbox import read_line
from slewline.drive.board import wire
from slewline.drive.board.frames import Decoder, Frame
from slewline.drive.board.wire import Answer, BoardEvent, Happening
from tests.drive.process import ModuleHost, Slewline

from .served import HZ, ServedBoard

pytestmark = [pytest.mark.posix, pytest.mark.long, pytest.mark.timeout(120)]  # in real time: not beside other tests

GSC = ("gs-c200s", "--strap", "chs=0", "--tcp", "127.0.0.1:0")
POWER = ("--driver", "A4988", "--enable")
FAST = ("S50", "T970", "R400")  # 500 to 9,700 steps/s


@pytest.fixture
def board(firmware):
    with ServedBoard(firmware) as board:
        yield board


@contextmanager
def driven(board, folder, *words, chip=GSC, **options):
    """A drive on the board with its driver on, and the address of its port."""
    with Slewline("drive", *chip, "--board", board.port, *POWER, *words, folder=folder, **options) as drive:
        yield drive, drive.ready()


def net(board):
    """Where the motor is, by the edges of STEP since the last power-up: DIR is high upwards."""
    return sum(1 if level else -1 for _, level in board.steps())


def until_it_moves(board, steps, seconds=20):
    """Wait until so many edges have been made since the last power-up."""
    limit = time.monotonic() + seconds
    while len(board.steps()) < steps:
        assert time.monotonic() < limit, len(board.steps())
        time.sleep(0.02)


def until_it_stands(board, seconds=20):
    """Wait until no more edges come; return how many there are."""
    limit = time.monotonic() + seconds
    before = len(board.steps())
    while True:
        time.sleep(0.15)
        if (count := len(board.steps())) == before:
            return count
        assert time.monotonic() < limit
        before = count


def gaps(board):
    """The intervals between the last steps, in ticks."""
    ticks = [tick for tick, _ in board.steps()[-41:]]
    return [after - before for before, after in pairwise(ticks)]


def stood_by_its_way_down(board):
    """Whether the last intervals grow up to the start-stop rate, to 2 ticks, as those of a way down do."""
    found = gaps(board)[-30:]
    grow = all(after >= before - 2 for before, after in pairwise(found))
    return grow and found[-1] > HZ // 1_500


def heard(box):
    """What the board has said, as a black box has it."""
    decoder = Decoder()
    data = b"".join(data for _, _, way, data in read_line(box) if way == "<")
    return [wire.read(frame) for frame in decoder.feed(data) if isinstance(frame, Frame)]


# ------------------------------------------------------------------------------------------------- the host is killed
def killed(board, folder, seconds, count):
    """Kill a host so many seconds after the first step of a motion, on a board that has a count from before, or None.

    Return the count of the board then.
    """
    with driven(board, folder, "--no-black-box") as (drive, where), ModuleHost(where) as host:
        if count is not None:
            stood = drive.hears(r"gs_c200s: board-went-on: .* the motor is at rest at count (-?\d+), which the model")
            assert int(stood[1]) == count == net(board)
            assert "--keep-count" in drive.text
            assert drive.count() == count
        host.program(*FAST, "g+")
        until_it_moves(board, len(board.steps()) + 1)
        time.sleep(seconds)
        os.kill(drive.process.pid, signal.SIGKILL)
    made = until_it_stands(board)
    assert stood_by_its_way_down(board), gaps(board)
    assert made == net(board) > (count or 0)
    return made


def goes_on(board, folder, count):
    """Check that another host finds the count of the board, and moves its motor."""
    before = len(board.steps())
    with driven(board, folder, "--no-black-box") as (drive, where), ModuleHost(where) as host:
        drive.hears(rf"board-went-on: .* is at rest at count {count}; the model does not know this count: home")
        host.program(*FAST, "-25")
        host.until_ready()
        assert host.position() == -25
        assert drive.stands() == count - 25 == net(board)
        assert len(board.steps()) == before + 25
        assert drive.end() == 0
        assert "count-differs" not in drive.text
    with driven(board, folder, "--no-black-box", "--keep-count") as (drive, where), ModuleHost(where) as host:
        drive.hears(rf"is at rest at count {count - 25}; the position register is set to this count")
        assert host.position() == count - 25
        assert drive.end() == 0


def kill_again_and_again(board, folder, times, seed):
    rnd = random.Random(seed)
    count = None
    for _ in range(times):
        count = killed(board, folder, rnd.uniform(0.0, 0.4), count)
    goes_on(board, folder, count)
    # The first one who opens the port resets the board; nobody does after that.
    assert board.status()["resets"] == 1


def test_a_host_that_is_killed_leaves_a_board_that_knows_its_count(board, tmp_path):
    kill_again_and_again(board, tmp_path, 3, 7)


@pytest.mark.long
@pytest.mark.timeout(3000)
@pytest.mark.parametrize("seed", range(10))
def test_two_hundred_hosts_are_killed_in_motion(board, tmp_path, seed):
    kill_again_and_again(board, tmp_path, 20, seed)


# ------------------------------------------------------------------------------------------ line, supply, and machine
def clear_and_move(drive, host, board, count):
    """Let a drive go on whose module was stopped by K, and move its motor from a count on."""
    drive.clear()
    before = host.position()
    host.program(*FAST, "-25")
    host.until_ready()
    assert drive.stands() == count - 25 == net(board)
    assert host.position() == before - 25
    assert "count-differs" not in drive.text


def test_a_host_stopped_for_half_a_second_causes_an_underrun_and_the_count_is_right(board, tmp_path):
    with driven(board, tmp_path, "--no-black-box") as (drive, where), ModuleHost(where) as host:
        host.program(*FAST, "g+")
        until_it_moves(board, 3_000)
        drive.signal(signal.SIGSTOP)
        made = until_it_stands(board)  # nobody tells it anything
        drive.signal(signal.SIGCONT)
        assert stood_by_its_way_down(board), gaps(board)
        said = drive.hears(r"gs_c200s: (underrun: the board ran dry|host-silent: the board has not heard)")
        assert "underrun" in said[0], "it ran dry before its watchdog was due"
        drive.hears(f"position-taken-over: the motor is at {made}: ")
        assert drive.stands() == made == net(board) == len(board.steps()) == host.position()
        clear_and_move(drive, host, board, made)
        assert drive.end() == 0


def test_on_a_line_that_damages_a_byte_in_a_hundred_no_step_is_lost(board, tmp_path):
    with driven(board, tmp_path, "--no-black-box", "--horizon", "300 ms") as (drive, where), ModuleHost(where) as host:
        host.program(*FAST, "+20000")
        until_it_moves(board, 1)
        board.damage(0.01, seed=5)
        until_it_moves(board, 17_000)
        board.damage(0)
        host.until_ready()
        assert drive.stands() == 20_000 == net(board) == host.position()
        assert "gs_c200s: " not in drive.text.replace("gs_c200s: socket", ""), "a finding"
        assert drive.end() == 0


def test_a_supply_that_is_gone_stops_the_motor_and_its_count_is_lost(board, tmp_path):
    with driven(board, tmp_path, "--no-black-box") as (drive, where), ModuleHost(where) as host:
        host.program(*FAST, "g+")
        until_it_moves(board, 2_000)
        board.supply(False)
        made = len(board.steps())
        drive.hears("gs_c200s: board-silent: the board has not answered for 500 ms: check its cable and its supply")
        assert "board halted at " in drive.status()
        board.supply(True)
        drive.hears("gs_c200s: board-reset: the board was reset, or lost its supply: its count")
        assert "board unknown at ?, position unknown | " in drive.status()
        time.sleep(0.3)
        assert [len(life) for life in board.lives()][-2:] == [made, 0], "it moves by itself"
        clear_and_move(drive, host, board, 0)
        assert drive.end() == 0


def test_a_cable_that_is_pulled_takes_the_supply_with_it_and_clear_opens_the_port_again(board, tmp_path):
    with driven(board, tmp_path, "--black-box", "boxes") as (drive, where), ModuleHost(where) as host:
        host.program(*FAST, "g+")
        until_it_moves(board, 2_000)
        board.unplug()
        made = len(board.steps())
        drive.hears(r"gs_c200s: port-lost: the port of the board is gone \(.*\): nobody knows where the motor is; put")
        assert "board unknown at ?, position unknown | " in drive.status()
        drive.signal(signal.SIGUSR2)
        drive.hears(f"slewline: {board.port}: no such port; name the port of the board")
        board.plug()
        clear_and_move(drive, host, board, 0)
        assert made in [len(life) for life in board.lives()[:-1]]
        assert drive.end() == 0
    (box,) = (tmp_path / "boxes").iterdir()
    kinds = [said.kind for said in heard(box) if isinstance(said, BoardEvent)]
    assert kinds.count(Happening.BOOT) == 1  # as the port was opened again; the record began after the first time
    assert max(said.position for said in heard(box) if isinstance(said, Answer)) > 1_000


# ------------------------------------------------------------------------------------------------------------- --check
def checked_up(board, monkeypatch, capfd):
    """Call the command with --check, for less long than a user would; return its status, and the lines."""
    monkeypatch.setattr("slewline.cli.live.drive.CHECK_S", 0.5)
    monkeypatch.setattr("slewline.links.sockets.system.be_prompt", lambda: "normal priority")
    status = invoke(["drive", *GSC[:3], "--check", "--board", board.port])
    return status, dict(line.split(None, 1) for line in capfd.readouterr().out.splitlines())


@pytest.mark.parametrize("wired", [True, False])
def test_check_tests_link_machine_and_pulses(board, wired, monkeypatch, capfd, tmp_path):
    monkeypatch.setenv("XDG_STATE_HOME", str(tmp_path))
    board.loop(wired)
    status, lines = checked_up(board, monkeypatch, capfd)
    assert list(lines) == ["board", "link", "machine", "horizon", "pulses"]
    assert re.fullmatch(r"Arduino Uno \(ATmega328P, 16 MHz\); .* differs from this .* by [+-]\d+ ppm", lines["board"])
    link = r"\d+\.\d ms round trip, \d+\.\d ms at worst, \d+ ms for the start of a motion; 0 frames damaged"
    assert re.fullmatch(link, lines["link"])
    late = re.fullmatch(
        r"wakes (\S+) ms late \(median\), (\S+) ms \(99th percentile\), (\S+) ms at worst; no priority .*",
        lines["machine"],
    )
    assert 0 < float(late[1]) <= float(late[2]) <= float(late[3]) + 0.05
    assert re.match(r'--horizon "(20|50|100|250|500|1000) ms" is enough', lines["horizon"])
    if wired:
        assert (status, lines["pulses"]) == (0, "1000 pulses sent, 1000 counted")
    else:
        assert status == 1 and lines["pulses"].startswith("1000 pulses sent, none counted: connect D9 to D4, and noth")
    assert len(board.steps()) == 1_000
    assert not list(tmp_path.iterdir())


# ---------------------------------------------------------------------------------- a host program that knows nothing
HOME, END = range(-240, -220), 60  # where the switches are closed, in steps from where the motor is
SERVED = f"""
[[chip]]
name = "gs_c200s"
part = "gs-c200s"
straps = {{ chs = 0, br0 = 0, br1 = 0, br2 = 0 }}

[[part]]
name = "motor"
kind = "translator"
to = "gs_c200s"

[[part]]
name = "home"
kind = "switch"
on = "motor"
to = "gs_c200s"
role = "home"
low = {HOME.start}
high = {HOME.stop}

[[part]]
name = "end"
kind = "switch"
on = "motor"
to = "gs_c200s"
role = "end"
low = {END}

[[serve]]
chips = ["gs_c200s"]
pty = "served"
"""


def said_to(port):
    """Run the program on a port; return what it prints, a line for each question."""
    ran = subprocess.run(
        [sys.executable, str(Path(__file__).with_name("old_host.py")), str(port)],
        stdout=subprocess.PIPE,
        text=True,
        timeout=60,
        check=True,
    )
    return ran.stdout.splitlines()


def positions(said):
    """The answers to V1."""
    return [int(line.split("V")[2]) for line in said if line.startswith("V1 ")]


def test_an_old_program_does_not_notice_that_a_motor_has_taken_the_place_of_the_module(board, tmp_path):
    (tmp_path / "served.toml").write_text(SERVED)
    words = ("gs-c200s", "--strap", "chs=0", "--pty", "driven", "--input", "A0=eot", "--input", "A1=home")
    words += ("--horizon", "500 ms")  # an emulator that shares its machine is late now and then
    places, over = [], threading.Event()
    words += ("--board", board.port, "--pulses", "--no-black-box")
    with (
        Slewline("serve", "--bench", "served.toml", folder=tmp_path) as served,
        Slewline("drive", *words, folder=tmp_path) as drive,
        ThreadPoolExecutor() as pool,
    ):
        served.hears("^gs_c200s: ")
        drive.hears(", horizon ")

        def switch():
            """The switches, by where the motor is."""
            shown = None
            while not over.wait(0.001):
                place = net(board)
                levels = (int(place < END), int(place not in HOME))
                if levels != shown:
                    for number, level in enumerate(levels):
                        board.set_input(number, level)
                    places.append((place, levels))
                    shown = levels

        switching = pool.submit(switch)
        try:
            wanted, said = pool.map(said_to, (tmp_path / "served", tmp_path / "driven"))
        finally:
            over.set()
        switching.result()
        last = drive.stands()
        assert drive.end() == served.end() == 0
    # What a host says while the motor runs comes when it comes: two positions are those at which that was.
    stopped = [at for at, line in enumerate(wanted) if line.startswith(("Z ", "K "))]
    for each in (said, wanted):
        found = positions(each)
        assert found[:4] == [0, 0, 200, -50] and found[6] == 0
        assert found[4] > 50 and found[5] < found[4]
        for at in stopped:
            each[at + 2] = "V1 V<somewhere>"
    assert said == wanted and len(stopped) == 2
    assert (END, (0, 1)) in places or any(END <= place < END + 20 and not level for place, (level, _) in places)
    assert last == net(board)
    assert abs(net(board) - (HOME.stop - 1)) <= 12  # it has homed at its switch, and is back there
    # K stops at once, from a rate at which a motor cannot: that is said, and nothing else is.
    findings = [line for line in drive.said if line.startswith("slewline: gs_c200s: ")]
    assert all("position-uncertain: the motor was stopped dead from 2000 steps/s" in line for line in findings), (
        findings
    )
    assert "taken back" not in drive.text


# ------------------------------------------------------------------------------------------------------- in real time
@contextmanager
def busy(number):
    """Processes that do nothing, as fast as they can, with the least priority."""
    loops = [
        subprocess.Popen([sys.executable, "-c", "import os; os.nice(19)\nwhile True: pass"]) for _ in range(number)
    ]
    try:
        yield
    finally:
        for each in loops:
            each.kill()
            each.wait()


def in_time(board, folder, seconds):
    """Move at 9,700 steps/s for so long beside two busy processes; return figures of the turns of the host."""
    words = ("drive", *GSC, "--board", board.port, "--pulses", "--no-black-box")
    program = ("tests.firmware.lateness", str(folder / "figures.json"))
    with busy(2), Slewline(*words, folder=folder, program=program) as drive, ModuleHost(drive.ready()) as host:
        host.program(*FAST, "g+")
        time.sleep(seconds)
        lost = board.status()["lost"]
        answer = host.ask("Z")
        if answer == "Y":
            host.until_ready()
        made = drive.stands()
        assert made == net(board) == len(board.steps())
        assert answer != "Y" or host.position() == made
        assert drive.end() == 0
        text = drive.text
    told = json.loads((folder / "figures.json").read_text())
    ticks = [tick for tick, _ in board.steps()]
    told |= {"steps": made, "seconds of the board": (ticks[-1] - ticks[0]) / HZ, "lost, s": lost}
    told["findings"] = [line for line in text.splitlines() if line.startswith("slewline: gs_c200s: ")]
    return told


@pytest.mark.long
@pytest.mark.timeout(300)
def test_for_a_minute_at_full_rate_next_to_busy_processes_no_step_is_late(firmware, tmp_path):
    """The board judges its host in its own time, which stands while the emulator is held up, and does not hurry then.

    So only a host that is late makes it run dry.  Nothing is shown for as long as a machine holds up both at once.
    """
    with ServedBoard(firmware) as board:
        board.promptly()
        told = in_time(board, tmp_path, 60)
    print(json.dumps(told, indent=1))
    if out := os.environ.get("SLEWLINE_FIGURES"):
        Path(out).write_text(json.dumps(told, indent=1) + "\n")
    assert not told["findings"]
    assert told["seconds of the board"] > 58 - told["lost, s"]
    assert told["steps"] > 9_700 * (told["seconds of the board"] - 1)
    assert told["lead, ms"]["least"] > 20

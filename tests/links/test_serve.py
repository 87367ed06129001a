"""`slewline serve` as a command: what it prints, how it ends, what it keeps, and what it refuses."""

from __future__ import annotations

import json
import os
import random
import select
import shutil
import signal
import subprocess
import time
from pathlib import Path

import pytest
import serial

import slewline
from slewline.cli.live.serve import ServeCommand, signals
from slewline.cli.main import invoke
from slewline.links.ports.pty import HINT
from slewline.links.views.reports import CAUSES, PERIOD_S
from tests.ensembles import few

from .conftest import COMMAND, PATIENCE, Asks

PROGRAM = (b"Po", b"S50", b"T200", b"R20", b"+400")
ONE = ("gs-c200s", "--strap", "chs=0", "--lockstep")


@pytest.fixture(autouse=True)
def folder(tmp_path, monkeypatch):
    """An empty directory, in which the command runs."""
    monkeypatch.chdir(tmp_path)
    return tmp_path


def ask(host, line):
    return host.ask(line + b"\r")


ENDS = [signal.SIGINT, signal.SIGTERM, *([signal.SIGHUP] if hasattr(signal, "SIGHUP") else [])]


@pytest.mark.system
@pytest.mark.posix
@pytest.mark.parametrize("number", ENDS)
def test_a_signal_ends_it_in_good_order(serve, client, number):
    server = serve(*ONE, "--tcp", "127.0.0.1:0")
    assert list(server.ports) == ["gs_c200s"]
    host = client(server.where)
    assert ask(host, b"F") == b"R\r"
    assert server.end(number) == (0, "")
    assert host.read(end=b"") == b""


@pytest.mark.system
@pytest.mark.posix
@pytest.mark.parametrize("number", few(ENDS, 1))
def test_a_signal_that_comes_again_changes_nothing(serve, number):
    server = serve(*ONE, "--tcp", "127.0.0.1:0")
    while server.process.poll() is None:
        server.process.send_signal(number)
    assert server.end(number) == (0, "")


@pytest.mark.posix
def test_signals_are_handled_before_a_port_is_open(monkeypatch, capfd):
    before = [signal.getsignal(number) for number in (*ENDS, signal.SIGUSR1)]
    heard = []

    def refuse(*_):
        heard.extend(signal.getsignal(number) for number in (*ENDS, signal.SIGUSR1))
        raise slewline.errors.UsageError("no")

    monkeypatch.setattr(ServeCommand, "open_chip", refuse)
    assert invoke([*ONE_MORE]) == 2
    assert len(heard) == 4 and not set(heard) & set(before)
    assert [signal.getsignal(number) for number in (*ENDS, signal.SIGUSR1)] == before


@pytest.mark.posix
@pytest.mark.parametrize("name", ["SIGINT", "SIGTERM", "SIGHUP", "SIGQUIT"])
def test_a_signal_that_is_ignored_stays_so(lockstep, name):
    server, _ = lockstep()
    number = getattr(signal, name)
    kept = {each: signal.getsignal(each) for each in (*ENDS, signal.SIGQUIT, signal.SIGUSR1)}
    signal.signal(number, signal.SIG_IGN)
    try:
        with signals(server):
            assert signal.getsignal(number) is signal.SIG_IGN
    finally:
        for each, handler in kept.items():
            signal.signal(each, handler)
    server.close()


@pytest.mark.system
@pytest.mark.posix
@pytest.mark.parametrize("number", few(ENDS, 1))
def test_a_signal_removes_the_link(serve, number):
    server = serve(*ONE, "--pty", "x")
    assert server.where == "x"
    assert os.readlink("x").startswith("/dev/pts/")
    assert server.end(number) == (0, f"slewline: x: {HINT}\n")
    assert not os.path.lexists("x")


@pytest.mark.system
def test_paced_by_default(serve, client):
    server = serve("gs-c200s", "--strap", "chs=0", "--tcp", "127.0.0.1:0", "--control", "127.0.0.1:0", ports=2)
    assert list(server.ports) == ["gs_c200s", "control"]
    host, control = client(server.ports["gs_c200s"]), client(server.ports["control"])
    assert ask(host, b"F") == b"R\r"
    control.send(
        b'{"do": "advance", "time": "1 s"}\n{"do": "status"}\n{"do": "until", "pin": "gs_c200s.rdy", "level": 1}\n'
    )
    refused, status, met = (json.loads(control.read(b"\n")) for _ in range(3))
    assert "start the server with --lockstep" in refused["error"]
    assert status["pace"]["rate"] == 1.0
    assert met["met"] is True
    control.send(b'{"do": "until", "pin": "gs_c200s.mov", "level": 1, "timeout": "20 ms"}\n{"do": "quit"}\n')
    before, after = status["time_ps"], json.loads(control.read(b"\n"))
    assert after["met"] is False
    assert after["time_ps"] >= before + 20 * 10**9
    assert server.process.wait(PATIENCE) == 0


@pytest.mark.system
def test_checksums_unless_strapped_otherwise(serve, client):
    server = serve("gs-c200", "--lockstep", "--tcp", "127.0.0.1:0")
    assert client(server.where).ask(b"V2\x18\r").startswith(b"V")


@pytest.mark.system
def test_options_of_the_chip(serve, client):
    server = serve(*ONE, "--option", "lenient=true", "--option", "turnround=3 ms", "--tcp", "127.0.0.1:0")
    assert ask(client(server.where), b"P0") == b"Y\r"


@pytest.mark.system
def test_memorised_programs_outlive_the_server(serve, client):
    first = serve(*ONE, "--tcp", "127.0.0.1:0", "--state", "memories")
    host = client(first.where)
    for line in (*PROGRAM, b"Px", b"M"):
        assert ask(host, line) == b"Y\r"
    assert first.end() == (0, "")
    assert set(os.listdir("memories")) == {".lock", "gs_c200s.eeprom"}
    second = serve(*ONE, "--tcp", "127.0.0.1:0", "--state", "memories")
    host = client(second.where)
    assert ask(host, b"X") == b"Y\r"
    host.send(b"Q\r")
    assert b"+400" in host.read(b"END\r")
    assert second.end() == (0, "")


@pytest.mark.system
def test_a_journal_of_a_server_that_had_a_memory_replays(serve, client):
    first = serve(*ONE, "--tcp", "127.0.0.1:0", "--state", "memories")
    host = client(first.where)
    for line in (*PROGRAM, b"Px", b"M"):
        ask(host, line)
    first.end()
    second = serve(*ONE, "--tcp", "127.0.0.1:0", "--state", "memories", "--journal", "journal")
    assert ask(client(second.where), b"X") == b"Y\r"
    second.end()
    again = slewline.replay("journal")
    assert len(again["gs_c200s"].program) == 16


@pytest.mark.posix
def test_a_memory_that_would_hang_the_start_is_refused(capfd):
    os.mkdir("memories")
    os.mkfifo("memories/gs_c200s.eeprom")
    assert invoke([*ONE_MORE, "--state", "memories"]) == 2
    assert "gs_c200s.eeprom is not a regular file" in capfd.readouterr().err


@pytest.mark.posix
def test_a_transcript_that_would_hang_the_start_is_refused(capfd):
    os.mkfifo("log")
    assert invoke([*ONE_MORE, "--log", "log"]) == 2
    assert "log log is not a regular file" in capfd.readouterr().err


@pytest.mark.system
def test_two_servers_do_not_share_a_memory(serve, capfd):
    serve(*ONE, "--tcp", "127.0.0.1:0", "--state", "memories")
    assert invoke([*ONE_MORE, "--state", "memories"]) == 2
    assert "used by another server" in capfd.readouterr().err


ONE_MORE = ["serve", "gs-c200s", "--tcp", "127.0.0.1:0"]


def test_a_damaged_memory_is_reported_before_anything_is_served(capfd):
    os.mkdir("memories")
    with open("memories/gs_c200s.eeprom", "wb") as file:
        file.write(b"not ours")
    assert invoke([*ONE_MORE, "--state", "memories"]) == 2
    assert "gs_c200s.eeprom" in capfd.readouterr().err


@pytest.mark.system
def test_the_transcript(serve, client):
    server = serve(*ONE, "--tcp", "127.0.0.1:0", "--log", "log")
    host = client(server.where)
    ask(host, b"F")
    name = "{}:{}".format(*host.socket.getsockname())
    host.close()
    server.end()
    with open("log") as log:
        lines = [line.split(maxsplit=1) for line in log.read().splitlines()]
    assert [text for _, text in lines][:3] == [f"gs_c200s ! {name} is connected", "gs_c200s < F\\r", "gs_c200s > R\\r"]
    assert lines[1][0] == "0.001000"


@pytest.mark.system
@pytest.mark.posix
def test_sigusr1_requests_a_status_line(serve, client):
    server = serve(*ONE, "--tcp", "127.0.0.1:0")
    host = client(server.where)
    ask(host, b"f+40")
    server.process.send_signal(signal.SIGUSR1)
    shown = server.errors()
    assert "gs_c200s idle at 40" in shown
    assert "1 of 1 lines connected" in shown
    assert ask(host, b"F") == b"R\r"


@pytest.mark.system
def test_no_input_brings_it_down_or_makes_it_grow(serve, client):
    flood(serve, client, 30_000)


@pytest.mark.long
@pytest.mark.timeout(900)
def test_a_million_random_bytes_neither(serve, client):
    flood(serve, client, 1_000_000)


@pytest.mark.system
@pytest.mark.posix
def test_a_status_line_on_a_terminal():
    terminal, ours = os.openpty()
    arguments = ("gs-c200s", "--tcp", "127.0.0.1:0", "--status")
    with subprocess.Popen([*COMMAND, *arguments], stdout=subprocess.PIPE, stderr=ours) as server:
        shown = b""
        while b"gs_c200s idle at 0 | 0 of 1 lines connected" not in shown:
            assert select.select([terminal], [], [], PATIENCE)[0]
            shown += os.read(terminal, 1000)
        server.terminate()
    assert server.returncode == 0
    for end in (terminal, ours):
        os.close(end)


@pytest.mark.system
def test_status_lines_into_a_pipe(serve):
    server = serve("gs-c200s", "--tcp", "127.0.0.1:0", "--status")
    for _ in range(2):
        assert "gs_c200s idle at 0 | 0 of 1 lines connected" in server.errors()


@pytest.mark.system
def test_indistinguishable_modules_are_reported_at_the_start(serve, client):
    chip = '[[chip]]\npart = "gs-c200s"\nname = "{}"\nstraps = {{ br0 = 0, br1 = 0, br2 = 0, sel2 = 0 }}\n'
    Path("line.toml").write_text(
        chip.format("left") + chip.format("right") + '[[serve]]\nchips = ["left", "right"]\ntcp = "127.0.0.1:0"\n'
    )
    server = serve("--bench", "line.toml", "--control", "127.0.0.1:0", ports=2)
    says = "left, right have the same address on one line: all of them answer; strap sel2, sel1, sel0 differently"
    assert server.errors() == f"slewline: left_line: same-address: {says}\n"
    status = Asks(client(server.ports["control"]))("status")
    assert status["troubles"] == [says]
    (found,) = status["lines"]["left+right"]["findings"]
    assert (found["code"], found["text"]) == ("same-address", says)


@pytest.mark.system
def test_the_reason_why_an_eeprom_was_not_written_is_reported(serve, client):
    server = serve(*ONE, "--tcp", "127.0.0.1:0", "--state", "st", "--control", "127.0.0.1:0", ports=2)
    shutil.rmtree("st")
    host = client(server.where)
    assert [host.ask(line) for line in (b"Po\r", b"A1\r", b"M\r", b"X\r", b"Q\r")] == [
        b"Y\r", b"Y\r", b"E6\r", b"E6\r", b"A1\r",
    ]  # fmt: skip
    says = "st/gs_c200s.eeprom: cannot write the memory: No such file or directory; give a file in a writable directory"
    assert server.errors() == f"slewline: {says}\n"
    assert Asks(client(server.ports["control"]))("status")["troubles"] == [says]


def test_a_journal_on_a_full_disk_is_reported(capfd):
    assert invoke([*ONE_MORE, "--journal", "/dev/full"]) == 2
    says = "slewline: journal /dev/full: No space left on device; give a file that can be written\n"
    assert capfd.readouterr().err == says


@pytest.mark.system
def test_a_journal_that_was_cut_off_replays_without_a_warning(lockstep):
    server, line = lockstep(journal="journal")
    server.bench.run(0)
    server.pace.start()
    line.take(b"V1\r")
    os.rename("journal", "cut")  # as if the server had been killed here
    with open("cut") as journal:
        assert '"verb":"write"' in journal.read().splitlines()[-1]
    ran = subprocess.run([*COMMAND[:-1], "run", "--replay", "cut"], check=False, capture_output=True, text=True)
    assert (ran.returncode, ran.stderr) == (0, "")
    server.close()


def flood(serve, client, total):
    """Random bytes, every hundredth with a parity fault: the module still answers, and what was done is told."""
    server = serve(*ONE, "--tcp", "127.0.0.1:0", "--control", "127.0.0.1:0", ports=2)
    host, control = client(server.ports["gs_c200s"]), client(server.ports["control"])
    for one in (host, control):
        one.socket.settimeout(600)

    def request(do, **more):
        control.send(json.dumps({"do": do} | more).encode() + b"\n")
        return json.loads(control.read(b"\n"))

    request("fault", line="gs_c200s", to="chip", kind="parity", count=10**9, chance=0.01, seed=6)
    chance = random.Random(12)
    host.send(chance.randbytes(total // 10))
    while request("status")["lines"]["gs_c200s"]["taken"] < total // 10:
        pass
    before, began = server.memory_kb(), time.monotonic()
    for _ in range(9):
        host.send(chance.randbytes(total // 10))
    while request("status")["lines"]["gs_c200s"]["taken"] < total:
        pass
    hits = request("clear", line="gs_c200s")["hits"]["chip"]["parity"]
    assert total * 0.008 < hits < total * 0.012
    assert request("status")["findings"] > total / 200
    assert server.memory_kb() < before + 20_000
    request("advance", time="10 s")
    for last in (b"\r", b"K\r"):
        host.send(last)
        request("advance", time="10 s")
    given = request("status")["lines"]["gs_c200s"]["given"]
    while given:
        given -= len(host.socket.recv(min(given, 1 << 16)))
    assert ask(host, b"F") in (b"R\r", b"B\r")
    status, told = server.end()
    assert status == 0
    codes = {line.split(": ")[2] for line in told.splitlines()}
    times = 2 + (time.monotonic() - began) // PERIOD_S
    assert len(codes) < len(told.splitlines()) <= times * (CAUSES + 1) * len(codes)  # each cause, and how many more


# -------------------------------------------------------------------------------------------------------- bench files
BENCH = """
[[chip]]
part = "gs-c200s"
name = "x"
straps = { br0 = 0, br1 = 0, br2 = 0, chs = 0, sel0 = 1, sel1 = 1, sel2 = 0 }

[[chip]]
part = "gs-c200s"
name = "y"
straps = { br0 = 0, br1 = 0, br2 = 0, chs = 0, sel0 = 1, sel1 = 0, sel2 = 1 }

[[chip]]
part = "gs-c200"
name = "z"
straps = { br0 = 0, br1 = 0, br2 = 0, chs = 0 }

[[chip]]
part = "cy525"
name = "c"

[[serve]]
chips = ["x", "y"]
tcp = "127.0.0.1:0"

[[serve]]
chips = ["z"]
pty = "z"

[[serve]]
chips = ["c"]
tcp = "127.0.0.1:0"
framing = true
"""


@pytest.mark.system
@pytest.mark.posix
def test_a_bench_file_serves_several_chips_at_the_same_time(serve, client, folder):
    (folder / "bench.toml").write_text(BENCH)
    server = serve("--bench", "bench.toml", "--lockstep", "--state", "memories", ports=3)
    assert list(server.ports) == ["x+y (addresses 1, 2)", "z", "c"]
    both, bus = client(server.where), client(server.ports["c"])
    bench = slewline.load("bench.toml")
    for name, value in (("x", b"+5"), ("y", b"-6")):
        address = str(bench[name].strapped_address()).encode()
        assert ask(both, address + b"f" + value) == b"Y\r"
        assert ask(both, address + b"V1") == b"V" + value + b"\r"
    with serial.Serial(server.ports["z"], 9600, bytesize=7, parity="O", stopbits=2, timeout=PATIENCE) as port:
        port.write(b"I1\r")
        assert port.read_until(b"\r") == b"Y\r"
    bus.send(b"A\nN 5\n?0\n")
    assert bus.read(b"\n").startswith(b"?0 ")
    status, told = server.end()
    hint, finding = told.splitlines()
    assert (status, hint) == (0, f"slewline: z: {HINT}")
    assert finding.startswith("slewline: c: missing-argument: ABSOLUTE needs position")
    assert os.listdir(".").count("z") == 0


@pytest.mark.parametrize(
    ("change", "says"),
    [
        (('chips = ["z"]', 'chips = ["w"]'), "[[serve]] 2, chips: no chip 'w' on the bench; available: x, y, z, c"),
        (('chips = ["z"]', 'chips = ["x"]'), "[[serve]] 2: x has a host or a port already"),
        (('pty = "z"', ""), "[[serve]] 2: found 0 ports; give one of tcp, pty, rfc2217, serial"),
        (('pty = "z"', 'pty = "z"\ntcp = "127.0.0.1:0"'), "[[serve]] 2: found 2 ports"),
        (('pty = "z"', 'pty = "z"\nframing = true'), "[[serve]] 2: z: already has a serial line"),
        (('pty = "z"', "pty = 7"), "[[serve]] 2, pty: found 7; allowed text"),
        (('pty = "z"', 'socket = "z"'), "unknown key; allowed chips, tcp, pty"),
        pytest.param(
            ('chips = ["c"]\ntcp', 'chips = ["c"]\nrfc2217'),
            "[[serve]] 3, rfc2217: c has no serial line",
            marks=[pytest.mark.posix, pytest.mark.system],  # the one before it opens a terminal
        ),
        (
            ('tcp = "127.0.0.1:0"\n\n[[serve]]\nchips = ["z"]', 'tcp = "0.0.0.0:0"\n\n[[serve]]\nchips = ["z"]'),
            "--allow-remote",
        ),
    ],
)
def test_mistakes_in_a_bench_file_are_reported_with_their_place(capfd, folder, change, says):
    assert change[0] in BENCH
    (folder / "bench.toml").write_text(BENCH.replace(*change, 1))
    assert invoke(["serve", "--bench", "bench.toml"]) == 2
    assert says in capfd.readouterr().err
    assert not os.path.lexists("z")


def test_a_bench_file_without_serve_is_reported(capfd, folder):
    (folder / "bench.toml").write_text(BENCH.partition("[[serve]]")[0])
    assert invoke(["serve", "--bench", "bench.toml"]) == 2
    assert "no [[serve]] table" in capfd.readouterr().err


@pytest.mark.parametrize(
    ("arguments", "says"),
    [
        ([], "give either a chip, such as gs-c200s, or --bench FILE"),
        (["gs-c200s"], "give one of --tcp, --pty, --rfc2217, --serial"),
        (["gs-c200s", "--tcp", "127.0.0.1:0", "--pty", "x"], "--pty: a chip has one port; leave out all but one"),
        (["gs-c200s", "--tcp", "127.0.0.1:0", "--lockstep", "--rate", "2"], "leave out --rate"),
        (["gs-c200s", "--tcp", "127.0.0.1:0", "--rate", "0"], "expected virtual seconds per second"),
        (["gs-c200s", "--tcp", "0.0.0.0:0"], "--allow-remote"),
        (["gs-c200s", "--tcp", "127.0.0.1:0", "--control", "0.0.0.0:0"], "--allow-remote"),
        (["gs-c200s", "--tcp", "nowhere"], "expected HOST:PORT"),
        pytest.param(["gs-c200s", "--pty", ""], "a pty needs a link", marks=pytest.mark.posix),
        (["gs-c200s", "--serial", "/dev/nowhere"], "/dev/nowhere"),
        (["gs-c200s", "--tcp", "127.0.0.1:0", "--framing"], "leave out framing"),
        (["gs-c200s", "--tcp", "127.0.0.1:0", "--strap", "chs"], "such as 'chs=0'"),
        (["gs-c200s", "--tcp", "127.0.0.1:0", "--strap", "xyz=0"], "no pin 'xyz'"),
        (["gs-c200s", "--tcp", "127.0.0.1:0", "--option", "xyz=0"], "no option 'xyz'"),
        (["gs-c200s", "--tcp", "127.0.0.1:0", "--option", "xyz"], "an option and its value"),
        (["gs-c200x", "--tcp", "127.0.0.1:0"], "no chip 'gs-c200x'"),
        (["gs-c200s", "--tcp", "127.0.0.1:0", "--log", "a", "--journal", "./a"], "--log and --journal: the same file"),
        (["gs-c200s", "--tcp", "127.0.0.1:0", "--anywhere"], "--anywhere needs --bench"),
        (["gs-c200s", "--tcp", "127.0.0.1:0", "--log", "no/where"], "give a file that can be written"),
        (["gs-c200s", "--tcp", "127.0.0.1:0", "--state", "/dev/null/x"], "give a writable directory"),
        (["--bench", "b.toml", "--strap", "chs=0"], "a bench file sets its own ports and options"),
        (["cy525", "--rfc2217", "127.0.0.1:0", "--framing"], "has no serial line"),
    ],
)
def test_wrong_use_is_reported(capfd, arguments, says):
    assert invoke(["serve", *arguments]) == 2
    assert says in capfd.readouterr().err


@pytest.mark.system
def test_other_machines_are_allowed_on_request(serve, client):
    server = serve(*ONE, "--tcp", "0.0.0.0:0", "--allow-remote")
    assert server.where.startswith("socket://0.0.0.0:")
    assert ask(client(server.where), b"F") == b"R\r"

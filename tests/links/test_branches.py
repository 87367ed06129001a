"""Branches: whatever ends, waits or speaks while they change, on servers in processes of their own."""

from __future__ import annotations

import json
import os
import select
import signal
import socket
import time
from contextlib import suppress
from pathlib import Path

import pytest

from .conftest import STRAPS, Asks, children, until
from .test_travel_families import differences, everything

pytestmark = [
    pytest.mark.system,
    pytest.mark.skipif(not hasattr(os, "fork"), reason="the system cannot copy a process"),
]

ONE = ("gs-c200s", *(f"--strap={pin}={level}" for pin, level in STRAPS.items()))
X = "gs_c200s"
LONG = ("Po", "S50", "T900", "R20", "L0", "+9", "-8", "L255", "E")  # moves again and again


class Module:
    """A server with one module, on a TCP port."""

    def __init__(self, serve, client, folder, *more):
        ports = ("--tcp", "127.0.0.1:0", "--control", "127.0.0.1:0")
        self.server = serve(*ONE, *ports, "--journal", folder / "journal", *more, ports=2)
        self.client = client
        self.ask, self.host = self.another(), client(self.server.ports[X])

    def another(self):
        """Another client of the control port."""
        return Asks(self.client(self.server.ports["control"]))

    def position(self):
        return self.ask("view")["view"]["chips"][X]["axes"][0]["position"]

    def begin(self, *lines):
        for line in lines:
            self.host.ask(line.encode() + b"\r")

    def worlds(self):
        """Processes of worlds: those whose parents are checkpoints."""
        return [child for one in children(self.server.process.pid) for child in children(one)]

    def descriptors(self):
        return len(os.listdir(f"/proc/{self.server.process.pid}/fd"))


@pytest.fixture
def module(serve, client, tmp_path):
    """Start a server with one module."""
    return lambda *more: Module(serve, client, tmp_path, *more)


def alive(process):
    """Is it there, and not only to be taken notice of?"""
    try:
        return Path(f"/proc/{process}/stat").read_text().rpartition(")")[2].split()[0] != "Z"
    except OSError:
        return False


def test_a_branch_has_a_past_of_its_own_even_without_a_different_input(module):
    x = module("--rate", "200")
    x.begin("Po", "S50", "T900", "R20", "+9000", "E")
    names = list(x.ask("view")["view"]["chips"][X]["registers"])
    never = [{"chip": X, "register": name, "value": -12345} for name in names]
    x.ask("breakpoints", breakpoints=(never * 256)[:256])  # which makes work of looking
    x.ask("pause")
    begin, before = x.ask("view")["time_ps"], len(children(x.server.process.pid))
    end = begin
    while len(children(x.server.process.pid)) < before + 5:  # checkpoints behind the last input
        end += 10**9
        assert x.ask("until", time=end)["met"]
    third, half = begin + (end - begin) // 3, begin + (end - begin) // 2
    x.ask("back", time=third)
    x.ask("power", chip=X, on=False)
    x.ask("until", time=end)
    off = everything(x.ask)
    x.ask("back", time=end)
    assert differences(off, everything(x.ask)) == []
    x.ask("back", time=half, branch=0)
    assert x.ask("view")["view"]["chips"][X]["powered"]
    x.ask("back", time=half, branch=1)
    assert not x.ask("view")["view"]["chips"][X]["powered"]


def test_two_clients_that_go_back_at_the_same_time_come_to_their_own_instants(module):
    x = module("--rate", "50")
    x.begin("Po", "S50", "T200", "R20", "+400", "E")
    time.sleep(0.2)
    x.ask("pause")
    now, other = x.ask("view")["time_ps"], x.another()
    for number in range(1, 6):
        late, early = now * (20 - number) // 20, now // (number + 10)
        for ask, at in ((x.ask, late), (other, early)):
            ask.client.send(json.dumps({"do": "back", "time": at, "branch": 0}).encode() + b"\n")
        one, two = x.ask.answer(), other.answer()
        assert (one["time_ps"], two["time_ps"]) == (late, early)
        shown = x.ask("branches")["current"]
        assert x.ask("view")["time_ps"] == (late if shown == one["branch"] else early)


@pytest.mark.parametrize("do", ["status", "branches", "branch", "back", "subscribe"])
def test_a_branch_that_does_not_answer_is_left(module, do):
    x = module()
    x.ask("pause")
    now = x.ask("advance", time="10 ms")["time_ps"]
    assert x.ask("back", time="1 ms")["branch"] == 1
    (world,) = x.worlds()
    os.kill(world, signal.SIGSTOP)
    keys = {"branch": {"number": 0}, "back": {"time": "2 ms"}, "subscribe": {"every": "10 ms"}}.get(do, {})
    reply = x.ask(do, **keys)  # is answered, with an error or not
    assert "time_ps" in reply and ("error" in reply) == (do in ("status", "subscribe", "back"))
    other = x.another()
    assert other("branches")["current"] == 0
    assert other("view")["time_ps"] == now
    until(lambda: not alive(world))


def test_a_branch_without_requests_is_left_as_well(module):
    x = module()
    x.ask("pause")
    x.ask("advance", time="10 ms")
    x.ask("subscribe", every="10 ms")
    x.ask("back", time="1 ms")
    (world,) = x.worlds()
    os.kill(world, signal.SIGSTOP)
    while (event := x.ask.answer()).get("event") != "branch" or event["branch"] != 0:
        pass
    until(lambda: not alive(world))
    x.another()("go")
    assert x.host.ask(b"F\r") == b"R\r"


def test_the_ports_of_a_branch_are_of_this_user_alone(module, tmp_path):
    x = module()
    x.ask("pause")
    x.ask("advance", time="10 ms")
    x.ask("back", time="1 ms")
    (world,) = x.worlds()
    assert (len(listening(x.server.process.pid)), listening(world)) == (2, [])
    sockets = [path for path in opened_sockets(world) if "slewline-" in path]
    assert len(sockets) >= 2 and {os.stat(Path(path).parent).st_mode & 0o777 for path in sockets} == {0o700}
    x.ask("branch", number=0)
    until(lambda: not any(map(os.path.exists, sockets)))  # it was left untouched, and is dropped


def numbers_of(process):
    """The numbers of the sockets that a process has open."""
    found = set()
    for name in os.listdir(f"/proc/{process}/fd"):
        with suppress(OSError):
            found.add(os.readlink(f"/proc/{process}/fd/{name}").removeprefix("socket:[").rstrip("]"))
    return found


def listening(process):
    """The TCP ports on which a process listens."""
    rows = [line.split() for line in Path(f"/proc/{process}/net/tcp").read_text().splitlines()[1:]]
    return [row[1] for row in rows if row[3] == "0A" and row[9] in numbers_of(process)]


def opened_sockets(process):
    """The paths of the Unix sockets on which a process listens."""
    rows = [line.split() for line in Path(f"/proc/{process}/net/unix").read_text().splitlines()[1:]]
    return [row[7] for row in rows if len(row) > 7 and row[6] in numbers_of(process)]


def test_a_branch_that_works_for_long_is_kept(module):
    x = module()
    x.ask("pause")
    x.ask("advance", time="10 ms")
    x.ask("back", time="1 ms")
    x.ask("until", time="2000 s")  # nothing happens: it is there at once, or works
    time.sleep(2)
    assert x.ask("branches")["current"] == 1


def test_refusals_change_nothing(module):
    x = module()
    assert "is in the future" in x.ask("back", time="1000 s")["error"]
    assert not x.ask("view")["view"]["pace"]["paused"]
    x.ask("pause")
    x.ask("back", time="1 ms")
    x.ask("go")
    for wrong in ([1], True, "1", 1.5):
        assert x.ask("back", time="1 ms", branch=wrong)["error"].startswith("back: branch: ")
        assert x.ask("branch", number=wrong)["error"].startswith("branch: number: ")
    assert x.ask("back", time="1 ms", branch=7)["error"] == "no branch 7; allowed: 0, 1"
    assert x.ask("branch", number=7)["error"].startswith("no branch 7; allowed: 0, ")
    assert "is in the future" in x.ask("back", time="1000 s", branch=0)["error"]
    x.ask("go")
    assert "is in the future" in x.ask("back", time="1000 s")["error"]
    before = x.ask("branches")
    assert not x.ask("view")["view"]["pace"]["paused"]  # neither of them lets a branch stand
    assert x.ask("view")["time_ps"] > before["time_ps"]


def test_clients_waiting_in_a_branch_are_notified_when_another_one_is_shown(module):
    x = module()
    x.ask("pause")
    x.ask("back", time="1 ms")
    x.ask("go", rate="0.001")
    other = x.another()
    assert other("view")["view"]["pace"]["branch"] == 1
    other.client.send(b'{"do": "until", "chip": "gs_c200s", "position": 7, "timeout": "1000 s", "id": 7}\n')
    assert x.ask("view")["view"]["pace"]["rate"] == 0.001  # and what the other one has said before has been read, too
    x.ask("branch", number=0)
    found = other.answer()
    assert found["id"] == 7 and found["error"] == "until: another branch is shown now"
    assert other("view")["view"]["pace"]["branch"] == 0
    worlds = x.worlds()
    x.server.kill()
    until(lambda: not any(alive(world) for world in worlds))  # though the branch still owed a reply


@pytest.mark.parametrize("shown", [True, False])
def test_a_branch_that_is_killed_leaves_the_first_run(module, shown):
    x = module()
    x.ask("pause")
    now = x.ask("view")["time_ps"]
    x.ask("back", time="1 ms")
    x.ask("drive", pin=f"{X}.ui1", level=0)
    if not shown:
        x.ask("branch", number=0)
    (world,) = x.worlds()
    os.kill(world, signal.SIGKILL)
    until(lambda: len(x.ask("branches")["branches"]) == 1)
    assert x.ask("view")["time_ps"] == now
    assert x.ask("branch", number=1)["error"] == "no branch 1; allowed: 0"
    assert x.ask("back", time="1 ms")["branch"] == 2
    x.ask("go")
    assert x.host.ask(b"V1\r") == b"V+0\r"


def test_checkpoints_that_are_killed_are_missed_and_the_server_continues(module):
    x = module()
    x.begin("V1")
    x.ask("pause")
    for process in children(x.server.process.pid):
        os.kill(process, signal.SIGKILL)
    for _ in range(3):
        assert "has ended" in x.ask("back", time="1 ms")["error"]
    x.ask("go")
    assert x.host.ask(b"V1\r") == b"V+0\r"
    until(lambda: all(map(alive, children(x.server.process.pid))))  # none is left that nobody has taken notice of


def test_a_world_that_is_killed_while_going_back_is_reported(module):
    x = module()
    x.begin(*["V1"] * 40)
    x.ask("pause")
    mark, *others = children(x.server.process.pid)
    for process in others:
        os.kill(process, signal.SIGKILL)  # so that it takes its time
    until(lambda: not set(others) & set(children(x.server.process.pid)))
    os.kill(mark, signal.SIGSTOP)
    before_all_new_ones = x.ask("view")["time_ps"] - 1
    x.ask.client.send(json.dumps({"do": "back", "time": before_all_new_ones}).encode() + b"\n")
    time.sleep(0.1)
    os.kill(mark, signal.SIGCONT)
    until(lambda: children(mark) or select.select([x.ask.client.socket], [], [], 0)[0])  # a quick one has answered
    for process in children(mark):
        with suppress(ProcessLookupError):
            os.kill(process, signal.SIGKILL)
    found = x.ask.answer()
    assert "error" not in found or found["error"].startswith("back: ")
    until(lambda: len(x.ask("branches")["branches"]) == 1)
    assert x.ask("back", time="1 ms")["time_ps"] == 10**9


# ------------------------------------------------------------------------------------------------------- the outside
def test_output_while_a_branch_is_shown_is_never_lost_or_repeated(module):
    x = module("--rate", "100")
    got, phases = 0, (None, 1, 0, 1, 0)
    for phase in phases:
        if phase is not None:
            x.ask("pause")
            x.ask("back", time=x.ask("view")["time_ps"]) if got == 20 else x.ask("branch", number=phase)
            x.ask("go")
        before = x.ask("view")["view"]["entries"]
        x.host.send(b"V1\r" * 20)  # more than the module takes
        until(lambda before=before: before < x.ask("view")["view"]["entries"])
        x.ask("until", time=x.ask("view")["time_ps"] + 2 * 10**12)  # all of it is said and answered
        said = x.ask("said", start=before)["entries"]
        got += sum(entry["text"].count("\\r") for entry in said if entry["kind"] == "got")
        if phase is None:
            first = got
            got = 20
    x.ask("branch", number=1)
    x.ask("go")
    x.host.send(b"F\r")
    assert x.host.read(b"R\r") == b"V+0\r" * (got - 20 + first) + b"R\r"


def test_a_host_whose_line_was_full_continues_in_the_branch_and_back(module):
    x = module("--rate", "100")
    x.ask("pause")
    x.host.send(b"V1\r" * 2000)  # the line takes 256 characters, and time stands
    until(lambda: x.ask("status")["lines"][X]["taken"] >= 256)
    x.ask("back", time=0)
    x.ask("go")
    assert x.host.read(b"V+0\r" * 2)
    until(lambda: x.ask("status")["lines"][X]["taken"] > 4000)
    x.ask("branch", number=0)
    x.ask("go")
    assert x.host.read(b"V+0\r" * 50)


def test_no_file_changes_while_a_branch_is_shown(module, tmp_path):
    state = tmp_path / "state"
    x = module("--rate", "20", "--state", state, "--log", tmp_path / "log")
    x.begin("Po", "S50")
    entered = x.ask("view")["time_ps"]  # while it has nothing to answer, which a branch from there would answer too
    x.begin("Px", "M")

    def disk():
        return {path.name: path.read_bytes() for path in [*state.iterdir(), tmp_path / "journal", tmp_path / "log"]}

    x.ask("pause")
    before = disk()
    assert set(before) == {".lock", "gs_c200s.eeprom", "journal", "log"}
    x.ask("back", time=entered)
    x.ask("go")
    for line in (b"Po\r", b"T900\r", b"Px\r", b"M\r", b"HELLO\r", b"X\r"):
        assert x.host.ask(line)
    x.ask("power", chip=X, on=False)
    x.ask("power", chip=X, on=True)
    assert disk() == before
    x.ask("branch", number=0)
    assert disk() == before or disk()["log"] != before["log"]
    x.ask("go")
    x.begin("Po", "T300", "Px", "M")
    assert all(disk()[name] != before[name] for name in ("journal", "gs_c200s.eeprom"))


def folder_of(x):
    """The folder of the journals of its branches: the journal of a world has its path."""
    found = []
    for name in os.listdir(place := f"/proc/{x.worlds()[0]}/fd"):
        with suppress(FileNotFoundError):  # it has been closed meanwhile
            found.append(Path(os.readlink(f"{place}/{name}")))
    return next(path.parent for path in found if path.name.startswith("branch"))


@pytest.mark.parametrize("number", [signal.SIGTERM, signal.SIGINT, signal.SIGHUP, signal.SIGKILL])
def test_no_process_and_no_file_remains(module, number):
    x = module()
    x.ask("pause")
    x.ask("until", time="5 ms")
    for at in ("1 ms", "2 ms", "3 ms"):
        x.ask("back", time=at, branch=0)
        x.ask("drive", pin=f"{X}.ui1", level=0)
        x.ask("go")
    marks = children(x.server.process.pid)
    group, folder = [*marks, *x.worlds()], folder_of(x)
    assert len(x.worlds()) == 3
    status, err = x.server.end(number)
    assert (status, err) == ((-9, "") if number == signal.SIGKILL else (0, ""))
    until(lambda: not any(alive(process) for process in group))
    assert folder.exists() == (number == signal.SIGKILL)


def test_a_server_ends_in_good_order_while_a_branch_owes_a_reply(module):
    x = module()
    x.ask("pause")
    x.ask("back", time="1 ms")
    x.ask("go", rate="0.001")
    other = x.another()
    other.client.send(b'{"do": "until", "chip": "gs_c200s", "position": 7, "timeout": "1000 s", "id": 7}\n')
    assert x.ask("view")["view"]["pace"]["branch"] == 1
    time.sleep(0.05)
    assert x.server.end() == (0, "")


def test_many_returns_leave_nothing_open(module):
    x = module("--rate", "20")
    x.begin("Po", "S50", "T200", "R20", "+400", "E")
    x.ask("pause")
    now = x.ask("view")["time_ps"]
    x.ask("back", time=now)
    was, processes, memory = x.descriptors(), len(x.worlds()), x.server.memory_kb()
    for number in range(40):
        assert x.ask("back", time=now * (number % 20) // 20, branch=0)["time_ps"] == now * (number % 20) // 20
    until(lambda: len(x.worlds()) == processes)
    until(lambda: x.descriptors() == was)
    assert x.server.memory_kb() - memory < 2000
    assert len(list(folder_of(x).iterdir())) == 4  # lock, journal, control port and line of the branch that is shown


def test_twenty_branches_that_were_changed_of_which_the_last_ones_are_kept(module):
    x = module()
    x.ask("pause")
    for number in range(1, 21):
        assert (
            x.ask("back", time=f"{number} us")["branch"] == number
            if number == 1
            else x.ask("back", time=f"{number} us", branch=0)
        )
        x.ask("drive", pin=f"{X}.ui1", level=0)
    found = x.ask("branches")
    assert [row["number"] for row in found["branches"]] == [0, *range(5, 21)] and found["current"] == 20
    until(lambda: len(x.worlds()) == 16)
    assert x.ask("branch", number=5)["time_ps"] == 5 * 10**6


def test_a_branch_of_a_branch_of_a_branch(module):
    x = module("--rate", "20")
    x.begin(*LONG)
    time.sleep(0.2)
    x.ask("pause")
    now = x.ask("view")["time_ps"]
    places = {}
    for number in range(1, 7):
        x.ask("back", time=now // 2 + number * 10**9)
        x.ask("drive", pin=f"{X}.ui1", level=number % 2)
        x.ask("until", time=now // 2 + (number + 2) * 10**9)
        places[number] = everything(x.ask)
    for number in (3, 1, 6, 2, 5, 4):
        x.ask("branch", number=number)
        assert differences(places[number], everything(x.ask)) == []
        x.ask("back", time=places[number]["status"]["time_ps"], branch=number)
        assert differences(places[number], everything(x.ask)) == []


def test_a_branch_in_program_entry_is_unchanged_on_return(module):
    """No host has gone there, though nobody speaks to it for a while."""
    x = module()
    x.begin("Po", "S50")
    x.ask("pause")
    x.ask("back", time=x.ask("view")["time_ps"])
    x.ask("drive", pin=f"{X}.ui1", level=0)
    left = everything(x.ask)
    x.ask("branch", number=0)
    x.ask("branch", number=1)
    assert differences(left, everything(x.ask)) == []


def test_a_client_or_a_host_that_goes_in_the_middle(module, client):
    x = module()
    for number in range(1, 6):
        gone = x.another()
        gone.client.send(b'{"do": "back", "time": "1 ms", "branch": 0}\n')
        gone.client.close()
        until(lambda number=number: x.ask("branches")["current"] == number)
    x.host.close()
    host = client(x.server.ports[X])
    x.ask("go")
    assert host.ask(b"V1\r") == b"V+0\r"
    host.close()
    x.ask("branch", number=0)
    x.ask("go")
    assert client(x.server.ports[X]).ask(b"V1\r") == b"V+0\r"


def test_events_continue_when_branches_change_and_stop_when_they_are_no_longer_requested(module):
    x = module()
    x.ask("pause")
    x.ask("back", time="1 ms")
    x.ask("subscribe", every="10 ms")  # in a branch
    x.ask.client.send(b'{"do": "branch", "number": 0, "id": 1}\n')

    def next_event(kind):
        while (found := x.ask.answer()).get("event") != kind:
            pass
        return found

    assert next_event("branch")["branch"] == 0
    assert next_event("view")["view"]["pace"]["branch"] == 0  # whole
    x.ask.client.send(b'{"do": "drive", "pin": "gs_c200s.ui1", "level": 0}\n')
    assert next_event("view")["view"]["chips"][X]["levels"]["ui1"] == 0
    x.ask.client.send(b'{"do": "back", "time": "1 ms"}\n')
    next_event("branch")
    x.ask.client.send(b'{"do": "subscribe", "every": 0, "id": "end"}\n')
    while x.ask.answer().get("id") != "end":
        pass
    x.ask.client.socket.settimeout(0.3)
    with pytest.raises(socket.timeout):
        x.ask.answer()
    before = cpu_s(x.server.process.pid)
    time.sleep(0.3)
    assert cpu_s(x.server.process.pid) - before < 0.1


def cpu_s(process):
    """The time that a process has worked."""
    return sum(map(int, Path(f"/proc/{process}/stat").read_text().rpartition(")")[2].split()[11:13])) / os.sysconf(
        "SC_CLK_TCK"
    )


@pytest.mark.parametrize(
    ("name", "pieces", "answer"),
    [
        ("mc1451a", (b"\x90", b"\x00"), b"\x02"),
        ("cy525", (b"?", b"\r"), b"? ready\r\n"),
    ],
)
def test_requests_that_come_in_pieces_are_whole_in_the_branch(serve, client, tmp_path, name, pieces, answer):
    """The beginning goes to the first run, the end to the branch, and the next ones the other way."""
    framing = ["--framing"] if name == "cy525" else []
    ports = ("--tcp", "127.0.0.1:0", "--control", "127.0.0.1:0", "--journal", tmp_path / "journal")
    server = serve(name, *framing, *ports, ports=2)
    ask, host = Asks(client(server.ports["control"])), client(server.ports[name])
    if name == "mc1451a":
        host.read(b"\n")
    ask("until", time="20 ms")
    first, rest = pieces
    for step in range(4):
        host.send(first)
        time.sleep(0.05)
        ask("pause")
        ask("back", time="10 ms") if not step % 2 else ask("branch", number=0)
        ask("go")
        host.send(rest)
        assert host.read(answer) == answer

"""A chipset that is served with another card: by requests, by the clients in Python, and by a host program in C."""

from __future__ import annotations

import shutil
import subprocess

import pytest

import slewline
from slewline.cli.main import invoke
from slewline.links.clients.chipset_host import ChipsetHost
from slewline.links.clients.chipset_port import ChipsetPort
from slewline.links.lines.pace import Lockstep
from slewline.links.server import Server
from tests.rows import rows

from .conftest import PATIENCE, Asks, Threaded

EXAMPLES = __file__.partition("tests")[0] + "examples/mc1451a"
COMPILER = shutil.which("cc") or shutil.which("gcc") or shutil.which("clang")
OWN = "data=4,command=6,status=7,reset=5"
CARDS = ("pmd", "pi-c842", OWN)


def place(where):
    host, port = where.rpartition("//")[2].rsplit(":", 1)
    return host, int(port)


class Stand:
    """A chipset x behind a card, in lockstep in a thread of this process."""

    def __init__(self, card):
        self.bench = slewline.Bench()
        self.x = self.bench.add("mc1451a", name="x")
        server = Server(self.bench, Lockstep(self.bench))
        self.where = place(server.tcp(server.line(self.x, card=card), "127.0.0.1:0").where)
        self.threaded = Threaded(server)

    def __enter__(self):
        self.running = self.threaded.__enter__()
        return self

    def __exit__(self, *error):
        self.threaded.__exit__(*error)

    def findings(self):
        return self.running.do(lambda: [found.text for found in self.bench.findings])


def program(port, base):
    """A host program byte by byte; returns what it has read."""
    at = {name: base + offset for name, offset in port.at.items()}

    def ready():
        polls = 1
        while not port.inp(at["status"]) & 0x80:
            polls += 1
        return polls

    found = []
    for code, words in ((0x6C, ()), (0x10, (0, 1000)), (0x11, (8, 0)), (0x12, (0, 0x1000)), (0x1A, ()), (0x4A, ())):
        found.append(ready())
        port.out(at["command"], code)
        for word in words:
            for byte in divmod(word, 0x100):
                found.append(ready())
                port.out(at["data"], byte)
        for _ in range(2 if code == 0x4A else code == 0x6C):
            for _ in range(2):
                found.append(ready())
                found.append(port.inp(at["data"]))
    if "reset" in at:
        port.out(at["reset"], 0)
        found.append(port.ready())
    return found


@pytest.mark.system
@pytest.mark.parametrize("card", CARDS)
def test_a_client_learns_where_the_registers_are(card):
    """What the client foresees is what a client that waits for every answer sees, at the same instants."""
    seen = []
    for plain in (False, True):
        with Stand(card) as stand, ChipsetPort(*stand.where, plain=plain) as port:
            bytes_read = program(port, 0x340)
            seen.append((bytes_read, stand.running.do(lambda stand=stand: stand.bench.now_ps), stand.findings()))
    assert seen[0] == seen[1]
    assert seen[0][2] == [] and [seen[0][0][at] for at in (2, 4)] == [0x5C, 0x11]


@pytest.mark.system
@pytest.mark.parametrize("card", CARDS)
def test_a_host_by_names_works_on_any_card(card):
    with Stand(card) as stand, ChipsetHost(*stand.where) as host:
        host.command("SET_POS", 1000)
        host.command("SET_VEL", 0x80000)
        host.command("SET_ACC", 0x1000)
        host.command("UPDATE")
        host.wait("motion_complete", every=0)
        assert host.query("GET_TRGT_POS") == 1000 and stand.findings() == []


HOST = """
#include <stdio.h>
#include "slewline_port.h"
#define CARD 0x210
static void ready(void) { while (!(inp(CARD + 1) & 0x80)) ; }
static void command(int code) { ready(); outp(CARD + 1, code); }
static void byte(long value) { ready(); outp(CARD, (int)(value & 0xFF)); }
static void number(int code, long value)
{
    command(code);
    byte(value >> 24); byte(value >> 16); byte(value >> 8); byte(value);
}
static unsigned word(void)
{
    unsigned high;

    ready();
    high = inp(CARD);
    ready();
    return high << 8 | inp(CARD);
}
int main(void)
{
    static const int begin[] = {0x01, 0x33, 0x41, 0x43, 0x45, 0x09};
    unsigned status, at;

    command(0x39);
    outp(CARD + 2, 0x0F); /* the board's own register, without a look at the status */
    for (at = 0; at < sizeof begin / sizeof *begin; at++)
        command(begin[at]);
    number(0x12, 0x1000); number(0x11, 0x80000); number(0x10, 1000);
    command(0x1A);
    for (at = 0; at < 2000; at++) {
        command(0x31);
        status = word();
        if (status & 1)
            break; /* motion complete */
    }
    command(0x1D);
    at = word();
    printf("%u %u\\n", at, word());
    return 0;
}
"""


@pytest.mark.system
@pytest.mark.skipif(COMPILER is None, reason="no C compiler (cc, gcc, clang) on this machine")
@pytest.mark.parametrize("how", [("--lockstep",), ()])
def test_a_host_program_for_a_c842_works_with_its_card_and_is_a_finding_without(serve, client, tmp_path, how):
    (tmp_path / "host.c").write_text(HOST)
    flags = ["-std=c89", "-pedantic", "-Wall", "-Wextra", "-Werror", f"-I{EXAMPLES}"]
    subprocess.run([COMPILER, *flags, "-o", tmp_path / "host", tmp_path / "host.c"], check=True)
    served = ("mc1451a", "--tcp", "127.0.0.1:0", "--control", "127.0.0.1:0", *how)
    for card, printed, position in ((("--card", "pi-c842"), "0 1000\n", 1000), ((), None, 0)):
        server = serve(*served, *card, ports=2)
        environment = {"SLEWLINE": server.where.rpartition("//")[2]}
        ran = subprocess.run(
            [tmp_path / "host"], env=environment, capture_output=True, text=True, timeout=PATIENCE, check=False
        )
        status = Asks(client(server.ports["control"]))("status")
        assert status["chips"]["mc1451a"]["position"] == position
        every = Asks(client(server.ports["control"]))("findings", source="mc1451a_isa")["findings"]
        found = [one["text"] for one in every if one["code"] == "no-register"]
        if printed is not None:
            assert (ran.returncode, ran.stdout, found) == (0, printed, [])
        else:
            assert [text.split(":")[0] for text in found][:2] == [
                "IN 0x341 reads FF",
                "OUT 0x341 has no effect",
            ], found


@rows(
    ("arguments", "says"),
    [
        (("mc1451a", "--card", "c842", "--tcp", "127.0.0.1:0"), "card 'c842': not known; allowed pmd, pi-c842"),
        (("gs-c200s", "--card", "pmd", "--tcp", "127.0.0.1:0"), "only a chipset has a card"),
        (("--bench", "x.toml", "--card", "pmd"), "leave out ports"),
    ],
)
def test_a_card_that_cannot_be_is_refused(capfd, arguments, says):
    assert invoke(["serve", *arguments]) == 2
    assert says in capfd.readouterr().err


@pytest.mark.system
def test_a_bench_file_names_the_card(serve, tmp_path):
    file = tmp_path / "x.toml"
    file.write_text(
        '[[chip]]\nname = "x"\npart = "mc1451a"\n[[serve]]\nchips = ["x"]\ntcp = "127.0.0.1:0"\ncard = "pi-c842"\n'
    )
    server = serve("--bench", str(file))
    with ChipsetPort(*place(server.where)) as port:
        assert port.at == {"data": 0, "status": 1, "command": 1, "function": 2}
        assert port.packet(0x6C, reads=2) == (0x5C11, 0x5C7D)

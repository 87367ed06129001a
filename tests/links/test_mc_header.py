"""Host programs in C on a served chipset: they have the header of the examples, and else what a program on a PC has."""

from __future__ import annotations

import shutil
import subprocess

import pytest

from tests.ensembles import few

from .conftest import PATIENCE, Asks, until

EXAMPLES = __file__.partition("tests")[0] + "examples/mc1451a"
SERVED = ("mc1451a", "--tcp", "127.0.0.1:0", "--control", "127.0.0.1:0")
COMPILER = shutil.which("cc") or shutil.which("gcc") or shutil.which("clang")
pytestmark = [
    pytest.mark.system,
    pytest.mark.skipif(COMPILER is None, reason="no C compiler (cc, gcc, clang) on this machine"),
]


@pytest.fixture
def run(tmp_path):
    """Compile a program, from a file or its text, and run it; `where` goes into its environment."""

    def start(source, where=None, standard="c89", arguments=()):
        if not source.endswith(".c"):
            (tmp_path / "program.c").write_text(f'#include <stdio.h>\n#include "slewline_port.h"\n{source}')
            source = str(tmp_path / "program.c")
        flags = [f"-std={standard}", "-pedantic", "-Wall", "-Wextra", "-Werror", f"-I{EXAMPLES}"]
        subprocess.run([COMPILER, *flags, "-o", tmp_path / "program", source], check=True)
        environment = {} if where is None else {"SLEWLINE": where.rpartition("//")[2]}
        command = [tmp_path / "program", *arguments]
        started.append(
            subprocess.Popen(command, env=environment, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)
        )
        return started[-1]

    started = []
    yield start
    for one in started:
        one.kill()
        one.communicate()


def ended(program):
    """Exit status, standard output, standard error."""
    out, err = program.communicate(timeout=PATIENCE)
    return program.returncode, out, err


@pytest.mark.parametrize("standard", few(["c89", "c99", "c11"], 1))
def test_a_program_homes_an_axis_in_real_time(serve, client, run, standard):
    server = serve(*SERVED, ports=2)
    ask = Asks(client(server.ports["control"]))
    program = run(f"{EXAMPLES}/homing.c", server.where, standard)
    assert program.stdout.readline() == "version 5c11\n"
    until(lambda: ask("status")["chips"]["mc1451a"]["position"] < -500)
    ask("drive", pin="mc1451a.home1", level=0)
    assert ended(program) == (0, "home\nat 500\n", "")
    chip = ask("status")["chips"]["mc1451a"]
    assert (chip["position"], chip["findings"]) == (500, [])


def test_the_same_in_lockstep_where_time_passes_by_its_accesses(serve, client, run):
    server = serve(*SERVED, "--lockstep", ports=2)
    ask = Asks(client(server.ports["control"]))
    program = run(f"{EXAMPLES}/homing.c", server.where)
    assert program.stdout.readline() == "version 5c11\n"
    until(lambda: ask("status")["chips"]["mc1451a"]["position"] < -500)
    ask("drive", pin="mc1451a.home1", level=0)
    assert ended(program) == (0, "home\nat 500\n", "")


def test_every_name_for_a_port_reaches_the_chipset(serve, client, run):
    server = serve(*SERVED, "--lockstep", ports=2)
    program = run(
        """
        #define GET(in) (slewline_ready(100), in)
        int main(void)
        {
            if (ioperm(0x340, 16, 1) != 0) return 2;
            while (!(inp(0x344) & 0x80)) ;
            outp(0x342, 0x6c);             printf("%02x", GET(inp(0x340))); printf("%02x ", inp(0x340));
            _outp(0x342, GET(0x6c));       printf("%02x", GET(_inp(0x340))); printf("%02x ", _inp(0x340));
            outportb(0x342, GET(0x6c));    printf("%02x", GET(inportb(0x340))); printf("%02x ", inportb(0x340));
            outb(GET(0x6c), 0x342);        printf("%02x", GET(inb(0x340))); printf("%02x ", inb(0x340));
            slewline_out(2, GET(0x6c));    printf("%02x", GET(slewline_in(0))); printf("%02x ", slewline_in(0));
            outpw(0x342, GET(0xff6c));     printf("%04x ", GET(inpw(0x340)));
            _outpw(0x342, GET(0xff6c));    printf("%04x ", GET(_inpw(0x340)));
            printf("%d", slewline_ready(0));
            slewline_close();
            return 0;
        }
        """,
        server.where,
    )
    assert ended(program) == (0, "5c11 5c11 5c11 5c11 5c11 ff5c ff5c 1", "")
    assert Asks(client(server.ports["control"]))("status")["chips"]["mc1451a"]["findings"] == []


OPEN = """
int main(int count, char **words)
{
    if (count != 3 || slewline_open(words[1], atoi(words[2])) != 0) return 3;
    printf("%d\\n", slewline_ready(100)); fflush(stdout);
    for (;;) inp(0x344);
}
"""


def place(where):
    return where.rpartition("//")[2].split(":")


def test_a_server_that_goes_away_ends_the_program(serve, run):
    server = serve(*SERVED, ports=2)
    program = run(OPEN, arguments=place(server.where))
    assert program.stdout.readline() == "1\n"
    server.kill()
    assert ended(program) == (1, "", "slewline_port: the server has closed the connection\n")


def test_the_next_program_learns_the_owner_of_the_port(serve, client, run):
    server = serve(*SERVED, ports=2)
    first = client(server.where)
    name = "{}:{}".format(*first.socket.getsockname())
    host, port = place(server.where)
    says = f"slewline_port: {host}:{port} says: slewline: {name} has this port; one host at a time"
    status, out, err = ended(run(OPEN, arguments=(host, port)))
    assert (status, out, err.strip()) == (3, "", says)


def test_a_name_of_a_machine_will_do(serve, run):
    server = serve(*SERVED, "--lockstep", ports=2)
    program = run(OPEN, arguments=("localhost", place(server.where)[1]))
    assert program.stdout.readline() == "1\n"


READ = "int main(void) { return inp(0x344); }"


@pytest.mark.parametrize(
    ("where", "says"),
    [
        (None, "slewline_port: where is the chipset? call slewline_open, or set SLEWLINE=127.0.0.1:4001\n"),
        ("127.0.0.1", "slewline_port: where is the chipset? call slewline_open, or set SLEWLINE=127.0.0.1:4001\n"),
        ("127.0.0.1:1", "slewline_port: no server at 127.0.0.1:1\n"),
    ],
)
def test_a_missing_chipset_is_reported(run, where, says):
    assert ended(run(READ, where)) == (1, "", says)

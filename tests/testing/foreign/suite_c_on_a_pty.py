"""A program in C that knows a device file: raw, 9600 baud, 7 data bits, odd parity, 2 stop bits."""

import shutil
import subprocess

import pytest

PROGRAM = r"""
#include <fcntl.h>
#include <poll.h>
#include <stdio.h>
#include <string.h>
#include <termios.h>
#include <unistd.h>

static int port;

static const char *ask(const char *line) {
    static char answer[32];
    size_t got = 0;
    struct pollfd ready = {port, POLLIN, 0};
    write(port, line, strlen(line));
    write(port, "\r", 1);
    while (got < sizeof answer - 1 && poll(&ready, 1, 60000) > 0 && read(port, answer + got, 1) == 1)
        if (answer[got++] == '\r') break;
    answer[got ? got - 1 : 0] = 0;
    return answer;
}

int main(int count, char **words) {
    struct termios line;
    const char *program[] = {"Po", "S10", "T100", "R50", words[2], "E"};
    port = open(words[1], O_RDWR | O_NOCTTY);
    if (port < 0 || tcgetattr(port, &line)) return perror(words[1]), 1;
    cfmakeraw(&line);
    line.c_cflag = (line.c_cflag & ~CSIZE) | CS7 | PARENB | PARODD | CSTOPB | CLOCAL | CREAD;
    cfsetspeed(&line, B9600);
    if (tcsetattr(port, TCSANOW, &line)) return perror("tcsetattr"), 1;
    for (int n = 0; n < 6; n++)
        if (strcmp(ask(program[n]), "Y")) return fprintf(stderr, "%s\n", program[n]), 1;
    while (!strcmp(ask("F"), "B"));
    puts(ask("V1"));
    close(port);
}
"""
pytestmark = pytest.mark.slewline(on="pty", straps={"chs": 0})


@pytest.fixture(scope="module")
def program(tmp_path_factory):
    compiler = shutil.which("cc")
    if compiler is None:
        pytest.skip("needs a C compiler")
    folder = tmp_path_factory.mktemp("program")
    (folder / "feed.c").write_text(PROGRAM)
    subprocess.run([compiler, "-o", folder / "feed", folder / "feed.c"], check=True)
    return folder / "feed"


def fed(*words):
    """What the program prints, if it succeeds."""
    return subprocess.run(words, check=True, stdout=subprocess.PIPE, text=True, timeout=100).stdout


@pytest.mark.parametrize("steps", [1, 30, -30])
def test_it_feeds_a_sheet(gs_c200s, program, steps):
    assert fed(program, gs_c200s.url, f"{steps:+d}") == f"V{steps:+d}\n"
    gs_c200s.assert_steps(abs(steps))


def test_it_runs_again_and_again_on_one_module(gs_c200s, program):
    for number in range(1, 4):
        assert fed(program, gs_c200s.url, "+5") == f"V+{5 * number}\n"

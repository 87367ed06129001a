"""Walks through the page as a user takes them: Chromium, and the command in a process of its own."""

from __future__ import annotations

import os
import subprocess
import sys
from contextlib import contextmanager, suppress
from pathlib import Path

import pytest

from .walking import DESKTOP, PHONE, Walk, running

pytestmark = pytest.mark.system
LONGEST_S = 3.0  # of work of the command, until something moves

WELDING = """
[[chip]]
part = "cy525"
name = "x"
crystal = "11 MHz"

[[part]]
kind = "workpieces"
name = "table"
to = "x"
pieces = 2
welds = 6
change = "1 s"

[[part]]
kind = "welder"
name = "carriage"
to = "x"

[[host]]
chips = ["x"]
script = []
"""

# A host program as anybody would write it: it stores a program, starts it, and asks now and then.
HOST = """
import sys, time, serial
host = serial.serial_for_url(sys.argv[1], timeout=1)
def ask(line):
    host.write(line + b"\\r")
    return host.read_until(b"\\r")
for line in b"Po S10 T100 R10 jc1,18 jc2,24 j12 +30 j12 -30 j12 E".split():
    assert ask(line) == b"Y\\r", line
print("stored", flush=True)
while True:
    time.sleep(0.2)
    answer = ask(b"F")
    assert not answer.strip(b"B\\r"), answer  # none, or a part of one, where time stands
"""

WELDERS = [  # a phone is held against test_page in every run, and dark by the walk with the keyboard
    pytest.param(DESKTOP, "light", id="desktop"),
    pytest.param(PHONE, "dark", id="phone", marks=pytest.mark.long),
]
PLACES = [60000, -45000, 30000, -15000]
S_CURVE = "SET_PRFL_S_CRV\nSET_VEL 0x30000\nSET_MAX_ACC 0x80\nSET_JERK 0x8000\n"
AXES = [f"SET_{axis}\n{S_CURVE}SET_POS {place}\n" for axis, place in enumerate(PLACES, 1)]
S_CURVES = "".join([*AXES, "MULTI_UPDATE 0xF\n"])

MODULES = ("left", "middle", "right")
LINE = "".join(
    f'[[chip]]\npart = "gs-c200s"\nname = "{name}"\nstraps = {{ br0 = 0, br1 = 0, br2 = 0, chs = 0, sel{n} = 0 }}\n\n'
    for n, name in enumerate(MODULES)
) + f'[[serve]]\nchips = {list(MODULES)}\ntcp = "127.0.0.1:0"\n'.replace("'", '"')

FRONT_PANEL = """
[[chip]]
part = "cy545b"
name = "x"

[[part]]
kind = "hp_display"
name = "display"
to = "x"

[[part]]
kind = "thumbwheels"
name = "wheels"
to = "x"
letter = "N"
value = "00000025"

[[part]]
kind = "jog_switch"
name = "switch"
to = "x"

[[part]]
kind = "motor"
name = "motor"
to = "x"

[[part]]
kind = "switch"
name = "home"
on = "motor"
low = 30

[[wire]]
from = "home.out"
to = "x.usrb0"

[[host]]
chips = ["x"]
script = ["O 95H"]
"""


@pytest.fixture
def bench(tmp_path):
    """Write a bench file, or a program, and return where it is."""

    def written(text, name="bench.toml"):
        (tmp_path / name).write_text(text)
        return tmp_path / name

    return written


@pytest.fixture
def walk(browser, tmp_path):
    """Open pages; at the end of a test all are closed, and nothing has gone wrong on them."""
    walks = []

    def opened(url, size=DESKTOP, scheme="light"):
        walks.append(Walk(browser, url, tmp_path, size, scheme))
        return walks[-1]

    return opened


@pytest.mark.parametrize(("size", "scheme"), WELDERS)
def test_twelve_spots_are_welded_with_the_controls_of_the_page(walk, bench, size, scheme):
    with running("panel", bench(WELDING), "--no-browser") as command:
        page = walk(command.port("panel"), size, scheme)
        page.page.get_by_role("tab", name="Editor").click()
        page.page.get_by_label("Example", exact=True).select_option("programs/weld.cy525")
        page.page.get_by_text("20 bytes").wait_for()
        page.button("10 times real time").click()
        page.button("Run").click()
        table = page.part("table, workpieces")
        finished = table.locator(".figures > div", has_text="finished").locator("dd")
        page.until(lambda: finished.text_content() in ("1", "2"))  # the second one follows in half a second
        page.picture("weld_half")
        page.until(lambda: finished.text_content() == "2")
        page.page.get_by_role("img", name="carriage carriage, 12 spots").wait_for()
        page.picture("weld_done")
        page.close()


@contextmanager
def host_program(url):
    """Run a host program in a process of its own; it must not fail as long as it is needed."""
    process = subprocess.Popen(
        [sys.executable, "-c", HOST, url], stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True
    )
    with process:
        try:
            assert process.stdout.readline() == "stored\n", process.stderr.read()
            yield process
            assert process.poll() is None, process.stderr.read()
        finally:
            process.kill()


@pytest.mark.parametrize(
    "attached", [pytest.param(False, id="serve"), pytest.param(True, id="attach", marks=pytest.mark.long)]
)
def test_a_program_is_taken_back_and_takes_the_other_path(walk, attached, tmp_path):
    own = ["--control", "127.0.0.1:0", "--journal", tmp_path / "journal"] if attached else ["--panel", "127.0.0.1:0"]
    serve = ("serve", "gs-c200s", "--strap", "chs=0", "--tcp", "127.0.0.1:0")
    with (
        running(*serve, *own, may_say=("unfinished",)) as server,  # a pause may come between the two bytes of a command
        host_program(server.port("gs_c200s")),
    ):
        if not attached:
            other_way(walk(server.port("panel")), by_slider=False)
            return
        with running("panel", "--attach", server.port("control"), "--no-browser") as panel:
            other_way(walk(panel.port("panel"), scheme="dark"), by_slider=True)


def other_way(page, by_slider):
    """Stop a program at a jump, step it, go back five seconds, and change the input that it asks."""
    chip = "gs_c200s"
    page.pin("ui2").click()
    page.pin("ui3").click()
    page.until(lambda: page.position() > 0)
    began = page.seconds()
    page.until(lambda: page.seconds() > began + 6)
    listing = page.page.get_by_role("listbox", name=f"Program of {chip}")
    listing.get_by_text("jc1,18", exact=True).click()
    page.page.locator(".stopped", has_text="at instruction 12").wait_for()
    page.until(lambda: page.current() == "jc1,18")
    page.picture(f"jump_stopped_{by_slider}")
    seen = []
    for text in ("+30", "j12"):
        page.button("Instruction").click()
        page.until(lambda text=text: page.current() == text)
        seen.append(page.position())
    assert seen[1] == seen[0] + 30
    listing.get_by_text("jc1,18", exact=True).click()
    page.page.locator(".listing-row[aria-selected=true]").wait_for(state="detached")

    now, there = page.seconds(), page.position()
    if by_slider:
        page.page.get_by_label("Past", exact=True).focus()
        page.page.get_by_label("Past", exact=True).fill(str(round(10_000 * (now - 5) / now)))
    else:
        page.page.get_by_label("Target of the run").fill(f"{now - 5:.6f} s")
        page.button("Run there").click()
    page.until(lambda: abs(page.seconds() - (now - 5)) < 0.01)
    page.page.get_by_label("Branch", exact=True).wait_for()
    page.until(lambda: 0 < page.position() < there)
    assert page.button("Go").is_visible()
    before = page.position()
    page.pin("ui1").click()
    page.pin("ui2").click()
    page.until(lambda: page.pin("ui1").get_attribute("data-level") == "0")
    page.until(lambda: page.pin("ui2").get_attribute("data-level") == "1")
    page.button("Go").click()
    page.until(lambda: page.position() < before - 60)
    page.until(lambda: page.seconds() > now - 4)
    page.picture(f"jump_other_way_{by_slider}")
    page.close()


@pytest.mark.parametrize("scheme", ["light", pytest.param("dark", marks=pytest.mark.long)])
def test_four_axes_turn_in_s_curves(walk, bench, scheme):
    with running("panel", bench(S_CURVES, "curves.mc1451a"), "--run", "--no-browser") as command:
        page = walk(command.port("panel"), scheme=scheme)
        page.until(lambda: page.position(axis=0) > 20000)
        page.picture(f"curves_{scheme}")
        page.until(lambda: [page.position(axis=axis) for axis in range(4)] == PLACES)
        page.picture(f"curves_end_{scheme}")
        page.close()


def test_three_modules_share_a_line(walk, bench):
    with running("serve", "--bench", bench(LINE), "--panel", "127.0.0.1:0") as server:
        page = walk(server.port("panel"))
        for address, chip in zip((4, 2, 1), MODULES, strict=True):
            page.send(chip, *(f"{address}{line}" for line in ("Po", "S10", "T100", "R10", f"+{400 * address}", "E")))
        for address, chip in zip((4, 2, 1), MODULES, strict=True):
            page.until(lambda chip=chip, address=address: page.position(chip) == 400 * address)
        page.picture("line")
        page.close()


def test_a_front_panel_is_worked_by_mouse(walk, bench):
    with running("panel", bench(FRONT_PANEL), "--run", "--no-browser") as command:
        page = walk(command.port("panel"))
        switch, bank = page.part("switch, jog switch"), page.part("wheels, thumbwheels")
        clockwise = page.button("switch: jog clockwise", switch)
        clockwise.hover()
        page.page.mouse.down()
        page.until(lambda: page.position() > 3)
        page.picture("front_panel_jog")
        clockwise.hover()
        page.page.mouse.up()
        switch.get_by_text("off", exact=True).wait_for()

        page.send("x", "A 0")
        for _ in range(4):
            page.button("wheels, digit 7 of 8: up", bank).click()
        page.button("wheels, digit 8 of 8: down", bank).click()
        page.until(lambda: wheels(page) == "00000064")
        page.send("x", "+", "N #", "G")
        page.until(lambda: page.position() == 64)
        page.send("x", "? P")
        page.until(lambda: "64" in shown(page))
        page.send("x", "H 16")
        page.part("home, switch").get_by_text("closed").wait_for()
        page.picture("front_panel_mouse")
        page.close()


def shown(page):
    """Return what the display shows."""
    return "".join(page.part("display, hp display").locator(".display-cell").all_text_contents())


def test_a_front_panel_is_worked_with_the_keyboard_alone(walk, bench):
    with running("panel", bench(FRONT_PANEL), "--run", "--no-browser") as command:
        page = walk(command.port("panel"), scheme="dark")
        keys = page.page.keyboard
        page.part("display, hp display").wait_for()

        page.tab_to("Command for x")
        keys.type("A 0\n")
        page.tab_to("wheels, digit 7 of 8: up", back=True)
        keys.press("Enter")
        page.tab_to("wheels, digit 7 of 8: down")
        keys.press(" ")
        keys.press(" ")
        page.until(lambda: wheels(page) == "00000015")
        page.tab_to("switch: jog clockwise")
        keys.down(" ")
        page.until(lambda: page.position() > 0)
        keys.up(" ")
        page.until(lambda: page.part("switch, jog switch").locator(".jog-state").text_content() == "off")

        page.tab_to("Command for x")
        keys.type("A 0\n+\nN #\nG\n? P\n")
        page.until(lambda: page.position() == 15)
        page.until(lambda: "15" in shown(page))
        keys.press("F8")
        page.button("Go").wait_for()
        page.tab_to("pin usrb1, input and output, high", back=True)
        keys.press("0")
        page.until(lambda: page.pin("usrb1").get_attribute("data-level") == "0")
        keys.press("Escape")
        page.until(lambda: page.pin("usrb1").get_attribute("data-level") == "1")
        keys.press("F8")
        page.button("Pause").wait_for()
        page.picture("front_panel_keyboard")
        page.close()


def wheels(page):
    """Return what the thumbwheels show."""
    return "".join(page.part("wheels, thumbwheels").locator(".wheel-digit").all_text_contents())


@pytest.mark.skipif(not Path("/proc/self/stat").exists(), reason="the system does not tell of the work of a process")
def test_from_the_command_to_a_moving_motor_little_is_to_be_done(walk, bench):
    moves = bench("A 0\nF 20\nR 40\nS 200\nZ 1\nN 60000\n+\nG\n", "moves.cy525")
    with running("panel", moves, "--run", "--no-browser") as command:
        page = walk(command.port("panel"))
        page.until(lambda: page.position() > 0)
        own = command.process.pid
        assert sum(map(worked_s, (own, *children(own)))) < LONGEST_S  # on several cores it is there in half of that
        page.close()


def children(process):
    """Return the processes that a process has started."""
    found = []
    for folder in Path("/proc").glob("[0-9]*"):
        with suppress(OSError):
            if int((folder / "stat").read_text().rpartition(")")[2].split()[1]) == process:
                found.append(int(folder.name))
    return found


def worked_s(process):
    """Return how long a process has worked, in seconds."""
    with suppress(OSError):
        fields = Path(f"/proc/{process}/stat").read_text().rpartition(")")[2].split()
        return sum(map(int, fields[11:13])) / os.sysconf("SC_CLK_TCK")
    return 0

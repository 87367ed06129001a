"""The data sheet of the NEW-NAME as data: pins, commands, serial line."""

from __future__ import annotations

from slewline.build import Arg, Lines, Pin, Row, SerialLine, Sheet, Table


def row(form: str, name: str, says: str, *args: Arg) -> Row:
    """Return a command: its letter, its name, which also names its method (SPEED: do_speed), and its effect."""
    return Row(form, name, args, 1000, says, "p. 2", stored=False)  # 1000 µs each; none can be stored


SHEET = Sheet(
    part="new-name",
    title="NEW-NAME stepper motor controller",
    manual="NEW-NAME data sheet",
    pins=(
        Pin(1, "rxd", "in", "serial data in", pull=0, role="serial_in"),
        Pin(2, "txd", "out", "serial data out", reset=0, role="serial_out"),
        Pin(3, "step", "out", "low for 2 µs at each step", active=0, reset=1, role="step"),
        Pin(4, "dir", "out", "high: clockwise", reset=1, role="direction"),
    ),
    commands=Table(
        row("V", "SPEED", "steps/s", Arg("speed", 2, 1, 20000)),
        row("M", "MOVE", "steps, clockwise if positive", Arg("steps", 3, -999999, 999999, sign="may", zero=False)),
        row("S", "STOP", "stops immediately"),
        row("P", "POSITION", "returns the position"),
    ),
    dialect=Lines(),
    channels=(SerialLine(bits=8, parity="none", stop=1, bauds={(): 9600}),),
)

"""The fixed part of every host script: the class `Grbl`, which communicates with the grbl board."""

from __future__ import annotations

# {letter}, {spm}, {digits} and {port} are filled in; Python's own braces are doubled.
FRAME = '''import sys
import time

import serial  # of the package pyserial

PORT = "{port}"
STEPS_PER_MM = {spm}
INPUTS = {{1: "P", 2: "X", 3: "Y", 4: "Z"}}  # how grbl reports them: probe, limits


class Grbl:
    """A board with grbl 1.1."""

    def __init__(self, port):
        self.line = serial.Serial(port, 115200, timeout=3600)
        self.position = 0  # in steps
        time.sleep(2)  # opening the port resets the board
        self.line.reset_input_buffer()

    def send(self, command):
        """Send a line, and wait until grbl has accepted it."""
        self.line.write(command.encode("ascii") + b"\\n")
        while True:
            answer = self.line.readline().decode("ascii", "replace").strip()
            if answer == "ok":
                return
            if not answer or answer.startswith(("error", "ALARM")):
                sys.exit(f"{{command}}: {{answer or 'no answer'}}")

    def settle(self):
        """Wait until all motion has ended."""
        self.send("G4 P0")

    def move_by(self, steps, axis="{letter}"):
        """Move by a number of steps."""
        self.send(f"G91 G1 {{axis}}{{steps / STEPS_PER_MM:.{digits}f}}")
        self.settle()
        self.position += steps

    def move_to(self, position, axis="{letter}"):
        """Move to a position, in steps."""
        self.send(f"G90 G1 {{axis}}{{position / STEPS_PER_MM:.{digits}f}}")
        self.settle()
        self.position = position

    def feed(self, rate):
        """Set the rate of moves, steps/s."""
        self.send(f"F{{rate * 60 / STEPS_PER_MM:.3f}}")

    def set_position(self, position, axis="{letter}"):
        """Set the present position, in steps."""
        self.send(f"G92 {{axis}}{{position / STEPS_PER_MM:.{digits}f}}")
        self.position = position

    def search(self, steps, code="G38.3", axis="{letter}"):
        """Move until the probe input changes, by at most `steps`."""
        self.send(f"G91 {{code}} {{axis}}{{steps / STEPS_PER_MM:.{digits}f}}")

    def level(self, number):
        """Return the level of an input: 0 while it is triggered."""
        self.line.write(b"?")
        report = ""
        while not report.startswith("<"):
            report = self.line.readline().decode("ascii", "replace").strip()
        pins = [field[3:] for field in report.strip("<>").split("|") if field.startswith("Pn:")]
        return 0 if pins and INPUTS[number] in pins[0] else 1

    def wait(self, number, level):
        """Wait until an input has a level."""
        while self.level(number) != level:
            time.sleep(0.005)'''

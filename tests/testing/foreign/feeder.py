"""The program under test of the suites in this folder: it knows a serial port, and nothing of slewline."""

from __future__ import annotations

FORMAT = {"bytesize": 7, "parity": "O", "stopbits": 2, "timeout": 2}


class Feeder:
    """A sheet feeder with a stepper motor on a controller that answers each line."""

    def __init__(self, port):
        self.port = port

    def ask(self, line):
        self.port.write(line.encode("ascii") + b"\r")
        answer = self.port.read_until(b"\r")
        if not answer.endswith(b"\r"):
            raise TimeoutError(f"{line}: no answer, {answer!r}")
        return answer[:-1].decode("ascii")

    def feed(self, steps):
        for line in ("Po", "S10", "T100", "R50", f"{steps:+d}", "E"):
            if (answer := self.ask(line)) != "Y":
                raise RuntimeError(f"{line}: {answer}")

    def wait(self):
        while self.ask("F") == "B":
            pass

    @property
    def position(self):
        return int(self.ask("V1")[1:])

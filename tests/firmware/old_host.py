"""A host program as it may have been for thirty years: homes a GS-C200S, moves it, stops it, reads where it is.

python old_host.py /dev/ttyS0
"""

import sys
import time

import serial


def main(name):
    line = serial.Serial(name, 9600, serial.SEVENBITS, serial.PARITY_ODD, serial.STOPBITS_TWO, timeout=5)

    def ask(text):
        line.write(text.encode("ascii") + b"\r")
        answer = line.read_until(b"\r").decode("ascii", "replace").strip()
        print(text, answer, flush=True)
        return answer

    def until_ready():
        while True:
            line.write(b"F\r")
            answer = line.read_until(b"\r").strip()
            if answer != b"B":
                break
            time.sleep(0.02)
        print("F", answer.decode(), flush=True)
        ask("V1")

    def run(*program):
        for text in ("Po", *program, "E"):
            ask(text)

    ask("V1")
    run("S40", "T200", "R40")
    ask("H")
    until_ready()
    run("+200")
    until_ready()
    run("G-50")
    until_ready()
    run("g+")
    time.sleep(0.5)
    ask("Z")  # by its ramp
    until_ready()
    run("g-")
    time.sleep(0.4)
    ask("K")  # at once
    until_ready()
    run("G0")
    until_ready()
    line.close()


main(sys.argv[1])

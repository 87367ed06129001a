"""Pins of a sketch: their names, their counterparts in the source, and their preparation in setup()."""

from __future__ import annotations

from ..meaning import Program
from ..program_facts import axes, outputs
from ..translation_report import OutLine
from .libraries import Library

ENABLE = 8  # as on the Arduino CNC shield
INPUTS = ("A0", "A1", "A2", "A3")
ABORT, HOME = "A4", "A5"


class SketchPins:
    """The pins that a sketch uses."""

    def __init__(self, program: Program, library: Library) -> None:
        self.program, self.library = program, library
        self.axes = [axis for axis in axes(program) if axis <= len(library.step_pins)]
        self.used: dict[str, str] = {}

    def pin(self, name: str, pin: str) -> str:
        """Record a pin, so that it is declared under a given name; return the name."""
        self.used[name] = pin
        return name

    def declarations(self) -> list[OutLine]:
        """Return the declarations of all pins, as constants."""
        found = []
        for axis in self.axes:
            end = self._suffix(axis)
            found.append(OutLine(f"const byte STEP_PIN{end} = {self._step_pin(axis)};", self._was("step")))
            found.append(
                OutLine(f"const byte DIR_PIN{end} = {self.library.dir_pins[axis - 1]};", self._was("direction"))
            )
        found.append(OutLine(f"const byte ENABLE_PIN = {ENABLE};", "of the driver, low: enabled"))
        names = {f"OUTPUT{n}_PIN": f"output{n}" for n in range(1, 5)} | {
            f"INPUT{n}_PIN": f"input{n}" for n in range(1, 5)
        }
        names |= {"ABORT_PIN": "abort", "HOME_PIN": "home"}
        for name, pin in sorted(self.used.items()):
            found.append(OutLine(f"const byte {name} = {pin};", self._was(names[name])))
        return found

    def _was(self, role: str) -> str:
        name = self.program.wiring.get(role)
        return f"was {name} of the {self.program.part.upper()}" if name else ""

    def _step_pin(self, axis: int) -> int:
        return self.library.step_pins[axis - 1]

    def _suffix(self, axis: int) -> str:
        return str(axis) if len(self.axes) > 1 else ""

    def stepper(self, axis: int) -> str:
        """Return the name of the stepper object of an axis."""
        return f"stepper{self._suffix(axis)}"

    def steppers(self) -> list[OutLine]:
        """Return the declarations of the steppers."""
        return [
            OutLine(line)
            for axis in self.axes
            for line in self.library.declared.format(stepper=self.stepper(axis), n=self._suffix(axis)).splitlines()
        ]

    def prepared(self) -> list[OutLine]:
        """Return the lines of setup() that prepare the pins and the steppers."""
        found: list[OutLine] = []
        for output, level in outputs(self.program):
            if output <= len(self.library.outputs):
                name = self.pin(f"OUTPUT{output}_PIN", self.library.outputs[output - 1])
                found.append(OutLine(f"  digitalWrite({name}, {level_name(level)});", "as after a reset"))
                found.append(OutLine(f"  pinMode({name}, OUTPUT);"))
        found += [OutLine(f"  pinMode({name}, INPUT_PULLUP);") for name in sorted(self.used) if "OUTPUT" not in name]
        for axis in self.axes:
            text = self.library.prepared.format(stepper=self.stepper(axis), n=self._suffix(axis))
            found += [OutLine(f"  {line}") for line in text.splitlines()]
        found.append(OutLine("  pinMode(ENABLE_PIN, OUTPUT);"))
        found.append(OutLine("  digitalWrite(ENABLE_PIN, LOW);"))
        return found

    def wires(self) -> list[tuple[str, str]]:
        """Return pairs of a wire's purpose and its pin."""
        names = [("step", f"pin {self._step_pin(1)}, STEP"), ("direction", f"pin {self.library.dir_pins[0]}, DIR")]
        names += [("enable", f"pin {ENABLE}, ENABLE"), ("abort", f"pin {ABORT}"), ("home", f"pin {HOME}")]
        names += [(f"output{n}", f"pin {pin}") for n, pin in enumerate(self.library.outputs, 1)]
        return names + [(f"input{n}", f"pin {pin}") for n, pin in enumerate(INPUTS, 1)]


def level_name(level: int) -> str:
    """Return the Arduino name of a level: HIGH or LOW."""
    return "HIGH" if level else "LOW"

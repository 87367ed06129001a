"""Stepper motor libraries that a sketch may use: includes, declarations and calls."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import NamedTuple

from ...errors import UsageError
from ..meaning import Profile, Program
from ..program_facts import top_rate
from ..target_writer import WriterOptions
from .source_sheet import number


class Library(NamedTuple):
    """A library, and the functions through which a sketch uses it.

    `helpers` are functions of the sketch, which are written only if called.  `fastest` is the maximum rate
    on an Uno according to the library's documentation, steps/s; `source` is the place in that documentation,
    and `faster` is advice for a program that needs a higher rate.
    """

    title: str
    includes: tuple[str, ...]
    declared: str
    prepared: str
    step_pins: tuple[int, ...]
    dir_pins: tuple[int, ...]
    outputs: tuple[str, ...]  # pins that are free
    parameter: str  # a stepper as a parameter of a function
    helpers: Mapping[str, str]
    calls: str  # between the name of a stepper and a method
    speed: Callable[[str, float], str]
    acceleration: Callable[[str, float], str]
    without_ramp: Callable[[Profile], float]
    fastest: int
    source: str
    faster: str
    rest: str

    def of(self, stepper: str) -> str:
        """Return the name of a stepper, followed by the operator ("." or "->") for a call to one of its methods."""
        return stepper + self.calls

    def helper(self, name: str) -> str:
        """Return the text of a helper function; if its name ends with OfAxis, the stepper is its first parameter."""
        plain = name.removesuffix("OfAxis")
        text = self.helpers[plain]
        return text if plain == name else text.replace(f"{plain}(", f"{name}({self.parameter}, ", 1)


WAIT_FOR = """void waitFor(byte pin, int level) {
  while (digitalRead(pin) != level) {
  }
}"""

ACCEL = Library(
    title="AccelStepper",
    includes=("#include <AccelStepper.h>",),
    declared="AccelStepper {stepper}(AccelStepper::DRIVER, STEP_PIN{n}, DIR_PIN{n});",
    prepared="",
    step_pins=(2, 3, 4),
    dir_pins=(5, 6, 7),
    outputs=("9", "10", "11", "12"),
    parameter="AccelStepper &stepper",
    helpers={
        "waitFor": WAIT_FOR,
        "moveBy": """void moveBy(long steps) {
  stepper.move(steps);
  stepper.runToPosition();
}""",
        "moveTo": """void moveTo(long position) {
  stepper.moveTo(position);
  stepper.runToPosition();
}""",
        "moveByEvenly": """void moveByEvenly(long steps, float rate) {
  stepper.move(steps);
  stepper.setSpeed(steps > 0 ? rate : -rate);
  while (stepper.distanceToGo() != 0) {
    stepper.runSpeedToPosition();
  }
  stepper.setCurrentPosition(stepper.currentPosition());
}""",
        "moveToEvenly": """void moveToEvenly(long position, float rate) {
  stepper.moveTo(position);
  stepper.setSpeed(stepper.distanceToGo() > 0 ? rate : -rate);
  while (stepper.distanceToGo() != 0) {
    stepper.runSpeedToPosition();
  }
  stepper.setCurrentPosition(stepper.currentPosition());
}""",
        "runUntil": """void runUntil(int direction, byte pin, int level) {
  stepper.move(direction * 2000000000L);
  while (digitalRead(pin) != level) {
    stepper.run();
  }
  stepper.stop();
  stepper.runToPosition();
}""",
    },
    calls=".",
    speed=lambda stepper, rate: f"{stepper}.setMaxSpeed({number(rate, 3)});",
    acceleration=lambda stepper, value: f"{stepper}.setAcceleration({number(value, 1)});",
    without_ramp=lambda profile: 0.0,
    fastest=4000,
    source="AccelStepper, description of the class",
    faster="use FastAccelStepper, or a faster board",
    rest="AccelStepper starts from standstill",
)

FAST = Library(
    title="FastAccelStepper",
    includes=("#include <FastAccelStepper.h>",),
    declared="FastAccelStepperEngine engine{n};\nFastAccelStepper *{stepper} = NULL;",
    prepared="engine{n}.init();\n{stepper} = engine{n}.stepperConnectToPin(STEP_PIN{n});\n"
    "{stepper}->setDirectionPin(DIR_PIN{n});",
    step_pins=(9, 10),  # the only pins that timer 1 can drive
    dir_pins=(5, 6),
    outputs=("2", "3", "4", "7"),
    parameter="FastAccelStepper *stepper",
    helpers={
        "waitFor": WAIT_FOR,
        "moveBy": """void moveBy(long steps) {
  stepper->move(steps, true);
}""",
        "moveTo": """void moveTo(long position) {
  stepper->moveTo(position, true);
}""",
        "runUntil": """void runUntil(int direction, byte pin, int level) {
  if (direction > 0) {
    stepper->runForward();
  } else {
    stepper->runBackward();
  }
  while (digitalRead(pin) != level) {
  }
  stepper->stopMove();
  while (stepper->isRunning()) {
  }
}""",
    },
    calls="->",
    speed=lambda stepper, rate: f"{stepper}->setSpeedInMilliHz({max(1, round(rate * 1000))});",
    acceleration=lambda stepper, value: f"{stepper}->setAcceleration({max(1, round(value))});",
    without_ramp=lambda profile: min(profile.top**2, 1e9),  # within half a step
    fastest=50_000,
    source="FastAccelStepper, README",
    faster="a faster board",
    rest="FastAccelStepper starts from standstill",
)


def chosen(program: Program, options: WriterOptions) -> Library:
    """Return the library that the user has selected, or else a library that is fast enough for the program."""
    named = options.values.get("library", "")
    if named not in ("", ACCEL.title.lower(), FAST.title.lower()):
        allowed = f"{ACCEL.title.lower()} or {FAST.title.lower()}"
        raise UsageError(f"library {named}: not a library for sketches; allowed {allowed}")
    fast = named == FAST.title.lower() or (not named and top_rate(program.actions) > ACCEL.fastest)
    return FAST if fast else ACCEL

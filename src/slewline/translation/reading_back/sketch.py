"""Runs an Arduino sketch on paper: its C++, and its calls to Arduino and to the two stepper libraries.

The language is limited to the C++ that the writers of sketches use.  A loop that repeats until an input
has a given level counts as a wait.  Times are not computed.
"""

from __future__ import annotations

import operator
import re
from collections.abc import Callable
from typing import Any, NamedTuple

from ..target_writer import PlayedTrace, WriterOptions
from .sketch_steppers import SketchPin, SketchStepper
from .sketch_tokens import SketchTokens
from .surroundings import Enough, Surroundings

TYPES = {"long", "int", "byte", "float", "const", "bool", "unsigned"}
LIBRARIES = {"<AccelStepper.h>": "AccelStepper", "<FastAccelStepper.h>": "FastAccelStepper"}
ARDUINO = {"pinMode", "digitalWrite", "digitalRead", "delay", "delayMicroseconds"}
BINARY: dict[str, tuple[int, Callable[[Any, Any], Any]]] = {
    "||": (1, lambda a, b: int(bool(a) or bool(b))),
    "&&": (2, lambda a, b: int(bool(a) and bool(b))),
    "==": (3, operator.eq),
    "!=": (3, operator.ne),
    "<": (4, operator.lt),
    "<=": (4, operator.le),
    ">": (4, operator.gt),
    ">=": (4, operator.ge),
    "+": (5, operator.add),
    "-": (5, operator.sub),
    "*": (6, operator.mul),
}
OUTPUT = re.compile(r"OUTPUT(\d+)_PIN$")
INPUTS = 100  # numbers from this one up are pins of other inputs
INPUT = re.compile(r"INPUT(\d+)_PIN$")


class _Returned(Exception):
    """The return from a function."""


class _Function(NamedTuple):
    parameters: list[str]
    start: int  # position of its body


def read(text: str, options: WriterOptions) -> PlayedTrace:
    """Return the events of a sketch during its setup().

    Raises:
        RefusedLine: the compiler, or a library, would not accept a line.
    """
    machine = _SketchMachine(text, options)
    stopped = False
    try:
        machine.declarations()
        machine.called("setup", [])
    except Enough:
        stopped = True
    return machine.around.trace("read back", stopped)


class _SketchMachine(SketchTokens):
    def __init__(self, text: str, options: WriterOptions) -> None:
        self.around = Surroundings(options)
        super().__init__(text)
        self.functions: dict[str, _Function] = {}
        self.names: dict[str, Any] = {"HIGH": 1, "LOW": 0, "true": 1, "false": 0, "NULL": None, "OUTPUT": 1}
        self.names |= {"INPUT_PULLUP": 2} | {f"A{n}": 14 + n for n in range(6)}
        self.frames: list[dict[str, Any]] = []
        self.library = ""
        self.modes: dict[int, int] = {}

    # --------------------------------------------------------------------------------------------------- declarations
    def declarations(self) -> None:
        """Read the declarations outside all functions."""
        while self.here:
            if self.here.startswith("#"):
                name = self.take().partition(" ")[2].strip()
                if name not in LIBRARIES:
                    raise self.refused("unknown library")
                self.library = LIBRARIES[name]
                continue
            if self.here == "void":
                self._function()
                continue
            if self.here == f"{self.library}Engine":
                self.take()
                self.names[self.take()] = "engine"
                self.take(";")
                continue
            if self.here == self.library:
                self._stepper()
                continue
            self._variable(self.names)

    def _stepper(self) -> None:
        self.take()
        if self.here == "*":
            self.take()
        name = self.take()
        axis = 1 + sum(isinstance(each, SketchStepper) for each in self.names.values())
        self.names[name] = SketchStepper(axis, self.around)
        while self.take() != ";":
            pass

    def _function(self) -> None:
        self.take("void")
        name = self.take()
        self.take("(")
        parameters: list[str] = []
        while self.here != ")":
            if self.here == ",":
                self.take()
            while self.here in TYPES or self.here in (self.library, "&", "*"):
                self.take()
            parameters.append(self.take())
        self.take(")")
        self.functions[name] = _Function(parameters, self.at)
        self.skip()

    def _variable(self, names: dict[str, Any]) -> None:
        if self.here not in TYPES:
            raise self.refused("not a declaration")
        while self.here in TYPES:
            self.take()
        name = self.take()
        self.take("=")
        value = self.expression()
        names[name] = SketchPin(value, name) if name.endswith("_PIN") else value
        self.take(";")

    # ----------------------------------------------------------------------------------------------------- statements
    def called(self, name: str, values: list[Any]) -> None:
        """Call the function `name` of the sketch, with the arguments `values`."""
        if name not in self.functions:
            raise self.refused(f"{name} is not declared")
        function = self.functions[name]
        if len(values) != len(function.parameters):
            raise self.refused(f"{name} takes {len(function.parameters)} values")
        back, self.at = self.at, function.start
        self.frames.append(dict(zip(function.parameters, values, strict=True)))
        try:
            self.statement()
        except _Returned:
            pass
        finally:
            self.frames.pop()
            self.at = back

    def statement(self) -> None:
        """Run the next statement."""
        self.around.statement()
        match self.here:
            case "{":
                self._block()
            case "if":
                self._if()
            case "while":
                self._while()
            case "do":
                self._do()
            case "for":
                self._for()
            case "return":
                raise _Returned
            case here if here in TYPES:
                self._variable(self.frames[-1])
            case _:
                self._simple()
                self.take(";")

    def _block(self) -> None:
        self.take("{")
        while self.here != "}":
            self.statement()
        self.take()

    def _simple(self) -> None:
        name, after = self.here, self.tokens[self.at + 1].text
        if after in ("=", "++"):
            self.at += 2
            names = self.frames[-1] if name in self.frames[-1] else self.names
            if name not in names:
                raise self.refused(f"{name} is not declared")
            names[name] = self.expression() if after == "=" else names[name] + 1
            return
        self.expression()

    def _if(self) -> None:
        self.take("if")
        self.take("(")
        chosen = self.expression()
        self.take(")")
        if chosen:
            self.statement()
        else:
            self.skip()
        if self.here == "else":
            self.take()
            if chosen:
                self.skip()
            else:
                self.statement()

    def _while(self) -> None:
        self.take("while")
        start = self.at
        if self._waits():
            self.skip_brackets()
            self.skip()
            return
        while True:
            self.around.statement()
            self.at = start
            self.take("(")
            more = self.expression()
            self.take(")")
            if not more:
                self.skip()
                return
            self.statement()

    def _waits(self) -> bool:
        """Return whether a loop begins with while (digitalRead(pin) != level); if so, first wait for this level."""
        words = [token.text for token in self.tokens[self.at : self.at + 8]]
        if words[:3] != ["(", "digitalRead", "("] or words[4:6] != [")", "!="]:
            return False
        pin, level = self.value_of(words[3]), self.value_of(words[6])
        for each in self.names.values():
            if isinstance(each, SketchStepper) and each.target != each.position:
                self.around.run(each.axis, 1 if each.target > each.position else -1)
        if (number := self._input_number(pin)) < INPUTS:
            self.around.wait(number, level)
        return True

    def _do(self) -> None:
        self.take("do")
        start = self.at
        while True:
            self.at = start
            self.statement()
            self.take("while")
            self.take("(")
            more = self.expression()
            self.take(")")
            self.take(";")
            if not more:
                return

    def _for(self) -> None:
        self.take("for")
        self.take("(")
        self._variable(self.frames[-1])
        condition = self.at
        while self.take() != ";":
            pass
        step = self.at
        while self.take() != ")":
            pass
        body = self.at
        while True:
            self.at = condition
            if not self.expression():
                self.at = body
                self.skip()
                return
            self.at = body
            self.statement()
            self.at = step
            self._simple()

    # ---------------------------------------------------------------------------------------------------- expressions
    def expression(self) -> Any:
        """Evaluate the next expression, and return its value."""
        value = self._binary(0)
        if self.here != "?":
            return value
        self.take()
        first = self._binary(0)
        self.take(":")
        second = self._binary(0)
        return first if value else second

    def _binary(self, least: int) -> Any:
        left = self._primary()
        while self.here in BINARY and BINARY[self.here][0] > least:
            binds, action = BINARY[self.take()]
            left = action(left, self._binary(binds))
        return left

    def _primary(self) -> Any:
        token = self.take()
        if token == "-":
            return -self._primary()
        if token == "!":
            return int(not self._primary())
        if token == "(":
            value = self.expression()
            self.take(")")
            return value
        if token[0].isdigit():
            return float(token) if "." in token else int(token.rstrip("L"))
        if self.here == "(":
            return self._call(token)
        if self.here in (".", "->"):
            return self._method(token)
        return self.value_of(token)

    def value_of(self, name: str) -> Any:
        """Return the value of the variable or constant with the given name."""
        for names in (self.frames[-1] if self.frames else {}, self.names):
            if name in names:
                return names[name]
        raise self.refused(f"{name} is not declared")

    def _values(self) -> list[Any]:
        self.take("(")
        values: list[Any] = []
        while self.here != ")":
            if values:
                self.take(",")
            values.append(self.expression())
        self.take(")")
        return values

    def _call(self, name: str) -> Any:
        values = self._values()
        if name not in ARDUINO:
            return self.called(name, values)
        if name == "digitalRead":
            return self.around.level(self._input_number(values[0]))
        if name == "pinMode":
            self.modes[int(values[0])] = values[1]
        elif name == "digitalWrite":
            if found := OUTPUT.match(values[0].name):
                self.around.output(int(found[1]), values[1])
        else:
            self.around.delay(values[0] * (10**9 if name == "delay" else 10**6))
        return None

    def _input_number(self, pin: SketchPin) -> int:
        if self.modes.get(int(pin)) != 2:
            raise self.refused(f"{pin.name} is not an input")
        found = INPUT.match(pin.name)
        return int(found[1]) if found else INPUTS + int(pin)

    def _method(self, name: str) -> Any:
        thing = self.value_of(name)
        wanted = "->" if self.library == "FastAccelStepper" and isinstance(thing, SketchStepper) else "."
        self.take(wanted)
        method = self.take()
        values = self._values()
        if thing == "engine":
            steppers = [each for each in self.names.values() if isinstance(each, SketchStepper)]
            return steppers[0] if method == "stepperConnectToPin" else None
        try:
            return thing.call(method, values)
        except (KeyError, TypeError, ValueError) as error:
            raise self.refused(f"{method}: {error}") from None

"""Klipper, run on paper: configuration sections, macro templates, and the commands from the templates.

"On paper" means that this module follows the statements without Klipper.  A template is evaluated as a
whole before its first command runs, with the state at that time.  The template of a delayed_gcode is
evaluated in the same way when it is due.
"""

from __future__ import annotations

import ast
import operator
import re
from typing import Any

from ..target_writer import PlayedTrace, WriterOptions
from .surroundings import Enough, RefusedLine, Surroundings

SECTION = re.compile(r"\[(\w+)(?: (\w+))?\]$")
TAG = re.compile(r"\{%\s*(.*?)\s*%\}")
ELSE = re.compile(r"\{%\s*else\s*%\}")
VALUE = re.compile(r"\{(?!%)(.*?)\}")
OPERATORS: dict[type, Any] = {ast.Add: operator.add, ast.Sub: operator.sub, ast.Mult: operator.mul}
OPERATORS |= {ast.Div: operator.truediv, ast.Eq: operator.eq, ast.Lt: operator.lt}
KNOWN = {"manual_stepper", "output_pin", "gcode_button", "gcode_macro", "delayed_gcode"}
SEARCHES = {"try_probe", "try_inverted_probe"}


def read(text: str, options: WriterOptions) -> PlayedTrace:
    """Return the events of the macro PROGRAM.

    Raises:
        RefusedLine: Klipper would not accept the configuration, or a command.
    """
    klipper = _Klipper(text, options)
    stopped = False
    try:
        klipper.run()
    except Enough:
        stopped = True
    return klipper.around.trace("read back", stopped)


class _Klipper:
    def __init__(self, text: str, options: WriterOptions) -> None:
        self.around = Surroundings(options)
        self.sections: dict[tuple[str, str], dict[str, Any]] = {}
        self._read(text)
        self.variables = {
            key.removeprefix("variable_"): ast.literal_eval(value)
            for key, value in self.sections.get(("gcode_macro", "PROGRAM"), {}).items()
            if key.startswith("variable_")
        }
        for (kind, name), values in self.sections.items():
            if kind == "output_pin":
                self.around.output(int(name.removeprefix("output")), int(values["value"]))
        self.at = 0.0  # mm
        self.due: list[str] = []  # the delayed_gcode that was scheduled
        self.running: list[str] = []

    def _read(self, text: str) -> None:
        """Read the sections of a configuration: their options, and the lines of their templates."""
        values: dict[str, Any] | None = None
        key = ""
        for number, line in enumerate(text.splitlines(), 1):
            code = line.partition("#")[0].rstrip()
            if not code:
                continue
            if found := SECTION.match(code):
                kind, name = found[1], found[2] or ""
                if kind not in KNOWN or (kind, name) in self.sections:
                    raise RefusedLine(number, line, "unknown or repeated section")
                values = self.sections[kind, name] = {}
            elif code[0].isspace():
                if values is None or key != "gcode":
                    raise RefusedLine(number, line, "a line outside a template")
                values[key].append((number, code.strip()))
            else:
                key, mark, value = (part.strip() for part in code.partition(":"))
                if values is None or not mark:
                    raise RefusedLine(number, line, "not an option")
                values[key] = [] if key == "gcode" else value

    # ------------------------------------------------------------------------------------------------------- templates
    def worked_out(self, lines: list[tuple[int, str]]) -> list[tuple[int, str]]:
        """Return the commands that a template produces in the current state, each with its line number."""
        out: list[tuple[int, str]] = []
        self._template(lines, {}, out)
        return out

    def _template(self, lines: list[tuple[int, str]], names: dict[str, Any], out: list[tuple[int, str]]) -> None:
        place = 0
        while place < len(lines):
            self.around.statement()
            number, line = lines[place]
            tag = TAG.match(line)
            if not tag:
                out.append((number, self._filled(line, names, number)))
                place += 1
                continue
            word = tag[1]
            if word.startswith("set "):
                self._set(word[4:], names, number)
                place += 1
            elif found := re.match(r"for _ in range\((\d+)\)$", word):
                end = self._end(lines, place, "for")
                for _ in range(int(found[1])):
                    self._template(lines[place + 1 : end], names, out)
                place = end + 1
            elif word.startswith("if "):
                end = self._end(lines, place, "if")
                inside = lines[place + 1 : end]
                others = (at for at, (_, each) in enumerate(inside) if ELSE.match(each))
                middle = next(others, len(inside))
                chosen = inside[:middle] if self._value(word[3:], names, number) else inside[middle + 1 :]
                self._template(chosen, names, out)
                place = end + 1
            else:
                raise RefusedLine(number, line, "not a tag that translations use")

    def _filled(self, line: str, names: dict[str, Any], number: int) -> str:
        """Return a line with each expression in braces replaced by its value."""
        return VALUE.sub(lambda found: str(self._value(found[1], names, number)), line)

    def _end(self, lines: list[tuple[int, str]], place: int, word: str) -> int:
        depth = 0
        for at in range(place, len(lines)):
            tag = TAG.match(lines[at][1])
            if tag and tag[1].startswith(f"{word} "):
                depth += 1
            elif tag and tag[1] == f"end{word}":
                depth -= 1
                if not depth:
                    return at
        raise RefusedLine(*lines[place], f"end{word} is missing")

    def _set(self, text: str, names: dict[str, Any], number: int) -> None:
        target, _, value = (part.strip() for part in text.partition("="))
        if found := re.match(r"namespace\((.*)\)$", value):
            pairs = (pair.partition("=") for pair in found[1].split(", "))
            names[target] = {name: self._value(of, names, number) for name, _, of in pairs}
            return
        space, _, name = target.partition(".")
        if space not in names:
            raise RefusedLine(number, text, f"{space} is not known")
        names[space][name] = self._value(value, names, number)

    def _value(self, text: str, names: dict[str, Any], number: int) -> Any:
        try:
            return self._of(ast.parse(text.strip(), mode="eval").body, names)
        except (SyntaxError, KeyError, TypeError, AssertionError) as error:
            raise RefusedLine(number, text, f"{type(error).__name__}: {error}") from None

    def _of(self, it: ast.expr, names: dict[str, Any]) -> Any:
        match it:
            case ast.Constant(value=value):
                return value
            case ast.UnaryOp(op=ast.USub(), operand=of):
                return -self._of(of, names)
            case ast.BinOp():
                return OPERATORS[type(it.op)](self._of(it.left, names), self._of(it.right, names))
            case ast.BoolOp(op=ast.And()):
                return all(self._of(each, names) for each in it.values)
            case ast.IfExp():
                return self._of(it.body if self._of(it.test, names) else it.orelse, names)
            case ast.Compare(ops=[op], comparators=[right]):
                return OPERATORS[type(op)](self._of(it.left, names), self._of(right, names))
            case ast.Attribute(value=ast.Name(id=space), attr=name):
                return names[space][name]
            case ast.Attribute(
                value=ast.Subscript(value=ast.Name(id="printer"), slice=ast.Constant(value=of)), attr=name
            ):
                return self._status(str(of), name)
            case _:
                raise TypeError(ast.unparse(it))

    def _status(self, of: str, name: str) -> Any:
        """Return the value `name` of Klipper's object `of`, in the form in which a template reads it."""
        kind, _, which = of.partition(" ")
        if (kind, which) not in self.sections:
            raise KeyError(of)
        if kind == "gcode_macro":
            return self.variables[name]
        pressed = self.around.level(int(which.removeprefix("input")))
        return "PRESSED" if pressed else "RELEASED"

    # -------------------------------------------------------------------------------------------------------- commands
    def run(self) -> None:
        """Run the macro PROGRAM, then each delayed_gcode that has been scheduled."""
        self._macro("PROGRAM", 0)
        while self.due:
            self.around.statement()
            name = self.due.pop(0)
            lines = self.sections["delayed_gcode", name]["gcode"]
            if not self.around.waits:
                self._meet(lines, name)
            for number, command in self.worked_out(lines):
                self._command(number, command)

    def _meet(self, lines: list[tuple[int, str]], name: str) -> None:
        """Set an input to a level if the delayed_gcode `name` repeats itself until the input has that level."""
        again = any(f"ID={name} DURATION=0.02" in line for _, line in lines)
        found = re.search(r'gcode_button input(\d+)"\]\.state == "(\w+)"', lines[0][1])
        if again and found:
            level = int(found[2] == "PRESSED")
            self.around.wait(int(found[1]), level)
            self.around.levels[int(found[1])] = level

    def _macro(self, name: str, number: int) -> None:
        if name in self.running:
            raise RefusedLine(number, name, "a macro calls itself")
        self.running.append(name)
        for line, command in self.worked_out(self.sections["gcode_macro", name]["gcode"]):
            self._command(line, command)
        self.running.remove(name)

    def _command(self, number: int, text: str) -> None:
        word, *rest = text.split()
        values = dict(pair.split("=", 1) for pair in rest if "=" in pair)
        match word:
            case "MANUAL_STEPPER":
                self._stepper(number, text, values)
            case "SET_PIN":
                if ("output_pin", values["PIN"]) not in self.sections:
                    raise RefusedLine(number, text, "no such pin")
                self.around.output(int(values["PIN"].removeprefix("output")), int(values["VALUE"]))
            case "G4":
                self.around.delay(round(float(rest[0].removeprefix("P")) * 1e6) * 1000)
            case "M400":
                pass
            case "SET_GCODE_VARIABLE":
                if values["VARIABLE"] not in self.variables or values["MACRO"] != "PROGRAM":
                    raise RefusedLine(number, text, "no such variable")
                self.variables[values["VARIABLE"]] = ast.literal_eval(values["VALUE"])
            case "UPDATE_DELAYED_GCODE":
                if ("delayed_gcode", values["ID"]) not in self.sections:
                    raise RefusedLine(number, text, "no such delayed_gcode")
                self.due.append(values["ID"])
            case _ if ("gcode_macro", word) in self.sections:
                self._macro(word, number)
            case _:
                raise RefusedLine(number, text, "unknown command")

    def _stepper(self, number: int, text: str, values: dict[str, str]) -> None:
        if ("manual_stepper", values.get("STEPPER", "")) not in self.sections:
            raise RefusedLine(number, text, "no such stepper")
        if float(values.get("SPEED", "1")) <= 0 or float(values.get("ACCEL", "0")) < 0:
            raise RefusedLine(number, text, "SPEED above 0, ACCEL 0 or more")
        if "SET_POSITION" in values:
            self.at = float(values["SET_POSITION"])
        if "MOVE" not in values:
            return
        spm = self.around.steps_per_mm
        before, to = self.at, float(values["MOVE"])
        steps = round(to * spm) - round(before * spm)
        if "STOP_ON_ENDSTOP" in values:
            if (
                values["STOP_ON_ENDSTOP"] not in SEARCHES
                or "endstop_pin" not in self.sections["manual_stepper", "axis"]
            ):
                raise RefusedLine(number, text, "no such search, or no endstop")
            self.around.run(1, 1 if steps > 0 else -1)
            return
        self.at = to
        self.around.move(1, steps)

"""A host script, run on paper: Python's parser reads it; its statements are followed, not executed."""

from __future__ import annotations

import ast
import operator
from contextlib import suppress
from typing import Any

from ..target_writer import PlayedTrace, WriterOptions
from .grbl_reader import AXES, Machine
from .surroundings import Enough, RefusedLine

BINARY: dict[type, Any] = {ast.Mult: operator.mul, ast.Add: operator.add, ast.Sub: operator.sub}
COMPARED: dict[type, Any] = {ast.Eq: operator.eq, ast.NotEq: operator.ne, ast.GtE: operator.ge, ast.Lt: operator.lt}
METHODS = {"send", "move_by", "move_to", "feed", "set_position", "search", "level", "wait", "settle"}


class _FunctionLeft(Exception):
    """The return from a function."""


class _Broken(Exception):
    """The exit from a loop."""


def read(text: str, options: WriterOptions) -> PlayedTrace:
    """Return the events of a script.

    Raises:
        RefusedLine: Python, or grbl, would not accept a line.
    """
    try:
        tree = ast.parse(text)
    except SyntaxError as error:
        raise RefusedLine(error.lineno or 0, error.text or "", error.msg) from None
    script = _Script(tree, options)
    stopped = False
    try:
        script.called("main")
    except Enough:
        stopped = True
    return script.grbl.around.trace("read back", stopped)


class _Script:
    def __init__(self, tree: ast.Module, options: WriterOptions) -> None:
        self.grbl = Machine(options)
        self.functions = {each.name: each for each in tree.body if isinstance(each, ast.FunctionDef)}
        self.names: dict[str, Any] = {}
        for each in tree.body:
            if isinstance(each, ast.Assign):
                self._assign(each)
        board = next(each for each in tree.body if isinstance(each, ast.ClassDef))
        offered = {each.name for each in board.body if isinstance(each, ast.FunctionDef)}
        if not offered >= METHODS:
            raise RefusedLine(board.lineno, board.name, f"without {', '.join(METHODS - offered)}")

    def called(self, name: str) -> None:
        """Follow the statements of the function with the given name."""
        if name not in self.functions:
            raise RefusedLine(0, name, "no such function")
        with suppress(_FunctionLeft):
            self._all(self.functions[name].body)

    def _all(self, body: list[ast.stmt]) -> None:
        for each in body:
            self._one(each)

    def _one(self, it: ast.stmt) -> None:
        self.grbl.around.statement()
        match it:
            case ast.Expr(value=ast.Call()):
                self._value(it.value)
            case ast.Assign():
                self._assign(it)
            case ast.AugAssign(target=ast.Name(id=name), op=ast.Add()):
                self.names[name] += self._value(it.value)
            case ast.For(iter=ast.Call(func=ast.Name(id="range"), args=[count])):
                for _ in range(self._value(count)):
                    self._all(it.body)
            case ast.While():
                with suppress(_Broken):
                    while self._value(it.test):
                        self._all(it.body)
                        self.grbl.around.statement()
            case ast.If():
                self._all(it.body if self._value(it.test) else it.orelse)
            case ast.Break():
                raise _Broken
            case ast.Return(value=None):
                raise _FunctionLeft
            case ast.Global() | ast.Pass():
                pass
            case _:
                raise RefusedLine(it.lineno, ast.unparse(it), "not a statement that translations use")

    def _assign(self, it: ast.Assign) -> None:
        if not isinstance(it.targets[0], ast.Name) or not isinstance(it.value, ast.Constant | ast.UnaryOp | ast.IfExp):
            if isinstance(it.value, ast.Dict):
                return
            raise RefusedLine(it.lineno, ast.unparse(it), "not an assignment that translations use")
        self.names[it.targets[0].id] = self._value(it.value)

    def _value(self, it: ast.expr) -> Any:
        match it:
            case ast.Constant(value=value):
                return value
            case ast.Name(id=name):
                if name not in self.names:
                    raise RefusedLine(it.lineno, name, "no such name")
                return self.names[name]
            case ast.UnaryOp(op=ast.USub()):
                return -self._value(it.operand)
            case ast.UnaryOp(op=ast.Not()):
                return not self._value(it.operand)
            case ast.BinOp() if type(it.op) in BINARY:
                return BINARY[type(it.op)](self._value(it.left), self._value(it.right))
            case ast.IfExp():
                return self._value(it.body if self._value(it.test) else it.orelse)
            case ast.Attribute(value=ast.Name(id="grbl"), attr="position"):
                spm = self.grbl.around.steps_per_mm
                return round((self.grbl.at[AXES[0]] - self.grbl.offset[AXES[0]]) * spm)
            case ast.BoolOp(op=ast.And()):
                return all(self._value(each) for each in it.values)
            case ast.Compare(ops=[op], comparators=[right]) if type(op) in COMPARED:
                return COMPARED[type(op)](self._value(it.left), self._value(right))
            case ast.Call(func=ast.Attribute(value=ast.Name(id="grbl"), attr=name)):
                return self._method(name, [self._value(each) for each in it.args], self._named(it))
            case ast.Call(func=ast.Attribute(value=ast.Name(id="time"), attr="sleep"), args=[time]):
                self.grbl.around.delay(round(self._value(time) * 1e6) * 10**6)
                return None
            case ast.Call(func=ast.Name(id=name), args=[ast.Name(id="grbl")]):
                return self.called(name)
            case _:
                raise RefusedLine(it.lineno, ast.unparse(it), "not an expression that translations use")

    def _named(self, it: ast.Call) -> dict[str, Any]:
        return {str(each.arg): self._value(each.value) for each in it.keywords}

    def _method(self, name: str, values: list[Any], named: dict[str, Any]) -> Any:
        """Follow a call to a method of the script's board: process the commands that the method sends to grbl.

        Args:
            values, named: the positional and the keyword arguments of the call.

        Returns:
            The level of the input for the method "level"; None for other methods.
        """
        spm = self.grbl.around.steps_per_mm
        letter = named.get("axis", AXES[0])
        match name:
            case "send":
                self.grbl.line(0, values[0])
            case "feed":
                self.grbl.line(0, f"F{values[0] * 60 / spm:.6f}")
            case "move_by":
                self.grbl.line(0, f"G91 G1 {letter}{values[0] / spm:.6f}")
            case "move_to":
                self.grbl.line(0, f"G90 G1 {letter}{values[0] / spm:.6f}")
            case "set_position":
                self.grbl.line(0, f"G92 {letter}{values[0] / spm:.6f}")
            case "search":
                self.grbl.line(0, f"G91 {named.get('code', 'G38.3')} {letter}{values[0] / spm:.6f}")
            case "level":
                return self.grbl.around.level(values[0])
            case "wait":
                self.grbl.around.wait(values[0], values[1])
            case _:
                raise RefusedLine(0, name, "no such method")
        return None

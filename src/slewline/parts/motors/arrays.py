"""The equations for many motors, as calls of NumPy that write into a few arrays, used again and again.

`v1 * INV_L - R_L * i1` makes three new arrays; for a thousand motors that costs more than the arithmetic.  `in_place`
turns the text into

    c0 = asarray(INV_L)                         once, before the loop
    multiply(v1, c0, p0)                        into p0
    multiply(c1, i1, p1)
    subtract(p0, p1, p1)                        the value in p1 was used for the last time

so that what is read has just been written, and is in the nearest cache.  Operations and their order stay as they are,
and so do the bits.  `where` writes only if its condition holds for one motor, and asks what is joined by `&` or `and`
only as long as it may: it rarely does, where latches trip, shafts stop and motors come to rest.

What has one number a motor is called a lane here: what is unpacked from `state`, and what is made of lanes.  All else
stays plain Python.  Assignments without a branch in between are a run: within it arrays are handed out and taken back
as the text is made, the last one back first; at its end each name that is read elsewhere has an array of its own.
"""

from __future__ import annotations

import ast
from dataclasses import dataclass
from itertools import groupby
from typing import Any

CALLS: dict[Any, str] = {
    ast.Add: "add", ast.Sub: "subtract", ast.Mult: "multiply", ast.Div: "divide", ast.USub: "negative",
    ast.BitAnd: "bitwise_and", ast.BitOr: "bitwise_or", ast.Lt: "less", ast.LtE: "less_equal", ast.Gt: "greater",
    ast.GtE: "greater_equal", ast.Eq: "equal",
}  # fmt: skip
LOGICAL = ast.Compare | ast.BoolOp | ast.BitAnd | ast.BitOr


@dataclass(eq=False, slots=True)
class Value:
    """What a call makes: is it True or False, how often will it be used yet, and in which array is it?"""

    logical: bool
    uses: int = 0
    array: str = ""


@dataclass(eq=False, slots=True)
class ArrayLine:
    """A line to be made: {} stands for each of `of`, {out} for what is made.

    Attributes:
        deeper: by how much the lines that follow are further to the right.
        keeps: for the base of a `where`, how often it is used until it is written to.
    """

    text: str
    of: tuple[Value | str, ...] = ()
    made: Value | None = None
    deeper: int = 0
    keeps: int | None = None


def in_place(text: str) -> str:
    """Return a function made of another, which unpacks `parameters` and `state` first, and then branches and assigns.

    `array(size, of)` makes a new array; `asarray`, `copyto`, `count_nonzero` and the names of ufuncs are NumPy's.
    """
    return _Lanes(ast.parse(text).body[0]).text


class _Lanes:
    """The text of a function, on its way."""

    def __init__(self, function: Any) -> None:
        parameters, state, *body = function.body
        self.constants, first = _names(parameters.targets[0]), _names(state.targets[0])
        self.lanes = dict.fromkeys(first, False)  # and: is it True or False?
        made: list[Any] = [n for n in ast.walk(function) if isinstance(n, ast.Assign) and _is_of_a_run(n)]
        while new := [n for n in made if self._is_lane(n.value) and n.targets[0].id not in self.lanes]:
            self.lanes |= {n.targets[0].id: self._is_logical(n.value) for n in new}
        self.needed: set[str] = set()  # lanes that are read in another run than they are made in
        self._need(body)
        self.hoisted: dict[str, str] = {}
        self.pools: dict[bool, list[str]] = {False: [], True: []}
        self.lines: list[str] = []
        self._body(body, 1)
        own = [(name, self.lanes[name]) for name in sorted(self.needed | {*first})]
        own += [(name, logical) for logical, names in self.pools.items() for name in names]
        self.text = "\n".join(
            [
                ast.unparse(function).split("\n")[0],
                f"    {ast.unparse(parameters)}",
                f"    motors = len({ast.unparse(state.value)}[0])",
                *(f"    {name} = asarray({text})" for text, name in self.hoisted.items()),
                *(f"    {name} = array(motors{', bool' if logical else ''})" for name, logical in own),
                *(f"    {name}[:] = state[{n}]" for n, name in enumerate(first)),
                *self.lines,
            ]
        )

    def _is_lane(self, node: ast.AST) -> bool:
        return any(name in self.lanes for name in _names(node))

    def _is_logical(self, node: Any) -> bool:
        if isinstance(node, ast.Name):
            return self.lanes.get(node.id, False)
        if isinstance(node, ast.Call):
            return any(self._is_logical(part) for part in node.args[1:])
        value = node.value if isinstance(node, ast.Constant) else None
        return isinstance(value, bool) or isinstance(getattr(node, "op", node), LOGICAL)

    # -------------------------------------------------------------------------------------------------------- branches
    def _need(self, body: list[Any]) -> None:
        for is_run, nodes in groupby(body, _is_of_a_run):
            made: set[str] = set()
            for node in nodes:
                read = _names(node.value) if is_run else _names(getattr(node, "test", getattr(node, "value", node)))
                self.needed |= {name for name in read if name in self.lanes} - made
                if is_run:
                    made |= set(_names(getattr(node, "target", None) or node.targets[0]))
                for inner in ("body", "orelse"):
                    self._need(getattr(node, inner, []))

    def _body(self, body: list[Any], depth: int) -> None:
        for is_run, nodes in groupby(body, _is_of_a_run):
            if is_run:
                self._run(list(nodes), depth)
                continue
            for node in nodes:
                if not isinstance(node, ast.If | ast.While):
                    self.lines.append("    " * depth + ast.unparse(node))
                    continue
                word = "if" if isinstance(node, ast.If) else "while"
                self.lines.append("    " * depth + f"{word} {ast.unparse(node.test)}:")
                self._body(node.body, depth + 1)
                if node.orelse:
                    self.lines.append("    " * depth + "else:")
                    self._body(node.orelse, depth + 1)

    # ------------------------------------------------------------------------------------------------------------ runs
    def _run(self, nodes: list[Any], depth: int) -> None:
        self.run: list[ArrayLine] = []
        self.held: dict[str, Value] = {}
        self.ready: set[str] = set()  # plain names that are arrays of NumPy already
        made = set()
        for node in nodes:
            name = getattr(node, "target", None) or node.targets[0]
            if isinstance(node, ast.Assign) and name.id in self.lanes:
                value = self._value(node.value)
                self.held[name.id] = value if isinstance(value, Value) else self._copy(value, self.lanes[name.id])
                made.add(name.id)
            else:
                self._add(ast.unparse(node))
                self.ready -= {name.id}
        kept = {value for name, value in self.held.items() if name in self.needed - made}
        ends: dict[str, Value] = {}
        for name in sorted(made & self.needed):
            value = self.held[name]
            ends[name] = self._copy(value, value.logical) if value in {*kept, *ends.values()} else value
        for value in (*kept, *ends.values()):
            value.uses += 1
        self._write(depth, ends)
        for logical in (False, True):
            moves = {name: v.array for name, v in ends.items() if v.logical == logical and v.array != name}
            if moves:
                to = [*moves, *sorted({*moves.values()} - {*moves})]
                what = [*moves.values(), *sorted({*moves} - {*moves.values()})]
                self.lines.append("    " * depth + f"{', '.join(to)} = {', '.join(what)}")

    def _write(self, depth: int, ends: dict[str, Value]) -> None:
        """Hand out arrays: those of the pool, and those of names that are made again, without what was there."""
        used = {value.array for line in self.run for value in (*line.of, *ends.values()) if isinstance(value, Value)}
        free = {
            logical: [name for name in ends if self.lanes[name] == logical and name not in used] + pool
            for logical, pool in self.pools.items()
        }
        for line in self.run:
            names = [value if isinstance(value, str) else value.array for value in line.of]
            base = line.of[0] if line.keeps is not None else None
            made = line.made
            if made and isinstance(base, Value) and base.uses == 1 + (line.keeps or 0):  # nobody else needs it
                made.array = base.array
                continue
            for value in line.of:
                if isinstance(value, Value):
                    value.uses -= 1
                    if not value.uses:
                        free[value.logical].append(value.array)
            if made and not made.array:
                pool = self.pools[made.logical]
                if not free[made.logical]:
                    pool.append(f"{'q' if made.logical else 'p'}{len(pool)}")
                    free[made.logical].append(pool[-1])
                made.array = free[made.logical].pop()
                if not made.uses:
                    free[made.logical].append(made.array)
            self.lines.append("    " * depth + line.text.format(*names, out=made.array if made else ""))
            depth += line.deeper

    # ------------------------------------------------------------------------------------------------------ operations
    def _add(self, text: str, *of: Value | str, made: Value | None = None, deeper: int = 0) -> None:
        for value in of:
            if isinstance(value, Value):
                value.uses += 1
        self.run.append(ArrayLine(text, of, made, deeper))

    def _copy(self, value: Value | str, logical: bool) -> Value:
        made = Value(logical)
        self._add("{out}[:] = {}", value, made=made)
        return made

    def _call(self, name: str, logical: bool, *of: Value | str) -> Value:
        """`out` by its place, which takes 6 % less time; maximum and minimum want it by its name."""
        out = "out={out}" if name in ("maximum", "minimum") else "{out}"
        made = Value(logical)
        self._add(f"{name}({', '.join('{}' for _ in of)}, {out})", *of, made=made)
        return made

    def _value(self, node: Any) -> Value | str:
        if not self._is_lane(node):
            return self._plain(node)
        if isinstance(node, ast.Name):
            return self.held.setdefault(node.id, Value(self.lanes[node.id], array=node.id))
        if isinstance(node, ast.Call):
            name = ast.unparse(node.func)
            if name == "where":
                return self._where(*node.args)
            value, *others = (self._value(part) for part in node.args)
            if name == "clip":
                return self._call("minimum", False, self._call("maximum", False, value, others[0]), others[1])
            return self._call(name, False, value, *others)
        if isinstance(node, ast.UnaryOp):
            operation: ast.AST = node.op
            parts = [node.operand]
        elif isinstance(node, ast.Compare):
            operation, parts = node.ops[0], [node.left, *node.comparators]
        else:
            operation, parts = node.op, [node.left, node.right]
        return self._call(CALLS[type(operation)], self._is_logical(node), *(self._value(part) for part in parts))

    def _plain(self, node: ast.AST) -> str:
        text = ast.unparse(node)
        if all(name in self.constants for name in _names(node)):
            return self.hoisted.setdefault(text, f"c{len(self.hoisted)}")
        if isinstance(node, ast.Name) and text not in self.ready:
            self.ready.add(text)
            self._add(f"{text} = asarray({text})")
        return text if isinstance(node, ast.Name) else f"({text})"

    def _where(self, condition: Any, yes: Any, no: Any) -> Value:
        base = self._value(no)
        made = self._copy(base, self._is_logical(yes) or self._is_logical(no))
        start, before = self.run[-1], base.uses if isinstance(base, Value) else 0
        conditions = _joined(condition)
        mask = self._value(conditions[0])
        self._add("if count_nonzero({}):", mask, deeper=1)
        for part in conditions[1:]:
            mask = self._call("bitwise_and", True, mask, self._value(part))
            self._add("if count_nonzero({}):", mask, deeper=1)
        self._add("copyto({out}, {}, where={})", self._value(yes), mask, made=made, deeper=-len(conditions))
        start.keeps = base.uses - before if isinstance(base, Value) else 0
        return made


def _is_of_a_run(node: ast.AST) -> bool:
    """Is it an assignment, and not a number of motors, for which the run has to be over?"""
    return isinstance(node, ast.Assign | ast.AugAssign) and not {"len", "count_nonzero"} & set(_names(node))


def _names(node: ast.AST) -> list[str]:
    return [part.id for part in ast.walk(node) if isinstance(part, ast.Name)]


def _joined(node: Any) -> list[Any]:
    """Return what is joined by `&` or `and`."""
    if isinstance(node, ast.BoolOp):
        return [part for value in node.values for part in _joined(value)]
    if isinstance(node, ast.BinOp) and isinstance(node.op, ast.BitAnd):
        return [*_joined(node.left), *_joined(node.right)]
    return [node]

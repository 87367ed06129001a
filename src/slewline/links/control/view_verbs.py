"""What the requests for what is seen of chips and parts do."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import asdict
from functools import partial
from pathlib import Path
from tempfile import TemporaryDirectory
from time import perf_counter
from typing import TYPE_CHECKING

from ...bench.files import examples
from ...bench.scripts.script import run_script
from ...chips import checks_of
from ...core.component import input_of
from ...core.datasheet.packages import packages
from ...core.messages.near import hint
from ...core.time.timebase import Time, moment, picoseconds
from ...errors import SlewlineError, UsageError
from ...language.assemble import RefusedProgram, assemble
from ...language.describe import syntax
from ...language.lint import lint
from ...parts.hosts.host import Host
from ..lines.line import ConnectorLine
from .kinds import Data
from .rows_of_views import FORMS, MAX_COLUMNS, MAX_ENTRIES
from .verbs import Verbs

if TYPE_CHECKING:
    from ...core.chip import Chip
    from ...core.datasheet.table import Sheet
    from ...language.problems import Problem
    from ...parts.base.part import Part

WORK_S = 0.0005  # how long a window is worked out in a turn of the loop
EXPORTED = 5_000_000  # characters of a file
LONGEST = 1 << 20  # characters of a program


class ViewVerbs(Verbs):
    """Sheets, programs, what is said, what signals did; commands and hands."""

    def do_describe(self, request: Data) -> Data:
        """Reply with what the data sheet of a chip says."""
        return {"sheet": sheet_data(self.chip(request["chip"]).sheet)}

    def do_parts(self, _request: Data) -> Data:
        """Reply with the parts."""
        bench, found = self.bench, {}
        owners: dict[str, Chip | Part] = {**bench.chips, **bench.parts}
        wires = {name: {pin.net.root for pin in owner.pins.values()} for name, owner in owners.items()}
        for name, part in bench.parts.items():
            shaft = getattr(part, "shaft", None)
            source = getattr(getattr(shaft, "source", None), "name", None)
            found[name] = {
                "kind": type(part).__name__,
                "pins": [*part.pins],
                "verbs": [*part.verbs],
                "quantities": [quantity.name for quantity in part.quantities()],
                "to": [other for other in wires if other != name and not wires[name].isdisjoint(wires[other])],
                "on": source if source != name else None,
            }
        return {"parts": found}

    def do_listing(self, request: Data) -> Data:
        """Reply with the stored program of a chip."""
        chip = self.chip(request["chip"])
        rows = [
            {"address": row.address, "bytes": row.data.hex(" ").upper(), "text": row.text}
            for row in chip.program_rows()
        ]
        return {"rows": rows, "counter": chip.program_counter}

    def do_view(self, _request: Data) -> Data:
        """Reply with everything that a panel shows."""
        return {"view": self.server.views.view()}

    def do_subscribe(self, request: Data) -> Data:
        """Send events from now on."""
        return {"view": self.client.subscribe(picoseconds(request["every"]) / 1e12)}

    def do_said(self, request: Data) -> Data:
        """Reply with the last entries."""
        start = request.get("start", 0)
        if not isinstance(start, int):
            raise UsageError(f"start {start!r}; expected the number of an entry")
        entries, omitted = self.server.dialogue.since(start)
        return {"entries": entries[-MAX_ENTRIES:], "omitted": omitted + max(len(entries) - MAX_ENTRIES, 0)}

    # --------------------------------------------------------------------------------------------------------- scope
    def do_signals(self, _request: Data) -> Data:
        """Reply with what a scope can show."""
        return self.server.scope.signals()

    def do_record(self, request: Data) -> Data:
        """Keep what pins do."""
        pins = texts(request, "pins")
        if pins:
            self.bench.record(*pins, keep=request.get("keep", "1 h"))
        return {}

    def do_window(self, request: Data) -> None:
        """Reply with what signals did; a long answer is worked out beside everything else."""
        columns = request["columns"]
        if not isinstance(columns, int) or not 1 <= columns <= MAX_COLUMNS:
            raise UsageError(f"columns {columns!r}; allowed 1 to {MAX_COLUMNS}")
        names = texts(request, "signals")
        work = self.server.scope.window(names, *self.of_window(request), columns)
        self.go_on_with(work, self.client.answer_later(request))

    def go_on_with(self, work: Iterator[Data | None], answer: Callable[[Data], object]) -> None:
        """Work for a share of the turn; answer when it is done."""
        end_s = perf_counter() + WORK_S
        found = None
        try:
            for found in work:
                if found is not None or perf_counter() > end_s:
                    break
        except SlewlineError as error:
            answer({"error": str(error)})
            return
        if found is not None:
            answer({"signals": found})
        else:
            self.server.loop.ask(partial(self.go_on_with, work, answer))

    def do_find(self, request: Data) -> Data:
        """Reply with the instant at which something happens."""
        if not isinstance(request["on"], dict):
            raise UsageError(f"on {request['on']!r}; expected an object such as {{'pin': 'x.slew', 'edge': 'falls'}}")
        found = self.server.scope.find(request["on"], *self.of_window(request), request.get("last") is True)
        return {"found_ps": found}

    def of_window(self, request: Data) -> tuple[int, int]:
        """Return the window of a request, up to now (ps)."""
        start, stop = moment(request.get("start", 0)), moment(request.get("stop", self.bench.now_ps))
        stop = min(stop, self.bench.now_ps)
        return min(start, stop), stop

    def do_export(self, request: Data) -> Data:
        """Reply with recorded pins as a file."""
        form, names = request["form"], texts(request, "signals")
        if form not in FORMS:
            raise UsageError(f"form {form!r}; allowed {', '.join(FORMS)}")
        pins = [name for name in names if name in self.bench.recorded]
        start, stop = (f"{ps} ps" for ps in self.of_window(request))
        with TemporaryDirectory() as folder:
            path = Path(folder) / f"window.{form}"
            (self.bench.save_vcd if form == "vcd" else self.bench.save_csv)(path, pins, as_time(start), as_time(stop))
            if path.stat().st_size > EXPORTED:
                raise UsageError(f"export: {path.stat().st_size} bytes; allowed {EXPORTED}; choose a shorter window")
            return {"text": path.read_text("utf-8")}

    # ------------------------------------------------------------------------------------------------ commands, hands
    def do_send(self, request: Data) -> Data:
        """Send commands to a chip."""
        chip, text = self.chip(request["chip"]), request["text"]
        served = [line for line in self.server.lines.values() if chip in line.chips]
        lines = {line.port for line in served if isinstance(line, ConnectorLine)}
        hosts = [part for part in self.bench.parts.values() if isinstance(part, Host) and chip.name in part.chips]
        own = [host for host in hosts if host not in lines]
        if own:
            with self.bench.kernel.outside.queued():
                run_script(self.bench, own[0].to(chip), text, "command line")
            return {}
        for line in served:
            if isinstance(line, ConnectorLine):
                for command in text.splitlines():
                    line.take(command.encode("ascii", "replace") + b"\r")
                return {}
        raise UsageError(f"{chip.name}: a host program has its registers; its commands come from there alone")

    def do_act(self, request: Data) -> Data:
        """Do something to a part."""
        args = request.get("args", [])
        if not isinstance(args, list):
            raise UsageError(f"args {args!r}; expected a list")
        part = self.bench[request["part"]]
        if request["verb"] not in getattr(part, "verbs", ()):
            allowed = ", ".join(getattr(part, "verbs", ())) or "none"
            raise UsageError(f"{part.name}: no verb {request['verb']!r}; allowed {allowed}")
        input_of(part, request["verb"])(*args)
        return {}

    def do_assemble(self, request: Data) -> Data:
        """Reply with an assembled program, and what is odd about it."""
        chip, text = self.chip(request["chip"]), request["text"]
        if len(text) > LONGEST:
            raise UsageError(f"assemble: {len(text)} characters; allowed {LONGEST}")
        problems = lint(text, chip.sheet, checks_of(type(chip), chip.sheet))
        try:
            assembly = assemble(text, chip.sheet, "program")
        except RefusedProgram:
            return {"rows": [], "bytes": 0, "problems": [problem_data(problem) for problem in problems]}
        rows = [
            {
                "line": line.number,
                "address": line.address,
                "bytes": assembly.stored[statement.address - assembly.base : statement.end - assembly.base]
                .hex(" ")
                .upper(),
                "text": line.source,
            }
            for line, statement in zip(assembly.lines, assembly.statements, strict=True)
        ]
        return {
            "rows": rows,
            "bytes": len(assembly.stored),
            "problems": [problem_data(problem) for problem in problems],
        }

    def do_examples(self, _request: Data) -> Data:
        """Reply with the examples."""
        rows = [
            {"name": name, "part": path.suffix[1:], "title": examples.title(path)}
            for name, path in examples.named().items()
        ]
        return {"examples": rows}

    def do_example(self, request: Data) -> Data:
        """Reply with the text of an example."""
        found = examples.named()
        if request["name"] not in found:
            raise UsageError(f"no example {request['name']!r}{hint(request['name'], found)}; `examples` lists them")
        return {"text": found[request["name"]].read_text("utf-8", "replace")}


def texts(request: Data, key: str) -> list[str]:
    """Return a list of texts in a request.

    Raises:
        UsageError: it is none.
    """
    value = request[key]
    if not isinstance(value, list) or not all(isinstance(each, str) for each in value):
        raise UsageError(f'{key} {value!r}; expected a list such as ["x.pulse"]')
    return value


def as_time(text: str) -> Time:
    """Return a time as the bench takes it: 0 has no unit."""
    return 0 if text == "0 ps" else text


def problem_data(problem: Problem) -> Data:
    """Return a problem as data."""
    return {
        "line": problem.line,
        "column": problem.column,
        "length": problem.length,
        "severity": problem.severity,
        "says": problem.says,
        "remedy": problem.remedy,
    }


def sheet_data(sheet: Sheet) -> Data:
    """Return what a panel needs of a data sheet."""
    pins = [
        {
            "number": pin.number,
            "name": pin.name,
            "way": pin.way,
            "says": pin.says,
            "active": pin.active,
            "role": pin.role,
            "axis": pin.axis,
            "where": pin.where,
        }
        for pin in sheet.pins
    ]
    registers = [
        {"name": each.name, "bits": each.bits, "says": each.says, "unit": each.unit, "letter": each.letter}
        for each in sheet.registers
    ]
    commands = [
        {"form": row.form, "name": row.name, "syntax": syntax(row), "says": row.says, "where": row.where}
        for row in sheet.commands
    ]
    return {
        "part": sheet.part,
        "title": sheet.title,
        "manual": sheet.manual,
        "axes": sheet.axes,
        "buffer_bytes": sheet.buffer_bytes,
        "memory_unit": sheet.memory_unit,
        "pins": pins,
        "packages": [asdict(package) for package in packages(sheet.pins)],
        "registers": registers,
        "commands": commands,
        "wires": [list(names) for names in sheet.wires],
    }

"""Handlers of the requests for views of chips and parts."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import asdict
from functools import partial
from inspect import Parameter, signature
from pathlib import Path
from tempfile import TemporaryDirectory
from time import perf_counter
from typing import TYPE_CHECKING, Any

from ...bench.files import shipped_files
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
from ..lines.served_line import ConnectorLine
from .pin_verbs import Verbs
from .rows_of_views import MAX_ENTRIES
from .validator import check
from .value_kinds import INTEGER, Data

if TYPE_CHECKING:
    from ...core.chip import Chip
    from ...core.datasheet.table import Sheet
    from ...language.problems import Problem
    from ...parts.base.part import Part

WORK_S = 0.0005  # time for a window per turn of the loop
PARAMETERS = {"int": "integer", "float": "number", "str": "string", "bool": "boolean"}
EXPORTED = 5_000_000  # characters of a file


class ViewVerbs(Verbs):
    """Handlers for data sheets, programs, dialogues, signals, commands and manual actions."""

    def do_describe(self, request: Data) -> Data:
        """Reply with the data sheet of a chip."""
        return {"sheet": sheet_data(self.chip(request["chip"]).sheet)}

    def do_parts(self, _request: Data) -> Data:
        """Reply with the parts on the bench, keyed by name."""
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
        """Reply with the complete view for a panel."""
        return {"view": self.server.views.view()}

    def do_subscribe(self, request: Data) -> Data:
        """Start sending events to the client, or stop if the interval is 0; reply with the current view."""
        return {"view": self.client.subscribe(picoseconds(request["every"]) / 1e12)}

    def do_said(self, request: Data) -> Data:
        """Reply with the latest entries in the dialogue of hosts and chips."""
        entries, omitted = self.server.dialogue.since(request.get("start", 0))
        return {"entries": entries[-MAX_ENTRIES:], "omitted": omitted + max(len(entries) - MAX_ENTRIES, 0)}

    # --------------------------------------------------------------------------------------------------------- scope
    def do_signals(self, _request: Data) -> Data:
        """Reply with the signals that a scope can show."""
        return self.server.scope.signals()

    def do_record(self, request: Data) -> Data:
        """Record pins from now on."""
        if request["pins"]:
            self.bench.record(*request["pins"], keep=request.get("keep", "1 h"))
        return {}

    def do_window(self, request: Data) -> None:
        """Reply with the history of signals; a long answer is computed over several loop turns."""
        names = [*dict.fromkeys(request["signals"])]
        work = self.server.scope.window(names, *self.of_window(request), request["columns"])
        self.go_on_with(request, work, self.client.answer_later(request))

    def go_on_with(self, request: Data, work: Iterator[Data | None], answer: Callable[[Data], object]) -> None:
        """Continue `work` for a share of a loop turn; answer when it is done, or else continue in the next turn."""
        end_s = perf_counter() + WORK_S
        found = None
        try:
            for found in work:
                if found is not None or perf_counter() > end_s:
                    break
        except Exception as error:
            answer(self.client.failed(request, error))
            return
        if found is not None:
            answer({"signals": found})
        else:
            self.server.loop.ask(partial(self.go_on_with, request, work, answer))

    def do_find(self, request: Data) -> Data:
        """Reply with the instant at which an event first or last occurs in a window; null if it does not occur."""
        found = self.server.scope.find(request["on"], *self.of_window(request), request.get("last", False))
        return {"found_ps": found}

    def of_window(self, request: Data) -> tuple[int, int]:
        """Return the start and end of the window in a request (ps); neither is later than the current instant."""
        start, stop = moment(request.get("start", 0)), moment(request.get("stop", self.bench.now_ps))
        stop = min(stop, self.bench.now_ps)
        return min(start, stop), stop

    def do_export(self, request: Data) -> Data:
        """Reply with the history of recorded pins in a window, as the content of a VCD or CSV file."""
        form = request["form"]
        pins = [name for name in dict.fromkeys(request["signals"]) if name in self.bench.recorded]
        if not pins:
            raise UsageError("export: signals: no recorded pin is among them; use `record` to record pins from now on")
        start, stop = (f"{ps} ps" for ps in self.of_window(request))
        with TemporaryDirectory() as folder:
            path = Path(folder) / f"window.{form}"
            try:
                (self.bench.save_vcd if form == "vcd" else self.bench.save_csv)(
                    path, pins, as_time(start), as_time(stop)
                )
            except SlewlineError as error:  # it names a file on the server
                raise UsageError(f"export: {str(error).removeprefix(f'{path}: ')}") from None
            if path.stat().st_size > EXPORTED:
                size = path.stat().st_size
                raise UsageError(f"export: {size} bytes; allowed up to {EXPORTED}; choose a shorter window")
            return {"text": path.read_text("utf-8")}

    # ---------------------------------------------------------------------------------------------- commands, actions
    def do_send(self, request: Data) -> Data:
        """Send commands to a chip, as its host would."""
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
        raise UsageError(
            f"{chip.name}: a host program uses the registers of this chip; send the commands from that program"
        )

    def do_act(self, request: Data) -> Data:
        """Perform a manual action on a part."""
        part = self.bench[request["part"]]
        if request["verb"] not in getattr(part, "verbs", ()):
            allowed = ", ".join(getattr(part, "verbs", ())) or "none"
            raise UsageError(f"{part.name}: no verb {request['verb']!r}; allowed {allowed}")
        method = input_of(part, request["verb"])
        method(*arguments(method, request.get("args", [])))
        return {}

    def do_assemble(self, request: Data) -> Data:
        """Assemble a program without sending it; reply with its instructions, its length and its problems."""
        chip, text = self.chip(request["chip"]), request["text"]
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
        """Reply with the list of the shipped examples."""
        rows = [
            {"name": name, "part": path.suffix[1:], "title": shipped_files.title(path)}
            for name, path in shipped_files.named().items()
        ]
        return {"examples": rows}

    def do_example(self, request: Data) -> Data:
        """Reply with the text of a shipped example."""
        found = shipped_files.named()
        if request["name"] not in found:
            raise UsageError(f"no example {request['name']!r}{hint(request['name'], found)}; `examples` lists them")
        return {"text": found[request["name"]].read_text("utf-8", "replace")}


def arguments(method: Callable[..., object], values: list[Any]) -> list[Any]:
    """Return `values` as the arguments of a part's verb, each checked against the kind of its parameter.

    Raises:
        UsageError: there are too few or too many arguments, or one is of the wrong kind.
    """
    parameters = [*signature(method).parameters.values()]
    needed = sum(parameter.default is parameter.empty for parameter in parameters)
    if not needed <= len(values) <= len(parameters):
        takes = ", ".join(parameter.name for parameter in parameters) or "none"
        raise UsageError(f"act: args: a list of length {len(values)}; allowed for {method.__name__}: {takes}")
    return [
        check(value, argument(parameter), f"act: args[{number}]")
        for number, (value, parameter) in enumerate(zip(values, parameters, strict=False))
    ]


def argument(parameter: Parameter) -> Data:
    """Return the kind of a verb's parameter, as a JSON schema made from its annotation."""
    types = [PARAMETERS[each] for each in str(parameter.annotation).split(" | ")]
    return INTEGER if types == ["integer"] else {"type": types}


def as_time(text: str) -> Time:
    """Return a text as a time that a bench accepts: "0 ps" becomes the number 0, any other text is unchanged."""
    return 0 if text == "0 ps" else text


def problem_data(problem: Problem) -> Data:
    """Return a problem in a program as JSON data."""
    return {
        "line": problem.line,
        "column": problem.column,
        "length": problem.length,
        "severity": problem.severity,
        "says": problem.message,
        "remedy": problem.remedy,
    }


def sheet_data(sheet: Sheet) -> Data:
    """Return the content that a panel needs from a data sheet, as JSON data."""
    pins = [
        {
            "number": pin.number,
            "name": pin.name,
            "way": pin.in_out,
            "says": pin.description,
            "active": pin.active,
            "role": pin.role,
            "axis": pin.axis,
            "where": pin.where,
        }
        for pin in sheet.pins
    ]
    registers = [
        {"name": each.name, "bits": each.bits, "says": each.description, "unit": each.unit, "letter": each.letter}
        for each in sheet.registers
    ]
    commands = [
        {"form": row.form, "name": row.name, "syntax": syntax(row), "says": row.description, "where": row.where}
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

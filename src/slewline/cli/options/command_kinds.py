"""Kinds of commands, and suggestions for unknown commands and options."""

from __future__ import annotations

from collections.abc import Iterable
from typing import Any

import click

from ...core.messages.near import near
from .word_order import misplaced

MEANT = {  # suggestions for unknown commands and options
    "plot": "slewline run FILE --plot F.svg draws a run, slewline ramp CHIP ... --plot F.svg a ramp",
    **dict.fromkeys(("simulate", "sim", "play", "start", "test"), "slewline run FILE"),
    **dict.fromkeys(("emulate", "server", "port", "listen"), "slewline serve CHIP --tcp 4001"),
    **dict.fromkeys(("list", "parts", "ls"), "`slewline chips` lists the chips, `slewline examples` the examples"),
    **dict.fromkeys(("info", "show", "doc", "commands", "man"), "slewline describe CHIP"),
    **dict.fromkeys(("assemble", "compile"), "slewline asm FILE"),
    **dict.fromkeys(("disassemble", "disasm"), "slewline dis FILE"),
    **dict.fromkeys(("check", "verify", "validate"), "slewline lint FILE"),
    **dict.fromkeys(("convert", "vcd"), "slewline run FILE --vcd F.vcd writes a waveform"),
    **dict.fromkeys(("talk", "connect", "console", "miniterm"), "slewline terminal PORT --chip CHIP"),
    **dict.fromkeys(("record", "sniff", "spy"), "slewline proxy --serial DEV --chip CHIP --pty LINK --dialogue F"),
    **dict.fromkeys(("diff", "differences"), "slewline compare"),
    **dict.fromkeys(
        ("backup", "save", "download", "read"), "slewline pull PORT -o FILE saves the program of a real module"
    ),
    **dict.fromkeys(("restore", "upload", "load", "write"), "slewline push PORT FILE sends a program to a real module"),
    "replay": "slewline run --replay JOURNAL",
    "version": "slewline --version",
    "run --bench": "a bench file is the FILE itself, slewline run BENCH.toml",
    "run --part": "--chip names the part",
    "run --output": "--vcd, --steps, --plot and --json name the output files",
    "run -o": "--vcd, --steps, --plot and --json name the output files",
    "run --npz": "--steps F.npz",
    "run --csv": "--steps F.csv",
    "run --time": "--until sets the end, such as '2 s'",
    "pull --port": "PORT is an argument, not an option: slewline pull PORT -o FILE",
    "push --port": "PORT is an argument, not an option: slewline push PORT FILE",
    "panel --port": "--listen HOST:PORT",
    "serve --port": "--tcp 4001, --serial DEV or --pty LINK",
    "serve --chip": "CHIP is an argument, not an option: slewline serve PART --tcp 4001",
    "describe --chip": "CHIP is an argument, not an option: slewline describe PART",
    "ramp --chip": "CHIP is an argument, not an option: slewline ramp PART NAME=VALUE ...",
}


EXAMPLES = {  # of commands that need more than one option
    "tune": "cy525 --motor QSH4218-51-10-049 --driver '24 V, 1 A averaged' --steps 500",
    "calibrate": "--motor QSH4218-51-10-049 --driver '24 V, 1 A' --start-stop '900 steps/s'",
    "drive": "gs-c200s --board /dev/ttyACM0 --tcp 4001",
    "pull": "/dev/ttyUSB0 -o saved.gs-c200s",
    "terminal": "/dev/ttyUSB0 --chip gs-c200s",
    "proxy": "--serial /dev/ttyUSB0 --chip gs-c200s --tcp 4001 --dialogue recorded.dialogue",
    "epics": "/dev/ttyUSB0 --chip gs-c200s --record lab:m1 S=10 T=100 R=50",
    "translate": "old.cy512 --to cy525 --prove",
    "check-capture": "recorded.csv --axis x=STEP,DIR",
    "decode": "recorded.csv --chip gs-c200s --host D0 --module D1",
}


def meant(name: str, names: Iterable[str]) -> str:
    """Return a text that suggests the known name most similar to a wrong name; empty if none is similar."""
    return next((f". Did you mean {each!r}?" for each in near(name, names)), "")


class HintingCommand(click.Command):
    """A command that suggests a known option for an unknown one, and lists all missing arguments and options."""

    def parse_args(self, ctx: click.Context, args: list[str]) -> list[str]:
        """Read the arguments; if any is misplaced, missing or unknown, fail with a suggestion."""
        given = list(args)
        is_checked = not (ctx.resilient_parsing or {"-h", "--help"} & {*args})
        if is_checked and (message := misplaced(self, ctx, given)):
            raise click.UsageError(message, ctx)
        try:
            return super().parse_args(ctx, self.completed(ctx, args) if is_checked else args)
        except click.MissingParameter as error:
            if getattr(error.param, "name", "") == "chip":
                raise click.UsageError("Missing argument 'CHIP': `slewline chips` lists the chips", ctx) from None
            example = EXAMPLES.get(self.name or "")
            if example is None:
                raise
            missing = ", ".join(self.missing(ctx, given))
            raise click.UsageError(f"Missing {missing}; for example:  slewline {self.name} {example}", ctx) from None
        except click.NoSuchOption as error:
            remedy = MEANT.get(f"{ctx.info_name} {error.option_name}")
            message = meant(error.option_name, self.options(ctx)) if remedy is None else f": {remedy}"
            raise click.UsageError(f"No such option '{error.option_name}'{message}", ctx) from None

    def options(self, ctx: click.Context) -> list[str]:
        """Return the names, beginning with --, of the options that the help lists."""
        listed = [each for each in self.get_params(ctx) if isinstance(each, click.Option) and not each.hidden]
        return [name for each in listed for name in (*each.opts, *each.secondary_opts) if name.startswith("--")]

    def completed(self, ctx: click.Context, args: list[str]) -> list[str]:
        """Return the arguments unchanged; a subclass may prompt the user for missing ones and add the answers."""
        return args

    def given(self, ctx: click.Context, args: list[str]) -> dict[str, Any]:
        """Return the values on the command line as they were written, by parameter name."""
        found, _, _ = self.make_parser(ctx).parse_args(list(args))
        return {
            name: value for name, value in found.items() if isinstance(value, (str, bool, list, tuple)) and value != ()
        }

    def missing(self, ctx: click.Context, args: list[str]) -> list[str]:
        """Return the names of the required arguments and options that the line lacks, as a user writes them."""
        found = self.given(ctx, args)
        needed = [each for each in self.get_params(ctx) if each.required and each.name not in found]
        return [each.human_readable_name if isinstance(each, click.Argument) else each.opts[0] for each in needed]


class ChipOption(click.Option):
    """The option --chip of a command for a real module; its old name --part still works, but is hidden."""

    also = ("--part",)

    def add_to_parser(self, parser: Any, ctx: click.Context) -> None:
        """Add both names to the parser."""
        shown, self.opts = self.opts, [*self.opts, *self.also]
        try:
            super().add_to_parser(parser, ctx)
        finally:
            self.opts = shown


class CommandGroup(click.Group):
    """The group of all commands; for an unknown command it suggests a known one."""

    command_class = HintingCommand

    @property
    def shown(self) -> list[str]:
        """The names of the commands that the help lists."""
        return [name for name, command in self.commands.items() if not command.hidden]

    def resolve_command(
        self, ctx: click.Context, args: list[str]
    ) -> tuple[str | None, click.Command | None, list[str]]:
        """Return the name, the command and its arguments; for an unknown name, fail with a suggestion."""
        name = args[0]
        if name not in self.commands and not name.startswith("-"):
            if name in MEANT:
                ctx.fail(f"No such command {name!r}: {MEANT[name]}")
            there = f"; commands: {', '.join(self.shown)}"
            ctx.fail(f"No such command {name!r}{meant(name, self.shown) or there}")
        return super().resolve_command(ctx, args)


class CommandWithGuide(HintingCommand):
    """A command whose help ends with the guide to writing run scripts."""

    def format_epilog(self, ctx: click.Context, formatter: click.HelpFormatter) -> None:
        """Write the guide, which is the unchanged docstring of bench/scripts/script.py, then the exit statuses."""
        from ...bench.scripts import script

        formatter.write_paragraph()
        formatter.write((script.__doc__ or "") + "\n")
        super().format_epilog(ctx, formatter)


class OncePerName(click.Option):
    """A repeatable option, NAME=VALUE, that refuses a repeated name: otherwise the last value would win silently."""

    def type_cast_value(self, ctx: click.Context, value: Any) -> Any:
        """Return the values; refuse a repeated name."""
        found = super().type_cast_value(ctx, value)
        given: dict[str, Any] = {}
        for each in found or ():
            name = (each[0] if isinstance(each, tuple) else each.partition("=")[0]).strip()
            if name in given:
                raise click.BadParameter(f"{name} is given twice; leave one out", ctx, self)
            given[name] = each
        return found

"""The entry point, which runs the command line and turns every error into a message and an exit status.

The status is 0 for success; 1 if a problem was found in the program or file, the time limit was reached,
or the command was interrupted; 2 for incorrect usage.
"""

from __future__ import annotations

import codecs
import io
import os
import signal
import sys
import warnings
from functools import partial

from . import FOUND, WRONG_USE, Terminated

TYPE_CHECKING = False  # imports are delayed as long as possible: see `main`
if TYPE_CHECKING:
    from collections.abc import Iterator, Sequence
    from typing import NoReturn

    import click

INTERRUPTED = "interrupted; unfinished files are unchanged"
AGAIN_S = 0.01
ENDS = ("SIGTERM", "SIGHUP", "SIGQUIT")  # if the system has them


def main() -> None:
    """Run the command line and exit with its status; the console script `slewline` calls this function."""
    _open_closed()
    if default := signal.getsignal(signal.SIGINT) is signal.default_int_handler:
        signal.signal(signal.SIGINT, _interrupted)  # an exception would show a traceback of the imports
    try:
        from ..errors import SlewlineError  # noqa: F401
        from .commands import cli  # noqa: F401
    except ModuleNotFoundError:  # `invoke` reports it
        pass
    codecs.register_error("slewline", _plainer)
    for stream in (sys.stdout, sys.stderr):
        if isinstance(stream, io.TextIOWrapper):
            stream.reconfigure(errors="slewline")
    try:
        if default:
            signal.signal(signal.SIGINT, signal.default_int_handler)
        _end_in_order()
        warnings.showwarning = _shown  # type: ignore[assignment]
        sys.unraisablehook = _dropped
        status = invoke(sys.argv[1:])
    except KeyboardInterrupt:  # before or after the command
        _interrupted()
    if default:
        signal.signal(signal.SIGINT, signal.SIG_IGN)  # Python takes a while to exit
    exec("")  # `python -m` ends by SIGINT if the last `exec`, as in a dataclass, was interrupted
    sys.exit(status)


def _end_in_order() -> None:
    """Make SIGTERM, SIGHUP and SIGQUIT end the command like Ctrl-C, except any that are ignored (as by nohup)."""
    own = os.getpid()
    numbers = [number for name in ENDS if (number := getattr(signal, name, None)) is not None]
    numbers = [number for number in numbers if signal.getsignal(number) is signal.SIG_DFL]

    def end(number: int, _frame: object) -> None:
        if os.getpid() != own:  # a forked copy of the process
            signal.signal(number, signal.SIG_DFL)
            signal.raise_signal(number)
        for each in numbers:
            signal.signal(each, signal.SIG_IGN)
        raise Terminated

    for number in numbers:
        signal.signal(number, end)


def _dropped(failed: sys.UnraisableHookArgs) -> None:
    """Raise KeyboardInterrupt again if Python has discarded it, as in `__del__`; report other errors as usual."""
    if not isinstance(failed.exc_value, KeyboardInterrupt):
        sys.__unraisablehook__(failed)
        return
    import threading

    signal.signal(signal.SIGINT, signal.default_int_handler)
    main, kill = threading.main_thread().ident, getattr(signal, "pthread_kill", None)  # the main thread may be asleep
    again = partial(signal.raise_signal, signal.SIGINT) if kill is None else partial(kill, main, signal.SIGINT)
    threading.Timer(AGAIN_S, again).start()  # after this function has returned


def _open_closed() -> None:
    """Connect closed standard streams to the null device, so that no file opened later takes their numbers."""
    for number, name in enumerate(("stdin", "stdout", "stderr")):
        if getattr(sys, name) is None:
            nowhere = os.open(os.devnull, os.O_RDWR)  # takes the lowest free number
            os.set_inheritable(nowhere, True)
            mode = "w" if number else "r"
            setattr(sys, name, open(nowhere, mode, encoding="utf-8"))  # noqa: SIM115  # it stays open


def _plainer(error: UnicodeError) -> tuple[str, int]:
    """Return a replacement for the characters that an output encoding lacks, and the index after them.

    For example, µs becomes us if the encoding of a terminal or file has no µ, as in some Windows code pages.
    """
    if not isinstance(error, UnicodeEncodeError):
        raise error
    from ..core.messages.plain import ascii_of

    return ascii_of(error.object[error.start : error.end]), error.end


def _interrupted(*_: object) -> NoReturn:
    try:
        os.write(2, f"slewline: {INTERRUPTED}\n".encode())
    finally:
        os._exit(FOUND)


def invoke(arguments: Sequence[str]) -> int:
    """Run a command line; return the exit status.  An exception raised by this function is a fault in slewline."""
    from ..extras import needs

    try:
        from .commands import cli
    except ModuleNotFoundError as error:
        if error.name != "click":
            raise
        if list(arguments) == ["--version"]:
            from .version_line import version_line

            sys.stdout.write(f"{version_line()}\n")
            return 0
        sys.stderr.write(f"slewline: {needs('the command line needs', 'cli')}\n")
        return WRONG_USE
    try:
        status = _called(cli, arguments)
        sys.stdout.flush()
        return status
    except BrokenPipeError:  # the reader has closed the pipe, as in `slewline run FILE | head`
        _let_go()
        return FOUND
    except OSError as error:
        sys.stderr.write(f"slewline: output: {error.strerror or error}\n")
        _let_go()
        return FOUND


def _let_go() -> None:
    """Discard unwritten standard output, so that the interpreter does not fail at exit."""
    os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())


def _shown(message: Warning | str, *_: object) -> None:
    """Print a warning to standard error, in the form `slewline: MESSAGE`."""
    sys.stderr.write(f"slewline: {message}\n")


def _called(cli: click.Command, arguments: Sequence[str]) -> int:
    import click

    from ..errors import Endless, ProgramError, SlewlineError, Timeout
    from ..extras import needs

    try:
        # None: use colours on a terminal (https://no-color.org)
        colours = False if os.environ.get("NO_COLOR") else None
        return int(cli.main(list(arguments), prog_name="slewline", standalone_mode=False, color=colours) or 0)
    except click.ClickException as error:
        error.show()
        return error.exit_code
    except click.Abort as error:
        return _report_interrupt(error.__cause__)
    except ModuleNotFoundError as error:
        if (error.name or "").partition(".")[0] != "rich":
            raise
        click.echo(f"slewline: {needs('the command line needs', 'cli')}", err=True)
        return WRONG_USE
    except SlewlineError as error:
        click.echo(f"slewline: {error}", err=True)
        return FOUND if isinstance(error, (Timeout, Endless, ProgramError)) else WRONG_USE
    except Exception as error:  # Python or a library may have replaced the interrupt by another exception
        if not any(isinstance(each, KeyboardInterrupt) for each in _before(error)):
            raise
        return _report_interrupt()


def _report_interrupt(interrupt: BaseException | None = None) -> int:
    """Print the text of an interrupt, or a standard message if it has none; return the exit status, 1."""
    import click

    sys.unraisablehook = lambda _failed: None  # half-built objects cannot be finalised
    message = str(interrupt) if isinstance(interrupt, KeyboardInterrupt) else ""
    click.echo(f"slewline: {message or INTERRUPTED}", err=True)
    return FOUND


def _before(error: BaseException | None) -> Iterator[BaseException]:
    """Yield an exception, then the chain of exceptions that led to it, newest first."""
    while error is not None:
        yield error
        error = error.__cause__ or error.__context__

"""The run script: what a host sends, a command a line, and what it does in between.

    ; weld.cy525           a comment runs to the end of the line
    R 80                   goes out with a carriage return
    A$P 40                 a label goes out as it stands
    QX                     Q goes out without a carriage return, as the chip wants it; here X follows
    @until run=1           a line that begins with @ directs the host

A directive begins when the chip is READY after the command above it, or has been at work on it for 1 ms (at 11 MHz: a
motion, a delay, a wait).  A module on a serial line is asked line by line: address, checksum and carriage return are
added, and what comes next waits for the answer.

    Po                     the transcript shows the answer: Po -> Y
    S10
    E                      the program runs while what follows is asked

Directives take times such as 20 ms, and pins of the chip that the host speaks to (abort) or of anything on the bench
(y.abort):

    @wait 20 ms            let time pass
    @until run=1           wait for a level of a pin
    @until position=40     wait for a position
    @drive abort=0         put a level on a pin, now
    @drive abort=0@12 ms   or at an instant of the run
    @release abort         let go of a pin, now; or, as above, @release abort@15 ms
    @pulse wait=0 20 us    put a level on a pin for a time
    @power off             switch the supply off, or on
    @bytes 43 00           send bytes as they are
    @to y                  from here on, speak to chip y of those that share the bus or the line
    @note the door opens   say something in the transcript

To a chip on a bus (CY525); while ASCII/BINARY is low, commands go out in binary form:

    @reset                 pulse RESET
    @live R 20 | B         commands to a running program, through PROG/LIVE
    @rate 60               another rate on the fly, when the motor slews
    @read position         read the position on the fly, while the motor steps
    @verify 3              read a verify group

To a module on a serial line (GS-C200, GS-C200S):

    @until ready           ask F until the answer is no longer B
    @ask V1                ask something, as a line without @ does
"""

from __future__ import annotations

import re
from collections.abc import Iterable
from dataclasses import replace
from typing import TYPE_CHECKING

from ..errors import SlewlineError, UsageError
from ..language.source import host_lines
from .directives import DIRECTIVES
from .stage import Script, Stage, Step, command

if TYPE_CHECKING:
    from .bench import Bench
    from .stage import Computer

LONGEST = 1000  # characters of a line; no chip takes as many
EXAMPLES = re.findall(r"^    (@(\w+).*?)  +\S", __doc__ or "", re.MULTILINE)


def run_script(bench: Bench, host: Computer, script: Script | str | Iterable[str], where: str = "script") -> None:
    """Queue a script on a host; it plays while time passes, side by side with those of other hosts.

    Args:
        script: text, lines, or what `read_script` made of them.
        where: the name of the script in messages.

    Raises:
        ProgramError: lines that cannot be played; all of them are in `.problems`.
    """
    if not isinstance(script, Script):
        script = read_script(script if isinstance(script, str) else "\n".join(script), where)
    check_script(bench, host, script)
    if bench.journal is not None:
        bench.journal.write("script", host=host.name, args=[host.chip.name, script.text, script.where])
    stage = Stage(bench, host, script)
    following = [*script.steps[1:], None]
    for stage.step, then in zip(script.steps, following, strict=False):
        stage.directed = then is not None and then.directs
        stage.step.queue(stage)


def check_script(bench: Bench, host: Computer, script: Script) -> None:
    """Raise what is wrong with a script, pins and chips that the bench does not have included."""
    found = list(script.problems)
    stage, chip = Stage(bench, host, script), host.chip
    for step in script.steps:
        if step.to in host.chips:
            chip = host.chips[step.to]
        elif step.to:
            found.append(step.problem("unknown-chip", f"{host.name} serves {', '.join(host.chips)}, but not {step.to}"))
        try:
            if step.pin:
                stage.terminal(step.pin, chip)
            if step.fits is not None:
                step.fits(chip)
        except SlewlineError as error:
            found.append(step.problem("unknown-pin" if step.pin else "directive", str(error)))
    script.refuse(found)


# ------------------------------------------------------------------------------------------------------------- reading
def read_script(text: str, where: str = "script") -> Script:
    """Take a text apart.  Never raises: what is wrong is in `problems`."""
    steps, problems = [], []
    for line, column, body in host_lines(text):
        step = Step(line, column, body, command(body))
        try:
            _plain(step)
            steps.append(_directive(step) if step.directs else step)
        except UsageError as error:
            example = next((example for example, verb in EXAMPLES if verb == step.verb), "")
            remedy = f"write, for example, {example}" if example else ""
            problems.append(step.problem("directive" if step.directs else "line", str(error), remedy))
    return Script(text, where, tuple(steps), tuple(problems))


def _plain(step: Step) -> None:
    """A host sends printable ASCII, and no line without end."""
    if len(step.text) > LONGEST:
        raise UsageError(f"a line of {len(step.text)} characters; allowed {LONGEST}")
    odd = next((c for c in step.text if not " " <= c <= "~"), None)
    if odd is not None and step.verb != "note":
        at = f"{odd!r} at character {step.text.index(odd) + 1}"
        raise UsageError(f"{at} is not printable ASCII; @bytes sends other bytes")


def _directive(step: Step) -> Step:
    if step.verb not in DIRECTIVES:
        raise UsageError(f"no directive @{step.verb}; there are {' '.join('@' + verb for verb in DIRECTIVES)}")
    rest = step.text[1 + len(step.verb) :].strip()
    if bool(rest) == (step.verb == "reset"):
        raise UsageError("@reset takes no argument" if rest else f"@{step.verb} needs an argument")
    queue, pin, fits = DIRECTIVES[step.verb](rest)
    return replace(step, queue=queue, pin=pin, fits=fits, to=rest if step.verb == "to" else "")

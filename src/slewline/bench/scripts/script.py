"""The run script: the commands of a host, one per line, and its actions between them.

    ; weld.txt             a comment runs to the end of the line
    R 80                   sent with a carriage return
    A$P 40                 a label is sent unchanged
    QX                     Q is sent without a carriage return, as the chip requires; X follows
    @until run=1           a line that begins with @ is a directive to the host

A directive begins when the chip is READY after the command above it, or has been busy for 1 ms at
11 MHz with that command (a motion, a delay or a wait).  For a module on a serial line, the address,
checksum and carriage return are added to each line, and the next line waits for the answer.

    Po                     the transcript shows the answer: Po -> Y
    S10
    E                      the program runs while the next lines are sent

Directives take times such as 20 ms, and pins of the chip that the host commands (abort) or of any chip
or part on the bench (y.abort):

    @wait 20 ms            let time pass
    @until run=1           wait for a pin level; here, after X, until the program has ended
    @until position=40     wait for a position
    @drive abort=0         drive a pin to a level, now
    @drive abort=0@12 ms   or at an instant of the run
    @release abort         release a pin now, or at an instant: @release abort@15 ms
    @pulse wait=0 20 us    drive a pin to a level for a time, then release it
    @power off             switch the supply off or on
    @bytes 43 00           send bytes unchanged
    @to y                  address all further commands to chip y on the same bus or line
    @tell shaft slip 20    operate a part; here, make the shaft slip by 20 counts
    @note the door opens   write a line in the transcript

For a chip on a bus (while ASCII/BINARY is low, commands are sent in binary form):

    @reset                 pulse RESET
    @live R 20 | V 0       send commands to a running program, through PROG/LIVE; V 0 reads verify group 0
    @rate 60               change the rate on the fly while the motor slews
    @read position         read the position on the fly, while the motor steps
    @verify 3              read verify group 3

For a module on a serial line:

    @until ready           send F until the answer is no longer B
    @ask V1                send a query, like a line without @

For a chipset that takes packets, a line is a command and its argument, decimal or hexadecimal; the transcript shows the
returned words.  These two directives may also be written without @:

    @wait motion_complete  read the status word of the current axis until this bit is 1; !in_motion: until it is 0
    @expect 0x0300         check the result of the last command; any other result is a finding, and the exit status is 1
"""

from __future__ import annotations

import re
from collections.abc import Iterable
from dataclasses import replace
from typing import TYPE_CHECKING

from ...core.datasheet.channel import row_for
from ...core.messages.near import hint
from ...errors import SlewlineError, UsageError
from ...language.dialect import dialect_of
from ...language.problems import Problem
from ...language.source import commented, host_lines, mended
from .directives import DIRECTIVES, DirectiveKind
from .protocols import SPEECH
from .script_runner import Script, ScriptLine, ScriptRunner, command

if TYPE_CHECKING:
    from ...core.chip import Chip
    from ...core.datasheet.table import Sheet
    from ...parts.hosts.host import Host
    from ..bench import Bench

COPIED = {  # characters printed in manuals, and their ASCII form
    **dict.fromkeys("\u00d8\u00f8\u2205", "write 0 for a slashed zero"),
    **dict.fromkeys("\t\u00a0\u2002\u2003\u2007\u2009\u202f\u3000", "write a space"),
    **dict.fromkeys("\u2010\u2011\u2012\u2013\u2014\u2212", "write -"),
    **dict.fromkeys("\u201c\u201d\u201e\u00ab\u00bb", 'write "'),
    **dict.fromkeys("\u2018\u2019", "write '"),
    **dict.fromkeys("\u200b\u200c\u200d\u2060\ufeff\u00ad", "delete this invisible character"),
    **dict.fromkeys("\u2193\u21b5", "leave out the symbol of the return key"),
}
LONGEST = 1000  # characters of a line; more than any chip takes
EXAMPLES = re.findall(r"^    (@(\w+).*?)  +\S", __doc__ or "", re.MULTILINE)


def _runner(bench: Bench, host: Host, script: Script) -> ScriptRunner:
    return ScriptRunner(bench, host, script, row_for(host.channel, SPEECH, "runs scripts over"))


def run_script(bench: Bench, host: Host, script: Script | str | Iterable[str], where: str = "script") -> None:
    """Queue a script on a host; it runs while time passes, in parallel with the scripts of other hosts.

    Args:
        script: text, lines, or the result of `read_script`.
        where: the name of the script in messages.

    Raises:
        ProgramError: some lines cannot be executed; the `.problems` of the error list all of them.
    """
    if not isinstance(script, Script):
        script = read_script(script if isinstance(script, str) else "\n".join(script), where)
    check_script(bench, host, script)
    bench.kernel.outside.record("script", host=host.name, args=[host.chip.name, script.text, script.where])
    for problem in commented(script.text, host.chip.sheet):
        host.finding("comment", f"{script.where}, line {problem.line}: {problem.found}; {problem.remedy}")
    runner = _runner(bench, host, script)
    following = [*script.steps[1:], None]
    for runner.step, then in zip(script.steps, following, strict=False):
        runner.directed = then is not None and then.directs
        runner.step.queue(runner)


def check_script(bench: Bench, host: Host, script: Script) -> None:
    """Check that a host can execute every line of a script on its bench.

    Raises:
        ProgramError: some lines cannot be executed; the `.problems` of the error list all of them.
    """
    script.refuse(refused(bench, host, script))


def refused(bench: Bench, host: Host, script: Script) -> list[Problem]:
    """Return the problems in a script, including the use of pins and chips that the bench does not have.

    `run` executes no line of a script with problems, and `lint` reports each problem as an error.
    """
    found = list(script.problems)
    runner, chip = _runner(bench, host, script), bench.chips[host.chip.name]
    for step in script.steps:
        if step.to in host.chips:
            chip = bench.chips[step.to]
        elif step.to:
            found.append(step.problem("unknown-chip", f"{host.name} serves {', '.join(host.chips)}, but not {step.to}"))
        found += _no_command(step, chip.sheet, chip.crystal_hz)
        try:
            if step.pin:
                runner.terminal(step.pin, chip)
            if step.fits is not None:
                step.fits(runner, chip)
        except SlewlineError as error:
            found.append(step.problem("unknown-pin" if step.pin else "directive", str(error)))
    return mended(found, script.text)


def _no_command(step: ScriptLine, sheet: Sheet, crystal_hz: int) -> list[Problem]:
    """Return a list with the problem of a script line if no host can send its command; otherwise []."""
    dialect = dialect_of(sheet)
    if step.directs or dialect.directs(step.text):
        return []
    no = dialect.refusal(sheet, step.text, crystal_hz)
    if no is None:
        return []
    place = step.line, step.column + no.at, no.end - no.at
    return [Problem(*place, no.code, "error", no.found, no.allowed, dialect.where, no.remedy)]


# ------------------------------------------------------------------------------------------------------------- reading
def read_script(text: str, where: str = "script") -> Script:
    """Parse the text of a script.  Never raises: errors are in the `problems` of the script."""
    steps, problems = [], []
    for line, column, body in host_lines(text):
        step = ScriptLine(line, column, body, command(body))
        try:
            _plain(step)
            steps.append(_directive(step) if step.directs else _line(step))
        except UsageError as error:
            example = next((example for example, verb in EXAMPLES if verb == step.verb), "")
            remedy = f"write, for example, {example}" if example else ""
            problems.append(step.problem("directive" if step.directs else "line", str(error), remedy))
    return Script(text, where, tuple(steps), tuple(problems))


def _plain(step: ScriptLine) -> None:
    """Check that a line is not too long and, unless it is an @note, that it is printable ASCII."""
    if len(step.text) > LONGEST:
        raise UsageError(f"a line of {len(step.text)} characters; allowed up to {LONGEST}")
    odd = next((c for c in step.text if not " " <= c <= "~"), None)
    if odd is not None and step.verb != "note":
        at = f"{odd!r} at character {step.text.index(odd) + 1}"
        raise UsageError(f"{at} is not printable ASCII; {COPIED.get(odd, '@bytes sends other bytes')}")


def _line(step: ScriptLine) -> ScriptLine:
    """Return a line without @, ready to queue; in some dialects, a word such as `wait` makes it a directive."""
    word = step.text.split()[0].lower()
    if word not in DIRECTIVES:
        return step

    def queue(runner: ScriptRunner) -> None:
        directs = dialect_of(runner.host.chip.sheet).directs(step.text)
        (_reading(word, step.text).queue if directs else step.queue)(runner)

    def fits(runner: ScriptRunner, chip: Chip) -> None:
        if dialect_of(chip.sheet).directs(step.text) and (reading := _reading(word, step.text)).fits is not None:
            reading.fits(runner, chip)

    return replace(step, queue=queue, fits=fits)


def _directive(step: ScriptLine) -> ScriptLine:
    if step.verb not in DIRECTIVES:
        there = " ".join("@" + verb for verb in DIRECTIVES)
        raise UsageError(f"no directive @{step.verb}; available: {there}{hint(step.verb, DIRECTIVES)}")
    queue, pin, fits = _reading(step.verb, step.text[1:])
    return replace(step, queue=queue, pin=pin, fits=fits, to=step.text[3:].strip() if step.verb == "to" else "")


def _reading(verb: str, text: str) -> DirectiveKind:
    """Return the directive that a verb selects; `text` begins with the verb."""
    rest = text[len(verb) :].strip()
    if bool(rest) == (verb == "reset"):
        raise UsageError("@reset takes no argument" if rest else f"@{verb} needs an argument")
    return DIRECTIVES[verb](rest)

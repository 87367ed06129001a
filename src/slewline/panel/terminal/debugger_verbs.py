"""The command line: a line that begins with a colon is for the debugger, any other line is for the chip.

`R 100` goes to the selected chip, as a host would send it; `:break 7` is for the debugger.  `VERBS` has all verbs.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Coroutine, Iterable
from dataclasses import dataclass
from typing import Any

from ...core.messages.near import hint
from ...core.time.timebase import PS_PER_S, picoseconds
from ...errors import UsageError
from .session import RATES, DebugSession

Work = Coroutine[Any, Any, None]
EDGES = ("rises", "falls", "any")
BREAKS = "ADDRESS, pin PIN [EDGE], register NAME [VALUE], position P [AXIS], finding [WHOSE]"
STEPS = ("instruction", "step", "command", "finding")


@dataclass(frozen=True, slots=True)
class Verb:
    """A verb of the debugger."""

    name: str
    takes: str
    description: str
    do: Callable[[DebugSession, list[str]], Work]


def number(text: str, what: str) -> int:
    """Convert a text to a whole number; `what` is the name of that number in the error message."""
    try:
        return int(text, 0)
    except ValueError:
        raise UsageError(f"{what} {text!r}; expected a whole number") from None


def instant(text: str) -> int:
    """Convert a text to an instant in picoseconds; a number without a unit is in seconds."""
    return picoseconds(f"{text} s" if re.fullmatch(r"[0-9]*\.?[0-9]+", text) else text)


def quoted(words: list[str]) -> str:
    """Return the words after a verb as text for an error message: " 'wait 2';", or ":" if there are no words."""
    return f" {' '.join(words)!r};" if words else ":"


async def go(session: DebugSession, words: list[str]) -> None:
    """Let time run, at the given rate; without one, at the present rate."""
    await session.go(rate_of(words[0]) if words else None)


def rate_of(text: str) -> float:
    """Convert a text to a rate, in virtual seconds per second."""
    try:
        found = float(text)
    except ValueError:
        found = 0.0
    if not RATES[0] <= found <= RATES[-1]:
        raise UsageError(f"rate {text!r}; expected virtual seconds per second, {RATES[0]:g} to {RATES[-1]:g}")
    return found


async def pause(session: DebugSession, _words: list[str]) -> None:
    """Pause time."""
    await session.pause()


async def step(session: DebugSession, words: list[str]) -> None:
    """Run to the next event of the given kind; if none is given, to the next instruction."""
    by = words[0] if words else STEPS[0]
    if by not in STEPS:
        raise UsageError(f"step {by!r}; allowed {', '.join(STEPS)}{hint(by, STEPS)}")
    await session.step(by)


async def edge(session: DebugSession, words: list[str]) -> None:
    """Run to the next edge of the named pin, in the given direction or, without one, in any direction."""
    which = words[1] if len(words) > 1 else "any"
    if not words or which not in EDGES:
        raise UsageError(f"edge{quoted(words)} expected a pin, and optionally 'rises', 'falls' or 'any'")
    await session.to_edge(words[0], which)
    session.last_edge = words[0]


async def until(session: DebugSession, words: list[str]) -> None:
    """Run to the instruction at an address."""
    if not words:
        raise UsageError("until: expected the address of an instruction")
    address = number(words[0], "address")
    listed = [row["address"] for row in session.listings.get(session.selected, ())]
    if address not in listed:
        there = f"the first one is at {listed[0]}, the last one at {listed[-1]}" if listed else "no program is stored"
        raise UsageError(f"until: no instruction begins at {address}; {there}")
    await session.to_address(address)


async def time(session: DebugSession, words: list[str]) -> None:
    """Go to an instant, forwards or back; with a sign, the time is relative to the present instant."""
    if not words:
        raise UsageError("time: expected an instant, such as 1.5 s")
    text = " ".join(words)
    if text[0] in "+-":
        await session.to_time(session.now_ps + instant(text[1:].strip()) * (1 if text[0] == "+" else -1))
    else:
        await session.to_time(instant(text))


async def position(session: DebugSession, words: list[str]) -> None:
    """Run to a position, in steps, of the motor on the given axis; without an axis, on the first."""
    if not words:
        raise UsageError("position: expected a position, in steps")
    axis = number(words[1], "axis") if len(words) > 1 else 1
    await session.to_position(number(words[0], "position"), axis)


async def put_break(session: DebugSession, words: list[str]) -> None:
    """Set the breakpoint that the words describe, or remove it if it is set already."""
    point = point_of(session, words)
    await session.toggle(point)
    listed = [row["address"] for row in session.listings.get(session.selected, ())]
    if point in session.breakpoints and not listed and "address" in point:
        session.trouble = f"no program is stored in {session.selected} now; the breakpoint waits for one"
    if point in session.breakpoints and listed and point.get("address", listed[0]) not in listed:
        session.trouble = (
            f"no instruction begins at {point['address']} now; the first one is at {listed[0]}, the last one at "
            f"{listed[-1]}"
        )


def point_of(session: DebugSession, words: list[str]) -> dict[str, Any]:
    """Return the breakpoint that the words after the verb `break` describe."""
    chip, first, rest = session.selected, words[0] if words else "", words[1:]
    if first == "finding":
        return {"finding": rest[0] if rest else ""}
    if first == "position" and rest:
        axis = number(rest[1], "axis") if len(rest) > 1 else 1
        return {"chip": chip, "position": number(rest[0], "position"), "axis": axis}
    if first == "register" and rest:
        value = {"value": number(rest[1], "value")} if len(rest) > 1 else {}
        return {"chip": chip, "register": rest[0], **value}
    if first == "pin" and rest:
        which = rest[1] if len(rest) > 1 else "any"
        if which not in EDGES:
            raise UsageError(f"break: edge {which!r}; allowed {', '.join(map(repr, EDGES))}")
        return {"pin": session.full_pin(rest[0]), "edge": which}
    if first.isdecimal():
        return {"chip": chip, "address": int(first)}
    raise UsageError(f"break{quoted(words)} expected {BREAKS}")


async def clear(session: DebugSession, words: list[str]) -> None:
    """Remove all breakpoints."""
    if words:
        one = f":break {' '.join(words)}"
        raise UsageError(f"clear{quoted(words)} expected no argument; use {one} to remove only that breakpoint")
    await session.put_breakpoints([])


async def rate(session: DebugSession, words: list[str]) -> None:
    """Set the rate at which time runs."""
    if not words:
        raise UsageError("rate: expected virtual seconds per second, such as 0.1")
    session.rate = rate_of(words[0])
    if not session.paused:
        await session.go()


async def drive(session: DebugSession, words: list[str]) -> None:
    """Drive a pin to a level."""
    if len(words) != 2:
        raise UsageError(f"drive{quoted(words)} expected a pin and a level, such as :drive wait 0")
    if words[1] not in ("0", "1"):
        raise UsageError(f"drive: level {words[1]!r}; allowed 0 and 1")
    await session.client.request("drive", pin=session.full_pin(words[0]), level=int(words[1]))


async def release(session: DebugSession, words: list[str]) -> None:
    """Stop driving a pin."""
    if not words:
        raise UsageError("release: expected a pin")
    await session.client.request("release", pin=session.full_pin(words[0]))


async def power(session: DebugSession, words: list[str]) -> None:
    """Switch the supply of the selected chip on or off."""
    if words not in (["on"], ["off"]):
        raise UsageError(f"power{quoted(words)} expected 'on' or 'off'")
    await session.client.request("power", chip=session.selected, on=words == ["on"])


async def act(session: DebugSession, words: list[str]) -> None:
    """Operate a part as a person at the bench would: call one of its verbs, with the given values."""
    if len(words) < 2:
        raise UsageError(f"act{quoted(words)} expected a part and a verb; parts: {', '.join(session.parts) or 'none'}")
    arguments = [int(word) if re.fullmatch(r"[+-]?\d+", word) else word for word in words[2:]]
    await session.client.request("act", part=words[0], verb=words[1], args=arguments)


async def branch(session: DebugSession, words: list[str]) -> None:
    """Go back to the branch with the given number; without a number, show the list of branches."""
    if words:
        await session.client.request("branch", number=number(words[0], "branch"))
        return
    found = await session.client.request("branches")
    shown = (f"{row['number']} from {row['from_ps'] / PS_PER_S:g} s" for row in found["branches"])
    session.trouble = f"branches: {', '.join(shown)}; current {found['current']}"


VERBS = (
    Verb("go", "[RATE]", "let time run, with the wall clock", go),
    Verb("pause", "", "pause time", pause),
    Verb("step", "[instruction|step|command|finding]", "run to the next instruction, step, command or finding", step),
    Verb("edge", "PIN [rises|falls|any]", "run to the next edge of a pin", edge),
    Verb("until", "ADDRESS", "run to an instruction", until),
    Verb("time", "INSTANT", "go to an instant, forwards or back: 1.5, 20 ms, +3 ms, -1 s", time),
    Verb("position", "POSITION [AXIS]", "run to a position of a motor", position),
    Verb(
        "break",
        "ADDRESS | pin PIN [EDGE] | register NAME [VALUE] | position P [AXIS] | finding",
        "set or remove a breakpoint",
        put_break,
    ),
    Verb("clear", "", "remove all breakpoints", clear),
    Verb("rate", "RATE", "set the rate, 0.001 to 1000 virtual seconds per second", rate),
    Verb("drive", "PIN LEVEL", "drive a pin to a level", drive),
    Verb("release", "PIN", "release a pin", release),
    Verb("power", "on|off", "switch the supply of the chip", power),
    Verb("act", "PART VERB [VALUE ...]", "operate a part", act),
    Verb("branch", "[NUMBER]", "return to a branch; alone: list them", branch),
)
BY_NAME = {verb.name: verb for verb in VERBS}


KEYS = {
    "quit": "q leaves the debugger",
    "exit": "q leaves the debugger",
    "help": "? shows the help of the debugger",
    "run": ":go lets time run",
}


async def obey(session: DebugSession, text: str) -> None:
    """Execute a typed line: run a verb of the debugger, or send the line to the selected chip.

    Raises:
        UsageError: there is no such verb, the verb lacks its colon, the words after it are wrong, or the
            server refuses.
    """
    if not text.startswith(":"):
        check_verb(session, text)
        await session.client.request("send", chip=session.selected, text=text)
        if session.paused:
            paused = "can be sent only while time runs, but time is paused"
            session.trouble = f"{text}: {paused}: press Esc, then the space bar"
        return
    name, *words = text[1:].split() or [""]
    verb = BY_NAME.get(name) or only(name)
    if verb is None:
        raise UsageError(f"no verb {name!r}; allowed: {', '.join(BY_NAME)}{hint(name, BY_NAME)}")
    await verb.do(session, words)


def check_verb(session: DebugSession, text: str) -> None:
    """Refuse to send a text that begins with a debugger verb, unless a chip command also begins with that word.

    Raises:
        UsageError: the text is refused.
    """
    word = next(iter(text.lower().split()), "")
    forms = [row["form"].lower().split() for row in session.sheets.get(session.selected, {}).get("commands", ())]
    if (word in BY_NAME or word in KEYS) and not any(word in form[:1] for form in forms):
        message = KEYS.get(word) or f"a verb of the debugger begins with a colon, :{text}"
        raise UsageError(f"{text} is not a command of {session.selected}; {message}")


def only(start: str) -> Verb | None:
    """Return the only verb whose name begins with a text; None if there is none, or more than one."""
    found = [verb for verb in VERBS if start and verb.name.startswith(start)]
    return found[0] if len(found) == 1 else None


# ----------------------------------------------------------------------------------------------------------- completion
def candidates(session: DebugSession, text: str) -> list[str]:
    """Return the possible completions of a line, as whole lines, the most likely first."""
    head, _, word = text.rpartition(" ")
    head += " " if head else ""
    return [head + each for each in words_at(session, text) if each.lower().startswith(word.lower()) and each != word]


def words_at(session: DebugSession, text: str) -> Iterable[str]:
    """Return all words that are allowed in the place of the last word of a line."""
    words = text.split(" ")
    if not text.startswith(":"):
        rows = session.sheets.get(session.selected, {}).get("commands", ())
        return dict.fromkeys(row["form"].split()[0] for row in rows) if len(words) == 1 else ()
    at, verb = len(words) - 1, words[0][1:]
    if at == 0:
        return [f":{name}" for name in BY_NAME]
    pins = [*session.chips.get(session.selected, {}).get("levels", ()), *session.pin_names()]
    choices: dict[tuple[str, int], Iterable[str]] = {
        ("step", 1): STEPS,
        ("edge", 1): pins,
        ("edge", 2): EDGES,
        ("drive", 1): pins,
        ("drive", 2): "01",
        ("release", 1): pins,
        ("power", 1): ("on", "off"),
        ("break", 1): ("pin", "register", "position", "finding"),
        ("act", 1): session.parts,
        ("act", 2): session.parts.get(words[1], {}).get("verbs", ()) if at >= 1 else (),
    }
    if verb == "break" and at == 2:
        registers = [row["name"] for row in session.sheets[session.selected]["registers"]]
        return {"pin": pins, "register": registers, "finding": session.chips}.get(words[1], ())
    return choices.get((verb, at), ())


def explained(session: DebugSession, text: str) -> str:
    """Return one row of help on a typed text: a chip command (from the manual) or verbs; "" if there is none."""
    if text.startswith(":"):
        name = text[1:].partition(" ")[0]
        verb = BY_NAME.get(name) or only(name)
        if verb is not None:
            return f":{verb.name} {verb.takes}  {verb.description}"
        return "  ".join(f":{each}" for each in BY_NAME if each.startswith(name))
    found = of_command(session, text)
    return f"{found['syntax']}  {found['name']}: {found['says']}  ({found['where']})" if found else ""


def of_command(session: DebugSession, text: str) -> dict[str, Any] | None:
    """Return the selected chip's data sheet row for the command at the start of a text; None if there is none.

    The command with the longest matching form is preferred; if no form matches, the first command whose name
    begins with the text is returned.
    """
    rows = session.sheets.get(session.selected, {}).get("commands", ())
    text = text.strip().split("$")[-1]
    best: dict[str, Any] | None = None
    for row in rows:
        head = row["form"].split()[0] if row["form"].split() else row["form"]
        if text and text.upper().startswith(head.upper()) and (best is None or len(head) > len(best["form"])):
            best = row
    return best or next((row for row in rows if text and row["name"].upper().startswith(text.upper())), None)

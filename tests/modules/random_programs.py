"""Programs at random: whatever a part stores, in its memory's size."""

from __future__ import annotations

from random import Random

from slewline.core.datasheet.channel import AdaptiveLine
from slewline.language.dialect import dialect_of

LINES = 40


def program(sheet, seed):
    """A program text without what begins and ends its entry, a line each."""
    random = Random(f"{sheet.part} {seed}")
    if sheet.channel(AdaptiveLine) is not None:
        return [_line(random, sheet) for _ in range(random.randint(1, LINES))]
    rows = [row for row in sheet.commands if row.stored]
    lines, room = [], sheet.buffer_bytes
    for _ in range(random.randint(1, LINES)):
        row = random.choice(rows)
        if row.size > room:
            break
        room -= row.size
        lines.append(dialect_of(sheet).spell(row, [_value(random, arg) for arg in row.args]))
    return lines


def _line(random, sheet):
    """A line of a memory: any command that may stand in a program and does not end it, or a string."""
    row = random.choice([row for row in sheet.commands if row.stored and "n" in row.flow and row.form not in '?"['])
    if random.random() < 0.1:
        return f'"{random.choice(("done", "Q", "a  b", ""))}"'
    values = [0 if arg.name == "target" else _value(random, arg) for arg in row.args]  # a branch leads back
    text = dialect_of(sheet).spell(row, values)
    return f"/{text}" if row.form in dialect_of(sheet).negated and random.random() < 0.2 else text


def _value(random, arg):
    while not arg.allows(value := random.randint(arg.low, arg.high)) or (arg.sign == "alone" and not value):
        pass
    return value


def text(sheet, lines):
    """The lines as a program file; of a part whose memory goes on behind them, with a command that ends them."""
    ends = [sheet.leave[-1].form] if not sheet.leave[-1].may_step else []
    stops = ["0"] if sheet.channel(AdaptiveLine) is not None else []
    return "".join(f"{line}\n" for line in [sheet.enter.form, *lines, *stops, *ends])

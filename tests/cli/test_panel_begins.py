"""When the panel lets time pass from the start, and when it waits for its page."""

from __future__ import annotations

from dataclasses import fields

from slewline.cli.live.panel import PanelCommand
from tests.rows import rows

CHIP = '[[chip]]\npart = "gs-c200s"\nname = "x"\n'
SERVE = '[[serve]]\nchips = ["x"]\ntcp = "127.0.0.1:0"\n'
HOST = '[[host]]\nchips = ["x"]\nscript = {}\n'


@rows(
    ("name", "text", "run", "waits"),
    [
        ("p.cy525", "A 0\n", False, True),
        ("p.cy525", "A 0\n", True, False),
        ("cy525", "", False, False),
        ("script.toml", CHIP + HOST.format('["V1"]'), False, True),
        ("script.toml", CHIP + HOST.format('["V1"]'), True, False),
        ("empty.toml", CHIP + HOST.format("[]"), False, False),
        ("chip.toml", CHIP, False, False),
        ("served.toml", CHIP + SERVE, False, False),
        (
            "both.toml",
            CHIP + SERVE + '[[chip]]\npart = "cy525"\nname = "y"\n' + HOST.format('["A 0"]').replace('"x"', '"y"'),
            False,
            False,
        ),
    ],
)
def test_a_program_waits_and_a_host_on_a_port_does_not(folder, name, text, run, waits):
    if text:
        (folder / name).write_text(text)
    none = dict.fromkeys(field.name for field in fields(PanelCommand) if field.name not in ("file", "has_program"))
    command = PanelCommand(**none | {"what": name, "strap": (), "run": run})
    command.new_bench()
    assert command.begins_paused == waits

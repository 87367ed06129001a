"""Writers: a module for each target that is not one of our parts.

`TARGETS` has their classes as module:Class, loaded when they are asked for.
"""

from __future__ import annotations

from importlib import import_module

from ..target_writer import Target

TARGETS: dict[str, str] = {
    "grbl": "grbl:Grbl",
    "linuxcnc": "linuxcnc:LinuxCNC",
    "klipper": "klipper:Klipper",
    "tmcl": "tmcl:Tmcl",
    "arduino": "arduino:Arduino",
    "python": "host_script:HostScript",
}


def target(name: str) -> Target:
    """Return a target by its name in `TARGETS`."""
    module, _, attribute = TARGETS[name].partition(":")
    found = getattr(import_module(f"{__name__}.{module}"), attribute)()
    assert isinstance(found, Target)  # noqa: S101
    return found

"""Writers: a module for each target that is not one of our parts.

`TARGETS` has their classes as module:Class, loaded when they are asked for.
"""

from __future__ import annotations

from importlib import import_module

from ..target_writer import Target

TARGETS: dict[str, str] = {
    "grbl": "grbl_writer:Grbl",
    "linuxcnc": "linuxcnc_writer:LinuxCNC",
    "klipper": "klipper_writer:Klipper",
    "tmcl": "tmcl_writer:Tmcl",
    "arduino": "arduino:Arduino",
    "python": "host_script:HostScript",
}


def target(name: str) -> Target:
    """Return a target by its name in `TARGETS`."""
    module, _, attribute = TARGETS[name].partition(":")
    found = getattr(import_module(f"{__name__}.{module}"), attribute)()
    assert isinstance(found, Target)  # noqa: S101
    return found

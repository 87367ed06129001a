"""Writers: a module for each target that is not one of our parts, and the table of all such targets."""

from __future__ import annotations

from ..target_writer import Target

REPEATS = (("repeats", "1 or more: number of times that an endless loop is written"),)

TARGETS: dict[str, Target] = {
    target.name: target
    for target in (
        Target(
            "grbl",
            "; ",
            ".nc",
            "grbl 1.1h (wiki and documentation)",
            "grbl_writer:GrblWriter",
            "grbl_reader:read",
            settings=REPEATS,
        ),
        Target(
            "linuxcnc",
            "; ",
            ".ngc",
            "LinuxCNC 2.9 (G-code, M-code and O-code reference)",
            "linuxcnc_writer:LinuxCncWriter",
            "linuxcnc_reader:read",
            "rs274:run",
        ),
        Target(
            "klipper",
            "# ",
            ".cfg",
            "Klipper, G-Codes and Config reference",
            "klipper_writer:KlipperWriter",
            "klipper_reader:read",
        ),
        Target(
            "tmcl", "// ", ".tmc", "TMCM-1290 TMCL firmware manual V1.01", "tmcl_writer:TmclWriter", "tmcl_reader:read"
        ),
        Target(
            "arduino",
            "// ",
            ".ino",
            "Arduino Uno with AccelStepper 1.64 or FastAccelStepper",
            "arduino:SketchWriter",
            "sketch:read",
            settings=(("library", "accelstepper or fastaccelstepper"),),
        ),
        Target(
            "python",
            "# ",
            ".py",
            "Python 3 with pySerial, grbl 1.1h",
            "host_script:ScriptWriter",
            "script_reader:read",
            settings=(("port", "a port, such as /dev/ttyUSB0 or COM3"),),
        ),
    )
}


def target(name: str) -> Target:
    """Return the target with the given name."""
    return TARGETS[name]

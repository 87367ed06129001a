r"""slewline: programmable stepper motor controllers, as software.

import slewline

bench = slewline.Bench()
x = bench.add("cy525")
host = bench.host(x)
host.send("A 0\rN 40\rG\r")
bench.run_until_idle()
print(x.position)
"""

from __future__ import annotations

from .lazy import lazily
from .version import __version__ as __version__

TYPE_CHECKING = False  # without loading `typing`: an interrupt before the command line begins is a traceback
if TYPE_CHECKING:
    from .bench import Bench, load, replay
    from .bench.files.images import read_image, write_image
    from .bench.ramp_calculator import find_ramps, ramp
    from .core.chip import Chip
    from .core.component import Finding
    from .core.motion.axis import Steps
    from .drive.captures.checking import check_capture
    from .drive.motor_drive import Drive
    from .errors import ChecksumError, ProgramError, SlewlineError, Timeout, UsageError, WaveformError, WiringError
    from .parts.motors.laws import motor_law
    from .parts.motors.pull_out import pull_out
    from .record.measuring.compare_edges import compare_edges
    from .record.waveforms.read_vcd import read_vcd
    from .record.waveforms.read_waveforms import read_waveforms
    from .translation.translate import translate
    from .translation.whole_bench import translate_bench
    from .tuning.tune_ramp import tune

_FROM = {  # loaded on first use, so that `import slewline` is quick
    "bench": ("Bench", "load", "replay"),
    "bench.files.images": ("read_image", "write_image"),
    "bench.ramp_calculator": ("find_ramps", "ramp"),
    "core.motion.axis": ("Steps",),
    "core.chip": ("Chip",),
    "core.component": ("Finding",),
    "drive.captures.checking": ("check_capture",),
    "drive.motor_drive": ("Drive",),
    "errors": (
        "ChecksumError",
        "ProgramError",
        "SlewlineError",
        "Timeout",
        "UsageError",
        "WaveformError",
        "WiringError",
    ),
    "parts.motors.laws": ("motor_law",),
    "parts.motors.pull_out": ("pull_out",),
    "record.measuring.compare_edges": ("compare_edges",),
    "record.waveforms.read_vcd": ("read_vcd",),
    "record.waveforms.read_waveforms": ("read_waveforms",),
    "translation.translate": ("translate",),
    "translation.whole_bench": ("translate_bench",),
    "tuning.tune_ramp": ("tune",),
}
__all__ = [
    "Bench",
    "ChecksumError",
    "Chip",
    "Drive",
    "Finding",
    "ProgramError",
    "SlewlineError",
    "Steps",
    "Timeout",
    "UsageError",
    "WaveformError",
    "WiringError",
    "check_capture",
    "compare_edges",
    "find_ramps",
    "load",
    "motor_law",
    "pull_out",
    "ramp",
    "read_image",
    "read_vcd",
    "read_waveforms",
    "replay",
    "translate",
    "translate_bench",
    "tune",
    "write_image",
]


_ON_A_BENCH = 'bench = slewline.Bench(), x = bench.add("PART"), then '
_MEANT = {  # names that do not exist, and what to write instead
    **dict.fromkeys(("bench", "new", "create", "Simulator", "Simulation", "Emulator"), "slewline.Bench()"),
    **dict.fromkeys(("add", "chip", "make", "part", "controller", "Controller"), 'slewline.Bench().add("PART")'),
    **dict.fromkeys(("run", "simulate", "run_until_idle", "start"), f"{_ON_A_BENCH}bench.run_until_idle()"),
    **dict.fromkeys(("host", "send", "Host", "connect"), f"{_ON_A_BENCH}bench.host(x).send(...)"),
    **dict.fromkeys(("open", "Serial", "serial", "port"), 'serial.serial_for_url("slewline://PART"), of pySerial'),
    **dict.fromkeys(
        ("open_bench", "load_bench", "read_bench", "from_file", "from_toml"), 'slewline.load("bench.files.toml")'
    ),
    **dict.fromkeys(("ramps", "Ramp", "calculate"), 'slewline.ramp("PART", ...)'),
    **dict.fromkeys(("plot", "show", "figure"), f'{_ON_A_BENCH}bench.plot("run.svg")'),
    **dict.fromkeys(("serve", "Server"), "slewline serve on the command line"),
}


def _instead(name: str) -> str:
    """Return a hint for a missing name: its replacement, how to add a chip of that name, or a similar name."""
    from .core.messages.near import hint

    if name in _MEANT:
        return f"; write {_MEANT[name]}"
    if any(map(str.isdigit, name)):
        from .chips import CATALOGUE

        for part in CATALOGUE.ours:
            if part.replace("-", "") == name.lower().replace("_", ""):
                return f'; a chip is put on a bench: slewline.Bench().add("{part}")'
    return hint(name, __all__)


__getattr__, __dir__ = lazily(globals(), _FROM, _instead)

"""slewline: programmable stepper motor controllers, as software.

import slewline

bench = slewline.Bench()
x = bench.add("cy525")
host = bench.host(x)
host.send("A 0\\rN 40\\rG\\r")
bench.run_until_idle()
print(x.position)
"""

from __future__ import annotations

from importlib import import_module
from typing import TYPE_CHECKING, Any

from .version import __version__ as __version__

if TYPE_CHECKING:
    from .bench import Bench, load, replay
    from .bench.ramps import find_ramps, ramp
    from .core.axis import Steps
    from .core.chip import Chip, Finding
    from .errors import ChecksumError, ProgramError, SlewlineError, Timeout, UsageError, WaveformError, WiringError
    from .record.compare import compare_edges
    from .record.read_vcd import read_vcd

_WHERE = {  # loaded when first asked for (PEP 562), so that `import slewline` costs nothing
    "Bench": "bench",
    "load": "bench",
    "replay": "bench",
    "ramp": "bench.ramps",
    "find_ramps": "bench.ramps",
    "Chip": "core.chip",
    "Finding": "core.chip",
    "Steps": "core.axis",
    "ChecksumError": "errors",
    "ProgramError": "errors",
    "SlewlineError": "errors",
    "Timeout": "errors",
    "UsageError": "errors",
    "WaveformError": "errors",
    "WiringError": "errors",
    "compare_edges": "record.compare",
    "read_vcd": "record.read_vcd",
}
__all__ = [
    "Bench",
    "ChecksumError",
    "Chip",
    "Finding",
    "ProgramError",
    "SlewlineError",
    "Steps",
    "Timeout",
    "UsageError",
    "WaveformError",
    "WiringError",
    "compare_edges",
    "find_ramps",
    "load",
    "ramp",
    "read_vcd",
    "replay",
]


def __getattr__(name: str) -> Any:
    if name in _WHERE:
        value = getattr(import_module(f"{__name__}.{_WHERE[name]}"), name)
        globals()[name] = value
        return value
    raise AttributeError(f"module {__name__!r} has no attribute {name!r}")


def __dir__() -> list[str]:
    return sorted([*globals(), *__all__])

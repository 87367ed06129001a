"""The packages in each optional extra of slewline, and the message for a user who lacks one of them.

The command in the message installs the packages by their own names.  So the command also works if
slewline was installed from a clone or a wheel, and does not need a package index that contains slewline.
"""

from __future__ import annotations

from itertools import chain

EXTRAS = {  # by extra: packages, each by its names for installation and for import
    "cli": (("click", "click"), ("rich", "rich")),
    "dask": (("distributed", "distributed"),),
    "epics": (("caproto", "caproto"),),
    "files": (("msgspec", "msgspec"),),
    "fast": (("numba", "numba"),),
    "panel": tuple((name, name) for name in ("starlette", "uvicorn", "websockets", "textual")),
    "plot": (("matplotlib", "matplotlib"),),
    "serial": (("pyserial", "serial"),),
    "terminal": (("prompt_toolkit", "prompt_toolkit"),),
    "visa": (("pyvisa", "pyvisa"), ("pyvisa-py", "pyvisa_py")),
}


def lacking() -> dict[str, list[str]]:
    """Return the packages that are not installed, keyed by extra; an extra that is fully installed is left out."""
    from importlib.util import find_spec

    found = {extra: [name for name, module in rows if find_spec(module) is None] for extra, rows in EXTRAS.items()}
    return {extra: names for extra, names in found.items() if names}


def needs(what: str, extra: str) -> str:
    """Return the message that a feature needs an extra, with the command that installs it and all other missing extras.

    `what` is the feature, as the beginning of a sentence: "bench files need".
    """
    lacks = lacking()
    own = lacks.pop(extra, [name for name, _ in EXTRAS[extra]])
    message = f"{what} {' and '.join(own)}: pip install {' '.join(own)}"
    if lacks:
        others = ", ".join(f"{' and '.join(names)} ({other})" for other, names in lacks.items())
        everything = " ".join(chain(own, *lacks.values()))
        message += f"; also missing: {others}; everything together: pip install {everything}"
    return message

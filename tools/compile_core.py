"""The build hook of the compiled build: mypyc makes extension modules of listed source files, for a wheel.

    HATCH_BUILD_HOOK_ENABLE_CUSTOM=true pip install .

It is off by default (pyproject.toml).  All work is done on a copy of the sources, in a folder that is removed: Python
would import an extension module next to its source file in a clone from then on.  mypy only supplies what mypyc
needs; `make check` checks the types.
"""

from __future__ import annotations

import os
import shutil
import subprocess
import sys
import sysconfig
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

from hatchling.builders.hooks.plugin.interface import BuildHookInterface

PACKAGE = "slewline"
CALL = """
from mypyc.build import mypycify
from setuptools import setup

setup(
    name={name!r}, packages=[], ext_modules=mypycify({arguments!r}, opt_level={level!r}, debug_level="0")
)
"""
# The compiled code does not depend on the types of NumPy, which take longer to read than all of slewline's.
SETTINGS = "[mypy]\ncache_dir = {cache}\n[mypy-numpy.*]\nfollow_imports = skip\nfollow_imports_for_stubs = True\n"


class NoCompiler(Exception):
    """A missing C compiler, with the packages to install."""


def find_compiler() -> str:
    """Return the C compiler for extension modules; on Windows setuptools finds it itself.

    Raises:
        NoCompiler: no compiler is installed.
    """
    command = os.environ.get("CC") or sysconfig.get_config_var("CC") or "cc"
    if os.name != "nt" and shutil.which(command.split()[0]) is None:
        raise NoCompiler(
            f"the compiled build needs a C compiler, and there is no {command.split()[0]!r} here; install one, on "
            "Debian with  apt install gcc  (or name another: CC=clang), or stay with the plain build, which needs none"
        )
    return command


def compile_modules(source: Path, modules: list[str], level: str, folder: Path) -> list[Path]:
    """Compile modules of a package, on a copy of it in a folder; return the extension modules, below that folder.

    Args:
        source: the folder of the package.
        modules: paths of its files, relative to that folder.
        level: optimization level, "0" to "3".
    """
    missing = [name for name in modules if not (source / name).is_file()]
    if missing:
        raise FileNotFoundError(f"pyproject.toml names modules to compile that are not there: {', '.join(missing)}")
    find_compiler()
    shutil.copytree(source, folder / PACKAGE, ignore=shutil.ignore_patterns("__pycache__", "*.so", "*.pyd"))
    (folder / "mypy.ini").write_text(SETTINGS.format(cache=folder / "cache"), "utf-8")
    arguments = ["--config-file=mypy.ini", *(f"{PACKAGE}/{name}" for name in modules)]
    (folder / "setup.py").write_text(CALL.format(name=PACKAGE, arguments=arguments, level=level), "utf-8")
    done = subprocess.run(
        [sys.executable, "setup.py", "-q", "build_ext", "--inplace"],
        cwd=folder,
        stdout=subprocess.PIPE,
        stderr=subprocess.STDOUT,
        text=True,
        check=False,
    )
    if done.returncode:
        raise RuntimeError(f"mypyc or the C compiler has failed:\n{done.stdout}")
    shutil.rmtree(folder / "build")
    suffix = sysconfig.get_config_var("EXT_SUFFIX")
    return [path for path in folder.rglob(f"*{suffix}") if path.is_file()]


class CompiledCore(BuildHookInterface):  # type: ignore[type-arg, misc, unused-ignore]
    """Hook that puts extension modules into a wheel, next to their source files."""

    def initialize(self, version: str, build_data: dict[str, Any]) -> None:
        """Compile; an editable installation is always plain Python."""
        if version == "editable":
            return
        self.folder = TemporaryDirectory()
        folder = Path(self.folder.name).resolve()
        source = Path(self.root, "src", PACKAGE)
        for path in compile_modules(source, self.config["modules"], self.config["optimization"], folder):
            build_data["force_include"][str(path)] = path.relative_to(folder).as_posix()
        build_data["infer_tag"] = True
        build_data["pure_python"] = False

    def finalize(self, version: str, build_data: dict[str, Any], artifact_path: str) -> None:
        """Remove the copy."""
        if version != "editable":
            self.folder.cleanup()

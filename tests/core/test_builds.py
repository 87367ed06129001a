"""The plain and the compiled build: what is compiled is listed once, and a run takes all of it from one of them."""

from __future__ import annotations

import tomllib
from importlib import import_module
from pathlib import Path

from slewline.cli.version_line import is_compiled
from slewline.core.time import kernel
from tests.rows import rows

ROOT = Path(__file__).parents[2]
PROJECT = tomllib.loads((ROOT / "pyproject.toml").read_text("utf-8"))
HOOK = PROJECT["tool"]["hatch"]["build"]["targets"]["wheel"]["hooks"]["custom"]
PINS = [
    line.split()[0]
    for line in (ROOT / "requirements" / "compiled.lock").read_text("utf-8").splitlines()
    if "==" in line
]


@rows("path", HOOK["modules"])
def test_a_listed_module_is_loaded_from_the_build_that_runs(path):
    module = import_module(f"slewline.{path.removesuffix('.py').replace('/', '.')}")
    assert is_compiled(module) == is_compiled(kernel)


def test_the_kernel_is_compiled_where_the_compiled_build_is_tested(pytestconfig):
    assert is_compiled(kernel) == pytestconfig.pluginmanager.has_plugin("tests.compiled")


def test_the_plain_build_is_the_default_and_the_compiler_is_pinned():
    assert HOOK["enable-by-default"] is False
    assert set(HOOK["dependencies"]) <= set(PINS)
    dev = (ROOT / "requirements" / "dev.lock").read_text("utf-8")
    assert [pin for pin in PINS if f"{pin} " not in dev] == [pin for pin in PINS if pin.startswith("setuptools=")]

"""What is published: packages, forms for issues, the citation, the command in the container."""

from __future__ import annotations

import importlib.util
import io
import json
import re
import socket
import subprocess
import sys
import tarfile
import zipfile
from email import message_from_bytes

import pytest

from slewline import __version__

from .blocks import ROOT

NAME = f"slewline-{__version__}"


def test_packages_are_the_same_twice_and_whole(tmp_path):
    """One test, since what is looked at takes ten seconds to build."""
    packages = built_twice()
    sdist, wheel = (packages[f"{NAME}{end}"] for end in (".tar.gz", "-py3-none-any.whl"))
    with zipfile.ZipFile(io.BytesIO(wheel)) as files:
        inside = {name: files.read(name) for name in files.namelist()}
    an_index_takes(packages, tmp_path)
    has_all_that_the_source_has(inside)
    has_what_systems_look_for(inside)
    has_a_page_for_an_index(inside[f"{NAME}.dist-info/METADATA"])
    has_tests_and_documentation(sdist)


def built_twice():
    """Wheel and sdist by name."""
    sys.path.insert(0, str(ROOT / "tools"))
    try:
        spec = importlib.util.spec_from_file_location("release", ROOT / "tools/release.py")
        release = importlib.util.module_from_spec(spec)
        spec.loader.exec_module(release)
    finally:
        sys.path.pop(0)
        sys.modules.pop("setup", None)
    return release.built_twice(ROOT)


def an_index_takes(packages, folder):
    for name, data in packages.items():
        (folder / name).write_bytes(data)
    command = [sys.executable, "-m", "twine", "check", "--strict", *sorted(folder.iterdir())]
    checked = subprocess.run(command, capture_output=True, text=True, check=False)
    assert checked.returncode == 0 and checked.stdout.count("PASSED") == 2, checked.stdout


def has_all_that_the_source_has(wheel):
    for top in ("slewline", "pyvisa_slewline"):
        files = [path for path in (ROOT / "src" / top).rglob("*") if path.is_file() and "__pycache__" not in path.parts]
        assert files and not [path for path in files if path.relative_to(ROOT / "src").as_posix() not in wheel]
    assert "slewline/examples/welding_machine.py" in wheel
    assert not [name for name in wheel if re.search(r"\.pyc$|^tests/", name)]


def has_what_systems_look_for(wheel):
    shared = [path.relative_to(ROOT).as_posix() for path in (ROOT / "share").rglob("*") if path.is_file()]
    assert len(shared) == 4
    for name in shared:
        assert wheel[f"{NAME}.data/data/{name}"] == (ROOT / name).read_bytes()
    for name in ("LICENSE", "NOTICE"):
        assert wheel[f"{NAME}.dist-info/licenses/{name}"] == (ROOT / name).read_bytes()


def has_a_page_for_an_index(metadata):
    told = message_from_bytes(metadata)
    assert told.get_payload(decode=True).decode().lstrip().startswith("# slewline")
    assert (told["Version"], told["License-Expression"], told["Requires-Python"]) == (__version__, "MIT", ">=3.11")
    assert told["Metadata-Version"] <= "2.4" and told["Description-Content-Type"] == "text/markdown"


def has_tests_and_documentation(sdist):
    with tarfile.open(fileobj=io.BytesIO(sdist)) as files:
        inside = {name.partition("/")[2] for name in files.getnames()}
        modes = {member.mode for member in files}
    assert {"tests/docs/test_release.py", "docs/index.md", "conformance/cy525/language.toml", "Makefile"} <= inside
    assert modes <= {0o644, 0o755}
    assert not [name for name in inside if name.startswith((".venv/", "build/", "dist/"))]


# -------------------------------------------------------------------------------------------------------------- schemas
@pytest.mark.parametrize(
    ("schema", "files"),
    [
        ("citation-file-format", "CITATION.cff"),
        ("github-workflows", ".github/workflows/*.yml"),
        ("github-issue-forms", ".github/ISSUE_TEMPLATE/[0-9]*.yml"),
        ("github-issue-config", ".github/ISSUE_TEMPLATE/config.yml"),
    ],
)
def test_files_for_other_programs_keep_to_their_schemas(schema, files, tmp_path):
    found = sorted(ROOT.glob(files))
    damaged = tmp_path / found[0].name
    damaged.write_text(found[0].read_text("utf-8") + "\nstrange-key: [1]\n", "utf-8")
    command = [sys.executable, "-m", "check_jsonschema", "--builtin-schema", f"vendor.{schema}"]
    for paths, fails in ((found, 0), ([damaged], 1)):
        ran = subprocess.run([*command, *paths], capture_output=True, text=True, check=False)
        assert ran.returncode == fails, ran.stdout


# ------------------------------------------------------------------------------------------------------------ container
def answered(host):
    """Whether the module says where its motor is; it says nothing while it is being switched on."""
    host.sendall(b"V1\r")
    got = b""
    try:
        while not got.endswith(b"\r"):  # characters come one by one, as on the line
            got += host.recv(100)
    except TimeoutError:
        return False
    return got == b"V+0\r"


def test_the_command_of_the_container_serves_a_module(tmp_path):
    text = (ROOT / "Containerfile").read_text("utf-8")
    words = json.loads(re.search(r"^CMD (.*)$", text, re.MULTILINE)[1])
    words[words.index("0.0.0.0:4001")] = "127.0.0.1:0"  # the port of a test
    words[words.index("/state")] = str(tmp_path)
    server = subprocess.Popen(
        [sys.executable, "-m", "slewline", *words], stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True
    )
    try:
        port = int(re.search(r":(\d+)$", server.stdout.readline().strip())[1])
        with socket.create_connection(("127.0.0.1", port), timeout=1) as host:
            assert any(answered(host) for _ in range(30))
    finally:
        server.terminate()  # as a container is stopped
        server.communicate(timeout=30)
    assert server.returncode == 0

"""What stands about the project in more than one place says the same everywhere: version, parts, packages, checks."""

from __future__ import annotations

import hashlib
import importlib.util
import json
import re
import shlex
import subprocess
import sys
import tomllib
from pathlib import Path

import pytest
import yaml

from slewline import __version__
from slewline.chips import PARTS
from slewline.cli.live.ready_made import FIRMWARE
from tests.sources import SOURCES

ROOT = Path(__file__).parents[2]
SETTINGS = tomllib.loads((ROOT / "pyproject.toml").read_text("utf-8"))
PROJECT, GROUPS = SETTINGS["project"], SETTINGS["dependency-groups"]
CITATION = yaml.safe_load((ROOT / "CITATION.cff").read_text("utf-8"))
README = (ROOT / "README.md").read_text("utf-8")
MAKE = re.compile(r"(?:`|^\$ )(?:[A-Z_]+=\S+ )?make ([a-z][a-z-]*)", re.MULTILINE)  # as code, or typed


def tool(name):
    """A module of tools/, and what it imports from there."""
    sys.path.insert(0, str(ROOT / "tools"))
    try:
        spec = importlib.util.spec_from_file_location(f"tool_{name}", ROOT / "tools" / f"{name}.py")
        module = importlib.util.module_from_spec(spec)
        spec.loader.exec_module(module)
        return module
    finally:
        sys.path.pop(0)
        sys.modules.pop("setup", None)


@pytest.fixture(scope="module")
def release():
    return tool("release")


# ------------------------------------------------------------------------------------------------------------- version
def test_one_file_has_the_version_and_the_others_agree():
    assert "version" in PROJECT["dynamic"] and SETTINGS["tool"]["hatch"]["version"] == {
        "path": "src/slewline/version.py"
    }
    assert CITATION["version"] == __version__
    newest = re.search(r"^## (\S+) \((.*)\)$", (ROOT / "CHANGELOG.md").read_text("utf-8"), re.MULTILINE)
    assert newest[1] == __version__
    released = newest[2] if newest[2] != "not released" else None
    assert str(CITATION.get("date-released")) == str(released)


def test_make_targets_on_a_page_are_tasks():
    tasks = {"help"} | {f"{name}-env" if name in ("run", "dev") else name for name, *_ in tool("setup").TASKS}
    pages = [ROOT / "README.md", ROOT / "CONTRIBUTING.md", *sorted((ROOT / "docs").rglob("*.md"))]
    named = {(task, page.name) for page in pages for task in MAKE.findall(page.read_text("utf-8"))}
    assert {"demo", "dev-env", "test", "check", "boards"} <= {task for task, _ in named}
    assert [(task, page) for task, page in sorted(named) if task not in tasks] == []


def test_names_of_all_parts_are_keywords_and_in_the_notice():
    parts = {part.upper().removesuffix("-E") for part in PARTS}
    assert parts <= {*PROJECT["keywords"]}
    table = " ".join(re.findall(r"^  (.{18})", (ROOT / "NOTICE").read_text("utf-8"), re.MULTILINE))
    assert parts <= {*re.findall(r"[\w-]+", table)}


# -------------------------------------------------------------------------------------------------------------- package
def names(group):
    """What a group brings, with what it includes, as an index spells it."""
    for entry in GROUPS[group]:
        yield from (entry.replace("_", "-"),) if isinstance(entry, str) else names(entry["include-group"])


@pytest.mark.parametrize("group", GROUPS)
def test_packages_of_a_group_are_locked(group):
    lock = (ROOT / f"requirements/{group}.lock").read_text("utf-8")
    assert {*names(group)} <= {*re.findall(r"^([\w-]+)==", lock, re.MULTILINE)}


def test_every_group_has_a_lock_and_every_lock_a_group():
    assert {path.stem for path in (ROOT / "requirements").iterdir()} == {*GROUPS}


def test_developers_have_the_packages_of_the_extras():
    extras = {
        re.split(r"[<>=]", name)[0].replace("_", "-")
        for extra in PROJECT["optional-dependencies"].values()
        for name in extra
    }
    ours = {name for name in extras if not name.startswith("slewline[")}
    assert ours | {"numpy"} <= {*names("dev")}


def test_the_page_on_an_index_has_no_link_that_leads_nowhere():
    absolute = tool("metadata").absolute
    page = absolute(README, "https://host.example/slewline", "1.2")
    targets = re.findall(r"\]\((?!#)([^)\s]+)\)", page)
    assert len(targets) > 50 and all(target.startswith("https://") for target in targets)
    for kind, path in re.findall(r"https://host\.example/slewline/(blob|raw)/v1\.2/([^)#\s]+)", page):
        assert (ROOT / path).is_file() and (kind == "raw") == (Path(path).suffix in (".svg", ".png")), path
    assert absolute("![a](b.svg) [![c](d.png)](e.md#f) [g](#h)", "s", "1") == (
        "![a](s/raw/v1/b.svg) [![c](d.png)](s/blob/v1/e.md#f) [g](#h)"
    )


def test_an_address_of_the_repository_comes_with_its_companions():
    urls = PROJECT.get("urls", {})
    assert set(urls) in (set(), {"Source", "Documentation", "Changelog", "Issues"})
    assert all(url.startswith(urls["Source"]) for url in urls.values())


# -------------------------------------------------------------------------------------------------------------- release
def test_obstacles_to_the_release_of_a_version_are_listed(release, tmp_path, monkeypatch):
    monkeypatch.setattr(release, "__version__", "0.3.0")
    project, changelog = tmp_path / "pyproject.toml", tmp_path / "CHANGELOG.md"
    project.write_text("[project]\n")
    changelog.write_text("## 0.3.0 (not released)\n\n## 0.2.0 (2030-01-31)\n")
    found = release.hindrances(tmp_path, "v0.2.0", "https://host.example/slewline")
    assert [line.split(" ")[0] for line in found] == ["the", "CHANGELOG.md", "Source"]
    project.write_text('[project.urls]\nSource = "https://host.example/slewline"\n')
    changelog.write_text("## 0.3.0 (2030-02-28)\n")
    assert release.hindrances(tmp_path, "v0.3.0", "https://host.example/slewline") == []
    subprocess.run(["git", "init", "-q", tmp_path], check=True)
    (found,) = release.hindrances(tmp_path, "v0.3.0", "https://host.example/slewline")
    assert found.startswith("2 files are not committed")


def test_packages_that_differ_are_not_packages(release, monkeypatch):
    built = iter([{"a.whl": b"1", "a.tar.gz": b"2"}, {"a.whl": b"1", "a.tar.gz": b"3"}])
    monkeypatch.setattr(release, "build", lambda *_: next(built))
    with pytest.raises(SystemExit, match=r"different: a\.tar\.gz"):
        release.built_twice(ROOT)


def test_a_release_has_what_git_knows_and_an_sdist_all_but_what_is_made(release, tmp_path):
    for name in ("a.py", "build/b.py", "c/__pycache__/d.pyc", "c/e.py"):
        (tmp_path / name).parent.mkdir(parents=True, exist_ok=True)
        (tmp_path / name).touch()
    assert release.files(tmp_path) == ["a.py", "c/e.py"]
    subprocess.run(["git", "init", "-q", tmp_path], check=True)
    (tmp_path / ".gitignore").write_text("/build/\n__pycache__/\n/a.py\n")
    assert sorted(release.files(tmp_path)) == [".gitignore", "c/e.py"]


@pytest.mark.system
def test_firmware_is_next_to_the_packages_with_the_licences_of_its_libraries(release, tmp_path, monkeypatch):
    if gone := release.without_compilers():
        pytest.skip(f"{', '.join(gone)}: not installed; make boards does it")
    monkeypatch.setattr(release, "ROOT", tmp_path)
    (tmp_path / "LICENSE").write_text("Permission is hereby granted")
    release.write_firmware(tmp_path / "firmware")
    names = {about.file for about in FIRMWARE.values()}
    assert {path.name for path in (tmp_path / "firmware").iterdir()} == names | {"NOTICES.txt", "SHA256SUMS"}
    text = (tmp_path / "firmware" / "NOTICES.txt").read_text("utf-8")
    for part in ("Permission is hereby granted", "sf_sqrt.c", "Marek Michalkiewicz", "GCC RUNTIME LIBRARY EXCEPTION"):
        assert part.lower() in text.lower(), part
    sums = (tmp_path / "firmware" / "SHA256SUMS").read_text("ascii").split()
    assert dict(zip(sums[1::2], sums[::2], strict=True)) == {
        name: hashlib.sha256((tmp_path / "firmware" / name).read_bytes()).hexdigest() for name in names
    }


def test_firmware_that_differs_is_none(release, monkeypatch, tmp_path):
    built = iter((b"1", b"2"))

    class Made:
        @property
        def path(self):
            file = tmp_path / "x.hex"
            file.write_bytes(next(built))
            return file

    monkeypatch.setattr(release.uno, "build", lambda _folder: Made())
    monkeypatch.setattr(release.pico, "PARTS", {})
    with pytest.raises(SystemExit, match="built twice, and is different"):
        release.built_firmware()


def test_the_workflow_of_a_release_lets_nothing_out_without_a_person():
    flow = yaml.safe_load((ROOT / ".github/workflows/release.yml").read_text("utf-8"))
    assert flow["permissions"] == {} and flow[True] == {"push": {"tags": ["v*"]}}  # YAML reads `on` as true
    holders = [name for name, job in flow["jobs"].items() if job.get("permissions", {}).get("id-token") == "write"]
    assert holders == ["attest", "publish"] and flow["jobs"]["publish"]["environment"]["name"] == "release"
    checked_out = [name for name, job in flow["jobs"].items() if "checkout" in json.dumps(job)]
    assert checked_out == ["build", "test"]  # what runs code of the repository can sign nothing
    uploads = [name for name, job in flow["jobs"].items() if "upload-artifact" in json.dumps(job)]
    tests = [name for name, job in flow["jobs"].items() if "make test" in json.dumps(job)]
    assert (uploads, tests) == (["build"], ["test"])  # packages of others never run beside what is uploaded
    assert flow["jobs"]["attest"]["needs"] == ["build", "test"]
    writers = [name for name, job in flow["jobs"].items() if job.get("permissions", {}).get("contents") == "write"]
    assert writers == ["files"] and flow["jobs"]["files"]["environment"]["name"] == "release"
    for path in (ROOT / ".github/workflows").iterdir():
        used = re.findall(r"uses: (\S+)", path.read_text("utf-8"))
        assert used and all(re.fullmatch(r"[\w/-]+@[0-9a-f]{40}", action) for action in used), path.name


# --------------------------------------------------------------------------------------------------------------- checks
def test_hooks_before_a_commit_are_the_first_checks():
    (repo,) = yaml.safe_load((ROOT / ".pre-commit-config.yaml").read_text("utf-8"))["repos"]
    assert repo["repo"] == "local" and {hook["language"] for hook in repo["hooks"]} == {"system"}
    hooks = [shlex.split(hook["entry"])[1:] for hook in repo["hooks"]]
    assert hooks == tool("setup").check("")[: len(hooks)]


def test_every_layer_has_an_exhaustive_contract():
    contracts = SETTINGS["tool"]["importlinter"]["contracts"]
    layered = [contract for contract in contracts if contract["type"] == "layers"]
    assert all(contract["exhaustive"] for contract in layered)
    held = {container for contract in layered for container in contract["containers"]}
    layers = re.findall(r"\w+", " ".join(layered[0]["layers"]))
    packages = [name for name in layers if (SOURCES / "slewline" / name / "__init__.py").is_file()]
    assert not [name for name in packages if f"slewline.{name}" not in held]


def test_a_container_gets_its_copied_files_and_an_existing_command():
    from slewline.cli.commands import cli

    text = (ROOT / "Containerfile").read_text("utf-8")
    ignored = (ROOT / ".dockerignore").read_text("utf-8").splitlines()
    let_in = [line[1:] for line in ignored if line.startswith("!")]
    assert all((ROOT / name).exists() for name in let_in)
    needed = {"pyproject.toml", "README.md", "LICENSE", "NOTICE", "requirements", "tools", "src"}
    wheel = SETTINGS["tool"]["hatch"]["build"]["targets"]["wheel"]
    copied = {*needed, *wheel["force-include"], *wheel["shared-data"]}
    assert not [path for path in copied if not any(f"{path}/".startswith(f"{name}/") for name in let_in)]
    (entry,) = re.findall(r"^ENTRYPOINT (.*)$", text, re.MULTILINE)
    (words,) = re.findall(r"^CMD (.*)$", text, re.MULTILINE)
    name, *arguments = json.loads(words)
    assert json.loads(entry) == ["slewline"]
    context = cli.commands[name].make_context(name, arguments)
    assert (context.params["tcp"], context.params["allow_remote"]) == ("0.0.0.0:4001", True)

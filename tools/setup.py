"""Set up slewline, and run its tasks: `python tools/setup.py demo`, `test`, `check` ...; without one they are listed.

Only the standard library, and only syntax that Python 2.7 can parse: an old Python must reach the message that names
the version to install.
"""

import hashlib
import json
import os
import shutil
import subprocess
import sys
import tempfile

OLDEST = (3, 11)
ROOT = os.path.dirname(os.path.dirname(os.path.abspath(__file__)))
WINDOWS = os.name == "nt"
AGAIN = "py -3.12 tools/setup.py demo" if WINDOWS else "PYTHON=python3.12 make demo"


class SetupError(Exception):
    """An error, with its remedy."""


def say(text):
    sys.stderr.write("setup: %s\n" % text)
    sys.stderr.flush()


def digest(*parts):
    return hashlib.sha256("\0".join(parts).encode("utf-8")).hexdigest()


# ------------------------------------------------------------------------------------------------------------- places
def is_writable(folder):
    """Return whether a folder can be written to, by trying: permissions and mounts are reported in different forms."""
    try:
        os.rmdir(tempfile.mkdtemp(prefix=".setup-", dir=folder))
    except OSError:
        return False
    return True


def workplace():
    """Return the folder for .venv and build products: the checkout or, if it is read-only, a folder of the user."""
    if is_writable(ROOT):
        return ROOT
    caches = os.environ.get("LOCALAPPDATA" if WINDOWS else "XDG_CACHE_HOME")
    caches = caches or os.path.join(os.path.expanduser("~"), ".cache")
    place = os.path.join(caches, "slewline", digest(ROOT)[:12])
    if not os.path.isdir(place):
        try:
            os.makedirs(place)
        except OSError as error:
            raise SetupError(
                "%s cannot be written, and neither can %s (%s);\n"
                "  name a folder for the environment:  XDG_CACHE_HOME=/some/folder" % (ROOT, place, error.strerror)
            )
    say("this checkout is read-only; the environment and build products go to %s" % place)
    return place


def in_venv(work, *names):
    return os.path.join(work, ".venv", "Scripts" if WINDOWS else "bin", *names)


def python_of(work):
    return in_venv(work, "python.exe" if WINDOWS else "python")


def read(*path):
    with open(os.path.join(ROOT, *path), "rb") as source:
        return source.read().decode("utf-8")


# -------------------------------------------------------------------------------------------------------------- tools
def check_version(version):
    if tuple(version[:2]) < OLDEST:
        raise SetupError(
            "slewline needs Python %d.%d or newer; this is Python %s (%s).\n"
            "  Install a newer one, e.g. on Debian:  apt install python3.11 python3.11-venv\n"
            "  or name one you already have:         %s"
            % (OLDEST + (".".join(str(part) for part in version[:3]), sys.executable, AGAIN))
        )


def find_maker():
    """Return the tool that creates environments and installs packages here: "venv", or else "uv" or "virtualenv"."""
    try:
        import ensurepip  # noqa: F401
    except ImportError:
        pass
    else:
        return "venv"
    for tool in ("uv", "virtualenv"):
        if shutil.which(tool):
            say("Python has no ensurepip here; %s takes its place" % tool)
            return tool
    found = "%d.%d" % tuple(sys.version_info[:2])
    raise SetupError(
        "Python %s (%s) cannot put pip into a virtual environment:\n"
        "  its module `ensurepip` is missing, which Debian and Ubuntu package separately.\n"
        "  Install it:  apt install python3-venv  (or python%s-venv, if %s is not the default python3)\n"
        "  or have `uv` or `virtualenv` where programs are found (PATH); neither is there."
        % (found, sys.executable, found, found)
    )


def run(command, failure, **more):
    if subprocess.call(command, cwd=ROOT, **more) != 0:
        raise SetupError(failure)


def create_venv(work, maker):
    say("creating .venv with Python %d.%d" % tuple(sys.version_info[:2]))
    # The base interpreter, because --clear may be about to delete the one that runs this.
    python = sys._base_executable
    command = {
        "venv": [python, "-I", "-m", "venv", "--clear"],
        "uv": ["uv", "venv", "--quiet", "--no-python-downloads", "--python", python],
        "virtualenv": ["virtualenv", "--quiet", "--clear", "--python", python],
    }[maker]
    cleared = dict(os.environ, UV_VENV_CLEAR="1")  # an old uv clears it anyway, and has no option for it
    run(command + [os.path.join(work, ".venv")], "could not create .venv; the reason is above.", env=cleared)


def install(work, maker, arguments, failure, **more):
    if maker == "uv":
        command = ["uv", "pip", "install", "--quiet", "--python", python_of(work)]
    else:
        # -I: a PYTHONPATH meant for another project must not reach into this environment.
        # -qq: pip still reports errors, but not each index or link it passes over.
        command = [python_of(work), "-I", "-m", "pip", "install", "-qq", "--disable-pip-version-check", "--no-input"]
    run(command + arguments, failure, **more)


def install_lock(work, maker, name):
    say("installing requirements/%s.lock (the first time takes a minute)" % name)
    # Wheels only: a build from source would fetch build tools that no hash in the lock covers.
    install(
        work,
        maker,
        ["--only-binary=:all:", "--require-hashes", "-r", os.path.join("requirements", name + ".lock")],
        "could not install requirements/%s.lock; the reason is above.\n"
        "  No network?    Connect and repeat the command; finished steps are kept.\n"
        "  On a mirror?   Point pip at it (PIP_INDEX_URL, or pip.conf; uv: UV_INDEX_URL); the hashes hold there too.\n"
        "  No wheel?      Choose another Python, e.g. %s" % (name, AGAIN),
    )


def install_project(work, maker):
    say("installing slewline (editable)")
    install(
        work,
        maker,
        ["--no-deps", "--no-build-isolation", "-e", "."],
        "could not install slewline itself; the reason is above. This step needs no network.",
    )


def sources():
    """Return every source file of the compiled build."""
    found = [os.path.join("tools", "compile_core.py")]
    for folder, inside, files in os.walk(os.path.join(ROOT, "src")):
        inside[:] = sorted(name for name in inside if name != "__pycache__")
        found += [os.path.relpath(os.path.join(folder, name), ROOT) for name in sorted(files)]
    return found


def compile_core(work, maker):
    say("building the compiled core into build/compiled (a minute)")
    target = os.path.join(work, "build", "compiled")
    shutil.rmtree(target, ignore_errors=True)
    install(
        work,
        maker,
        ["--no-deps", "--no-build-isolation", "--target", target, "."],
        "could not build the compiled core; the reason is above. The plain build needs no compiler: make test",
        env=dict(os.environ, HATCH_BUILD_HOOK_ENABLE_CUSTOM="true"),
    )


def packaging_metadata():
    """Return the part of pyproject.toml that affects an installation, without the settings of tools."""
    import tomllib  # only a new Python has it

    settings = tomllib.loads(read("pyproject.toml"))
    parts = [settings["build-system"], settings["project"], settings["tool"]["hatch"]]
    return json.dumps(parts, sort_keys=True) + read("src", "slewline", "version.py")


# -------------------------------------------------------------------------------------------------------------- steps
def stamp_path(work, name):
    return os.path.join(work, ".venv", "stamp-" + name)


def is_done(work, name, key):
    try:
        with open(stamp_path(work, name)) as stamp:
            return stamp.read() == key
    except OSError:
        return False


def step(work, name, key, action):
    """Run `action` unless its stamp has this `key`. A failure leaves no stamp."""
    # Without its interpreter (the system's Python was replaced) an environment is not done, whatever it says.
    if is_done(work, name, key) and os.path.exists(python_of(work)):
        return
    stamp = stamp_path(work, name)
    if os.path.exists(stamp):
        os.remove(stamp)
    action()
    # Written aside and renamed: an interrupted write must not look like a stamp.
    with open(stamp + ".new", "w") as new:
        new.write(key)
    os.rename(stamp + ".new", stamp)


def set_up(work, name):
    # The path is in the key because an environment stops working when the checkout moves.
    maker = find_maker()
    base = digest(ROOT, "%d.%d" % tuple(sys.version_info[:2]), *([] if maker == "venv" else [maker]))
    locks = dict((lock, digest(base, read("requirements", lock + ".lock"))) for lock in ("run", "dev", "compiled"))

    step(work, "venv", base, lambda: create_venv(work, maker))
    # dev.lock contains run.lock, so a complete dev environment serves the demo as well.
    needed = ["dev", "compiled"] if name == "compiled" else [name]
    for each in needed:
        if not (each == "run" and is_done(work, "dev", locks["dev"])):
            step(work, each, locks[each], lambda each=each: install_lock(work, maker, each))
    step(work, "project", digest(base, packaging_metadata()), lambda: install_project(work, maker))
    if name == "compiled":
        key = digest(locks[name], packaging_metadata(), *[read(path) for path in sources()])
        step(work, "core", key, lambda: compile_core(work, maker))


def lock(file):
    """Wait until no other setup of this checkout runs; the system drops the lock if the setup is killed."""
    try:
        import fcntl
    except ImportError:
        import msvcrt

        file.seek(1 << 30)  # far after the end, so no reader is blocked
        while True:
            try:
                msvcrt.locking(file.fileno(), msvcrt.LK_LOCK, 1)  # tries for ten seconds
                return
            except OSError:
                pass
    try:
        fcntl.flock(file, fcntl.LOCK_EX)
    except OSError as error:
        say("no lock is available (%s); do not start two of these at the same time" % error.strerror)


# -------------------------------------------------------------------------------------------------------------- tasks
def bytecode(work):
    """Return an environment that keeps compiled bytecode, because tests start Python some hundred times."""
    kept = dict(os.environ, PYTHONPYCACHEPREFIX=os.path.join(work, "build", "bytecode"))
    kept["SLEWLINE_CACHE"] = os.path.join(work, "build", "machine_code")
    kept.pop("PYTHONDONTWRITEBYTECODE", None)
    if work != ROOT:
        kept["HYPOTHESIS_STORAGE_DIRECTORY"] = os.path.join(work, ".hypothesis")
        kept["SLEWLINE_BOARDS"] = os.path.join(work, "build", "boards")
        kept["SLEWLINE_CLIENTS"] = os.path.join(work, "build", "clients")
        kept["SLEWLINE_INTERPRETERS"] = os.path.join(work, "build", "interpreters")
    return kept


def tests(work, *more):
    kept = [] if work == ROOT else ["-p", "no:cacheprovider"]
    return [["-m", "pytest", "-n", "2", "--dist", "worksteal"] + kept + list(more)]


def waiting_tests(work, *more):  # while some wait, others compute
    return tests(work, "-n", "6", *more)


def compiled_tests(work, *more):
    return tests(work, "-p", "tests.compiled", *more)


def check(work):
    return [
        ["-m", "ruff", "check"],
        ["-m", "ruff", "format", "--check"],
        ["-m", "mypy"],
        ["-c", "from importlinter.cli import lint_imports_command; lint_imports_command()"],
        ["tools/conformance.py", "--check"],
        ["tools/describe_docs.py", "--check"],
        ["tools/stubs.py", "--check"],
        ["tools/share.py", "--check"],
        [os.path.join("tools", "page", "check.py"), os.path.join(work, "build", "page")],
    ] + waiting_tests(work, "-m", "check and not long")


# name, environment, what it does, the calls of Python
TASKS = (
    ("run", "run", "Set up the environment of the demo", lambda work: []),
    ("dev", "dev", "Set up the environment of the tests", lambda work: []),
    (
        "demo",
        "run",
        "Set up and run the demo",
        lambda work: [
            ["-m", "slewline", "demo"] + ([] if work == ROOT else ["-o", os.path.join(work, "build", "demo")])
        ],
    ),
    ("test", "dev", "Run the tests that need no other process, terminal or real time", tests),
    (
        "test-system",
        "dev",
        "Run the tests with processes, terminals, sockets and real time",
        lambda work: waiting_tests(work, "-m", "system and not check and not long"),
    ),
    (
        "test-anywhere",
        "dev",
        "Run both in difficult surroundings: another user, odd variables, no network, busy processors",
        lambda work: [["tools/anywhere.py"]],
    ),
    (
        "test-compiled",
        "compiled",
        "Run the tests of the core and the laws over the compiled build",
        lambda work: compiled_tests(work, "tests/core", "tests/laws"),
    ),
    (
        "test-long",
        "compiled",
        "Run the long tests, and all tests over the compiled build",
        lambda work: waiting_tests(work, "-m", "long") + compiled_tests(work, "-m", "not check", "-n", "6"),
    ),
    (
        "boards",
        "run",
        "Install the tools for building and testing the firmware of boards, and build it",
        lambda work: [["tools/boards.py", os.path.join(work, "build", "boards")]],
    ),
    (
        "clients",
        "run",
        "Install the EPICS clients for the tests of the motor record",
        lambda work: [["tools/clients.py", os.path.join(work, "build", "clients")]],
    ),
    (
        "interpreters",
        "run",
        "Unpack the interpreters of other controllers that run translated programs",
        lambda work: [["tools/interpreters.py", os.path.join(work, "build", "interpreters")]],
    ),
    (
        "firmware",
        "run",
        "Build the firmware of boards into build/firmware",
        lambda work: [
            [tool, os.path.join(work, "build", "firmware")] for tool in ("tools/firmware.py", "tools/pico.py")
        ],
    ),
    (
        "physics",
        "dev",
        "Print the table of the physics of motors: value, expected, tolerance",
        lambda work: [["-m", "tests.physics"]],
    ),
    ("check", "dev", "Check style, types, imports, conformance table and documentation", check),
    ("conformance", "dev", "Write the conformance table", lambda work: [["tools/conformance.py"]]),
    (
        "mutations",
        "dev",
        "Deliberately break the source, and check that a test fails",
        lambda work: [["tools/mutations.py"]],
    ),
    (
        "bench",
        "dev",
        "Measure the speed, and write the page about it",
        lambda work: [["benchmarks/run.py", "--long", "--page", "docs/reference/performance.md"]],
    ),
    (
        "docs",
        "dev",
        "Build the documentation into build/docs",
        lambda work: [["-m", "sphinx", "-W", "docs", os.path.join(work, "build", "docs")]],
    ),
    ("dist", "dev", "Build wheel and sdist into dist, twice, and compare", lambda work: [["tools/release.py"]]),
    ("compiled", "compiled", "Build the compiled core into build/compiled", lambda work: []),
    ("clean", None, "Remove .venv, build products and caches", None),
)
CALLS = dict((task[0], task[3]) for task in TASKS)
MADE = (".venv", "build", "dist", ".coverage", ".hypothesis", ".import_linter_cache", ".mypy_cache")
MADE += (".pytest_cache", ".ruff_cache")


def clean(work):
    for name in MADE:
        path = os.path.join(work, name)
        if os.path.isdir(path):
            shutil.rmtree(path, ignore_errors=True)
        elif os.path.exists(path):
            os.remove(path)
    for part in ("src", "tests", "tools", "benchmarks", "docs"):
        for folder, inside, _files in os.walk(os.path.join(work, part)):
            if "__pycache__" in inside:
                shutil.rmtree(os.path.join(folder, "__pycache__"), ignore_errors=True)


def perform(task, more):
    _name, environment, _what, calls = task
    work = workplace()
    if environment is None:
        clean(work)
        return 0
    # One setup at a time: `make demo` and `make test` may start together. Locking this very file needs no lock file to
    # tidy up, and no right to write.
    with open(os.path.join(ROOT, "tools", "setup.py"), "rb") as file:
        lock(file)
        set_up(work, environment)
    commands = [[python_of(work)] + call for call in calls(work)]
    for command in commands[:-1]:
        if subprocess.call(command, cwd=ROOT, env=bytecode(work)) != 0:
            return 1
    return subprocess.call(commands[-1] + more, cwd=ROOT, env=bytecode(work)) if commands else 0


def main(arguments):
    tasks = dict((task[0], task) for task in TASKS)
    if not arguments or arguments[0] not in tasks:
        sys.stderr.write("usage: python tools/setup.py TASK [ARGUMENT]...\n")
        for name, _environment, what, _calls in TASKS:
            sys.stderr.write("  %-12s %s\n" % (name, what))
        return 2
    try:
        check_version(sys.version_info)
        return perform(tasks[arguments[0]], list(arguments[1:]))
    except SetupError as error:
        say(error)
        return 1


if __name__ == "__main__":
    try:
        sys.exit(main(sys.argv[1:]))
    except KeyboardInterrupt:
        sys.exit(130)

"""Make .venv ready: `python3 tools/setup.py run` (for the demo) or `dev` (for tests, checks, docs).

Only the standard library, and only syntax that Python 2.7 can parse: an old Python must get as far
as the message that says which one to install.
"""

import hashlib
import json
import os
import subprocess
import sys

OLDEST = (3, 11)
ROOT = os.path.dirname(os.path.dirname(os.path.abspath(__file__)))
VENV = os.path.join(ROOT, ".venv")
VENV_PYTHON = os.path.join(VENV, "bin", "python")


class SetupError(Exception):
    """What went wrong, and what to do about it."""


def check_version(version):
    if tuple(version[:2]) < OLDEST:
        raise SetupError(
            "slewline needs Python %d.%d or newer; this is Python %s (%s).\n"
            "  Install a newer one, e.g. on Debian:  apt install python3.11 python3.11-venv\n"
            "  or name one you already have:         PYTHON=python3.12 make demo"
            % (OLDEST + (".".join(str(part) for part in version[:3]), sys.executable))
        )


def check_ensurepip():
    try:
        import ensurepip  # noqa: F401
    except ImportError:
        found = "%d.%d" % tuple(sys.version_info[:2])
        raise SetupError(
            "Python %s (%s) cannot put pip into a virtual environment:\n"
            "  its module `ensurepip` is missing, which Debian and Ubuntu package separately.\n"
            "  Install it:  apt install python3-venv  (or python%s-venv, if %s is not the default python3)"
            % (found, sys.executable, found, found)
        )


def say(text):
    sys.stderr.write("setup: %s\n" % text)
    sys.stderr.flush()


def run(command, failure):
    if subprocess.call(command, cwd=ROOT) != 0:
        raise SetupError(failure)


def pip_install(arguments, failure):
    # -I: a PYTHONPATH meant for another project must not reach into this environment.
    # -qq: pip still reports errors, but not each index or link it passes over.
    pip = [VENV_PYTHON, "-I", "-m", "pip", "install", "-qq", "--disable-pip-version-check", "--no-input"]
    run(pip + arguments, failure)


def create_venv():
    say("creating .venv with Python %d.%d" % tuple(sys.version_info[:2]))
    # The base interpreter, because --clear may be about to delete the one that runs this.
    run([sys._base_executable, "-I", "-m", "venv", "--clear", VENV], "could not create .venv; the reason is above.")


def install_lock(name):
    say("installing requirements/%s.lock (the first time takes a minute)" % name)
    # Wheels only: a build from source would fetch build tools that no hash in the lock covers.
    pip_install(
        ["--only-binary=:all:", "--require-hashes", "-r", os.path.join("requirements", name + ".lock")],
        "could not install requirements/%s.lock; pip's reason is above.\n"
        "  No network?    Connect and repeat the command; finished steps are kept.\n"
        "  On a mirror?   Point pip at it (PIP_INDEX_URL, or pip.conf); the hashes hold there too.\n"
        "  No wheel?      Choose another Python, e.g. PYTHON=python3.12 make demo" % name,
    )


def install_project():
    say("installing slewline (editable)")
    pip_install(
        ["--no-deps", "--no-build-isolation", "-e", "."],
        "could not install slewline itself; pip's reason is above. This step needs no network.",
    )


def digest(*parts):
    return hashlib.sha256("\0".join(parts).encode("utf-8")).hexdigest()


def read(*path):
    with open(os.path.join(ROOT, *path), "rb") as source:
        return source.read().decode("utf-8")


def packaging_metadata():
    """The part of pyproject.toml that an installation depends on: tool settings do not call for a new one."""
    import tomllib  # only a new Python has it

    settings = tomllib.loads(read("pyproject.toml"))
    parts = [settings["build-system"], settings["project"], settings["tool"]["hatch"]]
    return json.dumps(parts, sort_keys=True)


def stamp_path(name):
    return os.path.join(VENV, "stamp-" + name)


def is_done(name, key):
    try:
        with open(stamp_path(name)) as stamp:
            return stamp.read() == key
    except OSError:
        return False


def step(name, key, action):
    """Do `action` unless its stamp says it was done for this `key`. A failure leaves no stamp."""
    # Without its interpreter (the system's Python was replaced) an environment is not done, whatever it says.
    if is_done(name, key) and os.path.exists(VENV_PYTHON):
        return
    if os.path.exists(stamp_path(name)):
        os.remove(stamp_path(name))
    action()
    # Written aside and renamed: an interrupted write must not look like a stamp.
    with open(stamp_path(name) + ".new", "w") as stamp:
        stamp.write(key)
    os.rename(stamp_path(name) + ".new", stamp_path(name))


def set_up(name):
    # The path is in the key because an environment stops working when the checkout moves.
    base = digest(ROOT, "%d.%d" % tuple(sys.version_info[:2]))
    locks = dict((lock, digest(base, read("requirements", lock + ".lock"))) for lock in ("run", "dev"))

    step("venv", base, create_venv)
    # dev.lock contains run.lock, so a complete dev environment serves the demo as well.
    if not (name == "run" and is_done("dev", locks["dev"])):
        step(name, locks[name], lambda: install_lock(name))
    step("project", digest(base, packaging_metadata()), install_project)


def main(arguments):
    if len(arguments) != 1 or arguments[0] not in ("run", "dev"):
        sys.stderr.write("usage: python3 tools/setup.py run|dev\n")
        return 2
    try:
        check_version(sys.version_info)
        check_ensurepip()
        import fcntl

        # One setup at a time: `make demo` and `make test` may start together. Locking this very file
        # needs no lock file to tidy up, and the system drops the lock if the setup is killed.
        with open(os.path.join(ROOT, "tools", "setup.py"), "r+b") as lock:
            fcntl.flock(lock, fcntl.LOCK_EX)
            set_up(arguments[0])
    except SetupError as error:
        say(error)
        return 1
    return 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))

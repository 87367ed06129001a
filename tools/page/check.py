"""Check the types of our scripts with the TypeScript compiler, which npm installs: tools/page/check.py FOLDER.

They are those of the panel's page, and those of the documentation.

The compiler goes to FOLDER, which may be left out.  Where there is no npm, nothing is checked, and a line says so.
"""

import shutil
import subprocess
import sys
from pathlib import Path

HERE = Path(__file__).resolve().parent
NEEDED = ("package.json", "package-lock.json")


def main(arguments):
    """Check the types of the scripts of the panel and of the pages; return the exit status."""
    place = Path(arguments[0] if arguments else HERE.parent.parent / "build" / "page")
    npm, node = shutil.which("npm"), shutil.which("node")
    if npm is None or node is None:
        print("page: npm is not here, so the types of our scripts are not checked; on Debian:  apt install npm")
        return 0
    compiler = place / "node_modules" / "typescript" / "bin" / "tsc"
    if not compiler.exists() or any(not same(HERE / name, place / name) for name in NEEDED):
        place.mkdir(parents=True, exist_ok=True)
        for name in NEEDED:
            shutil.copyfile(HERE / name, place / name)
        if subprocess.call([npm, "ci", "--no-audit", "--no-fund", "--silent"], cwd=place) != 0:
            print("page: npm could not install the TypeScript compiler; the reason is above")
            return 1
    return subprocess.call([node, str(compiler), "-p", str(HERE / "jsconfig.json")])


def same(one, other):
    """Return whether two files have the same bytes; a file that does not exist has none."""
    return other.exists() and one.read_bytes() == other.read_bytes()


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))

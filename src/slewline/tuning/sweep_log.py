"""The log of a sweep: JSON, one line per judged run, written immediately.  A killed sweep can be resumed from it.

    {"tune": 1, "digest": "5c0f...", "slewline": "0.1.0", "task": {...}}
    {"move": "9a1e...", "values": {"F": 3, ...}, "run": "nominal, forward", "lost": false, "error": 0.02, "worst": 1.4}

A last line without a line end, which was being written when the process was killed, is cut off.  A sweep
locks its log, so that no other sweep can write to it.
"""

from __future__ import annotations

import json
from collections.abc import Iterator, Mapping
from hashlib import blake2b
from io import BufferedReader, FileIO
from pathlib import Path
from typing import Any, BinaryIO, cast

from ..errors import BenchFileError, UsageError
from ..gate import from_json, lines_of
from ..locks import lock
from ..version import __version__
from .judging import Verdict

VERSION = 1
FIRST = b'{"tune":'  # as it begins
SHORT = 120  # characters of a value in a message
_ABSENT = "missing"


def digest(task: Mapping[str, Any]) -> str:
    """Return a digest of a task together with the version of slewline."""
    text = json.dumps([VERSION, __version__, task], sort_keys=True)
    return blake2b(text.encode(), digest_size=16).hexdigest()


def interrupted(log: Log | None, here: int, most: int | None) -> str:
    """Return the message for an interrupted search: the number of runs kept or lost, and how to resume.

    Args:
        here: the number of runs judged since the start of this session.
        most: the maximum number of runs in the whole search; None if they have not been counted yet.
    """
    of = "" if most is None else f" of up to {most:,}"
    if log is None:
        return (
            f"interrupted after {here:,}{of} runs, which are lost; with --store F.jsonl (store=) every run is kept, "
            "and the same command resumes from there"
        )
    return f"interrupted; {log.path} has {log.runs:,}{of} runs: run the same command again to continue"


class Log:
    """The log in a file: a new log is begun; an existing log of the same task is continued.

    Args:
        task: all data on which verdicts depend, for JSON.

    Raises:
        UsageError: the file is not a log, is the log of another task, is in use by another sweep, or cannot
            be read or written.
    """

    def __init__(self, path: str | Path, task: Mapping[str, Any]) -> None:
        self.path = Path(path)
        self.verdicts: dict[tuple[str, str], Verdict] = {}
        if not self.path.parent.is_dir():
            raise UsageError(f"{path}: no directory {str(self.path.parent)!r}; create it, or name another file")
        if self.path.exists() and not self.path.is_file():
            raise UsageError(f"{path} is not a file; name a writable file, such as tune.jsonl")
        try:
            self._file: BinaryIO = open(path, "a+b", buffering=0)  # noqa: SIM115
        except OSError as error:
            raise self._refused(error) from None
        try:
            self._begin(json.loads(json.dumps(task)))
        except BaseException:
            self.close()
            raise

    def _begin(self, task: Mapping[str, Any]) -> None:
        """Read the existing lines, and write the first line of a new log."""
        path = self.path
        if not lock(self._file.fileno()):
            raise UsageError(f"{path}: another sweep is writing to it; wait until it is finished, or name another file")
        try:
            whole = self._read(task)
        except BenchFileError as error:
            raise UsageError(str(error)) from None
        except OSError as error:
            raise self._refused(error) from None
        try:
            self._file.truncate(whole)
        except OSError as error:
            raise self._refused(error) from None
        if not whole:
            self._write({"tune": VERSION, "digest": digest(task), "slewline": __version__, "task": task})

    def _read(self, task: Mapping[str, Any]) -> int:
        """Read the existing lines; return the number of bytes in complete lines."""
        whole = 0
        self._file.seek(0)
        file = BufferedReader(cast("FileIO", self._file))
        try:
            for number, line in enumerate(lines_of(self.path, file), 1):
                if not line.endswith(b"\n"):
                    if not (whole or FIRST.startswith(line[: len(FIRST)])):
                        raise UsageError(f"{self.path} is not the log of a sweep; name a new file")
                    break
                if number == 1:
                    self._check(line, task)
                else:
                    key, verdict = self._verdict(number, line.rstrip(b"\n"))
                    self.verdicts[key] = verdict
                whole += len(line)
        finally:
            file.detach()
        return whole

    @property
    def runs(self) -> int:
        """The number of complete verdicts in the file, even if an `add` was interrupted after it wrote its verdict."""
        return Path(self.path).read_bytes().count(b"\n") - 1

    def add(self, key: tuple[str, str], values: Mapping[str, Any], verdict: Verdict) -> None:
        """Write a verdict.

        Args:
            key: the key of the move, and the name of the scenario.
        """
        self._write(
            {"move": key[0], "values": values, "run": key[1]}
            | {"lost": verdict.lost, "error": verdict.error, "worst": verdict.worst}
        )
        self.verdicts[key] = verdict

    def close(self) -> None:
        """Close the file."""
        self._file.close()

    def _write(self, line: Mapping[str, Any]) -> None:
        data = json.dumps(line, ensure_ascii=False).encode() + b"\n"
        try:
            while data:
                data = data[self._file.write(data) :]
        except OSError as error:
            raise self._refused(error) from None

    def _refused(self, error: OSError) -> UsageError:
        why = error.strerror or error
        return UsageError(f"{self.path}: {why}; earlier verdicts are kept; name a writable file")

    def _check(self, line: bytes, task: Mapping[str, Any]) -> None:
        """Refuse a log of another task, or a file that is not a log."""
        head = _object(line)
        if head is None or not isinstance(head.get("task"), dict) or "tune" not in head:
            raise UsageError(f"{self.path} is not the log of a sweep; name a new file")
        if head.get("digest") == digest(task):
            return
        was, now = {"slewline": head.get("slewline")} | head["task"], {"slewline": __version__} | dict(task)
        differs = "; ".join(differences(was, now)) or "its format"
        raise UsageError(f"{self.path} is the log of another task: {differs}; name another file")

    def _verdict(self, number: int, line: bytes) -> tuple[tuple[str, str], Verdict]:
        entry = _object(line)
        try:
            if entry is None:
                raise KeyError
            return (str(entry["move"]), str(entry["run"])), Verdict(
                bool(entry["lost"]), float(entry["error"]), float(entry["worst"])
            )
        except (KeyError, TypeError, ValueError, OverflowError):
            found = line[:SHORT].decode(errors="replace")
            raise UsageError(f"{self.path}, line {number}: {found} is not a run record; remove the line") from None


def _object(line: bytes) -> dict[str, Any] | None:
    try:
        found = from_json(line)
    except ValueError:
        return None
    return found if isinstance(found, dict) else None


def differences(was: Any, now: Any, where: str = "") -> Iterator[str]:
    """Yield the differences between two JSON values as text, each with the path of names that leads to it."""
    if isinstance(was, dict) and isinstance(now, dict):
        for name in dict.fromkeys([*was, *now]):
            yield from differences(was.get(name, _ABSENT), now.get(name, _ABSENT), f"{where}.{name}".lstrip("."))
    elif was != now:
        yield f"{where} was {_short(was)}, is now {_short(now)}"


def _short(value: Any) -> str:
    text = value if value is _ABSENT else json.dumps(value, ensure_ascii=False)
    return text if len(text) <= SHORT else f"{text[:SHORT]}..."

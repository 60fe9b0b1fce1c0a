"""The history: bias levels over versions, one line of JSON an entry, appended under a lock.

Why JSON lines and not Parquet: git shows and merges lines (with `*.jsonl merge=union` both sides of a merge are kept),
pandas reads them (`pandas.read_json(path, lines=True)`), a line that is cut off harms no other, and nothing that is
there is ever written again. Parquet is smaller, but a binary file that git can neither show nor merge.

Each line carries the SHA-256 of its own contents as `digest`, and as `after` the digest of the line before it when it
was written. So an edited, repeated or missing line is seen, and two branches that were merged are no fault. This is
against accidents and hand-made corrections: who computes digests anew can write what he likes.

`append` is the only way in, and `read` takes a file in any state: what is damaged is named and not used. Measuring and
comparing are elsewhere (`tracking`, `changes`).

A line, cut short:

    {"schema": "leakref/history/1", "label": "v2", "target": "mine:extract", ..., "measurements": [{"case": "broad",
     "window": "hann", "method": "nsp", "wavenumbers": [...], "unit": 1e-06, "errors": [[...], ...]}], "timings": null,
     "after": "<digest of the line before>", "digest": "<of this line>"}
"""

from __future__ import annotations

import json
import os
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import portalocker

from leakref._base import LeakrefError, refusal
from leakref.golden.digests import digest

__all__ = ["SCHEMA", "Damaged", "Entry", "History", "append", "read"]

SCHEMA = "leakref/history/1"
"""Of a line. A line of another schema is a fault, and is not used."""
_FORM = {"label": str, "target": str, "after": str | None, "measurements": list, "timings": dict | None}
_PATIENCE = 60.0  # seconds to wait for another writer


class Damaged(LeakrefError):
    """The entry that was named is there, and is not what was written. It names the line; the remedy is to take it back
    from version control.
    """


@dataclass(frozen=True, eq=False)
class Entry:
    """One line of a history, counted from 1: its `record`, and the `fault` that forbids its use, empty if it is whole.

    The record of a line that is not JSON is empty.

    `fault` is words that follow `line N`. Two entries of one digest are one: the second has a fault. Only one without a
    fault is compared or drawn.
    """

    line: int
    record: Mapping[str, Any]
    fault: str = ""

    @property
    def label(self) -> str:
        """What its version is called."""
        return str(self.record.get("label", ""))

    @property
    def target(self) -> str:
        """What was measured."""
        return str(self.record.get("target", ""))

    @property
    def digest(self) -> str:
        """As it states it, and its own if it is whole."""
        return str(self.record.get("digest", ""))

    def __str__(self) -> str:
        return f"{self.label} (line {self.line}, {self.digest[:8]})"


@dataclass(frozen=True, eq=False)
class History:
    """The lines of `path` in order, and the `faults` of the file in words, each naming its line."""

    path: Path
    lines: tuple[Entry, ...]
    faults: tuple[str, ...]

    @property
    def entries(self) -> list[Entry]:
        """Those that are whole, each once.

        In the order of the file, which is that of recording unless branches were merged.
        """
        return [line for line in self.lines if not line.fault]

    def entry(self, name: str) -> Entry:
        """The entry that `name` means: last, previous (the one before it of the same target), a label or a digest.

        Of several with one label the last. At least six characters of a digest are needed. Raises LeakrefError if
        there is none, and Damaged if it is not whole.
        """
        found = self._named(name)
        if found is None:
            labels = ", ".join(dict.fromkeys(entry.label for entry in self.lines if entry.label)) or "none"
            if name == "previous" and self.lines:
                raise LeakrefError(
                    "history",
                    f"{self.path} has no entry of the target of the last one, {self.lines[-1].target}, before it",
                    f"name one of the labels: {labels}",
                )
            raise LeakrefError(
                "history",
                f"{self.path} has no entry {name!r}; there are {labels}",
                "name one of them, last or previous, or record it first",
            )
        if found.fault:
            raise Damaged(
                "history", f"line {found.line} of {self.path} {found.fault}", "put the line back from version control"
            )
        return found

    def _named(self, name: str) -> Entry | None:
        once = [line for line in self.lines if not line.fault.startswith(_REPEATS)]
        if name == "last":
            return once[-1] if once else None
        if name == "previous":
            return next((line for line in once[-2::-1] if line.target == once[-1].target), None)
        labelled = [line for line in once if line.label == name]
        digests = [line for line in once if len(name) >= 6 and line.digest.startswith(name)]
        return next(reversed(labelled or digests), None)


_REPEATS = "repeats line"


def read(path: Path) -> History:
    """The history in `path`, whatever state it is in. Raises LeakrefError if it cannot be read.

    Locked for reading meanwhile where that can be. A file that is empty has no lines and no faults; one that does not
    exist cannot be read.
    """
    return History(path, *_parsed(_bytes(path)))


def append(path: Path, fields: Mapping[str, Any]) -> tuple[Entry, str]:
    """Write an entry with `fields` at the end of `path` and return it, and what was found amiss there in words.

    The file is locked meanwhile and made if need be. What is left of a last line that was cut off goes: it is lost
    anyway, and would spoil the next. Raises LeakrefError.

    `fields` are those of `tracking.fields`. LeakrefError is raised where the file cannot be written, or another writer
    holds it for a minute.
    """
    try:
        path.parent.mkdir(parents=True, exist_ok=True)
        with portalocker.Lock(path, "ab+", timeout=_PATIENCE, check_interval=0.02) as stream:
            stream.seek(0)
            data = stream.read()
            lines, _ = _parsed(data)
            end = data.rfind(b"\n") + 1
            said = ""
            if end < len(data) and not lines[-1].fault:
                stream.write(b"\n")  # all of it but for its end
            elif end < len(data):
                stream.truncate(end)
                lines = lines[:-1]
                said = f"line {len(lines) + 1} was cut off: what was left of it is removed"
            before = [line.digest for line in lines if line.digest]
            record = {"schema": SCHEMA, **fields, "after": before[-1] if before else None}
            record["digest"] = digest(record)
            stream.write(_line(record) + b"\n")
            stream.flush()
            os.fsync(stream.fileno())
    except (OSError, portalocker.LockException) as error:
        raise refusal(
            "history",
            f"{path} cannot be written ({error})",
            "choose another file with --history, or end who holds it",
            error,
        ) from None
    return Entry(len(lines) + 1, record), said


def _bytes(path: Path) -> bytes:
    """All of the file, not while somebody writes, where that can be prevented."""
    shared = portalocker.LockFlags.SHARED | portalocker.LockFlags.NON_BLOCKING
    try:
        with portalocker.Lock(path, "rb", timeout=_PATIENCE, check_interval=0.02, flags=shared) as stream:
            return bytes(stream.read())
    except portalocker.LockException:
        return path.read_bytes()  # a file system without locks
    except OSError as error:
        raise refusal(
            "history",
            f"{path} cannot be read ({error.strerror or error})",
            "record into it first: `leakref track record`",
            error,
        ) from None


def _line(record: Mapping[str, Any]) -> bytes:
    return json.dumps(record, separators=(",", ":"), ensure_ascii=False, allow_nan=False).encode()


def _parsed(data: bytes) -> tuple[tuple[Entry, ...], tuple[str, ...]]:
    """The lines, and the faults of the file. A last line without its end is whole if its digest is; else it was cut
    off.
    """
    *whole, rest = data.split(b"\n")
    lines = [_entry(n, line.removesuffix(b"\r")) for n, line in enumerate(whole + [rest] * bool(rest), 1)]
    if rest and lines[-1].fault:
        lines[-1] = Entry(lines[-1].line, {}, "is cut off: that entry is lost, no other")
    first: dict[str, int] = {}
    for n, line in enumerate(lines):
        if not line.fault and first.setdefault(line.digest, line.line) != line.line:
            lines[n] = Entry(line.line, line.record, f"{_REPEATS} {first[line.digest]}: it counts once")
    return tuple(lines), tuple(_faults(lines))


def _entry(number: int, line: bytes) -> Entry:
    """A line as an entry, with what is wrong with it: not JSON, edited, of another schema, or without a field. A line
    must be byte for byte what `append` would write.
    """
    try:
        record = json.loads(line)
        if not isinstance(record, dict) or "digest" not in record:
            return Entry(number, {}, "is no entry: it has no digest")
        same = _line(record) == line and digest({k: v for k, v in record.items() if k != "digest"}) == record["digest"]
    except (ValueError, RecursionError):
        return Entry(number, {}, "is not whole: it was cut or edited, and is no JSON any more")
    if not same:
        return Entry(number, record, "was edited: its contents are not those of its digest")
    if record.get("schema") != SCHEMA:
        return Entry(number, record, f"is of another schema, {record.get('schema')!r}")
    if wrong := [name for name, kind in _FORM.items() if not isinstance(record.get(name), kind)]:
        sound = {name: value for name, value in record.items() if name not in wrong}
        return Entry(number, sound, f"is no entry: its {wrong[0]} is {str(record.get(wrong[0]))[:40]!r}")
    return Entry(number, record)


def _faults(lines: list[Entry]) -> Iterator[str]:
    """In words, with the number of the line. An entry that is named as the one before and is nowhere was taken out."""
    stated = {line.digest for line in lines if line.digest}
    for line in lines:
        if line.fault:
            yield f"line {line.line} {line.fault}"
        elif line.record.get("after") and line.record["after"] not in stated:
            gone = str(line.record["after"])[:8]
            yield f"line {line.line} was written after an entry ({gone}) that is not there any more"

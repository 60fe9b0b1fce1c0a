"""The private folder in which the arrays of a run are handed over and come back: formats, digests, stray files."""

from __future__ import annotations

import hashlib
import math
import os
import shutil
import stat
import tempfile
from collections.abc import Mapping, Sequence
from contextlib import suppress
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt
from scipy import io

from leakref import files
from leakref._base import LeakrefError
from leakref._output import dump, folder, write_whole
from leakref.certify.verdict import Unanswered, Verdict

__all__ = ["Exchange"]

_ROOM = 1 << 16
Seen = tuple[int, str]
"""Of an input as it was handed over: its inode and its SHA-256."""


class Exchange:
    """A folder for each run, in a temporary one that only the user may enter, or in a new one in `keep` that stays.

    A run's input is one file, or for raw a folder with one for each array, read-only; its output likewise. Raises
    LeakrefError if nothing can be written to `keep`.
    """

    def __init__(self, keep: Path | None = None) -> None:
        self._kept = keep is not None
        self.folder = Path(tempfile.mkdtemp(prefix="leakref-", dir=folder(keep) if keep else None)).resolve()
        self._known: set[Path] = set()
        self._inputs: dict[Path, Seen] = {}
        self._format = ""
        self.output = self.folder

    def give(self, run: int, form: str, arrays: Mapping[str, npt.ArrayLike]) -> tuple[Path, Path]:
        """Write the inputs of a run as npz, mat or raw: the paths of its input, and of the output to be."""
        place = self.folder / f"run-{run}"
        place.mkdir()
        suffix = "" if form == "raw" else f".{form}"
        given, self.output, self._format = place / f"in{suffix}", place / f"out{suffix}", form
        values = {name: np.ascontiguousarray(value, dtype="<f8") for name, value in arrays.items()}
        if form == "raw":
            given.mkdir()
            self.output.mkdir()
            for name, value in values.items():
                value.tofile(given / f"{name}.f64")
        elif form == "mat":
            io.savemat(given, values, appendmat=False)
        else:
            np.savez(given, **values)  # type: ignore[arg-type]
        written = sorted(given.iterdir()) if form == "raw" else [given]
        for path in written:
            path.chmod(0o444)
        self._inputs = {path: _seen(path) for path in written}
        self._known |= {place, given, *written}
        return given, self.output

    def take(self, name: str, shape: Sequence[int]) -> npt.NDArray[Any]:
        """The output variable `name`, float64 or complex128; raw has no shape of its own and takes on `shape`.

        Raises Unanswered: error if there is no such file or it is damaged, fail if it holds something else.
        """
        path = self.output / f"{name}.f64" if self._format == "raw" else self.output
        if not _regular(path):
            raise Unanswered(Verdict.ERROR, f"there is no file {path.relative_to(self.output.parent)}, where the "
                                            "output should be")
        if self._format == "raw":
            return _raw(path, name, shape)
        try:
            found = files.variables(path, (name,))
        except LeakrefError as error:
            raise Unanswered(Verdict.ERROR, f"its output {error.fault}") from None
        if name not in found:
            raise Unanswered(Verdict.FAIL, f"its output {path.name} does not hold {name}")
        array = np.asarray(found[name])
        if array.dtype.kind not in "fiuc":
            raise Unanswered(Verdict.FAIL, f"{name} is of the type {array.dtype}, should be numbers")
        return array.astype(np.complex128 if array.dtype.kind == "c" else np.float64)

    def room(self) -> None:
        """Raise OSError if the output had no room: that is no fault of the program's."""
        largest = max((path.stat().st_size for path in self._inputs if _regular(path)), default=0)
        with tempfile.TemporaryFile(dir=self.folder) as stream:
            stream.write(bytes(_ROOM + 2 * largest))

    def changes(self) -> list[str]:
        """What was done in the folder, since `give`, other than writing the output: each in words, none if all is well.

        What is still there of it counts as known afterwards.
        """
        said = [f"{verb} its input {path.relative_to(self.output.parent)}" for path, before in self._inputs.items()
                if (verb := _changed(path, before))]
        there = _entries(self.folder)
        allowed = {path for path in there if path == self.output or (self._format == "raw" and path.suffix == ".f64"
                                                                     and path.parent == self.output)}
        stray = sorted(repr(str(path.relative_to(self.folder))) for path in there - self._known - allowed)
        if stray:
            said.append(f"left in the exchange folder {', '.join(stray[:3])}" + ", ..." * (len(stray) > 3))
        self._known |= there
        return said

    def clear(self) -> None:
        """Remove all that is in the folder, unless it is to be kept."""
        self._inputs = {}
        if not self._kept:
            _remove(self.folder)
            self.folder.mkdir(mode=0o700, exist_ok=True)
            self._known = set()

    def note(self, name: str, record: Mapping[str, Any]) -> None:
        """Beside the files of a run that is kept, what was said about them, as JSON."""
        if self._kept:
            path = write_whole(self.output.parent / name, lambda beside: beside.write_text(dump(record) + "\n"))
            self._known.add(path)

    def close(self) -> None:
        """Remove the folder, unless it is to be kept."""
        if not self._kept:
            _remove(self.folder)


def _regular(path: Path) -> bool:
    """Whether it is a file and nothing else: a link leads elsewhere, and a pipe would be read for ever."""
    try:
        return stat.S_ISREG(path.lstat().st_mode)
    except OSError:
        return False


def _seen(path: Path) -> Seen:
    with path.open("rb") as stream:
        return os.fstat(stream.fileno()).st_ino, hashlib.file_digest(stream, "sha256").hexdigest()


def _changed(path: Path, before: Seen) -> str:
    """In one word what became of an input, nothing if it is as it was."""
    if not _regular(path):
        return "replaced" if os.path.lexists(path) else "removed"
    try:
        inode, digest = _seen(path)
    except OSError:
        return "locked"
    return "altered" if digest != before[1] else "replaced" if inode != before[0] else ""


def _raw(path: Path, name: str, shape: Sequence[int]) -> npt.NDArray[Any]:
    """Little-endian float64 in C order, real or complex by its size."""
    size, count = path.stat().st_size, math.prod(shape)
    if size == 8 * count:
        return np.fromfile(path, "<f8").astype(np.float64).reshape(shape)
    if size == 16 * count:
        return np.fromfile(path, "<c16").astype(np.complex128).reshape(shape)
    raise Unanswered(Verdict.FAIL, f"{path.name} holds {size} bytes, should be 8 for each number of {name}, of shape "
                                   f"{tuple(shape)}, or 16 if they are complex")


def _entries(top: Path) -> set[Path]:
    return {Path(place) / name for place, folders, names in os.walk(top) for name in (*folders, *names)}


def _remove(path: Path) -> None:
    """A folder with all that is in it, whatever modes it was given; or what has taken its place."""
    if path.is_symlink() or not path.is_dir():
        path.unlink(missing_ok=True)
        return
    path.chmod(0o700)
    for place, folders, names in os.walk(path):  # from the top: a folder is opened up before it is entered
        for name in folders + names * (os.name == "nt"):  # elsewhere read-only files can be removed
            if not os.path.islink(inner := os.path.join(place, name)):
                with suppress(OSError):
                    os.chmod(inner, 0o700)
    shutil.rmtree(path, ignore_errors=True)

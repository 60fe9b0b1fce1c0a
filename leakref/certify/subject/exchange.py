"""The private folder in which the arrays of a run are handed over and come back: formats, digests, stray files.

What is promised of it is in the guide protocol, sections 7 and 10.

It belongs to `protocol.ProcessSubject`, one for each session. A program under test may write anything here, or put
links, pipes and huge files in the place of its output: files are opened without following links, sizes are looked at
before contents, and nothing is trusted to be still what it was. What it should not have done is said in words.

What is in the folder while a run lasts:

    run-7/in.npz   or for raw   run-7/in/eta.f64, run-7/in/x.f64, ...
    run-7/out.npz               run-7/out/S.f64
    run-7/request.json, run-7/answer.json   (only if they are kept)
"""

from __future__ import annotations

import errno
import hashlib
import math
import os
import stat
import tempfile
from collections import deque
from collections.abc import Mapping, Sequence
from contextlib import suppress
from pathlib import Path
from typing import Any, BinaryIO
from uuid import uuid4

import numpy as np
import numpy.typing as npt

from leakref._base import LeakrefError
from leakref._output import dump, folder, write_whole
from leakref.certify.verdict import Unanswered, Verdict, printable
from leakref.cubes import formats

__all__ = ["Exchange", "opened", "taken", "too_deep"]

Seen = tuple[int, int, str]
"""Of an input as it was handed over: its inode, its size and its SHA-256."""
_SOMEBODY = (errno.ENOENT, errno.ENOTDIR, errno.EEXIST, errno.EISDIR, errno.ELOOP, errno.EACCES, errno.EINVAL)
"""Errors where a folder or file of ours is gone, or is something else."""
_ROUNDS = 9  # of removing what is there, while somebody adds to it
_STEPWISE = os.open in os.supports_dir_fd  # whether a path can be walked folder by folder
_ENTRIES = 1000
"""In the exchange folder: those beyond it are not looked at."""
_ROOM = 1 << 16
_DEEPEST = 50


class Exchange:
    """A folder for each run, in a temporary one that only the user may enter, or in a new one in `keep` that stays.

    A run's input is one file, or for raw a folder with one for each array, read-only; its output likewise. Raises
    LeakrefError if nothing can be written to `keep`.

    - `folder`: the one that holds a folder for each run; `output`: where the output of the last run should be.

    OSError of the machine's own, such as a disk that is full, is passed on: it is no fault of the program.
    """

    def __init__(self, keep: Path | None = None) -> None:
        self._kept = keep is not None
        self.folder = Path(tempfile.mkdtemp(dir=folder(keep) if keep else None)).resolve()
        self._known: set[Path] = set()
        self._inputs: dict[Path, Seen] = {}
        self._format = ""
        self.output = self.folder

    @property
    def belongings(self) -> str:
        """What nobody is to find here once we are gone: the folder, unless it was asked to be kept."""
        return "" if self._kept else str(self.folder)

    def give(self, run: int, form: str, arrays: Mapping[str, npt.ArrayLike]) -> tuple[Path, Path]:
        """Write the inputs of a run as npz, mat or raw: the paths of its input, and of the output to be.

        Raises Unanswered (error) if somebody else keeps it from that.

        `run` is a number that names the folder, `form` one of the three formats, `arrays` become float64 in C order,
        little-endian. For raw, input and output are folders with a file `NAME.f64` for each array. Inode, size and
        SHA-256 of every input are kept, for `changes`.
        """
        try:
            return self._given(run, form, arrays)
        except OSError as error:
            if error.errno not in _SOMEBODY:
                raise
            raise Unanswered(
                Verdict.ERROR,
                f"removed or replaced the exchange folder, so that nothing can be asked ({error.strerror})",
            ) from None

    def _given(self, run: int, form: str, arrays: Mapping[str, npt.ArrayLike]) -> tuple[Path, Path]:
        """Where the inputs of a run lie, and where its output belongs: arrays as little-endian float64 in the format
        that the program declared, readable and no more.
        """
        place = self.folder / f"run-{run}"
        try:
            place.mkdir()
        except FileExistsError:  # somebody has guessed it
            place = Path(tempfile.mkdtemp(prefix=f"run-{run}-", dir=self.folder))
        suffix = "" if form == "raw" else f".{form}"
        given, self.output, self._format = place / f"in{suffix}", place / f"out{suffix}", form
        values = {name: np.ascontiguousarray(value, dtype="<f8") for name, value in arrays.items()}
        if form == "raw":
            given.mkdir()
            self.output.mkdir()
            for name, value in values.items():
                value.tofile(given / f"{name}.f64")
        elif form == "mat":
            from scipy import io  # for programs that want this format alone

            io.savemat(given, values, appendmat=False)
        else:
            np.savez(given, **values)  # type: ignore[arg-type]  # numpy says bool of all keywords
        written = sorted(given.iterdir()) if form == "raw" else [given]
        for path in written:
            path.chmod(0o444)
        self._inputs = {path: _seen(self.folder, path) for path in written}
        self._known |= {place, given, *written}
        return given, self.output

    def take(self, name: str, shape: Sequence[int]) -> npt.NDArray[Any]:
        """The output variable `name`, float64 or complex128; raw has no shape of its own and takes on `shape`.

        Raises Unanswered: error if there is no such file or it is damaged, fail if it holds something else.

        `shape` is the one it should have; only raw is given that shape here, the others keep their own, which the
        caller checks. A file that claims to hold more than there should be is refused before it is unpacked.
        """
        return taken(self.folder, self.output, self._format, name, shape)

    def check_space(self) -> None:
        """Raise OSError if the output had no room: that is no fault of the program's."""
        largest = max((size for _, size, _ in self._inputs.values()), default=0)
        with tempfile.TemporaryFile(dir=self.folder) as stream:
            stream.write(bytes(_ROOM + 2 * largest))

    def changes(self) -> list[str]:
        """What was done in the folder, since `give`, other than writing the output: each in words, none if all is well.

        What is still there of it counts as known afterwards.

        An input may be removed, replaced, altered or locked; what else lies in the folder is named, the first three of
        it. Files below a raw output folder count as output only if they end in `.f64`.
        """
        said = [
            f"{verb} its input {path.relative_to(self.output.parent)}"
            for path, before in self._inputs.items()
            if (verb := _changed(self.folder, path, before))
        ]
        there = _entries(self.folder)
        allowed = {
            path
            for path in there
            if path == self.output or (self._format == "raw" and path.suffix == ".f64" and path.parent == self.output)
        }
        stray = sorted(repr(printable(path.relative_to(self.folder), 120)) for path in there - self._known - allowed)
        if stray:
            said.append(f"left in the exchange folder {', '.join(stray[:3])}" + ", ..." * (len(stray) > 3))
        self._known |= there
        return said

    def clear(self) -> None:
        """Remove all that is in the folder, unless it is to be kept. Called after every run, so that the outputs of one
        run are never taken for those of the next.
        """
        self._inputs = {}
        if not self._kept:
            _remove(self.folder)
            with suppress(OSError):
                self.folder.mkdir(mode=0o700)
            self._known = set()

    def note(self, name: str, record: Mapping[str, Any]) -> None:
        """Beside the files of a run that is kept, what was said about them, as JSON.

        `name` is `request.json` or `answer.json`. Nothing is written where nothing is kept, or where the folder of the
        run has been taken away.
        """
        if self._kept and _is_folder(self.output.parent):
            path = write_whole(self.output.parent / name, lambda beside: beside.write_text(dump(record) + "\n"))
            self._known.add(path)

    def close(self) -> None:
        """Remove the folder, unless it is to be kept."""
        if not self._kept:
            _remove(self.folder)


def taken(top: Path, output: Path, form: str, name: str, shape: Sequence[int]) -> npt.NDArray[Any]:
    """The variable `name` of an `output` below the folder `top`, as `Exchange.take` has it."""
    path = output / f"{name}.f64" if form == "raw" else output
    try:
        stream = opened(top, path)
    except OSError:
        raise Unanswered(
            Verdict.ERROR, f"there is no file {path.relative_to(output.parent)}, where the output should be"
        ) from None
    with stream:
        return (_raw if form == "raw" else _packed)(stream, path, name, shape)


def _is_folder(path: Path) -> bool:
    """Whether it is one, and no link to one."""
    return path.is_dir() and not path.is_symlink()


def opened(top: Path, path: Path) -> BinaryIO:
    """A regular file below the folder `top`, to be read; whatever is put in its place is not waited for or followed.

    No link on the way, no pipe, no device. Raises OSError.
    """
    if not _STEPWISE:
        if any(part.is_symlink() for part in (path, *path.parents) if top in part.parents):
            raise OSError(errno.ELOOP, "it is a link")
        return _file(os.open(path, os.O_RDONLY | getattr(os, "O_BINARY", 0)))
    *folders, name = path.relative_to(top).parts
    place = os.open(top, os.O_RDONLY | os.O_DIRECTORY | os.O_NOFOLLOW)
    try:
        for part in folders:
            inner = os.open(part, os.O_RDONLY | os.O_DIRECTORY | os.O_NOFOLLOW, dir_fd=place)
            os.close(place)
            place = inner
        return _file(os.open(name, os.O_RDONLY | os.O_NOFOLLOW | os.O_NONBLOCK, dir_fd=place))
    finally:
        os.close(place)


def _file(number: int) -> BinaryIO:
    """A stream of an open file, if it is a regular one. Raises OSError, and closes it, for anything else."""
    if stat.S_ISREG(os.fstat(number).st_mode):
        return os.fdopen(number, "rb")
    os.close(number)
    raise OSError(errno.EINVAL, "it is no file")


def _seen(top: Path, path: Path) -> Seen:
    """Inode, size and digest of an input as it is now."""
    with opened(top, path) as stream:
        about = os.fstat(stream.fileno())
        return about.st_ino, about.st_size, hashlib.sha256(stream.read(about.st_size)).hexdigest()


def _changed(top: Path, path: Path, before: Seen) -> str:
    """In one word what became of an input, nothing if it is as it was."""
    if not os.path.lexists(path):
        return "removed"
    try:
        with opened(top, path) as stream:
            about = os.fstat(stream.fileno())
            if about.st_size != before[1]:  # maybe by terabytes, which are not read
                return "altered"
            digest = hashlib.sha256(stream.read(before[1])).hexdigest()
    except PermissionError:
        return "locked"
    except OSError:
        return "replaced"
    return "altered" if digest != before[2] else "replaced" if about.st_ino != before[0] else ""


def _packed(stream: BinaryIO, path: Path, name: str, shape: Sequence[int]) -> npt.NDArray[Any]:
    """The variable of an npz or mat file."""
    size, count = os.fstat(stream.fileno()).st_size, math.prod(shape)
    if size > 64 * count + 2**20:  # it may hold more than it was asked for, four arrays
        raise Unanswered(Verdict.FAIL, f"its output {path.name} takes {size} bytes, should be {count} numbers")
    try:
        found = formats.variables(path, (name,), stream=stream, most=count)
    except LeakrefError as error:
        verdict = Verdict.FAIL if isinstance(error, formats.TooLarge) else Verdict.ERROR
        raise Unanswered(verdict, f"its output {error.fault}") from None
    if name not in found:
        raise Unanswered(Verdict.FAIL, f"its output {path.name} does not hold {name}")
    array = np.asarray(found[name])
    if array.dtype.kind not in "fiuc":
        raise Unanswered(Verdict.FAIL, f"{name} is of the type {array.dtype}, should be numbers")
    return array.astype(np.complex128 if array.dtype.kind == "c" else np.float64)


def _raw(stream: BinaryIO, path: Path, name: str, shape: Sequence[int]) -> npt.NDArray[Any]:
    """Little-endian float64 in C order, real or complex by its size."""
    size, count = os.fstat(stream.fileno()).st_size, math.prod(shape)
    content = stream.read(size) if size in (8 * count, 16 * count) else b""
    if len(content) == size == 8 * count:
        return np.frombuffer(content, "<f8").astype(np.float64).reshape(shape)
    if len(content) == size == 16 * count:
        return np.frombuffer(content, "<c16").astype(np.complex128).reshape(shape)
    raise Unanswered(
        Verdict.FAIL,
        f"{path.name} holds {size} bytes, should be 8 for each number of {name}, of shape "
        f"{tuple(shape)}, or 16 if they are complex",
    )


def _entries(top: Path) -> set[Path]:
    """All that is in a folder, at any depth; some of it where there is more than anybody needs to see."""
    found: set[Path] = set()
    waiting = [str(top)]
    while waiting and len(found) < _ENTRIES:
        with suppress(OSError), os.scandir(waiting.pop()) as inside:
            for entry in inside:
                found.add(Path(entry.path))
                if entry.is_dir(follow_symlinks=False):
                    waiting.append(entry.path)
                if len(found) >= _ENTRIES:
                    break
    return found


def _remove(path: Path) -> None:
    """A folder with all that is in it, whatever modes it was given and however deep; or what has taken its place.

    Others may still write into it, so it is gone over several times; what cannot be removed is left.
    """
    with suppress(OSError):  # somebody may be at work in it
        if not _is_folder(path):
            path.unlink(missing_ok=True)
            return
        path.chmod(0o700)
        for _ in range(_ROUNDS):
            inside = deque(str(entry) for entry in path.iterdir())
            if not inside:
                break
            while inside:
                with suppress(OSError):
                    inside += _removed(inside.popleft(), path)
        path.rmdir()


def _removed(one: str, top: Path) -> list[str]:
    """Remove what is at a path; what was in it, now directly in `top`, so that no path gets too long."""
    if not os.path.isdir(one) or os.path.islink(one):
        if os.name == "nt":  # elsewhere read-only files can be removed
            os.chmod(one, 0o700)
        os.unlink(one)
        return []
    os.chmod(one, 0o700)
    moved = []
    for name in os.listdir(one):
        moved.append(os.path.join(top, f".{uuid4().hex}"))
        inner = os.path.join(one, name)
        if not os.path.islink(inner):
            os.chmod(inner, 0o700)  # a folder that is moved is written to
        os.rename(inner, moved[-1])
    os.rmdir(one)
    return moved


def too_deep(message: Any) -> bool:
    """Whether lists and objects are within each other more often than whoever reads it later can follow."""
    level = [message]
    for _ in range(_DEEPEST):
        level = [
            inner
            for one in level
            if isinstance(one, dict | list)
            for inner in (one.values() if isinstance(one, dict) else one)
        ]
    return bool(level)

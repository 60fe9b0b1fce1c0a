"""The variables of an npz, mat (v5), NetCDF or npy file, read with suspicion.

What a header claims is held against the size of the file before anything is read.

`files` and the exchange with programs under test read through this. Each reader returns raw variables by name and
judges nothing of what they mean. A damaged file may make a parser raise anything: all of it becomes a LeakrefError.
"""

from __future__ import annotations

import errno
import io as streams
import math
import os
import zipfile
import zlib
from collections.abc import Callable, Iterator, Sequence
from contextlib import nullcontext
from itertools import islice
from pathlib import Path
from typing import Any, BinaryIO, NoReturn

import numpy as np

from leakref._base import LeakrefError, Trouble, installed_with

__all__ = ["KNOWN", "WAVES", "TooLarge", "netcdf_library", "raw_variables", "refuse", "variables"]

_DENSEST = 1032  # deflate shrinks no further: what claims to hold more than this many times its bytes cannot
_HEADER = 1 << 12  # bytes in which a variable says what it is; numpy's own limit is some more
WAVES = ("kx", "ky", "omega", "amplitude", "phase")
"""The arrays that describe the waves of a cube with a truth, (n,) each."""
KNOWN = ("eta", "x", "y", "t", "gravity", *WAVES, "current", "peak_wavenumber", "units", "spacing", "dx", "dy", "dt")
"""The variables that are looked for in a cube; others are never unpacked."""


def netcdf_library() -> Any:
    """xarray, or a LeakrefError that says how to get it."""
    try:
        import h5netcdf  # noqa: F401  what xarray needs for it, asked for here to name what is lacking
        import h5py  # noqa: F401
        import xarray
    except ModuleNotFoundError as error:
        raise LeakrefError(
            "netcdf",
            f"NetCDF needs {error.name}, which is not installed",
            f"use npz or mat, or {installed_with('netcdf')}",
        ) from None
    return xarray


def variables(
    path: Path, names: Sequence[str], *, stream: BinaryIO | None = None, most: int | None = None
) -> dict[str, Any]:
    """Those of the variables `names` that an npz or mat file holds, as arrays, read with the same suspicion as `read`.

    `stream` is the file if it is open already. With `most`, a variable that claims to be more than as many numbers is
    refused, as TooLarge, before anything of it is unpacked. Raises LeakrefError that names file, fault and remedy.

    The type and the shape are those of the file; names that it does not hold are left out.
    """
    return raw_variables(Path(path), names, ("npz", "mat"), stream, most)


class TooLarge(LeakrefError):
    """A file holds more than there can be.

    Raised only where the caller has said how much there can be at `most`: an output under judgement.
    """


def raw_variables(
    path: Path, names: Sequence[str], kinds: Sequence[str] = (), given: BinaryIO | None = None, most: int | None = None
) -> dict[str, Any]:
    """The raw variables of a file, of one of the `kinds` if there are any. Whatever goes wrong is a LeakrefError. That
    is but for a fault of the machine (EIO, no more files, no memory), which is a Trouble. `names` are looked for,
    others are not unpacked. Of a NetCDF file there are also `units of NAME` and `dims`.
    """
    kind = "a file"
    try:
        if not given and path.exists() and not path.is_file():
            what = "is a folder" if path.is_dir() else "is a pipe or a device"
            refuse(path, what, "name the file with the cube in it")
        with nullcontext(given) if given else path.open("rb") as stream:
            start = stream.read(128)
            stream.seek(0)
            kind, reader = _kind(path, start)
            if kinds and kind not in kinds:
                refuse(path, f"is a file of the kind {kind}", f"write {' or '.join(kinds)}")
            return reader(path, stream, names, most)
    except LeakrefError:
        raise
    except FileNotFoundError:
        refuse(path, "does not exist", "check the name")
    except PermissionError:
        refuse(path, "may not be read by you", "ask for permission to read it (chmod +r) or copy it")
    except MemoryError:
        refuse(path, "does not fit into memory", _AS_NPY)
    except Exception as error:  # parsers of damaged files raise anything: struct.error, zlib.error, KeyError, OSError
        if isinstance(error, OSError) and error.errno in _AROUND:
            raise Trouble("extract", f"{path} cannot be read ({error.strerror})", "see to that and try again") from None
        refuse(
            path,
            f"is damaged or cut short (reading it as {kind} failed: {error or type(error).__name__})",
            "copy or export it again",
        )


_AROUND = (errno.EIO, errno.EMFILE, errno.ENFILE, errno.ENOMEM, errno.ESTALE)  # not the file's fault
_AS_NPY = "save eta with numpy.save as .npy, which is read in blocks, and pass --spacing dx,dy,dt"


def refuse(path: Path, fault: str, remedy: str) -> NoReturn:
    """Raise the LeakrefError that names the file, what is wrong with it and what to do."""
    raise LeakrefError("extract", f"{path} {fault}", remedy)


Reader = Callable[[Path, BinaryIO, Sequence[str], int | None], dict[str, Any]]


def _kind(path: Path, start: bytes) -> tuple[str, Reader]:
    """The format by its first bytes, and its reader."""
    if start.startswith(b"\x93NUMPY"):
        return "npy", _read_npy
    if start.startswith(b"PK"):
        return "npz", _read_npz
    if start.startswith(b"\x89HDF\r\n"):
        return "NetCDF", _read_netcdf
    if start[124:128] in (b"\x00\x01IM", b"\x01\x00MI"):
        return "mat", _read_mat
    reasons = [
        (not start, "is empty", "export it again"),
        (start.startswith(b"MATLAB 7.3"), "is a MATLAB 7.3 file", "save it with save(..., '-v7') in MATLAB"),
        (
            start.startswith((b"# Created by Octave", b"Octave-1")),
            "is in a format of Octave's own",
            "save it with save -v7 in Octave",
        ),
        (start.startswith(b"CDF"), "is a classic NetCDF file", "convert it with nccopy -k nc4 IN OUT"),
        (
            start[:1] == b"\x80",
            "is a pickle, which is never loaded: it could run anything",
            "save the arrays with numpy.savez",
        ),
    ]
    for holds, fault, remedy in reasons:
        if holds:
            refuse(path, fault, remedy)
    refuse(path, "is of no kind that is known", "pass an npz, mat (v5 to v7), NetCDF (4) or npy file")


def _claim(
    path: Path,
    name: str,
    shape: tuple[int, ...],
    itemsize: int,
    available: float = math.inf,
    loaded: bool = True,
    most: int | None = None,
) -> None:
    """Refuse what a header claims but the file cannot hold, or memory cannot (a transform needs it four times).

    And what is more than `most` numbers, of 32 bytes or fewer. `available` is what the file has left, in bytes, times
    what packing can have saved; `loaded` is False for what is mapped.
    """
    count = math.prod(int(n) for n in shape)
    if most is not None and (count > most or count * itemsize > 32 * most):
        raise TooLarge(
            "extract",
            f"{path} holds {name} of shape {shape}, {count * itemsize} bytes, should be {most} "
            f"number{'s' * (most != 1)}",
            "write what was asked for",
        )
    if count * itemsize > available:
        refuse(
            path,
            f"is cut short: {name} of shape {shape} takes {count * itemsize} bytes, at most {available} are there",
            "copy or export it again",
        )
    memory = os.sysconf("SC_PAGE_SIZE") * os.sysconf("SC_PHYS_PAGES") if hasattr(os, "sysconf") else math.inf
    if loaded and 4 * 8 * count > memory:
        refuse(path, f"holds {name} of shape {shape}, too large for this machine's memory", _AS_NPY)


def _npy_header(path: Path, name: str, stream: Any) -> tuple[tuple[int, ...], bool, np.dtype[Any]]:
    """Shape, Fortran order and type from the header of an npy stream, which is left at the samples."""
    version = np.lib.format.read_magic(stream)
    size = int.from_bytes(claimed := stream.read(2 if version == (1, 0) else 4), "little")
    if size > 2 * _HEADER:
        refuse(path, f"is damaged: the header of {name} takes {size} bytes", "export it again")
    header = streams.BytesIO(claimed + stream.read(size))
    reader = {(1, 0): np.lib.format.read_array_header_1_0, (2, 0): np.lib.format.read_array_header_2_0}.get(version)
    if reader is None:
        refuse(path, f"holds {name} in npy format {version}, with named fields", "save plain numbers")
    shape, fortran, dtype = reader(header)
    if dtype.hasobject:
        refuse(
            path,
            f"holds {name} as pickled objects, which are never loaded: they could run anything",
            "save it as an array of numbers",
        )
    return shape, fortran, dtype


def _read_npy(path: Path, stream: BinaryIO, names: Sequence[str], most: int | None) -> dict[str, Any]:
    """Mapped and not read: the samples stay on the disk, and only `eta` can be in it."""
    shape, fortran, dtype = _npy_header(path, "eta", stream)
    offset = stream.tell()
    _claim(path, "eta", shape, dtype.itemsize, _size(stream) - offset, loaded=False)
    return {"eta": np.memmap(stream, dtype, "r", offset, shape, "F" if fortran else "C")}


def _size(stream: BinaryIO) -> int:
    """Of the file that is open, whatever has become of its name."""
    return os.fstat(stream.fileno()).st_size


def _read_npz(path: Path, stream: BinaryIO, names: Sequence[str], most: int | None) -> dict[str, Any]:
    """Each member's header is read first, and what it claims is held against the packed bytes; then it is read to its
    end, where the checksum is.
    """
    found = {}
    with zipfile.ZipFile(stream) as archive:
        for name in names:
            member = f"{name}.npy"
            if member not in archive.namelist():
                continue
            info = archive.getinfo(member)
            if info.compress_type not in (zipfile.ZIP_STORED, zipfile.ZIP_DEFLATED):  # others unpack without an end
                refuse(path, f"holds {name} packed in a way that numpy does not", "save it with numpy.savez")
            packed = min(info.compress_size, _size(stream))
            with archive.open(info) as content:
                shape, _, dtype = _npy_header(path, name, content)
                _claim(
                    path,
                    name,
                    shape,
                    dtype.itemsize,
                    min(info.file_size, packed * (_DENSEST if info.compress_type else 1)),
                    most=most,
                )
                if info.file_size > content.tell() + math.prod(shape) * dtype.itemsize:
                    refuse(path, f"is damaged: {name} of shape {shape} is followed by something", "export it again")
            with archive.open(info) as content:
                found[name] = np.lib.format.read_array(content, allow_pickle=False)
                content.read()  # to the end, where the checksum is compared
    return found


def _read_mat(path: Path, stream: BinaryIO, names: Sequence[str], most: int | None) -> dict[str, Any]:
    """The variables `names` of a mat file, v5 to v7. Read here: scipy.io.loadmat crashes on some damaged files."""
    # what others may still cut is read, not mapped: a page that is gone would end us
    content = memoryview(np.memmap(stream, np.uint8, "r") if most is None else stream.read(_size(stream)))
    order = "<" if bytes(content[126:128]) == b"IM" else ">"
    found: dict[str, Any] = {}
    for kind, element in _elements(path, content[128:], order):
        if kind == _COMPRESSED:
            start = zlib.decompressobj().decompress(element, 8 + _HEADER)
            kind, length = (int(n) for n in np.frombuffer(start[:8], f"{order}u4"))
            name, _, shape = _mat_header(path, memoryview(start)[8:], order)
            if name not in names:
                continue
            if most is not None and length > 16 * most + _HEADER:
                _claim(path, name, shape if math.prod(shape) > most else (length,), 1, length, most=most)
            _claim(path, "a variable", (length,), 1, _DENSEST * len(element))
            unpacked = memoryview(zlib.decompressobj().decompress(element, 8 + length))
            ((kind, element),) = _elements(path, unpacked, order)
        if kind == _MATRIX:
            found |= _mat_variable(path, element, order, names, most)
    return found


_STORED = {
    1: "i1",
    2: "u1",
    3: "i2",
    4: "u2",
    5: "i4",
    6: "u4",
    7: "f4",
    9: "f8",
    12: "i8",
    13: "u8",
    16: "u1",
    17: "u2",
    18: "u4",
}  # as the samples are stored, by the tag's number; the last three are text
_CLASSES = {4: "U1", 6: "f8", 7: "f4", 8: "i1", 9: "u1", 10: "i2", 11: "u2", 12: "i4", 13: "u4", 14: "i8", 15: "u8"}
_NOT_NUMBERS = {1: "cells", 2: "a structure", 3: "an object", 5: "a sparse matrix"}
_MATRIX, _COMPRESSED = 14, 15


def _elements(path: Path, content: memoryview, order: str) -> Iterator[tuple[int, memoryview]]:
    """Number and content of each element of a mat file, or of a variable in it. No claim may lead out of `content`. A
    tag is a number for the type and a length; up to four bytes of content stand in the tag itself.
    """
    at = 0
    while at < len(content):
        kind, length = (int(v) for v in np.frombuffer(content[at : at + 8].tobytes().ljust(8, b"\0"), f"{order}u4"))
        small = kind >> 16  # up to four bytes stand in the tag itself
        start, kind, length = (at + 4, kind & 0xFFFF, small) if small else (at + 8, kind, length)
        if start + length > len(content) or small > 4:
            refuse(
                path,
                f"is cut short: an element of {length} bytes in the place of {len(content) - start}",
                "copy or export it again",
            )
        yield kind, content[start : start + length]
        at = at + 8 if small else start + length + (0 if kind == _COMPRESSED else -length % 8)


def _mat_header(path: Path, content: memoryview, order: str) -> tuple[str, int, tuple[int, ...]]:
    """Name, flags and shape of a variable, from its beginning."""
    parts = islice(_elements(path, content, order), 3)
    flags, dims, label = (np.frombuffer(part, f"{order}{_STORED[stored]}") for stored, part in parts)
    return label.tobytes().decode("latin1"), int(flags[0]), tuple(int(n) for n in dims)


def _mat_variable(
    path: Path, content: memoryview, order: str, names: Sequence[str], most: int | None
) -> dict[str, Any]:
    """{name: array} of a variable that is one of `names`, empty for others."""
    name, flags, shape = _mat_header(path, content, order)
    kind = flags & 0xFF
    if name not in names:
        return {}
    if kind not in _CLASSES:
        refuse(path, f"holds {name} as {_NOT_NUMBERS.get(kind, 'something else')}", "save it as an array of numbers")
    parts = islice(_elements(path, content, order), 3, None)
    values = [np.frombuffer(part, f"{order}{_STORED[stored]}") for stored, part in parts]
    _claim(path, name, shape, 1, values[0].size if values else 0, most=most)
    if kind == 4:
        return {name: np.array("".join(map(chr, values[0].tolist())))}
    array = values[0].astype(_CLASSES[kind]).reshape(shape, order="F")
    return {name: array + 1j * values[1].reshape(shape, order="F") if flags & 0x800 else array}


def _read_netcdf(path: Path, stream: BinaryIO, names: Sequence[str], most: int | None) -> dict[str, Any]:
    """By xarray, after a look with h5py at whether every part of each variable was written."""
    xarray = netcdf_library()
    import h5py

    with h5py.File(path) as first:  # alone: h5netcdf prints a traceback of its own where this fails
        for name in first:
            _written(path, name, first["/"][name])
    with xarray.open_dataset(path, engine="h5netcdf", decode_times=False, phony_dims="sort") as data:
        found: dict[str, Any] = {}
        for name in names:
            if name in data.variables:
                variable = data.variables[name]
                _claim(path, name, variable.shape, variable.dtype.itemsize)
                found[name] = variable.values
                found[f"units of {name}"] = str(variable.attrs.get("units", ""))
        if "eta" in found:
            spelled = {"time": "t"}
            found["dims"] = tuple(spelled.get(str(d).lower(), str(d).lower()) for d in data.variables["eta"].dims)
            if "t" not in found and "time" in data.variables:
                found["t"], found["units of t"] = data["time"].values, str(data["time"].attrs.get("units", ""))
        found |= {name: data.attrs[name] for name in ("units", "gravity") if name in data.attrs and name not in found}
    return found


def _written(path: Path, name: str, stored: Any) -> None:
    """Refuse a variable of which parts were never written: they would be read as whatever it is filled with. A file
    that a program was killed at, or is still writing, looks whole otherwise.
    """
    if not getattr(stored, "size", 0) or stored.is_virtual or stored.external:
        return
    whole, there = 1, int(stored.id.get_storage_size() > 0)
    if stored.chunks:
        whole = math.prod(-(-n // size) for n, size in zip(stored.shape, stored.chunks, strict=True))
        there = int(stored.id.get_num_chunks())
    unnamed = stored.attrs.get("NAME", b"").startswith(b"This is a netCDF dimension")  # a size only, never written
    if there < whole and name in KNOWN and not unnamed:
        refuse(
            path,
            f"holds {name} of shape {stored.shape}, of which {there} of {whole} parts were ever written",
            "finish writing it, or cut it to what was recorded",
        )

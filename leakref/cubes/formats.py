"""The variables of an npz, mat, HDF5, NetCDF or npy file, read with suspicion.

What a header claims is held against the size of the file before anything is read. `reading` and the exchange with
programs under test read through this. Each reader lists and returns raw variables by name and judges nothing of what
they mean. A damaged file may make a parser raise anything: all of it becomes a LeakrefError.
"""

from __future__ import annotations

import io as streams
import math
import zipfile
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager, nullcontext
from dataclasses import dataclass
from pathlib import Path
from typing import Any, BinaryIO

import numpy as np

from leakref._base import LeakrefError
from leakref.cubes import hdf, matlab
from leakref.cubes.suspicion import DENSEST, HEADER, TooLarge, claim, refuse, size_of, told

__all__ = ["KNOWN", "WAVES", "Listing", "TooLarge", "contents", "raw_variables", "variables"]

Listing = dict[str, tuple[tuple[int, ...], str]]
"""What a file holds: of each variable its shape and the kind of its numbers, or what it is instead."""
WAVES = ("kx", "ky", "omega", "amplitude", "phase")
"""The arrays that describe the waves of a cube with a truth, (n,) each."""
KNOWN = ("eta", "x", "y", "t", "gravity", "depth", "surface_tension", *WAVES, "current", "peak_wavenumber", "units",
         "spacing", "dx", "dy", "dt")  # fmt: skip
"""The variables that are looked for in a cube; others are never unpacked."""


def variables(
    path: Path, names: Sequence[str], *, stream: BinaryIO | None = None, most: int | None = None
) -> dict[str, Any]:
    """Those of the variables `names` that an npz or mat file holds, as arrays, read with the same suspicion as `read`.

    `stream` is the file if it is open already. With `most`, a variable that claims to be more than as many numbers is
    refused, as TooLarge, before anything of it is unpacked. Raises LeakrefError that names file, fault and remedy.

    The type and the shape are those of the file; names that it does not hold are left out.
    """
    return raw_variables(Path(path), names, ("npz", "mat"), stream, most)


def raw_variables(
    path: Path, names: Sequence[str], kinds: Sequence[str] = (), given: BinaryIO | None = None, most: int | None = None
) -> dict[str, Any]:
    """The raw variables of a file, of one of the `kinds` if there are any. Whatever goes wrong is a LeakrefError. That
    is but for a fault of the machine (EIO, no more files, no memory), which is a Trouble. `names` are looked for,
    others are not unpacked. Of a NetCDF file there are also `units of NAME`, `axis of NAME` and `dims of NAME`.
    """
    with _opened(path, given) as (stream, kind):
        if kinds and kind.name not in kinds:
            refuse(path, f"is a file of the kind {kind.name}", f"write {' or '.join(kinds)}")
        return kind.read(path, stream, names, most)


def contents(path: Path) -> Listing:
    """What a file holds, by name, without unpacking the samples. Fields of structures are written with a dot.

    An npy holds one variable, which is called eta. Raises LeakrefError as `raw_variables` does.
    """
    with _opened(path) as (stream, kind):
        return kind.contents(path, stream)


@contextmanager
def _opened(path: Path, given: BinaryIO | None = None) -> Iterator[tuple[BinaryIO, _Kind]]:
    """The file and what it is by its first bytes; whatever goes wrong while it is open is told as it should be."""
    with told(path) as named:
        if not given and path.exists() and not path.is_file():
            what = "is a folder" if path.is_dir() else "is a pipe or a device"
            refuse(path, what, "name the file with the cube in it")
        with nullcontext(given) if given else path.open("rb") as stream:
            start = stream.read(128)
            stream.seek(0)
            kind = _kind(path, start)
            named.append(kind.name)
            yield stream, kind


@dataclass(frozen=True)
class _Kind:
    """A kind of file: how its variables are read, and how they are listed."""

    name: str
    read: Callable[[Path, BinaryIO, Sequence[str], int | None], dict[str, Any]]
    contents: Callable[[Path, BinaryIO], Listing]


def _kind(path: Path, start: bytes) -> _Kind:
    """The format by its first bytes."""
    if start.startswith(b"\x93NUMPY"):
        return _Kind("npy", _read_npy, _list_npy)
    if start.startswith(b"PK"):
        return _Kind("npz", _read_npz, _list_npz)
    if start.startswith(b"MATLAB 7.3"):
        return _Kind("mat (7.3)", hdf.read_mat, hdf.list_mat)
    if start.startswith((b"\x89HDF\r\n", b"CDF\x01", b"CDF\x02")):
        return _Kind("NetCDF", hdf.read_netcdf, hdf.list_netcdf)
    if start[124:128] in (b"\x00\x01IM", b"\x01\x00MI"):
        return _Kind("mat", matlab.read_mat, matlab.list_mat)
    reasons = [
        (not start, "is empty", "export it again"),
        (
            start.startswith((b"# Created by Octave", b"Octave-1")),
            "is in a format of Octave's own",
            "save it with save -v7 in Octave",
        ),
        (
            start[:1] == b"\x80",
            "is a pickle, which is never loaded: it could run anything",
            "save the arrays with numpy.savez",
        ),
    ]
    for holds, fault, remedy in reasons:
        if holds:
            refuse(path, fault, remedy)
    refuse(
        path,
        "is of no kind that is known",
        "pass an npz, mat, NetCDF, zarr or npy file, a folder of PNG or TIFF images, a TIFF stack, an mp4 or an avi",
    )


def _npy_header(path: Path, name: str, stream: Any) -> tuple[tuple[int, ...], bool, np.dtype[Any]]:
    """Shape, Fortran order and type from the header of an npy stream, which is left at the samples."""
    version = np.lib.format.read_magic(stream)
    size = int.from_bytes(claimed := stream.read(2 if version == (1, 0) else 4), "little")
    if size > 2 * HEADER:
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
    claim(path, "eta", shape, dtype.itemsize, size_of(stream) - offset, loaded=False)
    return {"eta": np.memmap(stream, dtype, "r", offset, shape, "F" if fortran else "C")}


def _list_npy(path: Path, stream: BinaryIO) -> Listing:
    shape, _, dtype = _npy_header(path, "eta", stream)
    return {"eta": (shape, str(dtype))}


def _list_npz(path: Path, stream: BinaryIO) -> Listing:
    """From the headers of the members, each read with a limit."""
    found: Listing = {}
    with zipfile.ZipFile(stream) as archive:
        for member in archive.namelist():
            if member.endswith(".npy"):
                with archive.open(member) as content:
                    name = member.removesuffix(".npy")
                    try:
                        shape, _, dtype = _npy_header(path, name, content)
                    except LeakrefError:  # is said if it is asked for
                        found[name] = ((), "objects")
                    else:
                        found[name] = (shape, str(dtype))
    return found


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
            packed = min(info.compress_size, size_of(stream))
            with archive.open(info) as content:
                shape, _, dtype = _npy_header(path, name, content)
                claim(
                    path,
                    name,
                    shape,
                    dtype.itemsize,
                    min(info.file_size, packed * (DENSEST if info.compress_type else 1)),
                    most=most,
                )
                if info.file_size > content.tell() + math.prod(shape) * dtype.itemsize:
                    refuse(path, f"is damaged: {name} of shape {shape} is followed by something", "export it again")
            with archive.open(info) as content:
                found[name] = np.lib.format.read_array(content, allow_pickle=False)
                content.read()  # to the end, where the checksum is compared
    return found

"""Arrays by name in files that any language reads: raw float64, mat, npz, NetCDF 3; and the sums of files.

Every format has the same variables with the same shapes. Written the same way every time, byte for byte, so that a
digest of files is one of what is in them.
"""

from __future__ import annotations

import hashlib
import zlib
from collections.abc import Mapping
from io import BytesIO
from pathlib import Path
from typing import Any, BinaryIO
from zipfile import ZipFile, ZipInfo

import numpy as np
import numpy.typing as npt
from scipy import io

from leakref._base import FloatArray, LeakrefError
from leakref.certify.subject.exchange import opened, taken
from leakref.certify.verdict import Unanswered, Verdict

__all__ = ["FORMATS", "SUFFIX", "checksum", "files", "format_named", "read", "sha256", "write"]

SUFFIX = {"raw": "", "mat": ".mat", "npz": ".npz", "netcdf": ".nc"}
"""Of the file, or the folder, in which the arrays of one question stand, by format."""
FORMATS = tuple(SUFFIX)


def format_named(call: str, name: str) -> str:
    """The format of that name. Raises LeakrefError."""
    if name not in FORMATS:
        raise LeakrefError(call, f"no format is called {name!r}", f"choose one of {', '.join(FORMATS)}")
    return name


def write(path: Path, form: str, arrays: Mapping[str, Any], dims: Mapping[str, tuple[str, ...]] | None = None) -> None:
    """Arrays as little-endian float64 in C order: a file, or for raw a folder with `NAME.f64` for each.

    `dims` are the names of dimensions for NetCDF, by variable, where they have some.
    """
    values = {name: np.ascontiguousarray(value, dtype="<f8") for name, value in arrays.items()}
    if form == "raw":
        path.mkdir(parents=True)
        for name, value in values.items():
            value.tofile(path / f"{name}.f64")
        return
    path.parent.mkdir(parents=True, exist_ok=True)
    with path.open("wb") as stream:
        {"mat": _mat, "npz": _npz, "netcdf": _netcdf}[form](stream, values, dims or {})


def _mat(stream: BinaryIO, values: Mapping[str, FloatArray], dims: Mapping[str, tuple[str, ...]]) -> None:
    io.savemat(stream, dict(values), appendmat=False)
    stream.seek(0)  # the header holds the date: the same arrays are to give the same bytes
    stream.write(b"MATLAB 5.0 MAT-file, written by leakref".ljust(116))


def _npz(stream: BinaryIO, values: Mapping[str, FloatArray], dims: Mapping[str, tuple[str, ...]]) -> None:
    """As numpy.savez, without the date."""
    with ZipFile(stream, "w") as archive:
        for name, value in values.items():
            content = BytesIO()
            np.lib.format.write_array(content, value, allow_pickle=False)
            archive.writestr(ZipInfo(f"{name}.npy"), content.getvalue())


def _netcdf(stream: BinaryIO, values: Mapping[str, FloatArray], dims: Mapping[str, tuple[str, ...]]) -> None:
    """NetCDF 3 with 64-bit offsets, which every library of NetCDF reads."""
    beside = BytesIO()
    with io.netcdf_file(beside, "w", version=2) as dataset:
        for name, value in values.items():
            axes = dims.get(name) or tuple(f"{name}_{n}" for n in range(value.ndim))
            for axis, size in zip(axes, value.shape, strict=True):
                if axis not in dataset.dimensions:
                    dataset.createDimension(axis, size)
            dataset.createVariable(name, "f8", axes)[...] = value
        dataset.flush()
        stream.write(beside.getvalue())


def files(path: Path) -> list[Path]:
    """Those in which the arrays of a question stand, in the order in which sums are taken: by name."""
    return sorted(path.iterdir()) if path.is_dir() else [path]


def sha256(content: bytes) -> str:
    """In hexadecimal digits."""
    return hashlib.sha256(content).hexdigest()


def checksum(content: bytes) -> int:
    """Adler-32 (RFC 1950): what a runner can compute in two lines of any language. It is against stale and damaged
    files; who alters them on purpose is found out by the seed.
    """
    return zlib.adler32(content)


def read(top: Path, path: Path, form: str, shapes: Mapping[str, tuple[int, ...]]) -> dict[str, npt.NDArray[Any]]:
    """The arrays of a file, or a folder, somewhere below the folder `top`, read with the suspicion with which the
    output of every program is read. Raises Unanswered: error if there is none or it is damaged, fail if it holds
    something else. Shapes are those wanted; only raw takes them on, the caller looks at the others.
    """
    if form != "netcdf":
        return {name: taken(top, path, form, name, shape) for name, shape in shapes.items()}
    most = 64 * sum(int(np.prod(shape)) for shape in shapes.values()) + 2**20
    try:
        with opened(top, path) as stream:
            content = stream.read(most + 1)
        if len(content) > most:
            raise Unanswered(Verdict.FAIL, f"its output {path.name} takes more than {most} bytes")
        with io.netcdf_file(BytesIO(content), "r", mmap=False) as dataset:
            return {name: np.array(dataset.variables[name][...], dtype=np.float64) for name in shapes}
    except Unanswered:
        raise
    except Exception as error:  # a damaged file may make a parser raise anything
        words = " ".join(str(error).split()) or type(error).__name__
        raise Unanswered(Verdict.ERROR, f"its output {path.name} cannot be read ({words})") from None

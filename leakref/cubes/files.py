"""Cubes in files: npz, mat (v5), NetCDF and memory-mapped npy, read with suspicion and written whole."""

from __future__ import annotations

import errno
import io as streams
import math
import os
import zipfile
import zlib
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import nullcontext
from dataclasses import dataclass
from io import BytesIO
from itertools import islice
from pathlib import Path
from typing import Any, BinaryIO, NoReturn

import numpy as np
import numpy.typing as npt
from scipy import io

from leakref._base import FloatArray, LARGEST, LeakrefError, Trouble, finite, vector
from leakref._output import write_whole
from leakref.cases import Configuration
from leakref.dispersion import Scales
from leakref.grid import Grid
from leakref.sea import Components
from leakref.synthesis import synthesize

__all__ = ["FORMATS", "UNITS", "Cube", "TooLarge", "netcdf", "netcdf_library", "of_configuration", "read", "variables",
           "write"]

FORMATS = ("npz", "mat", "netcdf")
"""What can be written; read is also a memory-mapped npy."""
UNITS = {"si": "m/s", "scaled": "c0", "given": "the file's units of length / time"}
"""Of a velocity, by the units a file states: SI, the paper's scaled ones (k0 = omega0 = g = 1), or nothing."""
JITTER = 1e-3
"""How far, in spacings, a coordinate may be from its place (float32 coordinates are off by 1e-4)."""
_DENSEST = 1032  # deflate shrinks no further: what claims to hold more than this many times its bytes lies
_HEADER = 1 << 12  # bytes in which a variable says what it is; numpy's own limit is some more
_WAVES = ("kx", "ky", "omega", "amplitude", "phase")
_KNOWN = ("eta", "x", "y", "t", "gravity", *_WAVES, "current", "peak_wavenumber", "units", "spacing",
          "dx", "dy", "dt")
_METRES, _SECONDS = {"m", "metre", "metres", "meter", "meters"}, {"s", "sec", "second", "seconds"}


@dataclass(frozen=True)
class Cube:
    """A surface eta[x, y, t] (array, or memory-mapped) on `grid`, and what its file says about it.

    `units`: "si", "scaled" or "given" (the file does not say). `components` and `current` (2,) are the truth, if
    the file has it. `notes` say what was done to the samples on the way.
    """

    surface: Any
    grid: Grid
    gravity: float
    units: str = "given"
    components: Components | None = None
    current: FloatArray | None = None
    peak_wavenumber: float | None = None
    notes: tuple[str, ...] = ()

    def __post_init__(self) -> None:
        if self.current is not None:
            vector("Cube", current=self.current)


def of_configuration(configuration: Configuration, realization: int, scales: Scales | None = None) -> Cube:
    """Surface and truth of one realisation, in scaled units or those of `scales` (SI, unless its gravity is 1)."""
    to = scales or Scales()
    waves, grid, c = configuration.components(realization), configuration.grid, configuration.current
    if scales:
        dx, dy, dt = grid.spacing
        grid = Grid(grid.shape, (dx * to.length, dy * to.length, dt * to.time))
        waves, c = waves.to_units(to), c * to.velocity
    surface = synthesize(waves, *(grid.samples(axis) for axis in range(3)))
    units = "scaled" if not scales else "given" if to.gravity == 1 else "si"
    return Cube(surface, grid, to.gravity, units, waves, c, to.peak_wavenumber)


# --- writing ---------------------------------------------------------------------------------------------------------


def write(path: Path, cube: Cube, format: str, about: Mapping[str, str] | None = None) -> Path:
    """A cube with all it knows to `path`, whole or not at all, the same bytes every time; `about`: words on its origin.

    Variables as in CONTRACT.md, section 1: eta, x, y, t, gravity, kx, ky, omega, amplitude, phase, current, and
    peak_wavenumber, units. Raises LeakrefError.
    """
    if format not in FORMATS:
        raise LeakrefError("write", f"no format is called {format!r}", f"choose one of {', '.join(FORMATS)}")
    variables: dict[str, Any] = {"eta": np.asarray(cube.surface)}
    variables |= {name: cube.grid.samples(axis) for axis, name in enumerate("xyt")}
    variables["gravity"] = np.float64(cube.gravity)
    if cube.components is not None:
        variables |= {name: getattr(cube.components, name) for name in _WAVES}
    variables |= {name: np.asarray(value, dtype=np.float64) for name in ("current", "peak_wavenumber")
                  if (value := getattr(cube, name)) is not None}
    words = {"units": cube.units, **(about or {})}
    writer: Callable[[Path], object]
    if format == "npz":
        def writer(beside: Path) -> None:
            with beside.open("wb") as stream:  # a stream: given a name, numpy would append .npz to it
                np.savez(stream, allow_pickle=False, **variables, **{key: np.array(w) for key, w in words.items()})
    elif format == "mat":
        def writer(beside: Path) -> None:
            with beside.open("wb") as stream:
                io.savemat(stream, {**variables, **words}, appendmat=False)
                stream.seek(0)  # the header holds the date: the same cube is to give the same bytes
                stream.write(b"MATLAB 5.0 MAT-file, written by leakref".ljust(116))
    else:
        dataset = _dataset(variables, words)

        def writer(beside: Path) -> None:
            beside.write_bytes(netcdf(dataset))
    return write_whole(path, writer)


def netcdf_library() -> Any:
    """xarray, or a LeakrefError that says how to get it."""
    try:
        import h5netcdf  # noqa: F401
        import h5py  # noqa: F401
        import xarray
    except ModuleNotFoundError as error:
        raise LeakrefError("netcdf", f"NetCDF needs {error.name}, which is not installed",
                           "pip install 'leakref[netcdf]', or use npz or mat") from None
    return xarray


def netcdf(dataset: Any) -> bytes:
    """An xarray.Dataset as NetCDF 4. In memory: HDF5 crashes, at the very end, where a disk is full."""
    from h5netcdf import File
    from xarray.backends import H5NetCDFStore

    stream = BytesIO()
    with File(stream, "w") as file:
        dataset.dump_to_store(H5NetCDFStore(file))
    return stream.getvalue()


def _dataset(variables: Mapping[str, Any], words: Mapping[str, str]) -> Any:
    """The variables of a cube as an xarray.Dataset with CF attributes."""
    units = words["units"]
    length, time = ("m", "s") if units == "si" else ("1", "1")
    per = {True: {"k": "m-1", "w": "s-1", "c": "m s-1", "g": "m s-2"}}.get(units == "si", dict.fromkeys("kwcg", "1"))
    about: dict[str, tuple[tuple[str, ...], str, str]] = {
        "eta": (("x", "y", "t"), length, "surface elevation"),
        "x": (("x",), length, "distance along x"), "y": (("y",), length, "distance along y"),
        "t": (("t",), time, "time since the first frame"), "gravity": ((), per["g"], "acceleration due to gravity"),
        "kx": (("wave",), per["k"], "angular wavenumber along x"),
        "ky": (("wave",), per["k"], "angular wavenumber along y"),
        "omega": (("wave",), per["w"], "angular frequency"), "amplitude": (("wave",), length, "amplitude"),
        "phase": (("wave",), "rad", "phase: a cos(kx x + ky y - omega t + phase)"),
        "current": (("component",), per["c"], "true current along x and y"),
        "peak_wavenumber": ((), per["k"], "angular wavenumber of the spectral peak")}
    standard = {"eta": "sea_surface_height_above_mean_sea_level"} if units == "si" else {}
    axis = {name: {"axis": name.upper()} for name in "xyt"}
    dims_values_attributes = {
        name: (about[name][0], value,
               {"units": about[name][1], "long_name": about[name][2], **axis.get(name, {}),
                **({"standard_name": standard[name]} if name in standard else {})})
        for name, value in variables.items()}
    return netcdf_library().Dataset(dims_values_attributes, attrs={"Conventions": "CF-1.10", **words})


# --- reading ---------------------------------------------------------------------------------------------------------


def read(path: Path, *, spacing: Sequence[float] | None = None, axes: str | None = None,
         gravity: float | None = None) -> Cube:
    """The cube in a file, whose kind is told by its first bytes. An npy stays on the disk, memory-mapped.

    `spacing` (dx, dy, dt) is needed where there are no coordinates; `axes`, a permutation of "xyt", is the order in
    which the samples are stored, first index first (default: xyt, or the names of NetCDF's dimensions);
    `gravity` goes before that of the file. No pickle is ever loaded, and what a header claims is held against the
    size of the file before anything is read. Raises LeakrefError that names file, fault and remedy.
    """
    path = Path(path)
    return _cube(path, _variables(path, _KNOWN), spacing, axes, gravity)


def variables(path: Path, names: Sequence[str], *, stream: BinaryIO | None = None,
              most: int | None = None) -> dict[str, Any]:
    """Those of the variables `names` that an npz or mat file holds, as arrays, read with the same suspicion as `read`.

    `stream` is the file if it is open already. With `most`, a variable that claims to be more than as many numbers is
    refused, as TooLarge, before anything of it is unpacked. Raises LeakrefError that names file, fault and remedy.
    """
    return _variables(Path(path), names, ("npz", "mat"), stream, most)


class TooLarge(LeakrefError):
    """A file holds more than there can be."""


def _variables(path: Path, names: Sequence[str], kinds: Sequence[str] = (), given: BinaryIO | None = None,
               most: int | None = None) -> dict[str, Any]:
    """The raw variables of a file, of one of the `kinds` if there are any. Whatever goes wrong is a LeakrefError."""
    kind = "a file"
    try:
        if not given and path.exists() and not path.is_file():
            what = "is a folder" if path.is_dir() else "is a pipe or a device"
            _refuse(path, what, "name the file with the cube in it")
        with nullcontext(given) if given else path.open("rb") as stream:
            start = stream.read(128)
            stream.seek(0)
            kind, reader = _kind(path, start)
            if kinds and kind not in kinds:
                _refuse(path, f"is a file of the kind {kind}", f"write {' or '.join(kinds)}")
            return reader(path, stream, names, most)
    except LeakrefError:
        raise
    except FileNotFoundError:
        _refuse(path, "does not exist", "check the name")
    except PermissionError:
        _refuse(path, "may not be read by you", "ask for permission to read it (chmod +r) or copy it")
    except MemoryError:
        _refuse(path, "does not fit into memory", _AS_NPY)
    except Exception as error:  # parsers of damaged files raise anything: struct.error, zlib.error, KeyError, OSError
        if isinstance(error, OSError) and error.errno in _AROUND:
            raise Trouble("extract", f"{path} cannot be read ({error.strerror})", "see to that and try again") from None
        _refuse(path, f"is damaged or cut short (reading it as {kind} failed: {error or type(error).__name__})",
                "copy or export it again")


_AROUND = (errno.EIO, errno.EMFILE, errno.ENFILE, errno.ENOMEM, errno.ESTALE)  # not the file's fault
_AS_NPY = "save eta with numpy.save as .npy, which is read in blocks, and pass --spacing dx,dy,dt"


def _refuse(path: Path, fault: str, remedy: str) -> NoReturn:
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
    reasons = [(not start, "is empty", "export it again"),
               (start.startswith(b"MATLAB 7.3"), "is a MATLAB 7.3 file", "save it with save(..., '-v7') in MATLAB"),
               (start.startswith((b"# Created by Octave", b"Octave-1")), "is in a format of Octave's own",
                "save it with save -v7 in Octave"),
               (start.startswith(b"CDF"), "is a classic NetCDF file", "convert it with nccopy -k nc4 IN OUT"),
               (start[:1] == b"\x80", "is a pickle, which is never loaded: it could run anything",
                "save the arrays with numpy.savez")]
    for holds, fault, remedy in reasons:
        if holds:
            _refuse(path, fault, remedy)
    _refuse(path, "is of no kind that is known", "pass an npz, mat (v5 to v7), NetCDF (4) or npy file")


def _claim(path: Path, name: str, shape: tuple[int, ...], itemsize: int, available: float = math.inf,
           loaded: bool = True, most: int | None = None) -> None:
    """Refuse what a header claims but the file cannot hold, or memory cannot (a transform needs it four times).

    And what is more than `most` numbers, of 32 bytes or fewer.
    """
    count = math.prod(int(n) for n in shape)
    if most is not None and (count > most or count * itemsize > 32 * most):
        raise TooLarge("extract", f"{path} holds {name} of shape {shape}, {count * itemsize} bytes, should be {most} "
                       f"number{'s' * (most != 1)}", "write what was asked for")
    if count * itemsize > available:
        _refuse(path, f"is cut short: {name} of shape {shape} takes {count * itemsize} bytes, at most {available} are "
                "there", "copy or export it again")
    memory = os.sysconf("SC_PAGE_SIZE") * os.sysconf("SC_PHYS_PAGES") if hasattr(os, "sysconf") else math.inf
    if loaded and 4 * 8 * count > memory:
        _refuse(path, f"holds {name} of shape {shape}, too large for this machine's memory", _AS_NPY)


def _npy_header(path: Path, name: str, stream: Any) -> tuple[tuple[int, ...], bool, np.dtype[Any]]:
    """Shape, Fortran order and type from the header of an npy stream, which is left at the samples."""
    version = np.lib.format.read_magic(stream)
    size = int.from_bytes(claimed := stream.read(2 if version == (1, 0) else 4), "little")
    if size > 2 * _HEADER:
        _refuse(path, f"is damaged: the header of {name} takes {size} bytes", "export it again")
    header = streams.BytesIO(claimed + stream.read(size))
    reader = {(1, 0): np.lib.format.read_array_header_1_0, (2, 0): np.lib.format.read_array_header_2_0}.get(version)
    if reader is None:
        _refuse(path, f"holds {name} in npy format {version}, with named fields", "save plain numbers")
    shape, fortran, dtype = reader(header)
    if dtype.hasobject:
        _refuse(path, f"holds {name} as pickled objects, which are never loaded: they could run anything",
                "save it as an array of numbers")
    return shape, fortran, dtype


def _read_npy(path: Path, stream: BinaryIO, names: Sequence[str], most: int | None) -> dict[str, Any]:
    shape, fortran, dtype = _npy_header(path, "eta", stream)
    offset = stream.tell()
    _claim(path, "eta", shape, dtype.itemsize, _size(stream) - offset, loaded=False)
    return {"eta": np.memmap(stream, dtype, "r", offset, shape, "F" if fortran else "C")}


def _size(stream: BinaryIO) -> int:
    return os.fstat(stream.fileno()).st_size


def _read_npz(path: Path, stream: BinaryIO, names: Sequence[str], most: int | None) -> dict[str, Any]:
    found = {}
    with zipfile.ZipFile(stream) as archive:
        for name in names:
            member = f"{name}.npy"
            if member not in archive.namelist():
                continue
            info = archive.getinfo(member)
            if info.compress_type not in (zipfile.ZIP_STORED, zipfile.ZIP_DEFLATED):  # others unpack without an end
                _refuse(path, f"holds {name} packed in a way that numpy does not", "save it with numpy.savez")
            packed = min(info.compress_size, _size(stream))
            with archive.open(info) as content:
                shape, _, dtype = _npy_header(path, name, content)
                _claim(path, name, shape, dtype.itemsize,
                       min(info.file_size, packed * (_DENSEST if info.compress_type else 1)), most=most)
                if info.file_size > content.tell() + math.prod(shape) * dtype.itemsize:
                    _refuse(path, f"is damaged: {name} of shape {shape} is followed by something", "export it again")
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


_STORED = {1: "i1", 2: "u1", 3: "i2", 4: "u2", 5: "i4", 6: "u4", 7: "f4", 9: "f8", 12: "i8", 13: "u8", 16: "u1",
           17: "u2", 18: "u4"}  # as the samples are stored, by the tag's number; the last three are text
_CLASSES = {4: "U1", 6: "f8", 7: "f4", 8: "i1", 9: "u1", 10: "i2", 11: "u2", 12: "i4", 13: "u4", 14: "i8", 15: "u8"}
_NOT_NUMBERS = {1: "cells", 2: "a structure", 3: "an object", 5: "a sparse matrix"}
_MATRIX, _COMPRESSED = 14, 15


def _elements(path: Path, content: memoryview, order: str) -> Iterator[tuple[int, memoryview]]:
    """Number and content of each element of a mat file, or of a variable in it. No claim may lead out of `content`."""
    at = 0
    while at < len(content):
        kind, length = (int(v) for v in np.frombuffer(content[at : at + 8].tobytes().ljust(8, b"\0"), f"{order}u4"))
        small = kind >> 16  # up to four bytes stand in the tag itself
        start, kind, length = (at + 4, kind & 0xFFFF, small) if small else (at + 8, kind, length)
        if start + length > len(content) or small > 4:
            _refuse(path, f"is cut short: an element of {length} bytes in the place of {len(content) - start}",
                    "copy or export it again")
        yield kind, content[start : start + length]
        at = at + 8 if small else start + length + (0 if kind == _COMPRESSED else -length % 8)


def _mat_header(path: Path, content: memoryview, order: str) -> tuple[str, int, tuple[int, ...]]:
    """Name, flags and shape of a variable, from its beginning."""
    parts = islice(_elements(path, content, order), 3)
    flags, dims, label = (np.frombuffer(part, f"{order}{_STORED[stored]}") for stored, part in parts)
    return label.tobytes().decode("latin1"), int(flags[0]), tuple(int(n) for n in dims)


def _mat_variable(path: Path, content: memoryview, order: str, names: Sequence[str],
                  most: int | None) -> dict[str, Any]:
    """{name: array} of a variable that is one of `names`, empty for others."""
    name, flags, shape = _mat_header(path, content, order)
    kind = flags & 0xFF
    if name not in names:
        return {}
    if kind not in _CLASSES:
        _refuse(path, f"holds {name} as {_NOT_NUMBERS.get(kind, 'something else')}", "save it as an array of numbers")
    parts = islice(_elements(path, content, order), 3, None)
    values = [np.frombuffer(part, f"{order}{_STORED[stored]}") for stored, part in parts]
    _claim(path, name, shape, 1, values[0].size if values else 0, most=most)
    if kind == 4:
        return {name: np.array("".join(map(chr, values[0].tolist())))}
    array = values[0].astype(_CLASSES[kind]).reshape(shape, order="F")
    return {name: array + 1j * values[1].reshape(shape, order="F") if flags & 0x800 else array}


def _read_netcdf(path: Path, stream: BinaryIO, names: Sequence[str], most: int | None) -> dict[str, Any]:
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
    """Refuse a variable of which parts were never written: they would be read as whatever it is filled with."""
    if not getattr(stored, "size", 0) or stored.is_virtual or stored.external:
        return
    whole, there = 1, int(stored.id.get_storage_size() > 0)
    if stored.chunks:
        whole = math.prod(-(-n // size) for n, size in zip(stored.shape, stored.chunks, strict=True))
        there = int(stored.id.get_num_chunks())
    unnamed = stored.attrs.get("NAME", b"").startswith(b"This is a netCDF dimension")  # a size only, never written
    if there < whole and name in _KNOWN and not unnamed:
        _refuse(path, f"holds {name} of shape {stored.shape}, of which {there} of {whole} parts were ever written",
                "finish writing it, or cut it to what was recorded")


# --- judging what was read -------------------------------------------------------------------------------------------


def _cube(path: Path, raw: dict[str, Any], spacing: Sequence[float] | None, axes: str | None,
          gravity: float | None) -> Cube:
    """The checked cube from the variables of a file."""
    notes: list[str] = []
    if "eta" not in raw:
        _refuse(path, f"holds no variable eta (known ones in it: {', '.join(n for n in _KNOWN if n in raw) or 'none'})",
                "store the surface as eta[x, y, t]")
    eta = _ordered(path, raw, axes)
    if eta.dtype.kind in "iu":
        notes.append(f"{eta.dtype} samples were converted to float64")
    units = _units(path, raw)
    g = gravity if gravity is not None else raw.get("gravity")
    if g is None:
        _refuse(path, "does not say its gravity", "pass --gravity: 9.81 for metres and seconds, 1 for scaled units")
    g = _number(path, "gravity", g)
    if gravity is None and (units == "si" and g == 1) != (units == "scaled" and g != 1):
        _refuse(path, f"has mixed units: it says {'SI' if units == 'si' else 'scaled'}, but gravity = {g:g}",
                "correct its units, or say which with --gravity")
    steps = []
    for axis, name in enumerate("xyt"):
        if spacing is not None:
            steps.append(float(spacing[axis]))
        elif name in raw:
            steps.append(_step(path, name, raw[name], eta.shape, axis))
        elif f"d{name}" in raw:
            steps.append(_number(path, f"d{name}", raw[f"d{name}"]))
        else:
            _refuse(path, f"lacks the coordinate {name}", f"store it or d{name}, or pass --spacing dx,dy,dt")
    if spacing is not None and any(name in raw for name in "xyt"):
        notes.append("--spacing was taken instead of the file's coordinates")
    try:
        grid = Grid(eta.shape, (steps[0], steps[1], steps[2]))
        components = Components(*(np.ravel(raw[name]) for name in _WAVES)) if all(n in raw for n in _WAVES) else None
        current = finite("Cube", "current", np.ravel(raw["current"]), 1) if "current" in raw else None
        if not isinstance(eta, np.memmap):
            eta = finite("Cube", "eta", eta, 3)
        peak = _number(path, "peak_wavenumber", raw["peak_wavenumber"]) if "peak_wavenumber" in raw else None
        return Cube(eta, grid, g, units, components, current, peak, tuple(notes))
    except LeakrefError as error:
        raise LeakrefError("extract", str(path) + ": " * (not error.fault.startswith(str(path)))
                           + error.fault.removeprefix(str(path)), error.remedy) from None


def _ordered(path: Path, raw: dict[str, Any], axes: str | None) -> Any:
    """eta as [x, y, t], of plain numbers, at least two samples along each axis."""
    eta, dims = raw["eta"], raw.get("dims")
    if eta.dtype.kind not in "iuf":
        kinds = {"c": ("complex samples", "store the real surface"), "b": ("true and false only", "store the images"),
                 "O": ("objects", "save it as an array of numbers")}
        what, remedy = kinds.get(eta.dtype.kind, (f"samples of type {eta.dtype}", "save it as an array of numbers"))
        _refuse(path, f"holds {what} in eta", remedy)
    if eta.ndim != 3:
        _refuse(path, f"has eta of shape {eta.shape}, {eta.ndim} axes instead of three" +
                (" (one frame is no video)" if eta.ndim == 2 else ""), "store eta[x, y, t]")
    if axes is None:
        axes = "".join(dims) if dims and set(dims) == {"x", "y", "t"} else None if dims else "xyt"
    if axes is None:
        _refuse(path, f"has eta with dimensions {dims}, not x, y and t",
                "rename them, or pass --axes with their order, such as txy")
    if sorted(axes) != ["t", "x", "y"]:
        raise LeakrefError("extract", f"--axes {axes} is not a permutation of xyt", "pass for instance --axes txy")
    eta = eta.transpose([axes.index(name) for name in "xyt"])
    for name, n in zip("xyt", eta.shape, strict=True):
        if n < 2:
            what = f"{n} frame{'s' * (n != 1)}" if name == "t" else f"{n} sample{'s' * (n != 1)} along {name}"
            _refuse(path, f"has only {what}", "record at least two, some ten periods or wavelengths for use")
    return eta


def _number(path: Path, name: str, value: npt.ArrayLike) -> float:
    array = np.asarray(value)
    if array.size != 1 or array.dtype.kind not in "iuf" or not 1 / LARGEST <= array.item() <= LARGEST:
        _refuse(path, f"has {name} = {array.tolist()!r:.60}", f"store {name} as one positive number")
    return float(array.item())


def _units(path: Path, raw: dict[str, Any]) -> str:
    """What the file says about its units: "si", "scaled", or "given" if nothing. Refuses a mixture."""
    word = str(np.asarray(raw.get("units", "")).ravel()[0] if np.size(raw.get("units", "")) else "").strip().lower()
    of = {name: raw.get(f"units of {name}", "").strip().lower().split(" since ")[0] for name in "xyt"}
    of = {name: "" if unit in ("1", "none", "dimensionless") else unit for name, unit in of.items()}
    said = " ".join(f"{name} in {unit or 'no unit'}," for name, unit in of.items()).rstrip(",")
    metric = of["x"] in _METRES and of["y"] in _METRES and of["t"] in _SECONDS
    mixed = any(of.values()) and (not all(of.values()) or (of["x"] != of["y"] and not metric))
    mixed |= (of["x"] in _METRES) != (of["t"] in _SECONDS) or (word == "si" and any(of.values()) and not metric)
    if mixed or (word == "scaled" and any(of.values())):
        _refuse(path, f"has mixed units: {said}" + f", and units = {word}" * bool(word),
                "convert the coordinates to metres and seconds, or to one consistent set, and say so")
    if word not in ("", "si", "scaled", "given"):
        _refuse(path, f"has units = {word!r}", "say si, scaled, or nothing")
    return "si" if metric or word == "si" else word or "given"


def _step(path: Path, name: str, values: npt.ArrayLike, shape: tuple[int, ...], axis: int) -> float:
    """The spacing of a coordinate, the same float that made it where it was made as i d."""
    v = np.ravel(values)
    if v.size != shape[axis]:
        _refuse(path, f"has {v.size} values of {name} for {shape[axis]} samples: eta has shape {shape} as [x, y, t]",
                "pass --axes with the order in which eta is stored, or correct the coordinate")
    if v.dtype.kind not in "iuf" or not np.isfinite(v).all():
        _refuse(path, f"has a coordinate {name} that is not all finite real numbers", "correct it or pass --spacing")
    with np.errstate(over="ignore"):
        v = v.astype(np.float64)
        mean = float(v[-1] - v[0]) / (v.size - 1)
    if not 1 / LARGEST <= abs(mean) <= LARGEST and np.unique(v).size > 1:
        _refuse(path, f"has a coordinate {name} from {v[0]:g} to {v[-1]:g}, beyond all reckoning",
                "give it in units that bring its steps nearer to 1")
    if not np.all(np.diff(v) > 0):
        at = int(np.argmin(np.diff(v) > 0))
        _refuse(path, f"has a coordinate {name} that does not increase: {v[at]:g} is followed by {v[at + 1]:g} "
                f"(index {at})", f"sort it, and reverse eta along {name} with it")
    index = np.arange(v.size)
    first = float(v[1] - v[0])
    off = np.abs(v - (v[0] + index * mean)) / mean
    if off.max() > JITTER:
        at = int(np.argmax(off))
        _refuse(path, f"has a coordinate {name} that is not uniform: {v[at]:g} (index {at}) is {off.max():.2g} "
                "spacings from its place", "interpolate eta onto equal steps")
    return first if np.array_equal(v[0] + index * first, v) else mean

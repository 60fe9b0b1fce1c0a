"""The variables of HDF5 files: MATLAB 7.3 by h5py, NetCDF and zarr by xarray.

Large samples are not read but deferred. In MATLAB's files the axes are stored the other way round and structures are
groups: both are seen as MATLAB shows them, a field as STRUCTURE.FIELD, and in an array of structures as
STRUCTURE(3).FIELD.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import Any, BinaryIO

import numpy as np

from leakref._base import LeakrefError, installed_with
from leakref.cubes.deferred import BLOCK, IN_MEMORY, Deferred
from leakref.cubes.suspicion import claim, refuse

__all__ = ["ATTRIBUTES", "is_zarr", "list_mat", "list_netcdf", "netcdf_library", "read_mat", "read_netcdf"]

Listing = dict[str, tuple[tuple[int, ...], str]]
ATTRIBUTES = ("units", "gravity", "depth", "surface_tension")
"""What a NetCDF file may say in an attribute instead of a variable."""


def netcdf_library() -> Any:
    """xarray, or a LeakrefError that says how to get it."""
    try:
        import h5netcdf  # noqa: F401  what xarray needs for it, asked for here to name what is lacking
        import h5py  # noqa: F401  # which h5netcdf needs
        import xarray
    except ModuleNotFoundError as error:
        raise LeakrefError(
            "netcdf",
            f"NetCDF needs {error.name}, which is not installed",
            f"use npz or mat, or {installed_with('netcdf')}",
        ) from None
    return xarray


def is_zarr(path: Path) -> bool:
    """Whether a folder is a zarr store, of version 2 or 3."""
    return any((path / name).is_file() for name in ("zarr.json", ".zgroup", ".zarray"))


# --- NetCDF and zarr -------------------------------------------------------------------------------------------------
def _open(path: Path) -> Any:
    """The dataset in a NetCDF file of version 3 or 4, or in a zarr store. Nothing of it is read yet."""
    xarray = netcdf_library()
    if path.is_dir():
        try:
            import zarr  # noqa: F401  what xarray needs for it
        except ModuleNotFoundError:
            raise LeakrefError(
                "extract", f"{path} is a zarr store, and zarr is not installed", installed_with("zarr")
            ) from None
        return xarray.open_dataset(path, engine="zarr", decode_times=False, consolidated=False)
    with path.open("rb") as stream:
        classic = stream.read(3) == b"CDF"
    if classic:
        return xarray.open_dataset(path, engine="scipy", decode_times=False)
    return xarray.open_dataset(path, engine="h5netcdf", decode_times=False, phony_dims="sort")


def list_netcdf(path: Path, stream: BinaryIO | None = None) -> Listing:
    """Name, shape and type of each variable."""
    netcdf_library()
    if not path.is_dir():
        _look(path, ())
    with _open(path) as data:
        return {str(name): (tuple(v.shape), str(v.dtype)) for name, v in data.variables.items()}


def read_netcdf(path: Path, stream: BinaryIO | None, names: Sequence[str], most: int | None = None) -> dict[str, Any]:
    """By xarray, after a look with h5py at whether every part of each variable was written. Besides each variable there
    are its units, its axis (X, Y or T, where it says) and its dimensions, under `units of NAME` and so on.
    """
    netcdf_library()
    if not path.is_dir():
        _look(path, names)
    with _open(path) as data:
        found: dict[str, Any] = {}
        for name in [n for n in names if n in data.variables]:
            variable = data.variables[name]
            large = variable.ndim == 3 and 8 * math.prod(variable.shape) > IN_MEMORY
            if not large:
                claim(path, name, variable.shape, variable.dtype.itemsize)
            found[name] = _deferred(path, name, variable) if large else variable.values
            found[f"units of {name}"] = str(variable.attrs.get("units", ""))
            found[f"dims of {name}"] = tuple(str(d) for d in variable.dims)
        for name in data.variables:  # what stands for x, y or t may have any name: it is told by its attributes
            if data[name].ndim == 1:
                about = data[name].attrs
                found[f"axis of {name}"] = str(about.get("axis", "") or _standard(about.get("standard_name", "")))
        found |= {name: data.attrs[name] for name in ATTRIBUTES if name in data.attrs and name not in found}
    return found


def _standard(name: object) -> str:
    """X, Y or T by a CF standard name, empty for others."""
    return {
        "projection_x_coordinate": "X",
        "projection_y_coordinate": "Y",
        "longitude": "X",
        "latitude": "Y",
        "time": "T",
    }.get(str(name), "")


def _deferred(path: Path, name: str, variable: Any) -> Deferred:
    """A large variable of a dataset, which is opened anew when it is read."""

    def blocks(cut: tuple[slice, ...]) -> Iterator[Any]:
        with _open(path) as data:
            wanted = data.variables[name][cut]
            step = max(1, BLOCK // max(1, 8 * math.prod(wanted.shape[1:])))
            for at in range(0, wanted.shape[0], step):
                yield wanted[at : at + step].values

    return Deferred(tuple(variable.shape), variable.dtype, blocks)


def _look(path: Path, names: Sequence[str]) -> None:
    """Refuse an HDF5 file in which a part of one of the variables `names` is lacking. Alone, and first: h5netcdf prints
    a traceback of its own where this fails.
    """
    import h5py

    with path.open("rb") as stream:
        if stream.read(3) == b"CDF":
            return
    with h5py.File(path) as first:
        for name in first:
            stored = first["/"][name]
            if name in names:
                _written(path, name, stored)


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
    if there < whole and not unnamed:
        refuse(
            path,
            f"holds {name} of shape {stored.shape}, of which {there} of {whole} parts were ever written",
            "finish writing it, or cut it to what was recorded",
        )


# --- MATLAB 7.3 ------------------------------------------------------------------------------------------------------
def _mat_datasets(path: Path) -> Iterator[tuple[str, Any]]:
    """Each array of numbers or text in a mat file of version 7.3, by dotted name, while the file is open.

    Raises LeakrefError without h5py.
    """
    try:
        import h5py
    except ModuleNotFoundError:
        raise LeakrefError(
            "extract",
            f"{path} is a MATLAB 7.3 file, which needs h5py",
            f"{installed_with('netcdf')}, or save it as -v7",
        ) from None
    with h5py.File(path) as file:
        found: list[tuple[str, Any]] = []

        def visit(name: str, held: Any) -> None:
            if isinstance(held, h5py.Dataset) and not name.startswith("#"):
                found.extend(_unfolded(file, name.replace("/", "."), held))

        file.visititems(visit)
        yield from found


def _unfolded(file: Any, name: str, held: Any) -> Iterator[tuple[str, Any]]:
    """What a dataset stands for: itself, or for the field of an array of structures, where it is references, each of
    them, numbered from 1 as in MATLAB. References to cells stay what they are.
    """
    structure, _, field = name.rpartition(".")
    if held.dtype.kind != "O" or "MATLAB_class" in held.attrs or not structure:
        yield name, held
        return
    for n, reference in enumerate(held[()].ravel(), 1):  # stored the other way round, so that rows are MATLAB's columns
        yield from _within(file, f"{structure}({n}).{field}", file[reference])


def _within(file: Any, name: str, held: Any) -> Iterator[tuple[str, Any]]:
    """A dataset, or all that is in a group, which is a structure."""
    if not hasattr(held, "keys"):
        yield from _unfolded(file, name, held)
        return
    for inner in held:
        yield from _within(file, f"{name}.{inner}", held[inner])


def list_mat(path: Path, stream: BinaryIO | None = None) -> Listing:
    """Name, shape as MATLAB shows it, and kind of each variable and of each field.

    Nothing of the samples is read. What MATLAB keeps for itself, in #refs# and the like, is left out.
    """
    return {name: (tuple(held.shape[::-1]), _class(held)) for name, held in _mat_datasets(path)}


def _class(held: Any) -> str:
    """What the numbers are: their type, or "text", "cells" and the like."""
    word = held.attrs.get("MATLAB_class", b"")
    word = word.decode() if isinstance(word, bytes) else str(word)
    return "text" if word == "char" else word if held.dtype.kind == "O" else str(held.dtype)


def read_mat(path: Path, stream: BinaryIO | None, names: Sequence[str], most: int | None = None) -> dict[str, Any]:
    """The variables `names` of a mat file of version 7.3, with their axes as MATLAB shows them.

    Text comes as one word, complex numbers as such. Samples of three axes that are larger than memory allows are
    deferred. Cells and other references are refused with a LeakrefError.
    """
    found: dict[str, Any] = {}
    for name, held in _mat_datasets(path):
        if name not in names:
            continue
        kind = _class(held)
        if held.dtype.kind == "O":
            refuse(path, f"holds {name} as {kind or 'references'}", "save it as an array of numbers")
        _written(path, name, held)
        if held.ndim == 3 and 8 * held.size > IN_MEMORY:
            found[name] = _deferred_mat(path, held)
            continue
        claim(path, name, held.shape, held.dtype.itemsize)
        array = np.asarray(held[()])
        if kind == "text":
            found[name] = np.array("".join(map(chr, array.ravel().tolist())))
        elif array.dtype.names == ("real", "imag"):
            found[name] = (array["real"] + 1j * array["imag"]).T
        else:
            found[name] = array.T
    return found


def _deferred_mat(path: Path, held: Any) -> Deferred:
    """A large array in a mat file of version 7.3."""
    name, dtype = held.name, held.dtype

    def blocks(cut: tuple[slice, ...]) -> Iterator[Any]:
        import h5py

        with h5py.File(path) as file:
            stored = file[name]
            rows = range(*cut[0].indices(stored.shape[0]))
            step = max(1, BLOCK // max(1, 8 * math.prod(stored.shape[1:])))
            for at in range(0, len(rows), step):
                part = rows[at : at + step]
                yield stored[(slice(part.start, part.stop, part.step), *cut[1:])]

    return Deferred(tuple(held.shape[::-1]), dtype, blocks, reversed_axes=True)

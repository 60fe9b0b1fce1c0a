"""Cubes in files: made from the cases of the paper, and written whole as npz, mat (v5) or NetCDF.

What is written can be read by NumPy, MATLAB, Octave and xarray; guide protocol, section 14, lists the variables.
Reading is in `reading`, and what a cube is in `cube`; both have their names here too.

A cube read and measured, in the units of its file:

    cube = read(Path("surface.npz"))
    found = analyse(fourier(cube.surface, cube.grid, "hann"), [0.2, 0.3], gravity=cube.gravity)
    print(found.velocities)
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from io import BytesIO
from pathlib import Path
from typing import Any

import numpy as np
from scipy import io

from leakref._base import LeakrefError
from leakref._output import write_whole
from leakref.cases import Configuration
from leakref.cubes.cube import UNITS, Cube
from leakref.cubes.formats import WAVES
from leakref.cubes.hdf import netcdf_library
from leakref.cubes.reading import read
from leakref.dispersion import Scales
from leakref.grid import Grid
from leakref.synthesis import synthesize

__all__ = ["FORMATS", "UNITS", "Cube", "netcdf", "of_configuration", "read", "write"]

FORMATS = ("npz", "mat", "netcdf")
"""What can be written; read is also a memory-mapped npy."""


def of_configuration(configuration: Configuration, realization: int, scales: Scales | None = None) -> Cube:
    """Surface and truth of one realisation, in scaled units or those of `scales` (SI, unless its gravity is 1).

    `realization` counts from 0. The whole surface is made in memory: 176 MB for the paper's L = 10, T = 20. Depth and
    surface tension are those of the water that the waves are in, whatever the configuration says is assumed.
    """
    to = scales or Scales()
    water = configuration.water.to_units(to)
    waves, grid, c = configuration.components(realization), configuration.grid, configuration.current
    if scales:
        dx, dy, dt = grid.spacing
        grid = Grid(grid.shape, (dx * to.length, dy * to.length, dt * to.time))
        waves, c = waves.to_units(to), c * to.velocity
    surface = synthesize(waves, *(grid.samples(axis) for axis in range(3)))
    units = "scaled" if not scales else "given" if to.gravity == 1 else "si"
    return Cube(
        surface,
        grid,
        to.gravity,
        units,
        waves,
        c,
        to.peak_wavenumber,
        depth=water.depth,
        surface_tension=water.surface_tension,
    )


# --- writing ---------------------------------------------------------------------------------------------------------
def write(path: Path, cube: Cube, format: str, about: Mapping[str, str] | None = None) -> Path:
    """A cube with all it knows to `path`, whole or not at all, the same bytes every time; `about`: words on its origin.

    The variables are those of guide protocol, section 14: eta, x, y, t, gravity, kx, ky, omega, amplitude, phase,
    current, peak_wavenumber, units and axes, the order of the axes; of water that is not deep, or has a surface
    tension, also depth and surface_tension. Raises LeakrefError.

    `format` is one of `FORMATS`. The path is returned. LeakrefError is raised for another format, for NetCDF without
    its library, and where nothing can be written.
    """
    if format not in FORMATS:
        raise LeakrefError("write", f"no format is called {format!r}", f"choose one of {', '.join(FORMATS)}")
    variables: dict[str, Any] = {"eta": np.asarray(cube.surface)}
    variables |= {name: cube.grid.samples(axis) for axis, name in enumerate("xyt")}
    variables["gravity"] = np.float64(cube.gravity)
    if (cube.depth, cube.surface_tension) != (np.inf, 0.0):
        variables |= {"depth": np.float64(cube.depth), "surface_tension": np.float64(cube.surface_tension)}
    if cube.components is not None:
        variables |= {name: getattr(cube.components, name) for name in WAVES}
    variables |= {
        name: np.asarray(value, dtype=np.float64)
        for name in ("current", "peak_wavenumber")
        if (value := getattr(cube, name)) is not None
    }
    words = {"units": cube.units, "axes": "xyt", **(about or {})}  # the order, since sides may well be equal
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


def netcdf(dataset: Any) -> bytes:
    """An xarray.Dataset as NetCDF 4. In memory: HDF5 crashes, at the very end, where a disk is full. The bytes of the
    file are returned, for `write_whole`.
    """
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
    si = {"k": "m-1", "w": "s-1", "c": "m s-1", "g": "m s-2", "s": "m3 s-2"}
    per = si if units == "si" else dict.fromkeys(si, "1")
    about: dict[str, tuple[tuple[str, ...], str, str]] = {
        "eta": (("x", "y", "t"), length, "surface elevation"),
        "x": (("x",), length, "distance along x"),
        "y": (("y",), length, "distance along y"),
        "t": (("t",), time, "time since the first frame"),
        "gravity": ((), per["g"], "acceleration due to gravity"),
        "depth": ((), length, "depth of the water"),
        "surface_tension": ((), per["s"], "surface tension over density"),
        "kx": (("wave",), per["k"], "angular wavenumber along x"),
        "ky": (("wave",), per["k"], "angular wavenumber along y"),
        "omega": (("wave",), per["w"], "angular frequency"),
        "amplitude": (("wave",), length, "amplitude"),
        "phase": (("wave",), "rad", "phase: a cos(kx x + ky y - omega t + phase)"),
        "current": (("component",), per["c"], "true current along x and y"),
        "peak_wavenumber": ((), per["k"], "angular wavenumber of the spectral peak"),
    }
    standard = {"eta": "sea_surface_height_above_mean_sea_level"} if units == "si" else {}
    axis = {name: {"axis": name.upper()} for name in "xyt"}
    dims_values_attributes = {
        name: (
            about[name][0],
            value,
            {
                "units": about[name][1],
                "long_name": about[name][2],
                **axis.get(name, {}),
                **({"standard_name": standard[name]} if name in standard else {}),
            },
        )
        for name, value in variables.items()
    }
    return netcdf_library().Dataset(dims_values_attributes, attrs={"Conventions": "CF-1.10", **words})

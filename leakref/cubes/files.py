"""Cubes in files: npz, mat (v5), NetCDF and memory-mapped npy, read with suspicion and written whole.

A file may come from anybody: what it claims is checked before it is believed, and a fault is a LeakrefError with the
file's name and a remedy. What is written can be read by NumPy, MATLAB, Octave and xarray; guide protocol, section 14,
lists the variables. Reading the bytes of each format is in `formats`.

A cube read and measured, in the units of its file:

    cube = read(Path("surface.npz"))
    found = analyse(fourier(cube.surface, cube.grid, "hann"), [0.2, 0.3], gravity=cube.gravity)
    print(found.velocities)
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from io import BytesIO
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt
from scipy import io

from leakref._base import LARGEST, FloatArray, LeakrefError, finite, vector
from leakref._output import write_whole
from leakref.cases import Configuration
from leakref.cubes.formats import KNOWN, WAVES, netcdf_library, raw_variables, refuse
from leakref.dispersion import DEEP, Scales
from leakref.grid import Grid
from leakref.sea import Components
from leakref.synthesis import synthesize

__all__ = ["FORMATS", "UNITS", "Cube", "netcdf", "of_configuration", "read", "write"]

FORMATS = ("npz", "mat", "netcdf")
"""What can be written; read is also a memory-mapped npy."""
UNITS = {"si": "m/s", "scaled": "c0", "given": "the file's units of length / time"}
"""Of a velocity, by the units a file states: SI, the paper's scaled ones (k0 = omega0 = g = 1), or nothing."""
JITTER = 1e-3
"""How far, in spacings, a coordinate may be from its place (float32 coordinates are off by 1e-4)."""
_METRES, _SECONDS = {"m", "metre", "metres", "meter", "meters"}, {"s", "sec", "second", "seconds"}


@dataclass(frozen=True)
class Cube:
    """A surface eta[x, y, t] (array, or memory-mapped) on `grid`, and what its file says about it.

    `units`: "si", "scaled" or "given" (the file does not say). `components` and `current` (2,) are the truth, if the
    file has it. `notes` say what was done to the samples on the way.

    - `surface`: (nx, ny, nt), float64, or the type in the file if it is memory-mapped.
    - `gravity`: in the same units of length and time as the grid.
    - `peak_wavenumber`: rad per length, None if the file does not say.
    - `components`, `current`: None without a truth; the current is along x and y, going to.

    A current that is not two finite numbers is refused with a LeakrefError.
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
    """Surface and truth of one realisation, in scaled units or those of `scales` (SI, unless its gravity is 1).

    `realization` counts from 0. The whole surface is made in memory: 176 MB for the paper's L = 10, T = 20. Raises
    LeakrefError for water that is not deep, since a cube does not say its depth.
    """
    if configuration.water != DEEP:
        fault = f"{configuration.id} is in {configuration.water}, and files say nothing of depth and tension"
        raise LeakrefError("of_configuration", fault, "make its surface by synthesize, and keep its water beside it")
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

    The variables are those of guide protocol, section 14: eta, x, y, t, gravity, kx, ky, omega, amplitude, phase,
    current, peak_wavenumber and units. Raises LeakrefError.

    `format` is one of `FORMATS`. The path is returned. LeakrefError is raised for another format, for NetCDF without
    its library, and where nothing can be written.
    """
    if format not in FORMATS:
        raise LeakrefError("write", f"no format is called {format!r}", f"choose one of {', '.join(FORMATS)}")
    variables: dict[str, Any] = {"eta": np.asarray(cube.surface)}
    variables |= {name: cube.grid.samples(axis) for axis, name in enumerate("xyt")}
    variables["gravity"] = np.float64(cube.gravity)
    if cube.components is not None:
        variables |= {name: getattr(cube.components, name) for name in WAVES}
    variables |= {
        name: np.asarray(value, dtype=np.float64)
        for name in ("current", "peak_wavenumber")
        if (value := getattr(cube, name)) is not None
    }
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
    per = {True: {"k": "m-1", "w": "s-1", "c": "m s-1", "g": "m s-2"}}.get(units == "si", dict.fromkeys("kwcg", "1"))
    about: dict[str, tuple[tuple[str, ...], str, str]] = {
        "eta": (("x", "y", "t"), length, "surface elevation"),
        "x": (("x",), length, "distance along x"),
        "y": (("y",), length, "distance along y"),
        "t": (("t",), time, "time since the first frame"),
        "gravity": ((), per["g"], "acceleration due to gravity"),
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


# --- reading ---------------------------------------------------------------------------------------------------------
def read(
    path: Path, *, spacing: Sequence[float] | None = None, axes: str | None = None, gravity: float | None = None
) -> Cube:
    """The cube in a file, whose kind is told by its first bytes. An npy stays on the disk, memory-mapped.

    `spacing` (dx, dy, dt) is needed where there are no coordinates; `axes`, a permutation of "xyt", is the order in
    which the samples are stored, first index first (default: xyt, or the names of NetCDF's dimensions); `gravity` goes
    before that of the file. No pickle is ever loaded, and what a header claims is held against the size of the file
    before anything is read. Raises LeakrefError that names file, fault and remedy.

    Refused are, among others: no `eta` or one of another number of axes, complex samples, fewer than two along an axis,
    coordinates that are not uniform or of another length, mixed units, no gravity, and samples that are not finite (of
    a memory-mapped file these are found when it is transformed).
    """
    path = Path(path)
    return _cube(path, raw_variables(path, KNOWN), spacing, axes, gravity)


# --- judging what was read -------------------------------------------------------------------------------------------
def _cube(
    path: Path, raw: dict[str, Any], spacing: Sequence[float] | None, axes: str | None, gravity: float | None
) -> Cube:
    """The checked cube from the variables of a file. Each refusal names the variable and what to do. What is only worth
    saying (a conversion, a spacing that was given) is a note.
    """
    notes: list[str] = []
    if "eta" not in raw:
        refuse(
            path,
            f"holds no variable eta (known ones in it: {', '.join(n for n in KNOWN if n in raw) or 'none'})",
            "store the surface as eta[x, y, t]",
        )
    eta = _ordered(path, raw, axes)
    if eta.dtype.kind in "iu":
        notes.append(f"{eta.dtype} samples were converted to float64")
    units = _units(path, raw)
    g = gravity if gravity is not None else raw.get("gravity")
    if g is None:
        refuse(path, "does not say its gravity", "pass --gravity: 9.81 for metres and seconds, 1 for scaled units")
    g = _number(path, "gravity", g)
    if gravity is None and (units == "si" and g == 1) != (units == "scaled" and g != 1):
        refuse(
            path,
            f"has mixed units: it says {'SI' if units == 'si' else 'scaled'}, but gravity = {g:g}",
            "correct its units, or say which with --gravity",
        )
    steps = []
    for axis, name in enumerate("xyt"):
        if spacing is not None:
            steps.append(float(spacing[axis]))
        elif name in raw:
            steps.append(_step(path, name, raw[name], eta.shape, axis))
        elif f"d{name}" in raw:
            steps.append(_number(path, f"d{name}", raw[f"d{name}"]))
        else:
            refuse(path, f"lacks the coordinate {name}", f"store it or d{name}, or pass --spacing dx,dy,dt")
    if spacing is not None and any(name in raw for name in "xyt"):
        notes.append("--spacing was taken instead of the file's coordinates")
    try:
        grid = Grid(eta.shape, (steps[0], steps[1], steps[2]))
        components = Components(*(np.ravel(raw[name]) for name in WAVES)) if all(n in raw for n in WAVES) else None
        current = finite("Cube", "current", np.ravel(raw["current"]), 1) if "current" in raw else None
        if not isinstance(eta, np.memmap):
            eta = finite("Cube", "eta", eta, 3)
        peak = _number(path, "peak_wavenumber", raw["peak_wavenumber"]) if "peak_wavenumber" in raw else None
        return Cube(eta, grid, g, units, components, current, peak, tuple(notes))
    except LeakrefError as error:
        raise LeakrefError(
            "extract",
            str(path) + ": " * (not error.fault.startswith(str(path))) + error.fault.removeprefix(str(path)),
            error.remedy,
        ) from None


def _ordered(path: Path, raw: dict[str, Any], axes: str | None) -> Any:
    """eta as [x, y, t], of plain numbers, at least two samples along each axis."""
    eta, dims = raw["eta"], raw.get("dims")
    if eta.dtype.kind not in "iuf":
        kinds = {
            "c": ("complex samples", "store the real surface"),
            "b": ("true and false only", "store the images"),
            "O": ("objects", "save it as an array of numbers"),
        }
        what, remedy = kinds.get(eta.dtype.kind, (f"samples of type {eta.dtype}", "save it as an array of numbers"))
        refuse(path, f"holds {what} in eta", remedy)
    if eta.ndim != 3:
        refuse(
            path,
            f"has eta of shape {eta.shape}, {eta.ndim} axes instead of three"
            + (" (one frame is no video)" if eta.ndim == 2 else ""),
            "store eta[x, y, t]",
        )
    if axes is None:
        axes = "".join(dims) if dims and set(dims) == {"x", "y", "t"} else None if dims else "xyt"
    if axes is None:
        refuse(
            path,
            f"has eta with dimensions {dims}, not x, y and t",
            "rename them, or pass --axes with their order, such as txy",
        )
    if sorted(axes) != ["t", "x", "y"]:
        raise LeakrefError("extract", f"--axes {axes} is not a permutation of xyt", "pass for instance --axes txy")
    eta = eta.transpose([axes.index(name) for name in "xyt"])
    for name, n in zip("xyt", eta.shape, strict=True):
        if n < 2:
            what = f"{n} frame{'s' * (n != 1)}" if name == "t" else f"{n} sample{'s' * (n != 1)} along {name}"
            refuse(path, f"has only {what}", "record at least two, some ten periods or wavelengths for use")
    return eta


def _number(path: Path, name: str, value: npt.ArrayLike) -> float:
    """One positive number that is in the range of any units. Refuses all else."""
    array = np.asarray(value)
    if array.size != 1 or array.dtype.kind not in "iuf" or not 1 / LARGEST <= array.item() <= LARGEST:
        refuse(path, f"has {name} = {array.tolist()!r:.60}", f"store {name} as one positive number")
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
        refuse(
            path,
            f"has mixed units: {said}" + f", and units = {word}" * bool(word),
            "convert the coordinates to metres and seconds, or to one consistent set, and say so",
        )
    if word not in ("", "si", "scaled", "given"):
        refuse(path, f"has units = {word!r}", "say si, scaled, or nothing")
    return "si" if metric or word == "si" else word or "given"


def _step(path: Path, name: str, values: npt.ArrayLike, shape: tuple[int, ...], axis: int) -> float:
    """The spacing of a coordinate, the same float that made it where it was made as i d. Steps may differ by `JITTER`
    of a spacing, as float32 coordinates do. The coordinate may begin anywhere.
    """
    v = np.ravel(values)
    if v.size != shape[axis]:
        refuse(
            path,
            f"has {v.size} values of {name} for {shape[axis]} samples: eta has shape {shape} as [x, y, t]",
            "pass --axes with the order in which eta is stored, or correct the coordinate",
        )
    if v.dtype.kind not in "iuf" or not np.isfinite(v).all():
        refuse(path, f"has a coordinate {name} that is not all finite real numbers", "correct it or pass --spacing")
    with np.errstate(over="ignore"):
        v = v.astype(np.float64)
        mean = float(v[-1] - v[0]) / (v.size - 1)
    if not 1 / LARGEST <= abs(mean) <= LARGEST and np.unique(v).size > 1:
        refuse(
            path,
            f"has a coordinate {name} from {v[0]:g} to {v[-1]:g}, beyond all reckoning",
            "give it in units that bring its steps nearer to 1",
        )
    if not np.all(np.diff(v) > 0):
        at = int(np.argmin(np.diff(v) > 0))
        refuse(
            path,
            f"has a coordinate {name} that does not increase: {v[at]:g} is followed by {v[at + 1]:g} (index {at})",
            f"sort it, and reverse eta along {name} with it",
        )
    index = np.arange(v.size)
    first = float(v[1] - v[0])
    off = np.abs(v - (v[0] + index * mean)) / mean
    if off.max() > JITTER:
        at = int(np.argmax(off))
        refuse(
            path,
            f"has a coordinate {name} that is not uniform: {v[at]:g} (index {at}) is {off.max():.2g} "
            "spacings from its place",
            "interpolate eta onto equal steps",
        )
    return first if np.array_equal(v[0] + index * first, v) else mean

"""From a file to a checked cube: what was asked, what the file says, and what is taken for granted.

A file may come from anybody: what it claims is checked before it is believed, and a fault is a LeakrefError with the
file's name and a remedy. Reading the bytes of each format is in `formats`, `hdf`, `matlab` and `images`; which variable
is which in `orders`; coordinates in `coordinates`; lost and doubled frames and holes in `mending`.
"""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt

from leakref._base import LARGEST, LeakrefError, finite
from leakref.cubes import hdf, mending
from leakref.cubes.asked import Asked, Assumed
from leakref.cubes.coordinates import Steps, flat, metric_factors, stated_units, steps
from leakref.cubes.cube import Cube
from leakref.cubes.deferred import Deferred
from leakref.cubes.formats import WAVES, contents, raw_variables
from leakref.cubes.images import frames
from leakref.cubes.orders import chosen_variable, order_of, renamed, rows_named
from leakref.cubes.suspicion import refuse
from leakref.cubes.waters import EARTH, water_of
from leakref.grid import Grid
from leakref.sea import Components

__all__ = ["read"]

_ABOUT = "pass --gravity: 9.81 for metres and seconds, 1 for scaled units"


def read(path: Path, **asked: Any) -> Cube:
    """The cube in a file, whose kind is told by its first bytes, or in a folder of images or a zarr store.

    `asked` are the fields of `Asked`, by name: what goes before the file, or says what it leaves open. The order of
    axes is taken from the names of dimensions, or from the sizes of the coordinates where they leave only one; else
    it must be asked for. Rows run downwards in images, where y falls with the index, and where `y` is "down": the
    cube that is returned has y upwards whatever the file has. An npy stays on the disk, memory-mapped. No pickle is
    ever loaded, and what a header claims is held against the size of the file before anything is read. Raises
    LeakrefError that names file, fault and remedy.

    Refused are, among others: a variable that is not there or one of many, another number of axes than three, complex
    samples, fewer than two along an axis, coordinates that are not uniform or of another length, mixed units, no
    gravity, and samples that are not finite (of a memory-mapped file these are found when it is transformed).
    """
    path, options = Path(path), Asked(**asked)
    raw = _raw(path, options)
    try:
        return _cube(path, raw, options)
    except LeakrefError as error:
        if error.fault.startswith(str(path)) or error.fault.startswith("--"):
            raise
        raise type(error)("extract", f"{path}: {error.fault}", error.remedy) from None


def _raw(path: Path, asked: Asked) -> dict[str, Any]:
    """The variables by the names that they have here, with `variable`, what the samples are called in the file."""
    if path.is_dir() and hdf.is_zarr(path):
        held, load = hdf.list_netcdf(path), hdf.read_netcdf
        names = renamed(held, chosen_variable(path, held, asked)[0])
        raw = load(path, None, list(names.values()))
    elif (video := frames(path)) is not None:
        if asked.variable is not None:
            refuse(path, "holds images and no variables", "leave out --variable")
        raw = {"eta": video.samples, "axes": "tyx", "rows": "down", "notes": list(video.notes), "variable": "frames"}
        return raw | ({} if video.stamps is None else {"t": video.stamps, "stamped": True})
    else:
        held = contents(path)
        names = renamed(held, chosen_variable(path, held, asked)[0])
        raw = raw_variables(path, list(names.values()))
    return _by_our_names(raw, names)


def _by_our_names(raw: dict[str, Any], names: Mapping[str, str]) -> dict[str, Any]:
    """What was read, by the names here; `axis` tells of each dimension what its attributes say it is."""
    found = {name: raw[word] for name, word in names.items() if word in raw}
    found |= {name: raw[name] for name in hdf.ATTRIBUTES if name in raw and name not in found}
    with_units = [name for name in (*"xyt", "depth", "surface_tension") if name in names]
    found |= {f"units of {name}": raw.get(f"units of {names[name]}", "") for name in with_units}
    found["coordinate depth"] = "depth" in names and raw.get(f"dims of {names['depth']}") == (names["depth"],)
    dims = raw.get(f"dims of {names['eta']}")
    if dims:
        found["dims"] = dims
        found["axis"] = {dim: raw.get(f"axis of {dim}", "") for dim in dims}
    if not isinstance(found["eta"], Deferred):
        found["eta"] = np.asarray(found["eta"]) if not isinstance(found["eta"], np.memmap) else found["eta"]
    return found | {"variable": names["eta"]}


def _cube(path: Path, raw: dict[str, Any], asked: Asked) -> Cube:
    """The checked cube from the variables of a file. Each refusal names the variable and what to do. What is only worth
    saying (a conversion, a spacing that was given) is a note.
    """
    notes: list[str] = list(raw.pop("notes", []))
    order, of_order = _order(path, raw, asked)
    units, factors = _units(path, raw)
    eta, place = _wanted(path, raw, order, asked)
    _look_at(path, raw["variable"], eta)
    if eta.dtype.kind in "iu":
        notes.append(f"{eta.dtype} samples were converted to float64")
    found = _steps(path, raw, eta.shape, place, factors, asked, notes)
    g, of_gravity = _gravity(path, raw, units, factors, asked)
    water = water_of(path, raw, units, factors, g, asked, notes)
    rows, of_rows = _rows(path, raw, found["y"], eta, asked, notes)
    eta = eta[:: -1 if found["x"].descends else 1, :: -1 if rows == "down" else 1]
    if found["x"].descends:
        notes.append("x falls with the index: the columns were turned round")
    if not isinstance(eta, np.memmap):
        eta, step, lost = mending.mended(path, eta, found["t"], asked, notes)
    else:
        eta, step, lost = mending.mapped(path, eta, found["t"], asked, notes)
    spacing = (found["x"].step, found["y"].step, step)
    grid = Grid(eta.shape, spacing)
    sources = {"axes": of_order, "y": of_rows, "gravity": of_gravity, "step": raw.get("stepped", "the file")}
    sources |= water.sources
    still = (water.depth, water.surface_tension)
    assumed = Assumed(raw["variable"], order, rows, units, g, spacing, *still, sources=sources)
    components, current = _truth(raw, rows == "down" and asked.y == "down" and not found["y"].descends)
    peak = _number(path, "peak_wavenumber", raw["peak_wavenumber"]) if "peak_wavenumber" in raw else None
    return Cube(eta, grid, g, units, components, current, peak, tuple(notes), assumed, *still, lost)


def _order(path: Path, raw: Mapping[str, Any], asked: Asked) -> tuple[str, str]:
    """As `orders.order_of`, of samples that have three axes."""
    eta = raw["eta"]
    if eta.ndim != 3:
        refuse(
            path,
            f"has {raw['variable']} of shape {eta.shape}, {eta.ndim} axes instead of three"
            + (" (one frame is no video)" if eta.ndim == 2 else ""),
            "store eta[x, y, t]",
        )
    return order_of(path, raw, asked)


def _wanted(path: Path, raw: Mapping[str, Any], order: str, asked: Asked) -> tuple[Any, dict[str, slice]]:
    """The samples as [x, y, t], of what was asked for, and which part of each axis that is.

    The cut is made before anything is read, and in the order in which the samples are stored. Refused is one that
    reaches beyond the samples that there are.
    """
    eta, place = raw["eta"], {name: asked.cut[name] for name in "xyt"}
    for name, part in place.items():
        n, option = eta.shape[order.index(name)], "--frames" if name == "t" else "--crop"
        if (part.stop or 0) > n or (part.start or 0) >= n:
            refuse(
                path,
                f"has {n} samples along {name}, {option} asks for up to {part.stop or part.start}",
                f"correct {option}",
            )
    cut = tuple(place[name] for name in order)
    eta = eta.gather(cut) if isinstance(eta, Deferred) else eta[cut]
    return eta.transpose([order.index(name) for name in "xyt"]), place


def _look_at(path: Path, variable: str, eta: Any) -> None:
    """Refuse samples that are no plain numbers, and fewer than two along an axis."""
    if eta.dtype.kind not in "iuf":
        kinds = {
            "c": ("complex samples", "store the real surface"),
            "b": ("true and false only", "store the images"),
            "O": ("objects", "save it as an array of numbers"),
        }
        what, remedy = kinds.get(eta.dtype.kind, (f"samples of type {eta.dtype}", "save it as an array of numbers"))
        refuse(path, f"holds {what} in {variable}", remedy)
    for name, n in zip("xyt", eta.shape, strict=True):
        if n < 2:
            what = f"{n} frame{'s' * (n != 1)}" if name == "t" else f"{n} sample{'s' * (n != 1)} along {name}"
            refuse(path, f"has only {what}", "record at least two, some ten periods or wavelengths for use")


def _steps(
    path: Path,
    raw: dict[str, Any],
    shape: tuple[int, ...],
    place: Mapping[str, slice],
    factors: Mapping[str, float],
    asked: Asked,
    notes: list[str],
) -> dict[str, Steps]:
    """The steps along x, y and t, in the units of the cube."""
    given = list(asked.spacing or [])
    found = {}
    for axis, name in enumerate("xyt"):
        skipped = place[name].step or 1
        if axis < len(given):
            found[name] = Steps(float(given[axis]) * skipped)
        elif name in raw:
            values = np.asarray(raw[name])
            if place[name] != slice(None):
                values = flat(path, name, values)[place[name]]
            found[name] = _scaled(steps(path, name, values, shape, axis), factors[name], name, raw, notes)
        elif f"d{name}" in raw:
            found[name] = Steps(_number(path, f"d{name}", raw[f"d{name}"]) * skipped * factors[name])
        elif given:
            fault = f"--spacing {','.join(map(repr, given))} has no d{name}, and {path} does not say it"
            raise LeakrefError("extract", fault, "pass all three, --spacing dx,dy,dt")
        else:
            refuse(path, f"lacks the coordinate {name}", f"store it or d{name}, or pass --spacing dx,dy,dt")
    if given:
        raw["stepped"] = "--spacing"
        ignored = [name for name in "xyt"[: len(given)] if name in raw and not raw.get("stamped")]
        if ignored:
            notes.append("--spacing was taken instead of the file's coordinates")
    return found


def _scaled(one: Steps, factor: float, name: str, raw: Mapping[str, Any], notes: list[str]) -> Steps:
    """Steps in metres or seconds, with what is to be said of them added to the notes."""
    if one.note:
        notes.append(one.note)
    if factor != 1:
        stated = str(raw.get(f"units of {name}", "")).split(" since ")[0]
        notes.append(f"{name} was converted from {stated} to {'seconds' if name == 't' else 'metres'}")
    return Steps(one.step * factor, one.descends, one.lost, one.doubled, one.note)


def _gravity(
    path: Path, raw: Mapping[str, Any], units: str, factors: Mapping[str, float], asked: Asked
) -> tuple[float, str]:
    """Gravity in the units of the cube, and where it is known from.

    There is no default, since it would be right in some units only. Refused are a file that does not say it, one whose
    units contradict it, and one whose lengths or times were converted while its gravity was not.
    """
    g = asked.gravity if asked.gravity is not None else raw.get("gravity")
    if g is None:
        refuse(path, "does not say its gravity", _ABOUT)
    g = _number(path, "gravity", g)
    if asked.gravity is not None:
        return g, "--gravity"
    if (units == "si" and g == 1) != (units == "scaled" and g != 1):
        refuse(
            path,
            f"has mixed units: it says {'SI' if units == 'si' else 'scaled'}, but gravity = {g:g}",
            "correct its units, or say which with --gravity",
        )
    if any(factor != 1 for factor in factors.values()) and not EARTH[0] < g < EARTH[1]:
        refuse(path, f"was converted to metres and seconds, but says gravity = {g:g}", "pass --gravity 9.81")
    return g, "the file"


def _rows(path: Path, raw: Mapping[str, Any], y: Steps, eta: Any, asked: Asked, notes: list[str]) -> tuple[str, str]:
    """Whether the rows run "up" or "down", and where that is known from.

    A coordinate decides, then the kind of the file, then the name of the dimension. Where none of them says it rows are
    taken to run upwards, which is said; of samples that may be images it is said as a warning.
    """
    if y.descends and asked.y == "up":
        refuse(
            path,
            "has a y that falls with the index, so that its rows run downwards, but --y up was asked for",
            "leave out --y, or pass --spacing instead of the coordinates",
        )
    if asked.y is not None:
        return asked.y, "--y"
    if y.descends:
        return "down", "y falls with the index"
    if "rows" in raw:
        return str(raw["rows"]), "as images are; --y up if not"
    if "y" in raw and asked.spacing is None:
        return "up", "y rises with the index"
    if rows_named(raw.get("dims")):
        return "down", "its dimension is called row; --y up if not"
    if eta.dtype.kind == "u":
        notes.append(
            f"WARNING: y was taken to rise with the index, but {eta.dtype} samples may be images, whose rows run "
            "downwards: pass --y down if so (the current along y comes out reversed otherwise), or --y up"
        )
    return "up", "by default; --y down if rows run downwards"


def _truth(raw: Mapping[str, Any], mirrored: bool) -> tuple[Components | None, Any]:
    """The waves and the current that a file states, in the frame of the cube: if its y was counted downwards the
    current is mirrored, and the waves are left out.
    """
    current = finite("Cube", "current", np.ravel(raw["current"]), 1) if "current" in raw else None
    if mirrored:
        return None, None if current is None or current.shape != (2,) else current * [1, -1]
    waves = Components(*(np.ravel(raw[name]) for name in WAVES)) if all(n in raw for n in WAVES) else None
    return waves, current


def _number(path: Path, name: str, value: npt.ArrayLike) -> float:
    """One positive number that is in the range of any units. Refuses all else."""
    array = np.asarray(value)
    if array.size != 1 or array.dtype.kind not in "iuf" or not 1 / LARGEST <= array.item() <= LARGEST:
        refuse(path, f"has {name} = {array.tolist()!r:.60}", f"store {name} as one positive number")
    return float(array.item())


def _units(path: Path, raw: Mapping[str, Any]) -> tuple[str, dict[str, float]]:
    """What the file says about its units: "si", "scaled", or "given" if nothing; and what x, y and t are multiplied by
    to be in metres and seconds. Refuses a mixture.
    """
    word = str(np.asarray(raw.get("units", "")).ravel()[0] if np.size(raw.get("units", "")) else "").strip().lower()
    of, as_they_are = stated_units(raw), dict.fromkeys("xyt", 1.0)
    if (factors := metric_factors(of)) is not None and word in ("", "si", "given"):
        return "si", factors
    said = " ".join(f"{name} in {unit or 'no unit'}," for name, unit in of.items()).rstrip(",")
    degrees = any("degree" in unit for unit in of.values())
    mixed = any(of.values()) and (not all(of.values()) or of["x"] != of["y"])
    mixed |= (
        metric_factors({**of, "t": "s"}) is not None or metric_factors({"x": "m", "y": "m", "t": of["t"]}) is not None
    )
    if mixed or (word in ("scaled", "si") and any(of.values())):
        refuse(
            path,
            f"has mixed units: {said}" + f", and units = {word}" * bool(word),
            "convert the coordinates to metres and seconds, or to one consistent set, and say so"
            + " (a degree of latitude is 111.2 km)" * degrees,
        )
    if word not in ("", "si", "scaled", "given"):
        refuse(path, f"has units = {word!r}", "say si, scaled, or nothing")
    return word or "given", as_they_are

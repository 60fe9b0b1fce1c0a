"""Which variable of a file holds the samples, in which order its axes are stored, and where its rows run.

Nothing is guessed: where neither the names of dimensions nor the sizes of coordinates leave only one order, it is asked
for. Each answer comes with its source, in words.
"""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from itertools import permutations
from pathlib import Path
from typing import Any

from leakref.cubes.asked import Asked
from leakref.cubes.coordinates import flat
from leakref.cubes.formats import KNOWN, WAVES, Listing
from leakref.cubes.suspicion import refuse

__all__ = ["axis_names", "chosen_variable", "order_of", "renamed", "rows_named"]

_SPELLED = {
    "x": (
        "x",
        "X",
        "xc",
        "xs",
        "x_m",
        "col",
        "cols",
        "column",
        "columns",
        "east",
        "easting",
        "gridX",
        "lon",
        "longitude",
    ),
    "y": ("y", "Y", "yc", "ys", "y_m", "row", "rows", "north", "northing", "gridY", "lat", "latitude"),
    "t": ("t", "T", "time", "Time", "times", "tt", "timestamp", "timestamps", "frame", "frames"),
    "gravity": ("gravity", "g"),
    "depth": ("depth", "water_depth"),
    "dt": ("dt", "Dt", "delta_t"),
}
"""Names under which the variables of a cube are found; the first is the name here."""
_ROWS = ("row", "rows")
_NUMBERED = re.compile(r"\(\d+\)")  # one of an array of structures


def _listed(contents: Listing) -> str:
    """What a file holds, for messages: names and shapes, at most a dozen; alike ones of an array of structures once."""
    alike: dict[tuple[str, str], list[str]] = {}
    for name, (shape, kind) in contents.items():
        what = f"{' x '.join(map(str, shape)) or 'scalar'} {kind}"
        alike.setdefault((_NUMBERED.sub("(...)", name), what), []).append(name)
    words = [f"{names[0]}{f' to {names[-1]}' * (len(names) > 1)} {what}" for (_, what), names in alike.items()]
    return ", ".join(words[:12]) + (f" and {len(words) - 12} more" if len(words) > 12 else "") or "nothing"


def chosen_variable(path: Path, contents: Listing, asked: Asked) -> tuple[str, str]:
    """The name of the samples in a file, and where it is known from: asked for, called eta, the only one of three axes.

    Refused, with a list of what the file holds, is a name that it does not hold, no such variable, and several.
    """
    if asked.variable is not None:
        if asked.variable not in contents:
            refuse(
                path, f"holds no variable {asked.variable}: it holds {_listed(contents)}", "name one with --variable"
            )
        return asked.variable, "--variable"
    if "eta" in contents:
        return "eta", ""
    cubes = [name for name, (shape, _) in contents.items() if len(shape) == 3 and min(shape) > 1]
    if len(cubes) == 1:
        return cubes[0], "the only variable with three axes"
    what = (
        f"holds {len(cubes)} variables with three axes" if cubes else "holds no variable eta and none with three axes"
    )
    remedy = "store the surface as eta[x, y, t], or name it with --variable"
    numbered = [name for name in contents if _NUMBERED.search(name)]
    if numbered and cubes:
        remedy += f", as in --variable '{cubes[0]}'"
    elif numbered:
        remedy += f"; frames in an array of structures are stacked by eta = cat(3, {_NUMBERED.sub('', numbered[0])})"
    refuse(path, f"{what}: it holds {_listed(contents)}", remedy)


def renamed(contents: Listing, variable: str) -> dict[str, str]:
    """The name in the file of each known variable that it holds, by the name here.

    Those that stand in the same structure as the samples go first: beside IMG_SEQ.IMG, IMG_SEQ.dt is dt.
    """
    prefix = variable.rpartition(".")[0]
    found = {"eta": variable}
    for name in (*KNOWN[1:], "axes"):
        spelled = _SPELLED.get(name, (name,))
        there = [s for p in ([f"{prefix}.", ""] if prefix else [""]) for s in (p + word for word in spelled)]
        held = [word for word in there if word in contents and word != variable]
        if held:
            found[name] = held[0]
    return found


def axis_names(dims: Sequence[str], about: Mapping[str, str]) -> str | None:
    """The order of axes by the names of dimensions, or by what is `about` their coordinates (X, Y or T); None if
    not all three are told.
    """
    order = []
    for dim in dims:
        by_name = [axis for axis in "xyt" if dim in _SPELLED[axis] or dim.lower() in _SPELLED[axis]]
        order.append((str(about.get(dim, "")).lower() or "".join(by_name[:1]))[:1])
    return "".join(order) if sorted(order) == ["t", "x", "y"] else None


def order_of(path: Path, raw: Mapping[str, Any], asked: Asked) -> tuple[str, str]:
    """The order of the axes of `eta`, first index first, and where it is known from. Refuses what leaves it open.

    In this order: what was asked for; what the file says; a cube of `leakref export`; the names of its dimensions, if
    the sizes of the coordinates agree; those sizes, if only one order fits them. Sides that are equal leave it open.
    """
    shape, dims = raw["eta"].shape, raw.get("dims")
    if asked.axes is not None:
        return asked.axes, "--axes"
    if "axes" in raw and sorted(str(raw["axes"])) == ["t", "x", "y"]:
        return str(raw["axes"]), "the file"
    if all(name in raw for name in WAVES) and not dims:  # a cube of leakref export, whose order is laid down
        return "xyt", "a cube with its waves"
    named = axis_names(dims, raw.get("axis", {})) if dims else None
    sizes = {name: flat(path, name, raw[name]).size for name in "xyt" if name in raw}
    fitting = [
        "".join(order)
        for order in permutations("xyt")
        if all(shape[order.index(name)] == n for name, n in sizes.items())
    ]
    if named in fitting:
        return str(named), "the names of the dimensions"
    if len(fitting) == 1:
        return fitting[0], "the sizes of the coordinates"
    if not fitting:
        name, n = next(((name, n) for name, n in sizes.items() if n not in shape), next(iter(sizes.items())))
        refuse(
            path,
            f"has {n} values of {name} for {shape['xyt'.index(name)]} samples: {raw['variable']} of shape {shape} "
            "fits the sizes of its coordinates in no order",
            "correct the coordinate, or pass --spacing and --axes with the order in which it is stored",
        )
    there = f"fits {', '.join(fitting)} alike" if sizes else "says nothing of the order of its axes"
    called = f", its dimensions being {', '.join(dims)}" if dims else ""
    refuse(
        path,
        f"has {raw['variable']} of shape {shape}, which {there}{called}",
        "pass --axes with the order in which it is stored, first index first: txy or xyt, tyx for images",
    )


def rows_named(dims: Sequence[str] | None) -> bool:
    """Whether the dimensions are called rows, which run downwards unless a coordinate says otherwise."""
    return bool(dims) and any(dim.lower() in _ROWS for dim in dims or ())

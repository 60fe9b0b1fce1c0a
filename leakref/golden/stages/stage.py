"""What a stage with golden values is, and what several of them share.

Stages are made of small functions from an input to an output, both mappings from names to plain values. This module has
those that several stages share: how grids, waves and spectra come out of an input, and how roundings are counted
(`relative`, `turns`). The stages themselves are in the modules beside it.

A stage is its equation, the routes, the oracle and the conditioning. With one route, it reads:

    Stage("eq:JONSWAP", {"chain": compute}, by_oracle, conditioning)

where `compute(given)` returns `{"density": array}`, `by_oracle(given, first)` the same with 40 digits, and
`conditioning(given, found)` one number or one for each item.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from leakref import leakage
from leakref.dispersion import Water
from leakref.grid import Grid
from leakref.sea import Components
from leakref.spectrum import Spectrum, fourier
from leakref.synthesis import synthesize

__all__ = [
    "Stage",
    "as_floats",
    "both_routes",
    "by_surface",
    "grid_of",
    "in_closed_form",
    "in_water",
    "largest",
    "listed",
    "plain",
    "real_and_imaginary",
    "relative",
    "rounded",
    "turns",
    "water_of",
    "waters",
    "waves_of",
]

Input = Mapping[str, Any]
"""An entry's input, by name: numbers and lists as JSON has them."""
Output = dict[str, Any]
"""Outputs by name, arrays or what becomes one; `notes` are lists of names."""
Route = Callable[[Input], Output]
WAVE = ("kx", "ky", "omega", "amplitude", "phase")


@dataclass(frozen=True)
class Stage:
    """How one stage's golden values are computed. `oracle` gets what the first route found: optima start there.

    - `equation`: the paper's label; `routes`: by name, ways to compute the outputs that must agree.
    - `oracle`: the outputs with 40 digits; None if the first route's are kept.
    - `conditioning`: for each output one number or one for each item of its first axis, in its own unit: how far it
      moves if every rounding on the way is one unit of 2^-52.
    """

    equation: str
    routes: Mapping[str, Callable[[Input], Output]]
    oracle: Callable[[Input, Output], Output] | None
    conditioning: Callable[[Input, Output], Output]


def as_floats(value: Any) -> Any:
    """mpmath numbers in nested lists to floats, correctly rounded. Anything that `float` takes is taken as an mpmath
    number.
    """
    if isinstance(value, list | tuple):
        return [as_floats(item) for item in value]
    return float(value)


def largest(value: Any) -> float:
    """The largest absolute value of nested lists, NaN aside. 0 for an empty one."""
    return float(np.nanmax(np.abs(np.asarray(value, dtype=np.float64)), initial=0.0))


def relative(factor: float, *exact: str) -> Callable[[Input, Output], Output]:
    """`factor` roundings of the largest item of each output; those named `exact` none.

    Returned is a function for `Stage.conditioning`. `factor` is the number of roundings on the way, as they can be
    counted in the code.
    """
    return lambda given, found: {
        name: 0.0 if name in exact else factor * largest(value) for name, value in found.items()
    }


def in_water(factor: float) -> Callable[[Input, Output], Output]:
    """The same with eight roundings more where the water is not deep: of k h, its tanh and 2 k h / sinh(2 k h), of
    k^2 S / g, and of the products of these.
    """

    def conditioning(given: Input, found: Output) -> Output:
        deep = not {"depth", "surface_tension"} & given.keys()
        return relative(factor if deep else factor + 8)(given, found)

    return conditioning


def grid_of(given: Input) -> Grid:
    """The grid of an entry."""
    return Grid(tuple(given["shape"]), tuple(given["spacing"]))


def water_of(given: Input) -> Water:
    """The water of an entry: of its `gravity`, 1 if it names none, and deep, without tension, unless it says so."""
    return Water(given.get("gravity", 1.0), given.get("depth", np.inf), given.get("surface_tension", 0.0))


def waters(given: Input) -> dict[str, Any]:
    """The same as the oracle takes it: a `depth` of None has no bottom."""
    return {
        "gravity": given.get("gravity", 1.0),
        "depth": given.get("depth"),
        "surface_tension": given.get("surface_tension", 0),
    }


def waves_of(given: Input) -> Components:
    """The waves of an entry."""
    return Components(*(np.asarray(given[name], dtype=np.float64) for name in WAVE))


def listed(given: Input) -> list[Any]:
    """The parameters of the waves of an entry as the oracle takes them."""
    return [given[name] for name in WAVE]


def real_and_imaginary(values: Any) -> Output:
    """Complex values as two outputs."""
    return {"real": np.real(values), "imag": np.imag(values)}


def rounded(found: Any) -> Output:
    """Complex numbers of the oracle as floats; what is zero but for its own rounding is zero.

    `found` are nested lists; returned are the outputs `real` and `imag`. Parts below 1e-30 of the largest are zero.
    """

    def part(nested: Any, name: str) -> Any:
        return [part(v, name) for v in nested] if isinstance(nested, list) else float(getattr(nested, name))

    parts = {name: np.array(part(found, name)) for name in ("real", "imag")}
    noise = 1e-30 * max(float(np.abs(v).max()) for v in parts.values())
    return {name: np.where(np.abs(v) < noise, 0.0, v) for name, v in parts.items()}


def turns(given: Input) -> float:
    """Roundings of an item of S over its largest: turns of phase formed, and the stages of the FFT.

    A wave whose phase is formed as a product has that phase wrong by as many roundings as it has radians: the sum of `k
    x` over each side of the cube, and its own. A surface that is given has only the stages of the FFT, log2 of its
    size.
    """
    grid = grid_of(given)
    stages = float(np.log2(np.prod(grid.shape)))
    if "kx" not in given:
        return 4 + stages
    return (
        4
        + stages
        + float(
            sum(largest(given[name]) * side for name, side in zip(("kx", "ky", "omega"), grid.lengths, strict=True))
            + largest(given["phase"])
        )
    )


def by_surface(given: Input) -> Spectrum:
    """The spectrum of the waves of an entry by route A, or of the surface that it gives."""
    grid = grid_of(given)
    eta = given.get("surface")
    if eta is None:
        eta = synthesize(waves_of(given), *(grid.samples(axis) for axis in range(3)))
    return fourier(eta, grid, given["window"], workers=1)


def in_closed_form(given: Input) -> Spectrum:
    """The spectrum of the waves of an entry by route B."""
    return leakage.spectrum(waves_of(given), grid_of(given), given["window"])


def both_routes(make: Callable[[Callable[[Input], Spectrum]], Route]) -> dict[str, Route]:
    """The same by the surface and the FFT (A) and in closed form (B).

    `make` gets the function that turns an input into a Spectrum, and gives the route.
    """
    return {"A": make(by_surface), "B": make(in_closed_form)}


def plain(found: Output) -> Output:
    """Outputs as floats in nested lists or arrays, whoever computed them. `notes` are left as they are."""
    return {
        name: value
        if name == "notes"
        else np.array(
            as_floats(value) if isinstance(value, list | tuple) else np.asarray(value, dtype=np.float64),
            dtype=np.float64,
        )
        for name, value in found.items()
    }

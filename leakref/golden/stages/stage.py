"""What a stage with golden values is, and what several of them share."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from leakref import leakage
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
    "largest",
    "listed",
    "plain",
    "real_and_imaginary",
    "relative",
    "rounded",
    "turns",
    "waves_of",
]

Input = Mapping[str, Any]
Output = dict[str, Any]
Route = Callable[[Input], Output]
WAVE = ("kx", "ky", "omega", "amplitude", "phase")


@dataclass(frozen=True)
class Stage:
    """How one stage's golden values are computed. `oracle` gets what the first route found: optima start there."""

    equation: str
    routes: Mapping[str, Callable[[Input], Output]]
    oracle: Callable[[Input, Output], Output] | None
    conditioning: Callable[[Input, Output], Output]


def as_floats(value: Any) -> Any:
    """mpmath numbers in nested lists to floats, correctly rounded."""
    if isinstance(value, list | tuple):
        return [as_floats(item) for item in value]
    return float(value)


def largest(value: Any) -> float:
    """The largest absolute value of nested lists, NaN aside."""
    return float(np.nanmax(np.abs(np.asarray(value, dtype=np.float64)), initial=0.0))


def relative(factor: float, *exact: str) -> Callable[[Input, Output], Output]:
    """`factor` roundings of the largest item of each output; those named `exact` none."""
    return lambda given, found: {
        name: 0.0 if name in exact else factor * largest(value) for name, value in found.items()
    }


def grid_of(given: Input) -> Grid:
    """The grid of an entry."""
    return Grid(tuple(given["shape"]), tuple(given["spacing"]))


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
    """Complex numbers of the oracle as floats; what is zero but for its own rounding is zero."""

    def part(nested: Any, name: str) -> Any:
        return [part(v, name) for v in nested] if isinstance(nested, list) else float(getattr(nested, name))

    parts = {name: np.array(part(found, name)) for name in ("real", "imag")}
    noise = 1e-30 * max(float(np.abs(v).max()) for v in parts.values())
    return {name: np.where(np.abs(v) < noise, 0.0, v) for name, v in parts.items()}


def turns(given: Input) -> float:
    """Roundings of an item of S over its largest: turns of phase formed, and the stages of the FFT."""
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
    """The same by the surface and the FFT (A) and in closed form (B)."""
    return {"A": make(by_surface), "B": make(in_closed_form)}


def plain(found: Output) -> Output:
    """Outputs as floats in nested lists or arrays, whoever computed them."""
    return {
        name: value
        if name == "notes"
        else np.array(
            as_floats(value) if isinstance(value, list | tuple) else np.asarray(value, dtype=np.float64),
            dtype=np.float64,
        )
        for name, value in found.items()
    }

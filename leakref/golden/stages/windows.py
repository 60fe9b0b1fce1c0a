"""Windows: samples, responses, lobes and their figures.

The stages are `window` (samples, eq:hann), `response` (the transform of a wave between bins, by closed form and by
plain sums), `lobes` (the continuous transform, fig:leakage_lobes) and `figures` (first zero, widths, sidelobes and
bandwidth, app:window_comparison). Positions and widths are in bins, levels over that at the centre.

- `window`: `window`, `size`; `w` (size,).
- `response`: `window`, `bins` (b,), `positions` (p,), `size`; `real` and `imag`, (b, p).
- `lobes`: `window`, `offsets` (n,); `lobe` (n,).
- `figures`: `window`; eight numbers by name.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np

from leakref._base import FloatArray
from leakref.golden import oracle
from leakref.golden.stages.stage import Input, Output, Stage, largest, relative, rounded
from leakref.window import window

__all__ = ["STAGES"]


def _response(given: Input) -> Output:
    """The transform of a wave at a position between bins, as the chain has it."""
    found = window(given["window"]).response(given["bins"], given["positions"], given["size"])
    return {"real": found.real, "imag": found.imag}


def _summed_response(given: Input) -> Output:
    """Sample by sample, the whole turns taken out first."""
    n, u, m = np.array(given["bins"]), np.array(given["positions"]), np.arange(given["size"])
    turn = (n[:, None, None] - np.rint(u)[:, None]) * m % given["size"] - (u - np.rint(u))[:, None] * m
    found = np.exp(-2j * np.pi * turn / given["size"]) @ window(given["window"]).samples(given["size"])
    return {"real": found.real, "imag": found.imag}


def _response_by_oracle(given: Input, _: Output) -> Output:
    return rounded(
        [[oracle.kernel(given["window"], n, u, given["size"]) for u in given["positions"]] for n in given["bins"]]
    )


def _response_conditioning(given: Input, _: Output) -> Output:
    """Whole turns are taken out first, only the remainder rounds; Kaiser-Bessel is summed with all its turns."""
    turns = 2 * np.pi * np.abs(given["positions"]).max() if given["window"] == "kaiser-bessel" else 0.0
    rounding = given["size"] * (16 + turns)
    return {"real": float(rounding), "imag": float(rounding)}


def _lobes(given: Input) -> Output:
    """The continuous transform at offsets in bins, from its closed form."""
    return {"lobe": window(given["window"]).transform(given["offsets"])}


def _lobes_integrated(given: Input) -> Output:
    """By Gauss-Legendre quadrature of the window itself."""
    nodes, weights = np.polynomial.legendre.leggauss(60)
    s = (nodes + 1) / 2
    taper = np.interp(s, [0, 1], [1, 1]) if given["window"] == "box" else _continuous(given["window"], s)
    return {"lobe": [float(np.sum(weights / 2 * taper * np.cos(2 * np.pi * v * (s - 0.5)))) for v in given["offsets"]]}


def _continuous(name: str, s: FloatArray) -> FloatArray:
    """The window between its samples, (n,)."""
    taper = window(name)
    if taper.coefficients:
        terms = ((-1) ** j * a * np.cos(2 * np.pi * j * s) for j, a in enumerate(taper.coefficients))
        return sum(terms, np.zeros(s.size))
    from scipy.special import i0

    from leakref.window import KAISER_SHAPE

    return i0(KAISER_SHAPE * np.sqrt(1 - (2 * s - 1) ** 2)) / i0(KAISER_SHAPE)


_ZERO = {"box": 1.0, "hann": 2.0, "blackman": 3.0, "kaiser-bessel": 2.0}  # where to look for it


def _tops(level: Callable[[float], Any], zero: float) -> list[float]:
    """Roughly where the sidelobes have their tops, on a lattice."""
    v = np.arange(zero + 0.02, zero + 6, 0.02)
    height = np.abs([float(level(float(u))) for u in v])
    return [float(v[n]) for n in range(1, v.size - 1) if height[n - 1] < height[n] >= height[n + 1]]


def _figures(given: Input) -> Output:
    """Zeros and levels of the lobe by bracketing, the highest sidelobe by a search near each top, the noise bandwidth
    by quadrature of the squared window. Widths and the first zero are in bins, levels over that of the centre.
    """
    from scipy.optimize import brentq, minimize_scalar

    taper, start = window(given["window"]), _ZERO[given["window"]]

    def level(v: float) -> float:
        return float(taper.transform(v) / taper.transform(0.0))

    zero = brentq(level, start - 0.02, start + 0.02, xtol=1e-15)
    side = min(
        minimize_scalar(
            lambda v: -abs(level(v)), bounds=(top - 0.02, top + 0.02), method="bounded", options={"xatol": 1e-10}
        ).fun
        for top in _tops(level, zero)
    )
    three, six = (
        2 * brentq(lambda v, part=part: level(v) - part, 0.01, zero, xtol=1e-15) for part in (np.sqrt(0.5), 0.5)
    )
    nodes, weights = np.polynomial.legendre.leggauss(60)
    square = float(np.sum(weights / 2 * _continuous(given["window"], (nodes + 1) / 2) ** 2))
    gain = float(taper.transform(0.0))
    return {
        "first_zero": zero,
        "width_3db": three,
        "width_6db": six,
        "peak_sidelobe": -side,
        "peak_sidelobe_db": 20 * np.log10(-side),
        "noise_bandwidth": square / gain**2,
        "coherent_gain": gain,
        "scalloping": level(0.5),
    }


def _figures_by_oracle(given: Input, _: Output) -> Output:
    """Roots and the top of the highest sidelobe by mpmath's solvers, on the closed lobe."""
    mp, mpf, name = oracle.mp, oracle.mpf, given["window"]
    gain = oracle.closed_lobe(name, mpf(0))

    def level(v: Any) -> Any:
        return oracle.closed_lobe(name, v) / gain

    zero = oracle.nearest_root(level, _ZERO[name] * 1.001)
    three = oracle.nearest_root(lambda v: level(v) - mp.sqrt(mpf(1) / 2), 0.44 + 0.2 * (_ZERO[name] > 1))
    six = oracle.nearest_root(lambda v: level(v) - mpf(1) / 2, 0.6 + 0.4 * (_ZERO[name] > 1))
    highest = max(_tops(level, _ZERO[name]), key=lambda v: abs(level(v)))
    side = abs(level(mp.findroot(lambda v: mp.diff(level, v), mpf(highest))))
    return {
        "first_zero": zero,
        "width_3db": 2 * three,
        "width_6db": 2 * six,
        "peak_sidelobe": side,
        "peak_sidelobe_db": 20 * mp.log10(side),
        "noise_bandwidth": oracle.mean_square(name) / gain**2,
        "coherent_gain": gain,
        "scalloping": level(mpf(1) / 2),
    }


def _figures_conditioning(given: Input, found: Output) -> Output:
    """A root moves by the rounding of the lobe over its slope; a quadrature by a rounding for each of its 60 nodes."""
    taper, h = window(given["window"]), 1e-6
    slope = {
        name: abs(float(taper.transform(v + h) - taper.transform(v - h))) / (2 * h) / found["coherent_gain"]
        for name, v in (
            ("first_zero", found["first_zero"]),
            ("width_3db", found["width_3db"] / 2),
            ("width_6db", found["width_6db"] / 2),
        )
    }
    return {
        name: 8 / slope[name]
        if name in slope
        else 8 * 20 / np.log(10) / found["peak_sidelobe"]
        if name == "peak_sidelobe_db"
        else 60.0
        if name == "noise_bandwidth"
        else 8.0
        for name in found
    }


STAGES = {
    "window": Stage(
        "eq:hann",
        {"chain": lambda g: {"w": window(g["window"]).samples(g["size"])}},
        lambda g, _: {"w": [oracle.window(g["window"], oracle.mpf(n) / g["size"]) for n in range(g["size"])]},
        relative(8),
    ),
    "response": Stage(
        "sec:leakage", {"chain": _response, "sum": _summed_response}, _response_by_oracle, _response_conditioning
    ),
    "lobes": Stage(
        "fig:leakage_lobes",
        {"chain": _lobes, "quadrature": _lobes_integrated},
        lambda g, _: {"lobe": [oracle.lobe(g["window"], v) for v in g["offsets"]]},
        lambda g, f: {"lobe": 8.0 + np.pi * largest(g["offsets"])},
    ),
    "figures": Stage("app:window_comparison", {"chain": _figures}, _figures_by_oracle, _figures_conditioning),
}

"""The high-precision oracle of the methods: what each finds in a shell, part of `golden.oracle`.

It shares only the papers' formulas with the chain, and writes them otherwise: sums term by term, minima by Cramer's
rule, that of the biweight by weighting again and again. Constants are written out here a second time on purpose.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from typing import Any

from mpmath import mp, mpf

from leakref.golden import oracle
from leakref.golden.oraclewater import group_velocity

__all__ = ["velocity"]

Number = Any  # mpf or mpc
Point = tuple[Number, Number, Number, Number]  # kx, ky, shift, weight
_NONE = [mp.nan, mp.nan]


def velocity(
    method: str, shell: oracle.Shell, start: Sequence[float], wavenumber: float, given: Mapping[str, Any]
) -> list[Number]:
    """What a method finds in a shell around `wavenumber`; maxima of N are looked for from `start`, which is close.

    `given` is the input of the entry. NaN where there is no number.
    """
    return _ORACLES[method](shell, start, wavenumber, given)


def _fit(points: Sequence[Point]) -> list[Number]:
    """The velocity with the least sum of weight (k.c - shift)^2."""
    xx, xy, yy, xb, yb = (
        mp.fsum(terms)
        for terms in zip(
            *((w * p * p, w * p * q, w * q * q, w * p * s, w * q * s) for p, q, s, w in points), strict=True
        )
    )
    determinant = xx * yy - xy * xy
    if abs(determinant) < mpf(10) ** -9 * (xx + yy) ** 2:
        return _NONE
    return [(yy * xb - xy * yb) / determinant, (xx * yb - xy * xb) / determinant]


def _adaptive(shell: oracle.Shell, start: Sequence[float], wavenumber: float, given: Mapping[str, Any]) -> list[Number]:
    """As NSP, a^2 = (4 domega)^2 + (4 cg dk)^2 (decision D36)."""
    dk = max(2 * mp.pi / (n * mpf(d)) for n, d in zip(given["shape"][:2], given["spacing"], strict=False))
    cg = group_velocity(wavenumber, given["gravity"], given.get("depth"), given.get("surface_tension", 0))
    shell.width = mp.sqrt(shell.width**2 + (4 * cg * dk) ** 2)
    return oracle.newton(shell, start)


def _polar(shell: oracle.Shell, *unused: Any) -> list[Number]:
    """The crest, a bin and its neighbours, and the biweight with a = 4 domega (decisions D33, D34)."""
    largest = max(max(row) for row in shell.f) ** 2
    a, points = shell.width, []
    for p, q, omega0, row in zip(shell.kx, shell.ky, shell.omega0, shell.f, strict=True):
        top = max(range(len(row)), key=row.__getitem__)
        if row[top] ** 2 < largest / 5:
            continue
        bins = [m for m in (top - 1, top, top + 1) if 0 <= m < len(row)]
        crest = mp.fsum(shell.omega[m] * row[m] ** 2 for m in bins) / mp.fsum(row[m] ** 2 for m in bins)
        points.append((p, q, crest - omega0, mpf(1)))
    c = _fit(points)
    for _ in range(400):
        if mp.isnan(c[0]):
            return _NONE
        squares = [((s - p * c[0] - q * c[1]) / a) ** 2 for p, q, s, _ in points]
        new = _fit([(p, q, s, max(1 - z, mpf(0)) ** 2) for (p, q, s, _), z in zip(points, squares, strict=True)])
        moved = mp.hypot(new[0] - c[0], new[1] - c[1])
        c = new
        if moved < mpf(10) ** -30:
            return c
    return _NONE


def _iterative(shell: oracle.Shell, *unused: Any) -> list[Number]:
    """Bins above a fifth, then those above a fiftieth within 4 domega of either branch (decisions D37, D38)."""
    c, largest = oracle.least_squares(shell), max(max(row) for row in shell.f) ** 2
    before: list[tuple[int, int, int]] = []
    bins = [(n, m) for n, row in enumerate(shell.f) for m, value in enumerate(row) if value**2 >= largest / 50]
    for _ in range(100):
        if mp.isnan(c[0]):
            return _NONE
        taken = []
        for n, m in bins:
            moved = shell.omega[m] - shell.kx[n] * c[0] - shell.ky[n] * c[1]
            sign = 1 if abs(moved - shell.omega0[n]) <= abs(moved + shell.omega0[n]) else -1
            if abs(moved - sign * shell.omega0[n]) <= shell.width:
                taken.append((n, m, sign))
        if taken == before:
            return c
        before = taken
        c = _fit([(shell.kx[n], shell.ky[n], shell.omega[m] - s * shell.omega0[n], mpf(1)) for n, m, s in taken])
    return _NONE


_ORACLES: dict[str, Callable[..., list[Number]]] = {
    "nsp": lambda shell, start, *_: oracle.newton(shell, start),
    "ls": lambda shell, *_: oracle.least_squares(shell),
    "nsp-grid": lambda shell, start, *_: oracle.newton(shell, start),
    "nsp-adaptive": _adaptive,
    "pcs": _polar,
    "ls-iterative": _iterative,
}

"""Whether velocities that failed are maxima of the score all the same, or lie on the way to one."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from typing import Any

import numpy as np

from leakref._base import FloatArray
from leakref.certify.strength.clues import Clue, Hypothesis, gather
from leakref.certify.strength.symptoms import AWAY, said
from leakref.certify.subject.declaration import Declaration
from leakref.certify.subject.frames import Velocities
from leakref.certify.subject.inprocess import InProcess
from leakref.certify.verdict import Finding
from leakref.chain import reference
from leakref.dispersion import Water
from leakref.grid import Grid
from leakref.nsp import WIDTH, characteristic_function, normalized_scalar_product, score_derivatives, score_range
from leakref.shell import Shell, shell_at
from leakref.spectrum import fourier

__all__ = ["other_maxima"]

_STAYS = 2e-3  # in c0: so near to a maximum is at it
_TOWARDS = 0.7  # cosine of the angle between a velocity and another in whose direction it is
_MOSTLY = 0.6  # part of the answers
_MANY = 8  # questions that are looked at again


class _Recording(InProcess):
    """The reference, and what it was shown."""

    shown: list[tuple[FloatArray, Sequence[float], FloatArray, str, str | None, Water]]

    def extract(self, surface: Any, spacing: Any, wavenumbers: Any, **named: Any) -> Velocities:
        """As `Subject.extract`, of which it takes down the question."""
        window, method = named.get("window", "hann"), named.get("method")
        water = named.get("water") or self.still()
        self.shown.append((surface, spacing, np.atleast_1d(wavenumbers), window, method, water))
        return super().extract(surface, spacing, wavenumbers, **named)


def other_maxima(
    findings: Sequence[Finding], declared: Mapping[str, Any], methods: Sequence[str], *, seed: int, golden: int
) -> list[Hypothesis]:
    """Whether velocities that failed are maxima of N all the same, or of N with the second branch as it is printed, or
    lie on the way to them.

    Only of a code that is an NSP, by what it says or what it was taken for. A maximum that scores lower than the
    reference's is where another search ends; that of the printed branch (decision D2) is none of N. What scores higher
    than zero current and points to the maximum, but is no maximum, is where a search stops that takes too few steps.
    """
    if "nsp" not in methods or "extract" not in declared["can"]:
        return []
    other, printed, early, known = 0, 0, 0, 0
    failed = [clue for clue in gather(findings, seed, golden) if clue.finding.calls and clue.check.stage == "extract"]
    for clue in [clue for clue in failed if clue.check.family in ("currents", "signs", "recovery", "shear")][:_MANY]:
        for shell, a, mine, should in _shells(clue, declared, methods):
            if not np.hypot(*mine) <= score_range(shell, a, 1.0) or np.hypot(*(mine - should)) < AWAY:
                continue
            known += 1
            zero, score, best = (normalized_scalar_product(shell, c, a) for c in (0 * mine, mine, should))
            at = _is_maximum(shell, mine, a)
            other += at and score < best * (1 - 1e-6)
            printed += not at and _is_maximum_as_printed(shell, mine, a)
            on_the_way = bool(
                mine @ should > _TOWARDS * np.hypot(*mine) * np.hypot(*should) and mine @ mine < should @ should
            )
            early += not at and zero < score < best and on_the_way
    counts = {
        "other-maximum": (
            other,
            "maxima of the score too, with a lower score: the search starts elsewhere, or its first step is too long "
            "(`leakref guide real-codes`)",
        ),
        "printed-branch": (
            printed,
            "maxima of the score with the second branch of G as it is printed, omega + omega0 + k.c (decision D2)",
        ),
        "stops-early": (
            early,
            "on the way from zero to a maximum of the score, and at none: the search stops before it is there (its "
            "tolerance, or its number of steps)",
        ),
    }
    return [
        said(name, f"{count} of {known} velocities that are far off are {words}")
        for name, (count, words) in counts.items()
        if known >= 2 and count >= _MOSTLY * known
    ]


def _shells(
    clue: Clue, declared: Mapping[str, Any], methods: Sequence[str]
) -> Iterator[tuple[Shell, float, FloatArray, FloatArray]]:
    """For each velocity of a finding by the NSP: its shell, the width a, the velocity and the reference's (2,)."""
    subject = _Recording(reference)
    subject.shown, subject.alike = [], frozenset()
    theirs = Declaration.read({**declared})
    own = subject.declaration
    can = {**own.can, "extract": {"methods": list(methods), "windows": list(theirs.windows)}}
    fixed = ("dy",) if "dy" in theirs.untold else ()
    subject.declaration, subject.asked_as = Declaration(fixed=fixed, can=can, water=own.water), theirs
    clue.check(subject, clue.case)
    for (surface, spacing, k, window, method, water), mine, true in zip(
        subject.shown, clue.finding.calls, subject.calls, strict=False
    ):
        if method == "nsp" and mine.answer.shape == true.answer.shape and mine.asked["scale"] == 1:
            grid = Grid(surface.shape, (spacing[0], spacing[1], spacing[2]))
            spectrum = fourier(surface, grid, window, workers=1)
            for n in np.flatnonzero(np.isfinite(mine.answer).all(axis=1) & np.isfinite(true.answer).all(axis=1)):
                width = WIDTH * grid.frequency_resolution
                yield shell_at(spectrum, float(k[n]), water=water), width, mine.answer[n], true.answer[n]


def _is_maximum(shell: Shell, velocity: FloatArray, a: float) -> bool:
    _, gradient, hessian = score_derivatives(shell, velocity, a)
    return _at_the_top(gradient, hessian)


def _is_maximum_as_printed(shell: Shell, velocity: FloatArray, a: float, step: float = 1e-3) -> bool:
    """By differences, of N with a second branch at -omega0 - k.c."""

    def score(c: FloatArray) -> float:
        g = characteristic_function(shell, c, a)
        mirror = np.exp(-2 * ((shell.omega + (shell.intrinsic - shell.kx * c[0] - shell.ky * c[1])[:, None]) / a) ** 2)
        printed = np.exp(-2 * ((shell.omega + (shell.intrinsic + shell.kx * c[0] + shell.ky * c[1])[:, None]) / a) ** 2)
        g = g - mirror + printed
        return float(np.sum((g * shell.magnitude) @ shell.weight) / np.sum(g @ shell.weight))

    x, y = np.eye(2) * step
    n = {(i, j): score(velocity + i * x + j * y) for i in (-1, 0, 1) for j in (-1, 0, 1)}
    gradient = np.array([n[1, 0] - n[-1, 0], n[0, 1] - n[0, -1]]) / (2 * step)
    cross = (n[1, 1] - n[1, -1] - n[-1, 1] + n[-1, -1]) / (4 * step**2)
    xx, yy = (n[1, 0] - 2 * n[0, 0] + n[-1, 0]) / step**2, (n[0, 1] - 2 * n[0, 0] + n[0, -1]) / step**2
    return _at_the_top(gradient, np.array([[xx, cross], [cross, yy]]))


def _at_the_top(gradient: FloatArray, hessian: FloatArray) -> bool:
    """Whether a step of Newton's would be short, towards a maximum."""
    if not np.isfinite(hessian).all() or np.linalg.eigvalsh(hessian).max() >= 0:
        return False
    return bool(np.hypot(*np.linalg.solve(hessian, gradient)) <= _STAYS)

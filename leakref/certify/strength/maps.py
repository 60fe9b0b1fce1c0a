"""What another algorithm has in common with the reference: a sign, an exchange of axes, a turn, a factor.

Such a code has no digits in common with any fault of the reference, but its velocities may be those of the reference
up to a linear map, or to a factor that depends on the scale of the sea. Used by `diagnosis`.
"""

from __future__ import annotations

import numpy as np

from leakref._base import FloatArray
from leakref.certify.strength.clues import FULL

__all__ = ["MAPS", "common_map"]

MAPS: dict[str, tuple[str, list[list[float]]]] = {
    "": ("", [[1, 0], [0, 1]]),
    "negated-current": ("negated", [[-1, 0], [0, -1]]),
    "flipped-x": ("with the x component of the wrong sign", [[-1, 0], [0, 1]]),
    "flipped-y": ("with the y component of the wrong sign", [[1, 0], [0, -1]]),
    "exchanged-axes": ("with x and y exchanged", [[0, 1], [1, 0]]),
    "quarter-turn": ("turned by a quarter turn", [[0, -1], [1, 0]]),
    "quarter-turn-back": ("turned back by a quarter turn", [[0, 1], [-1, 0]]),
    "exchanged-and-negated": ("with x and y exchanged, and negated", [[0, -1], [-1, 0]]),
    "lost-x": ("without an x component", [[0, 0], [0, 1]]),
    "lost-y": ("without a y component", [[1, 0], [0, 0]]),
}
"""What a slip of sign or order makes of a velocity: in words, and as a matrix."""
_NEAR = 10**-1.5  # part of the velocities that may be left over: what only comes nearer is no explanation
_BETTER = 0.7  # how much less a turn by any angle must leave over than the best of the maps above
_FACTOR = 0.15  # that a factor may differ from one


def common_map(mine: FloatArray, true: FloatArray, scales: FloatArray) -> tuple[str, str, float] | None:
    """The map from the velocities of the reference, `true` (m, 2), to those of a code, `mine` (m, 2), if there is one.

    `scales` (m,) are those at which the seas were shown. Returned are the name of the fault that it is, what it is in
    words, and to how many digits it holds.
    """
    if len(mine) < 2 or not mine.any() or np.linalg.matrix_rank(true, tol=0.1 * np.abs(true).max()) < 2:
        return None
    maps = {name: (words, true @ np.array(matrix).T) for name, (words, matrix) in MAPS.items()}
    rest, name = min((_left_over(mine, mapped), name) for name, (_, mapped) in maps.items())
    angle = float(np.angle(np.sum((mine @ [1, 1j]) * (true @ [1, -1j]))))
    c, s = np.cos(angle), np.sin(angle)
    turned = true @ np.array([[c, s], [-s, c]])
    if _left_over(mine, turned) < _BETTER * rest:
        rest, name = _left_over(mine, turned), "turned"
        maps[name] = f"turned by {np.degrees(angle):.0f} degrees", turned
    words, mapped = maps[name]
    factor = _factor(mine, mapped)
    each = {scale: _factor(mine[scales == scale], mapped[scales == scale]) for scale in np.unique(scales)}
    if max(each.values()) - min(each.values()) > _FACTOR * factor:
        rest = _left_over(mine, mapped * np.array([each[scale] for scale in scales])[:, None])
        said = ", ".join(f"{value:.2f} at {scale:g}" for scale, value in each.items())
        name, words = (
            "scale-dependent",
            (
                f"{words} and times a factor that depends on the scale of the sea: {said} "
                "times the usual peak wavenumber"
            ).removeprefix(" and "),
        )
    elif abs(factor - 1) >= min(_FACTOR, 1e-3 + 3 * rest):
        name, words = name or "factor", f"{words} and times {factor:.3g}".removeprefix(" and ")
    if rest > _NEAR or not name:
        return None
    return name, words, round(float(-np.log10(max(rest, 10**-FULL))), 1)


def _factor(mine: FloatArray, mapped: FloatArray) -> float:
    """By which `mapped` (m, 2) comes nearest to `mine` (m, 2), not below zero."""
    return max(float(np.sum(mapped * mine) / (np.sum(mapped**2) or 1.0)), 0.0)


def _left_over(mine: FloatArray, mapped: FloatArray) -> float:
    """Part of `mine` (m, 2) that no multiple of `mapped` (m, 2) explains.

    From 0, where one is a multiple of the other, to 1, where they have nothing in common; a tenth is one digit.
    """
    rest = mine - _factor(mine, mapped) * mapped
    return float(np.sqrt(np.sum(rest**2) / (np.sum(mine**2) or 1.0)))

"""Sheared currents end to end: how much of a shear inferred from waves is leakage?

The Doppler shift velocity of a current that varies with depth varies with wavenumber (eq:SJ), and so does leakage. Each
wavenumber is sensitive to the current down to about its effective depth 1 / 2k, at which a linear profile has exactly
the velocity of eq:SJ; the slope of velocities over these depths is the shear that one infers. A uniform current, whose
shear is none, shows what leakage alone makes of it.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import asdict, dataclass
from itertools import product
from typing import Any

import numpy as np

from leakref._base import FloatArray, LeakrefError
from leakref.cases import Configuration
from leakref.currents import Current, ExponentialCurrent, LinearCurrent, UniformCurrent, shift_in
from leakref.dispersion import Water
from leakref.ensemble import Ensemble
from leakref.sea import Components, SeaState

__all__ = [
    "BANDS",
    "DEPTH",
    "DIRECTIONS",
    "PROFILES",
    "SHEAR",
    "SHEARED",
    "SURFACE",
    "Inferred",
    "Sheared",
    "answer",
    "inferred",
    "sheared",
]

SURFACE = 0.15
"""Speed of the current at the surface in c0, the largest of case-U."""
SHEAR = 0.1
"""dU/dz of the linear profile in c0 k0: down to k = 0.4 it changes the velocity by as much as the surface current."""
DEPTH = 0.5
"""Of the exponential profile in 1 / k0."""
PROFILES = ("uniform", "linear", "exponential")
"""How the current varies with depth: not at all, linearly, or as exp(z / `DEPTH`)."""
DIRECTIONS = {90.0: "following", 0.0: "crossing", -90.0: "opposing"}
"""Of the current, in degrees; the waves go to 90."""
BANDS = {"from the peak up": 1.0, "all": 0.0}
"""The smallest wavenumber of each range over which a shear is inferred, in k0."""


@dataclass(frozen=True)
class Sheared(Configuration):
    """A configuration whose current varies with depth, by `profile`; `speed` is its speed at the surface.

    `profile` is one of `PROFILES`, else LeakrefError. The true velocity differs from shell to shell (`truth`), so that
    `current`, that at the surface, is no truth for the errors.
    """

    profile: str = "uniform"

    def __post_init__(self) -> None:
        super().__post_init__()
        if self.profile not in PROFILES:
            raise LeakrefError("Sheared", f"no profile is called {self.profile!r}", f"choose one of {PROFILES}")

    @property
    def id(self) -> str:
        """For instance `shear/profile=linear,current_direction=90`."""
        return f"{self.case}/profile={self.profile},current_direction={self.current_direction:g}"

    @property
    def along(self) -> FloatArray:
        """The direction of the current, a unit vector (2,)."""
        angle = np.radians(self.current_direction)
        return np.array([np.cos(angle), np.sin(angle)])

    @property
    def depending_on_depth(self) -> Current:
        """The current itself."""
        x, y = (float(value) for value in self.speed * self.along)
        if self.profile == "linear":
            return LinearCurrent((x, y), (float(SHEAR * self.along[0]), float(SHEAR * self.along[1])))
        return ExponentialCurrent((x, y), DEPTH) if self.profile == "exponential" else UniformCurrent((x, y))

    @property
    def truth(self) -> FloatArray:
        """eq:SJ, or what it becomes above a bottom (decision D30), at the shells' wavenumbers, (n, 2)."""
        return shift_in("Sheared", self.depending_on_depth, self.wavenumbers, self.water)

    def components(self, realization: int) -> Components:
        """The waves of one realisation, each shifted by its own eq:SJ."""
        sea = SeaState(self.direction, self.spread, self.peakedness, self.length, self.depending_on_depth, self.water)
        return sea.components(realization)


SHEARED = tuple(
    Sheared("shear", speed=SURFACE, current_direction=direction, profile=profile, varied=("current_direction",))
    for profile, direction in product(PROFILES, DIRECTIONS)
)
"""Case shear: each profile with, across and against the waves."""


def sheared(name: str) -> tuple[Sheared, ...]:
    """The configurations of case shear that `name` stands for, all or one; none if it is no name of theirs. `name` is
    `shear` or the id of one.
    """
    return tuple(c for c in SHEARED if name in (c.case, c.id))


@dataclass(frozen=True)
class Inferred:
    """The shear inferred along the current, over one band of wavenumbers, in c0 k0, and what it should be.

    `mean` and `random` are over realisations, `standard_error` is of the mean. `true` is what the same slope gives for
    the velocities of eq:SJ themselves: the shear of a linear profile, and a mean one of others.

    `direction` is that of the current in degrees, `band` a key of `BANDS`.
    """

    profile: str
    direction: float
    window: str
    method: str
    band: str
    true: float
    mean: float
    random: float
    standard_error: float

    @property
    def spurious(self) -> float:
        """What was inferred and is not there."""
        return self.mean - self.true

    def record(self) -> dict[str, Any]:
        """For JSON."""
        return {**asdict(self), "spurious": self.spurious}


def _slope(wavenumbers: FloatArray, velocities: FloatArray, water: Water) -> FloatArray:
    """Least-squares slope of velocities (..., n) over the effective depths, (...); none of a constant. Effective is the
    depth whose current shifts a wave where the shear is constant, -1 / 2k in deep water, in `1 / k0`, so that a slope
    is in `c0 k0`.
    """
    z = LinearCurrent((0.0, 0.0), (1.0, 0.0)).doppler_shift_velocity(wavenumbers, water)[:, 0]
    z = z - z.mean()
    return (velocities - velocities[..., :1]) @ z / (z @ z)


def inferred(ensemble: Ensemble) -> list[Inferred]:
    """The shear inferred from each realisation's velocities along the current, for both BANDS; without those
    realisations that lack a number. Two rows, in the order of `BANDS`. Raises LeakrefError for an ensemble of another
    case.
    """
    c, k = ensemble.configuration, ensemble.wavenumbers
    if not isinstance(c, Sheared):
        raise LeakrefError("inferred", f"{c.id} is no configuration of case shear", "pass an ensemble of one")
    rows = []
    for band, smallest in BANDS.items():
        on = k >= smallest - 1e-9
        each = _slope(k[on], ensemble.velocities[:, on] @ c.along, c.water)
        each = each[np.isfinite(each)]
        random = float(each.std(ddof=1)) if each.size > 1 else float("nan")
        rows.append(
            Inferred(
                c.profile,
                c.current_direction,
                ensemble.window,
                ensemble.method,
                band,
                float(_slope(k[on], (c.truth @ c.along)[on], c.water)),
                float(each.mean()) if each.size else float("nan"),
                random,
                random / float(np.sqrt(max(each.size, 1))),
            )
        )
    return rows


def answer(rows: Sequence[Inferred]) -> str:
    """How much of an inferred shear is leakage, in a sentence for each band: by NSP, untapered and tapered. Rows of LS
    are left out.
    """
    said = []
    for band in BANDS:
        added, made = [], []
        for window, words in (("box", "untapered"), ("hann", "tapered")):
            of = [row for row in rows if (row.window, row.method, row.band) == (window, "nsp", band)]
            if shares := [100 * row.spurious / row.true for row in of if row.profile != "uniform"]:
                added.append(f"{_span(shares, '+.0f')} % {words}")
            if alone := [abs(row.mean) for row in of if row.profile == "uniform"]:
                made.append(f"{max(alone):.2g} {words}")
        parts = [
            f"leakage adds to the true shear {' and '.join(added)}" if added else "",
            f"where there is none it makes one of up to {' and '.join(made)} (c0 k0)" if made else "",
        ]
        where = "all wavenumbers" if band == "all" else "wavenumbers from the peak up"
        said.append(f"By NSP, over {where}, {'; '.join(part for part in parts if part)}.")
    return " ".join(said)


def _span(values: Iterable[float], form: str) -> str:
    values = sorted(values)
    low, high = format(values[0], form), format(values[-1], form)
    return low if low == high else f"{low} to {high}"

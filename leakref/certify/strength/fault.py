"""What a fault is, and of what the list of them is made: lines of the chain, and what becomes of them."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from leakref._base import FloatArray
from leakref.altered import Change
from leakref.chain import Reference
from leakref.generator import Generator
from leakref.methods import DEFAULT, METHODS

__all__ = [
    "CALL",
    "CENTRES",
    "DEEP_ROOT",
    "DEPTHS",
    "FOURIER",
    "HALF",
    "INTRINSIC",
    "KX",
    "LENGTHS",
    "POLISH",
    "SHIFTED",
    "SI",
    "STAGES",
    "TAPER_SPACE",
    "TOLD",
    "UNPOLISHED",
    "WAVES",
    "WIDE",
    "Drifting",
    "Fault",
    "Remembering",
    "Tiling",
    "answer",
    "asked",
    "unchecked",
]

STAGES = ("frame", "units", "synthesis", "window", "spectrum", "shell", "water", *METHODS, "behaviour", "sea")
"""Where in the chain a fault sits, in the order in which the faults are listed."""


@dataclass(frozen=True)
class Fault:
    """`words` say what is wrong, as a diagnosis would; `family` is the one whose checks are meant to kill it.

    Either `changes` to the chain, or an `instead` of the reference. `sound`: a code like this is another algorithm,
    and only conformance tells. `killing_input` is a finding on which the effect is at least ten times the tolerance.
    The code with the fault declares `methods`.
    """

    id: str
    stage: str
    family: str
    words: str
    changes: tuple[Change, ...] = ()
    instead: type[Reference] | type[Generator] | None = None
    killing_input: str = ""
    methods: tuple[str, ...] = DEFAULT

    @property
    def sound(self) -> bool:
        """Whether it is killed by conformance alone."""
        return self.family == "conformance"


class Drifting(Reference):
    """Adds noise: no two calls agree."""

    def __init__(self) -> None:
        self.noise = np.random.default_rng(1)

    def extract(self, *cube: Any, gravity: float = 1.0, **settings: Any) -> FloatArray:
        """Velocities, (n, 2), as the reference finds them, and noise of a hundredth of c0 or so."""
        found = super().extract(*cube, gravity=gravity, **settings)
        return found + 1e-2 * float(np.sqrt(gravity)) * self.noise.standard_normal(found.shape)


class Remembering(Reference):
    """Keeps a running mean of the cubes of one shape: an answer depends on what was asked before."""

    def __init__(self) -> None:
        self.last: dict[tuple[int, ...], FloatArray] = {}

    def extract(self, surface: FloatArray, *rest: Any, **settings: Any) -> FloatArray:
        """Velocities, (n, 2), of the mean of this surface and the last one of its shape."""
        eta = np.array(surface)
        mean = (eta + self.last.get(eta.shape, eta)) / 2
        self.last[eta.shape] = eta
        return super().extract(mean, *rest, **settings)


class Tiling(Reference):
    """Takes the depth of the call before."""

    def __init__(self) -> None:
        self.depth = np.inf

    def extract(self, *cube: Any, depth: float = np.inf, **settings: Any) -> FloatArray:
        """Velocities, (n, 2), in water as deep as it was the last time."""
        before, self.depth = self.depth, depth
        return super().extract(*cube, depth=before, **settings)


TOLD = "water = Water(gravity, depth, surface_tension)"
DEPTHS = "kh, tension = k * min(self.depth, _BOTTOMLESS), k**2 * self.surface_tension / self.gravity"
CALL = "return extract(surface, spacing, wavenumbers, water=water, window=window, method=method).velocities"
FOURIER = "values = fft.fft2(values, axes=(0, 1), workers=threads, overwrite_x=True)"
TAPER_SPACE = "tapered *= (wx[:, None] * wy)[:, :, None]"
INTRINSIC = "water.frequency(k[a, b])"
CENTRES = "return shell.intrinsic + shift, -shell.intrinsic + shift"
POLISH = "velocity, steps, arrived = _ascend(shell, fit.x * unit, width, unit)"
UNPOLISHED = Change("nsp", POLISH, "velocity, steps, arrived = fit.x * unit, 0, True")
LENGTHS = "return nx * dx, ny * dy, nt * dt"
DEEP_ROOT = "return np.sqrt(self.gravity * np.asarray(wavenumber, dtype=np.float64))"
SHIFTED = "(np.arange(n) + n // 2) % n - n // 2"
WIDE = "self.grid.bin_widths[0]"
KX = f"self.i * {WIDE}"
HALF = "(self.grid.shape[0] / 2)"
SI = Change("chain", '"units": "scaled"', '"units": "si"')
WAVES = "waves = components.amplitude * np.exp(1j * components.phase)"
_REFUSAL = 'eta = finite("{}", "surface", surface, 3)'


def answer(new: str) -> Change:
    """Another last line of `Reference.extract`; FOUND stands for what it would have been."""
    return Change("chain", CALL, f"return {new.replace('FOUND', CALL.removeprefix('return '))}")


def asked(old: str, new: str) -> Change:
    """`Reference.extract` handing on something else in place of an argument."""
    return Change("chain", CALL, CALL.replace(f"{old},", f"{new},", 1))


def unchecked(new: str) -> tuple[Change, Change]:
    """The surface taken as it comes by `extract` and `fourier`, instead of refused if it is not finite."""
    return (
        Change("chain", _REFUSAL.format("extract"), f"eta = {new}"),
        Change("spectrum", _REFUSAL.format("fourier"), f"eta = {new}"),
    )

"""Realisations of a configuration, and the bias and random part of what is measured from them.

This is where statistics are made (sec:parameters): every figure, table and golden ensemble goes through `Ensemble`. It
computes nothing by itself but what one realisation gives (`realize`); running many is for `runs`. All is in scaled
units: wavenumbers in `k0`, velocities in `c0`.

With c_r the velocity of realisation r, of R that have a number:

    bias     =  sum |c_r| / R
    random   =  sqrt(sum (|c_r| - bias)^2 / (R - 1))
    mean     =  sum c_r / R
    standard_error  =  random / sqrt(R)
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from leakref import fast
from leakref._base import FloatArray, IntArray, deviation_of_known, mean_of_known
from leakref.cases import Configuration
from leakref.chain import analyse, transform
from leakref.dispersion import velocity_resolutions
from leakref.methods import DEFAULT
from leakref.shell import Extraction, Note

__all__ = ["Ensemble", "realize", "statistics_record"]


@dataclass(frozen=True, eq=False)
class Ensemble:
    """Velocities (R, n, 2) of R realisations at n `wavenumbers` of a configuration, and notes (R, n) as integers.

    Statistics are over realisations, for each wavenumber, without those that have no number (`count` says how many have
    one).

    - `configuration`: the sea, the current and the domain; `window`, `method`: by name.
    - `velocities`: in `c0`, x and y components, NaN where there is no number.
    - `notes`: the sums of `shell.Note` values, 0 where there is nothing to say.
    """

    configuration: Configuration
    window: str
    method: str
    wavenumbers: FloatArray
    velocities: FloatArray
    notes: IntArray

    @property
    def magnitudes(self) -> FloatArray:
        """|c|, (R, n)."""
        return np.hypot(self.velocities[..., 0], self.velocities[..., 1])

    @property
    def count(self) -> IntArray:
        """Realisations with a number, (n,)."""
        return np.isfinite(self.magnitudes).sum(axis=0)

    @property
    def bias(self) -> FloatArray:
        """Mean of |c|, (n,) (sec:parameters).

        In still water it is the bias of the paper. With a current it is not the error: see `claims.words` and
        `planning.plan.Expected` for |c - U|.
        """
        return mean_of_known(self.magnitudes)

    @property
    def random(self) -> FloatArray:
        """Standard deviation of |c|, (n,), with n - 1 (decision D12); the paper's figures show twice this. NaN where
        fewer than two realisations have a number.
        """
        return deviation_of_known(self.magnitudes)

    @property
    def mean(self) -> FloatArray:
        """Mean vector, (n, 2). Unlike the bias it tends to zero where velocities scatter evenly about zero."""
        return mean_of_known(self.velocities)

    @property
    def standard_error(self) -> FloatArray:
        """Of the bias, (n,). It is `random / sqrt(count)`."""
        return self.random / np.sqrt(np.maximum(self.count, 1))

    @property
    def resolutions(self) -> tuple[FloatArray, FloatArray]:
        """eq:dcdwk from frequency and from wavenumber, (n,) each.

        That is `domega / k` and `cg dk / k`, in `c0`: the change of velocity that moves the dispersion surface by one
        bin. The group velocity `cg` is that of the configuration's water.
        """
        grid, water = self.configuration.grid, self.configuration.water
        return velocity_resolutions(self.wavenumbers, grid.wavenumber_resolution, grid.frequency_resolution, water)

    def noted(self, note: Note) -> IntArray:
        """In how many realisations a note was made, (n,)."""
        return ((self.notes & note.value) != 0).sum(axis=0)

    def record(self) -> dict[str, Any]:
        """As in the JSON of `leakref reproduce` (guide protocol, section 14)."""
        flagged = {name: self.noted(note) for note in Note for name in note.names if self.noted(note).any()}
        return {
            **statistics_record(self, len(self.velocities)),
            "count": self.count,
            "current": self.configuration.current,
            "flagged": flagged,
        }


def statistics_record(e: Any, realizations: int) -> dict[str, Any]:
    """What the JSON of `leakref reproduce` says of any statistics, of an Ensemble or of one that a golden set keeps."""
    names = ("window", "method", "wavenumbers", "bias", "random", "mean", "standard_error")
    frequency, wavenumber = e.resolutions
    return {
        "case": e.configuration.id,
        **{name: getattr(e, name) for name in names},
        "resolution_frequency": frequency,
        "resolution_wavenumber": wavenumber,
        "realizations": realizations,
    }


def realize(
    configuration: Configuration, realization: int, *, methods: Sequence[str] = DEFAULT, route: str = "B"
) -> dict[tuple[str, str], Extraction]:
    """One realisation: an Extraction for each (window, method), by route A (surface and FFT) or B (closed form).

    Route A is the plain chain, route B its compiled twin. Both look for waves in the water that the configuration says
    they are looked for in, its own unless a mistake is to be shown.

    `realization` counts from 0. Both routes give velocities that agree to about 1e-11 `c0` where there is no note.
    """
    waves, grid, k = configuration.components(realization), configuration.grid, configuration.wavenumbers
    water = configuration.measured_in
    if route == "B":
        return fast.realize(waves, grid, k, windows=configuration.windows, methods=methods, water=water)
    spectra = transform(waves, grid, configuration.windows, route=route)
    return {(s.window, method): analyse(s, k, method=method, water=water) for s in spectra for method in methods}

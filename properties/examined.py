"""What is examined, as a property sees it, and how near is near enough."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
import numpy.typing as npt
import pytest
from hypothesis import reject

from leakref import chain
from leakref._base import FloatArray
from leakref.certify.checks.criteria import FRACTION, unflagged, vector
from leakref.certify.checks.identity import identify
from leakref.certify.checks.inputs import Cube
from leakref.certify.subject.frames import Subject
from leakref.certify.subject.inprocess import InProcess
from leakref.certify.subject.named import Named
from leakref.certify.verdict import Refused, Unanswered, Verdict
from leakref.methods import DEFAULT
from leakref.window import WINDOWS

__all__ = ["PRECISION", "SINGLE", "Examined", "same"]

PRECISION = 1e-10
"""In c0, of the reference: ten times the 1e-11 c0 by which rounding moves a velocity in a shell of the paper's cases
of which nothing is noted, since the maxima of small cubes are less sharp."""
SINGLE = 1e-5
"""Relative: what single precision may lose, some hundred roundings of 6e-8."""


@dataclass(frozen=True, eq=False)
class Examined:
    """An implementation, and the modules of the chain behind it: None if it is not the reference, or that with a fault.

    `is_reference`: held to rounding.
    """

    subject: Subject
    modules: Any = None
    is_reference: bool = False

    def _repr_pretty_(self, printer: Any, cycle: bool) -> None:  # what hypothesis prints of it
        printer.text(self.subject.declaration.name)

    def offered(self, stage: str, **asked: str) -> None:
        """Skip, with the reason, what it does not offer."""
        if not self.subject.offers(stage, **asked):
            what = ", ".join(f"{name} {value}" for name, value in asked.items())
            name = self.subject.declaration.name  # which then has nothing that could be held
            pytest.skip(f"{name} does not offer {stage}{f' with {what}' * bool(what)}")

    def methods(self, *, band: bool = True) -> Sequence[str]:
        """Its extractions; skips without any, or, unless `band`, if there is one velocity for all wavenumbers."""
        self.offered("extract")
        if self.subject.declaration.band and not band:
            pytest.skip("gives one velocity for the whole band")  # this is of single wavenumbers
        identify(self.subject)
        return self.subject.methods

    def windows(self) -> Sequence[str]:
        """Under which it can extract: box and Hann of those offered, or else the first one."""
        self.offered("extract")
        own = self.subject.declaration.windows
        return [name for name in ("hann", "box") if name in own] or own[:1]

    def ask(self, stage: str, *args: Any, **settings: Any) -> Any:
        """Call a stage of the subject: skip what is unsupported or refused, drop the example if declined, else fail."""
        try:
            return getattr(self.subject, stage)(*args, **settings)
        except Unanswered as nothing:
            if nothing.verdict is Verdict.UNSUPPORTED or isinstance(nothing, Refused):
                pytest.skip(str(nothing))  # in its own words
            if nothing.verdict is Verdict.MISSING:
                reject()
            raise AssertionError(f"{nothing.verdict}: {nothing}") from nothing
        finally:
            self.subject.calls.clear()

    def velocities(
        self,
        surface: FloatArray,
        cube: Cube,
        window: str,
        method: str,
        *,
        spacing: Sequence[float] | None = None,
        scale: float = 1.0,
        every: bool = False,
    ) -> FloatArray:
        """Velocities (n, 2) of a surface, sampled and asked for as `cube` is unless said otherwise.

        NaN where declined, and, unless `every` is wanted, where the reference has something to note of the cube: there
        it may have no number itself, and it is not asked for.
        """
        known = np.full(cube.wavenumbers.size, True) if every else unflagged(cube, window, method)
        values = np.full((known.size, 2), np.nan)
        if known.any():
            values[known] = self.ask(
                "extract",
                np.ascontiguousarray(surface),
                spacing or cube.spacing,
                cube.wavenumbers[known],
                window=window,
                method=method,
                scale=scale,
            ).values
        return values

    def velocities_of_changed(
        self, surface: FloatArray, cube: Cube, window: str, method: str, spacing: Sequence[float]
    ) -> FloatArray:
        """`velocities` of a surface that is not that of `cube`: NaN if refused where all is to be noted of it too."""
        try:
            return self.velocities(surface, cube, window, method, spacing=spacing)
        except AssertionError:
            if _noted(surface, spacing, cube, window, method).all():
                return np.full((cube.wavenumbers.size, 2), np.nan)
            raise


def _noted(
    surface: FloatArray, spacing: Sequence[float], cube: Cube, window: str, method: str
) -> npt.NDArray[np.bool_]:
    """Where the literal chain has something to note of a surface, (n,)."""
    dx, dy, dt = spacing
    found = chain.extract(surface, (dx, dy, dt), cube.wavenumbers, window=window, method=method, gravity=1.0)
    return np.array([bool(note) for note in found.notes])


def same(
    examined: Examined,
    cube: Cube,
    window: str,
    method: str,
    found: FloatArray,
    should: FloatArray,
    changed: tuple[FloatArray, Sequence[float]] | None = None,
    *,
    exact: float = PRECISION,
) -> None:
    """Fail unless velocities (n, 2) agree: the reference to `exact` c0, others to a tenth of the smaller resolution.

    In shells of which the reference has nothing to note, in the cube and in the `changed` surface with its spacing. A
    tenth: room for an optimiser that stops early and for single precision. Resolutions are those of eq:dcdwk.
    """
    known = np.isfinite(found).all(axis=1) & np.isfinite(should).all(axis=1)
    allowed = np.full(known.size, exact) if examined.is_reference else FRACTION * cube.resolutions[0]
    error = np.hypot(*(found - should).T)
    bad = known & ~(error <= allowed)
    if bad.any() and changed is not None:
        bad &= ~_noted(*changed, cube, window, method)  # the start simplex does not turn with the sea: another basin
    if bad.any():
        n = int(np.flatnonzero(bad)[0])
        raise AssertionError(
            f"{method}, {window}: got {vector(found[n])} at k = {cube.wavenumbers[n]:.4g}, but should "
            f"be {vector(should[n])}, within {allowed[n]:.2g} [{error[n]:.3g} off]"
        )


def reference(methods: Sequence[str] = DEFAULT) -> Examined:
    """The built-in implementation, of these methods, with its modules."""
    import leakref.leakage
    import leakref.leastsquares
    import leakref.nsp

    can = {"extract": {"methods": list(methods), "windows": list(WINDOWS), "resolves": "wavenumber"}}
    of_these = Named(chain.reference, "leakref", null=False, **({} if methods == DEFAULT else {"can": can}))
    return Examined(InProcess(of_these), leakref, is_reference=True)

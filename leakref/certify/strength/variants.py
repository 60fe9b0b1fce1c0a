"""Variants: correct codes that are not the reference, none of which may ever be rejected.

They keep the checks honest. Some are the reference behind another frame, unit or scale; some are its chain with a
choice made otherwise; some are written from the paper a second time, over the whole space, with plain sums and somebody
else's optimiser. Each says which grade it deserves: *conformant*, or *sound* if another algorithm or a rounder number.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
import scipy.fft
from scipy.optimize import minimize

from leakref._base import FloatArray, LeakrefError
from leakref._caches import njit
from leakref.altered import Change, altered
from leakref.certify.strength import beside
from leakref.certify.subject.named import Named
from leakref.chain import Reference, extract, reference
from leakref.dispersion import Water
from leakref.sea import Components
from leakref.shell import Note

__all__ = ["VARIANTS", "Variant", "implementation"]

Score = Callable[[FloatArray], float]
Bins = tuple[FloatArray, FloatArray, FloatArray, FloatArray, FloatArray, FloatArray]
"""Of one shell: kx, ky, k, omega, F and the weight of each bin, (n,) each."""


@dataclass(frozen=True)
class Variant:
    """`words` say what is different, `grade` is what it deserves, `make` makes one.

    `grade` is `conformant` or `sound`; `make` takes no arguments and gives an object as `Implementation` has it. `id`
    is what follows `variant:` in a TARGET.
    """

    id: str
    grade: str
    words: str
    make: Callable[[], Any]


def implementation(identifier: str) -> Any:
    """The variant of that name, a new one each time. Raises LeakrefError."""
    if identifier not in VARIANTS:
        raise LeakrefError("variants", f"no variant is called {identifier!r}", f"choose one of {', '.join(VARIANTS)}")
    return Named(VARIANTS[identifier].make(), f"variant:{identifier}")


# ---------------------------------------------------------------- the reference behind something else


class _Permuted(Reference):
    """The reference for cubes whose axes come in another order."""

    def __init__(self, axes: str) -> None:
        self.axes = axes

    def describe(self) -> Mapping[str, object]:
        return {**super().describe(), "axes": self.axes}

    def _own(self, cube: Any) -> FloatArray:
        """From its axes to x, y, t."""
        return np.transpose(cube, [self.axes.index(axis) for axis in "xyt"])

    def _theirs(self, cube: Any) -> Any:
        """From x, y, t to its axes."""
        return np.transpose(cube, ["xyt".index(axis) for axis in self.axes])

    def extract(self, surface: FloatArray, *rest: Any, **settings: Any) -> FloatArray:
        return super().extract(self._own(surface), *rest, **settings)

    def spectrum(self, surface: FloatArray, *rest: Any, **settings: Any) -> Any:
        return self._theirs(super().spectrum(self._own(surface), *rest, **settings))

    def synthesize(self, components: Components, x: FloatArray, y: FloatArray, t: FloatArray) -> FloatArray:
        return np.asarray(self._theirs(super().synthesize(components, x, y, t)))


class _Prepared(Reference):
    """The reference on a surface that something was done to first, which must not matter."""

    def __init__(self, prepare: Callable[[FloatArray], FloatArray]) -> None:
        self.prepare = prepare

    def describe(self) -> Mapping[str, object]:
        return {**super().describe(), "can": {"extract": {"methods": ["nsp", "ls"], "windows": ["box", "hann"]}}}

    def extract(self, surface: FloatArray, *rest: Any, **settings: Any) -> FloatArray:
        if not np.isfinite(surface).all():
            raise ValueError("the surface is not finite")
        return super().extract(self.prepare(surface), *rest, **settings)


def _quantised(bits: int) -> Callable[[FloatArray], FloatArray]:
    """Grey values of a camera of that many bits, its range set to that of the sequence."""

    def image(surface: FloatArray) -> FloatArray:
        low, high = surface.min(), surface.max()
        return np.rint((surface - low) * ((2**bits - 1) / (high - low or 1.0)))

    return image


class _From(Reference):
    """The reference, returning where currents come from."""

    def describe(self) -> Mapping[str, object]:
        return {**super().describe(), "direction": "from"}

    def extract(self, *cube: Any, **settings: Any) -> FloatArray:
        return -super().extract(*cube, **settings)


class _Fixed(Reference):
    """Has wavenumbers of its own, the multiples of dk, whatever is asked for, and says which they are."""

    def describe(self) -> Mapping[str, object]:
        return {**super().describe(), "fixed": ["wavenumbers"]}

    def extract(
        self, surface: FloatArray, spacing: tuple[float, float, float], wavenumbers: FloatArray, **settings: Any
    ) -> Any:
        (nx, ny, _), (dx, dy, _) = surface.shape, spacing
        dk = 2 * np.pi / min(nx * dx, ny * dy)
        own = dk * np.arange(3, int(np.pi / max(dx, dy) / dk) - 2)
        found = super().extract(surface, spacing, own, **settings)
        rows = [row.tolist() if np.isfinite(row).all() else None for row in found]
        return {"velocities": rows, "wavenumbers": own}


class _Declining(Reference):
    """Returns nothing for a wavenumber that it does not trust, unless it is the only one."""

    def extract(
        self,
        surface: FloatArray,
        spacing: tuple[float, float, float],
        wavenumbers: FloatArray,
        *,
        gravity: float = 1.0,
        depth: float = np.inf,
        surface_tension: float = 0.0,
        **settings: Any,
    ) -> Any:
        found = extract(surface, spacing, wavenumbers, water=Water(gravity, depth, surface_tension), **settings)
        doubtful = Note.ANOTHER_BASIN | Note.LEAKAGE_FLOOR | Note.UNCONVERGED
        bad = np.array([bool(note & doubtful) for note in found.notes]) & (len(found.notes) > 1)
        bad |= np.isnan(found.velocities).any(axis=1)
        return [None if nothing else row.tolist() for nothing, row in zip(bad, found.velocities, strict=True)]


# ---------------------------------------------------------------- written a second time


def _simplex(score: Score, unit: float, tolerance: float = 1e-9) -> FloatArray:
    """Nelder-Mead from rest; `fminsearch` stops at a tolerance of 1e-4 in both the point and the value."""
    start = 2.5e-4 * np.array([[0, 0], [1, 0], [0, 1]])
    options = {"initial_simplex": start, "xatol": tolerance, "fatol": tolerance, "maxiter": 2000, "maxfev": 4000}
    return unit * minimize(lambda c: -score(c * unit), start[0], method="Nelder-Mead", options=options).x


def _gradient(score: Score, unit: float) -> FloatArray:
    """BFGS with differences for a gradient, from rest; the score is made small, so that the first step is."""
    fit = minimize(lambda c: -1e-2 * score(c * unit), np.zeros(2), method="BFGS", options={"gtol": 1e-9})
    return unit * fit.x


def _highest(score: Score, unit: float) -> FloatArray:
    """The best point, in phase velocities, of a lattice up to 1.2 of them."""
    line = np.linspace(-1.2, 1.2, 33)
    _, u, v = max((float(score(unit * np.array([u, v]))), u, v) for u in line for v in line if np.hypot(u, v) <= 1.2)
    return np.array([u, v])


def _lattice(score: Score, unit: float) -> FloatArray:
    """Nelder-Mead from the best point of a lattice."""
    start = unit * _highest(score, unit)
    return start + _simplex(lambda c: score(start + c), unit)


def _powell(score: Score, unit: float) -> FloatArray:
    """Powell's method from the best point of a lattice: from rest its line searches jump into other basins."""
    start = _highest(score, unit)
    fit = minimize(
        lambda c: -score(c * unit),
        start,
        method="Powell",
        bounds=[(x - 0.1, x + 0.1) for x in start],
        options={"xtol": 1e-6, "ftol": 1e-14},
    )
    return unit * fit.x


class _Own:
    """The normalized scalar product and least squares over the whole space, written from the paper a second time."""

    def __init__(
        self,
        optimiser: Callable[[Score, float], FloatArray] = _simplex,
        *,
        transform: Any = scipy.fft.fftn,
        half: bool = False,
        real: type[np.floating[Any]] = np.float64,
        tapers: bool = True,
    ) -> None:
        self.optimiser, self.transform, self.half, self.real, self.tapers = optimiser, transform, half, real, tapers

    def describe(self) -> Mapping[str, object]:
        windows = ["box", "hann"] if self.tapers else []
        return {"can": {"extract": {"methods": ["nsp", "ls"], "windows": windows}}}

    def extract(
        self,
        surface: FloatArray,
        spacing: Sequence[float],
        wavenumbers: Sequence[float],
        *,
        gravity: float,
        window: str,
        method: str,
    ) -> FloatArray:
        """Velocities, (n, 2)."""
        space, dk = self._space(surface, spacing, window)
        domega = 2 * np.pi / (surface.shape[2] * spacing[2])
        way = self._least_squares if method == "ls" else self._overlap
        return np.array(
            [way(_shell(space, k, dk), gravity, 4 * domega, float(np.sqrt(gravity / k))) for k in wavenumbers],
            dtype=np.float64,
        )

    def _space(self, surface: FloatArray, spacing: Sequence[float], window: str) -> tuple[Bins, float]:
        """All bins, and dk. A forward transform along all axes puts a wave at (k, -omega): so omega is minus its
        frequency.
        """
        if not np.isfinite(surface).all():
            raise ValueError("the surface is not finite")
        eta = np.asarray(surface, dtype=self.real)
        dk = max(2 * np.pi / (n * d) for n, d in zip(surface.shape[:2], spacing, strict=False))
        if window == "hann" and self.tapers:
            for axis, n in enumerate(eta.shape):
                taper = np.sin(np.pi * np.arange(n) / n).astype(self.real) ** 2
                eta = eta * taper.reshape([-1 if a == axis else 1 for a in range(3)])
        kx, ky, omega = (2 * np.pi * np.fft.fftfreq(n, d) for n, d in zip(eta.shape, spacing, strict=True))
        f = np.abs(self.transform(eta / np.abs(eta).max()))
        weight = np.ones(omega.size)
        if self.half:
            keep = np.arange(eta.shape[2] // 2 + 1)
            weight = np.where((2 * keep) % eta.shape[2] == 0, 0.5, 1.0)
            f, omega = f[:, :, keep], omega[keep]
        kx, ky = np.meshgrid(kx, ky, indexing="ij")
        x, y, w, v, f = (a.astype(self.real) for a in (kx, ky, -omega, weight, f))
        return (x, y, np.hypot(x, y), w, f, v), dk

    def _overlap(self, shell: Bins, gravity: float, a: float, unit: float) -> FloatArray:
        """N of eq:normSp, G having both branches (D2), over the whole space or one half; the factor by which it is
        normalised is another than the reference's, which moves no maximum.
        """
        x, y, k, omega, f, weight = shell
        root = np.sqrt(self.real(gravity) * k)[:, None]

        def score(c: FloatArray) -> float:
            u, v = c.astype(self.real)
            along = omega - (x * u + y * v)[:, None]
            g = weight * (np.exp(-2 * ((along - root) / a) ** 2) + np.exp(-2 * ((along + root) / a) ** 2))
            return float((f * g).sum() / g.sum() / f.mean()) if g.any() else 0.0

        return self.optimiser(score, unit)

    def _least_squares(self, shell: Bins, gravity: float, a: float, unit: float) -> FloatArray:
        """The minimum of eq:LS1 over the bins above 0.2 of the largest power of the shell (D7), by NumPy's `lstsq`."""
        x, y, k, omega, f, _ = shell
        n, m = np.nonzero((f**2 >= 0.2 * f.max() ** 2) & (omega >= 0))
        if self.half:  # of a half of negative frequencies the mirror image
            n, m = np.nonzero((f**2 >= 0.2 * f.max() ** 2) & (omega <= 0))
            x, y, omega = -x, -y, -omega
        rows = np.stack([x[n], y[n]], axis=1)
        found, _, rank, _ = np.linalg.lstsq(rows, omega[m] - np.sqrt(self.real(gravity) * k[n]), rcond=1e-5)
        return found if rank == 2 else np.full(2, np.nan)


def _shell(space: Bins, wavenumber: float, dk: float) -> Bins:
    """The bins within two of a wavenumber, those on the edge included (D3)."""
    x, y, k, omega, f, weight = space
    inside = np.abs(k - wavenumber) <= 2 * dk * (1 + 1e-6)
    return x[inside], y[inside], k[inside], omega, f[inside], weight


class _BySimplex(_Own):
    """Least squares as a search instead of a solve."""

    def _least_squares(self, shell: Bins, gravity: float, a: float, unit: float) -> FloatArray:
        x, y, k, omega, f, _ = shell
        n, m = np.nonzero((f**2 >= 0.2 * f.max() ** 2) & (omega >= 0))
        shift = omega[m] - np.sqrt(gravity * k[n])
        return self.optimiser(lambda c: -float(np.mean((c[0] * x[n] + c[1] * y[n] - shift) ** 2)), unit)


class _ByLoops(_Own):
    """The scalar product bin by bin, as one would write it first."""

    def _overlap(self, shell: Bins, gravity: float, a: float, unit: float) -> FloatArray:
        return self.optimiser(lambda c: float(_looped(*shell, c, gravity, a)), unit)


@njit()
def _looped(x, y, k, omega, f, weight, c, gravity, a):  # type: ignore[no-untyped-def]  # compiled
    """The same overlap as `_Own._overlap`, in two loops."""
    overlap = total = 0.0
    for n in range(k.size):
        shift, root = x[n] * c[0] + y[n] * c[1], np.sqrt(gravity * k[n])
        for m in range(omega.size):
            near, far = (omega[m] - shift - root) / a, (omega[m] - shift + root) / a
            g = weight[m] * (np.exp(-2 * near**2) + np.exp(-2 * far**2))
            overlap, total = overlap + f[n, m] * g, total + g
    return overlap / total if total else 0.0


class _Band(_Own):
    """One current for the whole band: least squares over every strong bin near some dispersion surface."""

    def describe(self) -> Mapping[str, object]:
        return {"can": {"extract": {"methods": ["dispersion-fit"], "windows": ["box", "hann"], "resolves": "band"}}}

    def extract(
        self,
        surface: FloatArray,
        spacing: Sequence[float],
        wavenumbers: Sequence[float],
        *,
        gravity: float,
        window: str,
        method: str,
    ) -> FloatArray:
        """The current, (1, 2): the bins are weighted by their power, and those off the surface left out in turn."""
        (x, y, k, omega, f, _), dk = self._space(surface, spacing, window)
        inside = (k >= min(wavenumbers) - 2 * dk) & (k <= max(wavenumbers) + 2 * dk)
        power = np.where(inside[:, :, None] & (omega > 0), f, 0) ** 2
        i, j, m = np.nonzero(power >= 0.05 * power.max())
        rows, weight = np.stack([x[i, j], y[i, j]], axis=1), np.sqrt(power[i, j, m])
        shift, c = omega[m] - np.sqrt(gravity * k[i, j]), np.zeros(2)
        for _ in range(6):
            off = np.abs(rows @ c - shift)
            keep = off <= max(2.5 * float(np.median(off)), 2 * float(omega[0] - omega[1]))
            c = np.linalg.lstsq(rows[keep] * weight[keep, None], shift[keep] * weight[keep], rcond=None)[0]
        return c[None]


def _changed(*changes: tuple[str, str, str]) -> Callable[[], Any]:
    """The altered reference, made when it is asked for, since compiling takes long."""
    return lambda: altered(tuple(Change(*change) for change in changes)).chain.Reference()


VARIANTS = {variant.id: variant for variant in (
    Variant("axes-txy", "conformant", "wants cubes with the axes t, x, y", lambda: _Permuted("txy")),
    Variant("axes-ytx", "conformant", "wants cubes with the axes y, t, x", lambda: _Permuted("ytx")),
    Variant("y-downwards", "conformant", "counts rows downwards, and says so", lambda: Named(reference, "", y="down")),
    Variant("direction-from", "conformant", "returns where currents come from, and says so", _From),
    Variant("si", "conformant", "works in metres and seconds", lambda: Named(reference, "", units="si")),
    Variant("times-million", "conformant", "works with surfaces a million times as high",
            lambda: _Prepared(lambda eta: 1e6 * eta)),
    Variant("times-millionth", "conformant", "works with surfaces a millionth as high",
            lambda: _Prepared(lambda eta: 1e-6 * eta)),
    Variant("mean-removed", "sound", "removes the mean of the surface first",
            lambda: _Prepared(lambda eta: eta - eta.mean())),
    Variant("background-removed", "sound", "removes the mean picture from every frame first",
            lambda: _Prepared(lambda eta: eta - eta.mean(axis=2, keepdims=True))),
    Variant("eight-bits", "sound", "sees images of 8 bits", lambda: _Prepared(_quantised(8))),
    Variant("sixteen-bits", "sound", "sees images of 16 bits", lambda: _Prepared(_quantised(16))),
    Variant("fixed-wavenumbers", "sound", "has wavenumbers of its own, and says which", _Fixed),
    Variant("declining", "conformant", "declines wavenumbers that it does not trust", _Declining),
    Variant("coarse-simplex", "conformant", "stops the simplex at 1e-3 and goes on by Newton's method",
            _changed(("nsp", '"xatol": 1e-8', '"xatol": 1e-3'))),
    Variant("edge-bins-excluded", "sound", "leaves the bins on the edge of a shell out (D3)",
            _changed(("shell", "/ dk <= half_width + EDGE_MARGIN", "/ dk < half_width - EDGE_MARGIN"))),
    Variant("symmetric-hann", "sound", "samples windows symmetrically (D1)",
            _changed(("window", "(size - 1 if symmetric else size)", "(size - 1)"))),
    Variant("whole-space", "conformant", "sums over the whole space, by SciPy's FFT", _Own),
    Variant("half-space", "conformant", "sums over one half of the space", lambda: _Own(half=True)),
    Variant("numpy-fft", "conformant", "uses NumPy's FFT", lambda: _Own(transform=np.fft.fftn)),
    Variant("single-precision", "sound", "computes in 32 bits",
            lambda: _Own(lambda s, unit: _simplex(s, unit, 1e-4), real=np.float32)),
    Variant("fminsearch", "sound", "stops Nelder-Mead at MATLAB's default tolerances",
            lambda: _Own(lambda s, unit: _simplex(s, unit, 1e-4))),
    Variant("bfgs", "sound", "maximises by BFGS with differences", lambda: _Own(_gradient)),
    Variant("powell", "sound", "maximises by Powell's method, from the best point of a lattice", lambda: _Own(_powell)),
    Variant("lattice-search", "sound", "looks for the highest maximum on a lattice", lambda: _Own(_lattice)),
    Variant("ls-by-simplex", "sound", "does its least squares by a simplex search", _BySimplex),
    Variant("loops", "conformant", "sums bin by bin in plain loops", _ByLoops),
    Variant("no-taper", "sound", "tapers nothing, and says so", lambda: _Own(tapers=False)),
    Variant("band", "sound", "fits one current to the whole band", _Band),
    Variant("every-method", "conformant", "offers all methods of the reference", beside.every),
)}  # fmt: skip
"""Every variant by id."""

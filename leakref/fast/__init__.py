# mypy: disallow-untyped-defs=False
"""The whole chain in closed form and compiled: what `leakage`, `shell`, `nsp` and `leastsquares` give, sooner.

Those are the reference, and tests hold this against them. `spectra` makes the magnitudes, `score` climbs the scores;
here they come together. The result is the same to the last bit on one machine as long as the products run on one
thread.

Three things make it fast. Only the disc of bins that shells and waves reach is ever computed, and for all windows at
once. A score is a polynomial near any velocity, so that following a simplex costs no passes over bins. And what depends
on the grid alone (bins, shells, tables) is made once for all realisations. What is rare (a shell at the edge of the
band, a search that gets lost, waves in the corners of the spectrum, a method without a twin here) is handed to the
reference itself, so that nothing has to be right twice.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from copy import copy
from functools import cached_property, lru_cache
from math import comb
from typing import Any

import numpy as np
import numpy.typing as npt

from leakref import leakage, nsp, nspadaptive, nspgrid
from leakref._base import FloatArray, IntArray, fraction, positive
from leakref.dispersion import Water, law, velocity_unit
from leakref.fast.basins import PLACES, POOL, peaks, pool, read_off
from leakref.fast.leastsquares import least_squares, only_leaked
from leakref.fast.score import DENSE, ORDER, Ring, climb, hermite, models, outdone, principal, scores
from leakref.fast.spectra import Disc, magnitudes
from leakref.grid import Grid
from leakref.leastsquares import FREE, THRESHOLD
from leakref.leastsquares import remarks as fit_remarks
from leakref.methods import Method
from leakref.methods import method as named_method
from leakref.sea import Components
from leakref.shell import (
    _ROUNDING,
    EDGE_MARGIN,
    HALF_WIDTH,
    Extraction,
    Note,
    Optimum,
    Shell,
    checked_wavenumbers,
    collect,
    nothing,
    shell_at,
)
from leakref.spectrum import Spectrum
from leakref.window import window as named_window

__all__ = ["realize"]

_Found = dict[tuple[str, str], Extraction]
"""By window and method."""
_ROWS = 256  # of columns at a time, so that they stay in the cache
_CUT = 4.25  # widths, where the Gaussian ends: 1e-15 of it is left


@lru_cache(maxsize=32)
def _lobes(window: str, size: int) -> FloatArray:
    """Window.sidelobe_envelope at every distance modulo `size`, (size,): the same for all realisations."""
    return named_window(window).sidelobe_envelope(np.arange(size), size)


def _pad(width: float) -> int:
    """Bins on either side of a Gaussian's centre."""
    return int(np.ceil(_CUT * width)) + 1


@lru_cache(maxsize=256)
def _taps(width: float) -> FloatArray:
    """`hermite`, of a number of bins that five divides."""
    half = int(np.ceil(_CUT * width))
    return hermite(width, half + (2 - half) % 5)


@lru_cache(maxsize=256)
def _gaussians(width: float, blocks: int) -> tuple[IntArray, npt.NDArray[np.float32]]:
    """Gaussians around `blocks` of places, (blocks, bins, PLACES), and `_pad` past the first bin of each (blocks,)."""
    centres = np.arange(blocks * PLACES).reshape(blocks, PLACES) * (width / 8)
    low, pad = centres[:, 0].astype(np.int64), _pad(width)
    bins = low[:, None] - pad + np.arange(2 * pad + 2 + int(PLACES * width / 8))
    return low, np.exp(-2 * ((bins[:, :, None] - centres[:, None]) / width) ** 2).astype(np.float32)


class _Seen:
    """The magnitudes under one window, and the two extractions from a shell of them. Everything that shells share is
    made here once: sums and largest magnitudes of the columns, and what the strongest bin may leak along each axis, as
    a product of two envelopes across and one along omega.
    """

    def __init__(self, disc: Disc, window: str, magnitude: FloatArray, rings: list[Ring]) -> None:
        self.disc, self.magnitude, self.width, grid = disc, magnitude, rings[0].width, disc.grid
        fastest = max(ring.centre.max() + ring.largest * nsp._REACH * ring.unit for ring in rings)
        self.furthest = min(fastest, magnitude.shape[1] + 5 * self.width)  # that a centre may be
        self.step, self.even, m = grid.frequency_resolution, grid.shape[2] % 2 == 0, grid.bins(2)
        self.weight = np.where((m == 0) | (2 * m == grid.shape[2]), 0.5, 1.0)
        self.sums, self.largest = magnitude @ self.weight, magnitude.max(axis=1)
        self.strongest = int(self.largest.argmax())
        at = [*(int(bins[self.strongest]) for bins in disc.bins), int(magnitude[self.strongest].argmax())]
        x, y, self.along = (
            np.stack([lobes[(bins - n) % lobes.size], lobes[(bins + n) % lobes.size]])  # wave, mirror
            for lobes, bins, n in zip(map(_lobes, 3 * [window], grid.shape), (*disc.bins, m), at, strict=True)
        )
        self.across = self.largest[self.strongest] * x * y
        self.models, self.bar = models(self.largest.size), _ROUNDING * self.largest[self.strongest]

    def _shell(self, ring: Ring) -> Shell:
        """As shell.shell_at makes it. For what is handed to the reference, and to methods without a twin."""
        floor = None if (ring.columns == self.strongest).any() else self.across[:, ring.columns].T @ self.along
        kx, ky, intrinsic, omega = (
            bins * self.step for bins in (ring.kx, ring.ky, ring.centre, self.disc.grid.bins(2))
        )
        return Shell(
            ring.wavenumber * self.step,
            ring.frequency * self.step,
            kx,
            ky,
            intrinsic,
            omega,
            self.weight,
            self.magnitude[ring.columns],
            floor,
            self._is_empty(ring),
        )

    def plain(self, ring: Ring, method: Method, settings: Mapping[str, Any]) -> Optimum:
        """What a method says of the shell that has no twin here and needs nothing but the shell."""
        assert method.optimum is not None
        return method.optimum(self._shell(ring), **settings)

    def _alone(self, ring: Ring, width: float) -> tuple[_Seen, Ring]:
        """The columns of one shell by themselves, with a width of G of their own.

        Columns stay in their order, so that the mirror image of the first is still the last.
        """
        columns, own = ring.columns, copy(self)
        own.__dict__.pop("_table", None)
        own.magnitude, own.width, own.models = self.magnitude[columns], width, models(columns.size)
        own.sums, own.largest, own.across = self.sums[columns], self.largest[columns], self.across.take(columns, axis=1)
        own.strongest = next(iter(np.flatnonzero(columns == self.strongest).tolist()), -1)
        fastest = ring.centre.max() + ring.largest * nsp._REACH * ring.unit
        own.furthest = min(fastest, own.magnitude.shape[1] + 5 * width)
        return own, ring._replace(columns=np.arange(columns.size), width=width, taps=_taps(width))

    def _is_empty(self, ring: Ring) -> bool:
        """By the same bar as the reference: what is left is rounding of the strongest bin."""
        return not self.largest[ring.columns].max() > self.bar

    def _reach(self, ring: Ring) -> float:
        """nsp.score_range."""
        top = self.magnitude.shape[1] - 1 - ring.frequency - 3 * self.width
        return float(min(nsp._REACH * ring.unit, top / ring.wavenumber))

    def nsp_grid(self, ring: Ring, **settings: Any) -> Optimum:
        """nspgrid.optimum. The lattice is looked at in the table, and closely where that may be the best."""
        ring = ring._replace(magnitude=self.magnitude)
        lattice = nspgrid.LATTICE[np.hypot(*nspgrid.LATTICE.T) * ring.unit <= self._reach(ring)]
        if self._is_empty(ring) or not len(lattice):
            return self.nsp(ring, **settings)
        if self.width < DENSE:  # the table wants it so
            start = nspgrid.start(self._shell(ring), self.width * self.step, ring.unit)
        else:
            rough = read_off(ring, self._table[0], lattice * ring.unit)
            lattice = lattice[rough >= nspgrid.WORTH * rough.max()]
            self.models.made[:] = 0
            start = nspgrid.slowest(lattice, scores(ring, self.models, lattice * ring.unit))
        return self.nsp(ring, start=start, **settings)

    def nsp_adaptive(self, ring: Ring, *, water: Water, **settings: Any) -> Optimum:
        """nspadaptive.extract, of one shell."""
        if self._is_empty(ring):
            return nothing(Note.NO_SIGNAL)
        wider = nspadaptive.spread(self.disc.grid, water, ring.wavenumber * self.step)
        own, ring = self._alone(ring, self.width * wider)
        return own.nsp(ring, **settings)

    def nsp(self, ring: Ring, *, search: bool, start: FloatArray | None = None, **_: object) -> Optimum:
        """nsp.optimum.

        `climb` follows SciPy's simplex on polynomials; what it finds beyond reach, flat, or leaving the band is asked
        of the reference instead, whose rules for such cases stand in one place only. N is known up to the factor by
        which the magnitudes of the shell are normalised, which is put in at the end.
        """
        if self._is_empty(ring):
            return nothing(Note.NO_SIGNAL)
        ring, velocity, d = ring._replace(magnitude=self.magnitude), np.empty(2), np.empty(6)
        self.models.made[:] = 0
        first = np.zeros(2) if start is None else start
        used, arrived = climb(ring, self.models, nsp.START, first, velocity, d)
        reach = self._reach(ring)
        beyond, stiff, soft = np.hypot(*velocity) > reach, -principal(d)[1], -principal(d)[0]
        centres = ring.centre + ring.kx * velocity[0] + ring.ky * velocity[1]
        if not arrived or (
            beyond and (soft <= nsp.UNKNOWN * stiff or nsp.leaves_the_band(centres, self.magnitude.shape[1] - 1))
        ):
            shell = self._shell(ring)  # rare
            return nsp.optimum(shell, self.width * self.step, ring.unit, search=search, start=first)
        score = d[0]
        d *= ring.columns.size * self.weight.sum() / self.sums[ring.columns].sum()
        note = nsp.remarks(ring.columns.size, soft, score, ring.unit, bool(beyond))
        if only_leaked(ring, self.strongest, velocity, 0.0, self.across, self.along):
            note |= Note.LEAKAGE_FLOOR
        if (
            search
            and reach > 0
            and (
                self._another_basin(ring, velocity, score, reach)
                if self.width >= DENSE
                # the table wants it so
                else nsp.another_basin(self._shell(ring), velocity, float(d[0]), self.width * self.step, ring.unit)
            )
        ):
            note |= Note.ANOTHER_BASIN
        return Optimum(velocity, float(d[0]), d[1:3].copy(), d[[3, 4, 4, 5]].reshape(2, 2), int(used), note)

    def _another_basin(self, ring: Ring, velocity: FloatArray, score: float, reach: float) -> bool:
        """nsp.another_basin.

        `peaks` chooses starts from a table in single precision, and `outdone` climbs from each in double: the first
        decides only what is looked at, the second what is true.
        """
        table, pooled, tops = self._table
        tops = tops[ring.columns]
        order, best = np.argsort(-tops, kind="stable"), np.empty((7, 3))
        starts = peaks(ring, order, tops[order], table, pooled, reach, velocity, best)
        return bool(starts and outdone(ring, self.models, best[:starts], reach, score))

    @cached_property
    def _table(self) -> tuple[npt.NDArray[np.float32], npt.NDArray[np.float32], FloatArray]:
        """Each column's part of the score by the centre of the Gaussian, from 0 up in eighths of the width; and `pool`.

        In single precision: it only chooses starts.

        Each column is convolved with Gaussians whose centres are an eighth of the width apart. A block of `PLACES` of
        them reaches over few bins, so the whole table is a matrix product for each block, of rows that stay in the
        cache.
        """
        blocks, gaussians = _gaussians(self.width, int((self.furthest * 8 / self.width + 2 + POOL) / PLACES) + 1)
        (n, nw), pad = self.magnitude.shape, _pad(self.width)
        below = min(pad, nw - 1)  # negative frequencies, of which a short video has fewer than the Gaussian is wide
        table = np.empty((n, len(blocks) * PLACES), dtype=np.float32)
        f = np.zeros((_ROWS, pad + max(nw, blocks[-1] + gaussians.shape[1])), dtype=np.float32)
        for start in range(0, n, _ROWS):
            end = min(start + _ROWS, n)
            here = f[: end - start]
            here[:, pad : pad + nw] = self.magnitude[start:end]
            here[:, pad - below : pad] = self.magnitude[n - end : n - start][::-1, below:0:-1]
            if self.even:
                here[:, [pad + nw - 1, max(pad - nw + 1, 0)][: 1 + (below == nw - 1)]] *= 0.5
            for block, (low, g) in enumerate(zip(blocks, gaussians, strict=True)):
                np.matmul(here[:, low : low + len(g)], g, out=table[start:end, block * PLACES : (block + 1) * PLACES])
        return table, *pool(table)

    def ls(self, ring: Ring, *, threshold: float, **_: object) -> Optimum:
        """leastsquares.optimum. Frequencies are in bins throughout, and squares of them are scaled at the end."""
        if self._is_empty(ring):
            return nothing(Note.NO_SIGNAL)
        ring, out = ring._replace(magnitude=self.magnitude), np.empty(8)
        used, close, is_free, bar = least_squares(ring, self.largest, threshold, FREE, out)
        mean, radius = (out[3] + out[5]) / 2, np.hypot((out[3] - out[5]) / 2, out[4])
        note = fit_remarks(used, close, mean - radius, mean + radius)
        if only_leaked(ring, self.strongest, out, bar, self.across, self.along):
            note |= Note.LEAKAGE_FLOOR
        if is_free:
            return nothing(note)
        out[2:] *= self.step**2
        return Optimum(out[:2], float(out[2]), 2 * out[6:], 2 * out[[3, 4, 4, 5]].reshape(2, 2), 0, note)


@lru_cache(maxsize=8)
def _rings(
    grid: Grid,
    radius: float,
    wavenumbers: tuple[float, ...],
    water: Water,
    peak_wavenumber: float | None,
    width: float,
    half_width: float,
) -> tuple[Disc, list[Ring]]:
    """The bins, and the shells, still without magnitudes: the same for all realisations.

    Raises LeakrefError as shell.shell_at does. Eight of them are remembered, since a run over many realisations asks
    for the same one each time.
    """
    disc, step = Disc(grid, radius), grid.frequency_resolution
    dk, nyquist = grid.wavenumber_resolution, min(grid.nyquist[:2])
    kx, ky = (bins * spacing for bins, spacing in zip(disc.bins, grid.bin_widths, strict=False))
    k = np.hypot(kx, ky)
    centre = water.frequency(k) / step
    taps, is_even = _taps(width), grid.shape[2] % 2 == 0
    binomials = np.array([[float(comb(q + p, p)) for p in range(ORDER)] for q in range(ORDER)])
    rings = []
    for k_i in wavenumbers:
        columns = np.flatnonzero(np.abs(k - k_i) / dk <= half_width + EDGE_MARGIN)
        if not columns.size or k_i + half_width * dk >= nyquist * (1 - EDGE_MARGIN):
            empty = Spectrum(grid, "box", grid.bins(0), grid.bins(1), np.empty((0, 0, 0), dtype=np.complex128))
            shell_at(empty, k_i, water=water, half_width=half_width)  # which says what is wrong
        unit = velocity_unit(float(k_i), water, peak_wavenumber)
        own = (columns, kx[columns] / step, ky[columns] / step, centre[columns])
        place = (float(k[columns].max()) / step, float(k_i) / step, float(water.frequency(k_i)) / step)
        rings.append(Ring(np.empty((0, 0)), *own, *place, unit, float(width), is_even, taps, binomials))
    return disc, rings


_TWINS: dict[str, Callable[..., Optimum]] = {
    "nsp": _Seen.nsp, "ls": _Seen.ls, "nsp-grid": _Seen.nsp_grid, "nsp-adaptive": _Seen.nsp_adaptive
}  # fmt: skip
"""Of the methods that are compiled here; all others are asked as they are, of one shell if that is enough."""


def _plainly(
    components: Components,
    grid: Grid,
    wavenumbers: FloatArray,
    windows: Sequence[str],
    methods: Sequence[Method],
    settings: Mapping[str, Any],
    **shells: Any,
) -> _Found:
    """`realize` by the reference itself."""
    spectra = {name: leakage.spectrum(components, grid, name) for name in windows} if methods else {}
    return {
        (name, method.id): method.extract(spectra[name], wavenumbers, **shells, **_own(method, settings))
        for name in windows
        for method in methods
    }


def _own(method: Method, settings: Mapping[str, Any]) -> dict[str, Any]:
    return {name: value for name, value in settings.items() if name in method.settings}


def realize(
    components: Components,
    grid: Grid,
    wavenumbers: npt.ArrayLike,
    *,
    windows: Sequence[str] = ("box", "hann"),
    methods: Sequence[str] = ("nsp", "ls"),
    gravity: float | None = None,
    water: Water | None = None,
    peak_wavenumber: float | None = 1.0,
    width: float = nsp.WIDTH,
    half_width: float = HALF_WIDTH,
    threshold: float = THRESHOLD,
    search: bool = True,
) -> _Found:
    """What `chain.analyse` reports of these waves under every (window, method): velocities to 1e-11, and all notes.

    Settings as in `nsp.extract` and `leastsquares.extract`. `evaluations` are those of this way of climbing; the
    strongest bin (Note.LEAKAGE_FLOOR) is that within the outermost shell or wave. Raises LeakrefError.

    `wavenumbers` (n,), `width` (in frequency bins) and `half_width` (in wavenumber bins) are as in the reference,
    `gravity` in the units of the grid. Returned are Extractions with velocities (n, 2), in the order of `windows`, then
    `methods`. LeakrefError is raised for what the reference refuses: unknown names, wavenumbers beyond the Nyquist one,
    a threshold outside (0, 1].
    """
    tapers, records = [named_window(name) for name in windows], [named_method(name, "realize") for name in methods]
    k = checked_wavenumbers(wavenumbers, "realize")
    positive("realize", width=width, half_width=half_width, peak_wavenumber=peak_wavenumber or 1.0)
    fraction("realize", threshold=threshold)
    water = law("realize", gravity, water)
    settings = {"peak_wavenumber": peak_wavenumber, "width": width, "search": search, "threshold": threshold}
    dk, inside = grid.wavenumber_resolution, min(grid.nyquist[:2]) * (1 - EDGE_MARGIN)
    waves = float(np.hypot(components.kx, components.ky).max()) + dk
    # waves in the corners of the spectrum are where the disc does not reach: let the reference look there
    plain = [record for record in records if waves > inside or not (record.id in _TWINS or record.optimum)]
    found = _plainly(components, grid, k, windows, plain, settings, water=water, half_width=half_width)
    compiled = [record for record in records if record not in plain]
    if compiled or not records:  # of no method the spectra alone, which are timed
        outermost = float(k.max() + half_width * dk)
        radius = min(max(outermost, waves), inside) + EDGE_MARGIN * dk
        disc, rings = _rings(grid, radius, tuple(k.tolist()), water, peak_wavenumber, width, half_width)
        for name, magnitude in magnitudes(components, grid, tapers, disc).items():
            seen = _Seen(disc, name, magnitude, rings)
            for record in compiled:
                if record.id in _TWINS:
                    optima = [_TWINS[record.id](seen, ring, water=water, **settings) for ring in rings]
                else:
                    optima = [seen.plain(ring, record, _own(record, settings)) for ring in rings]
                found[name, record.id] = collect(record.id, k, optima)
    return {(name, record.id): found[name, record.id] for name in windows for record in records}

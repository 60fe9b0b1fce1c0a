"""What this machine could do at best, and what each stage asks of it: the yardstick of `leakref bench`.

Three limits are measured: a large matrix product on all threads and on one, and copying memory. For each stage the
multiply-adds or the bytes that it cannot do without are counted from its sizes, by the same code that arranges them.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from statistics import median
from time import perf_counter

import numpy as np

from leakref import runs
from leakref.fast.kernels import _WIDE
from leakref.fast.spectra import Disc, _Axis, _Band, _placed
from leakref.grid import Grid
from leakref.sea import Components
from leakref.shell import HALF_WIDTH

__all__ = [
    "MATRIX",
    "MATRIX_ONE",
    "MEMORY",
    "Machine",
    "closed_form_products",
    "fast_products",
    "fft_traffic",
    "magnitudes_traffic",
    "seconds",
    "synthesis_products",
]

MATRIX, MATRIX_ONE, MEMORY = "matrix product", "matrix product, one thread", "memory"
"""The limits, as they are named in a row."""


def seconds(work: Callable[[], object], repeats: int = 3, pick: Callable[[list[float]], float] = median) -> float:
    """Median time of `work` (or what `pick` makes of the times), after one run that is not counted. Compilation and
    first touches of memory are in the run that is not counted.
    """
    times = []
    for _ in range(repeats + 1):
        start = perf_counter()
        work()
        times.append(perf_counter() - start)
    return pick(times[1:])


@dataclass(frozen=True)
class Machine:
    """Real multiply-adds a second in a large matrix product, on all threads and on one, and bytes moved a second. Keys
    are `MATRIX`, `MATRIX_ONE` and `MEMORY`.
    """

    rates: dict[str, float]

    @classmethod
    def measured(cls) -> Machine:
        """Of this machine, now."""
        n = 1500
        a, b = np.random.default_rng(0).standard_normal((2, n, n))
        target, source = np.empty(2**24), np.ones(2**24)
        together = n**3 / seconds(lambda: a @ b, 5)
        with runs.one_thread():
            alone = n**3 / seconds(lambda: a @ b, 5)
        return cls(
            {
                MATRIX: together,
                MATRIX_ONE: alone,
                MEMORY: 2 * source.nbytes / seconds(lambda: np.copyto(target, source), 5),
            }
        )

    def share(self, limit: str, asked: float, time: float) -> float:
        """The part of a limit that is reached when `asked` operations or bytes take `time` seconds."""
        return asked / time / self.rates[limit]


def _lattice(waves: Components) -> tuple[int, int]:
    lattice = waves.separated()
    return (lattice[0].size, lattice[2].size) if lattice is not None else (1, waves.kx.size)


def synthesis_products(waves: Components, shape: tuple[int, int, int]) -> float:
    """Real multiply-adds in the matrix products of `synthesize`: complex along y, real along x. Waves that are no
    lattice count as a single row of it.
    """
    rows, columns = _lattice(waves)
    nx, ny, nt = shape
    return float(4 * rows * ny * columns * nt + 2 * nx * rows * ny * nt)


def fft_traffic(shape: tuple[int, int, int]) -> float:
    """Bytes of `fourier`: taper, then three passes over half as many complex numbers, each read and written."""
    return 8.0 * 8 * float(np.prod(shape))


def closed_form_products(waves: Components, grid: Grid, reach: float, windows: int) -> float:
    """Real multiply-adds of `leakage.spectrum`: for each frequency two products of three complex matrices. `reach` is
    the largest wavenumber kept; the cheaper order of the two products is taken.
    """
    rows, columns = _lattice(waves)
    i, j = (int(np.sum(np.abs(grid.bins(axis)) <= reach / grid.bin_widths[axis] + 1e-9)) for axis in (0, 1))
    left_first = i <= j
    one = i * rows * columns + i * columns * j if left_first else rows * columns * j + i * rows * j
    return float(windows * (grid.shape[2] // 2 + 1) * 2 * 4 * one)


def fast_products(waves: Components, grid: Grid, reach: float, stencil: int = 1) -> float:
    """Real multiply-adds of `fast.realize`, as `fast.spectra` arranges them: all windows come from one pass."""
    extents = Disc(grid, reach).extents(stencil)
    x, y, t = (
        _Axis(k / dk, size)
        for k, dk, size in zip((waves.kx, waves.ky, waves.omega), grid.bin_widths, grid.shape, strict=True)
    )
    kernel_x, kernel_y, _, _, parts, _, are_few = _placed(waves, x, y, extents)
    (wide, rows), columns = kernel_x.shape, kernel_y.shape[1]
    band = _Band(t, stencil)
    nodes, count, cells = band.angles.size, band.near + band.angles.size, int(np.sum(2 * extents + 1))
    spread = 2 * waves.kx.size * _WIDE**2 * count if parts else 0
    along_x = 0 if are_few else 2 * wide * rows * columns * count
    return float(spread + along_x + 2 * cells * columns * count + 2 * cells * nodes * band.matrix.shape[1])


def magnitudes_traffic(grid: Grid, wavenumbers: np.ndarray) -> float:
    """Bytes an extraction must read at least: the magnitudes of each shell, once. `wavenumbers` are those of the
    shells, which overlap: a bin counts for each.
    """
    dk = grid.wavenumber_resolution
    k = np.hypot(*np.meshgrid(*(grid.bins(axis) * grid.bin_widths[axis] for axis in (0, 1)), indexing="ij"))
    bins = sum(int(np.sum(np.abs(k - k_i) <= HALF_WIDTH * dk)) for k_i in wavenumbers)
    return 8.0 * bins * (grid.shape[2] // 2 + 1)

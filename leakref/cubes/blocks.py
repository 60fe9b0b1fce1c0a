"""Cubes larger than memory: trend and transform taken a block at a time, only the bins needed kept.

Used by `leakref extract` for a memory-mapped cube beyond a gigabyte. Results are those of `spectrum.fourier` to
rounding; only the order of sums differs. It reads each sample once, or twice if a trend is removed, and looks at the
samples on the way: ones that are not finite are refused with the place where they stand.
"""

from __future__ import annotations

import mmap
from collections.abc import Iterator
from typing import Any

import numpy as np
from scipy import fft

from leakref._base import ORDINARY, ComplexArray, FloatArray, IntArray, LeakrefError, finite
from leakref._output import progress_bar
from leakref.grid import Grid
from leakref.spectrum import Spectrum
from leakref.window import window as named_window

__all__ = ["HELD", "TRENDS", "fourier_in_blocks", "largest_kept", "plane", "release", "trend"]

TRENDS = ("none", "mean", "linear")
"""What can be removed before the transform: nothing, the mean, or the plane a + bx x + by y + bt t."""
_BLOCK = 2**26  # bytes of samples, as float64, held at a time
HELD = 2**29
"""Bytes of what is transformed along two axes, at most: with the spectrum itself (`measuring.KEPT`) and all else it
stays within 2 GB, however large the cube.
"""


def _blocks(surface: Any, size: int, what: str) -> Iterator[tuple[int, slice, FloatArray]]:
    """(axis, slice, finite float64 samples) along the axis that is slowest in the file: reads are in order. A block is
    a slice along one axis, whole along the others. It ends early at samples that are too large, since their sums would
    be infinite.
    """
    axis = _slowest(surface)
    n = surface.shape[axis]
    step = max(1, size * n // (8 * int(np.prod(surface.shape, dtype=np.int64))))
    largest = 0.0
    with progress_bar(what, -(-n // step)) as done:
        for start in range(0, n, step):
            release(surface)
            part = slice(start, min(start + step, n))
            samples = finite(
                "extract",
                f"the surface, samples {start}...{part.stop - 1} along {'xyt'[axis]},",
                np.asarray(surface[(slice(None),) * axis + (part,)]),
                3,
            )
            largest = max(largest, float(samples.max()), -float(samples.min()))
            if largest > 2.0**ORDINARY:
                break
            yield axis, part, samples
            done()
    if largest and not 2.0**-ORDINARY <= largest <= 2.0**ORDINARY:
        raise LeakrefError("extract", f"the surface has samples of {largest:.3g} and no more", "scale them nearer to 1")


def release(surface: Any) -> None:
    """Let go of what a memory-mapped file has brought into memory; it is read again where it is needed.

    The system would do so by itself, but only when memory is short, and until then it would count as ours.
    """
    mapped = getattr(surface, "_mmap", None)
    if mapped is not None and hasattr(mapped, "madvise"):
        mapped.madvise(mmap.MADV_DONTNEED)


def trend(surface: Any, kind: str, *, block: int = _BLOCK) -> FloatArray:
    """The trend of a surface eta[x, y, t] as (mean, bx, by, bt), slopes per sample, by least squares.

    On a full lattice the centred indices are orthogonal to each other and to the mean, so each slope is one sum. Raises
    LeakrefError for an unknown kind or samples that are not finite.

    `surface` is anything with a shape that can be sliced. Returned are four numbers in the units of the samples: the
    mean, and what the plane rises by from one sample to the next along x, y and t, counted from the middle of the cube.
    With `mean` the slopes are zero, with `none` all four. `block` is in bytes of float64.
    """
    if kind not in TRENDS:
        raise LeakrefError("trend", f"no trend is called {kind!r}", f"choose one of {', '.join(TRENDS)}")
    found = np.zeros(4)
    if kind == "none":
        return found
    centred = [np.arange(n) - (n - 1) / 2 for n in surface.shape]
    for axis, part, samples in _blocks(surface, block, "looking for a trend"):
        index = [c[part] if a == axis else c for a, c in enumerate(centred)]
        along_t = samples.sum(axis=(0, 1))
        found += [
            along_t.sum(),
            index[0] @ samples.sum(axis=(1, 2)),
            index[1] @ samples.sum(axis=(0, 2)),
            index[2] @ along_t,
        ]
    found /= np.prod(surface.shape, dtype=np.float64)
    found[1:] *= [12 / (n**2 - 1) if kind == "linear" else 0.0 for n in surface.shape]
    return found


def largest_kept(surface: Any, grid: Grid, size: float) -> float:
    """The largest wavenumber, rad per length, up to which `fourier_in_blocks` needs no more than `size` bytes.

    What it needs is the transform along two axes, before the last one follows along the axis that is slowest in the
    file. `surface` is only asked how it is stored.
    """
    axis = _slowest(surface)
    nx, ny, nt = grid.shape
    if axis == 2:
        bins = size / (16 * nt)  # in the plane, a square about zero
        return float(np.sqrt(bins * np.prod(grid.bin_widths[:2])) / 2)
    across, width = (nx, grid.bin_widths[1]) if axis == 0 else (ny, grid.bin_widths[0])
    return float(size / (16 * across * (nt // 2 + 1)) * width / 2)


def plane(
    coefficients: FloatArray, shape: tuple[int, int, int], axis: int = 0, part: slice | None = None
) -> FloatArray:
    """The trend on a cube of `shape`, or on the `part` of it along `axis`.

    `coefficients` are those of `trend`. Returned is an array that can be subtracted, of the shape of the part.
    """
    x, y, t = (
        b * (np.arange(n) - (n - 1) / 2)[part if a == axis and part else slice(None)]
        for a, (n, b) in enumerate(zip(shape, coefficients[1:], strict=True))
    )
    return (coefficients[0] + x[:, None] + y)[:, :, None] + t


def fourier_in_blocks(
    surface: Any,
    grid: Grid,
    window: str = "hann",
    *,
    largest_wavenumber: float | None = None,
    remove: FloatArray | None = None,
    block: int = _BLOCK,
    held: int = HELD,
) -> Spectrum:
    """What `spectrum.fourier` gives, to rounding, on the bins with |kx|, |ky| <= `largest_wavenumber` (default all).

    `surface` is anything with a shape that can be sliced, for instance memory-mapped; `remove` is a `trend`. The
    transform is separable: a block along the slowest axis is transformed along the other two, only the bins kept are
    stored, and the last axis follows at the end. Where these would take more than `held` bytes the file is read several
    times, for some of the frequencies each. Memory: `block`, `held`, and the bins kept, never the cube. Raises
    LeakrefError.

    `largest_wavenumber` is in rad per length, and bins exactly on it are kept. `surface` keeps its own type in the
    file; blocks of it become float64. LeakrefError is raised for a surface of another shape than the grid's, samples
    that are not finite, and samples so large or small that their squares would not be numbers.
    """
    if surface.shape != grid.shape:
        raise LeakrefError(
            "fourier_in_blocks",
            f"the surface has shape {surface.shape}, the grid {grid.shape}",
            "pass the grid the surface was sampled on, axes in the order x, y, t",
        )
    kept = [grid.bins(a) for a in (0, 1)]
    if largest_wavenumber is not None:
        kept = [b[np.abs(b) <= largest_wavenumber / grid.bin_widths[a] + 1e-9] for a, b in enumerate(kept)]
    half = grid.shape[2] // 2 + 1
    axis = _slowest(surface)
    # what is kept of a block along two axes: (x, ky, omega), (kx, y, omega) or (kx, ky, t); the last two may be many
    shape = [kept[0].size, kept[1].size, half]
    shape[axis] = grid.shape[axis]
    split = 0 if axis == 2 else 2
    each = max(1, int(held // (16 * np.prod(shape) / shape[split])))
    whole = np.empty((kept[0].size, kept[1].size, half), dtype=np.complex128)
    passes = range(0, shape[split], each)
    for number, start in enumerate(passes, 1):
        part = slice(start, min(start + each, shape[split]))
        what = f"transforming ({window}" + f", {number} of {len(passes)}" * (len(passes) > 1) + ")"
        partial = _along_two(surface, grid, window, kept, part, what, remove, block)
        _along_the_last(partial, axis, kept, part, whole, what)
    return Spectrum(grid, window, kept[0], kept[1], whole)


def _slowest(surface: Any) -> int:
    """The axis that is slowest in the file."""
    return int(np.argmax(np.abs(getattr(surface, "strides", (3, 2, 1)))))


def _along_two(
    surface: Any,
    grid: Grid,
    window: str,
    kept: list[IntArray],
    part: slice,
    what: str,
    remove: FloatArray | None,
    block: int,
) -> ComplexArray:
    """The transform along all axes but the slowest one, of the bins kept; of these a `part`, of the frequencies or,
    where time is the slowest axis, of the kx.
    """
    axis = _slowest(surface)
    tapers = [named_window(window).samples(n) for n in grid.shape]
    partial: ComplexArray | None = None
    for _, rows, samples in _blocks(surface, block, what):
        wx, wy, wt = (w[rows] if a == axis else w for a, w in enumerate(tapers))
        samples = samples - plane(remove, grid.shape, axis, rows) if remove is not None else samples.copy()
        samples *= (wx[:, None] * wy)[:, :, None]
        samples *= wt
        if axis == 2:
            values = fft.fft2(samples, axes=(0, 1))[np.ix_(kept[0][part], kept[1])]  # signed bins index from the end
        else:  # the conjugate makes it exp(+i omega t), as in spectrum.fourier
            values = fft.rfft(samples, axis=2)[:, :, part].conj()
            values = fft.fft(values, axis=1 - axis).take(kept[1 - axis], axis=1 - axis)
        if partial is None:
            shape = list(values.shape)
            shape[axis] = grid.shape[axis]
            partial = np.empty(shape, dtype=np.complex128)
        partial[(slice(None),) * axis + (rows,)] = values
    assert partial is not None  # a grid has samples
    return partial


def _along_the_last(
    partial: ComplexArray, axis: int, kept: list[IntArray], part: slice, whole: ComplexArray, what: str
) -> None:
    """The transform along the slowest axis, row by row into its place in `whole`: nothing is there twice."""
    rows = partial.shape[1] if axis == 0 else partial.shape[0]
    with progress_bar(f"{what}, along {'xyt'[axis]}", rows) as done:
        for n in range(rows):
            if axis == 2:
                whole[part.start + n] = fft.ifft(partial[n], axis=-1, norm="forward")[:, : whole.shape[2]]
            elif axis == 0:
                whole[:, n, part] = fft.fft(partial[:, n], axis=0)[kept[0]]
            else:
                whole[n, :, part] = fft.fft(partial[n], axis=0)[kept[1]]
            done()

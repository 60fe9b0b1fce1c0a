"""Lost frames of a cube without time stamps, told by how the surface moves on.

A frame is foretold from the two before it, as a weighted sum of both: one step ahead, and two. The four weights are
fitted to the cube itself. Where a frame was lost the next one is what was foretold for two steps, and not for one. A
frame that is the same as the one before, a flicker, noise, and a still picture are like neither, or like both, and
nothing is said of them; nor where so few frames make a period that one step is as hard to foretell as two.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from leakref._base import FloatArray, levelled
from leakref.cubes.blocks import release

__all__ = ["seemingly_lost"]

_LOOKED_AT = (8, 48)  # pixels along each of x and y: at most the second, and of long videos no fewer than the first
_SAMPLES = 2**22  # of all pixels that are looked at
_TELLING = 1.5  # how much nearer a frame must be to what two steps foretell, as a ratio of mean squares
_CLEAN = (0.5, 0.25)  # of the frames, one and two steps ahead: so many are taken to have no gap before them
_ROUNDS = 6
_FEWEST = 24  # frames in which there is something to fit


def seemingly_lost(surface: Any) -> list[int]:
    """The frames of eta[x, y, t] behind which one seems to be lost, counted from 0; empty if none does.

    `surface` is anything that can be sliced; a lattice of its pixels is looked at. Two frames that are lost one after
    the other are not seen, nor is every second or third frame: that looks like another step in time.
    """
    nx, ny, nt = surface.shape
    if nt < _FEWEST:
        return []
    side = int(np.clip(np.sqrt(_SAMPLES / nt), *_LOOKED_AT))
    every = [-(-n // side) for n in (nx, ny)]
    looked_at = np.asarray(surface[:: every[0], :: every[1]], dtype=np.float64)
    release(surface)
    if not np.isfinite(looked_at).all():
        return []
    pixels = levelled(looked_at)[0].reshape(-1, nt).T
    pixels = pixels - pixels.mean(axis=1, keepdims=True)
    spread = pixels.std(axis=1, keepdims=True)
    if not (spread > 0).all():
        return []
    pixels = pixels / spread
    one, two = (_foretold(pixels, ahead) for ahead in (1, 2))
    # one[n], two[n]: how far frame n + 2 is from what frames n and n + 1 foretell, by the weights of one and two steps
    near = two * _TELLING < one
    usual = float(np.median(one))
    at = np.flatnonzero(near & (one > _TELLING * usual)) + 1
    return [int(n) for n in at if n - 1 not in at]  # behind a gap the two before a frame are two steps apart themselves


def _foretold(pixels: FloatArray, ahead: int) -> FloatArray:
    """The mean square by which each next frame misses what the two before it foretell for so many steps, (nt - 2,)."""
    nt = len(pixels)
    count = nt - 1 - ahead  # of triples of frames n, n + 1 and n + 1 + ahead
    first, second, third = pixels[:count], pixels[1 : count + 1], pixels[1 + ahead :]
    products = [np.einsum("np,np->n", a, b) for a, b in ((first, first), (first, second), (second, second))]
    aims = [np.einsum("np,np->n", third, a) for a in (first, second)]
    chosen, weights = np.ones(count, dtype=bool), np.zeros(2)
    for _ in range(_ROUNDS):
        aa, ab, bb = (float(p[chosen].sum()) for p in products)
        wanted = [float(p[chosen].sum()) for p in aims]
        weights = np.linalg.lstsq(np.array([[aa, ab], [ab, bb]]), np.array(wanted), rcond=None)[0]
        off = np.mean((third - weights[0] * first - weights[1] * second) ** 2, axis=1)
        chosen = off <= np.quantile(off, _CLEAN[ahead - 1])
    following = pixels[2:] - weights[0] * pixels[:-2] - weights[1] * pixels[1:-1]
    return np.asarray(np.mean(following**2, axis=1))

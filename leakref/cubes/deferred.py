"""Samples that are still in their file: read a block at a time, into memory or beside it.

What is larger than memory allows goes into a file without a name in the folder for temporary files, which is gone when
the program ends, and is mapped from there: whoever uses the samples slices them as any array.
"""

from __future__ import annotations

import math
import tempfile
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from typing import Any

import numpy as np

from leakref._base import Trouble
from leakref._output import progress_bar
from leakref.cubes.blocks import release

__all__ = ["BLOCK", "IN_MEMORY", "Deferred"]

IN_MEMORY = 2**30
"""Samples of more than this many bytes, as float64, are not held in memory."""
BLOCK = 2**26
"""Bytes that are read from a file at a time."""
Cut = tuple[slice, ...]


@dataclass(frozen=True)
class Deferred:
    """An array of `shape` and `dtype` that has not been read.

    `blocks(cut)` yields arrays that follow each other along the first axis and together are what `cut`, a slice an
    axis, takes out of the whole. With `reversed_axes` the file stores the axes the other way round, as HDF5 does for
    MATLAB: `shape` is what is seen, `blocks` is in the order of the file.
    """

    shape: tuple[int, ...]
    dtype: np.dtype[Any]
    blocks: Callable[[Cut], Iterator[Any]]
    reversed_axes: bool = False

    @property
    def ndim(self) -> int:
        """How many axes there are."""
        return len(self.shape)

    def gather(self, cut: Cut) -> Any:
        """What `cut` takes out of it, as an array, or memory-mapped if it is larger than `IN_MEMORY`.

        There is one slice an axis, in the order of `shape`. Raises Trouble where the folder for temporary files has no
        room, and whatever the reader of the file raises.
        """
        shape = tuple(len(range(*part.indices(n))) for part, n in zip(cut, self.shape, strict=True))
        order = slice(None, None, -1 if self.reversed_axes else 1)
        stored = shape[order]
        result = _room(stored, self.dtype)
        at = 0
        with progress_bar("reading", stored[0]) as step:
            for block in self.blocks(cut[order]):
                result[at : at + len(block)] = block
                at += len(block)
                release(result)
                for _ in range(len(block)):
                    step()
        return result.transpose(range(len(shape))[order])


def _room(shape: tuple[int, ...], dtype: np.dtype[Any]) -> Any:
    """An array that is to be filled, in memory or, if it is large, in a file that has no name."""
    count = math.prod(shape)
    if 8 * count <= IN_MEMORY:
        return np.empty(shape, dtype)
    try:
        with tempfile.TemporaryFile(prefix="leakref-") as stream:
            return np.memmap(stream, dtype, "w+", 0, shape)
    except OSError as error:
        raise Trouble(
            "extract",
            f"there is no room for {count * dtype.itemsize / 2**30:.1f} GB in {tempfile.gettempdir()} "
            f"({error.strerror})",
            "make room, name another folder in TMPDIR, or cut with --crop or --frames",
        ) from None

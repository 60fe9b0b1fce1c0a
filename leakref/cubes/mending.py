"""Frames that are lost or stand there twice, and holes in the samples: named with their numbers, mended on request.

A lost frame is told by its stamp, or by how the surface moves on (`gaps`), a doubled one by its stamp or because it is
the frame before to the bit. Nothing is mended that was not asked for, but for a doubled frame with a doubled stamp,
which says the same thing twice.
"""

from __future__ import annotations

from collections.abc import Sequence
from itertools import pairwise
from pathlib import Path
from typing import Any

import numpy as np

from leakref.cubes.asked import Asked
from leakref.cubes.blocks import release
from leakref.cubes.coordinates import Steps
from leakref.cubes.deferred import IN_MEMORY
from leakref.cubes.gaps import seemingly_lost
from leakref.cubes.suspicion import refuse

__all__ = ["Filled", "mapped", "mended"]

_NAMED = 8  # frames that are named, at most


def _numbers(frames: Sequence[int]) -> str:
    """Frames by their numbers, counted from 0."""
    shown = ", ".join(str(n) for n in frames[:_NAMED])
    return shown + (f" and {len(frames) - _NAMED} more" if len(frames) > _NAMED else "")


def mended(path: Path, eta: Any, time: Steps, asked: Asked, notes: list[str]) -> tuple[Any, float, int]:
    """The samples (nx, ny, nt) in memory as finite float64, whole and evenly spaced in time, and the step in time.

    Third is how many frames seem to be lost without a word in the file, and were not put in. What was done is added to
    `notes`. Refused, with a remedy that works, are holes and lost frames beyond the share that `asked` allows, and
    frames that differ but carry the same time.
    """
    eta = np.asarray(eta)
    eta, time = _without_doubled(path, eta, time, asked, notes)
    values = _filled(path, np.asarray(eta, dtype=np.float64), asked, notes)
    if time.lost:
        return _interpolated(path, values, time, asked, notes), time.step, 0
    gone = seemingly_lost(values)
    if gone and len(gone) <= asked.holes * (values.shape[2] + len(gone)):
        notes.append(_seeming(gone))
        seen = Steps(time.step, lost=tuple((at, 1) for at in gone))
        return _interpolated(path, values, seen, asked, notes), time.step, 0
    return values, time.step, _warned(gone, values.shape[2], time.step, notes)


def _seeming(gone: Sequence[int]) -> str:
    """That frames seem to be lost, and why it seems so."""
    many = len(gone) > 1
    return (
        f"{len(gone)} frame{'s seem' if many else ' seems'} to be lost, behind frame{'s' * many} {_numbers(gone)} "
        "(counted from 0): the waves move on there by two steps"
    )


def _warned(gone: Sequence[int], nt: int, step: float, notes: list[str]) -> int:
    """Say which frames seem to be lost, and what helps; how many they are."""
    if gone:
        share = np.ceil(1000 * len(gone) / (nt + len(gone))) / 1000
        put_in = f"--fill-holes {share:g} puts in frames between their neighbours, "
        first, end = _longest([-1, *gone, nt - 1])
        stretch = f"--frames {first}:{end} takes the longest stretch without a loss, " * (4 * (end - first) >= nt)
        notes.append(
            f"WARNING: {_seeming(gone)}; {put_in}{stretch}--spacing dx,dy,{step * (nt + len(gone)) / nt:.6g}, "
            "if that is not allowed for yet, takes all as equally spaced"
        )
    return len(gone)


def _longest(edges: Sequence[int]) -> tuple[int, int]:
    """The longest stretch between `edges`, frames behind which there is a gap: its first frame, and the end."""
    length, end = max((b - a, b) for a, b in pairwise(edges))
    return end - length + 1, end + 1


def mapped(path: Path, eta: Any, time: Steps, asked: Asked, notes: list[str]) -> tuple[Any, float, int]:
    """As `mended`, of samples that stay on the disk: those of a large file are mended where they are read, a small one
    is read if there is anything to mend.
    """
    if 8 * eta.size <= IN_MEMORY and (time.lost or time.doubled or asked.holes or asked.drop_doubled):
        return mended(path, eta, time, asked, notes)
    if time.lost or time.doubled:
        _refuse_lost(path, time, eta.shape[2], "")
    gone = seemingly_lost(eta) if 8 * eta.size <= IN_MEMORY else []  # a lattice of pixels may be on every page there is
    lost = _warned(gone, eta.shape[2], time.step, notes)
    if asked.holes and eta.dtype.kind == "f":
        return _mapped_filled(path, eta, asked, notes), time.step, lost
    return eta, time.step, lost


def _without_doubled(path: Path, eta: Any, time: Steps, asked: Asked, notes: list[str]) -> tuple[Any, Steps]:
    """Without the frames that say what the one before says.

    A frame goes if it is the same to the bit and its stamp says so too, or if it was asked for. Others that are the
    same are only named, since a calm sea filmed at night may well look so. Where the stamps say nothing of it the
    frames that are left are taken as even, as after a conversion from 24 to 30 frames a second.
    """
    nt = eta.shape[2]
    same = [n for n in range(1, nt) if np.array_equal(eta[:, :, n], eta[:, :, n - 1])]
    if len(same) == nt - 1:
        notes.append("all frames are the same")
        return eta, time
    unlike = sorted(set(time.doubled) - set(same))
    if unlike:
        refuse(
            path,
            f"has frame{'s' * (len(unlike) > 1)} {_numbers(unlike)} with the time of the one before, but unlike it",
            f"pass --spacing dx,dy,dt to take all frames as equally spaced, dt being {time.step:.7g}",
        )
    gone = same if asked.drop_doubled else [n for n in same if n in time.doubled]
    if gone:
        notes.append(f"frame{'s' * (len(gone) > 1)} {_numbers(gone)}, the same as the one before, left out")
    rest = [n for n in same if n not in gone]
    if rest:
        notes.append(
            f"WARNING: frame{'s' * (len(rest) > 1)} {_numbers(rest)} the same as the one before: doubled by the camera "
            "or by a conversion; --drop-doubled leaves such frames out"
        )
    kept = np.setdiff1d(np.arange(nt), gone)
    step = time.step
    if asked.drop_doubled and not time.doubled and gone:  # a conversion to a higher rate: what is left is even
        step *= nt / len(kept)
        notes.append(f"the {len(kept)} frames left were taken as equally spaced, {step:.7g} apart")
    lost = tuple((int(np.searchsorted(kept, at)), count) for at, count in time.lost)
    return eta if not gone else eta[:, :, kept], Steps(step, time.descends, lost, (), time.note)


def _refuse_lost(path: Path, time: Steps, nt: int, allowed: str) -> None:
    """Name the lost frames, and what works: the longest stretch without a loss, or filling, or taking them as even."""
    behind = [at for at, _ in time.lost]
    count = sum(n for _, n in time.lost)
    first, end = _longest([-1, *behind, nt - 1])
    doubled = f" and frames {_numbers(time.doubled)} twice" if time.doubled else ""
    refuse(
        path,
        f"has lost {count} frame{'s' * (count > 1)}, behind frame{'s' * (len(behind) > 1)} {_numbers(behind)}{doubled} "
        f"(counted from 0, by the times)",
        f"pass --frames {first}:{end}, the longest stretch without a loss"
        f"{allowed}, or --spacing dx,dy,{time.step:.7g} to take them as equally spaced all the same",
    )


def _interpolated(path: Path, eta: Any, time: Steps, asked: Asked, notes: list[str]) -> Any:
    """With the lost frames put in, each between its neighbours in a straight line."""
    nt, count = eta.shape[2], sum(n for _, n in time.lost)
    if count > asked.holes * (nt + count):
        share = np.ceil(1000 * count / (nt + count)) / 1000
        _refuse_lost(path, time, nt, f", or --fill-holes {share:g} to put in frames between their neighbours")
    place = np.arange(nt) + np.cumsum([0, *(dict(time.lost).get(n, 0) for n in range(nt - 1))])
    whole = np.empty((*eta.shape[:2], nt + count))
    whole[:, :, place] = eta
    for at, n in time.lost:
        for m in range(1, n + 1):
            part = m / (n + 1)
            whole[:, :, place[at] + m] = (1 - part) * eta[:, :, at] + part * eta[:, :, at + 1]
    notes.append(f"{count} lost frame{'s' * (count > 1)}, behind {_numbers([at for at, _ in time.lost])}, interpolated")
    return whole


def _allowed(path: Path, holes: int, size: int, asked: Asked) -> None:
    """Refuse more holes than were allowed. The share that is named in the remedy would be enough."""
    if holes > asked.holes * size:
        share = float(f"{holes / size * 1.05:.1g}") if holes / size > 1e-6 else 1e-6
        share = share if share * size >= holes else 2 * share
        refuse(
            path,
            f"has eta that holds {holes} of {size} values that are not finite (NaN)",
            f"fill the NaN first, or pass --fill-holes {share:g} to fill them with the mean",
        )


def _filled_with(mean: float, holes: int, size: int) -> str:
    """What was put into the holes, and how many there were."""
    return f"{holes} of {size} samples ({100 * holes / size:.2g} %) were missing: filled with the mean, {mean:.6g}"


def _filled(path: Path, eta: Any, asked: Asked, notes: list[str]) -> Any:
    """Samples with their NaN replaced by the mean of the others, up to the share that was asked for.

    The mean of the whole cube adds nothing to any wave; what a hole takes away from each is its own share.
    """
    with np.errstate(over="ignore", invalid="ignore"):
        if np.isfinite(eta.sum()):  # then every sample is: one pass, no mask of the whole cube
            return eta
    missing = np.isnan(eta)
    holes = int(missing.sum())
    infinite = int(np.isinf(eta).sum())
    if infinite:
        refuse(
            path,
            f"has eta that holds {infinite + holes} of {eta.size} values that are not finite",
            "remove or fill NaN and infinity first",
        )
    if not holes:
        return eta
    _allowed(path, holes, eta.size, asked)
    mean = float(eta[~missing].mean())
    notes.append(_filled_with(mean, holes, eta.size))
    return np.where(missing, mean, eta)


def _mapped_filled(path: Path, eta: Any, asked: Asked, notes: list[str]) -> Any:
    """A mapped cube whose holes are filled as it is read; they are counted in a pass of its own."""
    holes, total = 0, 0.0
    axis = int(np.argmax(np.abs(eta.strides)))
    for n in range(eta.shape[axis]):
        release(eta)
        part = np.asarray(eta[(slice(None),) * axis + (n,)], dtype=np.float64)
        missing = np.isnan(part)
        holes += int(missing.sum())
        total += float(part[~missing].sum())
    if not holes:
        return eta
    _allowed(path, holes, eta.size, asked)
    mean = total / (eta.size - holes)
    notes.append(_filled_with(mean, holes, eta.size))
    return Filled(eta, mean)


class Filled(np.memmap):  # so that whoever asks for what stays on the disk finds it
    """A memory-mapped cube whose NaN are seen as `value` wherever a part of it is taken out."""

    value: float

    def __new__(cls, eta: Any, value: float) -> Filled:
        """See the mapped array `eta` with `value` in its holes."""
        self: Filled = eta.view(cls)
        self.value = value
        return self

    def __array_finalize__(self, source: Any) -> None:
        super().__array_finalize__(source)
        self.value = getattr(source, "value", np.nan)

    def __getitem__(self, index: Any) -> Any:
        part = np.asarray(super().__getitem__(index))
        return np.where(np.isnan(part), self.value, part)

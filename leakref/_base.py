"""What every module may lean on: the array type and the one kind of refusal."""

from __future__ import annotations

import errno
from collections.abc import Iterable
from numbers import Real
from typing import Any, ClassVar

import numpy as np
import numpy.typing as npt

__all__ = [
    "LARGEST",
    "ORDINARY",
    "ComplexArray",
    "Damaged",
    "FloatArray",
    "IntArray",
    "LeakrefError",
    "Trouble",
    "deviation_of_known",
    "finite",
    "fraction",
    "installed_with",
    "integer",
    "levelled",
    "mean_of_known",
    "number",
    "positive",
    "refusal",
    "vector",
]

FloatArray = npt.NDArray[np.floating[Any]]
ComplexArray = npt.NDArray[np.complex128]
IntArray = npt.NDArray[np.int64]
LARGEST = 1e60
"""No length, duration, gravity or wavenumber in any units is larger, or smaller than its inverse."""
ORDINARY = 100
"""Samples between two to the power of this and of minus this can be summed and squared as they are."""


class LeakrefError(ValueError):
    """An input was refused. The message names the call, the fault and the remedy."""

    status: ClassVar[int] = 2  # of a command that it ends: wrong use

    def __init__(self, call: str, fault: str, remedy: str) -> None:
        super().__init__(f"{call}: {fault}; {remedy}.")
        self.call, self.fault, self.remedy = call, fault, remedy

    def __reduce__(self) -> tuple[Any, ...]:  # so that it survives the way back from a worker
        return type(self), (self.call, self.fault, self.remedy)


class Trouble(LeakrefError):
    """What is around leakref broke, not what it was given: a disk that is full, a worker that is gone."""

    status = 3


class Damaged(Trouble):
    """What leakref brings along is not as it was made: nothing can be judged by it, and no code is to blame."""


def installed_with(extra: str) -> str:
    """How leakref is installed with an extra, for messages: from where it is, since it is on no index.

    If that changes it is said here, in the README, and at the top of the files for CI, and nowhere else.
    """
    return (
        f"pip install 'leakref[{extra}] @ ADDRESS', the address being that of your checkout or wheel (file:///...) "
        "or of a repository (git+https://...)"
    )


_ASKED = {
    errno.ENOENT,
    errno.EACCES,
    errno.EPERM,
    errno.EROFS,
    errno.ENOTDIR,
    errno.EISDIR,
    errno.EEXIST,
    errno.EBUSY,
    errno.ENAMETOOLONG,
    errno.ELOOP,
    errno.EINVAL,
    errno.ENOTEMPTY,
}


def refusal(call: str, fault: str, remedy: str, error: Exception) -> LeakrefError:
    """What to raise for an OSError: a refusal if the path asked for is to blame, else (a full disk) Trouble."""
    asked = not isinstance(error, OSError) or error.errno in _ASKED
    return (LeakrefError if asked else Trouble)(call, fault, remedy)


def finite(call: str, name: str, value: npt.ArrayLike, ndim: int | None = None) -> FloatArray:
    """`value` as finite float64 of `ndim` dimensions, or a LeakrefError that says what is wrong."""
    try:
        raw = np.asarray(value)
        if raw.dtype.kind == "c":
            raise LeakrefError(call, f"{name} is complex", "pass real numbers")
        if np.ma.is_masked(value):
            raise LeakrefError(call, f"{name} has masked values", "fill them first")
        with np.errstate(over="ignore"):  # of a long double: infinite, and said below
            array = np.asarray(raw, dtype=np.float64)
    except (TypeError, ValueError) as error:
        if isinstance(error, LeakrefError):
            raise
        raise LeakrefError(call, f"{name} is not numeric ({error})", "pass real numbers") from None
    if ndim is not None and array.ndim != ndim:
        raise LeakrefError(
            call,
            f"{name} has shape {array.shape}, {array.ndim} dimensions",
            f"pass an array of {ndim} dimension{'s' * (ndim != 1)}",
        )
    # a sum is finite only if every sample is (or it overflows): one pass, no mask of the whole cube
    with np.errstate(all="ignore"):
        total = array.sum()
    if not np.isfinite(total) and not (good := np.isfinite(array)).all():
        bad = int(array.size - good.sum())
        raise LeakrefError(
            call,
            f"{name} holds {bad} of {array.size} values that are not finite",
            "remove or fill NaN and infinity first",
        )
    return array


def levelled(samples: Any) -> tuple[Any, int]:
    """Samples times 2**-e, and e: 0 unless their squares would overflow or vanish. No digit and no velocity changes."""
    largest = max(abs(float(samples.max())), abs(float(samples.min()))) if samples.size else 0.0
    exponent = int(np.frexp(largest)[1]) if np.isfinite(largest) else 0
    return (np.ldexp(samples, -exponent), exponent) if abs(exponent) > ORDINARY else (samples, 0)


def integer(call: str, name: str, value: Any, least: int = 0) -> int:
    """`value` as a whole number of at least `least`, or a LeakrefError."""
    try:
        if value == int(value) and value >= least:
            return int(value)
    except (TypeError, ValueError, OverflowError):
        pass
    raise LeakrefError(call, f"{name} = {value!r} is not a whole number of at least {least}", f"give {name} as one")


def number(call: str, **values: object) -> None:
    """Refuse any named value that is not one real number: a text such as "4", True, an array, None or NaN.

    Infinity is a number; `positive` refuses it where it must not be.
    """
    for name, value in values.items():
        if isinstance(value, bool) or not isinstance(value, Real) or value != value:
            raise LeakrefError(call, f"{name} = {value!r} is not a number", f"give {name} as one real number")


def positive(call: str, **values: float | Iterable[float]) -> None:
    """Refuse any named number (or sequence of numbers) that is not finite and above zero, or beyond all reckoning."""
    for name, value in values.items():
        numbers = finite(call, name, np.asarray(value))
        if np.any(numbers <= 0):
            raise LeakrefError(call, f"{name} = {value} is not positive", f"give {name} > 0")
        if np.any((numbers > LARGEST) | (numbers < 1 / LARGEST)):  # its powers would overflow, or vanish
            raise LeakrefError(
                call,
                f"{name} = {value} is not between {1 / LARGEST:g} and {LARGEST:g}",
                f"give {name} in units that bring it nearer to 1",
            )


def fraction(call: str, **values: object) -> None:
    """Refuse any named value that is no part of the largest power: not above zero, or above one."""
    for name, value in values.items():
        if not (isinstance(value, int | float) and 0 < value <= 1):
            raise LeakrefError(call, f"{name} = {value}", "give a part of the largest power, above 0 and at most 1")


def vector(call: str, **vectors: npt.ArrayLike) -> None:
    """Refuse what is not two finite components: one would become (U, U), another current, and a third is none."""
    for name, value in vectors.items():
        if finite(call, name, value).shape != (2,):
            raise LeakrefError(call, f"{name} = {value!r} is not a vector", "give two components (x, y)")


def mean_of_known(values: FloatArray, axis: int = 0) -> FloatArray:
    """The mean along an axis of those that are numbers; NaN where none is."""
    count = np.isfinite(values).sum(axis=axis)
    return np.where(count > 0, np.nansum(values, axis=axis) / np.maximum(count, 1), np.nan)


def deviation_of_known(values: FloatArray) -> FloatArray:
    """The standard deviation along the first axis of those that are numbers, with n - 1; NaN of fewer than two."""
    count = np.isfinite(values).sum(axis=0)
    squares = np.nansum((values - mean_of_known(values)) ** 2, axis=0)
    return np.where(count > 1, np.sqrt(squares / np.maximum(count - 1, 1)), np.nan)

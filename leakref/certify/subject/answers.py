"""What comes back from a code: rows of two numbers, or null, matched to the wavenumbers that were asked for."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
import numpy.typing as npt

from leakref._base import FloatArray
from leakref.certify.subject.declaration import Declaration
from leakref.certify.verdict import Refused, Unanswered, Verdict, printable

__all__ = ["Velocities", "accepted", "matched", "part", "refuse_bad", "rows"]


@dataclass(frozen=True, eq=False)
class Velocities:
    """An answer: `values` (n, 2) at the `wavenumbers` (n,) that were asked for, NaN where `declined` (n,).

    `wavenumbers` are in units of `k0`, `values` in units of `c0`, x and y components of where the current goes.
    """

    wavenumbers: FloatArray
    values: FloatArray
    declined: npt.NDArray[Any]


def accepted(answer: Mapping[str, Any]) -> dict[str, Any]:
    """What an answer of status ok holds of velocities and wavenumbers. Raises Refused or Unanswered (error) for
    others.
    """
    status, message = answer.get("status"), printable(answer.get("message") or "it does not say why")
    if status == "unsupported":
        raise Refused(message)
    if status != "ok":
        other = f"answered with the status {printable(status)!r}, should be ok, unsupported or error"
        raise Unanswered(Verdict.ERROR, message if status == "error" else other)
    return {name: answer[name] for name in ("velocities", "wavenumbers") if name in answer}


def part(answer: Mapping[str, Any], name: str) -> Any:
    """An output by its name. Raises Unanswered (fail) if the answer does not hold it."""
    if name not in answer:
        raise Unanswered(Verdict.FAIL, f"the answer holds {sorted(map(str, answer))}, should hold {name}")
    return answer[name]


def rows(answer: Mapping[str, Any], asked: FloatArray, d: Declaration) -> tuple[FloatArray, FloatArray | None]:
    """Velocities (m, 2) with NaN for null, and the wavenumbers they are at, None for those asked. Units as answered.
    Accepted are lists and arrays, null or a masked row for what is declined; words and truth values are refused. Raises
    Unanswered (fail) for another number of rows.
    """
    given = part(answer, "velocities")
    if np.ma.isMaskedArray(given):
        given = [None if np.ma.getmaskarray(row).any() else row.tolist() for row in given]
    elif isinstance(given, np.ndarray):
        given = list(given) if given.ndim == 2 else given
    at = _numbers(answer.get("wavenumbers"))
    if at is None and "wavenumbers" in d.untold and not d.band:
        raise Unanswered(Verdict.FAIL, "its wavenumbers are fixed, and the answer does not say which they are")
    expected = 1 if d.band else len(at) if at is not None else asked.size
    if not isinstance(given, Sequence) or len(given) != expected:
        shape = getattr(given, "shape", None) or (len(given) if isinstance(given, Sequence) else type(given).__name__)
        raise Unanswered(Verdict.FAIL, f"velocities: got {shape}, should be {expected} rows of (cx, cy)")
    found = np.empty((expected, 2))
    for n, row in enumerate(given):
        try:
            found[n] = (np.nan, np.nan) if row is None else _floats(row).reshape(2)
        except (TypeError, ValueError, OverflowError):
            raise Unanswered(Verdict.FAIL, f"velocities[{n}] is {row!r}, should be two numbers or null") from None
        if row is not None and not np.isfinite(found[n]).all():
            found[n] = np.inf  # told apart from a declined one, and refused below
    return found, at


def _floats(given: Any) -> FloatArray:
    """As float64 what consists of numbers. Words and truths, which would be taken for some, raise TypeError."""
    if any(isinstance(one, str | bytes | bool | np.bool_) for one in np.asarray(given, dtype=object).ravel()):
        raise TypeError
    return np.asarray(given, dtype=np.float64)


def _numbers(given: Any) -> FloatArray | None:
    """The wavenumbers of an answer, (m,), if it names any."""
    if given is None:
        return None
    try:
        at = _floats(given)
    except (TypeError, ValueError, OverflowError):
        at = np.empty(0)
    if at.ndim != 1 or not at.size or not np.isfinite(at).all():
        raise Unanswered(Verdict.FAIL, f"wavenumbers are {str(given)[:80]}, should be a list of numbers")
    return at


def refuse_bad(found: FloatArray) -> None:
    """Infinite stands for NaN or infinity in the answer (see `rows`), NaN for what was declined: the first is a
    failure.
    """
    if (bad := np.isinf(found).any(axis=1)).any():
        raise Unanswered(
            Verdict.FAIL,
            f"{int(bad.sum())} of {len(found)} velocities are NaN or infinite; where there "
            "is no number the answer is null (in Python None, or a masked row)",
        )


def matched(
    asked: FloatArray,
    values: FloatArray,
    at: FloatArray | None,
    steps: Sequence[float],
    shape: tuple[int, ...],
    length: float,
    d: Declaration,
) -> Velocities:
    """For each wavenumber asked for the answer within half a bin of it; for a band the one answer there is. The bin is
    the wider of those along x and y, since a code with wavenumbers of its own cannot know which are asked for.
    """
    if d.band:
        values = np.repeat(values, asked.size, axis=0)
    elif at is not None:
        dk = length * max(2 * np.pi / (n * step) for n, step in zip(shape[:2], steps, strict=False))
        nearest = np.abs(asked[:, None] - at).argmin(axis=1)
        values = np.where((np.abs(at[nearest] - asked) <= dk / 2)[:, None], values[nearest], np.nan)
    return Velocities(asked, values, np.asarray(np.isnan(values).any(axis=1)))

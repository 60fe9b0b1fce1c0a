"""Timings of pytest-benchmark over versions, as ratios to a reference workload of the same run.

Seconds of two versions measured on different days or machines cannot be compared; ratios to the same workload in the
same run can, roughly. They are kept in the entries of the history if `leakref track record --timings` is given a file,
and a slower one is reported but fails nothing.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np
from scipy.stats import norm

from leakref._base import LeakrefError, positive
from leakref.track.changes import ALPHA, verdict

__all__ = ["SLOWER", "compare_timings", "timings"]

SLOWER = 0.25
"""A change of a ratio within this is none: clocks of busy machines drift more than any interval knows."""


def timings(benchmarks: Mapping[str, Any], yardstick: str) -> dict[str, Any]:
    """From the JSON of pytest-benchmark: medians as ratios to that of the `yardstick`, a benchmark of the same run.

    Benchmarks are known by their full names; of the yardstick the part after `::` is enough. `error` is the standard
    error of the logarithm of a ratio, from quartiles and rounds; NaN with one round. Raises LeakrefError.

    LeakrefError is raised for JSON of another kind, a yardstick that is none or several of the benchmarks, and medians
    that are not positive. Returned are `yardstick`, its `seconds`, and under `ratios` by full name `ratio` and `error`.
    """
    try:
        stats = {str(one["fullname"]): one["stats"] for one in benchmarks["benchmarks"]}
        medians = {name: float(own["median"]) for name, own in stats.items()}
        errors = {name: _error(own) for name, own in stats.items()}
    except (KeyError, TypeError, ValueError, ArithmeticError) as error:
        raise LeakrefError(
            "timings",
            f"this is no JSON of pytest-benchmark ({type(error).__name__}: {error})",
            "write one with `pytest --benchmark-only --benchmark-json FILE`",
        ) from None
    found = [name for name in medians if yardstick in (name, name.rpartition("::")[2])]
    if len(found) != 1:
        raise LeakrefError(
            "timings",
            f"{len(found)} benchmarks are called {yardstick!r}",
            f"choose the yardstick among {', '.join(medians) or 'none'}",
        )
    positive("timings", **medians)
    unit, off = medians[found[0]], errors[found[0]]
    return {
        "yardstick": found[0],
        "seconds": unit,
        "ratios": {
            name: {"ratio": median / unit, "error": float(np.hypot(errors[name], off))}
            for name, median in medians.items()
            if name != found[0]
        },
    }


def _error(stats: Mapping[str, Any]) -> float:
    """Relative standard error of a median, as of a normal distribution with these quartiles. The standard error of a
    median is 1.2533 times that of a mean; 1.349 deviations lie between the quartiles.
    """
    rounds = int(stats["rounds"])
    return 1.2533 * float(stats["iqr"]) / 1.349 / float(stats["median"]) / np.sqrt(rounds) if rounds > 1 else np.nan


def compare_timings(before: Mapping[str, Any] | None, after: Mapping[str, Any] | None) -> list[dict[str, Any]]:
    """Change of each ratio, 0.1 for 10 % longer, with its interval; only with a common yardstick.

    Whether something is slower is said, and fails nothing.

    `before` and `after` are what `timings` gives, None if there is none. Each row has `name`, the two ratios, `change`,
    `interval` and `verdict`: slower, faster, equal or undecided. All intervals together hold with confidence 1 -
    `ALPHA`.
    """
    if not before or not after or before["yardstick"] != after["yardstick"]:
        return []
    names = [name for name in before["ratios"] if name in after["ratios"]]
    rows = []
    for name in names:
        a, b = before["ratios"][name], after["ratios"][name]
        change = float(np.log(b["ratio"] / a["ratio"]))
        known = a["error"] is not None and b["error"] is not None
        reach = float(norm.isf(ALPHA / 2 / len(names)) * np.hypot(a["error"], b["error"])) if known else np.inf
        low, high = float(np.expm1(change - reach)), float(np.expm1(change + reach))
        words = {"worse": "slower", "better": "faster"}
        said = verdict(low, high, SLOWER)
        rows.append(
            {
                "name": name,
                "before": a["ratio"],
                "after": b["ratio"],
                "change": float(np.expm1(change)),
                "interval": [low, high],
                "verdict": words.get(said, said),
            }
        )
    return rows

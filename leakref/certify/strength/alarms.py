"""How often the statistical checks reject a code that is no worse than they allow.

Only the checks of bias are statistical; all others compare with a tolerance that is derived. Their rate of false alarms
is not taken from the formula of the test but counted: velocities of the reference in a hundred realisations of each sea
are computed once, and the test is applied to many draws from them. Used by `study` in its full form.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np
from scipy.stats import binomtest
from scipy.stats import t as student

from leakref import fast
from leakref.certify.checks import inputs
from leakref.certify.checks.registry import CHECKS
from leakref.certify.checks.statistics import FALSE_ALARMS, share
from leakref.certify.runner import select
from leakref.currents import UniformCurrent

__all__ = ["errors_of", "false_alarms", "rate_of", "seas"]

RESAMPLINGS = 100_000
_STORED = 100  # realisations of each sea of the statistical checks


def seas() -> dict[str, Mapping[str, Any]]:
    """The seas of the statistical check by name, without the number of realisations.

    Keys are the names of the cases of `leakage.bias` without their counts, values the arguments that make the sea.
    """
    select()  # loads the checks
    return {case.id.rpartition("-")[0]: case.given for case in CHECKS["leakage.bias"].cases}


def errors_of(name: str) -> dict[str, Any]:
    """Of stored realisations of a sea: mean |c - U| over the unflagged shells by method, and the smaller resolution.

    Lists of numbers in `c0`, one for each realisation, under `nsp` and `ls`, all with Hann; a realisation in which
    every shell has a note is left out. `resolution` is the mean over the wavenumbers of the smaller one (eq:dcdwk).
    """
    given = seas()[name]
    current = UniformCurrent(inputs.polar(given["speed"], given["direction"] + 70))
    errors: dict[str, list[float]] = {"nsp": [], "ls": []}
    for number in range(_STORED):
        cube = inputs.sea(given["direction"], given["spread"], current, realization=10_000 + number)
        answers = fast.realize(
            cube.components, cube.grid, cube.wavenumbers, windows=("hann",), methods=tuple(errors), gravity=1.0
        )
        for method, found in errors.items():
            answer = answers["hann", method]
            clear = np.array([not note for note in answer.notes])
            if clear.any():
                found.append(float(np.hypot(*(answer.velocities - cube.truth)[clear].T).mean()))
    return {**errors, "resolution": float(cube.resolutions[0].mean())}


def false_alarms(errors: Mapping[str, Mapping[str, Any]], resamplings: int = RESAMPLINGS) -> dict[str, Any]:
    """How often a whole run of the statistical checks rejects a code that is no worse than the margin allows.

    Under the null hypothesis the code's errors are those of the reference in other realisations than the reference is
    given, plus the whole margin: no code that is allowed is rejected more often. A second count leaves the margin out.

    `errors` are those of `errors_of` by sea. Each resampling draws `count` pairs of different realisations and applies
    the one-sided test of the check to their differences; a run is an alarm if any of its tests rejects. Returned are
    the number of resamplings and tests, the nominal rate, and for both counts alarms, rate and interval.
    """
    from leakref.certify.checks.leakage import MARGIN

    rng = np.random.default_rng(0)
    alarmed = {"at_margin": np.zeros(resamplings, dtype=bool), "as_good": np.zeros(resamplings, dtype=bool)}
    tests = [(case.id.rpartition("-")[0], case.given["count"]) for case in CHECKS["leakage.bias"].cases]
    methods = ("nsp", "ls")
    for name, count in tests:
        margin = MARGIN * errors[name]["resolution"]
        for method in methods:
            stored = np.array(errors[name][method])
            i = rng.integers(0, stored.size, (resamplings, count))
            j = (i + rng.integers(1, stored.size, i.shape)) % stored.size
            d = stored[i] - stored[j]
            above = student.isf(share(len(methods)), count - 1) * d.std(axis=1, ddof=1) / np.sqrt(count)
            alarmed["at_margin"] |= d.mean(axis=1) > above
            alarmed["as_good"] |= d.mean(axis=1) > margin + above
    return {
        "resamplings": resamplings,
        "tests": len(tests) * len(methods),
        "nominal": FALSE_ALARMS,
        **{name: rate_of(int(which.sum()), resamplings) for name, which in alarmed.items()},
    }


def rate_of(alarms: int, resamplings: int) -> dict[str, Any]:
    """With its Clopper-Pearson interval at 95 %. That interval is exact for a binomial, and wide enough where there are
    few alarms or none.
    """
    interval = binomtest(alarms, resamplings).proportion_ci(method="exact")
    return {"alarms": alarms, "rate": alarms / resamplings, "interval": [float(interval.low), float(interval.high)]}

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
from leakref.certify.checks import inputs, seameasures
from leakref.certify.checks.draw import PUBLISHED
from leakref.certify.checks.registry import CHECKS
from leakref.certify.checks.sea import CASES, asked_of
from leakref.certify.checks.statistics import FALSE_ALARMS, share
from leakref.certify.runner import select
from leakref.certify.subject.inprocess import InProcess
from leakref.certify.subject.seas import Sea
from leakref.currents import UniformCurrent
from leakref.generator import generator

__all__ = ["errors_of", "false_alarms", "rate_of", "sea_alarms", "seas", "seas_of"]

RESAMPLINGS = 100_000
SEA_RESAMPLINGS = 10_000
_SEAS = 256  # realisations of each random sea
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


def seas_of(name: str) -> dict[str, Any]:
    """Of stored realisations of a random sea of the family `sea`: the scalars that are measured, each a list, and the
    `bins`, real and imaginary parts; the sea is the one whose measures scatter most.
    """
    found = seameasures.realizations(_random_sea(name), range(10_000, 10_000 + _SEAS))
    bins = [found.bins.real.tolist(), found.bins.imag.tolist()]
    return {"scalars": {key: values.tolist() for key, values in found.scalars.items()}, "bins": bins}


def _random_sea(name: str) -> Sea:
    subject = InProcess(generator)
    with inputs.asked(subject, PUBLISHED):
        return asked_of(subject, next(case for case in CASES if case.id == name))


def sea_alarms(stored: Mapping[str, Mapping[str, Any]], resamplings: int = SEA_RESAMPLINGS) -> dict[str, Any]:
    """How often the statements about means and phases of random seas reject a right generator: counted, in draws of
    `seameasures.COUNT` realisations of each sea from those `stored` (`seas_of`), as the checks see them.
    """
    rng, alarmed = np.random.default_rng(0), np.zeros(resamplings, dtype=bool)
    for name, one in stored.items():
        other = seameasures.own(_random_sea(name))
        scalars, bins = one["scalars"], np.array(one["bins"][0]) + 1j * np.array(one["bins"][1])
        whole = {key: np.array(values) for key, values in scalars.items()}
        for n in range(resamplings):
            some = rng.choice(_SEAS, seameasures.COUNT, replace=False)
            found = seameasures.Measured(
                {key: values[some] for key, values in whole.items()}, bins[some], np.empty((0, 0))
            )
            over = [seameasures.apart(found, other, key) for key in whole]
            alarmed[n] |= max(*over, seameasures.added(found.bins)[0]) > 1
    return {"resamplings": resamplings, "nominal": FALSE_ALARMS, **rate_of(int(alarmed.sum()), resamplings)}


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

"""How often `leakref track compare` raises a false alarm, and whether it sees what it should.

Both are measured on stored realisations.

**Null comparisons.** Unpaired: the hundred realisations of each configuration of the paper, split at random into two
halves that share none. Paired: each sea in still water against its mirror image about the y axis, realisation by
realisation, which of the two is called the earlier being drawn by lot each time; by symmetry their errors are equally
distributed, but the two are different seas, so the differences are no zeros. Each comparison is a whole run over all
wavenumbers, bands, windows and methods of a configuration. An *alarm* is a run that says worse anywhere: declared is
a share of ALPHA / 2. A *miss* is one in which any interval does not hold the true change, which is zero: ALPHA.
Splits of one configuration are not independent of each other, so the interval of the share is that of the binomial
for as many runs as there are, and the number of configurations with an alarm stands beside it.

**Planted rises.** In one band of one series of the two cases that are recorded by default the mean error is raised by
5 % of the resolution: evenly, or by a random velocity added to every one measured, which is the harder to see.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import Executor
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np
from rich.console import Console
from scipy.optimize import brentq
from scipy.stats import binomtest

from leakref import runs
from leakref._base import FloatArray
from leakref._output import dump, envelope, folder, progress_bar
from leakref.cases import PAPER_CASES, Configuration, configurations
from leakref.claims.stored import write
from leakref.ensemble import Ensemble
from leakref.track.changes import ALPHA, BANDS, Comparison, compare, in_band
from leakref.track.tracking import PAPER, Series

__all__ = ["RISE", "run"]

RISE = 0.05
"""Of the smaller resolution: what must be seen with a hundred realisations."""
_SPLITS, _LOTS, _TRIALS = 20, 50, 20
_REALIZATIONS = 100
_CONFIDENCE = 0.95
Progress = Callable[[], object]


@dataclass(frozen=True)
class _Tally:
    """Runs of one kind: how many, of them with an alarm, with a miss, and the configurations with an alarm."""

    runs: int
    alarms: int
    misses: int
    configurations: int
    alarmed: int

    def record(self) -> dict[str, Any]:
        return {
            "comparisons": self.runs,
            "alarms": self.alarms,
            "share": self.alarms / self.runs,
            "interval": _interval(self.alarms, self.runs),
            "misses": self.misses,
            "share_of_misses": self.misses / self.runs,
            "interval_of_misses": _interval(self.misses, self.runs),
            "configurations": self.configurations,
            "configurations_with_an_alarm": self.alarmed,
        }


def _interval(count: int, of: int) -> list[float]:
    """Of Clopper and Pearson."""
    return list(binomtest(count, of).proportion_ci(_CONFIDENCE, "exact"))


def _series(ensembles: Sequence[Ensemble]) -> list[Series]:
    """Errors of ensembles as series without a digest, to be compared with each other only."""
    return [
        Series(
            e.configuration.case,
            "",
            e.window,
            e.method,
            e.wavenumbers,
            np.minimum(*e.resolutions),
            0,
            np.hypot(*np.moveaxis(e.velocities - e.configuration.current, -1, 0)),
        )
        for e in ensembles
    ]


def _halves(series: Sequence[Series], rng: np.random.Generator) -> Comparison:
    """Two halves of the realisations that have none in common."""
    order = rng.permutation(len(series[0].errors))
    half = order.size // 2
    before = [replace(one, errors=one.errors[order[:half]]) for one in series]
    after = [replace(one, errors=one.errors[order[half:]], first=order.size) for one in series]
    return compare(before, after)


def _by_lot(series: Sequence[Series], images: Sequence[Series], rng: np.random.Generator) -> Comparison:
    """Realisation by realisation one of the two seas as the earlier, the other as the later."""
    turned = rng.random((len(series[0].errors), 1)) < 0.5
    before = [replace(a, errors=np.where(turned, b.errors, a.errors)) for a, b in zip(series, images, strict=True)]
    after = [replace(a, errors=np.where(turned, a.errors, b.errors)) for a, b in zip(series, images, strict=True)]
    return compare(before, after)


def _tally(comparisons: Sequence[Sequence[Comparison]]) -> _Tally:
    """Of several comparisons of each configuration. `comparisons` has a list for each configuration."""
    alarms = [sum(bool(one.worse) for one in own) for own in comparisons]
    misses = [
        sum(any(c.interval[0] > 0 or c.interval[1] < 0 for c in one.changes) for one in own) for own in comparisons
    ]
    return _Tally(sum(map(len, comparisons)), sum(alarms), sum(misses), len(comparisons), sum(map(bool, alarms)))


def _mirrored(configuration: Configuration) -> Configuration:
    """The sea about the y axis; its phases are those of the same lattice points, so it is another sea."""
    return replace(configuration, case=f"mirrored-{configuration.case}", direction=180.0 - configuration.direction)


def _null(place: Path, executor: Executor | None, step: Progress) -> dict[str, Any]:
    """The tallies of both kinds of null comparison, and of all together."""
    everything = [c for members in PAPER_CASES.values() for c in members]
    turned = [c for c in everything if c.direction != 90.0 and not c.speed]
    rng = np.random.default_rng(20231101265)

    def ensembles(chosen: Sequence[Configuration]) -> Iterator[list[Series]]:
        for found in runs.run(chosen, realizations=_REALIZATIONS, folder=place, executor=executor, after_each=step):
            yield _series(found)

    seas = dict(zip((c.id for c in everything), ensembles(everything), strict=True))
    images = dict(zip((c.id for c in turned), ensembles([_mirrored(c) for c in turned]), strict=True))
    unpaired = _tally([[_halves(series, rng) for _ in range(_SPLITS)] for series in seas.values()])
    paired = _tally([[_by_lot(seas[name], series, rng) for _ in range(_LOTS)] for name, series in images.items()])
    both = _Tally(*(sum(pair) for pair in zip(vars(unpaired).values(), vars(paired).values(), strict=True)))
    return {"unpaired": unpaired.record(), "paired": paired.record(), "all": both.record()}


def _planted(place: Path, executor: Executor | None) -> Iterator[dict[str, Any]]:
    """For each series, band and kind of rise: in how many trials it was called worse."""
    found = [
        e
        for group in runs.run(configurations(PAPER), realizations=_REALIZATIONS, folder=place, executor=executor)
        for e in group
    ]
    before = [replace(one, case=e.configuration.id) for one, e in zip(_series(found), found, strict=True)]
    rng = np.random.default_rng(5)
    for n, (one, e) in enumerate(zip(before, found, strict=True)):
        for low, high in BANDS:
            inside = in_band(one.wavenumbers, low, high)
            for kind, raised, trials in (("even", _evenly, 1), ("scattered", _scattered, _TRIALS)):
                seen = 0
                for _ in range(trials):
                    errors = one.errors.copy()
                    errors[:, inside] = raised(e, inside, rng)
                    after = [*before[:n], replace(one, errors=errors), *before[n + 1 :]]
                    seen += any(c.band == f"{low:g} to {high:g}" for c in compare(before, after).worse)
                yield {
                    "case": one.case,
                    "window": one.window,
                    "method": one.method,
                    "band": f"{low:g} to {high:g}",
                    "rise": kind,
                    "trials": trials,
                    "seen": seen,
                }


def _evenly(e: Ensemble, inside: Any, rng: np.random.Generator) -> FloatArray:
    """Every error (R, m) longer by RISE of the resolution."""
    off = e.velocities[:, inside] - e.configuration.current
    return np.hypot(off[..., 0], off[..., 1]) + RISE * np.minimum(*e.resolutions)[inside]


def _scattered(e: Ensemble, inside: Any, rng: np.random.Generator) -> FloatArray:
    """Errors (R, m) with a normal velocity added to each, so large that their mean rises by RISE."""
    off = e.velocities[:, inside] - e.configuration.current
    unit = np.minimum(*e.resolutions)[inside]
    noise = rng.standard_normal(off.shape) * unit[:, None]

    def errors(size: float) -> FloatArray:
        return np.hypot(*np.moveaxis(off + size * noise, -1, 0))

    level = float(np.nanmean(errors(0.0)) + RISE * unit.mean())
    return errors(brentq(lambda size: float(np.nanmean(errors(size))) - level, 0.0, 10.0))


def run(out: Path | None, *, place: Path, workers: int, json: bool) -> bool:
    """Measure, print and write; whether alarms are as rare as declared and every even rise is seen.

    Realisations are kept in `place`, shared with `leakref reproduce --out`.

    With `out` the record is written there as JSON, a planted rise a line. `workers` are processes.
    """
    total = _REALIZATIONS * sum(
        len(members) + sum(c.direction != 90.0 for c in members) for members in PAPER_CASES.values()
    )
    with progress_bar("realisations", total) as step, runs.pool(workers) as executor:
        null = _null(folder(place) / "parts", executor, step)
        planted = list(_planted(place / "parts", executor))
    declared = {"alarms": ALPHA / 2, "misses": ALPHA}
    rare = null["all"]["share"] <= declared["alarms"] and null["all"]["share_of_misses"] <= declared["misses"]
    ok = rare and all(row["seen"] == row["trials"] for row in planted if row["rise"] == "even")
    result = envelope(
        "track", ok, action="null", declared=declared, realizations=_REALIZATIONS, **null, rise=RISE, planted=planted
    )
    if out:
        write(out, result, ("planted",))
    if json:
        print(dump(result))
        return ok
    show = Console()
    for name in ("unpaired", "paired", "all"):
        row = null[name]
        said = [
            f"{row[count]} {count} ({100 * row[share]:.2g} %, {100 * row[where][0]:.2g} to "
            f"{100 * row[where][1]:.2g}, declared {100 * declared[count]:g} %)"
            for count, share, where in (
                ("alarms", "share", "interval"),
                ("misses", "share_of_misses", "interval_of_misses"),
            )
        ]
        show.print(f"{name}: {row['comparisons']} null comparisons, {' and '.join(said)}", soft_wrap=True)
    for kind in ("even", "scattered"):
        rows = [row for row in planted if row["rise"] == kind]
        seen, trials = (sum(row[what] for row in rows) for what in ("seen", "trials"))
        show.print(f"{kind} rises of {100 * RISE:g} % of the resolution in one band: {seen} of {trials} seen")
    return ok

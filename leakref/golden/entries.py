"""The records of a golden set: what an entry holds, and how each is computed by its routes.

Vectors are made by `records.vector_record`. A realisation is computed by route A (surface and FFT) and by route B
(closed form), and both must agree within the conditioning. An ensemble of a hundred realisations is computed by B
alone, since A takes many times as long, and inherits the digits on which both routes agreed in its certified
realisations. `making` writes what is made here, `verifying` compares it.
"""

from __future__ import annotations

import json
from collections.abc import Callable, Iterator, Mapping, Sequence
from functools import cache, partial
from pathlib import Path
from typing import Any

import numpy as np
from threadpoolctl import threadpool_limits

from leakref import ensemble, kept, runs, sources
from leakref._base import FloatArray, LeakrefError
from leakref._output import plain as to_json
from leakref.cases import REALIZATIONS, Configuration
from leakref.chain import analyse
from leakref.dispersion import DEEP, velocity_unit
from leakref.ensemble import Ensemble
from leakref.golden.defined import VECTORS
from leakref.golden.ids import CERTIFIED, configuration_of, ensemble_id, methods_of, realization_id
from leakref.golden.records import entry_record, head_of, vector_record
from leakref.golden.sets import Entry, tolerance
from leakref.golden.stages.velocities import UNFLAGGED, softness, velocity_conditioning
from leakref.shell import Extraction, Note
from leakref.spectrum import Spectrum, fourier
from leakref.synthesis import synthesize

__all__ = ["certified", "closed_form", "describe", "inherit", "make", "statistics_of"]

Step = Callable[[], object]


def describe(c: Configuration) -> dict[str, Any]:
    """A configuration in words of JSON: enough to make it without this package's table of cases.

    Angles are in degrees, `length` and `duration` in peak wavelengths and periods, all else in scaled units. Of deep
    water without tension nothing is said.
    """
    water = {} if c.water == DEEP else {"depth": c.depth, "surface_tension": c.surface_tension}
    return {
        "configuration": c.id,
        "direction": c.direction,
        "spread": c.spread,
        "peakedness": c.peakedness,
        "length": c.length,
        "duration": c.duration,
        "speed": c.speed,
        "current_direction": c.current_direction,
        "rotation": c.rotation,
        **water,
        "shape": list(c.grid.shape),
        "spacing": list(c.grid.spacing),
        "windows": list(c.windows),
        "wavenumbers": c.wavenumbers.tolist(),
    }


def _one_by_one(c: Configuration, number: int) -> Iterator[Spectrum]:
    """Route A, one window at a time and no more than the surface and one spectrum in memory.

    The spectrum is cropped to the bins that shells need before the next window is begun: the largest domain has 351
    million samples.
    """
    waves, grid = c.components(number), c.grid
    eta = synthesize(waves, *(grid.samples(axis) for axis in range(3)))
    reach = float(c.wavenumbers[-1]) + 3 * grid.wavenumber_resolution
    near = [np.flatnonzero(np.abs(grid.bins(axis)) * grid.bin_widths[axis] <= reach) for axis in (0, 1)]
    for name in c.windows:
        whole = fourier(eta, grid, name, workers=1)
        cropped = Spectrum(grid, name, whole.i[near[0]], whole.j[near[1]], whole.values[np.ix_(*near)])
        del whole
        yield cropped


def _by_surface(c: Configuration, number: int, methods: Sequence[str]) -> tuple[dict[str, Any], dict[str, Any]]:
    """Velocities and notes by route A, and the conditioning of each velocity.

    Velocities (n, 2) and notes by `window_method`, under `notes` and by name, and the conditioning of each velocity, n
    numbers. `turns` counts the radians of phase that a wave goes through over the cube, which round one by one.
    """
    found: dict[str, Any] = {}
    conditioning: dict[str, Any] = {}
    turns = float(4 + np.log2(np.prod(c.grid.shape)) + 2 * np.pi * (3.5 * c.length * 2 + 1.9 * c.duration))
    notes: dict[str, Any] = {}
    for spectrum in _one_by_one(c, number):
        for method in methods:
            one = analyse(spectrum, c.wavenumbers, method=method, water=c.water)
            name = f"{spectrum.window}_{method}"
            found[name], notes[name] = one.velocities, _names(one)
            conditioning[name] = velocity_conditioning(spectrum, one, turns, c.water)
    return {**found, "notes": notes}, conditioning


def _names(found: Extraction) -> list[list[str]]:
    """The notes of each shell by name, as they are kept."""
    return [note.names for note in found.notes]


def closed_form(c: Configuration, number: int, methods: Sequence[str]) -> dict[str, Any]:
    """Velocities and notes by route B.

    Velocities (n, 2) by `window_method`, and under `notes` the names of the notes of each shell.
    """
    by_name = ensemble.realize(c, number, methods=methods, route="B")
    found = {f"{window}_{method}": one for (window, method), one in by_name.items()}
    return {
        **{name: one.velocities for name, one in found.items()},
        "notes": {name: _names(one) for name, one in found.items()},
    }


_DSV_DECISIONS = tuple(f"D{n}" for n in (1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 13, 15, 16, 17, 18, 19, 22))


def _decisions(c: Configuration) -> tuple[str, ...]:
    """Those that velocities depend on; in water that is not deep also those of its units, sea and search."""
    return _DSV_DECISIONS if c.water == DEEP else (*_DSV_DECISIONS, "D26", "D27", "D28", "D29", "D31")


def _realization(identifier: str) -> dict[str, Any]:
    """The record of one realisation by routes A and B.

    Where the routes do not agree within the conditioning there is no certified number: null, with that reason. It
    happens only in noted shells, where a rounding may decide which basin the search ends in; elsewhere it is refused.
    """
    c, number, methods = configuration_of(identifier), int(identifier.rsplit("/", 1)[1]), methods_of(identifier)
    a, conditioning = _by_surface(c, number, methods)
    b = closed_form(c, number, methods)
    reasons: dict[str, list[str]] = {}
    for name, kappa in conditioning.items():
        allowed = np.array([tolerance(x) for x in kappa])
        apart = ~(np.abs(a[name] - b[name]).max(axis=1) <= allowed) & np.isfinite(a[name]).all(axis=1)
        for n in np.flatnonzero(apart):
            if not a["notes"][name][n] and not b["notes"][name][n]:
                raise LeakrefError(
                    "golden.regenerate",
                    f"{identifier}: routes A and B give "
                    f"{a[name][n]} and {b[name][n]} in {name}, shell {n}, which has no note, where "
                    f"{allowed[n]:.2g} is allowed",
                    "find out why; nothing was written",
                )
        for one in (a, b):
            one[name] = np.where(apart[:, None], np.nan, one[name])
        conditioning[name] = [float("nan") if gone else x for x, gone in zip(kappa, apart, strict=True)]
        reasons[name] = [
            ("routes A and B differ; " if gone else "") + ", ".join(a["notes"][name][n])
            if gone or not np.isfinite(a[name][n]).all()
            else ""
            for n, gone in enumerate(apart)
        ]
    notes = a.pop("notes")
    b.pop("notes")
    head = head_of(
        identifier,
        "realization",
        "hard",
        "a whole sea through the whole chain, shell by shell: any slip that the small vectors miss",
        "sec:NSP",
        _DSV_FAULTS,
        _decisions(c),
    )
    given = {name: said for name, said in reasons.items() if any(said)}
    extra = {"notes": notes, **({"reasons": given} if given else {})}
    return entry_record(head, {**describe(c), "realization": number}, {"A": a, "B": b}, "A", conditioning, extra)


_DSV_FAULTS = (
    "negated-current",
    "flipped-x",
    "flipped-y",
    "exchanged-axes",
    "solve-sign-slip",
    "hard-coded-width",
    "extra-branch",
    "no-taper",
)
_STATISTICS = ("bias", "random", "mean", "standard_error", "count")


def statistics_of(e: Ensemble) -> dict[str, FloatArray]:
    """The statistics of an ensemble that a golden entry keeps, as arrays by name.

    They are `bias`, `random`, `standard_error` and `count`, (n,) each, and `mean`, (n, 2); in `c0`.
    """
    return {name: np.asarray(getattr(e, name), dtype=np.float64) for name in _STATISTICS}


def _ensembles(
    c: Configuration, found: Sequence[Ensemble], worse: Sequence[Mapping[tuple[str, str], list[float]]]
) -> list[dict[str, Any]]:
    """Records of the ensembles of a configuration: route B, confirmed by the realisations done by A as well.

    `worse`, one for each realisation, is what `_softnesses` says of its velocities. A mean is conditioned as the mean
    of its velocities' conditioning; a standard deviation as twice their root mean square; a standard error as that over
    the square root of the count; counts are exact.
    """
    records = []
    for e in found:
        name = (e.window, e.method)
        per_velocity = UNFLAGGED / tolerance(1.0) * np.array([one[name] for one in worse])  # (R, n)
        there = np.isfinite(e.magnitudes)
        mean = np.where(there, per_velocity, 0).sum(axis=0) / np.maximum(e.count, 1)
        spread = 2 * np.sqrt(np.where(there, per_velocity**2, 0).sum(axis=0) / np.maximum(e.count - 1, 1))
        conditioning = {
            "bias": mean.tolist(),
            "mean": mean.tolist(),
            "random": spread.tolist(),
            "count": 0.0,
            "standard_error": (spread / np.sqrt(np.maximum(e.count, 1))).tolist(),
        }
        head = head_of(
            ensemble_id(c, *name),
            "ensemble",
            "hard",
            "bias and random part over many seas: a slip too small or too rare for one sea",
            "sec:parameters",
            _DSV_FAULTS,
            (*_decisions(c), "D12"),
        )
        frequency, wavenumber = e.resolutions
        extra = {
            "resolution_frequency": frequency.tolist(),
            "resolution_wavenumber": wavenumber.tolist(),
            "flagged": {n: e.noted(note).tolist() for note in Note for n in note.names if e.noted(note).any()},
        }
        given = {**describe(c), "window": e.window, "method": e.method, "realizations": len(e.velocities)}
        records.append(entry_record(head, given, {"B": statistics_of(e)}, "B", conditioning, extra))
    return records


def inherit(record: dict[str, Any], certified: Mapping[str, Entry]) -> None:
    """Give an ensemble, which is by route B alone, the digits that both routes share in its certified realisations.
    `record` is changed in place; counts, which are whole numbers, keep theirs. Raises LeakrefError where a certified
    realisation of its configuration is missing.
    """
    method = record["input"]["method"]
    c, name = configuration_of(record["id"]), f"{record['input']['window']}_{method}"
    ids = [realization_id(c, number, method) for number in CERTIFIED]
    if missing := [i for i in ids if i not in certified]:
        raise LeakrefError(
            "golden.regenerate",
            f"{record['id']} has its digits from {missing[0]}, which is not there",
            f"make that first: leakref golden regenerate '{missing[0]}'",
        )
    digits = min(certified[i].record["accuracy"][name]["digits"] for i in ids)
    for statistic, said in record["accuracy"].items():
        if statistic != "count":  # a whole number
            said["digits"] = min(said["digits"], digits)


def _softnesses(c: Configuration, methods: Sequence[str], number: int) -> dict[tuple[str, str], list[float]]:
    """By how much each velocity of a realisation is worse conditioned than `UNFLAGGED`; 1 where there is none. In
    water that is not deep it is in that water's unit of velocity (decision D29).
    """
    unit = velocity_unit(1.0, c.water, None)
    with threadpool_limits(limits=1):
        found = ensemble.realize(c, number, methods=methods, route="B")
    return {
        (window, method): [
            unit * (softness(method, float(score), hessian, unit) if np.isfinite(score) else 1.0)
            for score, hessian in zip(one.score, one.hessian, strict=True)
        ]
        for (window, method), one in found.items()
    }


def make(
    wanted: Sequence[str], old: Mapping[str, Entry], work: Path | None, workers: int, step: Step
) -> Iterator[dict[str, Any]]:
    """The records of the `wanted` ids, from the inputs of `old` ones.

    Slow ones that were done before, by the same source, are found in `work`.

    Order is vectors, realisations, ensembles, whatever the order of `wanted`. `step` is called after each. Raises
    LeakrefError where the routes disagree in a shell that has no note; then nothing of that entry is made.
    """
    vectors = {v.id: v for members in VECTORS.values() for v in members}
    for identifier in (i for i in wanted if i in vectors):
        yield vector_record(vectors[identifier], old.get(identifier))
        step()
    for record in certified([i for i in wanted if i.startswith("realization-")], work, workers):
        yield record
        step()
    rest = [i for i in wanted if i.startswith("ensemble-")]
    kept_in = work and work / "runs"
    for methods in dict.fromkeys(methods_of(i) for i in rest):
        configurations = list(dict.fromkeys(configuration_of(i) for i in rest if methods_of(i) == methods))
        with runs.pool(workers) as executor:
            for found in runs.run(
                configurations, realizations=REALIZATIONS, methods=methods, folder=kept_in, executor=executor
            ):
                c = found[0].configuration
                each = partial(_softnesses, c, methods)
                soft = (map if executor is None else executor.map)(each, range(REALIZATIONS))
                for record in _ensembles(c, found, list(soft)):
                    if record["id"] in rest:
                        yield record
                        step()


def certified(wanted: Sequence[str], work: Path | None, workers: int) -> Iterator[dict[str, Any]]:
    """The records of realisations, in order; several at a time with several `workers`, each with up to 9 GB.

    Their ids end with the number of the realisation. What an earlier run of the same source left in `work` is taken.
    """
    one = partial(_certify, work=work)
    with runs.pool(min(workers, max(1, len(wanted)))) as executor:
        yield from (map(one, wanted) if executor is None else executor.map(one, wanted))


def _certify(identifier: str, work: Path | None) -> dict[str, Any]:
    """One realisation on one thread, so that the last bits do not depend on the machine's cores."""
    with threadpool_limits(limits=1):
        return _resumed(identifier, work, partial(_realization, identifier))


def _resumed(identifier: str, work: Path | None, make: Callable[[], dict[str, Any]]) -> dict[str, Any]:
    """A record from `work`, if an earlier run of the same source left it there, else made and left there. Kept under
    the digest of the sources, so that a change of anything that counts makes it anew.
    """
    if work is None:
        return make()
    about = {"id": identifier, "source": _source_digest()}
    path = work / "entries" / f"{kept.key(about)}.json"
    found = kept.record(path, about)
    if found is None:
        found = json.loads(json.dumps(to_json(make())))
        kept.keep_record(path, about, found)
    return dict(found)


@cache
def _source_digest() -> str:
    return sources.digest(__name__)

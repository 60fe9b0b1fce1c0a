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

from leakref import ensemble, kept, runs, sources
from leakref._base import FloatArray, LeakrefError
from leakref._output import plain as to_json
from leakref.cases import REALIZATIONS, Configuration
from leakref.chain import analyse
from leakref.dispersion import DEEP, velocity_unit
from leakref.ensemble import Ensemble
from leakref.golden.defined import VECTORS
from leakref.golden.ids import certified_ids, configuration_of, ensemble_id, methods_of, together
from leakref.golden.methodvectors import decisions_of
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


def _decisions(c: Configuration, methods: Sequence[str]) -> tuple[str, ...]:
    """Those that velocities depend on, of the methods beside the paper's; in water that is not deep also those of its
    units, sea and search.
    """
    own = (decision for name in methods for decision in decisions_of(name))
    return (*_DSV_DECISIONS, *(() if c.water == DEEP else ("D26", "D27", "D28", "D29", "D31")), *own)


def _realizations(identifiers: Sequence[str]) -> list[dict[str, Any]]:
    """The records of one realisation by routes A and B, one for each of the ids that share its sea."""
    c, number = configuration_of(identifiers[0]), int(identifiers[0].rsplit("/", 1)[1])
    methods = together(identifiers)[c]
    (a, conditioning), b = _by_surface(c, number, methods), closed_form(c, number, methods)

    def part(of: Mapping[str, Any], own: Sequence[str]) -> dict[str, Any]:
        return {name: value for name, value in of.items() if name.partition("_")[2] in own}

    records = []
    for identifier in identifiers:
        own = methods_of(identifier)
        first, second = ({**part(one, own), "notes": part(one["notes"], own)} for one in (a, b))
        records.append(_realization(identifier, first, second, part(conditioning, own)))
    return records


def _realization(identifier: str, a: dict[str, Any], b: dict[str, Any], conditioning: dict[str, Any]) -> dict[str, Any]:
    """The record of one realisation from what routes A and B found.

    Where the routes do not agree within the conditioning there is no certified number: null, with that reason. It
    happens only in noted shells, where a rounding may decide which basin the search ends in; elsewhere it is refused.
    """
    c, number = configuration_of(identifier), int(identifier.rsplit("/", 1)[1])
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
        _decisions(c, methods_of(identifier)),
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


def _ensemble(e: Ensemble, worse: FloatArray) -> dict[str, Any]:
    """The record of an ensemble: route B, confirmed by the realisations done by A as well.

    `worse` (R, n) is what `_measured` says of the softness of its velocities. A mean is conditioned as the mean
    of its velocities' conditioning; a standard deviation as twice their root mean square; a standard error as that over
    the square root of the count; counts are exact.
    """
    c, per_velocity = e.configuration, UNFLAGGED / tolerance(1.0) * worse  # (R, n)
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
        ensemble_id(c, e.window, e.method),
        "ensemble",
        "hard",
        "bias and random part over many seas: a slip too small or too rare for one sea",
        "sec:parameters",
        _DSV_FAULTS,
        (*_decisions(c, (e.method,)), "D12"),
    )
    frequency, wavenumber = e.resolutions
    extra = {
        "resolution_frequency": frequency.tolist(),
        "resolution_wavenumber": wavenumber.tolist(),
        "flagged": {n: e.noted(note).tolist() for note in Note for n in note.names if e.noted(note).any()},
    }
    given = {**describe(c), "window": e.window, "method": e.method, "realizations": len(e.velocities)}
    return entry_record(head, given, {"B": statistics_of(e)}, "B", conditioning, extra)


def inherit(record: dict[str, Any], certified: Mapping[str, Entry]) -> None:
    """Give an ensemble, which is by route B alone, the digits that both routes share in its certified realisations.
    `record` is changed in place; counts, which are whole numbers, keep theirs. Raises LeakrefError where a certified
    realisation of its configuration is missing.
    """
    method = record["input"]["method"]
    c, name = configuration_of(record["id"]), f"{record['input']['window']}_{method}"
    ids = certified_ids(c, method)
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


def _measured(c: Configuration, methods: tuple[str, ...], work: Path | None, number: int) -> dict[str, FloatArray]:
    """Of one realisation velocities (w, m, n, 2), notes (w, m, n), and by how much each velocity is worse conditioned
    than `UNFLAGGED`, `softness` (w, m, n); 1 where there is none.

    In water that is not deep that is in that water's unit of velocity (decision D29).
    """
    task = runs.Task(c, number, methods)
    about, shape = {**task.about, "source": _source_digest()}, task.shape
    path = None if work is None else work / "measured" / kept.key({**about, "realization": None}) / f"{number:05d}.npz"
    if path and (found := kept.arrays(path, about, velocities=(*shape, 2), notes=shape, softness=shape)):
        return found
    unit = velocity_unit(1.0, c.water, None)
    with runs.one_thread():
        by_name = ensemble.realize(c, number, methods=methods, route="B")
    soft = [
        unit * (softness(method, float(score), hessian, unit) if np.isfinite(score) else 1.0)
        for (_, method), one in by_name.items()
        for score, hessian in zip(one.score, one.hessian, strict=True)
    ]
    values = {
        "velocities": np.array([one.velocities for one in by_name.values()]).reshape(*shape, 2),
        "notes": np.array([[note.value for note in one.notes] for one in by_name.values()]).reshape(shape),
        "softness": np.array(soft).reshape(shape),
    }
    if path:
        kept.keep_arrays(path, about, **values)
    return values


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
    for c, methods in together(rest).items():
        with runs.pool(workers) as executor:
            one = partial(_measured, c, methods, work)
            parts = list((map if executor is None else executor.map)(one, range(REALIZATIONS)))
        stacked = {name: np.array([part[name] for part in parts]) for name in parts[0]}
        for w, m in np.ndindex(len(c.windows), len(methods)):
            velocities, notes, soft = (stacked[name][:, w, m] for name in ("velocities", "notes", "softness"))
            e = Ensemble(c, c.windows[w], methods[m], c.wavenumbers, velocities, notes)
            if ensemble_id(c, e.window, e.method) in rest:
                yield _ensemble(e, soft)
                step()


def certified(wanted: Sequence[str], work: Path | None, workers: int) -> Iterator[dict[str, Any]]:
    """The records of realisations; several seas at a time with several `workers`, each with up to 9 GB.

    Those that share a sea are made together. Ids end with the number of the realisation. What an earlier run of the
    same source left in `work` is taken.
    """
    groups: dict[tuple[Configuration, str], list[str]] = {}
    for identifier in wanted:
        groups.setdefault((configuration_of(identifier), identifier.rsplit("/", 1)[1]), []).append(identifier)
    one = partial(_certify, work=work)
    with runs.pool(min(workers, max(1, len(groups)))) as executor:
        for records in (map if executor is None else executor.map)(one, groups.values()):
            yield from records


def _certify(identifiers: Sequence[str], work: Path | None) -> list[dict[str, Any]]:
    """One realisation on one thread, so that the last bits do not depend on the machine's cores."""
    with runs.one_thread():
        return _resumed(identifiers, work, partial(_realizations, identifiers))


def _resumed(
    identifiers: Sequence[str], work: Path | None, make: Callable[[], list[dict[str, Any]]]
) -> list[dict[str, Any]]:
    """Records from `work`, if an earlier run of the same source left them there, else made and left there. Kept under
    the digest of the sources, so that a change of anything that counts makes them anew.
    """
    if work is None:
        return make()
    abouts = [{"id": identifier, "source": _source_digest()} for identifier in identifiers]
    paths = [work / "entries" / f"{kept.key(about)}.json" for about in abouts]
    found = [kept.record(path, about) for path, about in zip(paths, abouts, strict=True)]
    if None in found:
        found = json.loads(json.dumps(to_json(make())))
        for path, about, record in zip(paths, abouts, found, strict=True):
            kept.keep_record(path, about, record)
    return [dict(record) for record in found if record is not None]


@cache
def _source_digest() -> str:
    return sources.digest(__name__)

"""Making golden values, and computing them again: `leakref golden verify` and `leakref golden regenerate`.

Every value is computed by all routes of its stage; the one from the most digits is kept, with the digits on which all
agree. Where they agree less well than the conditioning allows, nothing is made: that is a fault to be found.
"""

from __future__ import annotations

import hashlib
import json
import re
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from fnmatch import fnmatchcase
from functools import cache, partial
from pathlib import Path
from typing import Any

import numpy as np
from threadpoolctl import threadpool_limits

from leakref import __version__, ensemble, kept, runs, sources
from leakref.golden import oracle
from leakref._base import FloatArray, LeakrefError
from leakref._output import plain as to_json
from leakref._output import write_whole
from leakref.cases import CASES, REALIZATIONS, Configuration
from leakref.chain import METHODS, analyse
from leakref.decisions import DECISIONS
from leakref.ensemble import Ensemble
from leakref.golden import (MARGIN, SCHEMA_VERSION, SETS, Entry, Failure, Golden, Report, agreed_digits, compare,
                            digest, entry_digest, tolerance)
from leakref.golden.beside import noted
from leakref.golden.same import agree, alike, given
from leakref.golden.stages import STAGES, UNFLAGGED, plain, softness, velocity_conditioning
from leakref.golden.vectors import VECTORS, Vector
from leakref.shell import Extraction, Note
from leakref.spectrum import Spectrum, fourier
from leakref.synthesis import synthesize

__all__ = ["ids", "looked_at", "regenerate", "verify", "verify_entry"]

Step = Callable[[], object]
_CERTIFIED = (0, 1)
"""Realisations of every configuration that are golden one by one."""


# ---------------------------------------------------------------- one entry


def _values(value: FloatArray) -> Any:
    """Nested lists for JSON: whole numbers as such, NaN as null."""
    listed = to_json(np.asarray(value, dtype=np.float64))

    def whole(item: Any) -> Any:
        if isinstance(item, list):
            return [whole(part) for part in item]
        return int(item) if item is not None and item == int(item) and abs(item) < 2**31 else item

    exact = bool(np.all(np.equal(np.round(value), value)))
    return whole(listed) if exact else listed


def _accuracy(name: str, identifier: str, golden: FloatArray, others: Mapping[str, FloatArray],
              conditioning: Any) -> dict[str, Any]:
    """Digits, conditioning and tolerance of one output; LeakrefError if a route is farther off than that."""
    kappa = np.asarray(conditioning, dtype=np.float64)
    allowed = np.asarray([tolerance(float(c)) for c in kappa.ravel()]).reshape(kappa.shape)
    per_item = allowed.reshape(allowed.shape + (1,) * (golden.ndim - allowed.ndim if allowed.ndim else 0))
    worst = 0.0
    for route, values in others.items():
        same_nan = np.isnan(values) == np.isnan(golden)
        off = np.where(np.isnan(golden), 0.0, np.abs(values - golden))
        too_far = off > np.where(np.isnan(per_item), 0, per_item)
        if values.shape != golden.shape or not same_nan.all() or too_far.any():
            raise LeakrefError("golden.regenerate", f"{identifier}: route {route} differs in {name} by "
                               f"{float(np.nanmax(off)):.2g}, more than its conditioning allows "
                               f"({float(np.nanmax(allowed)):.2g})", "find out why; nothing was written")
        worst = max(worst, float(np.nanmax(off, initial=0.0)))
    scale, most = (float(np.nanmax(np.abs(v), initial=0.0)) for v in (golden, kappa))
    scale = scale if scale > tolerance(most) else most  # all zero but for rounding: digits after the first that counts
    return {"digits": agreed_digits(worst, scale), "conditioning": to_json(kappa), "tolerance": to_json(allowed)}


def _reasons(golden: FloatArray, notes: Sequence[Sequence[str]] | None) -> list[str]:
    rows = golden.reshape(golden.shape[0], -1) if golden.ndim else golden.reshape(1, 1)
    missing = [bool(np.isnan(row).any()) for row in rows]
    return [", ".join(notes[n]) if gone and notes is not None else "no number" if gone else ""
            for n, gone in enumerate(missing)]


def _entry(head: Mapping[str, Any], given: Mapping[str, Any], found: Mapping[str, Mapping[str, Any]], kept: str,
           conditioning: Mapping[str, Any], extra: Mapping[str, Any] | None = None) -> dict[str, Any]:
    """The record of an entry from what each route `found`, keeping the values of route `kept`."""
    notes = next((outputs["notes"] for outputs in found.values() if "notes" in outputs), None)
    for route, outputs in found.items():
        if outputs.get("notes", notes) != notes:
            raise LeakrefError("golden.regenerate", f"{head['id']}: route {route} notes {outputs['notes']}, another "
                               f"{notes}", "find out why; nothing was written")
    golden = {name: value for name, value in found[kept].items() if name != "notes"}
    accuracy = {name: _accuracy(name, str(head["id"]), value, {r: o[name] for r, o in found.items() if r != kept},
                                conditioning[name]) for name, value in golden.items()}
    reasons = {name: _reasons(value, notes) for name, value in golden.items() if np.isnan(value).any()}
    record: dict[str, Any] = {**head, "input": given, "output": {name: _values(v) for name, v in golden.items()}}
    if notes is not None:
        record["notes"] = notes
    if reasons:
        record["reasons"] = reasons
    origin = {"values": kept, "confirmed_by": sorted(route for route in found if route != kept)}
    return {**record, **(extra or {}), "origin": origin, "accuracy": accuracy}


def _head(identifier: str, stage: str, difficulty: str, purpose: str, equation: str, faults: Iterable[str] = (),
          decisions: Iterable[str] = (), supersedes: str | None = None) -> dict[str, Any]:
    return {"id": identifier, "stage": stage, "difficulty": difficulty, "purpose": purpose, "faults": list(faults),
            "equation": equation, "decisions": list(decisions), "supersedes": supersedes}


def _vector(vector: Vector, before: Entry | None = None) -> dict[str, Any]:
    """The record of a vector, by every route and the witness; `before` is what the set has of it."""
    stage, put_in = STAGES[vector.stage], given(vector, before)
    found = {route: compute(put_in) for route, compute in stage.routes.items()}
    first = next(iter(found))
    if stage.witness is not None:
        found["mpmath"] = oracle.at_digits(stage.witness)(put_in, found[first])
    rounded = {route: plain(outputs) for route, outputs in found.items()}
    conditioning = stage.conditioning(put_in, {n: v for n, v in rounded[first].items() if n != "notes"})
    head = _head(vector.id, vector.stage, vector.difficulty, vector.purpose, stage.equation, vector.faults,
                 vector.decisions, vector.supersedes)
    return _entry(head, put_in, rounded, "mpmath" if stage.witness is not None else first, conditioning)


# ---------------------------------------------------------------- realisations and ensembles


def _described(c: Configuration) -> dict[str, Any]:
    """A configuration in words of JSON: enough to make it without this package's table of cases."""
    return {"configuration": c.id, "direction": c.direction, "spread": c.spread, "peakedness": c.peakedness,
            "length": c.length, "duration": c.duration, "speed": c.speed, "current_direction": c.current_direction,
            "rotation": c.rotation, "shape": list(c.grid.shape), "spacing": list(c.grid.spacing),
            "windows": list(c.windows), "wavenumbers": c.wavenumbers.tolist()}


def _one_by_one(c: Configuration, number: int) -> Iterator[Spectrum]:
    """Route A, one window at a time and no more than the surface and one spectrum in memory."""
    waves, grid = c.components(number), c.grid
    eta = synthesize(waves, *(grid.samples(axis) for axis in range(3)))
    reach = float(c.wavenumbers[-1]) + 3 * grid.wavenumber_resolution
    near = [np.flatnonzero(np.abs(grid.bins(axis)) * grid.bin_widths[axis] <= reach) for axis in (0, 1)]
    for name in c.windows:
        whole = fourier(eta, grid, name, workers=1)
        cropped = Spectrum(grid, name, whole.i[near[0]], whole.j[near[1]], whole.values[np.ix_(*near)])
        del whole
        yield cropped


def _by_surface(c: Configuration, number: int) -> tuple[dict[str, Any], dict[str, Any]]:
    """Velocities and notes by route A, and the conditioning of each velocity."""
    found: dict[str, Any] = {}
    conditioning: dict[str, Any] = {}
    turns = float(4 + np.log2(np.prod(c.grid.shape)) + 2 * np.pi * (3.5 * c.length * 2 + 1.9 * c.duration))
    notes: dict[str, Any] = {}
    for spectrum in _one_by_one(c, number):
        for method in METHODS:
            one = analyse(spectrum, c.wavenumbers, method=method)
            name = f"{spectrum.window}_{method}"
            found[name], notes[name] = one.velocities, _names(one)
            conditioning[name] = velocity_conditioning(spectrum, one, turns)
    return {**found, "notes": notes}, conditioning


def _names(found: Extraction) -> list[list[str]]:
    return [note.names for note in found.notes]


def _closed(c: Configuration, number: int) -> dict[str, Any]:
    """Velocities and notes by route B."""
    found = {f"{window}_{method}": one for (window, method), one in ensemble.realize(c, number, route="B").items()}
    return {**{name: one.velocities for name, one in found.items()},
            "notes": {name: _names(one) for name, one in found.items()}}


_DSV_DECISIONS = tuple(f"D{n}" for n in (1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 13, 15, 16, 17, 18, 19, 22))


def _realization(c: Configuration, number: int) -> dict[str, Any]:
    """The record of one realisation by routes A and B.

    Where the routes do not agree within the conditioning there is no certified number: null, with that reason. It
    happens only in noted shells, where a rounding may decide which basin the search ends in; elsewhere it is refused.
    """
    a, conditioning = _by_surface(c, number)
    b = _closed(c, number)
    reasons: dict[str, list[str]] = {}
    for name, kappa in conditioning.items():
        allowed = np.array([tolerance(x) for x in kappa])
        apart = ~(np.abs(a[name] - b[name]).max(axis=1) <= allowed) & np.isfinite(a[name]).all(axis=1)
        for n in np.flatnonzero(apart):
            if not a["notes"][name][n] and not b["notes"][name][n]:
                raise LeakrefError("golden.regenerate", f"{_realization_id(c, number)}: routes A and B give "
                                   f"{a[name][n]} and {b[name][n]} in {name}, shell {n}, which has no note, where "
                                   f"{allowed[n]:.2g} is allowed", "find out why; nothing was written")
        for one in (a, b):
            one[name] = np.where(apart[:, None], np.nan, one[name])
        conditioning[name] = [float("nan") if gone else x for x, gone in zip(kappa, apart, strict=True)]
        reasons[name] = [("routes A and B differ; " if gone else "") + ", ".join(a["notes"][name][n])
                         if gone or not np.isfinite(a[name][n]).all() else "" for n, gone in enumerate(apart)]
    notes = a.pop("notes")
    b.pop("notes")
    head = _head(_realization_id(c, number), "realization", "hard", "a whole sea through the whole chain, shell by "
                 "shell: any slip that the small vectors miss", "sec:NSP", _DSV_FAULTS, _DSV_DECISIONS)
    given = {name: said for name, said in reasons.items() if any(said)}
    extra = {"notes": notes, **({"reasons": given} if given else {})}
    return _entry(head, {**_described(c), "realization": number}, {"A": a, "B": b}, "A", conditioning, extra)


_DSV_FAULTS = ("negated-current", "flipped-x", "flipped-y", "exchanged-axes", "solve-sign-slip", "hard-coded-width",
               "extra-branch", "no-taper")
_STATISTICS = ("bias", "random", "mean", "standard_error", "count")


def _realization_id(c: Configuration, number: int) -> str:
    return f"realization-{c.id}/{number}"


def _ensemble_id(c: Configuration, window: str, method: str) -> str:
    return f"ensemble-{c.id}/{window}-{method}"


def _statistics(e: Ensemble) -> dict[str, FloatArray]:
    return {name: np.asarray(getattr(e, name), dtype=np.float64) for name in _STATISTICS}


def _ensembles(c: Configuration, found: Sequence[Ensemble],
               worse: Sequence[Mapping[tuple[str, str], list[float]]]) -> list[dict[str, Any]]:
    """Records of the ensembles of a configuration: route B, confirmed by the realisations done by A as well.

    `worse`, one for each realisation, is what `_softnesses` says of its velocities.
    """
    records = []
    for e in found:
        name = (e.window, e.method)
        per_velocity = UNFLAGGED / tolerance(1.0) * np.array([one[name] for one in worse])  # (R, n)
        there = np.isfinite(e.magnitudes)
        mean = np.where(there, per_velocity, 0).sum(axis=0) / np.maximum(e.count, 1)
        spread = 2 * np.sqrt(np.where(there, per_velocity**2, 0).sum(axis=0) / np.maximum(e.count - 1, 1))
        conditioning = {"bias": mean.tolist(), "mean": mean.tolist(), "random": spread.tolist(), "count": 0.0,
                        "standard_error": (spread / np.sqrt(np.maximum(e.count, 1))).tolist()}
        head = _head(_ensemble_id(c, *name), "ensemble", "hard", "bias and random part over many seas: a slip too "
                     "small or too rare for one sea", "sec:parameters", _DSV_FAULTS, (*_DSV_DECISIONS, "D12"))
        frequency, wavenumber = e.resolutions
        extra = {"resolution_frequency": frequency.tolist(),
                 "resolution_wavenumber": wavenumber.tolist(),
                 "flagged": {n: e.noted(note).tolist() for note in Note for n in note.names if e.noted(note).any()}}
        given = {**_described(c), "window": e.window, "method": e.method, "realizations": len(e.velocities)}
        records.append(_entry(head, given, {"B": _statistics(e)}, "B", conditioning, extra))
    return records


def _inherit(record: dict[str, Any], certified: Mapping[str, Entry]) -> None:
    """Give an ensemble, which is by route B alone, the digits that both routes share in its certified realisations."""
    c, name = _configuration(record["id"]), f"{record['input']['window']}_{record['input']['method']}"
    ids = [_realization_id(c, number) for number in _CERTIFIED]
    if missing := [i for i in ids if i not in certified]:
        raise LeakrefError("golden.regenerate", f"{record['id']} has its digits from {missing[0]}, which is not there",
                           f"make that first: leakref golden regenerate '{missing[0]}'")
    digits = min(certified[i].record["accuracy"][name]["digits"] for i in ids)
    for statistic, said in record["accuracy"].items():
        if statistic != "count":  # a whole number
            said["digits"] = min(said["digits"], digits)


def _softnesses(c: Configuration, number: int) -> dict[tuple[str, str], list[float]]:
    """By how much each velocity of a realisation is worse conditioned than `UNFLAGGED`; 1 where there is none."""
    with threadpool_limits(limits=1):
        found = ensemble.realize(c, number, route="B")
    return {(window, method): [softness(method, float(score), hessian) if np.isfinite(score) else 1.0
                               for score, hessian in zip(one.score, one.hessian, strict=True)]
            for (window, method), one in found.items()}


# ---------------------------------------------------------------- what there is to make


def _file_of(part: str, name: str) -> str:
    return f"{part}/{name}.json"


def ids(*parts: str) -> dict[str, str]:
    """Every id that can be made, and the file it belongs in."""
    found = {v.id: _file_of(part, v.stage if part == "vectors" else "windows") for part, vectors in VECTORS.items()
             for v in vectors if part in parts}
    for c in (c for members in CASES.values() for c in members):
        if "realizations" in parts:
            found |= {_realization_id(c, n): _file_of("realizations", c.case) for n in _CERTIFIED}
        if "ensembles" in parts:
            found |= {_ensemble_id(c, w, m): _file_of("ensembles", c.case) for w in c.windows for m in METHODS}
    return found


def _configuration(identifier: str) -> Configuration:
    name = identifier.split("-", 1)[1].rsplit("/", 1)[0]
    return next(c for members in CASES.values() for c in members if c.id == name)


def _make(wanted: Sequence[str], old: Mapping[str, Entry], work: Path | None, workers: int,
          step: Step) -> Iterator[dict[str, Any]]:
    """The records of the `wanted` ids, from the inputs of `old` ones.

    Slow ones that were done before, by the same source, are found in `work`.
    """
    vectors = {v.id: v for members in VECTORS.values() for v in members}
    for identifier in (i for i in wanted if i in vectors):
        yield _vector(vectors[identifier], old.get(identifier))
        step()
    for record in _certified([i for i in wanted if i.startswith("realization-")], work, workers):
        yield record
        step()
    rest = [i for i in wanted if i.startswith("ensemble-")]
    configurations = list(dict.fromkeys(_configuration(i) for i in rest))
    with runs.pool(workers) as executor:
        for found in runs.run(configurations, realizations=REALIZATIONS, folder=work and work / "runs",
                              executor=executor):
            c = found[0].configuration
            soft = (map if executor is None else executor.map)(partial(_softnesses, c), range(REALIZATIONS))
            for record in _ensembles(c, found, list(soft)):
                if record["id"] in rest:
                    yield record
                    step()


def _certified(wanted: Sequence[str], work: Path | None, workers: int) -> Iterator[dict[str, Any]]:
    """The records of realisations, in order; several at a time with several `workers`, each with up to 9 GB."""
    one = partial(_certify, work=work)
    with runs.pool(min(workers, max(1, len(wanted)))) as executor:
        yield from (map(one, wanted) if executor is None else executor.map(one, wanted))


def _certify(identifier: str, work: Path | None) -> dict[str, Any]:
    with threadpool_limits(limits=1):
        return _resumed(identifier, work, partial(_realization, _configuration(identifier),
                                                  int(identifier.rsplit("/", 1)[1])))


def _resumed(identifier: str, work: Path | None, make: Callable[[], dict[str, Any]]) -> dict[str, Any]:
    """A record from `work`, if an earlier run of the same source left it there, else made and left there."""
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


# ---------------------------------------------------------------- writing


def _text(value: Any, indent: int = 0) -> str:
    """JSON with one array of values a line: what changed in a diff is what changed in the set."""
    pad = "  " * (indent + 1)
    if isinstance(value, dict) and value:
        rows = [f"{pad}{json.dumps(key)}: {_text(item, indent + 1)}" for key, item in value.items()]
    elif isinstance(value, list) and any(isinstance(item, dict | list) for item in value):
        rows = [pad + _text(item, indent + 1) for item in value]
    else:
        return json.dumps(value, ensure_ascii=False, allow_nan=False)
    opening, closing = "{}" if isinstance(value, dict) else "[]"
    return f"{opening}\n" + ",\n".join(rows) + f"\n{'  ' * indent}{closing}"


def _split(record: dict[str, Any], file: str, archived: Sequence[str]) -> tuple[dict[str, Any], dict[str, FloatArray]]:
    """Large inputs go to the npz beside the file."""
    arrays: dict[str, FloatArray] = {}
    for name in archived:
        arrays[f"{record['id']}.{name}"] = np.asarray(record["input"][name], dtype=np.float64)
    beside = Path(file).with_suffix(".npz").name
    given = {name: {"npz": beside, "array": f"{record['id']}.{name}"} if name in archived else value
             for name, value in record["input"].items()}
    return {**record, "input": given}, arrays


def _write_text(text: str, path: Path) -> None:
    path.write_text(text, encoding="utf-8", newline="\n")


def _write(folder: Path, file: str, entries: Sequence[Entry]) -> list[str]:
    """A file of entries and, if they have arrays, the npz beside it; the names written."""
    content = {"schema": f"leakref/golden-entries/{SCHEMA_VERSION}", "entries": [dict(e.record) for e in entries]}
    write_whole(folder / file, partial(_write_text, _text(content) + "\n"))
    arrays = {n: value for entry in entries for n, value in entry.arrays.items() if n.startswith(f"{entry.id}.")}
    if not arrays:
        return [file]
    beside = str(Path(file).with_suffix(".npz").as_posix())
    write_whole(folder / beside, lambda path: np.savez(path, **{n: arrays[n] for n in sorted(arrays)}))  # type: ignore[arg-type]
    return [file, beside]


def _write_manifest(folder: Path) -> None:
    """Say what the files of `folder` hold: digests, counts, licence, decisions."""
    golden = Golden(folder)
    files: dict[str, Any] = {}
    parts = []
    for part in SETS:
        entries = values = 0
        for path in sorted((folder / part).glob("*")) if (folder / part).is_dir() else []:
            if path.name.endswith(".new.json"):
                continue
            name = f"{part}/{path.name}"
            files[name] = {"sha256": hashlib.sha256(path.read_bytes()).hexdigest()}
            if path.suffix == ".json":
                found = golden.as_it_is(name)
                files[name]["entries"] = {entry.id: entry_digest(entry) for entry in found}
                entries, values = entries + len(found), values + sum(entry.values for entry in found)
        of = len(ids(part))
        state = "complete" if entries >= of else "partial" if entries else "absent"
        parts.append({"name": part, "state": state, "entries": entries, "of": of, "values": values})
    files["schema.json"] = {"sha256": hashlib.sha256((folder / "schema.json").read_bytes()).hexdigest()}
    name = golden._json("manifest.json")["set"] if (folder / "manifest.json").is_file() else folder.name
    manifest = {"schema": f"leakref/golden-manifest/{SCHEMA_VERSION}", "set": name, "license": "CC0-1.0",
                "made_by": f"leakref {__version__}", "margin": MARGIN, "parts": parts,
                "decisions": {d.id: d.reference for d in DECISIONS.values()}, "files": files}
    manifest["sha256"] = digest(manifest)
    noted(write_whole(folder / "manifest.json", partial(_write_text, _text(manifest) + "\n")))


def regenerate(wanted: Sequence[str], folder: Path, *, work: Path | None = None, workers: int = 1,
               step: Step = lambda: None) -> tuple[list[dict[str, Any]], bool]:
    """Compute entries, again or for the first time: rows saying what became of each, whether nothing is left open.

    Nothing wanted: all that the set holds; what differs is written beside the old file as `NAME.new.json` and not
    taken over. An id that is named is written to the set, over the old one if there is one. A pattern such as
    `nsp-*`, or the name of a part such as `realizations`, adds what is missing and never replaces. Raises LeakrefError
    for an unknown id.
    """
    possible = ids(*SETS)
    golden = Golden(folder)
    old = {entry.id: entry for entry in golden.entries()} if (folder / "manifest.json").is_file() else {}
    exact = [w for w in wanted if w in possible]
    meant = {w: list(ids(w)) if w in SETS else [i for i in possible if fnmatchcase(i, w)] for w in wanted}
    matching = [i for w in wanted if w not in possible for i in meant[w] if i not in old]
    for w in wanted:
        if not meant[w]:
            raise LeakrefError("golden.regenerate", f"no golden value is called {w!r}",
                               "define it in leakref/golden/vectors.py first; ids are listed in the manifest")
    chosen = list(dict.fromkeys([*exact, *matching])) if wanted else [i for i in possible if i in old]
    archived = {v.id: v.archived for members in VECTORS.values() for v in members}
    rows: list[dict[str, Any]] = []
    beside = dict(old)
    for record in _make(chosen, old, work, workers, step):
        record = json.loads(json.dumps(to_json(record)))
        if record["stage"] == "ensemble":
            _inherit(record, old)
        record, arrays = _split(record, possible[record["id"]], archived.get(record["id"], ()))
        new = Entry(possible[record["id"]], record, arrays)
        before = old.get(new.id)
        if before is not None and agree(before, new):
            rows.append({"id": new.id, "change": "same", "largest": 0.0, "over_tolerance": 0.0, "written": False})
            continue
        take = new.id in exact or new.id in matching
        rows.append({"id": new.id, **_difference(before, new, take)})
        beside[new.id] = new
        if take:
            old[new.id] = new
            _save(folder, old, possible, new.file)  # at once: an interrupted run keeps what it has made
            _write_manifest(folder)
    if wanted:
        return rows, True
    changed = {row["id"] for row in rows if row["change"] != "same"}
    for file in sorted({beside[i].file for i in changed}):
        proposed = [e for e in beside.values() if e.file == file]
        content = {"schema": f"leakref/golden-entries/{SCHEMA_VERSION}", "entries": [dict(e.record) for e in proposed]}
        target = folder / re.sub(r"\.json$", ".new.json", file)
        write_whole(target, partial(_write_text, _text(content) + "\n"))
    return rows, not changed


def _save(folder: Path, entries: Mapping[str, Entry], possible: Mapping[str, str], file: str) -> None:
    order = {identifier: n for n, identifier in enumerate(possible)}
    members = sorted((e for e in entries.values() if e.file == file), key=lambda e: order.get(e.id, len(order)))
    _write(folder, file, members)


def _difference(before: Entry | None, after: Entry, taken: bool) -> dict[str, Any]:
    """What changed between two records of one id: largest change of a value, over its tolerance, and other keys."""
    if before is None:
        return {"change": "new", "largest": None, "over_tolerance": None, "written": taken}
    largest = over = 0.0
    for name in set(before.output) & set(after.output):
        a, b = before.output[name], after.output[name]
        if a.shape != b.shape or np.any(np.isnan(a) != np.isnan(b)):
            largest = over = float("inf")
            continue
        off = np.where(np.isnan(a), 0.0, np.abs(a - b))
        allowed = np.broadcast_to(before.tolerance(name), a.shape)
        largest = max(largest, float(off.max(initial=0.0)))
        over = max(over, float(np.max(np.where(off > 0, off / np.where(allowed > 0, allowed, 1e-300), 0), initial=0.0)))
    keys = sorted(k for k in {*before.record, *after.record} if before.record.get(k) != after.record.get(k))
    return {"change": ", ".join(keys) or "arrays", "largest": largest, "over_tolerance": over, "written": taken}


# ---------------------------------------------------------------- verifying


def verify_entry(entry: Entry, routes: Sequence[str] | None = None, *, with_witness: bool = False) -> list[Failure]:
    """Compute a vector again by the routes of its stage and compare; an exception is a failure like any other."""
    stage = STAGES[entry.stage]
    failures: list[Failure] = []
    first: dict[str, Any] | None = None
    for route, compute in stage.routes.items():
        if routes is not None and route not in routes:
            continue
        try:
            found = compute(entry.input)
        except Exception as error:
            failures.append(Failure(entry.id, f"route {route} failed: {type(error).__name__}: {error}", entry.stage))
            continue
        first = first or found
        failures += compare(entry, found, route) + _noted(entry, found.get("notes"), route)
    if with_witness and stage.witness is not None and first is not None:
        failures += compare(entry, plain(oracle.at_digits(stage.witness)(entry.input, first)), "mpmath")
    return failures


def _noted(entry: Entry, notes: Any, route: str) -> list[Failure]:
    golden = entry.record.get("notes")
    if notes is None or golden == notes:
        return []
    return [Failure(entry.id, f"the notes are {notes} by route {route}, but should be {golden}", entry.stage)]


def verify(golden: Golden | None = None, *, full: bool = False, wanted: Sequence[str] = (), route: str = "B",
           work: Path | None = None, workers: int = 1, step: Step = lambda: None) -> Report:
    """Compute golden values again and compare.

    Quick: all vectors and analytic values by the chain, realisation 0 of the small configurations by route B.
    `full`: vectors by every route and the witness, all realisations by A and B, all ensembles by B; what is done is
    kept in `work`, so that an interrupted run goes on where it stopped. `wanted` are ids, or patterns of them, to look
    at instead, as in a full run; with `route` A ensembles are confirmed by the surface and the FFT, 16 s a realisation.
    """
    golden = golden or Golden()
    failures = [Failure("manifest.json", f"decision {name} was {said!r} when this set was made, and is another now")
                for name, said in golden.manifest["decisions"].items()
                if name not in DECISIONS or DECISIONS[name].reference != said]
    full = full or bool(wanted)
    chosen = looked_at(golden, full, wanted)
    rows: list[dict[str, Any]] = []
    for part in SETS:
        entries = [e for e in chosen if e.file.split("/")[0] == part]
        if part in VECTORS:
            for entry in entries:
                failures += verify_entry(entry, with_witness=full)
                step()
        elif part == "realizations":
            failures += _verify_realizations(entries, full, work, workers, step)
        elif entries:
            failures += _verify_ensembles(entries, route, work, workers, step)
        rows.append({"name": part, "entries": len(entries), "values": sum(e.values for e in entries)})
    return Report(rows, sum(row["values"] for row in rows), failures)


def looked_at(golden: Golden, full: bool, wanted: Sequence[str] = ()) -> list[Entry]:
    """The entries that `verify` compares. Raises LeakrefError for an id or a pattern that is none of them."""
    entries = list(golden.entries())
    for pattern in wanted:
        if not any(fnmatchcase(e.id, pattern) for e in entries):
            raise LeakrefError("golden.verify", f"no golden value is called {pattern!r}", "ids are in the manifest")
    replaced = {e.record["supersedes"] for e in entries if e.record.get("supersedes")}
    return [e for e in entries if e.id not in replaced and (full or _is_quick(e))
            and (not wanted or any(fnmatchcase(e.id, pattern) for pattern in wanted))]


def _is_quick(entry: Entry) -> bool:
    if entry.stage == "realization":
        given = entry.record["input"]
        return bool(given["realization"] == 0 and given["length"] <= 10 and given["duration"] <= 10 * (
            1 + (given["configuration"] in ("nsp-ls", "theta0-dtheta/direction=60,spread=15"))))
    return entry.stage != "ensemble"


def _verify_realizations(entries: Sequence[Entry], full: bool, work: Path | None, workers: int,
                         step: Step) -> list[Failure]:
    failures = []
    by_surface = [entry.id for entry in entries if full and not _is_huge_again(entry)]
    again = {record["id"]: record for record in _certified(by_surface, work, workers)}
    for entry in entries:
        c, number = _configuration(entry.id), int(entry.record["input"]["realization"])
        if not alike(_described(c), {k: v for k, v in entry.record["input"].items() if k != "realization"}):
            failures.append(Failure(entry.id, "the configuration of that name is another now", entry.stage))
        failures += _without_null(entry, _closed(c, number), "B")
        if entry.id in again:
            record = again[entry.id]
            failures += _without_null(entry, {**Entry(entry.file, record).output, "notes": record["notes"]}, "A")
        step()
    return failures


def _is_huge_again(entry: Entry) -> bool:
    """L = 20, T = 80, 351 million samples, is done by the surface once."""
    given = entry.record["input"]
    return bool(given["realization"] > 0 and given["length"] >= 20 and given["duration"] >= 80)


def _without_null(entry: Entry, found: Mapping[str, Any], route: str) -> list[Failure]:
    """Compare where there is a certified number; where the routes once differed there is nothing to hold to."""
    reasons = entry.record.get("reasons", {})
    mine = dict(found)
    for name, said in reasons.items():
        differ = np.array([reason.startswith("routes A and B differ") for reason in said])
        mine[name] = np.where(differ[:, None], np.nan, mine[name])
    return compare(entry, mine, route)


def _verify_ensembles(entries: Sequence[Entry], route: str, work: Path | None, workers: int,
                      step: Step) -> list[Failure]:
    wanted = {entry.id: entry for entry in entries}
    failures = []
    with runs.pool(workers) as executor:
        for found in runs.run(list(dict.fromkeys(_configuration(i) for i in wanted)), realizations=REALIZATIONS,
                              route=route, folder=work and work / "runs", executor=executor):
            for e in found:
                entry = wanted.get(_ensemble_id(e.configuration, e.window, e.method))
                if entry is not None:
                    failures += compare(entry, _statistics(e), route)
                    step()
    return failures

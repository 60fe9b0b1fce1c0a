"""Computing golden values again and comparing them with what is kept.

It never writes into the set: what differs is a Failure, and what to do about it is for people. Vectors are computed by
the routes of their stage, realisations by `entries.certified` and `closed_form`, ensembles by `leakref.runs`. Whether
files were changed is looked at before, by `linting`.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from fnmatch import fnmatchcase
from pathlib import Path
from typing import Any

import numpy as np

from leakref import runs
from leakref._base import LeakrefError
from leakref.cases import REALIZATIONS, Configuration
from leakref.decisions import DECISIONS
from leakref.golden import oracle
from leakref.golden.defined import VECTORS
from leakref.golden.entries import Step, certified, closed_form, describe, statistics_of
from leakref.golden.ids import configuration_of, ensemble_id, methods_of, together
from leakref.golden.same import alike
from leakref.golden.sets import SETS, Entry, Failure, Golden, Report, compare
from leakref.golden.stages import STAGES
from leakref.golden.stages.stage import plain

__all__ = ["looked_at", "verify", "verify_entry"]


def verify_entry(entry: Entry, routes: Sequence[str] | None = None, *, with_oracle: bool = False) -> list[Failure]:
    """Compute a vector again by the routes of its stage and compare; an exception is a failure like any other.

    `routes` are those to try, by default all that the stage has; `with_oracle` adds the paper's formulas with 40
    digits, which start where the first route ended. Notes have to be equal to the letter.
    """
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
    if with_oracle and stage.oracle is not None and first is not None:
        failures += compare(entry, plain(oracle.at_digits(stage.oracle)(entry.input, first)), "mpmath")
    return failures


def _noted(entry: Entry, notes: Any, route: str) -> list[Failure]:
    golden = entry.record.get("notes")
    if notes is None or golden == notes:
        return []
    return [Failure(entry.id, f"the notes are {notes} by route {route}, but should be {golden}", entry.stage)]


def verify(
    golden: Golden | None = None,
    *,
    full: bool = False,
    wanted: Sequence[str] = (),
    route: str = "B",
    work: Path | None = None,
    workers: int = 1,
    step: Step = lambda: None,
) -> Report:
    """Compute golden values again and compare.

    Quick: all vectors and analytic values by the chain, realisation 0 of the small configurations by route B. `full`:
    vectors by every route and the high-precision oracle, all realisations by A and B, all ensembles by B; what is done
    is kept in `work`, so that an interrupted run goes on where it stopped. `wanted` are ids, or patterns of them, to
    look at instead, as in a full run; with `route` A ensembles are confirmed by the surface and the FFT, 16 s a
    realisation.

    `step` is called for each entry. Decisions whose reference has changed since the set was made are failures as well.
    Raises LeakrefError for an id or pattern in `wanted` that no entry has.
    """
    golden = golden or Golden()
    failures = [
        Failure(
            f"{one.manifest['set']}/manifest.json",
            f"decision {name} was {said!r} when this set was made, and is another now",
        )
        for one in golden.chain
        for name, said in one.manifest["decisions"].items()
        if name not in DECISIONS or DECISIONS[name].reference != said
    ]
    full = full or bool(wanted)
    chosen = looked_at(golden, full, wanted)
    rows: list[dict[str, Any]] = []
    for part in SETS:
        entries = [e for e in chosen if e.file.split("/")[0] == part]
        if part in VECTORS:
            for entry in entries:
                failures += verify_entry(entry, with_oracle=full)
                step()
        elif part == "realizations":
            failures += _verify_realizations(entries, full, work, workers, step)
        elif entries:
            failures += _verify_ensembles(entries, route, work, workers, step)
        rows.append({"name": part, "entries": len(entries), "values": sum(e.values for e in entries)})
    return Report(rows, sum(row["values"] for row in rows), failures)


def looked_at(golden: Golden, full: bool, wanted: Sequence[str] = ()) -> list[Entry]:
    """The entries that `verify` compares. Raises LeakrefError for an id or a pattern that is none of them.

    Entries that others supersede are left out. In a quick look there are vectors, analytic values, and realisation 0 of
    configurations small enough.
    """
    entries = list(golden.entries())
    for pattern in wanted:
        if not any(fnmatchcase(e.id, pattern) for e in entries):
            raise LeakrefError("golden.verify", f"no golden value is called {pattern!r}", "ids are in the manifest")
    replaced = {e.record["supersedes"] for e in entries if e.record.get("supersedes")}
    return [
        e
        for e in entries
        if e.id not in replaced
        and (full or _is_quick(e))
        and (not wanted or any(fnmatchcase(e.id, pattern) for pattern in wanted))
    ]


_QUICK = ("nsp-ls", "theta0-dtheta/direction=60,spread=15")
"""Configurations of L = 10 and T = 20 that are looked at all the same, as are those over a bottom."""


def _is_quick(entry: Entry) -> bool:
    if entry.stage == "realization":
        given = entry.record["input"]
        return bool(
            given["realization"] == 0
            and given["length"] <= 10
            and given["duration"] <= 10 * (1 + ("depth" in given or given["configuration"] in _QUICK))
        )
    return entry.stage != "ensemble"


def _verify_realizations(
    entries: Sequence[Entry], full: bool, work: Path | None, workers: int, step: Step
) -> list[Failure]:
    """Single realisations by the closed form, and with `full` through the surface and its transform as well, those of
    huge cubes left out; first, that a configuration is still the one that its name stood for.
    """
    failures = []
    by_surface = [entry.id for entry in entries if full and not _is_huge_again(entry)]
    again = {record["id"]: record for record in certified(by_surface, work, workers)}
    for entry in entries:
        c, number = configuration_of(entry.id), int(entry.record["input"]["realization"])
        if not alike(describe(c), {k: v for k, v in entry.record["input"].items() if k != "realization"}):
            failures.append(Failure(entry.id, "the configuration of that name is another now", entry.stage))
        failures += _without_null(entry, closed_form(c, number, methods_of(entry.id)), "B")
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
    """Compare where there is a certified number; where the routes once differed there is nothing to hold to. A null for
    any other reason must still be a null.
    """
    reasons = entry.record.get("reasons", {})
    mine = dict(found)
    for name, said in reasons.items():
        differ = np.array([reason.startswith("routes A and B differ") for reason in said])
        mine[name] = np.where(differ[:, None], np.nan, mine[name])
    return compare(entry, mine, route)


def _verify_ensembles(
    entries: Sequence[Entry], route: str, work: Path | None, workers: int, step: Step
) -> list[Failure]:
    """Ensembles run again, those of the same methods together, and their statistics against the ones that are kept."""
    wanted = {entry.id: entry for entry in entries}
    failures = []
    by_methods: dict[tuple[str, ...], list[Configuration]] = {}
    for c, methods in together(wanted).items():
        by_methods.setdefault(methods, []).append(c)
    for methods, configurations in by_methods.items():
        with runs.pool(workers) as executor:
            for found in runs.run(
                configurations,
                realizations=REALIZATIONS,
                methods=methods,
                route=route,
                folder=work and work / "runs",
                executor=executor,
            ):
                for e in found:
                    entry = wanted.get(ensemble_id(e.configuration, e.window, e.method))
                    if entry is not None:
                        failures += compare(entry, statistics_of(e), route)
                        step()
    return failures

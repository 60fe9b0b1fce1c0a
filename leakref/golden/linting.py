"""Is a golden set whole and unchanged? Schemas, counts, ids, digests, and that every tolerance is the formula's.

Nothing is computed here: it is about whether the numbers are those that were made, and about what each entry must state
of itself. Used by `leakref golden lint`, and before every verification. A file that cannot be read is one failure, and
the others are still looked at.
"""

from __future__ import annotations

import hashlib
import json
import math
from collections.abc import Iterator, Mapping
from functools import cache
from importlib.resources.abc import Traversable
from typing import Any

import numpy as np

from leakref._base import LeakrefError
from leakref.golden.digests import sealed
from leakref.golden.sets import EPSILON, MARGIN, Entry, Failure, Golden, Report, entry_digest, tolerance

__all__ = ["lint"]

_FORM = 4  # items of an array that show its form


def lint(golden: Golden | None = None) -> Report:
    """See that the set, and what it extends, is whole and unchanged: schemas, counts, ids, digests, tolerances.

    `golden` is the newest set unless given. Returned is a row for each part of each set with its files, entries and
    values, how many values in all, and a Failure for each fault, which names the entry or the file. If a manifest
    cannot be trusted nothing else of its set is looked at. Nothing is raised for a set that is damaged.
    """
    golden = golden or Golden()
    try:
        base = golden.base
    except LeakrefError as error:
        own = _lint(golden, {})
        said = [Failure("manifest.json", f"what it extends cannot be trusted: {error.fault}")]
        return Report(own.sets, own.values, own.failures or said)
    before = lint(base) if base is not None else Report([], 0)
    seen = {entry.id: entry for entry in base.entries()} if base is not None and not before.failures else {}
    own = _lint(golden, seen)
    return Report([*before.sets, *own.sets], before.values + own.values, [*before.failures, *own.failures])


def _lint(golden: Golden, before: Mapping[str, Entry]) -> Report:
    """Of the set itself; `before` are the entries of what it extends, whose ids it must not use again."""
    try:
        manifest, schema, as_stored = (
            golden._json("manifest.json"),
            golden._json("schema.json"),
            golden._read("schema.json"),
        )
        if hashlib.sha256(as_stored).hexdigest() != manifest["files"]["schema.json"]["sha256"]:
            return Report([], 0, [Failure("schema.json", "was changed: its SHA-256 is not the manifest's")])
    except LeakrefError as error:
        named = error.fault.split()[0]
        return Report([], 0, [Failure(named if named == "schema.json" else "manifest.json", error.fault)])
    except (KeyError, TypeError, ValueError):
        return Report([], 0, [Failure("manifest.json", "does not say which files the set has")])
    failures = [Failure("manifest.json", message) for message in _schema_faults(manifest, schema, "manifest")]
    if failures:
        return Report([], 0, failures)
    if not sealed(manifest):
        failures.append(Failure("manifest.json", "was changed: its own SHA-256 is not that of what it says"))
    seen = dict(before)
    rows = {
        part["name"]: {
            "name": part["name"],
            "set": manifest["set"],
            "state": part["state"],
            "files": 0,
            "entries": 0,
            "values": 0,
        }
        for part in manifest["parts"]
    }
    for name, row in manifest["files"].items():
        try:
            same = hashlib.sha256(golden._read(name)).hexdigest() == row["sha256"]
            entries = golden.as_it_is(name) if "entries" in row else []
        except (LeakrefError, KeyError, TypeError) as error:
            fault = error.fault if isinstance(error, LeakrefError) else f"has no {error}"
            ids = ", ".join(row.get("entries", ()))
            failures.append(Failure(name, f"{fault}; it should hold {ids or 'no entries'}"))
            continue
        faults = [fault for entry in entries for fault in _entry_faults(entry, row, schema, seen)]
        there = [entry.record.get("id") for entry in entries]
        faults += [Failure(i, f"is missing from {name}") for i in row.get("entries", ()) if i not in there]
        if not same and not faults:
            faults = [Failure(name, "was changed (its SHA-256 is not the manifest's), though no entry was")]
        failures += faults
        part = rows.get(name.split("/")[0])
        if part is not None and name.endswith(".json"):
            part["files"] += 1
            part["entries"] += len(entries)
            part["values"] += sum(entry.values for entry in entries if not faults)
    failures += _strays(golden, manifest)
    for entry in (entry for name, entry in seen.items() if name not in before):
        unknown = sorted(set(entry.record["decisions"]) - set(manifest["decisions"]))
        if unknown:
            failures.append(Failure(entry.id, f"depends on {unknown}, which the manifest does not list", entry.stage))
        old = entry.record.get("supersedes")
        if old is not None and old not in seen:
            failures.append(Failure(entry.id, f"supersedes {old!r}, which is not in the set", entry.stage))
    for part in manifest["parts"]:
        row = rows[part["name"]]
        if not failures and (row["entries"], row["values"]) != (part["entries"], part["values"]):
            failures.append(
                Failure(
                    "manifest.json",
                    f"says {part['entries']} entries and {part['values']} values in "
                    f"{part['name']}, but there are {row['entries']} and {row['values']}",
                )
            )
    return Report(list(rows.values()), sum(row["values"] for row in rows.values()), failures)


def _schema_faults(record: Any, schema: dict[str, Any], kind: str) -> Iterator[str]:
    """Where a record is not what the schema says of its `kind`, manifest or entry."""
    from jsonschema import Draft202012Validator

    for error in Draft202012Validator({**schema, "$ref": f"#/$defs/{kind}"}).iter_errors(record):
        yield f"{'/'.join(map(str, error.path)) or 'it'}: {error.message[:200]}"


@cache
def _form_fault(outline: str, schema: str) -> str:
    """The first fault of an entry's form, or nothing; a set that is looked at again is quick."""
    return next(_schema_faults(json.loads(outline), json.loads(schema), "entry"), "")


def _outline(value: Any) -> Any:
    """A record with the first items of its arrays only: the schema is about its form, the digest about every number.
    So the schema is asked once for each form, however many numbers there are.
    """
    if isinstance(value, dict):
        return {key: _outline(item) for key, item in value.items()}
    return [_outline(item) for item in value[:_FORM]] if isinstance(value, list) else value


def _entry_faults(
    entry: Entry, row: Mapping[str, Any], schema: dict[str, Any], seen: dict[str, Entry]
) -> Iterator[Failure]:
    """What is amiss with one entry: its form by the schema, its id, its digest, the shapes and the formula of its
    tolerances, digits that are fewer than the tolerance promises, and values that lack a number without a reason.
    `seen` collects ids.
    """
    name = str(entry.record.get("id", f"an entry without id in {entry.file}"))
    stage = str(entry.record.get("stage", ""))
    fault = _form_fault(json.dumps(_outline(entry.record)), json.dumps(schema))
    if fault:
        yield Failure(name, fault, stage)
        return
    if name in seen:
        first, second = (f"{one.folder}/{one.file}".lstrip("/") for one in (seen[name], entry))
        yield Failure(name, f"is there twice, in {first} and in {second}", stage)
        return
    seen[name] = entry
    try:
        changed = entry_digest(entry) != row["entries"].get(name)
        shapes = {key: value.shape for key, value in entry.output.items()}
    except (KeyError, ValueError, TypeError) as problem:
        yield Failure(name, f"has an output that is no array ({problem})", stage)
        return
    if name not in row["entries"]:
        yield Failure(name, f"is in {entry.file}, but not in the manifest", stage)
    elif changed:
        yield Failure(name, f"was changed in {entry.file}: its SHA-256 is not the manifest's", stage)
    for key, accuracy in entry.record["accuracy"].items():
        if key not in shapes:
            yield Failure(name, f"states the accuracy of {key}, which it does not have", stage)
            continue
        conditioning = np.asarray(accuracy["conditioning"], dtype=np.float64)
        allowed = np.asarray(accuracy["tolerance"], dtype=np.float64)
        if conditioning.shape != allowed.shape or (conditioning.ndim and conditioning.shape != shapes[key][:1]):
            yield Failure(name, f"{key}: conditioning, tolerance and values have different lengths", stage)
        elif any(
            not (t == tolerance(c) or (math.isnan(c) and math.isnan(t)))
            for c, t in zip(conditioning.ravel(), allowed.ravel(), strict=True)
        ):
            yield Failure(name, f"{key}: the tolerance is not {MARGIN:g} x 2^-52 x conditioning", stage)
        scale = float(np.nanmax(np.abs(entry.output[key]), initial=0.0))
        most = max(float(np.nanmax(allowed, initial=0.0)), EPSILON * scale)
        if scale > most and 10.0 ** -accuracy["digits"] * scale > 1.3 * most:
            yield Failure(name, f"{key}: {accuracy['digits']} digits are fewer than the tolerance promises", stage)
    for key in set(shapes) - set(entry.record["accuracy"]):
        yield Failure(name, f"does not state the accuracy of {key}", stage)
    for key, values in entry.output.items():
        reasons = entry.record.get("reasons", {}).get(key, [""] * (values.shape[0] if values.ndim else 1))
        for index, reason in enumerate(reasons):
            if bool(reason) != bool(np.isnan(values[index] if values.ndim else values).any()):
                yield Failure(name, f"{key}[{index}]: a null needs a reason, and a number none", stage)


def _strays(golden: Golden, manifest: Mapping[str, Any]) -> Iterator[Failure]:
    """Files in the set's folder that the manifest does not know."""
    known = {*manifest["files"], "manifest.json"}

    def walk(folder: Traversable, prefix: str) -> Iterator[str]:
        for child in folder.iterdir():
            if child.is_dir():
                yield from walk(child, f"{prefix}{child.name}/")
            else:
                yield prefix + child.name

    for name in sorted(walk(golden.folder, "")):
        if name not in known and not name.endswith(".new.json"):
            yield Failure(name, "is not in the manifest: remove it, or add it with `leakref golden regenerate`")

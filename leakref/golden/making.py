"""Making golden values, and computing them again: `leakref golden verify` and `leakref golden regenerate`.

Every value is computed by all routes of its stage; the one from the most digits is kept, with the digits on which all
agree. Where they agree less well than the conditioning allows, nothing is made: that is a fault to be found.
"""

from __future__ import annotations

import hashlib
import json
import re
from collections.abc import Mapping, Sequence
from fnmatch import fnmatchcase
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np

from leakref import __version__
from leakref._base import FloatArray, LeakrefError
from leakref._output import plain as to_json
from leakref._output import write_whole
from leakref.decisions import DECISIONS
from leakref.golden.beside import noted
from leakref.golden.defined import TABLES, VECTORS
from leakref.golden.digests import digest
from leakref.golden.entries import Step, inherit, make
from leakref.golden.ids import ids
from leakref.golden.same import agree
from leakref.golden.sets import MARGIN, SCHEMA_VERSION, SETS, Entry, Golden, archived, entry_digest
from leakref.golden.vectors import Vector

__all__ = ["regenerate"]


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


def _split(record: dict[str, Any], file: str, vector: Vector | None) -> tuple[dict[str, Any], dict[str, FloatArray]]:
    """Large inputs go beside the file. An archived input becomes a reference to an array of an npz, `{"npz": file,
    "array": id.name}`, or to a file of float64, `{"f64": file, "shape": [...]}`; the arrays are returned beside.
    """
    arrays: dict[str, FloatArray] = {}
    given = dict(record["input"])
    for name in vector.archived if vector is not None else ():
        values = np.asarray(given[name], dtype=np.float64)
        if vector is not None and vector.raw:
            given[name] = {"f64": f"{vector.raw}.f64", "shape": list(values.shape)}
        else:
            given[name] = {"npz": Path(file).with_suffix(".npz").name, "array": f"{record['id']}.{name}"}
        arrays[str(archived(given[name]))] = values
    return {**record, "input": given}, arrays


def _write_text(text: str, path: Path) -> None:
    path.write_text(text, encoding="utf-8", newline="\n")


def _write_raw(values: FloatArray, path: Path) -> None:
    path.write_bytes(np.ascontiguousarray(values, dtype="<f8").tobytes())


def _write(folder: Path, file: str, entries: Sequence[Entry]) -> list[str]:
    """A file of entries and what lies beside it, if they have arrays: an npz, files of float64; the names written.

    Entries that share a file of float64 have to have the same numbers in it, else LeakrefError, and nothing is written.
    """
    if name := _disputed(entries):
        raise LeakrefError(
            "golden.regenerate",
            f"entries that share {name} have other numbers in it",
            "name all of them, so that all are made again, or give each file a name of its own",
        )
    content = {"schema": f"leakref/golden-entries/{SCHEMA_VERSION}", "entries": [dict(e.record) for e in entries]}
    write_whole(folder / file, partial(_write_text, _text(content) + "\n"))
    used = {archived(value): entry for entry in entries for value in entry.record["input"].values()}
    arrays = {name: entry.arrays[name] for name, entry in used.items() if name is not None}
    raw = {name: arrays.pop(name) for name in sorted(arrays) if name.endswith(".f64")}
    names = [file]
    for name, values in raw.items():
        names.append((Path(file).parent / name).as_posix())
        write_whole(folder / names[-1], partial(_write_raw, values))
    if arrays:
        names.append(Path(file).with_suffix(".npz").as_posix())
        ordered: dict[str, Any] = {name: arrays[name] for name in sorted(arrays)}
        write_whole(folder / names[-1], lambda path: np.savez(path, **ordered))
    return names


def _disputed(entries: Sequence[Entry]) -> str:
    """The name of a file of float64 of which the entries that share it do not have the same numbers; empty if none."""
    shared: dict[str, FloatArray] = {}
    for entry in entries:
        for name in filter(None, map(archived, entry.record["input"].values())):
            if not np.array_equal(shared.setdefault(name, entry.arrays[name]), entry.arrays[name]):
                return name
    return ""


def _number(folder: Path) -> int | None:
    """The number of the set in `folder`, by its manifest or by its name; None if neither says."""
    there = (folder / "manifest.json").is_file()
    name = Golden(folder)._json("manifest.json")["set"] if there else folder.resolve().name
    return int(name[1:]) if re.fullmatch(r"v[0-9]+", name) else None


def _extended(folder: Path, number: int | None) -> dict[str, Any]:
    """What a manifest says of the set that is extended: nothing if there is none, as for the first and for a copy that
    stands alone.
    """
    if (folder / "manifest.json").is_file():
        said = Golden(folder)._json("manifest.json").get("extends")
        return {} if said is None else {"extends": said}
    base = folder.resolve().parent / f"v{(number or 1) - 1}"
    if not (base / "manifest.json").is_file():
        return {}
    return {"extends": {"set": base.name, "sha256": Golden(base).manifest["sha256"]}}


def _write_manifest(folder: Path) -> None:
    """Say what the files of `folder` hold: digests, counts, licence, decisions."""
    golden, number = Golden(folder), _number(folder)
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
        of = len(ids(part, number=number))
        state = "complete" if entries >= of > 0 else "partial" if entries else "absent"
        parts.append({"name": part, "state": state, "entries": entries, "of": of, "values": values})
    files["schema.json"] = {"sha256": hashlib.sha256((folder / "schema.json").read_bytes()).hexdigest()}
    name = folder.name if number is None else f"v{number}"
    manifest = {
        "schema": f"leakref/golden-manifest/{SCHEMA_VERSION}",
        "set": name,
        **_extended(folder, number),
        "license": "CC0-1.0",
        "made_by": f"leakref {__version__}",
        "margin": MARGIN,
        "parts": parts,
        "decisions": {d.id: d.reference for d in DECISIONS.values()},
        "files": files,
    }
    manifest["sha256"] = digest(manifest)
    noted(write_whole(folder / "manifest.json", partial(_write_text, _text(manifest) + "\n")))


def regenerate(
    wanted: Sequence[str], folder: Path, *, work: Path | None = None, workers: int = 1, step: Step = lambda: None
) -> tuple[list[dict[str, Any]], bool]:
    """Compute entries, again or for the first time: rows saying what became of each, whether nothing is left open.

    Nothing wanted: all that the set itself holds; what differs is written beside the old file as `NAME.new.json` and
    not taken over. What it extends is another set's, and is not touched. An id that is named is written to the set,
    over the old one if there is one. A pattern such as `nsp-*`, or the name of a part such as `realizations`, adds what
    is missing and never replaces. Raises LeakrefError for an id that is none of the set's own. Each row has `id`,
    `change` (`same`, `new`, or which fields differ), `largest` (the largest change of a value), the same over its
    tolerance, and whether it was `written`. Entries that agree with the old ones within their tolerance are `same` and
    not written, since other processors round otherwise. `work` is where slow parts are kept; `step` is called after
    each entry. LeakrefError is also raised where routes disagree.
    """
    possible = ids(*SETS, number=_number(folder))
    golden = Golden(folder)
    there = (folder / "manifest.json").is_file()
    old = {entry.id: entry for entry in golden.own()} if there else {}
    before_it = {entry.id: entry for entry in golden.base.entries()} if there and golden.base else {}
    exact = [w for w in wanted if w in possible]
    meant = {
        w: list(ids(w, number=_number(folder))) if w in SETS else [i for i in possible if fnmatchcase(i, w)]
        for w in wanted
    }
    matching = [i for w in wanted if w not in possible for i in meant[w] if i not in old]
    for w in wanted:
        if not meant[w] and w not in SETS:
            fault, remedy = f"no golden value of this set is called {w!r}", "ids are listed in the manifest"
            if elsewhere := [n for n in sorted(TABLES) if any(fnmatchcase(i, w) for i in ids(*SETS, number=n))]:
                remedy = f"it is of golden/v{elsewhere[0]}: add --golden {elsewhere[0]}"
            raise LeakrefError("golden.regenerate", fault, f"define it in a table of leakref/golden first; {remedy}")
    chosen = list(dict.fromkeys([*exact, *matching])) if wanted else [i for i in possible if i in old]
    vectors = {v.id: v for members in VECTORS.values() for v in members}
    rows: list[dict[str, Any]] = []
    beside = dict(old)
    unsaved: set[str] = set()
    for record in make(chosen, old, work, workers, step):
        record = json.loads(json.dumps(to_json(record)))
        if record["stage"] == "ensemble":
            inherit(record, {**before_it, **old})
        record, arrays = _split(record, possible[record["id"]], vectors.get(record["id"]))
        new = Entry(possible[record["id"]], record, arrays, folder.name)
        before = old.get(new.id)
        if before is not None and agree(before, new):
            rows.append({"id": new.id, "change": "same", "largest": 0.0, "over_tolerance": 0.0, "written": False})
            continue
        take = new.id in exact or new.id in matching
        rows.append({"id": new.id, **_difference(before, new, take)})
        beside[new.id] = new
        if take:
            old[new.id] = new
            unsaved.add(new.file)
        if take and not _disputed([e for e in old.values() if e.file == new.file]):
            _save(folder, old, possible, new.file)  # at once: an interrupted run keeps what it has made
            _write_manifest(folder)
            unsaved.remove(new.file)
    for file in sorted(unsaved):  # of a cube that several share some were made and some not
        _save(folder, old, possible, file)
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
    """The file `file` anew, with all its entries in the order of the ids."""
    order = {identifier: n for n, identifier in enumerate(possible)}
    members = sorted((e for e in entries.values() if e.file == file), key=lambda e: order.get(e.id, len(order)))
    _write(folder, file, members)


def _difference(before: Entry | None, after: Entry, taken: bool) -> dict[str, Any]:
    """What changed between two records of one id: largest change of a value, over its tolerance, and other keys.
    Outputs of another shape, or with a number where there was none, are infinitely far apart.
    """
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

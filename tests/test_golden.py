"""The golden sets: whole, reproduced, impossible to change unseen, and sharp enough to see a constant off by 1 %."""

from __future__ import annotations

import hashlib
import json
import os
import shutil
import struct
import subprocess
import sys
from contextlib import contextmanager
from dataclasses import replace
from importlib import import_module
from importlib.abc import Loader, MetaPathFinder
from importlib.util import spec_from_loader
from pathlib import Path

import numpy as np
import pytest
from test_commands import here as command
from test_faults import PINNED

import leakref
from leakref import LeakrefError
from leakref._base import Damaged
from leakref.certify.commands import Request
from leakref.cli.base import NEWEST_GOLDEN
from leakref.golden import entries, ids, making, records, same, sets, verifying
from leakref.golden.defined import TABLES, VECTORS
from leakref.golden.digests import digest, strict
from leakref.golden.linting import lint
from leakref.golden.sets import Entry, Golden, compare
from leakref.golden.stages import STAGES
from leakref.methods import DEFAULT, METHODS
from leakref.window import WINDOWS

pytestmark = pytest.mark.stored
SET, NEW = (Path(str(sets.locate(number))) for number in (1, 2))
ALL = list(Golden().entries())
HOUSE = Path(leakref.__file__).parent
WITNESSED = (
    "jonswap-33",
    "doppler-turning",
    "spectrum-half-bin",
    "score-si",
    "derivatives-moving",
    "nsp-half-bin",
    "ls-threshold",
    "figures-hann",
    "dispersion-film",
    "doppler-exponential-equal",
    "kernel-depth-0.7",
    "depth-factor-film",
    "components-depth-0.7",
    "nsp-capillary",
    "ls-depth-0.7",
)


def of(*sets):
    return [pytest.param(e, id=e.id) for e in ALL if e.file.split("/")[0] in sets]


def some(values, reason):
    """At least one parameter, so that an empty part shows as a failure and not as nothing."""
    return values or [pytest.param(None, id=reason)]


# ---------------------------------------------------------------- the set as it is


def test_the_set_is_whole_and_unchanged():
    report = lint()
    assert report.ok, "\n".join(map(str, report.failures))
    states = {(row["set"], row["name"]): row["state"] for row in report.sets}
    assert states == {
        **{("v1", part): "complete" for part in sets.SETS},
        **{("v2", part): "complete" if part != "analytic" else "absent" for part in sets.SETS},
    }


FIRST = "839e42dabcc388f957bb898c2d2abf31706aa4ab8e3b96b41b72fd96abeafbd3"


def test_the_first_set_is_as_it_was_released():
    """Byte for byte: this is the digest of its manifest, and the manifest has those of all its files."""
    assert hashlib.sha256((SET / "manifest.json").read_bytes()).hexdigest() == FIRST
    assert lint(Golden(SET)).ok
    assert sorted(p.name for p in SET.iterdir()) == sorted([*sets.SETS, "manifest.json", "schema.json"])
    assert len(list(Golden(SET).entries())) == 438
    assert not [e.id for e in ALL if e.folder == "v1" and {"depth", "surface_tension"} & e.record["input"].keys()]


def test_the_second_set_holds_what_is_new_and_gives_the_first_as_well():
    new = Golden(NEW)
    assert new.manifest["extends"] == {"set": "v1", "sha256": Golden(SET).manifest["sha256"]}
    first, second = ({e.id for e in Golden(folder).own()} for folder in (SET, NEW))
    assert not first & second
    assert {e.id for e in new.entries()} == {e.id for e in ALL} == first | second
    assert len(ALL) == len(first) + len(second)
    for identifier in ("window-hann-7", "nsp-film"):
        assert new.entry(identifier).folder == ("v1" if identifier in first else "v2")
    assert {e.folder for e in new.file("vectors/nsp.json")} == {"v1", "v2"}
    assert {e.folder for e in Golden(SET).file("vectors/nsp.json")} == {"v1"}
    with pytest.raises(LeakrefError, match="no golden value is called"):
        Golden(SET).entry("nsp-film")
    assert ids.ids(*sets.SETS, number=1).keys() == first
    assert ids.ids(*sets.SETS, number=2).keys() == second
    assert ids.ids(*sets.SETS).keys() == first | second


def test_the_newest_set_is_what_is_used_where_none_is_named():
    assert sets.NEWEST == NEWEST_GOLDEN == max(TABLES) == Request("reference", None).golden
    assert Golden().folder.name == "v2"
    assert sorted(p.name for p in NEW.parent.iterdir() if p.name.startswith("v")) == ["v1", "v2"]


def test_water_is_in_every_stage_that_it_enters():
    """At every depth, with tension, in every way that a velocity is found."""
    water = [e for e in ALL if {"depth", "surface_tension"} & e.record["input"].keys()]
    by_stage = {}
    for e in water:
        by_stage.setdefault(e.stage, []).append(e)
    assert set(by_stage) == {
        "dispersion", "resolutions", "kernel", "doppler", "depth-factor", "water-units", "components", "shell",
        "characteristic", "score", "derivatives", *METHODS, "extract", "realization", "ensemble",
    }  # fmt: skip
    for stage in ("dispersion", "kernel", "doppler", "depth-factor", "components", "nsp", "ls", "extract"):
        assert {0.7, 1.2, 2.0} <= {e.record["input"].get("depth") for e in by_stage[stage]}, stage
    for stage in ("dispersion", "shell", "characteristic", "score", "nsp", "ls", "extract"):
        si = [e.record["input"] for e in by_stage[stage] if e.record["input"].get("surface_tension")]
        k = np.concatenate([np.atleast_1d(given.get("wavenumbers", given.get("wavenumber"))) for given in si])
        assert ((k > 2 * np.pi / 0.1 - 1) & (k < 2 * np.pi / 0.02 + 1)).all()  # 2 to 10 cm


def test_there_are_cubes_of_all_windows_and_methods():
    cubes = [e for e in ALL if e.stage == "extract"]
    assert len(cubes) >= 20
    deep = [e for e in cubes if not {"depth", "surface_tension"} & e.record["input"].keys()]
    assert {(e.record["input"]["window"], e.record["input"]["method"]) for e in deep} == {
        (window, method) for window in WINDOWS for method in ("nsp", "ls")
    }


@pytest.mark.parametrize(("folder", "most"), [("vectors", 1.5e6), ("realizations", 1.2e4), ("ensembles", 1.1e4)])
def test_the_second_set_stays_small(folder, most):
    """The vectors in all, of everything else an entry: each method adds as many of these."""
    files = [path for path in (NEW / folder).iterdir() if path.is_file()]
    entries = 1 if folder == "vectors" else sum(e.folder == "v2" and e.stage == folder[:-1] for e in ALL)
    assert sum(path.stat().st_size for path in files) < most * entries


def test_a_raw_surface_is_what_its_name_and_shape_say():
    """Little-endian float64, eta[x][y][t] with t running fastest."""
    for e in (e for e in ALL if e.stage == "extract" and e.folder == "v2"):
        said = e.record["input"]["surface"]
        raw = (NEW / "vectors" / said["f64"]).read_bytes()
        assert said["shape"] == e.record["input"]["shape"]
        assert len(raw) == 8 * np.prod(said["shape"])
        x, y, t = 3, 2, 5
        _, ny, nt = said["shape"]
        (value,) = struct.unpack_from("<d", raw, 8 * ((x * ny + y) * nt + t))
        assert value == e.input["surface"][x, y, t]
        dx, dy, dt = e.record["input"]["spacing"]
        kx, ky, omega, a, phase = (np.array(e.input[n]) for n in ("kx", "ky", "omega", "amplitude", "phase"))
        assert value == pytest.approx(np.sum(a * np.cos(kx * x * dx + ky * y * dy - omega * t * dt + phase)), abs=1e-12)


def test_every_stage_has_vectors_and_every_named_fault_a_vector_that_exists_for_it():
    vectors = [e for e in ALL if e.file.startswith("vectors/")]
    assert len(vectors) >= 60
    assert {e.stage for e in ALL} >= set(STAGES)
    assert {fault for e in vectors for fault in e.record["faults"]} >= set(PINNED)
    assert {e.record["difficulty"] for e in vectors} == {"easy", "moderate", "hard"}


def test_every_value_has_a_second_route_and_the_digits_it_promises():
    for e in ALL:
        if e.stage != "ensemble":  # route B, as the realisations by both
            assert e.record["origin"]["confirmed_by"], e.id
        if e.stage in STAGES:
            assert min(a["digits"] for a in e.record["accuracy"].values()) >= 13 or not e.values, e.id


def test_the_definitions_are_those_the_set_was_made_from():
    made = {e.id: e for e in ALL}
    for vector in (v for members in VECTORS.values() for v in members):
        e = made[vector.id]
        assert (e.record["purpose"], e.record["faults"]) == (vector.purpose, list(vector.faults)), vector.id
        assert set(e.record["input"]) == set(vector.input)
        for name, value in same.given(vector, e).items():
            assert value is e.input[name], (vector.id, name)  # the definition is that but for rounding


@pytest.mark.parametrize("entry", of("vectors", "analytic"))
def test_the_chain_reproduces(entry):
    failures = verifying.verify_entry(entry)
    assert not failures, "\n".join(map(str, failures))


@pytest.mark.parametrize("entry", [p for p in of("vectors", "analytic") if p.id in WITNESSED])
def test_the_oracle_with_40_digits_reproduces(entry):
    failures = verifying.verify_entry(entry, with_oracle=True)
    assert not failures, "\n".join(map(str, failures))


def realizations(quick):
    return [p for p in of("realizations") if verifying._is_quick(p.values[0]) == quick]


@pytest.mark.parametrize("entry", some(realizations(True), "not in the set"))
def test_a_paper_case_is_reproduced(entry):
    if entry is None:  # then the set has to say so
        part = next(p for p in Golden().manifest["parts"] if p["name"] == "realizations")
        assert part["state"] in ("absent", "partial")
        return
    failures = verifying._verify_realizations([entry], False, None, 1, lambda: None)
    assert not failures, "\n".join(map(str, failures))


@pytest.mark.slow
@pytest.mark.parametrize("entry", some(realizations(False), "not in the set"))
def test_every_paper_case_is_reproduced(entry):
    test_a_paper_case_is_reproduced(entry)


@pytest.mark.night
def test_every_ensemble_is_reproduced(tmp_path):
    entries = [e for e in ALL if e.stage == "ensemble"]
    part = next(p for p in Golden().manifest["parts"] if p["name"] == "ensembles")
    assert len(entries) == part["entries"]
    failures = verifying._verify_ensembles(entries, "B", tmp_path, 2, lambda: None)
    assert not failures, "\n".join(map(str, failures))


# ---------------------------------------------------------------- comparing


def entry(**record):
    base = {
        "id": "the-id",
        "stage": "window",
        "purpose": "a test",
        "input": {},
        "output": {"v": [1.0, 2.0]},
        "accuracy": {"v": {"digits": 15.0, "conditioning": 1.0, "tolerance": sets.tolerance(1.0)}},
    }
    return Entry("vectors/x.json", {**base, **record})


@pytest.mark.parametrize(
    ("found", "said"),
    [
        ({"v": [1.0, 2.0 + 2e-14]}, "v[1] is 2.00000000000002"),
        ({"v": [np.nan, 2.0]}, "v[0] is nan"),
        ({"v": [1.0]}, "has shape (1,)"),
        ({}, "v is missing"),
        ({"v": [np.inf, 2.0]}, "v[0] is inf"),
    ],
)
def test_what_differs_is_named(found, said):
    (failure,) = compare(entry(), found)
    assert failure.id == "the-id"
    assert said in failure.message


def test_within_the_tolerance_is_the_same_and_null_wants_no_number():
    assert not compare(entry(), {"v": [1.0, 2.0 + sets.tolerance(0.9)]})
    null = entry(output={"v": [1.0, None]})
    assert not compare(null, {"v": [1.0, np.nan]})
    assert compare(null, {"v": [1.0, 0.0]})
    assert compare(null, {"v": [np.nan, np.nan]})


def test_the_formula_of_the_tolerance():
    assert sets.tolerance(3.0) == 8 * 2.0**-52 * 3.0
    assert sets.agreed_digits(0.0, 1.0) == 15.6
    assert sets.agreed_digits(1e-9, 10.0) == 10.0


# ---------------------------------------------------------------- protection


@pytest.fixture
def copy(tmp_path):
    """The first set, by itself."""
    target = tmp_path / "v1"
    shutil.copytree(SET, target)
    return target


@pytest.fixture
def both(tmp_path):
    """Both sets; the folder of the second."""
    for folder in (SET, NEW):
        shutil.copytree(folder, tmp_path / folder.name)
    return tmp_path / "v2"


def leaves(value, path=()):
    """Paths to all numbers in nested JSON."""
    if isinstance(value, dict | list):
        for key, item in value.items() if isinstance(value, dict) else enumerate(value):
            yield from leaves(item, (*path, key))
    elif isinstance(value, int | float) and not isinstance(value, bool):
        yield path


def nudged(record, path):
    """The record with the number at `path` moved by as little as its text shows."""
    record = json.loads(json.dumps(record))
    inside = record
    for key in path[:-1]:
        inside = inside[key]
    old = inside[path[-1]]
    inside[path[-1]] = old + 1 if isinstance(old, int) else float(np.nextafter(old, np.inf))
    return record


FILES = sorted({e.file for e in ALL if e.folder == "v1"})
NEW_FILES = sorted({e.file for e in ALL if e.folder == "v2"})


def changes(file, count, folder=SET):
    """(id, path, content) for some numbers of a file, evenly over all of them."""
    content = json.loads((folder / file).read_text(encoding="utf-8"))
    paths = list(leaves(content["entries"]))
    for path in [paths[n] for n in np.linspace(0, len(paths) - 1, count).astype(int)]:
        changed = {**content, "entries": nudged(content["entries"], path)}
        yield content["entries"][path[0]]["id"], path, changed


def assert_seen(files, copy, count, folder=SET):
    """One number of each file changed at a time: lint names those ids and no other."""
    for together in zip(*(changes(file, count, folder) for file in files), strict=True):
        for file, (_, _, changed) in zip(files, together, strict=True):
            (copy / file).write_text(making._text(changed) + "\n", encoding="utf-8")
        failures = lint(Golden(copy)).failures
        assert {f.id for f in failures} == {identifier for identifier, _, _ in together}, (together, failures)


@pytest.mark.parametrize("file", ["vectors/window.json", "realizations/U.json", "ensembles/U.json"])
def test_changing_one_number_is_seen_and_named(file, copy):
    assert_seen([file], copy, 2)


def test_changing_a_number_of_every_file_is_seen_and_named(copy):
    assert_seen(FILES, copy, 5)


def test_changing_a_number_of_every_file_of_the_second_set_is_seen_and_named(both):
    assert_seen(NEW_FILES, both, 3, NEW)


def test_changing_a_number_of_the_first_set_is_seen_through_the_second(both):
    path = both.parent / "v1" / "vectors" / "window.json"
    path.write_bytes(path.read_bytes().replace(b"0.1882550990706332", b"0.1882550990806332"))
    assert {f.id for f in lint(Golden(both)).failures} == {"window-hann-7"}
    with pytest.raises(Damaged, match=r"vectors/window\.json was changed"):
        list(Golden(both).entries())


def test_a_second_set_without_its_first_or_with_another_is_refused(both):
    manifest = json.loads((both.parent / "v1" / "manifest.json").read_text(encoding="utf-8"))
    said = {**{k: v for k, v in manifest.items() if k != "sha256"}, "made_by": "leakref 9"}
    path = both.parent / "v1" / "manifest.json"
    path.write_text(json.dumps({**said, "sha256": digest(said)}), encoding="utf-8")
    (failure,) = lint(Golden(both)).failures
    assert "v1 is another than the one that v2 extends" in failure.message
    shutil.rmtree(both.parent / "v1")
    (failure,) = lint(Golden(both)).failures
    assert "what it extends cannot be trusted" in failure.message
    with pytest.raises(Damaged):
        Golden(both).entry("nsp-film")


def test_an_id_of_the_first_set_is_not_used_again_in_the_second(both):
    path = both / "vectors" / "nsp.json"
    path.write_text(path.read_text(encoding="utf-8").replace('"nsp-film"', '"nsp-si"'), encoding="utf-8")
    making._write_manifest(both)
    assert ("nsp-si", "is there twice, in v1/vectors/nsp.json and in v2/vectors/nsp.json") in {
        (f.id, f.message) for f in lint(Golden(both)).failures
    }


@pytest.mark.parametrize("harm", ["a bit", "cut", "missing", "added"])
def test_a_raw_surface_that_was_changed_is_seen_and_not_read(harm, both):
    path = both / "vectors" / "extract-film.f64"
    content = bytearray(path.read_bytes())
    if harm == "a bit":
        content[len(content) // 2] ^= 1
    path.write_bytes(content[: len(content) - 8 * (harm == "cut")] + b"12345678" * (harm == "added"))
    if harm == "missing":
        path.unlink()
    failures = lint(Golden(both)).failures
    assert "extract-film" in " ".join(map(str, failures)), failures
    with pytest.raises(Damaged, match=r"extract-film\.f64 (was changed|cannot be read)"):
        Golden(both).entry("extract-film-hann-nsp")


@pytest.mark.night
def test_changing_any_of_many_numbers_is_seen_and_named(copy):
    assert_seen(FILES, copy, 40)


def test_changing_a_number_of_an_archive_is_seen_and_named(copy):
    path = copy / "vectors" / "extract.npz"
    with np.load(path) as stored:
        arrays = {name: stored[name] for name in stored.files}
    name = "extract-cube-nsp.surface"
    arrays[name][3, 4, 5] = np.nextafter(arrays[name][3, 4, 5], 9)
    np.savez(path, **arrays)
    failures = lint(Golden(copy)).failures
    assert {f.id for f in failures} >= {"extract-cube-nsp"}
    arrays.pop(name)
    np.savez(path, **arrays)
    assert "extract-cube-nsp" in {f.id for f in lint(Golden(copy)).failures}


def test_every_number_of_the_manifest_is_protected(copy):
    content = json.loads((SET / "manifest.json").read_text(encoding="utf-8"))
    for path in list(leaves(content))[::7]:
        (copy / "manifest.json").write_text(json.dumps(nudged(content, path)), encoding="utf-8")
        assert not lint(Golden(copy)).ok, path
    row = content["files"]["vectors/window.json"]["entries"]
    row["window-hann-7"] = "0" * 64
    (copy / "manifest.json").write_text(json.dumps(content), encoding="utf-8")
    assert "window-hann-7" in {f.id for f in lint(Golden(copy)).failures}


@pytest.mark.parametrize(
    ("harm", "named"),
    [
        (lambda folder: (folder / "vectors/window.json").unlink(), "vectors/window.json"),
        (lambda folder: (folder / "manifest.json").unlink(), "manifest.json"),
        (lambda folder: (folder / "schema.json").write_text("{}"), "schema.json"),
        (lambda folder: (folder / "manifest.json").write_text("{}"), "manifest.json"),
        (lambda folder: (folder / "vectors/window.json").write_text("{"), "vectors/window.json"),
        (lambda folder: (folder / "vectors/mine.json").write_text("{}"), "vectors/mine.json"),
        (lambda folder: swap(folder, '"digits": 15.6', '"digits": NaN'), "vectors/window.json"),
        (
            lambda folder: swap(folder, '"stage": "window"', '"stage": "window", "stage": "other"'),
            "vectors/window.json",
        ),
        (lambda folder: swap(folder, '"purpose": "p', '"purpose": "", "was": "p'), "window-box-7"),
        (lambda folder: swap(folder, '"id": "window-hann-7"', '"id": "window-box-7"'), "window-hann-7"),
        (lambda folder: swap(folder, "1.4210854715202004e-14", "1.5e-14"), "window-box-7"),
        (lambda folder: swap(folder, "{\n", "{\n\n"), "vectors/window.json"),
    ],
)
def test_a_set_that_was_harmed_fails_and_is_never_skipped(harm, named, copy):
    harm(copy)
    report = lint(Golden(copy))
    assert not report.ok
    assert named in {f.id for f in report.failures}, report.failures


def swap(folder, old, new):
    path = folder / "vectors/window.json"
    text = path.read_text(encoding="utf-8")
    assert old in text
    path.write_text(text.replace(old, new, 1), encoding="utf-8")


@pytest.mark.parametrize("encoding", ["utf-16", "utf-32", "utf-8-sig", "latin-1"])
def test_a_golden_file_is_utf_8_and_nothing_else(encoding):
    with pytest.raises(Damaged, match="is not strict JSON"):
        strict("a.json", '{"words": "é"}'.encode(encoding))


@pytest.mark.parametrize("name", ["", "nonsense", "ensemble-nonsense/hann-nsp", "realization-L-T/L=6,T=10/0"])
def test_an_id_that_names_no_configuration_is_refused(name):
    with pytest.raises(LeakrefError, match="names no configuration"):
        ids.configuration_of(name)


# ---------------------------------------------------------------- making


def put_in_place(monkeypatch, name, value):
    """Another value of a constant in every module that makes golden values."""
    for module in (ids, entries, records, making, verifying):
        if hasattr(module, name):
            monkeypatch.setattr(module, name, value)


def test_writing_what_was_read_gives_the_same_bytes(tmp_path):
    for folder, files in ((SET, FILES), (NEW, NEW_FILES)):
        written = []
        for file in files:
            own = [e for e in ALL if (e.folder, e.file) == (folder.name, file)]
            written += making._write(tmp_path / folder.name, file, own)
        for name in written:
            assert (tmp_path / folder.name / name).read_bytes() == (folder / name).read_bytes(), name
        there = {path.relative_to(folder).as_posix() for path in folder.rglob("*") if path.is_file()}
        assert there == {*written, "manifest.json", "schema.json"}


def test_entries_that_share_a_surface_have_to_have_the_same(tmp_path):
    first, second = (e for e in ALL if e.id in ("extract-lake-hann-nsp", "extract-lake-hann-ls"))
    other = replace(second, arrays={"extract-lake.f64": second.arrays["extract-lake.f64"] + 1})
    with pytest.raises(LeakrefError, match=r"share extract-lake\.f64 have other numbers"):
        making._write(tmp_path, "vectors/extract.json", [first, other])
    assert not list(tmp_path.iterdir())


def test_a_cube_is_replaced_for_all_that_share_it_or_for_none(both, monkeypatch):
    """Its surface is another one: 1e-3 of it, where 1e-12 is rounding."""
    louder = {
        part: tuple(
            replace(v, input={**v.input, "surface": np.asarray(v.input["surface"]) * 1.001})
            if v.raw == "extract-lake"
            else v
            for v in members
        )
        for part, members in VECTORS.items()
    }
    put_in_place(monkeypatch, "VECTORS", louder)
    monkeypatch.setitem(STAGES, "extract", replace(STAGES["extract"], oracle=None))
    before = {path: path.read_bytes() for path in both.rglob("*") if path.is_file()}
    with pytest.raises(LeakrefError, match="name all of them"):
        making.regenerate(["extract-lake-hann-nsp"], both)
    assert {path: path.read_bytes() for path in both.rglob("*") if path.is_file()} == before
    rows, _ = making.regenerate(["extract-lake-hann-nsp", "extract-lake-hann-ls"], both)
    assert [row["written"] for row in rows] == [True, True]
    assert lint(Golden(both)).ok
    scaled = Golden(both).entry("extract-lake-hann-ls").input["surface"]
    np.testing.assert_allclose(scaled, 1.001 * Golden().entry("extract-lake-hann-ls").input["surface"])


def test_an_entry_more_is_a_row_in_a_table(both, monkeypatch):
    """Of a vector; of realisations and ensembles by another method a row of `ids.SEAS`. Nothing else is to be done."""
    row = replace(next(v for v in VECTORS["vectors"] if v.id == "nsp-film"), id="nsp-film-again")
    more = {**TABLES, 2: {**TABLES[2], "vectors": (*TABLES[2]["vectors"], row)}}
    monkeypatch.setattr(ids, "TABLES", more)
    put_in_place(monkeypatch, "VECTORS", {**VECTORS, "vectors": (*VECTORS["vectors"], row)})
    rows, settled = making.regenerate(["vectors"], both)
    assert settled
    assert [(r["id"], r["change"], r["written"]) for r in rows] == [("nsp-film-again", "new", True)]
    assert lint(Golden(both)).ok
    assert Golden(both).entry("nsp-film-again").output["velocities"] == pytest.approx(
        Golden().entry("nsp-film").output["velocities"]
    )
    own = ids.Seas(2, ids.SEAS[0].configurations[:1], ("other",), "others")
    monkeypatch.setattr(ids, "SEAS", (*ids.SEAS, own))
    found = ids.ids("realizations", "ensembles", number=2)
    assert {i for i in found if "nsp-ls" in i and "other" in i} == {
        "realization-nsp-ls/others/0", "realization-nsp-ls/others/1",
        "ensemble-nsp-ls/box-other", "ensemble-nsp-ls/hann-other",
    }  # fmt: skip
    for identifier in found:
        more = [name for name in METHODS if name not in DEFAULT]
        ending = tuple(f"/{m}/{n}" for m in more for n in (0, 1)) + tuple(f"-{m}" for m in more)
        if not identifier.endswith(ending):
            assert ids.methods_of(identifier) == (("other",) if "other" in identifier else DEFAULT)
        assert ids.configuration_of(identifier).id in identifier
    assert ids.methods_of("realization-nsp-ls/0") == ids.methods_of("ensemble-nsp-ls/box-ls") == ("nsp", "ls")
    assert ids.certified_ids(own.configurations[0], "other")[1] == "realization-nsp-ls/others/1"


def test_what_belongs_to_the_first_set_is_not_written_into_the_second(both):
    before = {path: path.read_bytes() for path in both.rglob("*") if path.is_file()}
    with pytest.raises(LeakrefError, match=r"it is of golden/v1: add --golden 1"):
        making.regenerate(["window-hann-7"], both)
    assert making.regenerate(["analytic"], both) == ([], True)
    making._write_manifest(both)
    assert {path: path.read_bytes() for path in both.rglob("*") if path.is_file()} == before


@pytest.fixture
def small(tmp_path):
    """A set of two vectors."""
    folder = tmp_path / "v1"
    folder.mkdir()
    shutil.copy(SET / "schema.json", folder)
    rows, settled = making.regenerate(["grid-paper", "window-hann-7"], folder)
    assert settled
    assert [row["change"] for row in rows] == ["new", "new"]
    assert lint(Golden(folder)).ok
    return folder


def test_only_what_is_named_is_replaced(small):
    folder = small
    assert Golden(folder).entry("window-hann-7").record == Golden().entry("window-hann-7").record
    path = folder / "vectors/window.json"
    whole = path.read_bytes()
    path.write_bytes(whole.replace(b"0.1882550990706332", b"0.1882550990806332"))
    making._write_manifest(folder)  # as if somebody had covered it up
    edited = path.read_bytes()
    assert lint(Golden(folder)).ok
    assert not verifying.verify(Golden(folder)).ok
    rows, settled = making.regenerate([], folder)
    assert not settled
    (row,) = (row for row in rows if row["change"] != "same")
    assert (row["id"], row["written"]) == ("window-hann-7", False)
    assert row["largest"] == pytest.approx(1e-11, rel=1e-3)
    assert path.read_bytes() == edited
    assert (folder / "vectors/window.new.json").read_bytes() == whole
    making.regenerate(["window-hann-*"], folder)  # a pattern adds, and does not replace
    assert b"0.1882550990806332" in path.read_bytes()
    making.regenerate(["window-hann-7"], folder)
    assert b"0.1882550990806332" not in path.read_bytes()
    with pytest.raises(LeakrefError, match="no golden value of this set is called 'nonsense'"):
        making.regenerate(["nonsense"], folder)


def test_what_was_changed_is_not_covered_up_by_making_something_else(small):
    path = small / "vectors/window.json"
    path.write_bytes(path.read_bytes().replace(b"0.1882550990706332", b"0.1882550990806332"))
    edited = path.read_bytes()
    with pytest.raises(Damaged, match=r"vectors/window\.json was changed"):
        making.regenerate(["grid-small"], small)
    assert path.read_bytes() == edited
    assert {f.id for f in lint(Golden(small)).failures} == {"window-hann-7"}


def test_what_was_made_before_an_interruption_is_whole(small, monkeypatch):
    make = entries.vector_record
    monkeypatch.setattr(
        entries, "vector_record", lambda v, *rest: {}["gone"] if v.id == "grid-small" else make(v, *rest)
    )
    with pytest.raises(KeyError, match="gone"):
        making.regenerate(["grid-rounded", "grid-small"], small)
    assert lint(Golden(small)).ok
    assert Golden(small).entry("grid-rounded").values


# ---------------------------------------------------------------- other processors

SOME = ("jonswap-33", "surface-scattered", "nsp-half-bin", "components-rotated", "shell-just-inside", "figures-hann")


def set_of(ids, folder):
    """A set of some entries as they are in the true one of that name."""
    folder.mkdir()
    shutil.copy(SET.parent / folder.name / "schema.json", folder)
    chosen = [e for e in ALL if e.id in ids and e.folder == folder.name]
    for file in sorted({e.file for e in chosen}):
        making._write(folder, file, [e for e in chosen if e.file == file])
    making._write_manifest(folder)
    return folder


@pytest.fixture
def some_vectors(tmp_path):
    return set_of(SOME, tmp_path / "v1")


def rounded(value, relative):
    """Numbers moved by a few units of the last place, or by more."""
    if isinstance(value, dict):
        return {key: rounded(item, relative) for key, item in value.items()}
    if isinstance(value, list):
        return [rounded(item, relative) for item in value]
    return value * (1 + relative) if isinstance(value, float) else value


def redefined(monkeypatch, relative):
    """All inputs of vectors as they would be computed elsewhere."""
    put_in_place(
        monkeypatch,
        "VECTORS",
        {
            part: tuple(replace(v, input=rounded(v.input, relative)) for v in members)
            for part, members in VECTORS.items()
        },
    )


def test_inputs_that_are_rounded_otherwise_are_read_and_nothing_is_proposed(some_vectors, monkeypatch):
    before = {path: path.read_bytes() for path in some_vectors.rglob("*") if path.is_file()}
    redefined(monkeypatch, 2.0**-52)
    rows, settled = making.regenerate([], some_vectors)
    assert settled
    assert {row["id"]: row["change"] for row in rows} == dict.fromkeys(SOME, "same")
    making.regenerate(SOME[:2], some_vectors)  # nor is it written where it is named
    assert {path: path.read_bytes() for path in some_vectors.rglob("*") if path.is_file()} == before


def test_an_archived_surface_is_read_and_not_made_again(tmp_path):
    """Unless its definition is another one."""
    vector = next(v for v in VECTORS["vectors"] if v.id == "extract-cube-ls")
    e = Golden().entry(vector.id)
    for moved, is_read in ((0.5, True), (2.0, False)):
        surface = (np.array(vector.input["surface"]) + moved * same.archived_tolerance(vector)).tolist()
        found = same.given(replace(vector, input={**vector.input, "surface": surface}), e)["surface"]
        assert (found is e.input["surface"]) == is_read
    assert same.archived_tolerance(vector) < 1e-11


def test_inputs_that_are_others_are_proposed(some_vectors, monkeypatch):
    redefined(monkeypatch, 1e-9)
    rows, settled = making.regenerate([], some_vectors)
    assert not settled
    assert {row["id"] for row in rows if row["change"] != "same"} == {
        e.id for e in ALL if e.id in SOME and any(np.asarray(v).dtype.kind == "f" for v in e.input.values())
    }


def test_what_is_the_same_and_what_is_not():
    e = Golden().entry("nsp-narrow")

    def other(change):
        record = json.loads(json.dumps(e.record))
        change(record)
        return Entry(e.file, record, e.arrays)

    room = float(np.max(e.tolerance("velocities")))
    moved = {
        share: other(
            lambda r, share=share: r["output"]["velocities"][0].__setitem__(
                0, r["output"]["velocities"][0][0] + share * room
            )
        )
        for share in (0.1, 10)
    }
    assert same.agree(e, moved[0.1])
    assert not same.agree(e, moved[10])
    said = e.record["accuracy"]["velocities"]
    for change, agrees in (
        (lambda r: r["accuracy"]["velocities"].update(digits=14.0), True),
        (
            lambda r: r["accuracy"]["velocities"].update(conditioning=[c * (1 + 1e-12) for c in said["conditioning"]]),
            True,
        ),
        (lambda r: r["accuracy"]["velocities"].update(conditioning=[c * 1.001 for c in said["conditioning"]]), False),
        (lambda r: r.update(purpose="another"), False),
        (lambda r: r["output"].update(more=[1.0]), False),
        (lambda r: r["input"].update(window="box"), False),
        (lambda r: r["input"].update(gravity=1.001), False),
        (lambda r: r["input"].pop("gravity"), False),
        (lambda r: r["notes"].__setitem__(0, ["flat"]), False),
        (lambda r: r["output"]["velocities"].__setitem__(0, [None, None]), False),
    ):
        assert same.agree(e, other(change)) == agrees


def test_one_conditioning_stands_for_the_same_of_each_item():
    record = next(e.record for e in ALL if e.folder == "v2" and e.stage == "ensemble")
    n, one = len(record["output"]["bias"]), record["accuracy"]["bias"]["conditioning"]
    assert isinstance(one, float)  # written once where it is the same for all
    for conditioning, written in (([2.0, 2.0], 2.0), ([2.0, 3.0], [2.0, 3.0]), ([2.0], [2.0]), (2.0, 2.0)):
        values = np.zeros(np.shape(conditioning))
        assert records._accuracy("v", "x", values, {}, conditioning)["conditioning"] == written

    def entry(conditioning):
        told = {**record["accuracy"]["bias"], "conditioning": conditioning}
        return sets.Entry("x.json", {**record, "accuracy": {**record["accuracy"], "bias": told}})

    for conditioning, agrees in (
        ([one] * n, True),
        (one * 1.001, False),
        ([one] * (n - 1) + [one * 1.001], False),
    ):
        assert same.agree(entry(one), entry(conditioning)) == same.agree(entry(conditioning), entry(one)) == agrees
    assert not same.agree(entry([one] * n), entry([one] * (n - 1)))


@pytest.mark.parametrize(
    ("a", "b", "alike"),
    [
        (1.0, 1 + 2.0**-52, True),
        (1.0, 1 + 2.0**-48, False),
        ([0.0, 1.0], [1e-300, 1.0], False),
        (1, 1.0, True),
        ([1.0, None], [1.0, None], True),
        ([1.0, None], [1.0, 0.0], False),
        ({"a": [1.0]}, {"a": [1 + 2.0**-52]}, True),
        ({"a": 1}, {"b": 1}, False),
        ("1", 1, False),
        (True, 1, False),
        (["box", 1.0], ["box", 1 + 2.0**-52], True),
        (["box"], ["hann"], False),
        ([[1.0], [2.0, 3.0]], [[1.0], [2.0, 3.0]], True),
        ([[1.0], [2.0, 3.0]], [[1.0]], False),
        ([1.0], [1.0, 1.0], False),
        (None, 0.0, False),
    ],
)
def test_alike_but_for_rounding(a, b, alike):
    assert same.alike(a, b) == same.alike(b, a) == alike


ELSEWHERE = """
import sys
from dataclasses import replace
from pathlib import Path
from leakref.golden.sets import Golden
from leakref.golden.linting import lint
from leakref.golden import entries, making, same, verifying
from leakref.golden.stages import STAGES
folder, kept = Path(sys.argv[1]), sys.argv[2:]
true = entries.vector_record
def without_oracle(vector, before):
    stage = STAGES[vector.stage]
    if stage.oracle is None:
        return true(vector, before)
    STAGES[vector.stage] = replace(stage, oracle=lambda given, first: {**first, **before.output})
    record, STAGES[vector.stage] = true(vector, before), stage
    return record
if kept:
    entries.vector_record = without_oracle
made = {e.id: e for e in Golden().entries()}
for vector in (v for members in making.VECTORS.values() for v in members):
    found = same.given(vector, made[vector.id])
    assert all(value is made[vector.id].input[name] for name, value in found.items()), vector.id
rows, settled = making.regenerate([], folder)
assert settled, [row for row in rows if row["change"] != "same"]
assert lint(Golden(folder)).ok and verifying.verify(Golden(folder)).ok
"""


def elsewhere(kernel, folder, *kept):
    """By other kernels of the linear algebra library, as older processors have them.

    `kept`: with the 40 digits as they are kept. They use no such library, and take minutes.
    """
    env = {**os.environ, "OPENBLAS_CORETYPE": kernel}
    done = subprocess.run([sys.executable, "-c", ELSEWHERE, folder, *kept], env=env, capture_output=True, text=True)
    assert done.returncode == 0, done.stderr


@pytest.mark.parametrize("kernel", ["Prescott", "Haswell"])
def test_on_another_processor_nothing_is_proposed(kernel, some_vectors):
    elsewhere(kernel, some_vectors)


WET = ("dispersion-film", "doppler-turning-depth", "components-depth-0.7", "nsp-lake", "extract-depth-0.7-hann-nsp")


@pytest.mark.parametrize("kernel", ["Prescott", "Haswell"])
def test_on_another_processor_nothing_of_the_second_set_is_proposed(kernel, tmp_path):
    elsewhere(kernel, set_of(WET, tmp_path / "v2"))


@pytest.mark.slow
@pytest.mark.parametrize("name", ["v1", "v2"])
@pytest.mark.parametrize("kernel", ["Prescott", "Nehalem", "Haswell"])
def test_on_another_processor_nothing_of_all_stages_is_proposed(kernel, name, tmp_path):
    ids = {e.id for e in ALL if e.stage in STAGES} | {f"realization-L-T/L=5,T=10/{n}" for n in (0, 1)}
    elsewhere(kernel, set_of(ids, tmp_path / name), "kept")


def test_routes_that_disagree_make_nothing(monkeypatch, tmp_path):
    shutil.copy(SET / "schema.json", tmp_path)
    stage = STAGES["window"]
    wrong = replace(stage, routes={"chain": lambda g: {"w": np.ones(g["size"])}})
    monkeypatch.setitem(STAGES, "window", wrong)
    with pytest.raises(LeakrefError, match=r"window-hann-7: route chain differs in w by"):
        making.regenerate(["window-hann-7"], tmp_path)
    assert not (tmp_path / "vectors").exists()


@pytest.fixture(scope="module")
def work(tmp_path_factory):
    """Where what is slow to make is found again."""
    return tmp_path_factory.mktemp("work")


def test_a_realisation_is_made_by_both_routes_and_found_again_when_interrupted(small, tmp_path, work, monkeypatch):
    name = "realization-L-T/L=5,T=10/0"
    making.regenerate([name], small, work=work)
    assert lint(Golden(small)).ok
    entry = Golden(small).entry(name)
    assert entry.record["origin"] == {"values": "A", "confirmed_by": ["B"]}
    assert set(entry.output) == {f"{w}_{m}" for w in ("box", "hann") for m in ("nsp", "ls")}
    assert min(a["digits"] for a in entry.record["accuracy"].values()) > 12
    for key, notes in entry.record["notes"].items():
        plain = np.array([not said for said in notes])
        assert np.nanmax(np.asarray(entry.record["accuracy"][key]["tolerance"], dtype=float)[plain]) <= 1.001e-11
    assert verifying.verify(Golden(small), full=True, work=tmp_path).ok

    def made_again(*_):
        raise AssertionError("it was there")

    monkeypatch.setattr(entries, "_realization", made_again)
    rows, _ = making.regenerate([name], small, work=tmp_path)
    assert rows[0]["change"] == "same"
    path = small / "realizations/L-T.json"
    value = entry.record["output"]["hann_nsp"][3][1]
    path.write_text(path.read_text(encoding="utf-8").replace(repr(value), repr(value + 1e-10)), encoding="utf-8")
    assert {f.id for f in lint(Golden(small)).failures} == {name}
    making._write_manifest(small)
    (failure,) = verifying.verify(Golden(small)).failures
    assert failure.id == name
    assert "hann_nsp[3, 1]" in failure.message


def test_ensembles_are_made_and_checked(small, tmp_path, work, monkeypatch):
    put_in_place(monkeypatch, "REALIZATIONS", 2)
    one_each = tuple(replace(row, certified=(0,)) for row in ids.SEAS)
    monkeypatch.setattr(ids, "SEAS", one_each)
    with pytest.raises(LeakrefError, match=r"has its digits from realization-L-T/L=5,T=10/0, which is not there"):
        making.regenerate(["ensemble-L-T/L=5,T=10/*"], small, work=tmp_path)
    making.regenerate(["realization-L-T/L=5,T=10/0"], small, work=work)
    making.regenerate(["ensemble-L-T/L=5,T=10/*"], small, work=tmp_path)
    assert lint(Golden(small)).ok
    assert len(list(Golden(small).entries("ensembles"))) == 4
    entry = Golden(small).entry("ensemble-L-T/L=5,T=10/hann-nsp")
    assert entry.record["input"]["realizations"] == 2
    assert entry.output["bias"].shape == entry.output["random"].shape == (16,)
    assert entry.output["count"].tolist() == [2] * 16
    both = Golden(small).entry("realization-L-T/L=5,T=10/0").record["accuracy"]["hann_nsp"]["digits"]
    assert entry.record["accuracy"]["bias"]["digits"] == both < 15.6 == entry.record["accuracy"]["count"]["digits"]
    assert verifying.verify(Golden(small), full=True, work=tmp_path).ok


# ---------------------------------------------------------------- commands


def test_lint_and_verify_on_the_command_line(copy):
    done = command("golden", "lint", "--json")
    printed = json.loads(done.stdout)
    assert (done.returncode, printed["ok"], printed["failures"]) == (0, True, [])
    assert printed["values"] == sum(row["values"] for row in printed["sets"]) > 1000
    assert [row["set"] for row in printed["sets"]] == ["v1"] * 4 + ["v2"] * 4 + [""]
    first = json.loads(command("golden", "lint", "--golden", 1, "--json").stdout)
    assert [row["set"] for row in first["sets"]] == ["v1"] * 4 + [""]
    (copy / "vectors" / "window.json").unlink()
    for word, status in (("lint", 1), ("verify", 3)):
        done = command("golden", word, "--set", copy, "--json")
        assert done.returncode == status
        assert "window-hann-7" in json.loads(done.stdout)["failures"][0]["message"]
    assert command("golden", "lint", "--set", copy / "nowhere").returncode == 2
    assert command("golden", "lint", "--golden", 99).returncode == 2


# ---------------------------------------------------------------- every constant of the chain is seen

PERCENT = [  # module, where in its source, the number to be 1 % off, the stage that must see it
    ("grid", "SPACING = 1 / 28", "28", "scaled-grid"),
    ("grid", "TIME_STEP = 1 / 14", "14", "scaled-grid"),
    ("grid", "return 2 * np.pi / x,", "2", "scaled-grid"),
    ("grid", "x, 2 * np.pi / y,", "2", "scaled-grid"),
    ("grid", "y, 2 * np.pi / t", "2", "scaled-grid"),
    ("cases", "SHELLS = (0.4, 3.5)", "0.4", "scaled-grid"),
    ("cases", "SHELLS = (0.4, 3.5)", "3.5", "scaled-grid"),
    ("dispersion", "self.phase_velocity(wavenumber) / 2", "2", "dispersion"),
    ("currents", "np.tanh(k * water.depth) / (2 * k)", "2", "doppler"),
    ("currents", "kd = 2 * np.asarray", "2", "doppler"),
    ("currents", "np.log(half + np.hypot(half, end)) / (2 * k)", "2", "doppler"),
    ("sea", "np.where(w <= 1, 0.07, 0.09)", "0.07", "jonswap"),
    ("sea", "np.where(w <= 1, 0.07, 0.09)", "0.09", "jonswap"),
    ("sea", "np.exp(-0.5 * ((w - 1)", "0.5", "jonswap"),
    ("sea", "/ sigma) ** 2)", "2", "jonswap"),
    ("sea", "return w**-5 *", "5", "jonswap"),
    ("sea", "np.exp(-1.25 * w", "1.25", "jonswap"),
    ("sea", "* w**-4)", "4", "jonswap"),
    ("sea", "<= spread / 2,", "2", "spreading"),
    ("sea", "np.cos(np.pi * off / spread) ** 2", "2", "spreading"),
    ("sea", "INPUT_SPACING = 0.341", "0.341", "components"),
    ("sea", "LARGEST_WAVENUMBER = 3.5", "3.5", "components"),
    ("dispersion", "dtype=np.float64) ** -1.5", "1.5", "components"),
    ("sea", "* f * dk**2", "2", "components"),
    ("window", "KAISER_SHAPE = float(np.pi * np.sqrt(3))", "3", "window"),
    ("window", 'Window("hann", "Hann", (0.5, 0.5))', "(0.5", "window"),
    ("window", 'Window("hann", "Hann", (0.5, 0.5))', "0.5)", "window"),
    ("window", 'Window("blackman", "Blackman", (0.42, 0.5, 0.08))', "0.42", "window"),
    ("window", 'Window("blackman", "Blackman", (0.42, 0.5, 0.08))', " 0.5", "window"),
    ("window", 'Window("blackman", "Blackman", (0.42, 0.5, 0.08))', "0.08", "window"),
    ("window", "a * np.cos(2 * np.pi * j * s)", "2", "window"),
    ("window", "(-1) ** j * a / 2)", "2)", "response"),
    ("spectrum", "2 * m == self.grid.shape[2]), 0.5, 1.0)", "0.5", "shell"),
    ("leakage", "components.amplitude / 2", "2", "spectrum"),
    ("shell", "HALF_WIDTH = 2.0", "2.0", "shell"),
    ("nsp", "WIDTH = 4.0", "4.0", "characteristic"),
    ("nsp", "np.exp(-2 * ((shell.omega - centre", "2", "characteristic"),
    ("nsp", "g = np.exp(-2 * z**2)", "-2", "derivatives"),
    ("nsp", "(g, 4 * z / width * g,", "4", "derivatives"),
    ("nsp", "(16 * z**2 - 4)", "16", "derivatives"),
    ("nsp", "(16 * z**2 - 4)", "4)", "derivatives"),
    ("leastsquares", "THRESHOLD = 0.2", "0.2", "ls"),
    ("dispersion", "(1 + 3 * tension)", "3", "dispersion"),
    ("dispersion", "np.clip(2 * kh", "2", "dispersion"),
    ("dispersion", "tanh**2 / (1 + ratio)", "2", "components"),
    ("dispersion", "g * length**2)", "2)", "water-units"),
    ("currents", "np.exp(-4 * k * (z", "4", "kernel"),
    ("currents", "-np.expm1(-4 * k * water", "4", "kernel"),
    ("currents", "-np.expm1(-2 * qh) * share", "2", "doppler"),
]
REWRITTEN = [  # constants that are no number in the source, or whose hundredth part is nothing; mistakes about water
    ("dispersion", "np.sqrt((1 + tension) * tanh)", "np.sqrt(1 + tension) * tanh", "dispersion"),  # outside the root
    ("dispersion", "k**2 * self.surface_tension", "k * self.surface_tension", "dispersion"),  # k^2 for k^3
    ("dispersion", "self.surface_tension / self.gravity", "self.surface_tension", "dispersion"),
    ("dispersion", "kh, tension = k * min(", "kh, tension = k / 2 / np.pi * min(", "dispersion"),  # k in cycles
    ("dispersion", "(1 + tension) + ratio,", "(1 + tension),", "dispersion"),  # the group velocity of deep water
    ("currents", "np.asarray(self.shear) * np.tanh(k * water.depth)", "np.asarray(self.shear)", "doppler"),
    ("currents", "if water.depth == np.inf:\n            return np", "if True:\n            return np", "doppler"),
    ("currents", "qh / -np.expm1(-2 * qh) * share", "ph / -np.expm1(-2 * qh) * share", "doppler"),  # p for q
    ("currents", "np.exp(-(qh + np.minimum(ph, qh)))", "np.exp(-(ph + np.minimum(ph, qh)))", "doppler"),
    ("currents", "* (1 + np.exp(-4 * k * (z + water.depth)))", "", "kernel"),
    ("sea", "* water.depth_factor(k)", "", "components"),  # the factor of TMA
    ("sea", "self.current, k, water)", "self.current, k, DEEP)", "components"),  # the depth in omega0 alone
    ("sea", "water.frequency(k) / peak", "water.frequency(k)", "components"),
    ("sea", "omega = water.frequency(k) +", "omega = DEEP.frequency(k) +", "components"),
    ("shell", "water.frequency(k[a, b])", "Water(water.gravity).frequency(k[a, b])", "shell"),
    (
        "dispersion",
        "np.sqrt(self.gravity * np.asarray(wavenumber, dtype=np.float64))",
        "(self.gravity * np.asarray(wavenumber, dtype=np.float64)) ** 0.505",
        "dispersion",
    ),
    (
        "dispersion",
        "np.sqrt(self.gravity / np.asarray(wavenumber, dtype=np.float64))",
        "(self.gravity / np.asarray(wavenumber, dtype=np.float64)) ** 0.505",
        "dispersion",
    ),
    (
        "dispersion",
        "float(Water(self.gravity).frequency(self.peak_wavenumber))",
        "float((self.gravity * self.peak_wavenumber) ** 0.505)",
        "scales",
    ),
    ("sea", "* peakedness**r", "* peakedness ** (1.01 * r)", "jonswap"),
    ("sea", "np.sqrt(energy), uniform", "energy**0.505, uniform", "components"),
    ("sea", ">> np.uint64(11)", ">> np.uint64(12)", "phases"),
    ("sea", "2.0**-53", "2.0**-52", "phases"),
    ("sea", "_ORIGIN = 1 << 32", "_ORIGIN = 1 << 33", "phases"),
    ("sea", "stream.random_raw(4 * (high - low + 1))[::4]", "stream.random_raw(4 * (high - low + 1))[1::4]", "phases"),
    ("window", "s = np.arange(size) / (size - 1 if symmetric else size)", "s = np.arange(size) / (size - 1)", "window"),
    ("shell", "EDGE_MARGIN = 1e-9", "EDGE_MARGIN = -1e-9", "shell"),
    ("nsp", "START = 2.5e-4", "START = 1.0", "nsp"),
    ("_base", "np.maximum(count - 1, 1)", "np.maximum(count, 1)", "statistics"),
    (
        "ensemble",
        "self.random / np.sqrt(np.maximum(self.count, 1))",
        "self.random / np.maximum(self.count, 1)**0.505",
        "statistics",
    ),
]


@contextmanager
def rewritten(module, old, new):
    """The package with one place in one module rewritten, imported afresh beside the true one."""
    source = (HOUSE / f"{module}.py").read_text(encoding="utf-8")
    assert source.count(old) == 1, f"{old!r} is {source.count(old)} times in {module}.py"
    changed = source.replace(old, new)

    class Rewriter(MetaPathFinder, Loader):
        used = False

        def find_spec(self, name, path, target=None):
            return spec_from_loader(name, self) if name == f"leakref.{module}" else None

        def exec_module(self, loaded):
            Rewriter.used = True
            loaded.__file__ = str(HOUSE / f"{module}.py")
            exec(compile(changed, loaded.__file__, "exec"), loaded.__dict__)

    def ours():
        return [name for name in sys.modules if name == "leakref" or name.startswith("leakref.")]

    kept = {name: sys.modules.pop(name) for name in ours()}
    finder = Rewriter()
    sys.meta_path.insert(0, finder)
    try:
        verifying = import_module("leakref.golden.verifying")
        assert Rewriter.used
        yield verifying
    finally:
        sys.meta_path.remove(finder)
        for name in ours():
            del sys.modules[name]
        sys.modules.update(kept)


def first_to_see(verifying, through):
    """The first stage along the chain whose vectors fail, and what they say; looks no further than `through`."""
    order = list(STAGES)[: list(STAGES).index(through) + 1]
    for e in sorted((e for e in ALL if e.stage in order), key=lambda e: order.index(e.stage)):
        failures = verifying.verify_entry(e)
        if failures:
            return e.stage, failures
    return None, []


def percent(where, number, factor):
    """`where` with its `number` (and whatever bracket or sign comes with it) times `factor`."""
    assert where.count(number) == 1 or number == "4)", (where, number)
    digits = number.strip("() -")
    return where.replace(number, number.replace(digits, repr(float(digits) * factor)))


def seen(module, old, new, stage):
    with np.errstate(all="ignore"), rewritten(module, old, new) as verifying:
        found, failures = first_to_see(verifying, stage)
    assert found == stage, f"{module}: {old!r} -> {new!r} was seen by {found}, not by {stage}: {failures[:2]}"


overflowing = pytest.mark.filterwarnings("ignore::RuntimeWarning")  # what a wrong constant leads to
every_constant = pytest.mark.parametrize(
    ("module", "where", "number", "stage"), PERCENT, ids=[f"{p[0]}-{p[1]}-{p[2]}" for p in PERCENT]
)


@overflowing
@every_constant
def test_a_constant_one_percent_larger_is_seen_where_it_acts(module, where, number, stage):
    seen(module, where, percent(where, number, 1.01), stage)


@overflowing
@every_constant
def test_a_constant_one_percent_smaller_is_seen_where_it_acts(module, where, number, stage):
    seen(module, where, percent(where, number, 0.99), stage)


@overflowing
@pytest.mark.parametrize(("module", "old", "new", "stage"), REWRITTEN, ids=[f"{r[0]}-{r[1]}" for r in REWRITTEN])
def test_a_constant_in_other_form_is_seen_where_it_acts(module, old, new, stage):
    seen(module, old, new, stage)


def test_the_package_unchanged_sees_nothing():
    with rewritten("grid", "SPACING = 1 / 28", "SPACING = 1 / 28") as verifying:
        assert first_to_see(verifying, "figures") == (None, [])

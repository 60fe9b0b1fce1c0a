"""Golden files are compared with their digests before anything is judged by them, and every one of them is covered."""

from __future__ import annotations

import json
import os
import re
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

import leakref
from leakref._base import Damaged
from leakref.certify.strength import study
from leakref.claims import stored
from leakref.golden import beside, commands
from leakref.golden.sets import Golden
from leakref.track import commands as track
from leakref.track import history
from leakref.track.tracking import Series

PACKAGE, GOLDEN = Path(leakref.__file__).parent, Path(str(beside.home()))
BESIDE = sorted(path.name for path in GOLDEN.iterdir() if path.is_file())


@pytest.fixture
def copy(tmp_path):
    """The folder with all sets."""
    return Path(shutil.copytree(GOLDEN, tmp_path / "golden", ignore=shutil.ignore_patterns("__pycache__")))


def one_digit(path):
    """The first digit after the middle of the file, or a letter, is another."""
    text = path.read_bytes()
    found = re.compile(rb"[1-8]").search(text, len(text) // 2) or re.search(rb"[a-y]", text)
    at = found.start()
    path.write_bytes(text[:at] + bytes([text[at] + 1]) + text[at + 1 :])


def entries(change):
    def harm(path):
        content = json.loads(path.read_text(encoding="utf-8"))
        content["entries"] = change(content["entries"])
        path.write_text(json.dumps(content), encoding="utf-8")

    return harm


HARMS = {
    "one digit": one_digit,
    "emptied to one entry": entries(lambda all: all[:1]),
    "emptied": entries(lambda all: []),
    "an entry missing": entries(lambda all: all[1:]),
    "an entry more": entries(lambda all: [*all, {**all[0], "id": "mine"}]),
    "written otherwise": entries(lambda all: all),
    "no JSON": lambda path: path.write_text("{"),
    "missing": lambda path: path.unlink(),
}


# ---------------------------------------------------------------- sets


@pytest.mark.parametrize("harm", HARMS)
@pytest.mark.parametrize(
    ("number", "file", "within", "others"),
    [
        (1, "window", "window-hann-7", ["grid-paper"]),
        (2, "dispersion", "dispersion-film", ["nsp-film", "dispersion-si"]),
    ],
)
def test_a_file_that_was_changed_is_not_read(number, file, within, others, harm, copy):
    HARMS[harm](copy / f"v{number}/vectors/{file}.json")
    golden = Golden(copy / f"v{number}")
    with pytest.raises(Damaged, match=rf"vectors/{file}\.json (was changed|cannot be read)"):
        golden.entry(within)
    with pytest.raises(Damaged):
        golden.file(f"vectors/{file}.json")
    assert all(golden.entry(other).values for other in others)  # of the set that it extends too
    with pytest.raises(Damaged):
        list(golden.entries())
    if number > 1:
        assert Golden(copy / "v1").file(f"vectors/{file}.json")


@pytest.mark.parametrize("harm", ["one digit", "missing", "no JSON"])
def test_an_archive_that_was_changed_is_not_read(harm, copy):
    path = copy / "v1/vectors/extract.npz"
    if harm == "one digit":
        content = bytearray(path.read_bytes())
        content[len(content) // 2] ^= 1
        path.write_bytes(content)
    else:
        HARMS[harm](path)
    with pytest.raises((Damaged, KeyError)):
        Golden(copy / "v1").entry("extract-cube-nsp").input  # noqa: B018  # reading it raises


def covered_up(manifest):
    manifest["files"]["vectors/window.json"]["sha256"] = "0" * 64


@pytest.mark.parametrize(
    "harm",
    [
        covered_up,
        lambda manifest: manifest.pop("sha256"),
        lambda manifest: manifest.update(files=[]),
        lambda manifest: manifest.clear(),
    ],
)
def test_a_manifest_that_was_changed_is_not_believed(harm, copy):
    path = copy / "v1/manifest.json"
    manifest = json.loads(path.read_text(encoding="utf-8"))
    harm(manifest)
    path.write_text(json.dumps(manifest), encoding="utf-8")
    with pytest.raises(Damaged, match=r"manifest\.json was changed"):
        Golden(copy / "v1").file("vectors/window.json")


# ---------------------------------------------------------------- commands


@pytest.fixture
def installed(tmp_path):
    """leakref as a wheel lays it out, and how to run it."""
    root = tmp_path / "site"
    none = shutil.ignore_patterns("__pycache__")
    shutil.copytree(PACKAGE, root / "leakref", ignore=none)
    for source, name in ((GOLDEN, "_golden"), (PACKAGE.parent / "properties", "properties")):
        shutil.copytree(source, root / "leakref" / name, ignore=none, dirs_exist_ok=True)

    def run(*words):
        code = "import sys; from leakref.cli import main; sys.argv[0] = 'leakref'; main()"
        return subprocess.run(
            [sys.executable, "-c", code, *words],
            capture_output=True,
            text=True,
            cwd=tmp_path,
            env={**os.environ, "PYTHONPATH": str(root)},
        )

    return root / "leakref" / "_golden", run


def test_no_code_is_judged_by_a_set_that_was_changed(installed):
    golden, run = installed
    whole = (golden / "v1/vectors/window.json").read_bytes()
    for harm, *words in (
        ("one digit", "certify", "reference", "--only", "conformance"),
        ("emptied to one entry", "certify", "fault:flipped-y", "--only", "signs"),
        ("missing", "certify", "reference"),
        ("one digit", "golden", "verify"),
        ("one digit", "explain", "window-hann-7"),
        ("one digit", "golden", "verify", "--golden", "1"),
    ):
        (golden / "v1/vectors/window.json").write_bytes(whole)
        HARMS[harm](golden / "v1/vectors/window.json")
        done = run(*words)
        assert done.returncode == 3, (words, done.stdout, done.stderr)
        assert "vectors/window.json" in done.stdout + done.stderr or "window-" in done.stdout
        assert "Traceback" not in done.stderr
        assert "conformant" not in done.stdout + done.stderr
    assert run("golden", "lint").returncode == 1


def test_no_code_is_judged_by_a_second_set_that_was_changed(installed):
    golden, run = installed
    for name in ("v2/vectors/extract-wide.f64", "v2/vectors/nsp.json", "v2/manifest.json"):
        whole = (golden / name).read_bytes()
        one_bit(golden / name)
        for words in (("certify", "reference", "--only", "conformance"), ("golden", "verify")):
            done = run(*words)
            assert done.returncode == 3, (name, words, done.stdout, done.stderr)
            assert name.rpartition("/")[2].partition(".")[0] in done.stdout + done.stderr
            assert "Traceback" not in done.stderr
        (golden / name).write_bytes(whole)
    (golden / "v2/vectors/nsp.json").unlink()
    assert run("golden", "lint", "--golden", "1").returncode == 0
    assert run("golden", "lint").returncode == 1


def one_bit(path):
    content = bytearray(path.read_bytes())
    content[len(content) // 2] ^= 1
    path.write_bytes(content)


def test_no_result_is_shown_that_was_changed(installed):
    golden, run = installed
    for name, words in (("claims.json", ("explain", "W1")), ("decisions.json", ("claims", "--decisions", "D1"))):
        assert run(*words).returncode == 0
        one_digit(golden / name)
        done = run(*words)
        assert done.returncode == 3, (done.stdout, done.stderr)
        assert done.stderr.startswith("leakref: golden: golden/" + name)
    lint = run("golden", "lint", "--json")
    assert lint.returncode == 1
    assert {row["id"] for row in json.loads(lint.stdout)["failures"]} == {"golden/claims.json", "golden/decisions.json"}
    (golden / "manifest.json").unlink()
    assert run("golden", "lint").returncode == 1


# ---------------------------------------------------------------- beside the sets


def failures(copy):
    return {failure.id for failure in beside.lint(copy)[1]}


def test_every_file_is_covered(copy):
    assert commands._linted(Golden(copy / "v1"), copy / "v1").ok
    one_digit(copy / "claims.json")
    assert {f.id for f in commands._linted(Golden(copy / "v1"), copy / "v1").failures} == {"golden/claims.json"}
    assert {"README.md", "claims.json", "decisions.json", "strength.json", "tracking.json", "history.jsonl"} < {*BESIDE}


@pytest.mark.parametrize("name", BESIDE)
def test_one_digit_in_any_file_is_seen(name, copy):
    one_digit(copy / name)
    assert failures(copy) == {f"golden/{name}"}


@pytest.mark.parametrize("name", [name for name in BESIDE if name != "manifest.json"])
def test_a_file_that_is_missing_is_seen(name, copy):
    (copy / name).unlink()
    assert failures(copy) == {f"golden/{name}"}


def test_a_file_more_and_a_set_written_anew_behind_its_back_are_seen(copy):
    (copy / "mine.json").write_text("{}")
    manifest = copy / "v1/manifest.json"
    manifest.write_bytes(manifest.read_bytes() + b"\n")
    assert failures(copy) == {"golden/mine.json", "golden/v1/manifest.json"}
    assert all("leakref golden regenerate files" in failure.message for failure in beside.lint(copy)[1])


def test_naming_the_files_takes_them_as_they_are(copy, tmp_path):
    one_digit(copy / "README.md")
    assert commands.run_regenerate(["files"], 1, copy / "v1", work=tmp_path / "work", workers=1, json=False)
    assert not failures(copy)


def test_what_writes_a_file_writes_its_digest_in_the_same_step(copy):
    result = stored.stored_claims()
    stored.write(copy / "claims.json", {**result, "realizations": 99}, ("claims",))
    assert json.loads((copy / "claims.json").read_text(encoding="utf-8"))["realizations"] == 99
    assert not failures(copy)
    one_digit(copy / "tracking.json")
    stored.write(copy / "claims.json", result, ("claims",))
    assert failures(copy) == {"golden/tracking.json"}  # that one and no other


def test_a_study_and_a_history_are_noted_too(copy, monkeypatch):
    """What writes them asks for it: `strength --out`, `track record --history`."""
    monkeypatch.setattr(study, "study", lambda **_: {"full": False, "faults": [], "variants": [], "problems": []})
    monkeypatch.setattr(study, "jobs", lambda **_: [])
    assert study.run(out=copy, workers=1, json=True) == 0
    assert '"faults": []' in (copy / "strength.json").read_text(encoding="utf-8")
    assert not failures(copy)
    path = copy / "history.jsonl"
    entries = history.read(path).entries
    series = [Series.read(entries[-1].record["measurements"][0])]
    monkeypatch.setattr(track, "_reference", lambda *_: ({"name": "x", "version": "1"}, series, []))
    assert track.run_record(track.Request("reference", None, label="new", path=path), json=True) == 0
    assert len(history.read(path).entries) == len(entries) + 1
    assert not failures(copy)


def test_a_manifest_of_somebody_else_is_left_alone(tmp_path):
    for text in ("{}", "[1]", '{"schema": "leakref/golden-files/1", "files": {}}', "no"):
        (tmp_path / "manifest.json").write_text(text)
        (tmp_path / "a.json").write_text("1")
        beside.noted(tmp_path / "a.json")
        assert (tmp_path / "manifest.json").read_text() == text

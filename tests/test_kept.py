"""Whatever keeps parts of a computation takes none that is not of what is asked for, or not as it was written."""

from __future__ import annotations

import json
import shutil

import numpy as np
import pytest

from leakref import kept
from leakref.cases import Configuration
from leakref.claims import evidence, shifts
from leakref.claims.variants import VARIANTS
from leakref.golden import entries

SMALL = Configuration("small", direction=60, spread=45, length=2, duration=4)
ABOUT = {"id": "one", "numbers": (1, 2.5), "source": "abc"}


def edited(path, change):
    content = json.loads(path.read_text(encoding="utf-8"))
    change(content)
    path.write_text(json.dumps(content), encoding="utf-8")


HARMS = {
    "a number": lambda content: content["record"].update(value=1.0000000000000002),
    "null for a number": lambda content: content["record"].update(value=None),
    "NaN for a number": lambda content: content["record"].update(value=float("nan")),
    "a key more": lambda content: content["record"].update(more=1),
    "emptied": lambda content: content.update(record={}),
    "what it is of": lambda content: content["about"].update(id="two"),
    "the checksum": lambda content: content.update(sha256="0" * 64),
    "no checksum": lambda content: content.pop("sha256"),
    "nothing it is of": lambda content: content.update(about=None),
}


@pytest.mark.parametrize("harm", HARMS)
def test_a_record_that_was_edited_is_not_there(harm, tmp_path):
    path = tmp_path / "a.json"
    kept.keep_record(path, ABOUT, {"value": 1.0, "none": None})
    assert kept.record(path, ABOUT) == {"value": 1.0, "none": None}
    edited(path, HARMS[harm])
    assert kept.record(path, ABOUT) is None


@pytest.mark.parametrize("content", [b"", b"{", b"[]", b"null", b"\xff\xfe", b"[" * 100_000])
def test_what_is_no_record_is_not_there(content, tmp_path):
    (tmp_path / "a.json").write_bytes(content)
    assert kept.record(tmp_path / "a.json", ABOUT) is None


def test_a_record_of_something_else_is_not_there(tmp_path):
    kept.keep_record(tmp_path / "a.json", {**ABOUT, "id": "two"}, 1)
    assert kept.record(tmp_path / "a.json", ABOUT) is None
    assert kept.record(tmp_path / "a.json", {**ABOUT, "id": "two"}) == 1


def exchanged(folder):
    """The parts 0 and 1 of a folder, each in the other's place."""
    first, second = sorted(folder.rglob("0000[01].npz"))
    shutil.move(first, folder / "aside")
    shutil.move(second, first)
    shutil.move(folder / "aside", second)


def test_parts_of_claims_are_of_their_realisation(tmp_path):
    setting = evidence.Setting(without_peak=True)
    fresh = [evidence._special(SMALL, number, setting, None) for number in range(2)]
    for number in range(2):
        evidence._special(SMALL, number, setting, tmp_path)
    exchanged(tmp_path)
    for number in range(2):
        np.testing.assert_array_equal(evidence._special(SMALL, number, setting, tmp_path), fresh[number])


def test_parts_of_decisions_are_of_their_realisation(tmp_path, monkeypatch):
    def computed(number, folder=None):
        return shifts._kept([VARIANTS["edge-bins-out"]], [("box", "hann")], SMALL, number, evidence.PLAIN, folder)[0]

    fresh = [computed(number) for number in range(2)]
    for number in range(2):
        computed(number, tmp_path)
    exchanged(tmp_path)
    for number in range(2):
        np.testing.assert_array_equal(computed(number, tmp_path), fresh[number])
    monkeypatch.setattr(shifts, "velocities", lambda *_: pytest.fail("it was there"))
    for number in range(2):
        np.testing.assert_array_equal(computed(number, tmp_path), fresh[number])


def test_golden_entries_in_work_are_of_their_id(tmp_path):
    made = []

    def make(name):
        made.append(name)
        return [{"id": name, "value": [1.5, None]}]

    def resumed(name):
        (record,) = entries._resumed([name], tmp_path, lambda: make(name))
        return record

    for name in ("a", "b", "a"):
        assert resumed(name) == {"id": name, "value": [1.5, None]}
    assert made == ["a", "b"]
    a, b = (
        tmp_path / "entries" / f"{kept.key({'id': name, 'source': entries._source_digest()})}.json" for name in "ab"
    )
    shutil.copy(b, a)
    assert resumed("a")["id"] == "a"
    edited(b, lambda content: content["record"].update(value=[1.5, 2.0]))
    assert resumed("b")["value"] == [1.5, None]
    assert made == ["a", "b", "a", "b"]

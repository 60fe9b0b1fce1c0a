"""The switch LEAKREF_REQUIRE: what is absent is skipped with a reason, and where it is required it is a failure."""

from __future__ import annotations

import argparse
import subprocess
import sys
from pathlib import Path

import pytest
import tools
from conftest import _keep_part, _part


def outcome(monkeypatch, required, ask):
    monkeypatch.setenv("LEAKREF_REQUIRE", required)
    try:
        ask()
    except (pytest.skip.Exception, pytest.fail.Exception, pytest.UsageError) as said:
        return type(said).__name__, str(said)
    return "there", ""


@pytest.mark.parametrize(
    ("required", "what"),
    [
        ("", "Skipped"),
        ("octave", "Failed"),
        ("chromium, octave", "Failed"),
        ("chromium,iwave", "Skipped"),
        ("g++", "Skipped"),
        ("octavo", "UsageError"),
        ("chromium octave", "UsageError"),
    ],
)
def test_a_program_that_is_absent(monkeypatch, required, what):
    said, reason = outcome(monkeypatch, required, lambda: tools.requires("no-such-program", "octave"))
    assert said == what
    assert ("no-such-program is not installed" in reason) == (what != "UsageError")


def test_a_program_goes_by_its_own_name_unless_it_has_another(monkeypatch):
    monkeypatch.setenv("PATH", "")
    assert outcome(monkeypatch, "make", lambda: tools.requires("make"))[0] == "Failed"
    assert outcome(monkeypatch, "g++", lambda: tools.requires("make"))[0] == "Skipped"


@pytest.mark.parametrize("python", ["", "/nowhere/python", sys.executable])
@pytest.mark.parametrize(("required", "what"), [("", "Skipped"), ("iwave", "Failed")])
def test_an_environment_without_iwave(monkeypatch, python, required, what):
    monkeypatch.setenv("LEAKREF_IWAVE_PYTHON", python)
    said, reason = outcome(monkeypatch, required, tools.iwave_python)
    assert said == what
    assert ("has no iwave" if python == sys.executable else "does not name") in reason


def test_what_is_there_is_found_whatever_is_required(monkeypatch):
    for required in ("", "octave,chromium,iwave"):
        assert outcome(monkeypatch, required, lambda: tools.requires(sys.executable, "octave")) == ("there", "")


def test_of_a_name_in_slow_txt_one_in_so_many_is_asked_by_default():
    lines = Path(__file__).with_name("slow.txt").read_text(encoding="utf-8").splitlines()
    name = "tests/test_exits.py::test_what_cannot_be_printed_is_no_success"
    assert f"{name} one of 4" in lines

    def found(*words):
        ask = [sys.executable, "-m", "pytest", "--collect-only", "-q", "-n0", name, *words]
        done = subprocess.run(ask, capture_output=True, text=True, cwd=Path(__file__).parents[1])
        return [line for line in done.stdout.splitlines() if line.startswith(name)]

    everything = found()
    assert found("-m", "not slow") == everything[::4]
    assert len(everything) > 4


class Item:
    """As much of a collected test as it takes to choose it."""

    def __init__(self, nodeid, *keywords):
        self.nodeid, self.keywords = nodeid, keywords


def test_parts_are_whole_functions_and_together_all_slow_tests():
    slow = [Item(f"a.py::test_{n}[{p}]", "slow") for n in range(5) for p in range(n + 1)]
    quick = [Item("a.py::test_1[9]"), Item("a.py::test_9")]
    parts = []
    for which in (1, 2, 3):
        items, gone = [*slow, *quick], []
        _keep_part(items, which, 3, lambda items, gone=gone: gone.extend(items))
        assert set(quick) < set(items)
        assert {*items, *gone} == {*slow, *quick}
        parts.append({item for item in items if item.keywords})
    assert sum(map(len, parts)) == len(set().union(*parts)) == len(slow)
    assert not set.intersection(*({item.nodeid.partition("[")[0] for item in part} for part in parts))
    assert _part("2/3") == (2, 3)
    for text in ("0/3", "4/3", "x"):
        with pytest.raises(argparse.ArgumentTypeError, match="such as 2/3"):
            _part(text)

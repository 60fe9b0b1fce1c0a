"""Python targets in a program of their own: the same bits as in this one, and whatever they do, the protocol holds."""

from __future__ import annotations

import numpy as np
import pytest

from leakref import Grid, LeakrefError, SeaState, synthesize
from leakref.certify.subject import inprocess
from leakref.certify.targets import HarnessBroken, connect
from leakref.certify.verdict import Unanswered
from leakref.chain import reference

GRID = Grid((20, 22, 18), (0.9, 0.8, 0.7))
SEA = SeaState(length=3).components(1)
AXES = [GRID.samples(axis) for axis in range(3)]
SURFACE = synthesize(SEA, *AXES)

CODE = r'''
import os, subprocess, sys
from fractions import Fraction
import numpy as np

def zeros(n): return np.zeros((n, 2))

class Code:
    """What it does depends on the method it is asked for."""

    deeds = {
        "prints": lambda eta, n: (print('{"id": 2, "status": "ok"}'), os.write(1, b"raw"), zeros(n))[-1],
        "starts": lambda eta, n: (subprocess.run([sys.executable, "-c", "print('{\"id\": 3}')"]), zeros(n))[1],
        "reads": lambda eta, n: zeros(n) + len(sys.stdin.read()),
        "rows": lambda eta, n: [None, (0.5, Fraction(1, 4)), np.array([1, 2], np.int8)],
        "masks": lambda eta, n: np.ma.array(zeros(n) + 0.5, mask=[[0, 0], [1, 0], [0, 0]]),
        "single": lambda eta, n: np.full((n, 2), 0.1, np.float32),
        "nan": lambda eta, n: [[np.nan, 0.0]] * n,
        "words": lambda eta, n: [[object(), "x"]] * n,
        "complex": lambda eta, n: zeros(n) + 1j,
        "alters": lambda eta, n: (eta.__iadd__(1), zeros(n))[1],
        "raises": lambda eta, n: 1 / 0,
        "exits": lambda eta, n: sys.exit("enough"),
        "lacks": lambda eta, n: (_ for _ in ()).throw(NotImplementedError("no such method")),
    }

    def describe(self):
        return {"name": "<b>code</b>", "can": {"window": {}, "spectrum": {},
                "extract": {"methods": list(self.deeds), "windows": ["hann"]}}}

    def extract(self, surface, spacing, wavenumbers, *, method):
        return self.deeds[method](surface, len(wavenumbers))

    def window(self, name, size):
        return {"box": np.ones(size, np.longdouble), "hann": np.ma.masked_less(np.arange(size), 1.0),
                "blackman": [object()] * size}[name]

    def spectrum(self, surface, spacing, *, window):
        surface[:] = 0
        return np.fft.fftn(surface).astype(np.complex64)

def bare(surface, spacing):
    return [[0.25, 0.5]], [1.0]

class Broken:
    def describe(self): return {"axes": "abc"}
    extract = bare

nothing = 5
'''


@pytest.fixture
def folder(tmp_path, monkeypatch):
    (tmp_path / "small_code.py").write_text(CODE)
    (tmp_path / "failing_code.py").write_text("import math\nmath.sqrt(-1)\n")
    monkeypatch.chdir(tmp_path)
    return tmp_path


def asked(subject, method):
    try:
        return subject.extract(SURFACE, GRID.spacing, [0.8, 1.0, 1.2], window="hann", method=method).values.tolist()
    except Unanswered as nothing:
        return str(nothing.verdict), nothing.message


def test_the_reference_gives_the_same_bits_in_both_processes():
    here = inprocess.InProcess(reference)
    with connect("reference") as there:
        assert there.declaration == here.declaration
        for window in ("box", "hann"):
            for method in ("nsp", "ls"):
                answers = [
                    s.extract(SURFACE, GRID.spacing, [0.8, 0.9], window=window, method=method).values
                    for s in (here, there)
                ]
                assert np.array_equal(*answers)
                assert np.isfinite(answers[0]).all()
            assert np.array_equal(*(s.spectrum(SURFACE, GRID.spacing, window) for s in (here, there)))
            assert np.array_equal(*(s.window(window, 9) for s in (here, there)))
        assert np.array_equal(*(s.synthesize(SEA, *AXES) for s in (here, there)))
        assert there.violations == []


def test_whatever_a_target_does_the_protocol_holds(folder):
    zeros = [[0.0, 0.0]] * 3
    with connect("small_code:Code") as subject:
        assert subject.declaration.name == "<b>code</b>"
        assert subject.declaration.fixed == ("gravity", "window")
        assert [asked(subject, method) for method in ("prints", "starts", "reads")] == 3 * [zeros]
        rows = np.array(asked(subject, "rows"))
        assert np.isnan(rows[0]).all()
        assert rows[1:].tolist() == [[0.5, 0.25], [1.0, 2.0]]
        assert np.isnan(asked(subject, "masks")).tolist() == [[False] * 2, [True] * 2, [False] * 2]
        assert asked(subject, "single") == [[float(np.float32(0.1))] * 2] * 3
        assert [asked(subject, method)[0] for method in ("nan", "words", "complex")] == ["fail"] * 3
        assert asked(subject, "raises") == ("error", "ZeroDivisionError: division by zero")
        assert asked(subject, "exits") == ("error", "SystemExit: enough")
        assert asked(subject, "lacks") == ("missing", "refused: no such method")
        assert subject.violations == []
        assert asked(subject, "alters") == zeros
        assert subject.violations == ["extract altered its input eta"]
        assert not subject.spectrum(SURFACE, GRID.spacing, "hann").any()
        assert subject.violations == ["extract altered its input eta", "spectrum altered its input eta"]
        assert subject.window("box", 5).tolist() == [1.0] * 5
        assert np.isnan(subject.window("hann", 5)[0])
        with pytest.raises(Unanswered, match="TypeError"):
            subject.window("blackman", 5)
        assert asked(subject, "prints") == zeros


def test_a_bare_function_is_asked_for_no_more_than_it_takes(folder):
    with connect("small_code:bare") as subject:
        assert subject.declaration.name == "small_code:bare"
        assert set(subject.declaration.fixed) == {"gravity", "window", "method", "wavenumbers"}
        found = subject.extract(SURFACE, GRID.spacing, [0.4, 1.0], window="box")
    assert found.values[1].tolist() == [0.25, 0.5]
    assert found.declined.tolist() == [True, False]


@pytest.mark.parametrize(
    ("target", "words", "broken"),
    [
        ("no_such_module:code", "there is no module 'no_such_module'", False),
        ("small_code:none", "small_code has no 'none'", False),
        ("failing_code:x", "ValueError: ", False),
        ("fault:no-such-fault", "no-such-fault", False),
        ("small_code:nothing", "offers none of sea, window", True),
        ("small_code:Broken", "declares axes = 'abc'", True),
    ],
)
def test_a_target_that_is_none_is_wrong_use_and_one_that_offers_nothing_cannot_be_judged(folder, target, words, broken):
    with pytest.raises(LeakrefError) as refused, connect(target):
        pass
    assert words in str(refused.value)
    assert isinstance(refused.value, HarnessBroken) == broken


@pytest.mark.parametrize(
    ("answer", "wavenumbers", "velocities"),
    [
        (([None, [0.1, 0.2]], [0.8, 0.9]), True, [None, [0.1, 0.2]]),
        (([[0.1, 0.2]], [0.8]), True, [[0.1, 0.2]]),
        ((np.array([[0.1, 0.2], [0.3, 0.4]]), np.array([0.8, 0.9])), True, [[0.1, 0.2], [0.3, 0.4]]),
        (((0.1, 0.2), (0.3, 0.4)), False, [[0.1, 0.2], [0.3, 0.4]]),
        ((None, (0.3, 0.4)), False, [None, [0.3, 0.4]]),
        ([None, [0.3, 0.4]], False, [None, [0.3, 0.4]]),
    ],
)
def test_a_pair_is_told_from_velocities_alone(answer, wavenumbers, velocities):
    given = {"dx": 1.0, "dy": 1.0, "dt": 1.0, "gravity": 1.0, "window": "box", "method": "nsp"}
    found = inprocess.call(
        lambda eta, spacing, k: answer, "extract", {"eta": SURFACE}, {**given, "wavenumbers": [0.8, 0.9]}
    )
    assert ("wavenumbers" in found) == wavenumbers
    assert [None if row is None else list(map(float, row)) for row in found["velocities"]] == velocities

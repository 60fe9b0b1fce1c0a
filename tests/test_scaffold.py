"""Adapters to start from: each works as it is written, and finds a current that it is not told."""

from __future__ import annotations

import shutil
import subprocess
from pathlib import Path

import numpy as np
import pytest
from tools import requires

from leakref import Grid, LeakrefError, aligned_waves, synthesize
from leakref.certify import scaffold
from leakref.certify.targets import connect
from leakref.certify.verdict import Unanswered
from leakref.window import window

GRID = Grid((16, 18, 48), (0.9, 1.05, 0.6))
WAVES, CURRENT = aligned_waves(GRID, [(3, -1, 6), (2, 3, 5)], gravity=1.0)
SURFACE = synthesize(WAVES, *(GRID.samples(axis) for axis in range(3)))
SHELL = float(np.hypot(WAVES.kx, WAVES.ky).mean())


@pytest.fixture
def adapter(tmp_path, monkeypatch):
    """The command of an adapter that was just written, as it stands in NEXT."""
    monkeypatch.chdir(tmp_path)

    def start(kind):
        scaffold.write(kind, Path("."))
        *build, certify = scaffold.NEXT[kind].split(" && ")
        for command in build:
            subprocess.run(command.split(), check=True, capture_output=True)
        _, _, said = certify.partition("leakref certify ")
        if not said.startswith("--command "):
            return connect(said)
        return connect(command=said.removeprefix("--command ").strip('"').split())

    return start


def find(subject):
    """Along the way of a user: the current under box, where it is exact, under Hann, and where there is none."""
    exact = subject.extract(SURFACE, GRID.spacing, [SHELL], window="box", method="ls").values
    assert exact[0] == pytest.approx(CURRENT, abs=1e-9)
    tapered = subject.extract(SURFACE, GRID.spacing, [0.9 * SHELL, SHELL], window="hann", method="ls").values
    assert np.abs(tapered - CURRENT).max() < 0.15  # the side bins lie on the tangent of omega0, not on omega0
    one, _ = aligned_waves(GRID, [(3, -1, 6)], gravity=1.0)
    alone = synthesize(one, *(GRID.samples(axis) for axis in range(3)))
    # no direction but one; and a shell that ends past Nyquist
    nothing = subject.extract(SURFACE, GRID.spacing, [SHELL, 2.9], window="box", method="ls")
    assert nothing.declined.tolist() == [False, True]
    with pytest.raises(Unanswered, match="gave no velocity at any of 1"):
        subject.extract(alone, GRID.spacing, [SHELL], window="box", method="ls")
    with pytest.raises(Unanswered, match="not finite"):
        subject.extract(np.where(SURFACE > 1, np.nan, SURFACE), GRID.spacing, [SHELL], window="box", raw=True)
    assert subject.violations == []


def taper(subject):
    """The windows it offers are those of the reference."""
    for name, size in (("hann", 9), ("box", 4), ("hann", 16)):
        assert subject.window(name, size) == pytest.approx(window(name).samples(size), abs=1e-15)


def test_python(adapter):
    with adapter("python") as subject:
        find(subject)


def test_octave(adapter):
    requires("octave-cli", "octave")
    with adapter("octave") as subject:
        find(subject)
        taper(subject)


def test_cpp(adapter):
    requires("make")
    requires("g++")
    with adapter("cpp") as subject:
        find(subject)
        taper(subject)


@pytest.mark.skipif(not shutil.which("sh"), reason="there is no sh")
def test_shell(adapter):
    surface = SURFACE[:7, :6, :10]
    with adapter("shell") as subject:
        taper(subject)
        for name in ("box", "hann"):
            found = subject.spectrum(surface, GRID.spacing, name)
            tapered = surface
            for axis, size in enumerate(surface.shape):
                tapered = tapered * window(name).samples(size).reshape([-1 if n == axis else 1 for n in range(3)])
            # backwards in time: a wave is found at its own k and omega
            assert np.abs(found - np.fft.ifft(np.fft.fft2(tapered, axes=(0, 1)), norm="forward")).max() < 1e-12
        with pytest.raises(Unanswered, match="not as it should be"):
            subject.spectrum(np.full((4, 4, 4), np.inf), GRID.spacing, "box")
        assert subject.violations == []


def test_what_is_there_is_not_overwritten(tmp_path):
    (tmp_path / "README.md").write_text("mine")
    with pytest.raises(LeakrefError, match=r"README\.md is there already"):
        scaffold.write("octave", tmp_path)
    assert [path.name for path in tmp_path.iterdir()] == ["README.md"]
    with pytest.raises(LeakrefError, match="'fortran'; choose one of python, octave, shell, cpp, ci"):
        scaffold.write("fortran", tmp_path)


@pytest.mark.parametrize("kind", scaffold.NEXT)
def test_the_readme_says_what_to_do_next(kind, tmp_path):
    files = scaffold.write(kind, tmp_path / "new")
    assert sorted(path for path in (tmp_path / "new").rglob("*") if path.is_file()) == files
    if kind != "ci":  # it goes where a README.md is already
        assert f"\n    {scaffold.NEXT[kind]}\n" in (tmp_path / "new" / "README.md").read_text()

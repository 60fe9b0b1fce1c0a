"""Frames that are lost without a word in the file are told by how the waves move on, and nothing else is."""

from __future__ import annotations

import json

import numpy as np
import pytest
from typer.testing import CliRunner

from leakref import Components, Scales, SeaState, UniformCurrent, synthesize
from leakref.cli.base import app
from leakref.cubes.gaps import seemingly_lost

SCALES = Scales(25.0, 9.81)
X, Y = np.arange(40) * 0.026, np.arange(46) * 0.024
COUNT = 160


@pytest.fixture(scope="module")
def seas():
    """25 cm waves of a tank at 30 and at 15 frames a second."""
    sea = SeaState(70, 60, length=5, current=UniformCurrent((0.21, -0.12))).components(1).to_units(SCALES)
    return {fps: synthesize(sea, X, Y, np.arange(COUNT) / fps) for fps in (30, 15)}


def without(frames, lost):
    """The frames that are left, and those behind which one is gone."""
    kept = np.setdiff1d(np.arange(frames.shape[2]), lost)
    return frames[:, :, kept], np.flatnonzero(np.diff(kept) > 1).tolist()


@pytest.mark.parametrize("fps", [30, 15])
@pytest.mark.parametrize("noise", [0.0, 0.1])
@pytest.mark.parametrize("lost", [[], [70], [20, 90, 91 + 12], range(9, COUNT, 10), range(7, COUNT, 50)])
def test_every_lost_frame_is_named_and_no_other(seas, fps, noise, lost):
    random = np.random.default_rng(2)
    frames, behind = without(seas[fps], list(lost))
    assert seemingly_lost(frames + noise * frames.std() * random.normal(size=frames.shape)) == behind


@pytest.mark.parametrize("kind", ["noise", "still", "still in noise", "flicker", "doubled", "trend", "few", "zero"])
def test_nothing_is_said_of_what_only_looks_odd(seas, kind):
    random, sea = np.random.default_rng(0), seas[15]
    picture = random.normal(size=(*sea.shape[:2], 1))
    frames = {
        "noise": random.normal(size=sea.shape),
        "still": np.repeat(picture, COUNT, axis=2),
        "still in noise": picture + 0.1 * random.normal(size=sea.shape),
        "flicker": sea * (1 + 0.3 * random.normal(size=COUNT)) + sea.std() * random.normal(size=COUNT),
        "doubled": sea[:, :, (np.arange(120) * 4) // 5],
        "trend": sea + np.linspace(0, 9, COUNT) * sea.std(),
        "few": sea[:, :, :12],
        "zero": 0 * sea,
    }[kind]
    assert seemingly_lost(frames) == []


@pytest.mark.parametrize("length", [2.0, 3.3])
def test_nothing_is_said_of_swell_in_a_picture_of_two_wavelengths(length):
    """All pixels rise and fall together, so that frames differ more at some times than at others."""
    sea = SeaState(direction=70, spread=15, peakedness=7, length=length).components(0)
    swell = np.hypot(sea.kx, sea.ky) < 1.25
    sea = Components(*(getattr(sea, name)[swell] for name in ("kx", "ky", "omega", "amplitude", "phase")))
    side = np.arange(30) * 2 * np.pi * length / 30
    for a_period in (5, 14):
        frames = synthesize(sea, side, side, np.arange(300) * 2 * np.pi / a_period)
        assert seemingly_lost(frames) == []


def extract(path, *options):
    words = ["extract", str(path), "--spacing", "0.026,0.024,1/30", "--gravity", "9.81", "--axes", "xyt", "--json"]
    done = CliRunner().invoke(app, [*words, *options], catch_exceptions=False)
    return done.exit_code, json.loads(done.stdout)


def test_they_are_named_put_in_on_request_and_many_of_them_end_with_one(tmp_path, seas):
    frames, behind = without(seas[30], list(range(9, COUNT, 10)))
    np.save(tmp_path / "a.npy", frames)
    status, given = extract(tmp_path / "a.npy")
    assert status == 1
    assert any("15 frames seem to be lost, behind frames 8, 17, 26" in note for note in given["notes"]), given["notes"]
    assert any(
        word.startswith(f"{len(behind)} of {COUNT - 1} frames are lost") for word in given["shell_band"]["words"]
    )
    status, filled = extract(tmp_path / "a.npy", "--fill-holes", "0.1")
    assert (status, filled["shape"][2], filled["shell_band"]["words"]) == (0, COUNT - 1, [])
    whole = tmp_path / "b.npy"
    np.save(whole, seas[30])
    status, own = extract(whole)
    assert status == 0
    k, all_k = filled["wavenumbers"], own["wavenumbers"]
    there = [n for n, one in enumerate(k) if one in all_k and one < 60]
    off = (
        np.array(filled["doppler_shift_velocities"])[there]
        - np.array(own["doppler_shift_velocities"])[[all_k.index(k[n]) for n in there]]
    )
    assert np.hypot(*off.T).max() < max(np.array(filled["resolution_frequency"])[there])


def test_one_lost_frame_is_a_warning(tmp_path, seas):
    np.save(tmp_path / "a.npy", without(seas[30], [70])[0])
    status, given = extract(tmp_path / "a.npy")
    assert status == 0
    (note,) = (note for note in given["notes"] if "seems to be lost" in note)
    assert note.startswith("WARNING: 1 frame seems to be lost, behind frame 69 (counted from 0)")
    assert "--frames 70:159 takes the longest stretch" in note

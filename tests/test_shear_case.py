"""Case shear: what is inferred of currents that vary with depth, against eq:SJ."""

from __future__ import annotations

import json
from dataclasses import replace

import numpy as np
import pytest
from typer.testing import CliRunner

from leakref import LeakrefError, ProfileCurrent, runs
from leakref.cases import CASES, configurations
from leakref.cli.base import app
from leakref.dispersion import DEEP
from leakref.ensemble import Ensemble
from leakref.paper import shear
from leakref.paper.shear import BANDS, SHEARED, Sheared, answer, inferred, sheared

BY_ID = {c.id: c for c in SHEARED}


def measured(configuration, velocities):
    """An ensemble of these velocities (R, n, 2), or of one realisation (n, 2)."""
    velocities = np.broadcast_to(velocities, (3, configuration.wavenumbers.size, 2))
    return Ensemble(
        configuration,
        "hann",
        "nsp",
        configuration.wavenumbers,
        velocities,
        np.zeros(velocities.shape[:2], dtype=np.int64),
    )


def test_it_is_a_case_of_its_own():
    assert len(BY_ID) == 9
    assert "shear" not in CASES  # which the golden sets follow
    assert sheared("shear") == SHEARED
    one = "shear/profile=linear,current_direction=-90"
    assert sheared(one) == (BY_ID[one],)
    assert sheared("nsp-ls") == ()
    with pytest.raises(LeakrefError, match="no profile is called 'cubic'"):
        Sheared("shear", profile="cubic")


@pytest.mark.parametrize("configuration", SHEARED, ids=lambda c: c.id)
def test_the_truth_is_eq_sj_of_the_profile_itself(configuration):
    speeds = {
        "uniform": np.ones_like,
        "linear": lambda z: 1 + shear.SHEAR / shear.SURFACE * z,
        "exponential": lambda z: np.exp(z / shear.DEPTH),
    }
    angle = np.radians(configuration.current_direction)
    unit = np.array([np.cos(angle), np.sin(angle)])
    profile = ProfileCurrent(lambda z: np.outer(shear.SURFACE * speeds[configuration.profile](z), unit))
    theirs = profile.doppler_shift_velocity(configuration.wavenumbers)
    np.testing.assert_allclose(configuration.truth, theirs, atol=1e-11)


def test_every_wave_is_shifted_by_its_own_velocity():
    for c in SHEARED[::4]:
        small = replace(c, length=5.0)
        waves = small.components(1)
        k = np.hypot(waves.kx, waves.ky)
        shift = waves.kx, waves.ky
        own = small.depending_on_depth.doppler_shift_velocity(k)
        np.testing.assert_allclose(
            waves.omega - DEEP.frequency(k), shift[0] * own[:, 0] + shift[1] * own[:, 1], atol=1e-12
        )


def test_a_perfect_measurement_infers_the_true_shear():
    for c in SHEARED:
        for row in inferred(measured(c, c.truth)):
            assert row.mean == pytest.approx(row.true, abs=1e-14)
            assert abs(row.spurious) < 1e-14
            assert row.true == pytest.approx({"uniform": 0, "linear": shear.SHEAR}.get(c.profile, row.true), abs=1e-14)
            assert (row.profile == "uniform") == (row.true == 0)


def test_a_spurious_shear_is_found_along_the_current_and_in_its_band_only():
    c = BY_ID["shear/profile=exponential,current_direction=0"]
    z = -0.5 / c.wavenumbers
    wrong = c.truth + np.outer(0.03 * z, [1, 0]) + np.outer(0.5 * z, [0, 1])  # across the current is not looked at
    for row in inferred(measured(c, wrong)):
        assert row.spurious == pytest.approx(0.03, abs=1e-12)
        assert row.random == pytest.approx(0, abs=1e-14)
    below = c.truth + np.outer(np.where(c.wavenumbers < 0.95, 1.0, 0.0), [1, 0])
    peak_up, overall = inferred(measured(c, below))
    assert (peak_up.band, overall.band) == tuple(BANDS)
    assert peak_up.spurious == pytest.approx(0, abs=1e-14)
    assert overall.spurious < -0.1


def test_random_part_and_standard_error_are_over_realizations():
    c = BY_ID["shear/profile=linear,current_direction=90"]
    z = -0.5 / c.wavenumbers
    off = [-0.01, 0.0, 0.04]
    velocities = np.stack([c.truth + np.outer(o * z, c.along) for o in off])
    velocities = np.concatenate([velocities, np.full((1, *c.truth.shape), np.nan)])  # left out
    for row in inferred(replace(measured(c, c.truth), velocities=velocities)):
        assert row.spurious == pytest.approx(0.01)
        assert row.random == pytest.approx(np.std(off, ddof=1))
        assert row.standard_error == pytest.approx(np.std(off, ddof=1) / np.sqrt(3))


def test_only_this_case_is_inferred_from():
    paper = configurations(["nsp-ls"])[0]
    with pytest.raises(LeakrefError, match="no configuration of case shear"):
        inferred(measured(paper, np.zeros((paper.wavenumbers.size, 2))))


def test_the_answer_states_the_largest_and_smallest_share():
    rows = [
        shear.Inferred(profile, 0.0, window, "nsp", band, true, true + part * added, 0.0, 0.0)
        for window, part in (("box", 1.0), ("hann", 0.5))
        for band in BANDS
        for profile, true, added in (("uniform", 0.0, -0.02), ("linear", 0.1, 0.03), ("exponential", 0.2, -0.1))
    ]
    said = answer(rows)
    assert said.count("leakage adds to the true shear -50 to +30 % untapered and -25 to +15 % tapered") == 2
    assert said.count("one of up to 0.02 untapered and 0.01 tapered (c0 k0)") == 2
    only = [row for row in rows if row.profile == "linear"]
    assert "where there is none" not in answer(only)


def test_measured_tapered_the_profile_is_seen_and_untapered_less_well():
    """End to end on a smaller domain, from the peak up: closer to eq:SJ with a taper."""
    c = replace(BY_ID["shear/profile=linear,current_direction=0"], length=5.0, duration=10.0)
    off = {}
    for e in next(runs.run([c], realizations=6, methods=("nsp",))):
        on = e.wavenumbers >= 1
        off[e.window] = np.hypot(*(e.velocities.mean(axis=0) - c.truth)[on].T)
        assert (off[e.window] <= np.max(e.resolutions, axis=0)[on]).all()
    assert off["hann"].mean() < 0.7 * off["box"].mean()


def test_it_is_reproduced_like_any_case(tmp_path):
    name = "shear/profile=linear,current_direction=0"
    done = CliRunner().invoke(
        app,
        [
            "reproduce",
            name,
            "L-T/L=5,T=10",
            "--realizations",
            "2",
            "--workers",
            "1",
            "--figures",
            "--out",
            str(tmp_path),
            "--json",
        ],
        catch_exceptions=False,
    )
    assert done.exit_code == 0
    found = json.loads(done.stdout)
    of_it = [case for case in found["cases"] if case["case"] == name]
    assert len(of_it) == 4
    assert len(found["cases"]) == 8
    np.testing.assert_allclose(of_it[0]["truth"], BY_ID[name].truth, rtol=1e-12)
    assert of_it[0]["profile"] == "linear"
    assert "truth" not in found["cases"][-1]
    assert len(found["shear"]) == 8  # two windows, methods and bands
    np.testing.assert_allclose([row["true"] for row in found["shear"]], shear.SHEAR, rtol=1e-12)
    assert found["answer"].startswith("By NSP, over wavenumbers from the peak up, leakage adds")
    assert (tmp_path / "figure_shear.svg").stat().st_size > 10_000
    assert (tmp_path / "figure_L-T.png").exists()

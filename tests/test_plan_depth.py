"""`leakref plan --depth`: the campaign is simulated, measured and told in the water that was asked for."""

from __future__ import annotations

import csv
import json
from dataclasses import replace

import numpy as np
import pytest
from typer.testing import CliRunner

from leakref import LeakrefError, Scales, Water, runs
from leakref.cases import Configuration
from leakref.cli.base import app
from leakref.planning.advice import advice
from leakref.planning.command import parse_sweep
from leakref.planning.plan import GRAVITY, Campaign, expected, plan
from leakref.planning.quantities import CLEAN_WATER

WAVELENGTH = 2 * np.pi  # so that k0 is 1 and lengths are those of scaled units
SCALES = Scales(1.0, GRAVITY)
PERIOD = 2 * np.pi * SCALES.time


def campaign(**more):
    return Campaign((5 * WAVELENGTH,) * 2, 10 * PERIOD, WAVELENGTH, **more)


@pytest.mark.parametrize(("depth", "tension"), [(0.7, 0.0), (np.inf, 0.0), (1.2, 2e-4), (np.inf, 3e-5)])
def test_it_is_the_case_of_that_depth(depth, tension):
    """The same samples, waves and velocities as those of a configuration with this k0 h and S k0^2 / g."""
    asked = campaign(depth=depth, surface_tension=tension, spread=30.0)
    own = Configuration("depth", spread=30.0, length=5, duration=10, depth=depth, surface_tension=tension / GRAVITY)
    assert asked.flight.water.depth == depth
    assert asked.flight.water.surface_tension == pytest.approx(own.surface_tension, rel=1e-15)
    assert asked.flight.grid == own.grid
    flown = expected([asked], 2)[0]["hann", "nsp"]
    case = next(e for e in next(runs.run([own], realizations=2, methods=("nsp",))) if e.window == "hann")
    assert flown.measured.velocities == pytest.approx(case.velocities, abs=1e-12)
    k = flown.measured.wavenumbers
    assert flown.resolutions[1] == pytest.approx(Water(GRAVITY, depth, tension).group_velocity(k) * 0.2 / k, rel=1e-12)


def test_the_water_changes_what_is_expected():
    deep, shallow = (expected([campaign(depth=depth)], 3)[0]["hann", "nsp"] for depth in (np.inf, 0.7))
    assert np.all(shallow.resolutions[1] != deep.resolutions[1])
    assert not np.allclose(shallow.bias, deep.bias, rtol=0.02)


def test_the_periods_and_speeds_that_limit_a_campaign_are_those_of_its_water():
    shallow = campaign(depth=0.1)
    assert shallow.phase_velocity == pytest.approx(np.sqrt(GRAVITY * np.tanh(0.1)), rel=1e-12)
    with pytest.raises(LeakrefError, match=r"travel at 0\.989 m/s"):
        replace(shallow, speed=1.0)
    replace(campaign(), speed=1.0)
    with pytest.raises(LeakrefError, match=r"video is 2\.\d+ peak periods of 6\.35 s"):
        replace(shallow, duration=14.0)
    replace(campaign(), duration=14.0)


@pytest.mark.parametrize("water", [{}, {"depth": 0.02}, {"surface_tension": CLEAN_WATER}])
def test_the_wavelength_below_which_waves_alias_is_that_of_the_water(water):
    """Where omega0(k) + k U meets pi times the frame rate: by bisection, in metres and seconds."""
    small = Campaign((0.5, 0.5), 5.0, 0.1, speed=0.05, frame_rate=16.0, **water)
    law = Water(GRAVITY, **water)
    low, high = 2 * np.pi / 0.1, 2 * np.pi / 0.02
    for _ in range(60):
        k = (low + high) / 2
        low, high = (k, high) if law.frequency(k) + k * 0.05 < np.pi * 16 else (low, k)
    lattice = 0.1 / np.linspace(1, small.flight.wavenumbers.max(), 400)
    found = small.aliased_below()
    if 2 * np.pi / low < lattice[-1]:
        assert found is None
    else:
        assert 2 * np.pi / low == pytest.approx(found, rel=0.01)


def test_advice_says_what_taking_it_for_deep_would_cost():
    found = plan(campaign(depth=1.0), 2)
    c, deep = float(np.sqrt(GRAVITY * np.tanh(1.0))), np.sqrt(GRAVITY)
    assert advice(found)[-1].startswith("Give the depth to the extraction: waves of 6.28 m travel at 2.73 m/s here")
    assert f"{deep - c:.2g} m/s, for a current against them" in advice(found)[-1]
    faster = replace(found, campaign=campaign(surface_tension=2e-4))
    assert "Give the surface tension" in advice(faster)[-1]
    assert "for a current with them" in advice(faster)[-1]
    assert not any("extraction:" in words for words in advice(replace(found, campaign=campaign())))


def run(folder, *options):
    words = ["plan", "--field-of-view", "60m", "--duration", "30s", "--peak-wavelength", "15m", "--realizations", "2"]
    return CliRunner().invoke(app, [*words, "--workers", "1", "--out", str(folder), *options], catch_exceptions=False)


def test_text_table_json_and_pictures_say_the_depth(tmp_path):
    done = run(tmp_path, "--depth", "4m", "--sweep", "depth=2m:8m:2")
    assert done.exit_code == 0
    assert "Expected errors |c - U| in m/s, depth 4 m: mean" in " ".join(done.stdout.split())
    record = json.loads((tmp_path / "plan.json").read_text())
    assert (record["campaign"]["depth"], record["campaign"]["surface_tension"]) == (4.0, 0.0)
    k = 2 * np.pi / 15
    assert record["campaign"]["phase_velocity"] == pytest.approx(float(Water(GRAVITY, 4.0).phase_velocity(k)))
    assert (record["sweep"]["parameter"], record["sweep"]["unit"]) == ("depth", "m")
    assert [one["value"] for one in record["sweep"]["values"]] == [2.0, 8.0]
    assert "depth 4 m" in (tmp_path / "plan.svg").read_text()
    with (tmp_path / "plan_sweep.csv").open() as stream:
        assert {row["depth"] for row in csv.DictReader(stream)} == {"2.0", "8.0"}
    deep = run(tmp_path, "--depth", "deep", "--json")
    assert json.loads(deep.stdout)["campaign"]["depth"] == "deep water"
    assert "deep water" in (tmp_path / "plan.svg").read_text()


@pytest.mark.parametrize(
    ("options", "said"),
    [
        (("--depth", "0m"), "a depth of 0 m is not positive"),
        (("--depth=-3m",), "a depth counts downwards from the surface; give one such as 4m, or deep"),
        (("--depth", "nan"), "--depth nan is not a number with a unit; write it as in --depth 4m"),
        (("--depth", "4"), "--depth 4 has no unit; write it as in --depth 4m"),
        (("--depth", "4s"), "second cannot be had in m"),
        (("--depth", "4000km"), "is deeper than any ocean"),
        (("--surface-tension", "0.07m3/s2"), "is more than any liquid has: divide it by the density"),
        (("--surface-tension=-1e-5m3/s2",), "is not a number of at least 0"),
        (("--surface-tension", "0.073N/m"), "newton / meter cannot be had in m^3/s^2"),
        (("--sweep", "depth=0m:4m:3"), "a depth of 0 m is not positive"),
    ],
)
def test_what_no_water_has_is_refused(tmp_path, options, said):
    done = run(tmp_path / "out", *options)
    assert done.exit_code == 2
    assert said in " ".join(done.stderr.split())
    assert not (tmp_path / "out").exists()


@pytest.mark.parametrize("wrong", [{"depth": np.nan}, {"depth": "4"}, {"depth": None}, {"surface_tension": np.inf}])
def test_in_python_too(wrong):
    with pytest.raises(LeakrefError, match=r"plan: (depth|surface_tension|a surface tension)"):
        campaign(**wrong)


@pytest.mark.parametrize("text", ["depth=2m:deep:3", "depth=deep:2m:3"])
def test_a_sweep_without_an_end_is_refused(text):
    with pytest.raises(LeakrefError, match="has no end") as refused:
        parse_sweep(text)
    assert "depth=2m:20m:4" in refused.value.remedy

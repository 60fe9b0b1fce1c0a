"""`leakref plan`: it simulates the paper's chain in metres and seconds, and its words follow from the numbers."""

from __future__ import annotations

import csv
import json
from dataclasses import replace
from functools import partial

import numpy as np
import pytest
from typer.testing import CliRunner

from leakref import LeakrefError, Scales, ensemble, runs
from leakref.cases import configurations
from leakref.cli.base import app
from leakref.ensemble import Ensemble
from leakref.golden.sets import Golden
from leakref.planning import plan
from leakref.planning.advice import advice, ranges, scope
from leakref.planning.command import _show, _title, parse_sweep
from leakref.planning.figures import plan_figure
from leakref.planning.flight import Flight
from leakref.planning.plan import GRAVITY, Campaign, Expected, Plan, expected
from leakref.planning.quantities import number, quantity

WAVELENGTH = 20.0
SCALES = Scales(2 * np.pi / WAVELENGTH, GRAVITY)
PERIOD, C0 = 2 * np.pi * SCALES.time, SCALES.velocity


def campaign_of(configuration):
    """A paper's configuration in metres and seconds."""
    c = configuration
    return Campaign(
        (c.length * WAVELENGTH,) * 2,
        c.duration * PERIOD,
        WAVELENGTH,
        c.direction,
        c.spread,
        c.peakedness,
        c.speed * C0,
        c.current_direction,
    )


@pytest.mark.parametrize(
    ("text", "unit", "value"),
    [
        ("128m", "m", 128),
        ("0.128 km", "m", 128),
        ("1e2m", "m", 100),
        (".5 m", "m", 0.5),
        ("-3m", "m", -3),
        ("2 min", "s", 120),
        ("45deg", "deg", 45),
        ("45°", "deg", 45),
        ("0.25 turn", "deg", 90),
        ("3.6 km/h", "m/s", 1),
        ("0.3 m s^-1", "m/s", 0.3),
        ("1knot", "m/s", 1852 / 3600),
        ("2Hz", "Hz", 2),
        ("25/s", "Hz", 25),
    ],
)
def test_quantities_are_taken_in_any_unit_of_their_kind(text, unit, value):
    assert quantity("plan", "--x", text, unit) == pytest.approx(value, rel=1e-12)


@pytest.mark.parametrize(
    ("text", "unit", "said"),
    [
        ("128", "m", "has no unit"),
        ("30", "s", "has no unit"),
        ("45", "deg", "has no unit"),
        ("128s", "m", "cannot be had in m"),
        ("3 m/m", "deg", "cannot be had"),
        ("3 Hz", "deg", "cannot be had"),
        ("5 fps", "Hz", "foot_per_second"),
        ("3 blah", "m", "no unit 'blah'"),
        ("m", "m", "not a number"),
        ("nan m", "m", "not a number"),
        ("", "m", "not a number"),
        ("9**9**9**9m", "m", "no unit"),
        ("1e999m", "m", "not finite"),
        ("3 °C", "m", "cannot be"),
    ],
)
def test_what_is_no_such_quantity_is_refused_with_an_example(text, unit, said):
    with pytest.raises(LeakrefError, match=r"write it as in --x \d|that is") as refusal:
        quantity("plan", "--x", text, unit)
    assert said in str(refusal.value)


def test_plain_numbers():
    assert number("plan", "--gamma", "3.3") == 3.3
    for text in ("3.3m", "nan", "inf", ""):
        with pytest.raises(LeakrefError, match="--gamma"):
            number("plan", "--gamma", text)


def test_a_paper_case_in_si_is_that_case_to_the_last_bit():
    paper = replace(configurations(["L-T/L=5,T=10"])[0], speed=0.125, current_direction=0.0)
    campaign = campaign_of(paper)
    flight = campaign.flight
    assert (flight.length, flight.duration, flight.speed) == (5, 10, 0.125)  # no rounding in this choice of units
    assert flight.grid == paper.grid
    assert np.array_equal(flight.wavenumbers, paper.wavenumbers)
    theirs = next(runs.run([paper], realizations=2))
    mine = expected([campaign], 2)[0]
    for e in theirs:
        found = mine[e.window, e.method]
        np.testing.assert_array_equal(found.measured.velocities, e.velocities)
        whole = np.isfinite(e.velocities).all(axis=(0, 2))
        assert whole.sum() >= 15  # LS has a shell without a number
        errors = (e.velocities[:, whole] - [0.125, 0]) * C0
        off = np.hypot(errors[..., 0], errors[..., 1])
        np.testing.assert_allclose(found.bias[whole], off.mean(axis=0), rtol=1e-12)
        np.testing.assert_allclose(found.random[whole], off.std(axis=0, ddof=1), rtol=1e-9, atol=1e-12)
        np.testing.assert_allclose(found.mean_error[whole], errors.mean(axis=0), atol=1e-13)
        np.testing.assert_allclose(found.resolutions, np.array(e.resolutions) * C0, rtol=1e-12)
        np.testing.assert_allclose(found.wavelengths, WAVELENGTH / e.wavenumbers, rtol=1e-12)


def against_golden(case, realizations, sigmas):
    """Largest differences from the golden ensemble, which has the same first realisations, in standard errors."""
    paper = configurations([case])[0]
    mine = expected([campaign_of(paper)], realizations)[0]
    worst = {}
    for (window, method), e in mine.items():
        golden = Golden().entry(f"ensemble-{case}/{window}-{method}").output
        error = golden["random"] * np.sqrt(max(1 / realizations - 1 / 100, 0)) + 1e-9
        worst[window, method] = np.max(np.abs(e.record()["speed"] / C0 - golden["bias"]) / error)
        if not paper.speed:
            assert np.array_equal(e.record()["speed"], e.bias)
    assert max(worst.values()) <= sigmas, worst


@pytest.mark.stored
def test_a_paper_case_agrees_with_its_golden_ensemble_within_the_standard_errors():
    against_golden("L-T/L=5,T=10", 20, 4)


@pytest.mark.slow
@pytest.mark.parametrize(
    ("case", "realizations"),
    [
        ("nsp-ls", 30),
        ("theta0-dtheta/direction=60,spread=15", 30),
        ("U/rotation=0,current=0.15,current_direction=0", 30),
    ],
)
def test_more_paper_cases_agree_within_the_standard_errors(case, realizations):
    against_golden(case, realizations, 4)


@pytest.mark.slow
def test_all_realizations_of_a_paper_case_are_its_golden_ensemble():
    against_golden("L-T/L=5,T=10", 100, 1)  # an error of 1e-9 c0 is then allowed


def test_an_oblong_area_and_coarse_sampling_go_through_the_plain_chain_alike():
    flight = Campaign(
        (4.2 * WAVELENGTH, 5.1 * WAVELENGTH),
        9 * PERIOD,
        WAVELENGTH,
        direction=40,
        spread=110,
        speed=0.4,
        current_direction=-20,
        pixel=WAVELENGTH / 5.5,
        frame_rate=5.3 / PERIOD,
    ).flight
    assert flight.grid.shape == (23, 28, 48)
    np.testing.assert_allclose(flight.grid.lengths, 2 * np.pi * np.array([4.2, 5.1, 9]), rtol=1e-12)
    assert flight.wavenumbers.max() + 2 * flight.grid.wavenumber_resolution < min(flight.grid.nyquist[:2])
    plain, fast = (ensemble.realize(flight, 3, route=route) for route in "AB")
    for key, found in fast.items():
        assert found.notes == plain[key].notes
        np.testing.assert_allclose(found.velocities, plain[key].velocities, atol=1e-11)


def test_at_another_scale_all_velocities_follow_the_phase_velocity():
    one = Campaign((80.0, 80.0), 10 * PERIOD, WAVELENGTH, speed=0.2 * C0)
    four = Campaign((320.0, 320.0), 20 * PERIOD, 4 * WAVELENGTH, speed=0.4 * C0)
    small, large = (found["hann", "nsp"] for found in expected([one, four], 2, windows=("hann",), methods=("nsp",)))
    np.testing.assert_allclose(large.bias, 2 * small.bias, rtol=1e-6)
    np.testing.assert_allclose(large.wavelengths, 4 * small.wavelengths, rtol=1e-12)


def test_twice_the_area_keeps_proportions_and_is_as_much_data_as_twice_the_duration():
    campaign = Campaign((128.0, 96.0), 30.0, 15.0)
    larger, longer = campaign.enlarged(area=2), campaign.enlarged(duration=2)
    assert np.prod(larger.field_of_view) == pytest.approx(2 * 128 * 96)
    assert larger.field_of_view[0] / larger.field_of_view[1] == pytest.approx(128 / 96)
    assert (
        plan.work(larger.flight)
        == pytest.approx(plan.work(longer.flight))
        == pytest.approx(2 * plan.work(campaign.flight))
    )


def test_the_default_number_of_flights_falls_with_size_and_not_below_eight():
    counts = [plan.default_realizations(Flight("plan", length=side, sides=(side, side))) for side in (5, 10, 15, 40)]
    assert counts == [30, 29, 13, 8] or counts == sorted(counts, reverse=True)
    assert counts[-1] == 8
    assert counts[0] == 30


def test_a_frame_rate_too_low_for_short_waves_is_said():
    assert Campaign((80.0, 80.0), 30.0, 15.0).aliased_below() is None
    slow = Campaign((80.0, 80.0), 30.0, 15.0, frame_rate=1.0)
    period = np.sqrt(2 * np.pi * slow.aliased_below() / GRAVITY)
    assert period == pytest.approx(2.0, rel=0.01)  # two images a period


# ------------------------------------------------------------------------------------------------- words

FLIGHT = Flight("plan", length=8.0, duration=10.0, speed=0.1, current_direction=0.0, sides=(8.0, 8.0))


def made(scale, window="hann", method="nsp", flight=FLIGHT, jitter=0.1, count=12):
    """An ensemble whose errors are about `scale` times the smaller resolution at every wavenumber."""
    blank = Ensemble(
        flight,
        window,
        method,
        flight.wavenumbers,
        np.zeros((count, flight.wavenumbers.size, 2)),
        np.zeros((count, flight.wavenumbers.size), dtype=np.int64),
    )
    rng = np.random.default_rng(3)
    length = np.minimum(*blank.resolutions) * scale * (1 + jitter * rng.standard_normal(blank.velocities.shape[:2]))
    angle = rng.uniform(0, 2 * np.pi, length.shape)
    errors = length[..., None] * np.stack([np.cos(angle), np.sin(angle)], axis=-1)
    return Expected(replace(blank, velocities=flight.current + errors), CAMPAIGN.scales)


CAMPAIGN = Campaign((8 * 15.0, 8 * 15.0), 31.0, 15.0, speed=0.5, current_direction=0.0)


def said(hann=0.3, box=0.9, ls=0.6, larger=0.2, longer=0.28, campaign=CAMPAIGN):
    return advice(planning(hann, box, ls, larger, longer, campaign))


def planning(hann=0.3, box=0.9, ls=0.6, larger=0.2, longer=0.28, campaign=CAMPAIGN):
    """A plan whose errors are so many times the smaller resolution, of the current that the campaign has."""
    of = partial(made, flight=replace(FLIGHT, speed=campaign.speed / campaign.scales.velocity))
    ways = {
        ("box", "nsp"): of(box, "box"),
        ("hann", "nsp"): of(hann),
        ("box", "ls"): of(box, "box", "ls"),
        ("hann", "ls"): of(ls, "hann", "ls"),
    }
    return Plan(campaign, ways, of(larger), of(longer))


def test_advice_follows_the_numbers():
    words = said()
    assert words[0].startswith("Taper with a Hann window: untapered, the bias is 3 ±")
    assert words[1].startswith("Extract by NSP: least squares, the bias is 2 ±")
    assert words[2].startswith("Trust wavelengths of 30 to 4.29 m: ")
    assert words[3].startswith("Within 20 % of the current")
    assert words[4].startswith(
        "A larger area before a longer video: twice the area changes the bias at wavelengths up to the peak's by -33 ±"
    )


def test_advice_says_where_the_paper_s_rules_fail():
    words = said(hann=0.3, box=0.2, ls=0.3, larger=0.29, longer=0.2)
    assert words[0].startswith("Here the paper's rule does not hold (Taper with a Hann window)")
    assert "no difference that could be seen" in words[1]
    assert words[-1].startswith("A longer video before a larger area, against the paper's rule")
    assert said(larger=0.2, longer=0.202)[-1].startswith("Area or duration, no difference")


def test_nothing_is_to_be_trusted_beyond_the_resolution():
    assert said(hann=1.1)[2].startswith("Trust no wavelength")
    near = made(0.9)  # its mean is within the resolution, one flight in twenty is not
    assert (near.bias < np.minimum(*near.resolutions)).all()
    assert not near.trusted.any()
    e = made(0.3)
    assert e.trusted.all()
    lost = e.measured.velocities.copy()
    lost[2, 5] = np.nan  # one flight has no number there
    assert list(np.flatnonzero(~replace(e, measured=replace(e.measured, velocities=lost)).trusted)) == [5]


def test_nothing_is_to_be_trusted_beyond_the_current():
    slow = replace(CAMPAIGN, speed=0.25)  # errors at the longest wavelengths are larger, if within the resolution
    assert said(campaign=slow)[2].startswith("Trust wavelengths of 24 to 4.29 m, not the others: ")
    assert "and the current itself" in said(campaign=slow)[2]
    assert "current itself" not in said(campaign=replace(CAMPAIGN, speed=0.0))[2]


def test_text_picture_and_table_trust_the_same_wavelengths():
    """The text refused waves of 32 m that the picture shaded: beyond the current, if within the resolution."""
    slow = planning(campaign=replace(CAMPAIGN, speed=0.25))
    trusted = slow.best.wavelengths[slow.best.trusted]
    assert 0 < trusted.size < slow.best.wavelengths.size
    assert f"Trust wavelengths of {trusted[0]:.3g} to {trusted[-1]:.3g} m, not the others" in advice(slow)[2]
    drawn = plan_figure(slow, "")
    (shade,) = {
        tuple(part.get_paths()[0].vertices[:, 0].tolist())
        for ax in drawn.axes
        for part in ax.collections
        if "trusted" in str(part.get_label())
    }
    assert (min(shade), max(shade)) == pytest.approx((trusted[-1], trusted[0]))


def test_the_axis_of_errors_begins_at_the_data():
    one = planning()
    lines = [values for e in one.ways.values() for values in (e.bias, 2 * e.random)]
    low, high = plan_figure(one, "").axes[0].get_ylim()
    assert low == pytest.approx(np.concatenate(lines).min() / 2)
    assert high < 3 * max(np.concatenate(lines).max(), CAMPAIGN.speed, np.max(one.best.resolutions))


def test_the_title_of_a_sweep_leaves_out_what_is_swept():
    assert "spread" in _title(CAMPAIGN)
    assert "spread" not in _title(CAMPAIGN, "spread")
    assert "0.5 m/s" not in _title(CAMPAIGN, "current")


def test_ranges_of_wavelengths():
    assert ranges([9, 8, 7, 6, 5], [True, True, False, True, False]) == [(9, 8), (6, 6)]
    assert ranges([9, 8], [False, False]) == []


# ----------------------------------------------------------------------------------------------- command

GIVEN = ("--field-of-view", "75m", "--duration", "31s", "--peak-wavelength", "15m")


def test_a_sweep_is_read():
    name, values = parse_sweep("spread=15deg:90deg:6")
    assert name == "spread"
    np.testing.assert_allclose(values, [15, 30, 45, 60, 75, 90])
    assert parse_sweep("gamma=1:7:3") == ("gamma", [1.0, 4.0, 7.0])


@pytest.mark.parametrize(
    ("words", "message"),
    [
        (("--field-of-view", "75"), "--field-of-view 75 has no unit"),
        (("--duration", "31m"), "cannot be had in s"),
        (("--field-of-view", "-75m"), "not positive"),
        (("--spread", "0deg"), "spread = 0.0 is not positive"),
        (("--spread", "400deg"), "at most 360deg"),
        (("--gamma", "3.3m"), "--gamma 3.3m is not a number"),
        (("--gamma", "0.5"), "a gamma of 0.5, where the JONSWAP spectrum has 1 and more"),
        (("--field-of-view", "30m"), "2 peak wavelengths across; take at least 3"),
        (("--field-of-view", "75m x 30m"), "2 peak wavelengths across"),
        (("--duration", "5s"), "periods of 3.1 s long"),
        (("--field-of-view", "75mx75mx75m"), "has 3 sides"),
        (("--field-of-view", "20km"), "plan for less of it"),
        (("--current", "-0.3m/s"), "current's direction"),
        (("--current", "300 m/s"), "waves of 15 m travel at 4.84 m/s"),
        (("--pixel", "8m"), "pixels of 8.0 m do not resolve"),
        (("--frame-rate", "0.5Hz"), "do not resolve the peak"),
        (("--pixel", "0m"), "pixel = 0.0 is not positive"),
        (("--sweep", "spread"), "is not NAME=FIRST:LAST:HOW-MANY"),
        (("--sweep", "colour=1:2:3"), "names are field-of-view"),
        (("--sweep", "spread=15deg:90deg:1"), "asks for '1'"),
        (("--sweep", "spread=15:90:4"), "--spread 15 has no unit"),
        (("--sweep", "spread=-10deg:90deg:3"), "not positive"),
        (("--realizations", "1"), "--realizations"),
    ],
)
def test_wrong_use_names_fault_and_remedy(words, message, tmp_path):
    done = CliRunner().invoke(app, ["plan", *GIVEN, *words, "--out", str(tmp_path / "out")])
    assert done.exit_code == 2
    assert message in " ".join(done.stderr.replace("│", " ").split())
    assert not done.stdout
    assert not (tmp_path / "out").exists()


def test_what_is_printed_has_the_water_the_methods_and_what_it_holds_for(capsys):
    found = planning()
    _show(found, advice(found), "", (), ())
    said = " ".join(capsys.readouterr().out.split())
    assert said.count("Expected errors") == 1  # two methods, one table
    assert "in m/s, deep water: mean" in said
    assert scope(found).advice in said
    assert all(" ".join(sentence.split()) in said for sentence in advice(found))


@pytest.fixture(scope="module")
def planned(tmp_path_factory):
    out = tmp_path_factory.mktemp("plan")
    done = CliRunner().invoke(
        app,
        [
            "plan",
            *GIVEN,
            "--current",
            "0.3m/s",
            "--realizations",
            "2",
            "--sweep",
            "gamma=1:7:2",
            "--out",
            str(out),
            "--json",
        ],
        catch_exceptions=False,
    )
    assert done.exit_code == 0, done.stderr
    return out, json.loads(done.stdout)


def test_json_has_the_recommended_way_on_top_and_all_of_them_below(planned):
    out, found = planned
    assert found["schema"] == "leakref/plan/1"
    assert found["ok"] is True
    n = len(found["wavelengths"])
    assert n == 16
    for name in (
        "bias",
        "random",
        "standard_error",
        "resolution_frequency",
        "resolution_wavenumber",
        "mean_error",
        "speed",
    ):
        assert len(found[name]) == n
        assert np.isfinite(found[name]).all()
    assert [(way["window"], way["method"]) for way in found["ways"]] == [
        ("box", "nsp"),
        ("box", "ls"),
        ("hann", "nsp"),
        ("hann", "ls"),
    ]
    assert found["bias"] == found["ways"][2]["bias"]
    assert found["true_current"] == pytest.approx([0, 0.3])
    assert found["campaign"]["current_direction"] == 90  # with the waves, as nothing else was said
    assert len(found["recommendations"]) == 5
    assert json.loads((out / "plan.json").read_text(encoding="utf-8")) == found


def test_tables_say_what_the_json_says(planned):
    out, found = planned
    with (out / "plan.csv").open(encoding="utf-8") as stream:
        rows = list(csv.DictReader(stream))
    for way in found["ways"]:
        mine = [row for row in rows if (row["window"], row["method"]) == (way["window"], way["method"])]
        assert [float(row["bias"]) for row in mine] == way["bias"]
        assert [float(row["mean_error_y"]) for row in mine] == [error[1] for error in way["mean_error"]]
    with (out / "plan_sweep.csv").open(encoding="utf-8") as stream:
        rows = list(csv.DictReader(stream))
    assert [value["value"] for value in found["sweep"]["values"]] == [1, 7]
    last = found["sweep"]["values"][1]["ways"][2]
    assert [
        float(row["bias"]) for row in rows if (row["gamma"], row["window"], row["method"]) == ("7.0", "hann", "nsp")
    ] == last["bias"]
    assert {path.name for path in out.iterdir()} == {
        "plan.json",
        "plan.csv",
        "plan_sweep.csv",
        "plan.png",
        "plan.svg",
        "plan_sweep.png",
        "plan_sweep.svg",
    }


def test_the_table_shows_every_wavelength_whole(tmp_path, monkeypatch):
    monkeypatch.setenv("COLUMNS", "80")
    done = CliRunner().invoke(
        app,
        [
            "plan",
            *GIVEN[:1],
            "48m",
            "--duration",
            "10s",
            "--peak-wavelength",
            "15m",
            "--realizations",
            "2",
            "--out",
            str(tmp_path),
        ],
        catch_exceptions=False,
    )
    assert done.exit_code == 0
    lines = [line for line in done.stdout.splitlines() if line.count("±") == 4]
    assert len(lines) == 10
    assert "…" not in done.stdout
    assert "- Taper with a Hann window" in done.stdout or "does not hold (Taper" in done.stdout

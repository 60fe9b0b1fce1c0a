"""Codes that are made for some waves, some cubes, some currents: what they declare, are shown, and are told."""

import json
from contextlib import nullcontext
from dataclasses import replace

import numpy as np
import pytest

from leakref import nsp
from leakref._base import LeakrefError
from leakref.certify.checks import inputs
from leakref.certify.checks.exact import TRACE
from leakref.certify.commands import Request
from leakref.certify.report import sentence
from leakref.certify.runner import certify, run_checks, select
from leakref.certify.strength.clues import parts
from leakref.certify.strength.diagnosis import explain
from leakref.certify.strength.regime import CLOSE, right_between
from leakref.certify.subject.declaration import PEAK, Declaration
from leakref.certify.subject.inprocess import InProcess
from leakref.certify.verdict import Unanswered, Verdict
from leakref.chain import extract, reference
from leakref.grid import Grid
from leakref.spectrum import fourier

RANGE = [0.5, 4.0]


def si(**said):
    return Declaration.read({"units": "si", **said})


@pytest.mark.parametrize(
    "waves",
    [
        3.0,
        [0.5, 4],
        {"peak_wavelength": 3},
        {"peak_wavelength": [4, 0.5]},
        {"peak_wavelength": [0, 4]},
        {"peak_wavelength": [0.5, float("inf")]},
        {"peak_wavelength": ["0.5", "4"]},
        {"peak_wavelength": [0.5, 4, 8]},
        {"fastest": -1},
        {"fastest": float("nan")},
        {"fastest": True},
    ],
)
def test_what_are_no_waves_is_refused(waves):
    with pytest.raises(Unanswered, match=r"declares waves = .*should be an object with peak_wavelength") as said:
        si(waves=waves)
    assert said.value.verdict is Verdict.ERROR


def test_waves_are_those_of_codes_in_metres():
    with pytest.raises(Unanswered, match="for a code in SI"):
        Declaration.read({"units": "scaled", "waves": {"fastest": 1.0}})


@pytest.mark.parametrize(
    "cube", [{"multiple": 0}, {"multiple": 1.5}, {"shape": [8, 8]}, {"shape": 8}, 5, {"smallest": 0}]
)
def test_what_is_no_cube_is_refused(cube):
    with pytest.raises(Unanswered, match="declares cube = "):
        si(cube=cube)


def test_usual_waves_are_among_those_declared():
    assert si().scales().peak_wavenumber == PEAK
    assert si(waves={"peak_wavelength": [10, 100]}).scales().peak_wavenumber == PEAK
    d = si(waves={"peak_wavelength": RANGE})
    assert 2 * np.pi * d.scales().length == pytest.approx(np.sqrt(2.0))
    assert 2 * np.pi * d.scales(d.scale(16.0)).length == pytest.approx(0.5)
    assert 2 * np.pi * d.scales(d.scale(1 / 16)).length == pytest.approx(4.0)
    assert d.scale(4.0) ** 2 == pytest.approx(d.scale(16.0))
    assert [si().scale(one) for one in (16.0, 0.25)] == [16.0, 0.25]  # who says nothing is asked as before
    assert d.shows(d.scale(16.0))
    assert not d.shows(1.1 * d.scale(16.0))


class Shown:
    """The reference in SI, and the waves and currents that it was shown."""

    def __init__(self, **said):
        self.said, self.seen = said, []

    def describe(self):
        return {"units": "si", **self.said, "can": {"extract": {"methods": ["nsp"], "windows": ["box", "hann"]}}}

    def extract(self, surface, spacing, wavenumbers, *, gravity, window):
        self.seen.append((surface.shape, spacing, np.asarray(wavenumbers)))
        return extract(surface, spacing, wavenumbers, gravity=gravity, window=window).velocities


def judged(code, *patterns):
    return certify("code", [nullcontext(InProcess(code))], select(patterns, profile="quick"), profile="quick")


def test_all_questions_are_within_the_waves_and_the_grade_says_so():
    code = Shown(waves={"peak_wavelength": RANGE, "fastest": 0.6})
    found = judged(code, "signs.sea", "scale", "currents.strong", "recovery.pair[even-1]")
    assert not found.wrong, [(f.id, f.message) for f in found.wrong]
    assert "in waves of 0.5 to 4 m" in found.grade_line
    assert found.scope()["peak_wavelengths"] == pytest.approx(RANGE)
    assert found.scope()["fastest_current"] <= 0.6
    k = np.concatenate([k for _, _, k in code.seen])
    assert 2 * np.pi / k.max() > 0.5 / 3  # shells are up to 2.5 times the peak's wavenumber
    assert 2 * np.pi / k.min() < 4.0
    usual = judged(Shown(), "signs.sea[to-22.5]")
    assert "in waves" not in usual.grade_line


def test_a_current_that_is_too_fast_is_made_slower_or_not_shown():
    code = InProcess(Shown(waves={"fastest": 1.0}))  # 25 m: c0 = 6.3 m/s
    limit = code.declaration.fastest()
    with inputs.asked(code, 1):
        cube = inputs.sea(0.0, 180.0, inputs.UniformCurrent((0.3, 0.4)))
        assert np.hypot(*cube.truth[0]) == pytest.approx(0.95 * limit)
        assert np.hypot(*inputs.sea(0.0, 180.0, inputs.UniformCurrent((0.01, 0.0))).truth[0]) == 0.01
    (finding,) = run_checks(select(["recovery.ring[moving]"]), code)
    assert finding.verdict is Verdict.UNSUPPORTED
    assert "is made for currents up to 1 m/s" in finding.message


@pytest.mark.parametrize(
    ("cube", "holds"),
    [
        ({"multiple": 8}, lambda shape: not any(n % 8 for n in shape)),
        ({"shape": [48, 48, 96]}, lambda shape: shape == (48, 48, 96)),
    ],
)
def test_cubes_are_those_that_it_takes(cube, holds):
    code = Shown(cube=cube)
    found = judged(code, "signs.sea[to-22.5]", "recovery.pair", "recovery.ring", "leakage.aligned", "scale.peak[4]")
    assert all(holds(shape) for shape, _, _ in code.seen), {shape for shape, _, _ in code.seen}
    assert not found.wrong, [(f.id, f.message) for f in found.wrong]
    assert found.coverage["judged"] > 0.8 * found.coverage["asked"]
    assert "samples" in next(
        f.message for f in run_checks(select(["conformance.extract[nsp-oblong]"]), InProcess(code))
    )


class River(Shown):
    """A width in rad/s, and velocities beyond a range in m/s cut off."""

    def extract(self, surface, spacing, wavenumbers, *, gravity, window):
        grid = Grid(surface.shape, spacing)
        spectrum = fourier(surface, grid, window)
        found = nsp.extract(spectrum, wavenumbers, gravity=gravity, width=2.1 / grid.frequency_resolution).velocities
        return [None if np.isnan(row).any() else row for row in np.clip(found, -1.0, 1.0)]


def test_a_code_is_right_in_the_waves_that_it_is_made_for():
    found = judged(River(waves={"peak_wavelength": RANGE, "fastest": 0.9}), "signs.sea", "scale", "leakage.still")
    assert not found.wrong, [(f.id, f.message) for f in found.wrong]


def errors(code, wavelength):
    """Mean error over the resolution, by a declaration that has these waves alone in the middle."""
    declared = River(waves={"peak_wavelength": [wavelength / 1.01, wavelength * 1.01]})
    subject = InProcess(declared)
    from leakref.certify.checks.scale import shown_at

    with inputs.asked(subject, 1):
        cube = shown_at(subject, 1.0)
        found = subject.extract(cube.surface, cube.spacing, cube.wavenumbers, window="hann").values
        return np.nanmean(np.hypot(*(found - cube.truth).T)) / cube.resolutions[1].mean()


def test_the_range_in_which_it_is_right_is_found():
    code = River()
    short, long = right_between(InProcess(code))
    assert short < 2 * np.pi / PEAK / 16 * 1.01  # the shortest that are shown
    assert 5 < long < 400
    assert errors(code, long) <= 1 < errors(code, long * np.exp(2 * CLOSE))  # within 20 %, by measuring it anew
    assert right_between(InProcess(Shown())) is None  # right everywhere
    assert right_between(InProcess(reference)) is None  # in scaled units


def test_the_explanation_says_the_range():
    code = River()
    found = judged(code, "signs.sea[to-22.5]", "scale.peak[4]")
    assert found.grade == "rejected"
    told = explain(found, InProcess(code)).explanation
    assert "in waves of 1.6 to" in told
    assert "--waves 1.6m:" in told


@pytest.mark.parametrize(
    ("given", "words"),
    [
        ("0.5m", "not two wavelengths"),
        ("4m:0.5m", "do not go from short to long"),
        ("0m:4m", "do not go from short to long"),
        ("0.5:4", "has no unit"),
        ("0.5s:4s", "cannot be had in m"),
        ("a:b", "not a number"),
    ],
)
def test_waves_on_the_command_line_are_refused_in_words(given, words):
    with pytest.raises(LeakrefError, match=words) as refused:
        _ = Request("reference", None, waves=given).given_waves
    assert refused.value.call == "certify"
    assert "0.5m:4m" in refused.value.remedy


def test_waves_on_the_command_line_go_before_those_declared(capfd, monkeypatch, tmp_path):
    from leakref.certify import commands

    monkeypatch.chdir(tmp_path)
    (tmp_path / "own.py").write_text(
        "from leakref.chain import extract as chain\n"
        "class Code:\n"
        "    def describe(self):\n"
        "        return {'units': 'si', 'can': {'extract': {'methods': ['nsp'], 'windows': ['hann']}}}\n"
        "    def extract(self, surface, spacing, wavenumbers, *, gravity):\n"
        "        return chain(surface, spacing, wavenumbers, gravity=gravity).velocities\n"
    )
    status = commands.run(
        Request("own:Code", None, only=("signs.sea", "scale.peak"), workers=1, waves="50cm:4m"), json=True
    )
    said = json.loads(capfd.readouterr().out)
    assert status == 0
    assert said["declaration"]["waves"] == {"peak_wavelength": [0.5, 4.0]}
    assert "in waves of 0.5 to 4 m" in said["grade_line"]
    assert said["scope"]["peak_wavelengths"] == pytest.approx(RANGE)


def test_a_declared_current_too_slow_to_see_leaves_the_signs_open():
    found = judged(Shown(waves={"fastest": 0.3}), "signs", "leakage.still[broad]")  # 25 m: c0 = 6.3 m/s
    signs = [f for f in found.findings if f.family == "signs"]
    assert all("too slow to tell a slip of sign by" in f.message for f in signs)
    assert found.grade is None
    assert found.status == 3
    assert "which way its velocities point is not known" in sentence(found)


def test_records_shorter_than_a_code_takes_are_not_shown():
    code = Shown(cube={"duration": 20.0})  # 25 m: ten periods are 40 s
    found = {f.id: f for f in judged(code, "scale.duration", "signs.sea[to-22.5]").findings}
    assert found["scale.duration[brief]"].verdict is Verdict.UNSUPPORTED
    assert "takes no record shorter than 20 s; this has 14.3 s" in found["scale.duration[brief]"].message
    assert found["signs.sea[to-22.5]"].verdict is Verdict.PASS
    assert all(shape[2] * spacing[2] >= 20 for shape, spacing, _ in code.seen)


def test_square_pixels_go_with_numbers_of_samples():
    code = Shown(fixed=["dy"], cube={"multiple": 4})
    found = judged(code, "signs.sea[to-22.5]", "recovery.pair")
    assert found.coverage["judged"] == found.coverage["asked"]
    assert not found.wrong, [(f.id, f.message) for f in found.wrong]
    assert all(not any(n % 4 for n in shape) and spacing[0] == spacing[1] for shape, spacing, _ in code.seen)


class Whitening(Shown):
    """The reference after each frequency was divided by what it holds, as codes do that want waves of all lengths to
    weigh alike: right of every sea, and lost where most frequencies hold nothing but rounding."""

    def describe(self):
        return {"units": "si", "can": {"extract": {"methods": ["own"], "windows": []}}}

    def extract(self, surface, spacing, wavenumbers, *, gravity):
        self.seen.append(surface.shape)
        transformed = np.fft.fftn(surface)
        power = np.abs(transformed) ** 2
        eta = np.fft.ifftn(transformed / np.sqrt(power.mean(axis=(0, 1)))).real
        return self.answer(extract(eta, spacing, wavenumbers, gravity=gravity, window="box", method="ls").velocities)

    def answer(self, velocities):
        return velocities


class Exchanged(Whitening):
    def answer(self, velocities):
        return velocities[:, ::-1]


CLEAN = ("recovery.pair[prime-1]", "recovery.pair[even-1]", "recovery.ring", "currents.aligned")


def test_who_divides_by_what_is_at_a_frequency_is_asked_with_a_trace_of_noise():
    clean = inputs.pair(inputs.PRIME, (3, -5), (6, 1), (0.0, 0.0))
    off = [
        np.hypot(
            *(InProcess(Whitening()).extract(c.surface, c.spacing, c.wavenumbers, window="box").values - c.truth)[0]
        )
        for c in (clean, replace(clean, noise=TRACE))
    ]
    assert off[0] > 0.1 > 10 * off[1]
    found = judged(Whitening(), *CLEAN)
    assert not found.wrong, [(f.id, f.message) for f in found.wrong]
    assert {f.id.partition("[")[0] for f in judged(Exchanged(), *CLEAN).wrong} == {
        one.partition("[")[0] for one in CLEAN
    }


class Drift(Shown):
    """Takes waves for something that drifts: a dispersion relation without the waves' own frequency."""

    def describe(self):
        return {"units": "si", "can": {"extract": {"methods": ["own"], "windows": ["hann"]}}}

    def extract(self, surface, spacing, wavenumbers, *, gravity):
        return extract(surface, spacing, wavenumbers, gravity=1e-9, method="ls").velocities


def test_who_takes_waves_for_drift_is_told_so():
    found = judged(Drift(), "signs.sea[to-22.5]", "recovery.sea[broad]", "leakage.still[broad]")
    assert [", along the waves, and not the water" in f.message for f in found.wrong] == [True] * 3
    assert "in 3 of 3 seas that fell short its velocity is that of the crests" in explain(found).explanation
    right = judged(Shown(), "signs.sea[to-22.5]", "recovery.sea[broad]")
    assert not right.wrong
    assert not any(part.get("crests") for f in right.findings for part in parts(f.figures))

"""In which waves something holds: the same words on certificates, plans and extractions, and a line that can be run."""

import json
import shlex
from dataclasses import replace

import numpy as np
import pytest
from typer.testing import CliRunner

from leakref.certify.checks import inputs
from leakref.certify.commands import Request
from leakref.certify.subject.declaration import Declaration
from leakref.cli.base import app
from leakref.planning.advice import scope
from leakref.planning.plan import Campaign, plan
from leakref.scope import ASKED, Scope, peaks

FLIGHT = ["--field-of-view", "60m", "--duration", "15s", "--peak-wavelength", "15m", "--current", "0.3m/s"]


def waves_of(line):
    """What --waves of a line means, read as the command reads it."""
    words = shlex.split(line)
    assert words[:3] == ["leakref", "certify", "TARGET"]
    return Request("reference", None, waves=words[words.index("--waves") + 1]).given_waves["peak_wavelength"]


def asked(wavelengths):
    """The shortest and the longest waves at which a code for such seas is asked, at the ends and in the middle."""
    code = Declaration.read({"units": "si", "waves": {"peak_wavelength": wavelengths}})
    lengths = [2 * np.pi * code.scales(code.scale(end)).length for end in (16.0, 1.0, 1 / 16)]
    return min(lengths) / max(inputs.SHELLS), max(lengths) / min(inputs.SHELLS)


def test_certify_asks_where_it_is_said_to():
    assert (min(inputs.SHELLS), max(inputs.SHELLS)) == ASKED


@pytest.mark.parametrize("ends", [(4.3, 37.5), (0.2, 2.0), (50.0, 500.0)])
@pytest.mark.parametrize("part", [None, 0.5])
def test_asked_are_only_waves_within_those_that_there_are(ends, part):
    peak = None if part is None else ends[0] ** part * ends[1] ** (1 - part)
    shortest, longest = asked(peaks(*ends, peak))
    assert ends[0] * 0.999 <= shortest < longest <= ends[1] * 1.001


def test_the_peak_that_there_is_is_in_the_middle():
    low, high = peaks(4.3, 37.5, 15.0)
    assert np.sqrt(low * high) == pytest.approx(15.0)
    assert peaks(9.0, 10.0, 10.0)[1] == pytest.approx(11.0)  # never one length alone


def test_a_plan_says_it_in_its_json_and_on_the_terminal(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    monkeypatch.setenv("COLUMNS", "300")
    arguments = ["plan", *FLIGHT, "--depth", "4m", "--realizations", "2", "--workers", "1", "--out", str(tmp_path)]
    said = CliRunner().invoke(app, arguments)
    assert said.exit_code == 0, said.output
    told = json.loads((tmp_path / "plan.json").read_text())
    record = told["scope"]
    assert record["words"] in said.stdout
    assert record["certify"] in said.stdout
    assert "told of this water" in said.stdout
    assert record["wavelengths"] == pytest.approx([min(told["wavelengths"]), max(told["wavelengths"])])
    assert (record["depth"], record["fastest_current"], record["peak_wavelength"]) == (4.0, 0.3, 15.0)
    assert record["words"].startswith("Water of a depth of 4 m, no surface tension, linear waves of ")
    low, high = waves_of(record["certify"])
    assert low < 15 < high


def test_an_extraction_says_it_too(tmp_path, monkeypatch):
    monkeypatch.setenv("COLUMNS", "300")
    cube = tmp_path / "cube.npz"
    export = ["export", "L-T/L=5,T=10", "--peak-wavenumber", "0.25", "--gravity", "9.81", "--out", str(cube)]
    assert CliRunner().invoke(app, export).exit_code == 0
    told = json.loads(CliRunner().invoke(app, ["extract", str(cube), "--wavenumbers", "0.3,0.4", "--json"]).stdout)
    record, fastest = told["scope"], np.hypot(*np.transpose(told["doppler_shift_velocities"])).max()
    assert record["wavelengths"] == pytest.approx([2 * np.pi / 0.4, 2 * np.pi / 0.3])
    assert record["fastest_current"] == pytest.approx(fastest)
    assert record["words"].startswith("Deep water, no surface tension, linear waves of 15.7 to 20.9 m in a sea whose ")
    assert "--waves " in record["certify"]
    text = CliRunner().invoke(app, ["extract", str(cube), "--wavenumbers", "0.3,0.4"]).stdout
    assert record["words"] in text
    assert record["certify"] in text


def test_waves_that_are_not_known_in_metres_are_judged_by_no_line():
    here = Scope((2.0, 9.0), 3.0, 0.01, 0.2, units=("/ k0", "c0"), metric=False)
    assert here.certify is None
    assert here.advice == ""
    assert here.words.startswith("Water of a depth of 3 / k0, surface tension 0.01, linear waves of 2 to 9 / k0, one ")
    assert replace(here, wavelengths=None, metric=True).certify is None


def test_words_of_a_campaign_without_current_in_deep_water():
    found = scope(plan(Campaign((60.0, 60.0), 15.0, 15.0), 2))
    assert found.words.startswith("Deep water, no surface tension, linear waves of ")
    assert "declar" not in found.advice

"""Codes in other languages and by other people, as processes: what their certificates say is true.

`real_codes` holds an NSP in Octave, one in C++, and an adapter to iwave, which is AGPL and stays in an environment of
its own. `leakref guide real-codes` tells what each taught.
"""

from __future__ import annotations

import subprocess
from pathlib import Path

import pytest
from tools import iwave_python, requires

from leakref.certify.runner import certify, select
from leakref.certify.strength.diagnosis import explain
from leakref.certify.targets import connect

HERE = Path(__file__).parent / "real_codes"
EXACT = ("signs.aligned", "recovery.pair", "recovery.ring")
SOME = (
    "signs.sea[to-22.5]",
    "signs.aligned[to-112.5]",
    "recovery.pair[odd-1]",
    "recovery.single[even]",
    "currents.backwards",
    "shear.profile[linear]",
    "scale.peak[4]",
    "conformance.extract[nsp-*",
    "behaviour",
)


def certificate(command, *checks):
    """Of the quick profile, or of `checks` alone."""
    pairs = select(checks, profile="quick")
    return certify("code", [connect(command=list(map(str, command)))], pairs, profile="quick")


def verdicts(found):
    return {f.id: str(f.verdict) for f in found.findings}


def octave(source, folder):
    """The command that runs a script of that text."""
    program = requires("octave-cli", "octave")
    (folder / "nsp.m").write_text(source, encoding="utf-8")
    return program, "--quiet", "--no-init-file", "--no-history", folder / "nsp.m"


def cpp(source, folder):
    """The program that is made of that text."""
    compiler = requires("g++")
    (folder / "nsp.cpp").write_text(source, encoding="utf-8")
    subprocess.run(
        [compiler, "-std=c++17", "-O2", "-Wall", "-Wextra", "-Werror", "-o", folder / "nsp", folder / "nsp.cpp"],
        check=True,
    )
    return (folder / "nsp",)


CODES = {"nsp.m": octave, "nsp.cpp": cpp}


def changed(name, old, new):
    """Its source with one thing wrong."""
    source = (HERE / name).read_text(encoding="utf-8")
    assert source.count(old) == 1
    return source.replace(old, new)


@pytest.mark.parametrize("name", [pytest.param("nsp.m", marks=pytest.mark.slow), "nsp.cpp"])
def test_an_nsp_of_one_s_own_is_conformant(name, tmp_path):
    found = certificate(CODES[name]((HERE / name).read_text(encoding="utf-8"), tmp_path), *SOME)
    assert [f for f in found.findings if f.verdict != "pass"] == []
    assert found.grade == "conformant"


@pytest.mark.slow
@pytest.mark.parametrize("name", CODES)
def test_so_it_is_in_the_whole_profile(name, tmp_path):
    found = certificate(CODES[name]((HERE / name).read_text(encoding="utf-8"), tmp_path))
    assert found.wrong == []
    assert found.grade == "conformant"
    assert found.counts["pass"] > 70


@pytest.mark.parametrize(
    ("name", "old", "new", "fault"),
    [
        ("nsp.m", "S = ifft(fft(fft(eta, [], 1), [], 2), [], 3);", "S = fftn(eta);", "time-transform-reversed"),
        ("nsp.m", "sqrt(gravity * size_k(in))", "sqrt(10 * size_k(in))", "gravity-hard-coded"),
        ("nsp.cpp", "Wave wave{kx, -down,", "Wave wave{kx, down,", "flipped-y"),
        ("nsp.cpp", 'pi / (nt * number(line, "dt"))', 'pi / ((nt - 1) * number(line, "dt"))', "duration-short"),
    ],
)
def test_a_mistake_in_it_is_named(name, old, new, fault, tmp_path):
    found = explain(certificate(CODES[name](changed(name, old, new), tmp_path), *EXACT))
    assert found.grade == "rejected"
    assert fault in [one["fault"] for one in found.diagnosis]


def test_a_search_that_starts_with_steps_as_large_as_the_phase_velocity_ends_elsewhere(tmp_path):
    source = changed("nsp.m", "step = 0.01 * sqrt(gravity / wavenumber)", "step = sqrt(gravity / wavenumber)")
    found = verdicts(certificate(octave(source, tmp_path), "recovery.pair[even-1]", "currents.backwards"))
    assert found == {
        "recovery.pair[even-1]": "pass",
        "currents.backwards[opposing]": "fail",
        "currents.backwards[oblique]": "fail",
    }


def iwave(*options):
    return iwave_python(), HERE / "iwave_adapter.py", *options


def test_iwave_is_sound_in_its_own_waves():
    found = certificate(
        iwave("--waves-only", "--fastest", "1.5"),
        "signs.sea",
        "recovery.pair[even-1]",  # clean cubes, which it is shown with a trace of noise
        "recovery.pair[prime-2]",
        "recovery.ring[still]",
        "recovery.sea",
        "leakage.still",
        "depth.aligned[2]",
        "depth.change[1.2-for-0.8]",  # two waves on bins are too few for it
        "scale.peak",
        "scale.duration[brief]",  # shorter than its README asks for
        "behaviour.deterministic",
        "behaviour.refuses[nan]",
    )
    said = verdicts(found)
    assert {name for name, verdict in said.items() if verdict != "pass"} == {
        "depth.change[1.2-for-0.8]",
        "scale.peak[4-untapered]",
        "scale.peak[sixteenth-untapered]",
        "scale.peak[16-untapered]",
        "scale.duration[brief]",
    }
    assert found.wrong == []
    assert found.grade_line.startswith("sound, in waves of 0.5 to 4 m, ")
    assert found.scope()["peak_wavelengths"] == pytest.approx([0.5, 4.0])
    assert found.declaration["can"]["extract"]["resolves"] == "band"


def test_iwave_as_it_comes_is_told_what_it_errs_by():
    found = certificate(iwave(), "signs.sea[to-22.5]", "signs.sea[to-292.5]", "scale.peak[16]")
    (wrong,) = found.wrong
    assert wrong.id == "signs.sea[to-292.5]"
    assert "a current of (0.1148, -0.2772) comes back as (" in wrong.message  # and like no image of it


def test_iwave_in_waves_of_25_metres_is_not():
    found = certificate(
        iwave("--waves", "20", "32"), "signs.sea", "recovery.sea", "scale.peak[4]", "behaviour.deterministic"
    )
    said = verdicts(found)
    assert said.pop("behaviour.deterministic[twice]") == "pass"
    assert set(said.values()) == {"fail"}
    assert found.grade == "rejected"

"""What longer tests see through a whole command, asked of the function that does it: for every day, in a second.

A cube of random numbers is read and no velocity computed; a session is begun and no code asked.
"""

from __future__ import annotations

import json
import os
import re
from dataclasses import replace
from types import SimpleNamespace

import h5py
import numpy as np
import pytest
from PIL import Image
from scipy.io import savemat
from test_report import certificate

from leakref import Grid, LeakrefError, plugin
from leakref.certify import commands, parametrize_with_checks
from leakref.certify.runner import CutShort
from leakref.certify.strength import diagnosis, regime, replays
from leakref.certify.subject.declaration import Declaration
from leakref.certify.verdict import Finding, Unanswered
from leakref.certify.verdict import Verdict as Judgement
from leakref.cubes import causes, depths, measuring
from leakref.cubes.asked import Asked, Assumed
from leakref.cubes.causes import Verdict
from leakref.cubes.coordinates import metric_factors
from leakref.cubes.cube import Cube
from leakref.cubes.depths import Fit
from leakref.cubes.formats import contents
from leakref.cubes.reading import read
from leakref.cubes.waters import water_of
from leakref.dispersion import Water
from leakref.exam.replaying import Replay

X, Y, T = np.arange(6) * 0.3, np.arange(5) * 0.2, np.arange(12) * 0.1
ETA = np.random.default_rng(0).normal(size=(6, 5, 12))


@pytest.mark.parametrize(("dt", "g"), [(0.04, 9.81), (2.0, 1.0), (0.5, 981.0)])
def test_each_remedy_undoes_its_cause(dt, g):
    cube = Cube(np.zeros((4, 4, 4)), Grid((4, 4, 4), (0.3, 0.3, dt)), g)
    for cause in causes._causes(cube):
        told = re.search(r"--(spacing|gravity) (\S+)", cause.remedy)
        if told and told[1] == "spacing":
            dx, _, step = map(float, told[2].split(","))
            factor = step / dt * (dx / 0.3) ** -0.5
        else:
            factor = (float(told[2]) / g) ** 0.5 if told else 111195**-0.5
        assert factor == pytest.approx(cause.factor, rel=1e-4), cause.words


def test_names_in_matlab_files_are_found_and_members_are_numbered_from_one(tmp_path):
    savemat(tmp_path / "a.mat", {"heights": ETA.T, "X": X, "Y": Y, "time": T, "g": 9.81})
    assert read(tmp_path / "a.mat").assumed.axes == "tyx"
    film = np.zeros((1, 2), dtype=[("IMG", object)])
    film[0, 0], film[0, 1] = (ETA,), (ETA,)
    savemat(tmp_path / "b.mat", {"FILM": film})
    assert list(contents(tmp_path / "b.mat")) == ["FILM(1).IMG", "FILM(2).IMG"]
    with h5py.File(tmp_path / "c.mat", "w", userblock_size=512) as file:
        held = file.create_dataset("#refs#/a", data=ETA.T)
        file.create_dataset("FILM/IMG", data=np.array([[held.ref], [held.ref]], dtype=object), dtype=h5py.ref_dtype)
    with (tmp_path / "c.mat").open("r+b") as stream:
        stream.write(b"MATLAB 7.3 MAT-file, Platform: GLNXA64".ljust(124) + b"\x00\x02IM")
    assert list(contents(tmp_path / "c.mat")) == ["FILM(1).IMG", "FILM(2).IMG"]


def stamped(path, t, eta=ETA):
    np.savez(path, eta=eta[:, :, : len(t)], x=X, y=Y, t=t, gravity=9.81)
    return path


def test_stamps_frames_twice_and_frames_lost_are_seen_when_a_file_is_read(tmp_path):
    t = T + np.random.default_rng(0).normal(size=T.size) * 0.005
    assert any("unsteady" in note for note in read(stamped(tmp_path / "a.npz", t)).notes)
    with pytest.raises(LeakrefError, match="unlike it"):
        read(stamped(tmp_path / "b.npz", T[np.r_[0:5, 4, 6:12]]))
    twice = (np.arange(10) * 4) // 5
    path = stamped(tmp_path / "c.npz", np.arange(10) * 0.08, ETA[:, :, twice])
    assert read(path, drop_doubled=True).grid.spacing[2] == pytest.approx(0.1)
    kept = np.delete(np.arange(12), 5)
    path = stamped(tmp_path / "d.npz", T[kept], ETA[:, :, kept])
    with pytest.raises(LeakrefError) as refused:
        read(path)
    assert read(path, holes=float(re.search(r"--fill-holes (\S+)", str(refused.value))[1])).surface.shape[2] == 12


def test_images_come_in_the_order_of_their_numbers_and_bytes_without_rows_are_told(tmp_path):
    (tmp_path / "film").mkdir()
    for n in range(12):
        Image.fromarray(np.full((5, 6), 10 * n, np.uint8)).save(tmp_path / "film" / f"frame_{n}.png")
    cube = read(tmp_path / "film", spacing=(1, 1, 1), gravity=1.0, y="up")
    assert (cube.assumed.y, cube.surface[0, 0].tolist()) == ("up", [10.0 * n for n in range(12)])
    np.save(tmp_path / "a.npy", np.uint8(50 + 9 * ETA))
    assert any("--y down" in n for n in read(tmp_path / "a.npy", spacing=(1, 1, 1), gravity=1.0, axes="xyt").notes)
    assert metric_factors({"x": "m", "y": "m", "t": "milliseconds"})["t"] == 1e-3


def water(raw, units="si", gravity=9.81, factor=1.0, **asked):
    notes = []
    return water_of("a", raw, units, dict.fromkeys("xyt", factor), gravity, Asked(**asked), notes), notes


def test_water_of_a_file_and_of_an_option_in_any_unit():
    assert water({"depth": 300.0, "units of depth": "cm"}, factor=1e3)[0].depth == pytest.approx(3)
    with pytest.raises(LeakrefError, match="is in metres"):
        water({}, "scaled", 1.0, depth="3m")
    assert water({"depth": 3.0}, depth="3.2m")[1] == ["WARNING: --depth 3.2 was taken, and the file says depth = 3"]
    said, notes = water({"depth": 0.49, "coordinate depth": True})
    assert (said.depth, len(notes)) == (np.inf, 1)
    line = Assumed("eta", "xyt", "up", "si", 9.81, (1, 1, 1), 0.05, 7.29e-5, {"depth": "--depth"}).line()
    assert "depth 0.05 m (--depth); surface tension 7.29e-05 m3/s2" in line


def test_what_was_found_and_removed_is_said():
    cube = SimpleNamespace(units="si", depth=np.inf)
    assert "from 2 m up fits" in measuring._depth_words(cube, Verdict(True, 0.5, (), (2.0, np.inf)))[0]
    assert measuring._trend_words("mean", np.array([1000.0, 0, 0, 0])) == "the mean, 1000, was removed"


def test_what_is_too_large_for_memory_is_refused(monkeypatch):
    cube = Cube(np.zeros((40, 40, 40)), Grid((40, 40, 40), (1, 1, 1)), 1.0)
    monkeypatch.setattr(measuring, "KEPT", 10**5)
    with pytest.raises(LeakrefError, match="up to some"):
        measuring._reach(cube, measuring.Request(wavenumbers=np.array([1.0])), [])
    with pytest.raises(LeakrefError, match="too large"):
        measuring._reach(cube, measuring.Request(screening=True, angle=20.0), [])


def test_options_of_certify_arrive_and_what_was_found_is_written(monkeypatch, tmp_path, capsys):
    seen = []

    def connect(*target, **settings):
        seen.append(settings)

    def cut(*asked, known, **settings):
        seen.append(known)
        raise CutShort(certificate())

    monkeypatch.setattr(commands, "connect", connect)
    monkeypatch.setattr(commands, "certify", cut)
    known = tmp_path / "known.toml"
    known.write_text('"signs.aligned[to-22.5]" = {reason = "rows", issue = "#1"}\n')
    request = commands.Request("reference", None, start=0.6, waves="50cm:4m", known=known, report=tmp_path / "r")
    with pytest.raises(KeyboardInterrupt):
        commands.run(request)
    assert seen[0]["limits"].start == 0.6
    assert seen[0]["waves"] == {"peak_wavelength": [0.5, 4.0]}
    assert list(seen[-1]) == ["signs.aligned[to-22.5]"]
    assert {path.name for path in (tmp_path / "r").iterdir()} == {
        "certificate.html",
        "certificate.json",
        "junit.xml",
        "badge.svg",
    }
    assert "TARGET" not in (tmp_path / "r" / "certificate.json").read_text()


def test_a_known_failure_that_passes_is_told(capsys):
    found = certificate()
    passing = replace(found.findings[-1], verdict=Judgement.PASS)
    known = {passing.id: replace(next(iter(found.known.values())), id=passing.id)}
    commands._print(replace(found, findings=[*found.findings[:-1], passing], known=known), (), ())
    assert f"out of date {passing.id}" in " ".join(capsys.readouterr().out.split())


def report(outcome, **more):
    return SimpleNamespace(outcome=outcome, when="call", keywords={plugin.MARK: 1}, **more)


@pytest.mark.parametrize("status", [0, 5])
def test_a_session_that_judged_nothing_fails(status):
    def ended(*reports):
        judged = plugin.Judged()
        for one in reports:
            judged.pytest_runtest_logreport(one)
        option = SimpleNamespace(collectonly=False)
        session = SimpleNamespace(exitstatus=status, config=SimpleNamespace(option=option))
        judged.pytest_sessionfinish(session)
        return session.exitstatus

    assert ended() == ended(report("skipped")) == 1
    assert ended(report("passed")) == ended(report("skipped", wasxfail="known")) == status


@pytest.mark.parametrize("marked", [True, False])
def test_a_file_that_asks_by_itself_is_watched(marked):
    registered = []
    plugins = SimpleNamespace(has_plugin=lambda name: False, register=lambda *what: registered.append(what))
    item = SimpleNamespace(get_closest_marker=lambda name: marked and name == plugin.MARK)
    plugin.pytest_collection_finish(SimpleNamespace(config=SimpleNamespace(pluginmanager=plugins), items=[item]))
    assert [name for _, name in registered] == marked * [plugin.ASKED]


def test_a_decorated_test_takes_the_profile_that_it_names():
    quick, full = (
        parametrize_with_checks("reference", only=["signs.aligned"], profile=profile).mark.args[1]
        for profile in ("quick", "full")
    )
    assert 0 < len(quick) < len(full)


def test_the_waves_in_which_a_code_is_right_are_found_and_advised(monkeypatch):
    assert regime._edge(lambda x: x < 1.3, 0.0, 4.0) == pytest.approx(1.3, abs=regime.CLOSE)
    monkeypatch.setattr(regime, "right_between", lambda subject: (1.6, 30.0))
    wrong = SimpleNamespace(wrong=[SimpleNamespace(id="scale.peak[1]")])
    assert "of 1.6 to 30 m" in diagnosis._regime(wrong, None)
    assert "--waves 1.6m:30m" in diagnosis._regime(wrong, None)


def test_answers_of_faults_are_kept_for_these_sources_and_the_oldest_go(tmp_path, monkeypatch):
    monkeypatch.setattr(replays, "_FILES", 2)
    asked = json.dumps({"seed": replays.PUBLISHED, "golden": 2})
    finding = Finding("q", "signs", Judgement.FAIL, "wrong")

    def kept(identifier):
        return replays._Store(tmp_path).get(identifier, ("a-fault",), asked)

    for n, identifier in enumerate("abc"):
        store = replays._Store(tmp_path)
        store.put(identifier, ("a-fault",), asked, finding, ())
        store.flush()
        os.utime(store._place(identifier, asked)[0], (n, n))
    assert [kept(identifier) is not None for identifier in "abc"] == [False, True, True]
    monkeypatch.setattr(replays, "_sources", lambda golden: "others")
    assert kept("c") is None


def test_a_question_that_was_not_foreseen_is_unsupported(tmp_path):
    with pytest.raises(Unanswered) as said:
        Replay(Declaration(), {}, tmp_path, "npz")._work("window", {}, {"name": "hann", "size": 8})
    assert said.value.verdict is Judgement.UNSUPPORTED


@pytest.mark.parametrize(("own", "words"), [(np.inf, "depths 0.4 to 0.6 fit as well"), (0.5, "energy).")])
def test_depths_that_fit_as_well_are_said_where_the_depth_is_in_question(own, words):
    other = Fit(SimpleNamespace(share=0.9), Water(1.0, 0.5), 0.4, 0.6)
    band = SimpleNamespace(water=Water(1.0, own, 0.0 if own == np.inf else 1e-4))
    assert words in causes._in_other_water(band, other, SimpleNamespace(units="scaled"))


@pytest.mark.parametrize(("k", "is_metric", "tensions"), [(300.0, True, 2), (300.0, False, 1), (1.0, True, 1)])
def test_surface_tension_is_looked_for_in_metres_where_waves_are_short(monkeypatch, k, is_metric, tensions):
    tried = []

    def best(band, tension):
        tried.append(tension)
        return Fit(SimpleNamespace(share=0.5), Water(9.81, np.inf, tension), 1.0, 2.0)

    monkeypatch.setattr(depths, "_at_best_depth", best)
    depths.fit(SimpleNamespace(water=Water(9.81), kx=np.array([k]), ky=np.array([0.0])), is_metric)
    assert len(tried) == tensions

"""Seas as poor sensors see them: each against one made otherwise, breakdowns, what is kept, two mistakes."""

from __future__ import annotations

import json
from dataclasses import replace
from zlib import crc32

import jsonschema
import numpy as np
import pytest
from scipy.optimize import minimize
from scipy.special import ndtri
from test_report import certificate

from leakref import chain, nsp
from leakref._output import dump, plain
from leakref.certify.certificate import schema
from leakref.certify.checks import inputs
from leakref.certify.checks.criteria import unflagged
from leakref.certify.measures import stress as module
from leakref.certify.measures import stressfigure
from leakref.certify.measures.stress import STRESSES, Curve, Found, seas, stress
from leakref.certify.report import page
from leakref.certify.subject.inprocess import InProcess
from leakref.dispersion import DEEP, Water
from leakref.golden import beside
from leakref.grid import Grid
from leakref.shell import shell_at
from leakref.spectrum import fourier
from leakref.synthesis import synthesize

BY = {one.name: one for one in STRESSES}
VELOCITY = 0.4 * np.array([np.cos(np.radians(200)), np.sin(np.radians(200))])


def some(name, *levels):
    return [replace(BY[name], levels=levels)]


@pytest.fixture(scope="module")
def sea():
    return seas()[1]


def wave_by_wave(w, x, y, t):
    """The surface at one point, by its definition."""
    return float(np.sum(w.amplitude * np.cos(w.kx * x + w.ky * y - w.omega * t + w.phase)))


# ---------------------------------------------------------------- what is done to a sea


def test_noise_is_white_normal_and_as_strong_as_it_says(sea):
    added = BY["noise"].shown(sea, 5.0, 1) - sea.surface
    n = added.size
    assert 10 * np.log10(sea.surface.var() / added.var()) == pytest.approx(
        5.0, abs=5 * 10 / np.log(10) * np.sqrt(2 / n)
    )
    z = (added - added.mean()) / added.std()
    assert abs((z**3).mean()) < 5 * np.sqrt(6 / n)
    assert abs((z**4).mean() - 3) < 5 * np.sqrt(24 / n)
    for axis in range(3):
        assert abs((z * np.roll(z, 1, axis=axis)).mean()) < 5 / np.sqrt(n)
    np.testing.assert_allclose(BY["noise"].shown(sea, 25.0, 1) - sea.surface, added / 10, rtol=1e-9, atol=1e-15)
    assert np.abs(BY["noise"].shown(sea, 5.0, 2) - sea.surface - added).max() > added.std()  # another sea, other noise


@pytest.mark.parametrize("bits", [16, 8, 2])
def test_grey_values_are_whole_and_use_the_whole_range(sea, bits):
    seen = BY["grey"].shown(sea, bits, 0)
    assert (seen.min(), seen.max()) == (0, 2**bits - 1)
    np.testing.assert_array_equal(seen, np.rint(seen))
    back = sea.surface.min() + seen / (2**bits - 1) * np.ptp(sea.surface)
    assert np.abs(back - sea.surface).max() <= np.ptp(sea.surface) / (2**bits - 1) * 0.5000001


def test_slope_is_the_derivative_along_x_and_all_of_it_at_a_hundred_percent(sea):
    seen = BY["slope"].shown(sea, 100.0, 0)

    def rise(*at):
        x, y, t = (sea.grid.samples(axis)[n] for axis, n in enumerate(at))
        return (wave_by_wave(sea.components, x + 1e-5, y, t) - wave_by_wave(sea.components, x - 1e-5, y, t)) / 2e-5

    factor = seen[7, 5, 9] / rise(7, 5, 9)
    assert factor > 0
    for at in ((20, 30, 60), (49, 0, 79)):
        assert seen[at] == pytest.approx(factor * rise(*at), abs=1e-6)
    assert seen.std() == pytest.approx(1.0)
    quarter = BY["slope"].shown(sea, 25.0, 0)
    np.testing.assert_allclose(quarter, 0.25 * seen + 0.75 * sea.surface / sea.surface.std(), atol=1e-12)


def test_only_crests_are_seen(sea):
    seen = BY["crests"].shown(sea, 1.0, 0)
    over = sea.surface > sea.surface.std()
    assert np.array_equal(seen > 0, over)
    assert 0.1 < over.mean() < 0.2  # of a normal surface 0.159
    np.testing.assert_allclose(seen[over] + sea.surface.std(), sea.surface[over], rtol=1e-12)


def test_harmonics_hold_every_pair_of_waves_at_the_sum_of_both_and_nothing_else():
    """Three waves: nine pairs, against their sum written out."""
    three = inputs.waves(inputs.SEA, np.array([0.7, -0.4, 0.9]), np.array([0.5, 0.8, -0.3]), (1.2,))
    three = replace(three, components=replace(three.components, amplitude=np.array([1.0, 0.6, 0.3])))
    added = BY["harmonics"].shown(three, 20.0, 0) - three.surface
    w, (x, y, t) = three.components, np.meshgrid(*(three.grid.samples(a) for a in range(3)), indexing="ij")
    pairs = sum(
        w.amplitude[m] * w.amplitude[n]
        * np.cos((w.kx[m] + w.kx[n]) * x + (w.ky[m] + w.ky[n]) * y - (w.omega[m] + w.omega[n]) * t
                 + w.phase[m] + w.phase[n])
        for m in range(3) for n in range(3)
    )  # fmt: skip
    np.testing.assert_allclose(added / added.std(), pairs / pairs.std(), atol=1e-10)
    assert added.std() == pytest.approx(0.2 * three.surface.std(), rel=1e-12)


def test_jitter_moves_whole_frames_by_a_pixel_in_the_mean(sea):
    seen = BY["jitter"].shown(sea, 1.0, 3)
    x, y, t = (sea.grid.samples(axis) for axis in range(3))
    found = []
    for n in range(0, 80, 4):  # where the frame was looked at from, found again by fitting

        def off(d, n=n):
            return ((synthesize(sea.components, x[::5] + d[0], y[::5] + d[1], t[[n]]) - seen[::5, ::5, [n]]) ** 2).sum()

        fit = minimize(off, [0.0, 0.0], method="Nelder-Mead", options={"xatol": 1e-6, "fatol": 1e-14})
        assert fit.fun < 1e-8 * (seen[::5, ::5, n] ** 2).sum()
        found.append(fit.x / sea.spacing[:2])
    key = np.array([1, crc32(repr(("stress", "jitter", 3)).encode())], dtype=np.uint64)
    drawn = ndtri((np.random.Philox(key=key).random_raw(160) / 2.0**64).reshape(2, 80))[:, ::4]
    np.testing.assert_allclose(np.transpose(found), drawn, atol=1e-4)
    np.testing.assert_allclose(BY["jitter"].shown(sea, 0.0, 3), sea.surface, atol=1e-12)


def test_one_column_flickers_and_no_other(sea):
    seen = BY["column"].shown(sea, 10.0, 0)
    changed = (seen != sea.surface).any(axis=(1, 2))
    assert np.flatnonzero(changed).tolist() == [16]
    assert np.ptp(seen[16], axis=0).max() == 0  # as a whole
    assert seen[16, 0].std() / sea.surface.std() == pytest.approx(10, rel=4 / np.sqrt(2 * 80))


@pytest.mark.parametrize("gone", [16])
def test_lost_frames_are_missing_and_the_video_goes_on(sea, gone):
    seen = BY["lost"].shown(sea, gone, 2)
    longer = Grid((50, 44, 80 + gone), sea.spacing)
    whole = replace(sea, grid=longer).surface
    at = [int(np.argmin(((whole[::7, ::7] - seen[::7, ::7, [n]]) ** 2).sum(axis=(0, 1)))) for n in range(80)]
    np.testing.assert_allclose(whole[:, :, at], seen, atol=1e-11)
    assert at[0] == 0
    assert (np.diff(at) >= 1).all()
    assert at[-1] <= 79 + gone
    assert len(set(range(80)) - set(at)) == gone


def test_from_a_platform_points_move_against_its_course(sea):
    seen = BY["platform"].shown(sea, 0.4, 0)
    for i, j, m in ((3, 40, 70), (25, 10, 33), (49, 0, 79)):
        x, y, t = (sea.grid.samples(axis)[n] for axis, n in enumerate((i, j, m)))
        there = wave_by_wave(sea.components, x + VELOCITY[0] * t, y + VELOCITY[1] * t, t)
        assert seen[i, j, m] == pytest.approx(there, abs=1e-10)
    np.testing.assert_allclose(BY["platform"].velocity(0.4), VELOCITY, rtol=1e-12)
    assert not any(one.velocity(0.4).any() for one in STRESSES if one.name != "platform")


def test_no_sea_or_current_is_its_own_image_where_axes_are_exchanged():
    for direction, _, current in module.SEAS:
        assert abs(np.sin(np.radians(2 * direction) - np.pi / 2)) > 0.3
        assert current is None or abs(current[0] - current[1]) > 0.1
    assert all(unflagged(cube, "hann", "nsp").all() for cube in seas())


# ---------------------------------------------------------------- what is made of it


def curve(*means, levels=(10, 20, 40), name="jitter"):
    """Of one sea at two wavenumbers, with a smaller resolution of 1; None is no answer."""
    errors = np.array([[[np.nan if m is None else m] * 2] for m in means])
    one = replace(BY[name], levels=levels, unit=" px")
    return Curve(one, errors, np.ones((1, 2)), errors)


@pytest.mark.parametrize(
    ("means", "doubles", "passes"),
    [
        ((0.4, 0.4, 0.6, 1.4), "at 25 px", "at 30 px"),
        ((0.4, 0.5, 0.6, 0.7), "not within what was tried", "not within what was tried"),
        ((0.4, 0.9, 0.6, 0.7), "already at 10 px, the mildest", "not within what was tried"),
        ((1.1, 1.1, 1.1, 1.1), "not within what was tried", "already in the seas as they are"),
        ((0.4, 0.4, None, 1.2), "at 25 px", "at 32 px"),
        ((0.4, 0.4, None, None), "no answer from 20 px on", "no answer from 20 px on"),
        ((0.4, 1.4, None, None), "already at 10 px, the mildest", "already at 10 px, the mildest"),
        ((0.0, 0.0, 0.0, 0.0), "not within what was tried", "not within what was tried"),
        ((0.4, 0.4, 1.2, 0.3), "at 15 px", "at 18 px"),  # the first time counts
    ],
)
def test_breakdowns_lie_between_levels(means, doubles, passes):
    found = curve(*means)
    assert (found.doubles.words, found.passes.words) == (doubles, passes)
    level = found.doubles.level
    assert (
        np.isnan(level)
        if "px" not in doubles or "no answer" in doubles
        else doubles.startswith((f"at {level:g}", f"already at {level:g}"))
    )


def test_errors_are_doubled_over_what_was_answered_in_both():
    one = replace(BY["jitter"], levels=(1, 2))
    errors = np.array([[[0.1, 0.9]], [[0.15, np.nan]], [[0.25, np.nan]]])
    found = Curve(one, errors, np.array([[0.2, 0.05]]), errors)
    assert found.doubles.level == pytest.approx(1.5)
    assert found.answered.tolist() == [0.5, 0.5]
    assert found.passes.words == "already in the seas as they are"


def test_galileo_holds_up_to_a_speed():
    assert curve(0.0, 0.1, 0.2, 0.3).holds_to(0.25) == 20
    assert curve(0.0, 0.3, 0.1, 0.1).holds_to(0.25) == 0  # not at the first, so at none
    assert curve(0.0, 0.1, 0.1, 0.1).holds_to(0.25) == 40
    assert curve(0.0, 0.1, None, 0.1).holds_to(0.25) == 10


# ---------------------------------------------------------------- what is kept of the reference


def kept():
    return {row["stress"]: row["velocities"] for row in beside.read("stress.json")["rows"]}


def test_what_is_kept_is_of_these_seas_and_levels():
    golden = beside.read("stress.json")
    assert [row["stress"] for row in golden["rows"]] == ["none"] + [
        f"{one.name} {level:g}" for one in STRESSES for level in one.levels
    ]
    assert golden["seas"] == plain(module.SEAS)
    assert golden["wavenumbers"] == list(inputs.SHELLS)
    assert {np.array(row["velocities"], dtype=float).shape for row in golden["rows"]} == {(4, 4, 2)}


def by_hand(surface, cube, k):
    """N maximised from zero current over a shell of a numpy FFT, without `extract`, by another optimiser."""
    spectrum = fourier(surface - surface.mean(), Grid(surface.shape, cube.spacing), "hann")
    shell = shell_at(spectrum, k, water=DEEP)
    width = nsp.WIDTH * cube.grid.frequency_resolution
    start = minimize(
        lambda c: -nsp.normalized_scalar_product(shell, c, width), [0.0, 0.0], method="BFGS", options={"gtol": 1e-9}
    )
    return start.x


@pytest.mark.parametrize(
    ("name", "level", "number"),
    [("harmonics", 20, 3), ("platform", 0.1, 1), ("grey", 8, 0)],
)
def test_what_is_kept_is_found_again_in_seas_degraded_otherwise(name, level, number):
    """The sea degraded with words of its own; 1e-6 is what BFGS leaves of a maximum of curvature one at 1e-13 in N."""
    cube, again = seas()[number], None
    w, (x, y, t) = cube.components, (cube.grid.samples(a) for a in range(3))
    if name == "harmonics":
        z = np.einsum(
            "wx,wy,wt->xyt", w.amplitude[:, None] * np.exp(1j * (np.outer(w.kx, x) + w.phase[:, None])),
            np.exp(1j * np.outer(w.ky, y)), np.exp(-1j * np.outer(w.omega, t)), optimize=True,
        )  # fmt: skip
        bound = (z**2).real
        again = z.real + 0.2 * z.real.std() * bound / bound.std()
    elif name == "platform":
        moving = [wave_by_wave_in_plane(w, x + VELOCITY[0] / 4 * s, y + VELOCITY[1] / 4 * s, s) for s in t]
        again = np.stack(moving, axis=2)
    else:
        levels = np.linspace(cube.surface.min(), cube.surface.max(), 256)
        again = np.searchsorted((levels[1:] + levels[:-1]) / 2, cube.surface).astype(float)
    golden = np.array(kept()[f"{name} {level}"][number], dtype=float)
    found = [by_hand(again, cube, k) for k in inputs.SHELLS[:3]]
    np.testing.assert_allclose(found, golden[:3], atol=1e-6)


def wave_by_wave_in_plane(w, x, y, t):
    """One frame (nx, ny) as a sum over all waves."""
    left = w.amplitude * np.exp(1j * (np.outer(x, w.kx) + w.phase - w.omega * t))
    return (left @ np.exp(1j * np.outer(w.ky, y))).real


@pytest.mark.slow
@pytest.mark.parametrize("one", STRESSES, ids=lambda one: one.name)
def test_all_that_is_kept_is_what_the_chain_finds(one):
    """Beside rounding of the surface (1e-15) a grey value may flip where another processor rounds otherwise."""
    for number, cube in enumerate(seas()):
        for level in one.levels:
            seen = one.shown(cube, level, number)
            found = chain.extract(seen, cube.spacing, cube.wavenumbers, gravity=1.0).velocities
            golden = np.array(kept()[f"{one.name} {level:g}"][number], dtype=float)
            np.testing.assert_allclose(found, golden, atol=1e-4 if one.name == "grey" else 1e-7)


@pytest.mark.slow
def test_it_is_made_anew_the_same(tmp_path):
    path = module.regenerate(tmp_path / "stress.json")
    again, golden = json.loads(path.read_text(encoding="utf-8")), beside.read("stress.json")
    assert [row["stress"] for row in again["rows"]] == [row["stress"] for row in golden["rows"]]
    for row, other in zip(again["rows"], golden["rows"], strict=True):
        a, b = (np.array(r["velocities"], dtype=float) for r in (row, other))
        np.testing.assert_allclose(a, b, atol=1e-4 if row["stress"].startswith("grey") else 1e-7)


# ---------------------------------------------------------------- codes under it


def by_chain(surface, spacing, wavenumbers, *, gravity, window):
    found = chain.extract(surface, spacing, wavenumbers, gravity=gravity, window=window).velocities
    return [None if np.isnan(c).any() else c for c in found]


def only(monkeypatch, *numbers):
    """Some of the seas are enough to see something, and what is kept is of those."""
    cubes, velocities = seas(), kept()
    monkeypatch.setattr(module, "seas", lambda: [cubes[n] for n in numbers])
    monkeypatch.setattr(module, "_kept", lambda: {name: [c[n] for n in numbers] for name, c in velocities.items()})


def test_the_reference_is_as_it_is_kept_and_is_not_computed_again(monkeypatch):
    only(monkeypatch, 0, 1)
    monkeypatch.setattr(module, "_reference", None)
    shown = []
    stresses = [*some("harmonics", 5, 30), *some("platform", 0.1)]
    found, moved = stress(InProcess(by_chain), stresses, after_each=lambda: shown.append(1))
    assert len(shown) == 8
    np.testing.assert_allclose(found.own.errors, found.reference.errors, atol=1e-9)
    np.testing.assert_allclose(moved.own.galilean, moved.reference.galilean, atol=1e-9)
    assert moved.own.mean[1] < 0.04  # the velocity of the platform, 0.1, is taken off
    assert moved.record()["galilean"]["holds_to"] == 0.1
    assert "follow the platform to within the larger resolution up to 0.1 c0 (reference: up to 0.1 c0)" in moved.words
    record = json.loads(dump(found.record()))
    form = schema()
    jsonschema.validate(record, {**form["properties"]["stress"]["items"], "$defs": form["$defs"]})
    assert record["error"] == pytest.approx(record["reference_error"], abs=1e-9)
    assert record["doubles"] == {"level": None, "words": "not within what was tried"}


@pytest.mark.parametrize(("bits", "kind"), [(8, np.int8), (16, np.int16)])
def test_integers_that_wrap_around_show_up(bits, kind):
    """A camera's whole numbers taken into a type that is too small for them; elevations are none and stay right."""

    def wraps(surface, spacing, wavenumbers, *, gravity, window):
        if (surface == np.rint(surface)).all():
            surface = surface.astype(np.int64).astype(kind)
        return by_chain(surface.astype(float), spacing, wavenumbers, gravity=gravity, window=window)

    (found,) = stress(InProcess(wraps), some("grey", bits))
    assert found.own.doubles.level == bits
    assert "not within" in found.reference.doubles.words
    assert found.own.mean[1] > 2 * found.own.mean[0]
    assert found.own.mean[0] == pytest.approx(found.reference.mean[0], abs=1e-9)
    assert f"error doubled: already at {bits} bits, the mildest" in found.words


def with_harmonics(exchanged):
    """The NSP with a branch for bound second harmonics, at twice the frequency of waves of half the wavenumber, its
    Doppler shift read with kx and ky exchanged or not. From the maximum without it, half as wide, so that the two
    branches are apart.
    """

    def extract(surface, spacing, wavenumbers, *, gravity, window):
        grid = Grid(surface.shape, spacing)
        spectrum, a = fourier(surface - surface.mean(), grid, window), 2 * grid.frequency_resolution
        found, starts = [], nsp.extract(spectrum, wavenumbers, gravity=gravity).velocities
        for k, start in zip(wavenumbers, starts, strict=True):
            s = shell_at(spectrum, k, water=Water(gravity))
            other = (s.ky, s.kx) if exchanged else (s.kx, s.ky)
            weight = np.asarray(s.weight)

            def minus(step, s=s, other=other, weight=weight, start=start):
                c = start + 0.02 * step  # BFGS begins with a step of one: over the nearest maximum, were it c0
                first = s.intrinsic + s.kx * c[0] + s.ky * c[1]
                second = np.sqrt(2) * s.intrinsic + other[0] * c[0] + other[1] * c[1]
                g = sum(np.exp(-(((s.omega - m[:, None]) / a) ** 2) * 2) for m in (first, second))
                return -float(((s.magnitude * g) @ weight).sum() / (s.magnitude @ weight).sum() / (g @ weight).mean())

            fit = minimize(minus, [0.0, 0.0], method="BFGS", options={"gtol": 1e-5})
            found.append(start + 0.02 * fit.x)
        return np.array(found)

    return extract


def test_harmonics_read_with_axes_exchanged_show_up(monkeypatch):
    """In waves of 20 and of 165 degrees on currents; at 45 degrees on no current nothing would be seen of it."""
    only(monkeypatch, 1, 3)
    right, wrong = (stress(InProcess(with_harmonics(e)), some("harmonics", 30))[0].own for e in (False, True))
    assert (right.doubles.words, right.passes.words) == ("not within what was tried",) * 2
    assert wrong.mean[0] < 1.5 * right.mean[0]  # without harmonics it is as good
    assert wrong.doubles.level == wrong.passes.level == 30
    assert wrong.mean[1] > 4 * right.mean[1]


@pytest.mark.slow
def test_such_a_code_is_seen_in_all_seas_too():
    right, wrong = (stress(InProcess(with_harmonics(e)), [BY["harmonics"]])[0].own for e in (False, True))
    assert right.passes.words == "not within what was tried"
    # in still water its branch takes waves of another direction for harmonics
    assert wrong.passes.words != "not within what was tried"


def test_codes_of_other_kinds_are_looked_at_as_well(monkeypatch):
    """In metres, of one water of its own, of square pixels, with one answer, with wavenumbers of its own, that decline
    or fail: nothing is raised, and grey values reach all as whole numbers.
    """
    only(monkeypatch, 0)
    seen = []

    class Code:
        def __init__(self, **said):
            self.said = said

        def describe(self):
            return {"units": "si", **self.said}

        def extract(self, surface, spacing, wavenumbers, *, gravity, window):
            seen.append(surface)
            if surface.max() > 10:
                if self.said.get("fails"):
                    raise RuntimeError("clouds")
                assert np.array_equal(surface, np.rint(surface))
            return by_chain(surface, spacing, wavenumbers, gravity=gravity, window=window)

    (metres,) = stress(InProcess(Code()), some("grey", 16))
    np.testing.assert_allclose(metres.own.errors, metres.reference.errors, atol=1e-8)
    assert seen[-1].max() == 2**16 - 1
    assert np.ptp(seen[0]) > 0.1
    (fails,) = stress(InProcess(Code(fails=True)), some("grey", 16, 8))
    assert np.isnan(fails.own.mean[1:]).all()
    assert fails.own.answered.tolist() == [0, 0]
    assert "error doubled: no answer from 16 bits on" in fails.words
    assert json.loads(dump(fails.record()))["error"][1:] == [None, None]
    assert stress(InProcess(lambda surface, spacing, wavenumbers: [None] * 4), some("grey", 16)) == []


def test_other_water_and_square_pixels_have_the_reference_computed_along(monkeypatch):
    monkeypatch.setattr(module, "SEAS", module.SEAS[:1])
    monkeypatch.setattr(module, "_kept", None)  # it is of other seas

    class Shallow:
        def describe(self):
            return {"units": "si", "water": {"depth": 0.3}}

        def extract(self, surface, spacing, wavenumbers, *, gravity, window):
            assert surface.max() < 10 or np.array_equal(surface, np.rint(surface))
            water = Water(gravity, depth=0.3)
            return chain.extract(surface, spacing, wavenumbers, water=water, window=window).velocities

    class Square:
        def describe(self):
            return {"fixed": ["dy"]}

        def extract(self, surface, spacing, wavenumbers, *, gravity, window):
            dx, _, dt = spacing
            return by_chain(surface, (dx, dx, dt), wavenumbers, gravity=gravity, window=window)

    for code in (Shallow(), Square()):
        (found,) = stress(InProcess(code), some("grey", 8))
        np.testing.assert_allclose(found.own.errors, found.reference.errors, atol=1e-6)
        assert np.isfinite(found.own.mean).all()


def test_the_page_has_a_table_and_a_figure():
    found = [Found(curve(0.4, 0.4, 0.6, 1.4, name=one), curve(0.4, 0.4, 0.5, None, name=one), 2.0) for one in BY]
    picture = stressfigure.picture(found)
    rows = picture["table"]["rows"]
    assert rows[5][1:] == ["at 25 px", "no answer from 40 px on", "at 30 px", "no answer from 40 px on"]
    assert {len(row) for row in rows} == {len(picture["table"]["head"])}
    assert (
        "Answers follow the platform to within the larger resolution up to 40 c0 (reference: up to 20 c0)."
        in picture["words"]
    )
    text = page(replace(certificate(), stress=[one.record() for one in found]), [picture])
    assert text.count("<td>at 25 px</td>") == len(BY)
    assert "data:image/png;base64,iVBOR" in text
    assert "under stress" in text
    assert "a camera that moves" in page(certificate())
    form = schema()
    records = json.loads(dump([one.record() for one in found]))
    jsonschema.validate(records, {**form["properties"]["stress"], "$defs": form["$defs"]})

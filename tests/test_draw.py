"""What a seed makes of the questions, and codes that would like to be asked the published ones."""

from __future__ import annotations

from contextlib import nullcontext
from dataclasses import replace
from zlib import crc32

import numpy as np
import pytest

from leakref import LeakrefError
from leakref.certify import commands
from leakref.certify.checks import inputs, shear
from leakref.certify.checks.draw import _TURNS, DRAWN, PUBLISHED, Draw
from leakref.certify.checks.registry import FAMILIES, Case
from leakref.certify.runner import certify, select
from leakref.certify.strength import faults
from leakref.certify.strength.diagnosis import diagnose
from leakref.certify.subject.inprocess import InProcess
from leakref.chain import Reference, reference
from leakref.currents import ExponentialCurrent, LinearCurrent, UniformCurrent

SEA = {"direction": 40.0, "spread": 60.0, "current": UniformCurrent((0.2, -0.1))}


def drawn(seed: int, make=lambda: inputs.sea(**SEA)) -> inputs.Cube:
    with inputs.asked(InProcess(reference), seed):
        return make()


def pair() -> inputs.Cube:
    return inputs.pair(inputs.EVEN, (5, 3), (-2, 5), (0.1, 0.2))


def scattered() -> inputs.Cube:
    return inputs.waves(inputs.SEA, np.array([0.9, 1.4]), np.array([0.3, -0.2]), (1.2,), UniformCurrent((0.1, 0.0)))


@pytest.mark.parametrize("make", [lambda: inputs.sea(**SEA), pair, scattered], ids=["sea", "pair", "waves"])
def test_other_seeds_ask_of_other_water_and_the_published_one_of_what_is_published(make):
    usual, published, other, another = make(), drawn(PUBLISHED, make), drawn(3, make), drawn(4, make)
    np.testing.assert_array_equal(usual.surface, published.surface)
    assert usual.truth.tolist() == published.truth.tolist()
    for one, two in ((usual, other), (usual, another), (other, another)):
        assert one.surface.shape != two.surface.shape or not np.allclose(one.surface, two.surface)
        assert not np.allclose(one.truth, two.truth)
    np.testing.assert_array_equal(drawn(3, make).surface, other.surface)
    assert make().surface is not other.surface  # nothing of it stays behind


def test_a_question_does_not_depend_on_what_was_asked_before():
    alone = drawn(9, pair).surface
    with inputs.asked(InProcess(reference), 9):
        scattered(), inputs.sea(**SEA), inputs.sea(**SEA, grid=inputs.BRIEF)
        np.testing.assert_array_equal(pair().surface, alone)


def test_the_turns_are_the_eight_of_the_square_and_all_are_drawn():
    assert len({tuple(turn.ravel()) for turn in _TURNS}) == 8
    assert all(np.array_equal(t @ t.T, np.eye(2)) for t in _TURNS)
    assert len({tuple(Draw(seed).turn.ravel()) for seed in range(2, 60)}) == 8


def test_grids_and_currents_stay_near_what_tolerances_were_derived_for():
    for seed in range(2, 40):
        draw = Draw(seed)
        other = draw.grid(inputs.SEA)
        assert other != inputs.SEA
        assert np.abs(np.subtract(other.shape, inputs.SEA.shape)).max() <= 3
        assert np.all(np.divide(other.lengths, inputs.SEA.lengths) >= 1 - 1e-12)
        assert np.all(np.divide(other.lengths, inputs.SEA.lengths) <= 1.08)
        u = draw.current(UniformCurrent((0.3, 0.4))).velocity
        assert 0.94 * 0.5 <= np.hypot(*u) <= 0.5
        assert 0 < np.abs(draw.turn.T @ draw.near((0.1, 0.2)) - [0.1, 0.2]).max() <= 0.03
        assert np.abs(draw.turn.T @ draw.near((0.1, 0.55)) - [0.1, 0.55]).max() < 1e-15


@pytest.mark.parametrize(
    "current",
    [LinearCurrent((0.2, 0.1), (0.3, -0.1)), ExponentialCurrent((0.9, 0.4), 0.25), UniformCurrent((0.2, 0.1))],
)
def test_every_kind_of_current_is_turned_as_a_whole(current):
    k, draw = np.array([0.7, 2.0]), Draw(5)
    turned = draw.current(current).doppler_shift_velocity(k)
    should = current.doppler_shift_velocity(k) @ draw.turn.T
    factor = turned / should
    np.testing.assert_allclose(factor, factor[0, 0], rtol=1e-12)


def test_a_draw_rests_on_raw_words_of_philox():
    """As the definition has it: 53 bits of a word of Philox, keyed by the seed and the purpose."""
    key = crc32(b"('turn',)")
    word = np.random.Philox(key=np.array([7, key], dtype=np.uint64)).random_raw()
    assert Draw(7).numbers(1, "turn")[0] == (int(word) >> 11) / 2**53


@pytest.mark.parametrize("family", FAMILIES)
def test_the_families_that_are_drawn_see_other_water(family):
    own = [c for c, _ in select([family], seed=5)]
    assert {case.seed for _, case in select([family], seed=5)} == ({5} if family in DRAWN else {PUBLISHED})
    assert own == [c for c, _ in select([family])]


@pytest.mark.parametrize("seed", [-1, 2**63, True, 1.5, "1"])
def test_what_is_no_seed_is_refused(seed):
    with pytest.raises(LeakrefError, match="the seed is"):
        select(seed=seed)


def test_a_seed_is_typed_as_a_number_or_left_to_the_machine():
    assert commands.seed_of("17") == 17
    one, two = commands.seed_of("fresh"), commands.seed_of("fresh")
    assert one != two
    assert min(one, two) > PUBLISHED
    for bad in ("", "many", "-3", "1.5"):
        with pytest.raises(LeakrefError, match="the seed is"):
            commands.seed_of(bad)


def judged(code: object, *patterns: str, seed: int = PUBLISHED):
    pairs = select(patterns, profile="quick", seed=seed)
    return certify("code", [nullcontext(InProcess(code))], pairs, profile="quick", seed=seed)


class Table(Reference):
    """Knows the answers to what it was once asked, and nothing else."""

    def __init__(self) -> None:
        self.known: dict[bytes, np.ndarray] = {}
        self.learning = True

    def extract(self, surface, spacing, wavenumbers, **settings):
        key = repr((np.asarray(surface).tobytes()[:4096], tuple(wavenumbers), sorted(settings.items()))).encode()
        if self.learning:
            self.known[key] = np.array(super().extract(surface, spacing, wavenumbers, **settings))
        return self.known.get(key, np.zeros((len(wavenumbers), 2)))


def test_answers_learnt_by_heart_are_found_out_by_another_seed():
    table = Table()
    judged(table, "signs", "recovery")
    table.learning = False
    assert judged(table, "signs", "recovery").grade == "sound"  # of what was asked it knows all
    found = judged(table, "signs", "recovery", seed=1234)
    assert found.grade == "rejected"
    assert len(found.wrong) > 0.8 * len(found.judged)
    assert "--seed 1234" in found.wrong[0].repro


@pytest.fixture
def few(monkeypatch):
    """Fewer faults than there are: whether all of them are told apart is asked by the tests of the diagnosis."""
    some = ("flipped-y", "negated-current", "exchanged-axes", "knots", "hertz-for-radians")
    monkeypatch.setattr(faults, "FAULTS", {name: faults.FAULTS[name] for name in some})


def test_a_failure_of_another_seed_is_explained_by_its_own_questions(few):
    found = judged(_flipped(), "signs.aligned", "recovery.pair", seed=77)
    said = diagnose(found.wrong, found.declaration, seed=77)
    assert said.hypotheses[0].fault == "flipped-y"
    assert said.words.startswith("equals the reference with this fault, to 1")  # 16 digits or so


def _flipped() -> object:
    return faults.implementation("flipped-y")


class OneShape(Reference):
    """Refuses at run time every cube but those of one shape."""

    def extract(self, surface, spacing, wavenumbers, **settings):
        if np.shape(surface) != inputs.SEA.shape:
            raise NotImplementedError("only one shape")
        return super().extract(surface, spacing, wavenumbers, **settings)


class OneWavenumber(Reference):
    """Answers the first wavenumber of each question."""

    def extract(self, surface, spacing, wavenumbers, **settings):
        found = np.ma.masked_invalid(super().extract(surface, spacing, wavenumbers, **settings))
        found[1:] = np.ma.masked
        return found


@pytest.mark.parametrize("code", [OneShape(), OneWavenumber()])
def test_what_is_declared_and_not_answered_is_missing_and_not_conformant(code):
    found = judged(code, "signs", "recovery", "leakage.still", "leakage.bias", "conformance.extract")
    assert found.grade in (None, "sound")
    assert found.coverage["missing"] > 8
    assert found.wrong == []
    if isinstance(code, OneWavenumber):  # of one wavenumber it is asked no more than it answers
        assert {str(f.verdict) for f in found.findings if f.id.startswith("signs.aligned")} == {"pass"}
    assert found.coverage["judged"] + found.coverage["missing"] + found.coverage["unsupported"] == len(found.findings)


def test_a_third_of_the_wavenumbers_may_be_null_and_no_more():
    class Some(Reference):
        def __init__(self, null: int) -> None:
            self.null = null

        def extract(self, surface, spacing, wavenumbers, **settings):
            found = np.ma.masked_invalid(super().extract(surface, spacing, wavenumbers, **settings))
            found[len(found) - self.null :] = np.ma.masked
            return found

    for null, verdict in ((0, "pass"), (2, "pass"), (3, "missing"), (6, "missing")):  # of six wavenumbers
        (finding,) = judged(Some(null), "leakage.still[broad]").findings
        assert finding.verdict == verdict, null


def test_nulls_hide_no_mistake():
    """Neither those of other wavenumbers nor those of another method."""

    class Hiding(Reference):
        def extract(self, surface, spacing, wavenumbers, **settings):
            found = -np.ma.masked_invalid(super().extract(surface, spacing, wavenumbers, **settings))
            found[1:] = np.ma.masked
            return found

    class Silent(Reference):
        def extract(self, surface, spacing, wavenumbers, *, method, **settings):
            if method == "ls":
                return [None] * len(wavenumbers)
            return -super().extract(surface, spacing, wavenumbers, method=method, **settings)

    for code in (Hiding(), Silent()):
        (finding,) = judged(code, "signs.sea[to-22.5]").findings
        assert finding.verdict == "fail", finding.message


def nsp(surface, spacing, wavenumbers, gravity, window):
    return reference.extract(surface, spacing, wavenumbers, gravity=gravity, window=window, method="nsp")


def ls(surface, spacing, wavenumbers, gravity, window):
    return np.ma.masked_invalid(
        reference.extract(surface, spacing, wavenumbers, gravity=gravity, window=window, method="ls")
    )


def weighted(surface, spacing, wavenumbers):
    """A least squares of its own make: weighted by the power of every bin above a quarter of the largest."""
    if not np.isfinite(surface).all():
        raise ValueError("not finite")
    power = np.abs(np.fft.fft2(np.fft.ifft(surface, axis=2), axes=(0, 1))) ** 2
    axes = [2 * np.pi * np.fft.fftfreq(n, d) for n, d in zip(surface.shape, spacing, strict=True)]
    kx, ky, omega = np.meshgrid(*axes, indexing="ij")
    k = np.hypot(kx, ky)
    width = 2 * max(axes[0][1], axes[1][1])
    found = []
    for wavenumber in wavenumbers:
        bins = (np.abs(k - wavenumber) <= width) & (omega > 0)
        bins &= power > 0.25 * power[bins].max()
        weight = np.sqrt(power[bins])
        matrix = np.stack([kx[bins], ky[bins]], axis=1) * weight[:, None]
        found.append(np.linalg.lstsq(matrix, (omega[bins] - np.sqrt(k[bins])) * weight, rcond=None)[0])
    return np.array(found)


@pytest.mark.parametrize(("code", "turns_out"), [(nsp, "nsp"), (ls, "ls"), (weighted, "own")])
def test_a_bare_function_is_held_to_the_method_that_it_turns_out_to_be(code, turns_out):
    found = judged(code, "signs", "recovery", "leakage", "conformance.sea")
    assert found.grade in ("conformant", "sound"), [f.message for f in found.wrong]
    assert found.methods == (turns_out,)
    exact = [f for f in found.findings if f.family == "conformance" and f.verdict == "pass"]
    assert bool(exact) == (turns_out in ("nsp", "ls"))
    assert found.grade == ("conformant" if exact and not found.coverage["missing"] else "sound")


def test_a_bare_function_with_a_mistake_is_explained_by_the_method_that_it_is(few):
    def turned_round(surface, spacing, wavenumbers, gravity, window):
        return -ls(surface, spacing, wavenumbers, gravity, window)

    found = judged(turned_round, "signs")
    assert found.grade == "rejected"
    assert found.methods == ("own",)
    said = diagnose(found.wrong, found.declaration)
    assert "negated-current" in {one.fault for one in said.hypotheses}
    assert (said.hypotheses[0].digits or 16) > 6
    assert said.words.startswith("equals the reference with this fault")  # by least squares, in all that failed


class Changed(Reference):
    """By one method, under Hann: what `change` makes of the reference's velocities."""

    def __init__(self, method: str, change) -> None:
        self.method, self.change = method, change

    def describe(self):
        return {"can": {"extract": {"methods": [self.method], "windows": ["hann"]}}}

    def extract(self, surface, spacing, wavenumbers, **settings):
        return self.change(super().extract(surface, spacing, wavenumbers, **settings))


def verdict_of(identifier: str, seed: int, code: Reference, *alike: str) -> str:
    """Of a code that is taken for the reference's make of the methods `alike`; found out if none are given."""
    ((check, case),) = select([identifier])
    subject = InProcess(code)
    subject.alike = frozenset(alike) or None
    return str(check(subject, replace(case, seed=seed)).verdict)


@pytest.mark.parametrize(("factor", "verdict"), [(1.0, "pass"), (1.45, "pass"), (1.55, "fail")])
def test_where_a_method_itself_errs_half_as_much_again_is_allowed_and_no_more(factor, verdict):
    """A narrow sea in still water, in which the reference's own error is above the resolution."""
    assert verdict_of("leakage.still[narrow]", 191, Changed("nsp", lambda c: factor * c), "nsp") == verdict


@pytest.mark.parametrize(("factor", "verdict"), [(1.5, "pass"), (8.0, "fail")])
def test_where_it_does_not_err_the_resolution_is_all_there_is(factor, verdict):
    assert verdict_of("leakage.still[broad]", PUBLISHED, Changed("nsp", lambda c: factor * c), "nsp") == verdict


@pytest.mark.parametrize(
    ("case", "seed", "factor", "verdict"),
    [("narrow", 191, 1.9, "pass"), ("narrow", 191, 2.1, "fail"), ("broad", 1, 8.0, "pass"), ("broad", 1, 9.5, "fail")],
)
def test_another_make_may_err_by_the_resolution_beside_the_reference(case, seed, factor, verdict):
    """In narrow seas, where each make errs in its own way: here one whose errors are larger, and so not alike."""
    assert verdict_of(f"leakage.still[{case}]", seed, Changed("nsp", lambda c: factor * c)) == verdict


SLIPS = {
    "none": np.eye(2),
    "negated": -np.eye(2),
    "y": np.diag([1, -1]),
    "x": np.diag([-1, 1]),
    "exchanged": np.eye(2)[::-1],
}


@pytest.mark.parametrize("slip", SLIPS)
def test_what_least_squares_errs_by_in_a_sea_excuses_no_slip_of_sign(slip):
    """A sea in which its own velocity goes more than two fifths of the way to an image."""
    found = verdict_of("signs.sea[to-292.5]", 138, Changed("ls", lambda c: c @ SLIPS[slip]))
    assert found == ("pass" if slip == "none" else "fail")


@pytest.mark.parametrize(("factor", "verdict"), [(1.0, "pass"), (1.4, "pass"), (1.6, "fail")])
def test_of_a_change_with_wavenumber_half_as_much_again_is_allowed_and_no_more(factor, verdict):
    """A sea in which the reference's least squares is off by nine tenths of the change that there is."""
    with inputs.asked(InProcess(reference), 6):
        truth = shear._cube(Case("linear")).truth
    code = Changed("ls", lambda c: truth + factor * (c - truth))
    assert verdict_of("shear.slope[linear]", 6, code) == verdict


def test_cubes_are_equal_if_they_show_the_same_and_only_then():
    """What is right of a cube is kept under it: another wave, grid or wavenumber must be another cube."""
    one = inputs.pair(inputs.EVEN, (5, 3), (-2, 5), (0.21, -0.13))
    again = replace(one, wavenumbers=one.wavenumbers.copy())
    assert one == again
    assert hash(one) == hash(again)
    waves = one.components
    others = [
        replace(one, wavenumbers=one.wavenumbers * 1.001),
        replace(one, grid=replace(one.grid, spacing=(1.0, 1.0, 1.0))),
        *(replace(one, components=replace(waves, **{name: getattr(waves, name) * 1.001})) for name in vars(waves)),
    ]
    assert not any(one == other for other in others)

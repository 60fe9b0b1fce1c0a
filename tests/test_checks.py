"""The checks: right codes pass all of them, and every family sees mistakes of the kind it is for."""

from __future__ import annotations

from collections import Counter

import numpy as np
import pytest

from leakref import Components, Grid, LeakrefError
from leakref.altered import Change, altered
from leakref.certify.checks import criteria, exact, inputs, registry
from leakref.certify.checks.criteria import expected, score, unflagged
from leakref.certify.checks.inputs import SEA, SHELLS, pair, sea
from leakref.certify.checks.registry import CHECKS, FAMILIES, Outcome
from leakref.certify.checks.signs import image
from leakref.certify.checks.statistics import FALSE_ALARMS, TESTS, excess, share
from leakref.certify.runner import run_check, select
from leakref.certify.strength import beside
from leakref.certify.strength.faults import FAULTS
from leakref.certify.subject.inprocess import InProcess
from leakref.certify.verdict import Unanswered, Verdict
from leakref.chain import Reference, extract, reference
from leakref.currents import UniformCurrent
from leakref.generator import generator
from leakref.window import window as named_window

QUICK = [f"{c.id}[{case.id}]" for c, case in select(profile="quick")]
SLOW = [f"{c.id}[{case.id}]" for c, case in select() if not case.quick]


@pytest.fixture(scope="module")
def subject():
    return InProcess(reference)


@pytest.fixture(scope="module")
def seas():
    return InProcess(generator)


@pytest.fixture(scope="module")
def everything():
    """The reference, offering what it is asked for by name as well."""
    return InProcess(beside.every())


@pytest.mark.stored
@pytest.mark.parametrize("identifier", [*QUICK, *(pytest.param(i, marks=pytest.mark.slow) for i in SLOW)])
def test_the_reference_passes(identifier, subject, seas, everything):
    ((_, case),) = select([identifier])
    offers = everything if case.method else seas if identifier.startswith("sea.") else subject
    finding = run_check(identifier, offers)
    if identifier.startswith("shear.band"):
        assert finding.verdict is Verdict.UNSUPPORTED
        return
    assert finding.verdict is Verdict.PASS, finding.message
    assert 0 <= finding.over <= 0.75  # room for codes that are as good
    assert finding.message
    if finding.family == "conformance":
        assert finding.digits > 14


def test_every_check_says_what_it_is_for():
    assert Counter(c.family for c in CHECKS.values()).keys() == FAMILIES.keys()
    for c in CHECKS.values():
        assert len(c.reason) > 60, c.id
        assert c.tolerance, c.id
        assert c.label.partition(":")[0] in ("eq", "sec", "app", "protocol"), c.id
        assert any(case.quick for case in c.cases), c.id
        assert len({case.id for case in c.cases}) == len(c.cases), c.id
        assert not any(" " in case.id for case in c.cases), c.id


# ---------------------------------------------------------------- planted mistakes


class Planted(Reference):
    """The reference with a mistake in front of it or behind it."""

    def __init__(self, before=lambda eta: eta, after=lambda c, k: c, **settings):
        self.before, self.after, self.settings = before, after, settings

    def extract(self, surface, spacing, wavenumbers, *, gravity=1.0, window="hann", method="nsp"):
        given = {"gravity": gravity, "window": window, "method": method, **self.settings}
        return self.after(super().extract(self.before(surface), spacing, wavenumbers, **given), wavenumbers)


class Loud(Reference):
    """A surface with too much energy."""

    def synthesize(self, components, x, y, t):
        return np.sqrt(1.01) * super().synthesize(components, x, y, t)


class Drawn(Reference):
    """Amplitudes drawn at random, two thirds of the energy in the mean."""

    def synthesize(self, components, x, y, t):
        drawn = np.random.default_rng(0).random(components.kx.size) * np.sqrt(2)
        return super().synthesize(
            Components(components.kx, components.ky, components.omega, components.amplitude * drawn, components.phase),
            x,
            y,
            t,
        )


class Clipped(Reference):
    """A surface that saturates."""

    def synthesize(self, components, x, y, t):
        return np.clip(super().synthesize(components, x, y, t), -4.0, 4.0)


class Backwards(Reference):
    """A surface whose waves run the other way."""

    def synthesize(self, components, x, y, t):
        return super().synthesize(components, x, y, -np.asarray(t))


class Symmetric(Reference):
    """Windows sampled over n - 1, in every stage."""

    def window(self, name, size):
        return named_window(name).samples(size, symmetric=True)


class Forward(Reference):
    """A spectrum by a forward transform along all three axes."""

    def spectrum(self, surface, spacing, *, window="hann"):
        wx, wy, wt = (named_window(window).samples(n) for n in surface.shape)
        return np.fft.fftn(surface * wx[:, None, None] * wy[:, None] * wt)


class Restless(Reference):
    """Another answer each time."""

    count = 0

    def extract(self, *cube, **settings):
        self.count += 1
        return super().extract(*cube, **settings) + 1e-15 * self.count


class Floored(Reference):
    """Wavenumbers are cut to whole bins."""

    def extract(self, surface, spacing, wavenumbers, **settings):
        dk = max(2 * np.pi / (n * d) for n, d in zip(surface.shape[:2], spacing, strict=False))
        return super().extract(surface, spacing, np.floor(np.asarray(wavenumbers) / dk) * dk, **settings)


def spoiling(surface):
    surface *= 2.0
    return surface


def absolute(surface):
    """A noise floor in absolute numbers."""
    return np.where(np.abs(surface) < 1e-3, 0.0, surface)


def unscaled(c, k):
    """An error that depends on the unit of wavenumber."""
    return c * (1 + 0.2 * np.asarray(k)[:, None])


def uniform(c, k):
    return np.broadcast_to(c.mean(axis=0), c.shape)


def upside_down(c, k):
    return c[::-1]


def first_half(surface):
    """Half of the frames, and the duration of all."""
    return np.concatenate([surface[:, :, : surface.shape[2] // 2]] * 2, axis=2)[:, :, : surface.shape[2]]


class Watered(Reference):
    """Takes the depth and the surface tension for others."""

    def __init__(self, depth=lambda h: h, tension=1.0):
        self.depth, self.tension = depth, tension

    def extract(self, *cube, depth, surface_tension, **settings):
        return super().extract(
            *cube, depth=self.depth(depth), surface_tension=self.tension * surface_tension, **settings
        )


MISTAKES = {
    "deep water": (
        Watered(lambda h: np.inf),
        ["depth.aligned", "depth.ring", "depth.change", "depth.sea"],
    ),
    "half a depth": (Watered(lambda h: h / 2), ["depth.aligned", "depth.ring", "depth.change", "depth.sea"]),
    "a depth that overflows": (Watered(lambda h: h if h < 350 else 1e-3), ["depth.limit"]),
    "no tension": (Watered(tension=0.0), ["depth.tension", "depth.ring"]),
    "negated": (
        Planted(after=lambda c, k: -c),
        [
            "signs.sea",
            "signs.aligned",
            "recovery.pair",
            "recovery.single",
            "recovery.ring",
            "recovery.shells",
            "currents.strong",
            "scale.duration",
            "conformance.sea",
        ],
    ),
    "x flipped": (Planted(after=lambda c, k: c * [-1, 1]), ["signs.sea", "signs.aligned", "recovery.sea"]),
    "y flipped": (Planted(before=lambda eta: eta[:, ::-1]), ["signs.sea", "signs.aligned", "currents.aligned"]),
    "exchanged": (Planted(after=lambda c, k: c[:, ::-1]), ["signs.sea", "signs.aligned", "recovery.two-shells"]),
    "without a taper": (
        Planted(window="box"),
        ["leakage.still", "leakage.swell", "leakage.flicker", "conformance.sea"],
    ),
    "always tapered": (Planted(window="hann"), ["metamorphic.shift", "conformance.extract"]),
    "a little current": (
        Planted(after=lambda c, k: c + 1e-3),
        ["leakage.aligned", "recovery.pair"],
    ),
    "a little more": (
        Planted(after=lambda c, k: c + 1e-2),
        ["currents.aligned"],
    ),
    "biased": (Planted(after=lambda c, k: c * 1.3 + 0.1), ["leakage.bias", "behaviour.sizes"]),
    "limited": (Planted(after=lambda c, k: np.clip(c, -0.25, 0.25)), ["currents.strong", "currents.backwards"]),
    "only to the right": (Planted(after=lambda c, k: np.abs(c)), ["metamorphic.symmetry", "metamorphic.reversal"]),
    "a noise floor": (Planted(before=absolute), ["metamorphic.amplitude"]),
    "crests alone": (Planted(before=lambda eta: np.maximum(eta, 0.0)), ["metamorphic.constant"]),
    "one for all": (Planted(after=uniform), ["shear.profile", "shear.slope", "behaviour.order"]),
    "upside down": (Planted(after=upside_down), ["shear.slope", "behaviour.order", "recovery.two-shells"]),
    "units": (Planted(after=unscaled), ["scale.peak"]),
    "narrow shells": (
        altered((Change("shell", "HALF_WIDTH = 2.0", "HALF_WIDTH = 0.32"),)).chain.reference,
        ["recovery.half-width"],
    ),
    "power": (altered(FAULTS["power-for-magnitude"].changes).chain.reference, ["recovery.weights"]),
    "whole bins": (Floored(), ["behaviour.asked"]),
    "gravity": (Planted(gravity=1.0), ["scale.gravity"]),
    "half the frames": (Planted(before=first_half), ["conformance.sea"]),
    "loud": (Loud(), ["synthesis.energy", "synthesis.single", "conformance.surface"]),
    "drawn": (Drawn(), ["synthesis.mean-energy", "synthesis.energy"]),
    "clipped": (Clipped(), ["synthesis.linearity", "synthesis.sum"]),
    "backwards": (Backwards(), ["synthesis.single", "synthesis.sum", "conformance.surface"]),
    "symmetric": (Symmetric(), ["conformance.window"]),
    "forward": (Forward(), ["conformance.spectrum"]),
    "NaN as a number": (Planted(before=np.nan_to_num), ["behaviour.refuses"]),
    "input altered": (Planted(before=spoiling), ["behaviour.input"]),
    "restless": (Restless(), ["behaviour.deterministic"]),
    "NaN where there is no number": (Planted(after=lambda c, k: c * np.nan), ["signs.sea", "behaviour.sizes"]),
}
SEEN = [(name, check) for name, (_, seen) in MISTAKES.items() for check in seen]


def worst_of(check: str, implementation) -> registry.Finding:
    """The quick cases of a check, up to the first that fails."""
    findings = []
    for c, case in select([check], profile="quick"):
        findings.append(c(InProcess(implementation), case))
        if findings[-1].verdict is Verdict.FAIL:
            break
    return findings[-1]


@pytest.mark.parametrize(("mistake", "check"), SEEN)
def test_a_mistake_is_seen(mistake, check):
    finding = worst_of(check, MISTAKES[mistake][0])
    assert finding.verdict is Verdict.FAIL, (finding.verdict, finding.over, finding.message)
    assert finding.over is None or finding.over > 1.2, finding.message
    assert finding.message


def test_every_check_sees_some_mistake():
    unseen = {"shear.band", "behaviour.past-nyquist"}  # tested below
    of_seas = {name for name in CHECKS if name.startswith("sea.")}  # in test_seas
    assert {check for _, check in SEEN} | unseen | of_seas == set(CHECKS)


@pytest.mark.parametrize(
    ("mistake", "words"),
    [
        ("negated", "comes back negated"),
        ("x flipped", "with x flipped"),
        ("y flipped", "with y flipped"),
        ("exchanged", "x and y exchanged"),
    ],
)
def test_signs_say_what_it_looks_like(mistake, words):
    for check in ("signs.sea[to-22.5]", "signs.aligned[to-112.5]"):
        assert words in run_check(check, InProcess(MISTAKES[mistake][0])).message


def test_a_velocity_is_the_image_it_is_nearest_to():
    assert image(np.array([-0.28, -0.1]), np.array([0.28, 0.12])) == "negated"
    assert image(np.array([0.11, 0.29]), np.array([0.28, 0.12])) == "with x and y exchanged"
    assert image(np.array([0.25, 0.1]), np.array([0.28, 0.12])) == ""
    assert image(np.array([1.24, -0.09]), np.array([0.11, -0.28])) == ""  # nearest to an image, and like none


def test_a_synthesis_that_slips_is_named():
    assert "the other way in time" in run_check("synthesis.single[to-35]", InProcess(Backwards())).message


# ---------------------------------------------------------------- fair to codes that can do less, or other things


class Only(Reference):
    """The reference that offers less."""

    def __init__(self, **can):
        self.can = can

    def describe(self):
        return {"name": "only", "can": {"extract": {"methods": ["nsp"], "windows": ["hann"], **self.can}}}


class Band(Only):
    """One velocity for the whole band, the mean of the reference's and something."""

    def __init__(self, plus=0.0):
        super().__init__(resolves="band", windows=["box", "hann"])
        self.plus = plus

    def extract(self, *cube, **settings):
        return super().extract(*cube, **settings).mean(axis=0, keepdims=True) + self.plus


def verdicts(implementation, *patterns):
    subject = InProcess(implementation)
    return {f"{c.id}[{case.id}]": c(subject, case).verdict for c, case in select(patterns, profile="quick")}


def test_what_is_not_offered_is_not_judged():
    found = verdicts(
        Only(windows=["box"]),
        "signs",
        "metamorphic.shift",
        "leakage.still",
        "recovery.pair",
        "synthesis",
        "conformance.window",
    )
    for identifier, verdict in found.items():
        untapered = identifier.startswith(("signs.aligned", "metamorphic.shift", "recovery.pair"))
        assert verdict is (Verdict.PASS if untapered else Verdict.UNSUPPORTED), identifier


def test_a_code_that_always_tapers_is_judged_tapered():
    found = verdicts(Only(), "signs", "recovery", "metamorphic.reversal", "scale")
    for identifier, verdict in found.items():
        bare = any(word in identifier for word in ("untapered",))
        assert verdict is (Verdict.UNSUPPORTED if bare else Verdict.PASS), identifier


@pytest.mark.parametrize(("beyond", "verdict"), [(-0.5, "pass"), (0.45, "pass"), (0.55, "fail"), (-3.0, "fail")])
def test_one_velocity_for_two_currents_lies_between_them_or_half_their_distance_outside(beyond, verdict):
    class Between:
        def describe(self):
            return {"can": {"extract": {"methods": ["one"], "resolves": "band"}}}

        def extract(self, surface, spacing, wavenumbers, *, gravity, window, method):
            return [[max(low[0], high[0]) + beyond * np.hypot(*np.subtract(high, low)), (low[1] + high[1]) / 2]]

    low, high = (
        inputs.pair(inputs.EVEN, *bins).truth[0]
        for bins in (((4, 1), (-2, 4), (0.2, -0.1)), ((9, -4), (5, 8), (-0.15, 0.1)))
    )
    assert run_check("recovery.two-shells[even]", InProcess(Between())).verdict == verdict


def test_one_velocity_for_the_band_is_judged_on_what_it_claims():
    found = verdicts(Band(), "signs", "recovery", "shear", "behaviour.order")
    unsupported = {i for i, verdict in found.items() if verdict is Verdict.UNSUPPORTED}
    assert unsupported == {
        i
        for i in found
        if i.startswith(
            (
                "shear.profile",
                "shear.slope",
                "behaviour.order",
                "recovery.single",
                "recovery.shells",
                "recovery.weights",
                "recovery.half-width",
            )
        )
    }
    assert {verdict for i, verdict in found.items() if i not in unsupported} == {Verdict.PASS}
    assert set(verdicts(Band(plus=0.3), "shear.band").values()) == {Verdict.FAIL}


def test_least_squares_alone_is_not_asked_what_it_cannot_know():
    found = verdicts(Only(methods=["ls"]), "currents.backwards", "recovery.single")
    assert set(found.values()) == {Verdict.UNSUPPORTED}


def answering(change, **said):
    """A code of the reference's NSP whose velocities (n, 2) under a window are changed."""
    other = Only(**said)
    other.extract = lambda *cube, gravity=1.0, window="hann", method="": change(
        Reference.extract(reference, *cube, gravity=gravity, window=window), window
    )
    return other


def test_another_method_is_held_to_resolutions_not_to_digits():
    rough = answering(lambda c, window: np.round(c, 2), methods=["fit"], windows=["box", "hann"])
    found = verdicts(rough, "recovery", "currents.aligned", "leakage.aligned", "leakage.bias")
    fine = {i for i in found if "ring" in i}  # where nothing favours a method
    assert {verdict for i, verdict in found.items() if "single" not in i and "weights" not in i and i not in fine} == {
        Verdict.PASS
    }
    assert Verdict.FAIL in {found[i] for i in fine}


def test_who_finds_the_reference_in_a_sea_is_held_to_digits_on_bins():
    """And who does not is another make, to be held to resolutions, and to a tenth where nothing favours a make."""
    off = answering(lambda c, window: c + 3e-4 * (window == "box"), methods=["nsp"], windows=["box", "hann"])
    finding = run_check("recovery.pair[even-1]", InProcess(off))
    assert finding.verdict is Verdict.FAIL
    assert "declare a method of another name" in finding.message
    other = answering(lambda c, window: c + 0.02, methods=["nsp"], windows=["box", "hann"])
    assert run_check("recovery.pair[even-1]", InProcess(other)).verdict is Verdict.PASS
    assert run_check("recovery.ring[moving]", InProcess(other)).verdict is Verdict.FAIL


@pytest.mark.parametrize("fixed", ["gravity", "gravity (9.81)"])
def test_who_cannot_be_told_the_gravity_is_not_asked_about_another(fixed):
    class Told(Planted):
        def describe(self):
            return {**super().describe(), "fixed": [fixed]}

    assert run_check("scale.gravity[moon]", InProcess(Told(gravity=1.0))).verdict is Verdict.UNSUPPORTED
    assert "declares it as fixed" in run_check("scale.gravity[moon]", InProcess(Planted(gravity=1.0))).message


def test_no_cube_is_handed_to_who_says_that_it_is_too_small():
    class Large(Reference):
        def describe(self):
            return {**super().describe(), "cube": {"smallest": [30, 30, 60]}}

        def extract(self, surface, *rest, **settings):
            assert all(n >= least for n, least in zip(surface.shape, (30, 30, 60), strict=True))
            return super().extract(surface, *rest, **settings)

    found = verdicts(Large(), "currents.strong", "scale.duration", "recovery.sea")
    brief = {i for i in found if i.startswith("currents.strong") or "brief" in i}
    assert {i for i, verdict in found.items() if verdict is Verdict.UNSUPPORTED} == brief
    assert {verdict for i, verdict in found.items() if i not in brief} == {Verdict.PASS}


def test_numbers_that_are_declined_are_missing_or_left_out():
    class Declining(Reference):
        def extract(self, surface, spacing, wavenumbers, **settings):
            rows = super().extract(surface, spacing, wavenumbers, **settings).tolist()
            return [None if n == 1 or len(rows) == 1 else row for n, row in enumerate(rows)]

    found = verdicts(Declining(), "signs.sea", "recovery.sea", "metamorphic.reversal", "shear", "leakage.bias")
    assert {verdict for i, verdict in found.items() if "band" not in i} == {Verdict.PASS}
    assert set(verdicts(Declining(), "recovery.pair", "signs.aligned").values()) == {Verdict.MISSING}  # declined all


def test_past_nyquist_is_refused_or_at_least_no_nan():
    class Aliased(Reference):
        def extract(self, surface, spacing, wavenumbers, **settings):
            return np.full((len(wavenumbers), 2), self.value)

    code = Aliased()
    for value, verdict in ((0.1, Verdict.PASS), (np.nan, Verdict.FAIL)):
        code.value = value
        assert run_check("behaviour.past-nyquist[past]", InProcess(code)).verdict is verdict


def test_refusing_everything_is_no_refusal():
    class Refusing(Reference):
        def extract(self, *cube, **settings):
            raise ValueError("no")

    assert run_check("behaviour.refuses[nan]", InProcess(Refusing())).verdict is Verdict.ERROR


def test_violations_are_read_once():
    subject = InProcess(MISTAKES["input altered"][0])
    run_check("signs.sea[to-22.5]", subject)
    assert subject.violations
    finding = run_check("behaviour.input[all-stages]", subject)
    assert "altered its input eta" in finding.message
    assert not subject.violations


def test_a_code_with_rows_downwards_sees_the_golden_arrays():
    class Downwards(Reference):
        def describe(self):
            return {**super().describe(), "y": "down"}

        def extract(self, *cube, **settings):
            return super().extract(*cube, **settings)  # its y component is along its rows: downwards, as declared

    subject = InProcess(Downwards())
    for identifier in ("conformance.sea[edges-hann-nsp]", "conformance.extract[nsp-oblong]", "signs.sea[to-22.5]"):
        finding = run_check(identifier, subject)
        assert finding.verdict is Verdict.PASS, finding.message
        assert finding.digits is None or finding.digits > 14


# ---------------------------------------------------------------- inputs and tolerances


class Watching(InProcess):
    """Keeps the shape, step, wavenumbers and largest frequency of every cube that is shown."""

    def __init__(self, implementation):
        super().__init__(implementation)
        self.seen = []

    def _work(self, stage, arrays, parameters):
        if stage == "extract":
            spacing = [parameters[f"d{axis}"] for axis in "xyt"]
            self.seen.append((arrays["eta"].shape, spacing, parameters["wavenumbers"]))
        return super()._work(stage, arrays, parameters)


@pytest.fixture(scope="module")
def shown():
    subject = Watching(reference)
    subject.extract = lambda *args, **settings: InProcess.extract(subject, *args, **{**settings, "scale": 1.0})
    for c, case in select(profile="quick"):
        if c.id != "behaviour.past-nyquist":
            c(subject, case)
    return subject.seen


def test_cubes_are_small_uneven_and_below_nyquist(shown):
    square = 0
    for shape, (dx, dy, dt), wavenumbers in shown:
        grid = Grid(shape, (dx, dy, dt))
        assert np.prod(shape) <= 64**3, shape
        assert max(wavenumbers) + 2 * grid.wavenumber_resolution < min(grid.nyquist[:2])
        assert np.sqrt(max(wavenumbers)) < grid.nyquist[2]
        square += dx == dy or shape[0] == shape[1]
    assert len(shown) > 200
    assert square < len(shown) / 10  # golden vectors, and edge bins


def test_the_same_bits_every_time():
    first = sea(30.0, 60.0, UniformCurrent((0.1, 0.0)), realization=4)
    inputs._sea.cache_clear()
    again = sea(30.0, 60.0, UniformCurrent((0.1, 0.0)), realization=4)
    assert again is not first
    assert np.array_equal(again.surface, first.surface)
    with pytest.raises(ValueError, match="read-only"):
        first.surface[0, 0, 0] = 1.0


def test_what_is_expected_is_what_the_plain_chain_says():
    cube = sea(30.0, 60.0, UniformCurrent((0.1, 0.0)), realization=4)
    for window, method in (("hann", "nsp"), ("box", "ls")):
        plain = extract(cube.surface, cube.spacing, cube.wavenumbers, window=window, method=method, gravity=1.0)
        np.testing.assert_allclose(expected(cube, window, method).velocities, plain.velocities, rtol=0, atol=1e-11)
        assert unflagged(cube, window, method).tolist() == [not note for note in plain.notes]
    best = expected(cube, "hann", "nsp")
    assert score(cube, "hann", SHELLS[1], best.velocities[1]) == pytest.approx(best.score[1], rel=1e-9)
    assert expected(cube, "tukey", "fit") is not None  # stands for Hann and the NSP


def test_a_pair_has_the_current_it_says():
    cube = pair(inputs.EVEN, (5, 3), (-2, 5), (0.1, 0.2))
    w = cube.components
    np.testing.assert_allclose(
        np.sqrt(np.hypot(w.kx, w.ky)) + np.stack([w.kx, w.ky], 1) @ cube.truth[0], w.omega, rtol=1e-14
    )
    assert np.hypot(*(cube.truth[0] - (0.1, 0.2))) < 0.08


def test_exact_answers_may_be_off_by_a_little_or_by_nothing_in_score(subject):
    cube = sea(0.0, 360.0, UniformCurrent((0.1, 0.0)), realization=4)
    best = expected(cube, "hann", "nsp").velocities
    step = np.array([1.0, 0.0])

    def over(method, size):
        return exact.exactly(subject, cube, "hann", method, best + size * step, best)

    np.testing.assert_allclose(over("ls", 2.1e-4), 1.05, rtol=1e-9)
    assert over("nsp", 2.1e-4).max() < 1  # more than is allowed by argument, less by score
    assert over("nsp", 0.02).min() > 1
    for far in (1.3, 74.0, -74.0, 1e6):  # where next to nothing of G is left, whatever there is may score high
        np.testing.assert_allclose(over("nsp", far), abs(far) / exact.EXACT, rtol=1e-9)
    two, far = pair(inputs.EVEN, (5, 3), (-2, 5), (0.1, 0.2)), np.array([[-58.88, 96.42]])
    k = float(two.wavenumbers[0])
    assert score(two, "box", k, far[0]) > 20 * score(two, "box", k, two.truth[0])
    assert exact.exactly(subject, two, "box", "nsp", far, two.truth[:1]).min() > 1e5
    assert over("fit", 0.02).max() < 1


def test_the_worst_of_several_methods_is_told():
    worst = criteria.worst({"nsp": Outcome(0.2, "good", 12.0), "ls": Outcome(3.0, "bad", 3.0)})
    assert (worst.over, worst.message, worst.digits) == (3.0, "ls: bad", 3.0)
    assert np.isnan(criteria.worst({"nsp": Outcome(np.nan, ""), "ls": Outcome(3.0, "")}).over)
    with pytest.raises(Unanswered, match="no answer that can be judged"):
        criteria.verdict(np.full(4, np.nan), sea(0.0, 360.0), np.zeros((4, 2)), np.zeros((4, 2)))


# ---------------------------------------------------------------- statistics


def test_the_tests_of_a_run_share_its_false_alarms():
    assert len(CHECKS["leakage.bias"].cases) == TESTS
    assert TESTS * 2 * share(2) == pytest.approx(FALSE_ALARMS)


def test_excess_is_students_test():
    d = np.array([0.1, 0.3, 0.2, 0.25])
    found = excess(d, 0.05, 0.01)
    assert found.mean == pytest.approx(0.2125)
    assert found.limit == pytest.approx(0.05 + 4.540703 * found.standard_error, rel=1e-6)  # t of 0.99, 3
    assert found.over == pytest.approx(0.2125 / found.limit)
    assert excess(-d, 0.05, 0.01).over == 0
    for wrong in ((d[:1], 0.05, 0.01), (d, 0.0, 0.01), (d * np.nan, 0.05, 0.01)):
        with pytest.raises(LeakrefError):
            excess(*wrong)


def test_excess_raises_as_many_false_alarms_as_it_says():
    rng = np.random.default_rng(5)
    alarms = np.mean([excess(rng.normal(0.1, 0.3, 6), 0.1, 0.05).over > 1 for _ in range(2000)])
    assert abs(alarms - 0.05) < 4 * np.sqrt(0.05 * 0.95 / 2000)
    found = np.mean([excess(rng.normal(0.9, 0.3, 6), 0.1, 0.05).over > 1 for _ in range(200)])
    assert found > 0.95


def test_grids_of_the_seas_are_those_of_the_reason():
    assert SEA.shape[0] != SEA.shape[1] != SEA.shape[2]
    assert len({*SEA.spacing}) == 3


def test_conformance_is_to_the_golden_set_that_was_asked_for(tmp_path, monkeypatch):
    import shutil
    from importlib import resources

    from leakref.certify.checks import conformance
    from leakref.golden import making

    with resources.as_file(resources.files("leakref._golden").joinpath("v1")) as first:
        shutil.copytree(first, tmp_path / "v3")
    path = tmp_path / "v3" / "vectors" / "window.json"
    path.write_text(
        path.read_text(encoding="utf-8").replace("0.18825509907063323", "0.19825509907063323"), encoding="utf-8"
    )
    making._write_manifest(tmp_path / "v3")  # a set that was made so; one that was edited is not read
    usual = conformance.locate
    monkeypatch.setattr(conformance, "locate", lambda n: usual(n) if n < 3 else tmp_path / f"v{n}")
    for number, verdict in ((1, "pass"), (2, "pass"), (3, "fail")):
        (pair,) = select(["conformance.window[window-hann-7]"], golden=number)
        assert pair[0](InProcess(Reference()), pair[1]).verdict == verdict
    assert len(select(golden=1)) == len(select(golden=3)) < len(select(golden=2)) == len(select())


def test_the_second_set_asks_more_of_deep_water_and_of_other_water_who_is_told_of_it():
    old = {f"{c.id}[{case.id}]" for c, case in select(golden=1)}
    new = {f"{c.id}[{case.id}]": (c, case) for c, case in select() if f"{c.id}[{case.id}]" not in old}
    assert len([i for i in new if i.startswith("conformance.extract[extract-wide-")]) == 8  # four windows, two methods
    assert {i.partition("[")[0] for i in new} == {"conformance.extract"}
    deep = InProcess(Planted())
    assert not deep.told
    for identifier, (c, case) in new.items():
        words = {"depth": ("depth",), "lake": ("depth",), "film": ("depth", "surface_tension")}
        words |= {"tank": ("surface_tension",), "capillary": ("surface_tension",)}
        named = next((water for word, water in words.items() if word in identifier), ())
        assert case.water == named, identifier
        assert c(InProcess(beside.every() if case.method else Reference()), case).verdict == "pass", identifier
        if case.water:
            assert c(deep, case).verdict == "unsupported"


class Square(Reference):
    """Knows square pixels only, as many codes for videos do."""

    def describe(self):
        return {"name": "square", "fixed": ["dy"], "can": {"extract": {"methods": ["nsp", "ls"]}}}

    def extract(self, surface, spacing, *rest, **settings):
        assert spacing[0] == spacing[1]
        return super().extract(surface, spacing, *rest, **settings)


@pytest.mark.parametrize(
    "family",
    [
        "signs",
        "recovery",
        "leakage.swell",
        "leakage.aligned",
        "currents.aligned",
        "metamorphic.symmetry",
        "behaviour.sizes",
        "behaviour.input",
    ],
)
def test_a_code_for_square_pixels_is_shown_square_pixels(family):
    found = [c(InProcess(Square()), case) for c, case in select([family], profile="quick")]
    assert {f.verdict for f in found} == {Verdict.PASS}, [(f.id, f.message) for f in found]
    assert inputs.sampling(SEA) is SEA


def test_golden_cubes_whose_pixels_are_not_square_are_not_for_it():
    (finding,) = (c(InProcess(Square()), case) for c, case in select(["conformance.extract[nsp-oblong]"]))
    assert finding.verdict is Verdict.UNSUPPORTED
    assert "square pixels" in finding.message


@pytest.mark.parametrize(("name", "words"), [("signs", "names .* findings"), ("signs.nosuch", "no check is called")])
def test_one_check_is_run_by_the_id_of_one_finding(name, words):
    with pytest.raises(LeakrefError, match=words):
        run_check(name, InProcess(reference))


def test_questions_are_chosen_by_name_by_family_and_by_pattern():
    def chosen(*patterns):
        return {f"{c.id}[{case.id}]" for c, case in select(patterns)}

    sea = {i for i in chosen("signs.sea") if i.startswith("signs.sea[to-")}
    assert sea
    assert chosen("signs.sea[to-*") == chosen("signs.sea[to-*]") == sea  # a bracket is a bracket
    assert chosen(min(sea)) == {min(sea)}
    assert chosen("signs.sea") < chosen("signs") == chosen("signs.*")
    with pytest.raises(LeakrefError, match=r"no check is called 'signs\.sea\[to'"):
        select(["signs.sea[to"])

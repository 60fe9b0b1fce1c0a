"""Diagnosis by cure: each repair is found for the mistake that it is the inverse of, and nothing where none holds."""

from __future__ import annotations

import json
from contextlib import nullcontext

import numpy as np
import pytest

from leakref.certify.checks import inputs
from leakref.certify.commands import Request, run
from leakref.certify.runner import certify, run_checks, select
from leakref.certify.strength import faults, variants
from leakref.certify.strength.clues import Clue
from leakref.certify.strength.cure import Search, cure
from leakref.certify.strength.diagnosis import explain
from leakref.certify.strength.faults import FAULTS
from leakref.certify.strength.repaired import NONE, Memory, Question, Repaired, Spent, joined
from leakref.certify.strength.repairs import INPUTS, OUTPUTS, PAIRS
from leakref.certify.subject.inprocess import InProcess
from leakref.certify.verdict import Unanswered, Verdict
from leakref.chain import reference
from leakref.window import window as named_window

SOME = ("signs.aligned", "recovery.pair", "recovery.ring", "recovery.shells", "leakage.aligned")
PLENTY = 1e9


class Code:
    """A code that knows one method: `before` is what it does with its question, `after` with its answer.

    The least squares answers at once, and most mistakes are alike to it; as an NSP its search is SciPy's.
    """

    def __init__(self, before=None, after=None, method="ls", **declared):
        self.before, self.after, self.method, self.declared = before, after, method, declared
        self.inner = reference if method == "ls" else variants.implementation("whole-space")

    def describe(self):
        return {"can": {"extract": {"methods": [self.method], "windows": ["box", "hann"]}}, **self.declared}

    def extract(self, surface, spacing, wavenumbers, *, gravity, window, method):
        asked = [surface, np.array(spacing), np.array(wavenumbers), gravity, window]
        eta, d, k, g, w = self.before(*asked) if self.before else asked
        found = self.inner.extract(eta, tuple(d), k, gravity=g, window=w, method=method)
        return (
            self.after(np.array(found, dtype=float), np.array(spacing), asked[2], surface.shape)
            if self.after
            else found
        )


def judged(code, *checks, profile="quick"):
    subject = InProcess(code)
    return run_checks(select(checks or SOME, profile=profile), subject), subject


def cured(code, *checks, allowance=PLENTY):
    findings, subject = judged(code, *checks)
    assert any(f.verdict is Verdict.FAIL for f in findings)
    return cure(findings, subject, seed=1, golden=1, allowance=allowance)


def steps(x=1.0, y=1.0, t=1.0):
    """A code that takes its steps to be others; functions are of the numbers of samples."""

    def before(eta, d, k, g, w):
        by = [f(*eta.shape) if callable(f) else f for f in (x, y, t)]
        return eta, d * by, k, g, w

    return before


def turned(degrees):
    c, s = np.cos(np.radians(degrees)), np.sin(np.radians(degrees))
    return lambda v, d, k, n: v @ np.array([[c, s], [-s, c]])


ANSWERS = {
    "negated": lambda v, d, k, n: -v,
    "flipped-x": lambda v, d, k, n: v * [-1, 1],
    "flipped-y": lambda v, d, k, n: v * [1, -1],
    "exchanged": lambda v, d, k, n: v[:, ::-1],
    "exchanged-and-negated": lambda v, d, k, n: -v[:, ::-1],
    "quarter-turn": turned(-90),
    "quarter-turn-back": turned(90),
    "turned": turned(33),
    "factor": lambda v, d, k, n: v * np.pi,
    "factor-x": lambda v, d, k, n: v * [1.21, 1],
    "factor-y": lambda v, d, k, n: v * [1, 0.7],
    "unit:knots": lambda v, d, k, n: v * 1.943844,
    "unit:km/h": lambda v, d, k, n: v * 3.6,
    "unit:pixels-per-frame": lambda v, d, k, n: v * d[2] / d[:2],
    "doppler-frequency": lambda v, d, k, n: v * k[:, None],
    "polar-degrees": lambda v, d, k, n: np.stack([np.hypot(*v.T), np.degrees(np.arctan2(v[:, 1], v[:, 0]))], axis=1),
    "compass": lambda v, d, k, n: np.stack([np.hypot(*v.T), np.degrees(np.arctan2(v[:, 0], v[:, 1]))], axis=1),
}
QUESTIONS = {
    "dt-interval": steps(t=lambda nx, ny, nt: (nt - 1) / nt),
    "dt-interval-back": steps(t=lambda nx, ny, nt: nt / (nt - 1)),
    "dx-interval": steps(x=lambda nx, ny, nt: (nx - 1) / nx),
    "dy-interval": steps(y=lambda nx, ny, nt: (ny - 1) / ny),
    "lengths-interval": steps(*(lambda *n, axis=axis: (n[axis] - 1) / n[axis] for axis in range(3))),
    "n-exchanged": steps(lambda nx, ny, nt: ny / nx, lambda nx, ny, nt: nx / ny),
    "ny-for-nx": steps(x=lambda nx, ny, nt: ny / nx),
    "frames-dt:2": lambda eta, d, k, g, w: (eta[:, :, ::2], d, k, g, w),
    "frames-dt:3": lambda eta, d, k, g, w: (eta[:, :, ::3], d, k, g, w),
    "dt-doubled": steps(t=0.5),
    "frames-interlaced": lambda eta, d, k, g, w: (
        eta[:, :, np.argsort(np.arange(eta.shape[2]) % 2, kind="stable")],
        d,
        k,
        g,
        w,
    ),
    "dt-halved": steps(t=2),
    "time-reversed": lambda eta, d, k, g, w: (eta[:, :, ::-1], d, k, g, w),
    "cube-exchanged": lambda eta, d, k, g, w: (np.swapaxes(eta, 0, 1), d, k, g, w),
    "square-pixels": lambda eta, d, k, g, w: (eta, d[[0, 0, 2]], k, g, w),
    "exchanged-spacing": lambda eta, d, k, g, w: (eta, d[[1, 0, 2]], k, g, w),
    "frequency-hertz": steps(t=2 * np.pi),
    "frame-rate": lambda eta, d, k, g, w: (eta, d ** [1, 1, -1], k, g, w),
    "unit-time-step": lambda eta, d, k, g, w: (eta, d * [1, 1, 0] + [0, 0, 1], k, g, w),
    "wavenumbers-doubled": lambda eta, d, k, g, w: (eta, d, 2 * k, g, w),
    "wavenumbers-times-two-pi": lambda eta, d, k, g, w: (eta, d, 2 * np.pi * k, g, w),
}


@pytest.mark.parametrize("name", ANSWERS)
def test_a_mistake_in_the_answer_is_named_by_its_repair(name):
    best, remark = cured(Code(after=ANSWERS[name]))
    assert (", none of 0" in best[0].counted, ("others harmed" in best[0].counted)) == (False, best[0].unharmed > 0)
    assert best[0].repair.id == name
    assert best[0].cured == best[0].asked == best[0].failed
    assert best[0].digits > 3
    assert remark == ""


@pytest.mark.parametrize("name", QUESTIONS)
def test_a_mistake_in_what_is_read_is_named_by_its_repair(name):
    method = "nsp" if name == "wavenumbers-times-two-pi" else "ls"  # which finds nothing there to fit
    best, _ = cured(Code(QUESTIONS[name], method=method), *SOME)
    assert name in [one.repair.id for one in best]
    assert best[0].cured == best[0].asked
    assert best[0].repair.parts == 1


@pytest.mark.parametrize(
    ("value", "said"), [(1.0, "gravity is 1,"), (10.0, "gravity is 10,"), (6.37, "gravity is 6.37,")]
)
def test_of_a_gravity_that_is_taken_for_granted_the_value_is_told(value, said):
    best, _ = cured(Code(lambda eta, d, k, g, w: (eta, d, k, value, w), units="si"))
    assert best[0].repair.id == "gravity"
    assert best[0].repair.words.startswith(said)


def test_a_window_that_is_lacking_is_named_where_it_shows(of_windows):
    best, _ = cured(Code(lambda eta, d, k, g, w: (eta, d, k, g, "box"), method="nsp"), "leakage", "recovery.pair")
    assert best[0].repair.id == "no-taper"


@pytest.fixture
def of_windows(monkeypatch):
    """Repairs of windows alone: cubes that leak are large."""
    monkeypatch.setattr("leakref.certify.strength.cure.INPUTS", [one for one in INPUTS if "taper" in one.id])


def tapers(axes):
    """A code that tapers along some axes only, whatever window it is asked for."""

    def before(eta, d, k, g, w):
        for axis in axes if w != "box" else ():
            n = eta.shape[axis]
            eta = eta * named_window(w).samples(n).reshape([-1 if other == axis else 1 for other in range(3)])
        return eta, d, k, g, "box"

    return Code(before, method="nsp")


@pytest.mark.parametrize(("axes", "name"), [((1, 2), "taper-not-along-x"), ((0, 2), "taper-not-along-y")])
def test_a_window_that_is_lacking_along_an_axis_is_named_first(axes, name, of_windows):
    best, _ = cured(tapers(axes), "leakage", "metamorphic.symmetry")
    assert [one.repair.id for one in best][:1] == [name], [(one.repair.id, one.counted) for one in best]


@pytest.mark.parametrize(
    ("axes", "name", "check"),
    [((2,), "taper-in-time-only", "leakage.still"), ((0, 1), "taper-in-space-only", "leakage.flicker")],
)
def test_a_window_that_is_lacking_in_space_or_in_time_comes_right_with_it(axes, name, check):
    """Two questions see it, or one: too little to go on for the search, so that each is asked here."""
    findings, subject = judged(tapers(axes), check)
    search = Search(findings, subject, 1, 1, PLENTY, lambda: None)
    repair = next(one for one in INPUTS if one.id == name)
    assert search.failed
    assert all(search._finding(clue, repair, NONE).verdict is Verdict.PASS for clue in search.failed)
    assert all(search._finding(clue, NONE, NONE).verdict is Verdict.FAIL for clue in search.failed)


def test_two_mistakes_need_two_repairs():
    both = Code(QUESTIONS["dt-interval"], ANSWERS["flipped-y"])
    best, _ = cured(both)
    assert [one.repair.id for one in best] == ["dt-interval+flipped-y"]
    assert "and the y component is negated" in best[0].repair.words


def test_repairs_that_do_the_same_are_all_told():
    """Under a box a cube that is reversed in y is the sea with its y component negated."""
    findings, subject = judged(Code(after=ANSWERS["flipped-y"]), "signs.aligned", "recovery.pair")
    best, _ = cure(findings, subject, seed=1, golden=1, allowance=PLENTY)
    assert [one.repair.id for one in best] == ["flipped-y", "y-reversed"]


def test_a_repair_that_harms_what_passed_does_not_hold():
    """Its y component is of the wrong sign where it is positive: negated, the other answers are wrong."""
    best, _ = cured(Code(after=lambda v, d, k, n: np.where(v > 0, v * [1, -1], v)))
    assert best == []


def test_the_search_handles_no_more_than_it_may():
    findings, subject = judged(Code(QUESTIONS["dt-interval"]))
    before = subject.handled
    memory = Memory(subject, 1e6)
    best, remark = cure(findings, subject, seed=1, golden=1, allowance=1e6)
    assert best == []
    assert remark == "no repair was found before it was ended after as many samples as the judging took"
    assert subject.handled == before  # by the checks themselves nothing is asked beside the memory
    random = np.random.default_rng(0)
    cubes = [{"eta": random.normal(size=(50, 50, 50)), "x": [0], "y": [0], "t": [0]} for _ in range(20)]
    with pytest.raises(Spent):
        any(memory.asked(cube, GIVEN) is None for cube in cubes)
    assert memory.used <= 1e6


GIVEN = {"dx": 1.0, "dy": 1.0, "dt": 1.0, "gravity": 1.0, "wavenumbers": [1.0], "window": "box", "method": "ls"}


def test_a_session_that_breaks_ends_the_search_and_not_the_certificate():
    class Broken(InProcess):
        def _work(self, stage, arrays, parameters):
            raise Unanswered(Verdict.TIMEOUT, "gave no answer within 1 s")

    code = Code(after=ANSWERS["negated"])
    pairs = select(SOME, profile="quick")
    found = certify("mine", [nullcontext(InProcess(code))], pairs, profile="quick", only=SOME)
    said = explain(found, Broken(code))
    assert said.grade == "rejected"
    assert "ended when the program broke: gave no answer within 1 s" in said.explanation


def test_what_no_second_session_opens_for_is_said():
    class Gone:
        def __enter__(self):
            raise OSError("no such file")

        def __exit__(self, *_):
            raise AssertionError

    pairs = select(("signs.aligned",), profile="quick")
    found = certify("mine", [nullcontext(InProcess(Code(after=ANSWERS["negated"])))], pairs, profile="quick", only=SOME)
    assert "no repair was looked for, since no second session could be held" in explain(found, Gone()).explanation


def test_answers_that_are_not_repeated_are_no_evidence():
    noise = np.random.default_rng(3)
    code = Code(after=lambda v, d, k, n: v if noise.random() < 0.6 else -v)
    _, remark = cured(code)
    assert remark.endswith("failed questions pass when asked again: answers are not repeated")


ODD = {
    "half of it and a constant": lambda v, d, k, n: 0.5 * v + [0.12, -0.1],
    "a field of its own": lambda v, d, k, n: np.column_stack([np.sin(5 * k), np.cos(7 * k)]) * 0.3,
    "the components squared": lambda v, d, k, n: np.sign(v) * v**2 * 4 + 0.1,
    "one value whatever there is": lambda v, d, k, n: np.full_like(v, 0.016),
    "sheared": lambda v, d, k, n: v + np.outer(np.sin(40 * k), [0.3, -0.2]),
    "with a bias towards x": lambda v, d, k, n: v + np.array([0.25, 0.0]),
    "rounded": lambda v, d, k, n: np.round(v, 1),
    "slower the faster": lambda v, d, k, n: v / (1 + 3 * np.hypot(*v.T)[:, None]),
}


@pytest.mark.parametrize("what", ODD)
def test_what_no_repair_cures_is_not_said_to_be_cured(what):
    best, _ = cured(Code(after=ODD[what]), *SOME, "recovery.two-shells")
    assert best == []


def test_both_ways_of_explaining_stand_side_by_side(monkeypatch):
    monkeypatch.setattr(faults, "FAULTS", {name: FAULTS[name] for name in ("duration-short", "knots", "flipped-y")})
    code = faults.implementation("duration-short")
    pairs = select(SOME, profile="quick")
    found = certify("mine", [nullcontext(InProcess(code))], pairs, profile="quick", only=SOME)
    said = explain(found, InProcess(code))
    assert [(one["kind"], one["fault"]) for one in said.diagnosis] == [
        ("fault", "duration-short"),
        ("repair", "dt-interval"),
    ]
    assert "the duration is (n - 1) dt; comes right if dt is multiplied by n / (n - 1)" in said.explanation
    assert "failed questions, none of" in said.explanation
    assert said.handled > 0


def test_a_program_is_diagnosed_by_cure(tmp_path, monkeypatch, capsys):
    """In a session of its own, through the command; what it gets wrong is on no list."""
    (tmp_path / "stranger.py").write_text(
        "import numpy as np\n"
        "from leakref.certify.strength.variants import implementation\n"
        "inner = implementation('fminsearch')\n"
        "def extract(surface, spacing, wavenumbers, *, gravity, window):\n"
        "    dx, dy, dt = spacing\n"
        "    dx *= surface.shape[1] / surface.shape[0]\n"
        "    return inner.extract(surface, (dx, dy, dt), wavenumbers, gravity=gravity, window=window, method='nsp')\n"
    )
    monkeypatch.chdir(tmp_path)
    assert run(Request("stranger:extract", None, only=SOME), json=True) == 1
    said = json.loads(capsys.readouterr().out)
    assert [one["fault"] for one in said["diagnosis"] if one["kind"] == "repair"] == ["ny-for-nx"]
    assert "comes right if dx is multiplied by nx / ny" in said["explanation"]


# ---------------------------------------------------------------- the repairs themselves


@pytest.mark.parametrize(("units", "axes", "y"), [("si", "tyx", "down"), ("scaled", "xyt", "up")])
def test_around_a_right_code_repairs_by_units_change_nothing(units, axes, y):
    """Whatever its frame and units are: the search for gravity and for scales rests on that."""

    class Framed(Code):
        def extract(self, surface, *rest, **named):
            own = np.transpose(surface, [axes.index(axis) for axis in "xyt"])
            found = reference.extract(own[:, ::-1] if y == "down" else own, *rest, **named)
            return found * [1, -1] if y == "down" else found

    subject = InProcess(Framed(units=units, axes=axes, y=y))
    cube = inputs.pair(inputs.EVEN, (5, 3), (-2, 5), (0.21, -0.13))
    for name in (
        "waves:4",
        "waves:1/16",
        "unit-time-step",
        "unit-dx",
        "frames-odd",
        "one-by-one",
        "sorted-wavenumbers",
    ):
        repair = next(one for one in INPUTS if one.id == name)
        found = Repaired(Memory(subject, PLENTY), repair).extract(
            cube.surface, cube.spacing, cube.wavenumbers, window="box", method="ls"
        )
        assert found.values == pytest.approx(cube.truth, abs=1e-9), name


def test_no_two_repairs_have_one_name_and_each_says_what_it_does():
    every = [*OUTPUTS, *INPUTS, *PAIRS]
    assert len({one.id for one in every}) == len(every)
    assert len({one.words for one in every}) == len(every)
    assert all(one.words and one.id for one in every)


def test_what_no_velocities_are_in_is_handed_on_as_it_is():
    class Words(Code):
        def extract(self, surface, spacing, wavenumbers, *, gravity, window, method):
            return [("fast", "north")] * len(wavenumbers)

    subject = InProcess(Words())
    cube = inputs.pair(inputs.EVEN, (5, 3), (-2, 5), (0.21, -0.13))
    with pytest.raises(Unanswered, match="should be two numbers or null"):
        Repaired(Memory(subject, PLENTY), OUTPUTS[0]).extract(
            cube.surface, cube.spacing, cube.wavenumbers, window="box", method="ls"
        )


def test_a_question_is_put_once():
    findings, subject = judged(Code(after=ANSWERS["exchanged"]), "signs.aligned", "recovery.pair")
    search = Search(findings, subject, 1, 1, PLENTY, lambda: None)
    clue = search.failed[0]
    assert isinstance(clue, Clue)
    for output in (NONE, *OUTPUTS):
        search._finding(clue, NONE, output)
    assert search.memory.used == np.prod(clue.finding.calls[0].asked["shape"])


def test_of_two_repairs_the_first_is_nearer_to_the_code():
    one = joined(*(next(r for r in INPUTS if r.id == name) for name in ("dt-interval", "frames-dt:2")))
    cube = np.zeros((4, 5, 11))
    question = Question(cube, (1.0, 1.0, 1.0), cube.shape, 1.0, np.array([1.0]), "hann")
    assert one.change(question).steps[2] == pytest.approx(22 / 21)  # twenty-two frames, one more than intervals
    assert one.id == "dt-interval+frames-dt:2"
    tapered = next(r for r in INPUTS if r.id == "taper-in-space-only").change(
        Question(cube + 1, (1.0, 1.0, 1.0), cube.shape, 1.0, np.array([1.0]), "hann")
    )
    assert tapered.eta[0, 0] == pytest.approx(named_window("hann").samples(11))

"""Codes in water with a bottom and a surface tension: what they declare, what they are handed, how they are judged."""

import json
from contextlib import nullcontext
from dataclasses import replace

import numpy as np
import pytest
from strangers.finite import MISTAKES, Finite
from strangers.nsp import Extractor

from leakref.certify import commands
from leakref.certify.checks import depth as family
from leakref.certify.checks import inputs
from leakref.certify.measures import bias
from leakref.certify.report import page
from leakref.certify.runner import certify, run_checks, select
from leakref.certify.strength import cure, repairs
from leakref.certify.strength.diagnosis import explain
from leakref.certify.strength.faults import FAULTS
from leakref.certify.strength.repaired import Memory, Repaired
from leakref.certify.subject.declaration import Declaration
from leakref.certify.subject.frames import BOTTOMLESS
from leakref.certify.subject.inprocess import InProcess
from leakref.certify.subject.named import Named
from leakref.certify.verdict import Unanswered, Verdict
from leakref.chain import Reference, reference
from leakref.dispersion import DEEP, Water
from leakref.golden.sets import NEWEST

PAIRS = select(["depth"], profile="quick")
LESS = [pair for pair in PAIRS if not pair[0].id.endswith("sea")]


def judged(code, *patterns, profile="quick", pairs=None):
    pairs = select(patterns, profile=profile) if pairs is None else pairs
    return certify("code", [nullcontext(InProcess(code))], pairs, profile=profile)


class OneDepth(Reference):
    """Knows one depth, says which, and is right or not."""

    def __init__(self, depth, said=None, units="scaled"):
        self.depth, self.said, self.units = depth, depth if said is None else said, units

    def describe(self):
        return {**super().describe(), "units": self.units, "water": {"depth": self.said}}

    def extract(self, surface, spacing, wavenumbers, *, gravity, window, method):
        return super().extract(
            surface, spacing, wavenumbers, gravity=gravity, depth=self.depth, window=window, method=method
        )


class Seen(Reference):
    """Takes down what it is handed."""

    def __init__(self, units="scaled", **water):
        self.units, self.water, self.told = units, water, []

    def describe(self):
        return {**super().describe(), "units": self.units, "water": self.water}

    def extract(self, *cube, gravity, depth=None, surface_tension=None, window, method):
        self.told.append((depth, surface_tension, gravity))
        return np.zeros((len(cube[2]), 2)) + 0.1


# ---------------------------------------------------------------- declarations


@pytest.mark.parametrize(
    "water",
    [
        {"depth": 0},
        {"depth": -3.0},
        {"depth": float("nan")},
        {"depth": float("inf")},
        {"depth": "deep"},
        {"depth": True},
        {"depth": [3]},
        {"surface_tension": -1e-5},
        {"surface_tension": "water"},
        "given",
        3.0,
        ["depth"],
    ],
)
def test_what_is_no_water_is_refused_with_what_it_should_be(water):
    with pytest.raises(
        Unanswered, match=r"declares water = .*should be an object with depth or surface_tension"
    ) as said:
        Declaration.read({"water": water})
    assert said.value.verdict is Verdict.ERROR
    assert "leave depth out" in said.value.message


@pytest.mark.parametrize(
    ("water", "told"),
    [
        ({}, ()),
        ({"depth": None}, ()),
        ({"depth": "given"}, ("depth",)),
        ({"surface_tension": "given", "depth": 3}, ("surface_tension",)),
        ({"depth": "given", "surface_tension": "given", "salt": 35}, ("depth", "surface_tension")),
    ],
)
def test_what_is_declared_is_what_it_is_told(water, told):
    assert Declaration.read({"water": water}).told == told


def test_a_keyword_of_the_signature_counts_as_given_and_nothing_else_does():
    def deep(surface, spacing, wavenumbers, *, gravity, window, method): ...
    def known(surface, spacing, wavenumbers, *, gravity, depth, surface_tension, window): ...
    def anything(surface, spacing, wavenumbers, **keywords): ...
    def third(surface, spacing, depth): ...

    assert InProcess(deep).told == InProcess(anything).told == ()
    assert InProcess(known).told == ("depth", "surface_tension")
    assert "wavenumbers" in InProcess(third).declaration.fixed  # the depth is no list of wavenumbers

    class Refusing:
        def describe(self):
            return {"water": {"depth": "given"}}

        def extract(self, surface, spacing, wavenumbers): ...

    with pytest.raises(Unanswered, match="declares depth as given, and its extract takes no depth"):
        InProcess(Refusing())


class Tank(OneDepth):
    """Two centimetres of water, whose surface tension stands in the code as well."""

    def describe(self):
        return {**super().describe(), "water": {"depth": 0.02, "surface_tension": 7.3e-5}}

    def extract(self, surface, spacing, wavenumbers, *, gravity, window, method):
        water = {"depth": 0.02, "surface_tension": 7.3e-5}
        return Reference.extract(
            reference, surface, spacing, wavenumbers, gravity=gravity, **water, window=window, method=method
        )


def test_a_code_with_one_surface_tension_is_judged_in_that():
    found = judged(Tank(0.02, units="si"), "signs.aligned", "recovery.pair", "scale.gravity", "scale.peak")
    assert not found.wrong, [(f.id, f.message) for f in found.wrong]
    assert "surface tension up to 7.3e-05 m3/s2" in found.scope()["words"]
    unfelt = judged(Named(reference, "deep", units="si", water={"surface_tension": 7.3e-5}), "signs.sea[to-22.5]")
    assert "no surface tension" in unfelt.scope()["words"]  # waves of 25 m do not feel it


@pytest.mark.parametrize(
    ("units", "water"),
    [
        ("si", {"depth": 1e-300}),
        ("si", {"depth": 2e4}),
        ("si", {"surface_tension": 0.073}),
        ("si", {"surface_tension": 1e9}),
        ("scaled", {"depth": 1e-9}),
        ("scaled", {"surface_tension": 1e9}),
    ],
)
def test_what_no_water_has_is_refused(units, water):
    with pytest.raises(Unanswered, match="which no water has"):
        Declaration.read({"units": units, "water": water})


def test_a_code_that_answers_in_another_depth_than_it_declares_is_told_which():
    code = OneDepth(4.0, 5.0, "si")
    found = judged(code, "recovery.pair")
    assert "That is right in a depth of 4 m" in found.wrong[0].message
    told = explain(found, InProcess(code))
    assert "it is not in the depth that it declares: it answers as in a depth of 4 m" in told.explanation
    assert not {one["fault"] for one in told.diagnosis} & {f for f, one in FAULTS.items() if one.stage == "water"}


@pytest.mark.parametrize(("depth", "peak"), [(100.0, 0.25), (4.0, 0.25), (2.8, 0.25), (0.7, 1.0), (0.1, 7.0)])
def test_a_code_with_one_depth_is_shown_waves_that_are_not_long_in_it(depth, peak):
    d = Declaration.read({"units": "si", "water": {"depth": depth, "surface_tension": 7.4e-5}})
    assert d.scales().peak_wavenumber == pytest.approx(peak)
    assert d.still().depth == pytest.approx(depth * peak)
    assert d.still(16.0).depth == pytest.approx(16 * depth * peak)
    assert d.still().surface_tension == pytest.approx(7.4e-5 * peak**2 / 9.81)
    assert d.still().gravity == pytest.approx(1)


def test_a_code_that_declares_nothing_is_asked_in_the_water_of_the_paper():
    d = Declaration.read({"units": "si"})
    assert d.still() == d.still(0.1) == DEEP  # the same bits of every question


# ---------------------------------------------------------------- what is handed over


def test_depth_and_tension_come_in_the_units_of_the_code():
    water = Water(1.0, depth=1.2, surface_tension=0.12)
    surface, spacing = np.random.default_rng(1).standard_normal((8, 8, 8)), (0.5, 0.5, 0.5)
    for units, length, scale in (("scaled", 1 / 4, 4.0), ("si", 1 / (0.25 * 4), 4.0)):
        code = Seen(units, depth="given", surface_tension="given")
        InProcess(code).extract(surface, spacing, [1.0], water=water, scale=scale)
        depth, tension, gravity = code.told[-1]
        assert depth == pytest.approx(1.2 * length)
        assert tension == pytest.approx(0.12 * gravity * length**2)
        InProcess(code).extract(surface, spacing, [1.0], scale=scale)
        assert code.told[-1][:2] == (pytest.approx(BOTTOMLESS * length), 0.0)  # deep water


@pytest.mark.parametrize(
    ("said", "water", "words"),
    [
        ({}, Water(1.0, depth=1.0), "knows deep water"),
        ({}, Water(1.0, surface_tension=0.1), "knows no tension"),
        ({"depth": "given"}, Water(1.0, surface_tension=0.1), "knows no tension"),
        ({"depth": 2.0}, Water(1.0, depth=1.0), "knows one depth only"),
        ({"depth": 2.0}, DEEP, "knows one depth only"),
    ],
)
def test_what_it_cannot_be_told_it_is_not_asked(said, water, words):
    code = Seen()
    subject = InProcess(code)
    subject.declaration = replace(subject.declaration, water=said)
    with pytest.raises(Unanswered, match=words) as refused:
        subject.extract(np.ones((8, 8, 8)), (0.5, 0.5, 0.5), [1.0], water=water)
    assert refused.value.verdict is Verdict.UNSUPPORTED
    assert not code.told


def test_no_wave_that_is_looked_at_feels_the_bottom_of_deep_water():
    k = np.linspace(0.2, 60, 400)
    np.testing.assert_array_equal(Water(1.0, depth=BOTTOMLESS).frequency(k), DEEP.frequency(k))


# ---------------------------------------------------------------- right codes


def test_the_family_is_asked_of_codes_that_are_told_and_of_no_others():
    asked = {f.id for f in judged(reference, "depth.aligned", "recovery.pair").findings}
    assert any(i.startswith("depth.aligned") for i in asked)
    found = judged(Extractor(), "depth.aligned", "recovery.pair")
    assert not [f for f in found.findings if f.family == "depth"]
    assert found.coverage["unsupported"] == 0
    assert found.grade is None or found.coverage["asked"] == len(select(["recovery.pair"], profile="quick"))
    words = found.scope()
    assert words["depth"] == "deep"
    assert words["words"].startswith("Deep water, no surface tension")


@pytest.mark.parametrize("seed", [1, 6])
@pytest.mark.parametrize("units", ["si", "scaled"])
def test_the_reference_is_right_in_every_water(units, seed):
    class Own(Reference):
        def describe(self):
            return {**super().describe(), "units": units}

    found = certify(
        "own", [nullcontext(InProcess(Own()))], select(["depth"], profile="quick", seed=seed), profile="quick"
    )
    assert [f.verdict for f in found.findings] == [Verdict.PASS] * len(PAIRS)
    exact = {f.id: f.over for f in found.findings if "sea" not in f.id and "ring" not in f.id}
    assert max(exact.values()) < 1e-9  # what is exact is exact
    # of a ring G ends at the Nyquist frequency three widths from the shell's outermost bins: exp(-18) = 1.5e-8 in c0
    assert max(f.over for f in found.findings if "ring" in f.id) < 1e-4
    scope = found.scope()
    assert scope["depth"] == "deep and finite"
    assert scope["surface_tension"] > 0
    assert "surface tension up to" in scope["words"]
    assert "depths of" in scope["words"]


def test_a_right_code_of_another_make_is_right_in_every_water():
    found = judged(Finite(), pairs=PAIRS)
    assert not found.wrong, [(f.id, f.message) for f in found.wrong]
    assert not found.coverage["missing"]


SOME = ("signs.aligned", "recovery.pair", "recovery.ring", "recovery.sea", "currents.aligned", "scale.peak[4]", "shear")


@pytest.mark.parametrize(
    ("depth", "units", "patterns"),
    [
        (0.7, "scaled", SOME),
        (4.0, "si", SOME),
        pytest.param(0.7, "scaled", (), marks=pytest.mark.slow),
        pytest.param(0.3, "si", (), marks=pytest.mark.slow),
        (0.1, "scaled", ("signs.aligned", "recovery.pair", "recovery.shells")),
    ],
)
def test_a_code_with_one_depth_is_judged_in_that(depth, units, patterns):
    found = judged(OneDepth(depth, units=units), *patterns)
    assert not found.wrong, [(f.id, f.message) for f in found.wrong]
    assert found.coverage["judged"] > 0.7 * found.coverage["asked"]
    assert found.scope()["words"].startswith(f"Water of a depth of {depth:.3g}")
    wrong = judged(OneDepth(2 * depth, depth, units), "recovery.pair", "recovery.ring")
    assert wrong.grade == "rejected"


# ---------------------------------------------------------------- mistakes


@pytest.mark.parametrize("name", MISTAKES)
def test_mistakes_of_another_make_are_rejected(name):
    assert judged(Finite(MISTAKES[name][0]), pairs=LESS).grade == "rejected"


QUICKLY = ("feet", "ten-metres-by-default")


@pytest.mark.parametrize(
    "name",
    [
        name if name in QUICKLY else pytest.param(name, marks=pytest.mark.slow)
        for name, (_, say) in MISTAKES.items()
        if say
    ],
)
def test_mistakes_of_another_make_are_named(name):
    law, named = MISTAKES[name]
    code = Finite(law)
    found = judged(code, pairs=LESS)
    told = explain(found, InProcess(code))
    faults = [one["fault"] for one in told.diagnosis]
    assert named in faults or named in told.explanation, (faults, told.explanation)


def test_a_depth_that_is_not_used_is_told_with_the_one_that_is():
    (finding,) = run_checks(
        select(["depth.change[1.2-for-0.8]"]), InProcess(Finite(MISTAKES["ten-metres-by-default"][0]))
    )
    assert "the depth it is handed is not used" in finding.message
    assert "right in a depth of 10 m" in finding.message
    assert "handed a depth of 4.8 m instead of a depth of 3.2 m its answer changes by (0, 0)" in finding.message


def test_the_depth_of_the_tile_before_is_seen():
    from leakref.certify.strength.faults import implementation

    found = judged(implementation("depth-of-another-tile"), pairs=LESS)
    assert {"depth.aligned[0.7]", "depth.change[1.2-for-0.8]"} <= {f.id for f in found.wrong}


# ---------------------------------------------------------------- the questions themselves


@pytest.mark.parametrize("case", family.check_change.cases, ids=lambda case: case.id)
def test_what_must_change_is_what_the_law_says(case):
    """Of each wave the frequency in still water changes, and k times the change of the current makes up for it."""
    given = case.given
    cube = family._pair(given["grid"], given["near"], Water(1.0, depth=given["made"]))
    other = family._in_other_water(cube, Water(1.0, depth=given["told"]))
    waves = cube.components
    k = np.hypot(waves.kx, waves.ky)
    for one in (cube, other):
        omega = one.water.frequency(k) + waves.kx * one.truth[0, 0] + waves.ky * one.truth[0, 1]
        np.testing.assert_allclose(omega, waves.omega, rtol=1e-12)
    assert np.hypot(*(other.truth - cube.truth)[0]) > 0.03


def test_cubes_are_of_the_water_of_the_question():
    shallow = Water(1.0, depth=0.8)
    with inputs.in_water(shallow):
        cube = inputs.many(inputs.EVEN.shape, (0.2, 0.1))
    deep = inputs.many(inputs.EVEN.shape, (0.2, 0.1))
    assert cube.water == shallow
    assert deep.water == DEEP
    assert cube != deep
    assert replace(deep, water=shallow) != deep  # what is right of it is worked out anew


# ---------------------------------------------------------------- what stands around: repairs, bias, the first question


@pytest.mark.parametrize(
    ("name", "by"),
    [("depth-feet", 1 / 0.3048), ("depth-metres-as-feet", 0.3048), ("depth-cycles", 2 * np.pi), ("depth-halved", 2.0)],
)
def test_a_repair_hands_over_another_depth(name, by):
    repair = next(one for one in repairs.INPUTS if one.id == name)
    code = Seen(depth="given", surface_tension="given")
    subject = Repaired(Memory(InProcess(code), 1e9), repair)
    subject.extract(np.ones((8, 8, 8)), (0.5, 0.5, 0.5), [1.0], water=Water(1.0, 1.2, 0.05))
    assert code.told[-1][:2] == (pytest.approx(1.2 * by), pytest.approx(0.05))


def test_other_units_are_those_of_the_water_too():
    """Twice as long and half again as slow: of a right code the answer is the same."""
    smaller = next(one for one in repairs.INPUTS if one.id == "waves:4")
    code = Seen(depth="given", surface_tension="given")
    Repaired(Memory(InProcess(code), 1e9), smaller).extract(
        np.ones((8, 8, 8)), (0.5, 0.5, 0.5), [1.0], water=Water(1.0, 1.2, 0.05)
    )
    depth, tension, gravity = code.told[-1]
    assert (depth, tension, gravity) == (pytest.approx(4 * 1.2), pytest.approx(16 * 0.05), pytest.approx(1.0))


def test_a_search_for_a_gravity_that_runs_away_is_given_up():
    code = Finite(MISTAKES["negative"][0])
    found = judged(code, "depth.aligned", "depth.ring")
    assert found.grade == "rejected"
    repairs_found, remark = cure.cure(found.findings, InProcess(code), seed=1, golden=NEWEST, allowance=1e8)
    assert not repairs_found
    assert "Scales" not in remark


def test_bias_is_measured_in_the_water_that_a_code_knows():
    (right,) = bias.bias(InProcess(OneDepth(0.8)), [bias.SEAS["broad"]], scales=(1.0,), realizations=3)
    assert right.ratio == pytest.approx(1.0, abs=1e-6)  # it is the reference
    (wrong,) = bias.bias(InProcess(OneDepth(2.0, 0.8)), [bias.SEAS["broad"]], scales=(1.0,), realizations=3)
    assert wrong.ratio > 3


def test_golden_vectors_of_other_water_are_asked_in_the_units_of_a_code():
    si = Named(reference, "si", units="si")
    names = ("extract-tank-hann-nsp", "extract-lake-hann-ls", "nsp-film", "extract-depth-0.7-box-nsp")
    pairs = select([f"conformance.extract[{name}]" for name in names])
    seen = Seen("si", depth="given", surface_tension="given")
    for pair in pairs:
        (finding,) = run_checks([pair], InProcess(si))
        assert finding.verdict is Verdict.PASS
        assert finding.digits > 12
    run_checks(select(["conformance.extract[extract-tank-hann-nsp]"]), InProcess(seen))
    assert seen.told[-1][1:] == (pytest.approx(7.3e-5), pytest.approx(9.81))  # waves of centimetres are shown as such


def test_a_code_that_overflows_in_the_deepest_water_is_judged(tmp_path, monkeypatch, capfd):
    """The first small question is in water of two wavelengths over 2 pi, so that it is a question of `depth.limit`."""
    monkeypatch.chdir(tmp_path)
    (tmp_path / "own.py").write_text(
        "import numpy as np\n"
        "from leakref.chain import reference\n"
        "def extract(surface, spacing, wavenumbers, *, gravity, depth, window, method):\n"
        "    if max(wavenumbers) * depth > 50:\n"
        "        raise OverflowError('math range error')\n"
        "    return reference.extract(surface, spacing, wavenumbers, gravity=gravity, depth=depth, window=window,"
        " method=method)\n"
    )
    request = commands.Request("own:extract", None, only=("depth.aligned", "depth.limit"), workers=1, diagnosis=False)
    assert commands.run(request, json=True) == 1
    verdicts = {f["id"]: f["verdict"] for f in json.loads(capfd.readouterr().out)["findings"]}
    assert verdicts["depth.aligned[0.7]"] == "pass"
    assert verdicts["depth.limit[ten-thousand]"] == "error"


def test_what_was_not_tested_is_what_was_not_shown():
    """A code that takes a depth, asked of deep water alone, is not tested in others, whatever it declares."""
    told = judged(reference, "signs.sea[to-22.5]")
    assert "Other depths, surface tension, breaking" in page(told)
    some = judged(reference, "depth.aligned")
    assert "Surface tension, breaking" in page(some)
    every = judged(reference, "depth.aligned", "depth.tension")
    assert "</strong> Breaking or nonlinear waves" in page(every)
    own = judged(OneDepth(1.0), "signs.aligned[to-22.5]")
    assert "Other depths, surface tension, breaking" in page(own)


def test_a_line_that_shows_a_finding_again_asks_in_the_same_waves():
    found = judged(reference, "signs.sea[to-22.5]")
    again = commands.named(found, commands.Request("a:b", None, waves="0.5m:4m"))
    assert again.findings[0].repro.startswith("leakref certify a:b --waves 0.5m:4m --only 'signs.sea[to-22.5]'")
    assert "--waves 0.5m:4m" in again.again

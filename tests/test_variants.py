"""Variants: correct codes that are not the reference."""

import numpy as np
import pytest

import leakref
from leakref import LeakrefError
from leakref.certify.strength.study import variant_record
from leakref.certify.strength.variants import VARIANTS, implementation
from leakref.certify.subject.inprocess import InProcess

BRIEF = ("y-downwards", "half-space", "single-precision", "band")
MORE = ("background-removed", "declining", "direction-from", "si", "symmetric-hann")
"""Of the others those that differ most from each other; a quarter of an hour for all."""


def test_there_are_enough_and_each_says_what_it_deserves():
    assert len(VARIANTS) >= 15
    assert {variant.grade for variant in VARIANTS.values()} == {"conformant", "sound"}
    assert all(variant.id == identifier and variant.words for identifier, variant in VARIANTS.items())


@pytest.mark.parametrize("identifier", VARIANTS)
def test_a_variant_finds_the_current_of_aligned_waves_and_is_another_code(identifier):
    grid = leakref.Grid((28, 34, 48), (0.9, 0.7, 0.9))
    waves, current = leakref.aligned_waves(grid, [(5, 3, 10), (-2, 5, 9)], gravity=1.0)
    surface = leakref.synthesize(waves, *(grid.samples(axis) for axis in range(3)))
    subject = InProcess(implementation(identifier))
    assert subject.declaration.name == f"variant:{identifier}"
    k = float(np.hypot(waves.kx, waves.ky).mean())
    found = subject.extract(surface, grid.spacing, [k], window="box").values[0]
    np.testing.assert_allclose(found, current, atol=2e-4)


def test_an_unknown_variant_is_refused():
    with pytest.raises(LeakrefError, match="no variant is called 'none'"):
        implementation("none")


@pytest.mark.parametrize(
    "identifier",
    [pytest.param(i, marks=pytest.mark.slow if i in MORE else pytest.mark.night) for i in VARIANTS if i not in BRIEF],
)
def test_all_the_others_pass_too(identifier):
    assert variant_record(identifier)["wrong"] == {}


@pytest.mark.parametrize("identifier", BRIEF)
def test_a_variant_passes_the_quick_profile(identifier):
    record = variant_record(identifier)
    assert record["checks"] > 40
    assert record["wrong"] == {}

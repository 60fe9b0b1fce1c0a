"""The properties themselves: each fails on a fault that is meant for it, and none on a correct code."""

from __future__ import annotations

import pytest
from faulted import outcome, properties

from leakref.certify.strength.faults import FAULTS
from leakref.certify.strength.variants import VARIANTS
from leakref.properties.examined import Examined
from leakref.properties.opening import examined

MEANT = {
    "windows.lobe_is_the_transform_of_the_textbook_window": ("blackman-sign", "hamming-for-hann", "kaiser-without-pi"),
    "windows.lobes_vanish_on_bins": ("symmetric-taper", "taper-half-period"),
    "windows.response_is_the_sum_over_samples": ("symmetric-taper", "taper-inside-out"),
    "windows.samples_have_the_lobes_of_the_window": ("hamming-for-hann", "blackman-sign", "kaiser-without-pi"),
    "windows.windows_are_even_and_between_zero_and_one": ("taper-half-period", "blackman-sign"),
    "spectrum.closed_form_is_the_fft_of_the_surface": ("rectified", "time-transform-reversed"),
    "spectrum.spectrum_is_that_of_the_waves": ("time-transform-reversed", "x-transform-reversed", "no-taper"),
    "spectrum.a_wave_on_a_bin_is_at_its_own_bin_and_its_mirror_image": ("time-transform-reversed", "rectified"),
    "spectrum.the_spectrum_of_a_real_signal_is_its_own_mirror_image": ("mirror-not-conjugate",),
    "spectrum.the_spectrum_is_linear": ("rectified", "saturated"),
    "spectrum.parseval": ("rectified", "saturated"),
    "spectrum.a_circular_shift_turns_phases_only": ("time-transform-reversed", "always-hann"),
    "spectrum.index_reversal_reverses_the_axis_of_the_spectrum": ("mirror-not-conjugate", "taper-half-period"),
    "recovery.a_pair_of_waves_on_bins_gives_the_current": ("negated-current", "square-pixels", "solve-off-diagonal"),
    "recovery.a_wave_on_a_bin_gives_the_component_along_it": ("negated-current", "one-interval-short", "root-missing"),
    "symmetry.quarter_turns_mirror_images_and_exchanged_axes": ("flipped-x", "half-plane"),
    "symmetry.played_backwards_the_current_is_reversed": ("absolute-value", "rectified"),
    "symmetry.a_circular_shift_changes_nothing_untapered": ("always-hann",),
    "symmetry.amplitude_does_not_matter": ("saturated", "half-precision"),
    "symmetry.an_added_constant_changes_nothing": ("rectified", "taper-half-period"),
    "scale.two_peak_wavenumbers_give_the_same_current": ("hard-coded-width", "frequency-cut"),
    "scale.units_of_length_and_time_are_free": ("hard-coded-width", "frequency-cut"),
    "optimum.the_score_is_stationary_and_curved_downwards": ("stops-at-start", "narrow-bounds"),
    "optimum.the_half_space_stands_for_the_whole": ("unweighted-half", "missing-negative-branch"),
    "optimum.derivatives_of_the_score_are_its_differences": ("printed-branch", "current-sign-in-branch"),
    "optimum.least_squares_satisfies_its_normal_equations": ("ls-weighted", "solve-sign-slip", "ls-no-threshold"),
    "optimum.splitting_and_permuting_the_wavenumbers_changes_nothing": ("sorted-wavenumbers", "mean-over-band"),
    "ensemble.a_turned_sea_has_the_turned_current_tapered": ("flipped-x", "no-taper"),
    "ensemble.untapered_a_turned_sea_has_another_current": ("always-hann",),
    "ensemble.a_wider_spread_is_not_worse": ("ls-no-threshold",),
    "ensemble.with_a_following_or_opposing_current_errors_are_those_without": ("narrow-bounds", "negated-current"),
}
"""Which faults each property is there for, the cheapest first."""

SAMPLE = {
    "y-downwards": "symmetry.quarter_turns_mirror_images_and_exchanged_axes",
    "symmetric-hann": "windows.samples_have_the_lobes_of_the_window",
    "eight-bits": "recovery.a_pair_of_waves_on_bins_gives_the_current",
    "single-precision": "symmetry.amplitude_does_not_matter",
    "powell": "recovery.a_wave_on_a_bin_gives_the_component_along_it",
}
"""What each of some variants came near to failing."""
EXACT = [name for name in properties() if not name.startswith("ensemble.")]


def test_every_property_is_meant_for_a_fault_that_exists():
    assert list(MEANT) == list(properties())
    assert {fault for faults in MEANT.values() for fault in faults} <= set(FAULTS)


@pytest.mark.parametrize(
    "name", [name if name in EXACT else pytest.param(name, marks=pytest.mark.slow) for name in MEANT]
)
def test_a_property_fails_on_a_fault_that_is_meant_for_it(name, monkeypatch):
    fault, methods = MEANT[name][0], Examined.methods
    if FAULTS[fault].stage == "ls":  # the one that is wrong first: it is enough
        monkeypatch.setattr(Examined, "methods", lambda self, **of: methods(self, **of)[::-1])
    assert outcome(name, examined(f"fault:{fault}")) == "fail"


@pytest.mark.night
@pytest.mark.parametrize(("name", "fault"), [(name, fault) for name in MEANT for fault in MEANT[name][1:]])
def test_a_property_fails_on_all_faults_that_are_meant_for_it(name, fault):
    assert outcome(name, examined(f"fault:{fault}")) == "fail"


@pytest.mark.parametrize(("variant", "name"), SAMPLE.items())
def test_no_property_fails_on_a_variant(variant, name):
    assert outcome(name, examined(f"variant:{variant}")) == "pass"


@pytest.mark.night
@pytest.mark.parametrize("variant", VARIANTS)
def test_no_property_fails_on_any_variant(variant):
    subject = examined(f"variant:{variant}")
    said = {name: outcome(name, subject) for name in properties()}
    assert not [name for name, word in said.items() if word == "fail"]
    assert "pass" in said.values()


@pytest.mark.night
def test_the_matrix_of_faults_and_properties(capsys):
    """Every exact property on every fault: printed, and no fault of the chain from sea to spectrum goes unseen."""
    seen = {}
    for fault in FAULTS:
        subject = examined(f"fault:{fault}")
        seen[fault] = [name for name in EXACT if outcome(name, subject) == "fail"]
        with capsys.disabled():
            print(f"\n{fault:26}" + "".join("x" if name in seen[fault] else "." for name in EXACT), end="", flush=True)
    assert all(seen[fault] for fault in FAULTS if FAULTS[fault].stage == "spectrum")
    assert {name for names in seen.values() for name in names} == set(EXACT)

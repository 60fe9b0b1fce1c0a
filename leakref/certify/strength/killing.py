"""Killing inputs: of each fault a finding on which its effect is at least ten times the tolerance.

The strength study asks it first, and says how large the effect is.
"""

from __future__ import annotations

__all__ = ["KILLING_INPUT_OF"]

_FAULTS_BY_FINDING = {
    "sea.energy[broad]": "sea-two-thirds-energy sea-height-for-deviation sea-one-sided",
    "sea.spectrum[peaked]": "sea-peakedness-ignored sea-peak-in-hertz sea-jacobian-missing",
    "sea.directions[broad]": "sea-from-for-to sea-exchanged-axes sea-degrees-for-radians",
    "sea.spread[broad]": "sea-twice-the-width sea-half-the-width",
    "sea.backwards[broad]": "sea-both-ways",
    "sea.motion[broad]": "sea-current-sign sea-current-left-out",
    "sea.motion[peaked]": "sea-depth-ignored",
    "sea.phases[broad]": "sea-half-phases sea-one-phase",
    "sea.realizations[broad]": "sea-one-seed sea-few-seeds",
    "sea.amplitudes[broad]": "sea-amplitudes-drawn",
    "sea.repeats[twice]": "sea-unrepeatable",
    "recovery.pair[even-1]": (
        "negated-current flipped-x flipped-y exchanged-axes quarter-turn rows-downwards reversed-time "
        "exchanged-cube absolute-value no-cross-component exchanged-spacing square-pixels hertz-for-radians "
        "degrees-for-radians gravity-dropped gravity-hard-coded knots pixels-per-frame unit-time-step "
        "doppler-frequency one-interval-short duration-short time-transform-reversed x-transform-reversed "
        "frequencies-off-by-one wavenumbers-off-by-one frequency-at-centre group-velocity depth-assumed "
        "solve-sign-slip solve-off-diagonal solve-factor-two ls-wrong-branch ls-both-halves rounded-answer "
        "always-hann"
    ),
    "depth.aligned[0.7]": (
        "tanh-outside-root depth-ignored depth-by-default depth-in-cycles depth-in-feet depth-negative depth-inverted "
        "depth-of-another-tile"
    ),
    "depth.tension[aligned]": "tension-ignored tension-per-density tension-k-squared",
    "recovery.two-shells[even]": (
        "frame-rate rectified root-missing sum-for-length disc-for-shell mean-over-band reversed-wavenumbers "
        "frames-out-of-order width-short exchanged-counts shift-off-by-one-even linspace-for-fftfreq depth-of-half "
        "first-wavenumber-for-all"
    ),
    "synthesis.energy[40]": (
        "two-thirds-energy random-amplitudes amplitude-squared half-amplitude double-energy standing-waves"
    ),
    "synthesis.single[to-250]": (
        "phase-sign phase-in-degrees no-phases sine-for-cosine omega-sign origin-off-by-one synthesis-exchanged-axes"
    ),
    "synthesis.sum[backwards]": "absolute-frequency current-left-out",
    "conformance.spectrum[spectrum-on-bin-hann]": (
        "no-taper taper-in-time-only taper-in-space-only taper-twice symmetric-taper hamming-for-hann "
        "power-returned mirror-not-conjugate"
    ),
    "leakage.swell[low]": "taper-not-along-y",
    "leakage.flicker[fast]": "taper-inside-out",
    "conformance.window[window-hann-7]": "taper-half-period",
    "conformance.spectrum[spectrum-scattered]": "blackman-sign",
    "conformance.spectrum[spectrum-half-bin]": "half-precision",
    "conformance.window[window-kaiser-bessel-12]": "kaiser-without-pi",
    "recovery.sea[broad]": "shift-missing",
    "recovery.pair[odd-2]": "least-overlap frequencies-to-nyquist",
    "recovery.pair[even-2]": "far-start",
    "recovery.pair[prime-1]": "frames-skipped shift-off-by-one-odd wrapped-images",
    "conformance.extract[nsp-narrow]": "zero-frequency-left-out",
    "conformance.extract[nsp-backwards]": "shift-at-centre",
    "metamorphic.amplitude[1e+06-tapered]": "saturated",
    "conformance.extract[nsp-oblong]": "shell-off-by-one",
    "metamorphic.symmetry[exchange-tapered]": "half-plane",
    "scale.peak[4-untapered]": "hard-coded-shell frequency-cut",
    "conformance.sea[edges-box-nsp]": "edge-bins-excluded narrow-width power-for-magnitude",
    "conformance.sea[strong-box-ls]": (
        "narrow-shell wide-shell finer-bin real-part smoothed ls-threshold-on-magnitude ls-weighted ls-intercept "
        "unsigned-wavenumbers method-ignored"
    ),
    "conformance.sea[strong-hann-nsp]": "unweighted-half wide-width missing-negative-branch",
    "conformance.sea[strong-hann-ls]": "cycles-for-radians",
    "recovery.ring[beside-moving]": (
        "extra-branch stops-at-start current-sign-in-branch narrow-bounds only-negative-branch"
    ),
    "currents.backwards[oblique]": "printed-branch",
    "conformance.extract[nsp-untapered]": "hard-coded-width",
    "conformance.extract[ls-oblong]": "ls-no-threshold",
    "behaviour.refuses[nan]": "nan-as-number nan-replaced",
    "behaviour.input[all-stages]": "input-altered",
    "behaviour.deterministic[twice]": "random-output state-kept",
    "behaviour.order[shuffled]": "sorted-wavenumbers",
    "behaviour.order[reversed]": "first-wavenumber-dropped",
}
KILLING_INPUT_OF = {name: finding for finding, names in _FAULTS_BY_FINDING.items() for name in names.split()}
"""Of each fault its killing input."""

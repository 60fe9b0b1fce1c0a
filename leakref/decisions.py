"""The register of decisions: where the paper leaves a choice, or slips, and what the reference does."""

from __future__ import annotations

from dataclasses import dataclass

__all__ = ["DECISIONS", "PRACTICE", "SLIPS", "Decision"]


@dataclass(frozen=True)
class Decision:
    """`question` left open by the paper, the `reference`'s answer, and `where` in the package it is taken."""

    id: str
    question: str
    reference: str
    where: str


def _register(*rows: tuple[str, str, str]) -> dict[str, Decision]:
    return {f"D{n}": Decision(f"D{n}", *row) for n, row in enumerate(rows, 1)}


DECISIONS = _register(
    ("How is a Hann window sampled?", "Periodic, n / N: exactly three bins of the DFT. Symmetric, n / (N - 1), is the "
     "variant.", "window.Window.samples"),
    ("Where is the negative-frequency branch of G?", "At k.c - omega0, the mirror image of a real signal. As printed, "
     "at -omega0 - k.c, it breaks P(-k, -omega) = P(k, omega), and over the whole space the sign of c is lost.",
     "nsp._centres"),
    ("Does a bin on the edge of a shell belong to it?", "Yes, with a margin of 1e-9 dk, so that rounding decides "
     "nothing.", "shell.EDGE_MARGIN"),
    ("Over which frequencies do the sums go?", "The whole Nyquist range.", "shell.shell_at"),
    ("Half the space or all of it?", "The half omega >= 0 with both branches; weight 1/2 on omega = 0 and on the "
     "Nyquist plane of even nt makes them the same.", "spectrum.Spectrum.half_weight"),
    ("How does Nelder-Mead start and stop?", "From c = 0, first simplex 2.5e-4 c0, to 1e-8 c0, N taken with means; "
     "then Newton until the gradient vanishes. That stationary point is the certified value.", "nsp.optimum"),
    ("The least-squares threshold is 0.2 of what?", "Of the shell's own largest power.", "leastsquares.THRESHOLD"),
    ("How is C minimised?", "In closed form: it is quadratic.", "leastsquares.optimum"),
    ("Which shells?", "k_i = i dk for 0.4 <= k_i <= 3.5, half width 2 dk.", "chain.shell_wavenumbers"),
    ("Which lattice of input waves?", "Spacing 0.341 / L, the origin on the lattice, k <= 3.5 k_p.",
     "sea.INPUT_SPACING"),
    ("Which random phases?", "Philox words counted by lattice indices and keyed by the realisation: the same for "
     "every sea on a lattice, on every platform.", "sea.uniform_phases"),
    ("What is the random part?", "The standard deviation of |c| over realisations, with n - 1.",
     "ensemble.Ensemble.random"),
    ("What is a rotated video?", "Sea and current turned about the centre of the domain, the grid kept.",
     "sea.Components.rotated"),
    ("Which Kaiser-Bessel window?", "I0(b sqrt(1 - (2t/T - 1)^2)) / I0(b): the printed argument turns imaginary. "
     "b = pi sqrt 3, which puts the first zero at two bins, as Hann's.", "window.KAISER_SHAPE"),
    ("Which scale of amplitudes?", "a^2 = k^-3/2 S f dk^2, which carries the spectrum's energy; printed is "
     "2 k^-3/2 S f dk. Velocities do not depend on it.", "sea.SeaState.components"),
    ("Tapered or not, where the text does not say?", "Both, always.", "cases.Configuration"),
    ("S at which frequency, with a current?", "At the intrinsic omega0(k).", "sea.SeaState.components"),
    ("How are the integrals over theta, omega and k taken?", "As plain sums over bins.",
     "nsp.normalized_scalar_product"),
    ("Which half do the least-squares data come from?", "omega >= 0 only.", "leastsquares.optimum"),
    ("What is dk where the domain is not square?", "The larger of dkx and dky, so that a shell is closed in both "
     "directions.", "grid.Grid.wavenumber_resolution"),
    ("In which unit of velocity does Nelder-Mead start, where the peak is not known?", "c0 of the given peak "
     "wavenumber; else 1 if gravity is 1 (scaled units), else the phase velocity at the shell's own wavenumber, which "
     "is the same at every scale.", "dispersion.velocity_unit"),
    ("Which values within the ranges of the table (U 0...0.15, spread 15...60, gamma 1...7)?", "U 0, 0.025, 0.075, "
     "0.15; spread 15, 30, 45, 60; gamma 1, 3.3, 7; theta0 60, 75, 90 as in the text.", "cases.CASES"),
    ("In which sense is a video rotated?", "The sea turns anticlockwise. The other sense is its mirror image, with the "
     "two crossing currents exchanged.", "cases.Configuration.components"),
    ("What of a shell that reaches past the Nyquist wavenumber?", "It is refused: part of it does not exist.",
     "shell.shell_at"),
    ("What is a shell with nothing in it?", "Largest bin below 1e-12 of the spectrum's largest: no number, noted as "
     "no-signal. A single wave under least squares, or no stationary maximum: no number either, and noted.",
     "shell.Note"),
    ("Which units, where the water is not deep?", "k0 = g = 1 as in deep water: lengths in 1 / k0, times in 1 / "
     "sqrt(g k0), velocities in sqrt(g / k0), and L and T count 2 pi of them. So the samples are the same in every "
     "water, and depth is k0 h, surface tension S k0^2 / g.", "dispersion.Scales"),
    ("At which frequency is JONSWAP, where the water is not deep?", "At omega0(k) / omega0(k0), both in that water, so "
     "that the peak stays at k0; the density over the plane is 2 (d omega0 / d k) / k times that over frequencies.",
     "sea.SeaState.components"),
    ("What does a bottom do to the spectrum?", "It is multiplied by the depth factor of the TMA spectrum (Bouws et al. "
     "1985), tanh^2(k h) / (1 + 2 k h / sinh(2 k h)), which depends on k h alone: surface tension does not change it.",
     "dispersion.Water.depth_factor"),
    ("In which unit of velocity is the search, where the water is not deep?", "The phase velocity at k0 in that water: "
     "the first simplex, the reach of 1.2 and what counts as flat shrink with it.", "dispersion.velocity_unit"),
    ("Which Doppler shift has a current that varies with depth, above a bottom?", "That of first order (Skop 1987; "
     "Kirby and Chen 1989), of which eq:SJ is the deep limit. For a linear profile, too, of which an exact relation "
     "is known.", "currents.weight"),
    ("Which sea and domain has case depth, which the paper does not have?", "The paper's own: theta0 90, spread 60, "
     "gamma 3.3, L = 10, T = 20, at k0 h 0.7, 1, 1.5 and 2. Samples, lattice and phases are those of the paper's deep "
     "water, so that only the bottom differs, and 100 realisations of all take two minutes.", "cases.CASES"),
    ("How is a depth inferred along with the current, which the paper leaves open?", "N of eq:normSp over (cx, cy, "
     "h), the mean over the bins of a shell, or of a whole band with one current and one depth. k h is looked for from "
     "pi / 10 of the shortest waves to pi of the longest, the usual limits of shallow and deep water; the highest "
     "maximum within counts, others are noted; where N hardly depends on h there is none.", "depth.infer"),
    ("Which frequency has a point of the polar current shell? (Of Shen et al. 2015 the abstract could be read.)", "For "
     "each column the mean frequency, weighted by power, of its strongest bin and the two beside it: a bin alone is as "
     "coarse as the velocity resolution.", "pcs.optimum"),
    ("Which points are the polar current shell's, and what is a robust fit of its sine curve?", "Columns whose largest "
     "power is at least 0.2 of the shell's, as for LS; Tukey's biweight with a = 4 domega, from the least squares of "
     "all. All columns of a shell are fitted together, each with its own k; omega >= 0 on the positive branch, as for "
     "LS.", "pcs.OUTLIER"),
    ("From which lattice does the search start, if not from zero current?", "-1 ... 1 c0 in steps of 0.1 along both "
     "axes, as far as N means anything: the co-author's public code has the same in m/s, which is another lattice in "
     "every sea. Of points with the same N, to 1e-9, the slowest counts. It is N that is compared, where that code has "
     "signal over noise; the rest of the search is that of D6.", "nspgrid.start"),
    ("How does an adaptive width grow with the group velocity?", "a = 4 sqrt(domega^2 + (cg dk)^2) of the shell's own "
     "wavenumber: what leaks along k by a bin is as far off in omega as cg dk, and is independent of what leaks along "
     "omega.", "nspadaptive.spread"),
    ("Which thresholds has iterative least squares? (Of Senet et al. 2001 nothing but its summary could be read.)",
     "0.2 of the shell's largest power for the first guess, which so is the LS of the paper; 0.02, a tenth of that, "
     "afterwards. All bins count alike.", "lsiterative.LOWER"),
    ("Which bins does iterative least squares take up, and when does it end?", "Those within a = 4 domega of either "
     "branch of the surface of the velocity so far, the nearer one; until the bins no longer change. If they never "
     "settle, or the first guess has no number, there is none.", "lsiterative.REACH"),
)
"""Every decision by id, D1 to D19 as first laid down, those after as they were found, D26 to D32 of other water, D33 on
of methods beside the paper's."""
PRACTICE = {
    "D2": "The second Gaussian is at -omega0 + k.c, the mirror image of a real signal, as here and not as printed.",
    "D5": "The whole space is summed, with full weight at omega = 0.",
    "D6": "The simplex starts at the best point of a lattice of velocities (D35) and stops at MATLAB's tolerances. It "
    "maximises signal over noise, <F G> / <G> over <F (1 - G)> / <1 - G>, F the root of the power as here.",
    "D9": "Bins count by a Gaussian in |k| - k_i around each wavenumber, within a band cut out beforehand.",
    "D35": "-1 ... 1 m/s in steps of 0.1 m/s in its example, the first of equal points.",
    "D36": "The width may be any function of the wavenumber; in its example it is 0.4 rad/s for all.",
}
"""What the public code of the paper's co-author does, where it decides (B. K. Smeltzer, Current_Inversion_NTNU)."""
SLIPS = {
    "printed-branch": "over the whole space N is then the same for c and -c, and where waves are swept backwards the "
    "current is lost",
    "cut-at-3": "a limit in units of one sea: waves four times shorter are cut at one and a half times their peak, and "
    "in strong currents a maximum without meaning wins",
    "printed-amplitudes": "the sea has another energy than its spectrum, which depends on the size of the domain",
    "both-halves": "a wave's mirror image at (-k, -omega) lies on the other branch, which least squares does not fit",
}
"""Variants that are no choice but a slip, of the paper or of its reader, and why. A code that is like any other variant
is right as well, and never rejected."""

"""Of the methods beside the paper's: faults of their own, and the reference that offers them all.

A fault here is one changed line of the file of a method, in a code that declares this method alone: what a method's
golden values, and the questions that every method is asked, must see. As hypotheses they are tried on codes that
declare the method. What else can go wrong in a chain (`faults`) does so by any method.
"""

from __future__ import annotations

from collections.abc import Iterable
from typing import Any, cast

from leakref.altered import Change
from leakref.certify.strength.fault import Fault
from leakref.certify.subject.named import Named
from leakref.chain import reference
from leakref.methods import METHODS

__all__ = ["FAULTS", "every", "offering"]


def offering(methods: Iterable[str]) -> dict[str, Any]:
    """What the reference declares if it offers these methods and no others, for `Named`."""
    can = cast(dict[str, Any], reference.describe()["can"])
    return {"can": {**can, "extract": {**can["extract"], "methods": list(methods)}}}


def every() -> Named:
    """The reference, offering all its methods."""
    return Named(reference, "", **offering(METHODS))


def _of(method: str, module: str, *rows: tuple[str, str, str, str, str, str]) -> tuple[Fault, ...]:
    """Faults of a method: id, family, words, killing input, the old text and the new."""
    return tuple(
        Fault(name, method, family, words, (Change(module, old, new),), killing_input=killing, methods=(method,))
        for name, family, words, killing, old, new in rows
    )


_PAIR, _VECTOR, _SEA = "recovery.pair[even-1]", "conformance.extract[{}-{}]", "conformance.sea[{}-{}]"
_GRID, _ADAPTIVE, _PCS, _ITERATED = (
    [case.format(name, method) for case, name in ((_SEA, "strong-hann"), (_SEA, "edges-box"))]
    + [_VECTOR.format(method, name) for name in ("swell", "prime")]
    for method in ("nsp-grid", "nsp-adaptive", "pcs", "ls-iterative")
)  # the strong sea, the sea with bins on edges, two vectors
FAULTS: tuple[Fault, ...] = (
    *_of("nsp-grid", "nspgrid",
         ("grid-not-climbed", "recovery", "the best point of the lattice is the answer", "recovery.ring[moving]",
          "return nsp.optimum(shell, width, unit, search=search, start=start(shell, width, unit))",
          "from dataclasses import replace\n"
          "    found = nsp.optimum(shell, width, unit, search=search, start=start(shell, width, unit))\n"
          "    return replace(found, velocity=start(shell, width, unit) * unit)"),
         ("grid-worst", "recovery", "the search starts far beyond the worst point of the lattice",
          "recovery.pair[odd-1]", "best = lattice[scores >= scores.max() * (1 - SAME)]",
          "best = 3 * lattice[scores <= scores.min() * (1 + SAME)]"),
         ("grid-negated", "currents", "the search starts opposite to the best point of the lattice", _GRID[0],
          "start=start(shell, width, unit))", "start=-start(shell, width, unit))"),
         ("grid-wide-width", "conformance", "from a lattice, but with an a of 8 domega", _GRID[2],
          "a, water = width * spectrum", "a, water = 2 * width * spectrum"),
         ("grid-hard-coded-width", "scale", "from a lattice, but with an a that is a fixed number", _GRID[3],
          "a, water = width * spectrum.grid.frequency_resolution", "a, water = 0.4"),
         ("grid-one-row", "currents", "the lattice has velocities along x only", _GRID[0],
          'indexing="ij"), axis=-1).reshape(-1, 2)', 'indexing="ij"), axis=-1).reshape(-1, 2) * [1, 0]')),
    *_of("nsp-adaptive", "nspadaptive",
         ("adaptive-hard-coded", "scale", "the width a of G is a fixed number", _ADAPTIVE[3],
          "a, law_ = width * grid.frequency_resolution,", "a, law_ = 0.4,"),
         ("adaptive-phase-velocity", "conformance", "the width grows with the phase velocity instead of the group's",
          _ADAPTIVE[2], "water.group_velocity(wavenumber)", "water.phase_velocity(wavenumber)"),
         ("adaptive-narrower", "conformance", "the width falls with the group velocity instead of growing",
          _ADAPTIVE[1], "return float(np.hypot(1.0, along_k / grid.frequency_resolution))",
          "return 1 / float(np.hypot(1.0, along_k / grid.frequency_resolution))"),
         ("adaptive-in-cycles", "conformance", "dk is in cycles per length in the width", _ADAPTIVE[1],
          "* grid.wavenumber_resolution", "* grid.wavenumber_resolution / (2 * np.pi)"),
         ("adaptive-not", "conformance", "the width is that of the paper", _ADAPTIVE[1],
          "a * spread(grid, law_, k_i)", "a"),
         ("adaptive-twice", "conformance", "the width is twice as large", _ADAPTIVE[2],
          "a * spread(grid, law_, k_i)", "2 * a * spread(grid, law_, k_i)")),
    *_of("pcs", "pcs",
         ("pcs-sign", "signs", "the shift of the crest has the wrong sign", _PAIR,
          "crest - shell.intrinsic[column]", "shell.intrinsic[column] - crest"),
         ("pcs-frequency-at-centre", "recovery", "omega0 is that of the shell's wavenumber in all columns", _PAIR,
          "crest - shell.intrinsic[column]", "crest - shell.frequency"),
         ("pcs-exchanged", "signs", "x and y are exchanged in the fit of the curve", _PAIR,
          "np.stack([shell.kx[column], shell.ky[column]])", "np.stack([shell.ky[column], shell.kx[column]])"),
         ("pcs-unit-vectors", "recovery", "the curve is not divided by the wavenumber", _PAIR,
          "k, shift = np.stack([shell.kx[column], shell.ky[column]])",
          "k, shift = np.stack([shell.kx[column], shell.ky[column]]) / np.hypot(shell.kx[column], shell.ky[column])"),
         ("pcs-weakest", "recovery", "the weakest bin of a column is taken for the crest", _PAIR,
          "power[column].argmax(axis=1)", "power[column].argmin(axis=1)"),
         ("pcs-no-threshold", "leakage", "all columns count, however weak", _PCS[2],
          "column = np.flatnonzero(tops >= threshold)", "column = np.flatnonzero(tops >= 1e-9)"),
         ("pcs-late-neighbours", "conformance", "the crest is the mean of the strongest bin and the two after it",
          _PCS[2], "np.array([-1, 0, 1])", "np.array([0, 1, 2])"),
         ("pcs-magnitude-weighted", "conformance", "the crest is weighted by magnitude instead of power", _PCS[2],
          "np.sum(shell.omega[m] * part, axis=1) / part.sum(axis=1)",
          "np.sum(shell.omega[m] * np.sqrt(part), axis=1) / np.sqrt(part).sum(axis=1)")),
    *_of("ls-iterative", "lsiterative",
         ("iterated-sign", "signs", "the shift in the fit of the weak bins has the wrong sign", _PAIR,
          "(omega - sign * intrinsic)[here]", "(sign * intrinsic - omega)[here]"),
         ("iterated-factor-two", "recovery", "the current of the weak bins is twice as large", _PAIR,
          "np.linalg.solve(normal, near @ shift)", "np.linalg.solve(normal, 2 * near @ shift)"),
         ("iterated-never", "conformance", "the first guess is the answer", _ITERATED[2],
          "velocity = np.linalg.solve(normal, near @ shift)", "velocity = guess.velocity"),
         ("iterated-in-still-water", "conformance", "bins near the dispersion surface of still water are taken",
          _ITERATED[1], "moved = omega - velocity @ k", "moved = omega"),
         ("iterated-reach-fixed", "conformance", "the reach is a fixed number instead of 4 domega", _ITERATED[3],
          "reach * shell.omega[1]", "0.2"),
         ("iterated-no-lower", "conformance", "all bins near the surface count, however weak", _ITERATED[2],
          "np.nonzero(power >= lower)", "np.nonzero(power >= 1e-12)"),
         ("iterated-lower-of-magnitude", "conformance", "the lower threshold is of the magnitude instead of the power",
          _ITERATED[2], "np.nonzero(power >= lower)", "np.nonzero(power >= lower**2)")),
)  # fmt: skip
"""By method, in the order of the register."""

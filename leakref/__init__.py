"""leakref: a reference and test oracle for measuring near-surface currents from images of waves.

It implements and examines the chain of Weichert, Smeltzer and Ellingsen, *Biases from spectral leakage in
remote sensing of near-surface currents* (arXiv 2311.01265): sea, surface, window, spectrum, shells and the
Doppler shift velocity of each. Equations are cited by the paper's LaTeX labels.

Conventions, the same everywhere:

- A surface is `eta[x, y, t]`; a larger index is a larger coordinate. Directions are going-to, anticlockwise
  from +x, in degrees in public signatures. A wave is `cos(k.x - omega t + phase)`.
- Angular units: wavenumbers in rad per length, frequencies in rad per time. `gravity = 1` goes with the
  paper's scaled units (k0 = omega0 = 1, speeds in units of the peak phase velocity c0); 9.81 with SI. Water is
  deep unless a `Water` of some depth or surface tension is given; scaled units are then still those of deep water.
- Lengths and durations are n d, never (n - 1) d. The paper's L and T count wavelengths and periods. Bins are
  `2 pi / length` and `2 pi / duration` wide. Nothing assumes a square domain.
- `S(k, omega) = sum of w eta exp(-i (k.x - omega t))`, so a wave appears at its own (+k, +omega); P = |S|^2.
- A Doppler shift velocity is what is measured; a current is the truth behind it.

Where the paper leaves a choice, or slips, the decision is named D1, D2, ... in `leakref.decisions`.
"""

from __future__ import annotations

from importlib import import_module
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from leakref._base import LeakrefError
    from leakref.chain import analyse, extract, reference, shell_wavenumbers, transform
    from leakref.currents import ExponentialCurrent, LinearCurrent, ProfileCurrent, UniformCurrent
    from leakref.dispersion import Scales, Water
    from leakref.grid import Grid
    from leakref.sea import Components, SeaState, aligned_waves
    from leakref.shell import Extraction, Note
    from leakref.spectrum import Spectrum, fourier
    from leakref.synthesis import synthesize

__version__ = "0.1.0"

_HOME = {
    "LeakrefError": "_base", "analyse": "chain", "extract": "chain", "reference": "chain", "shell_wavenumbers": "chain",
    "transform": "chain", "ExponentialCurrent": "currents", "LinearCurrent": "currents",
    "ProfileCurrent": "currents", "UniformCurrent": "currents", "Scales": "dispersion", "Water": "dispersion",
    "Grid": "grid",
    "Components": "sea", "SeaState": "sea", "aligned_waves": "sea", "Extraction": "shell", "Note": "shell",
    "Spectrum": "spectrum", "fourier": "spectrum", "synthesize": "synthesis",
}  # fmt: skip

__all__ = [
    "Components", "ExponentialCurrent", "Extraction", "Grid", "LeakrefError", "LinearCurrent", "Note",
    "ProfileCurrent", "Scales", "SeaState", "Spectrum", "UniformCurrent", "Water", "__version__", "aligned_waves",
    "analyse", "extract", "fourier", "reference", "shell_wavenumbers", "synthesize", "transform",
]  # fmt: skip


def __getattr__(name: str) -> Any:
    """Load a name from its module on first use: `import leakref` alone stays light."""
    if name not in _HOME:
        raise AttributeError(f"module 'leakref' has no attribute {name!r}")
    return getattr(import_module(f"leakref.{_HOME[name]}"), name)


def __dir__() -> list[str]:
    return __all__

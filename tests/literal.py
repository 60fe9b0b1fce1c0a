"""The literal chain, equation by equation and not slowed down: what the fast one is timed against."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from leakref import Components, Grid, fourier, leastsquares, nsp, synthesize
from leakref.shell import Extraction


def realize(
    components: Components, grid: Grid, wavenumbers: np.ndarray, *, windows: Sequence[str] = ("box", "hann")
) -> dict[tuple[str, str], Extraction]:
    """One realisation by its surface, the FFT under each window, SciPy's Nelder-Mead and least squares (route A).

    The whole Nyquist range, as many threads as the libraries take by default. Other basins are not looked for.
    """
    surface = synthesize(components, *(grid.samples(axis) for axis in range(3)))
    found = {}
    for window in windows:
        spectrum = fourier(surface, grid, window)
        found[window, "nsp"] = nsp.extract(spectrum, wavenumbers, search=False, gravity=1.0)
        found[window, "ls"] = leastsquares.extract(spectrum, wavenumbers, gravity=1.0)
    return found

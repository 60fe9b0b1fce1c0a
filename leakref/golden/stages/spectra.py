"""Spectra by both routes, and the shells cut out of them.

The stages are `transform` (of a given surface), `spectrum` (of given waves, sec:NSP_and_leakage), `shell` (which bins
belong to one, eq:g), `magnitude` (F on them, eq:maskedSpec) and `characteristic` (G, eq:DSVkernel). Outputs on a shell
come in the order of the bin numbers (i, j), so that no order of columns is part of a golden value.

- `transform`: `surface` (nx, ny, nt), `spacing`, `window`; `real` and `imag`, (nx, ny, nt), bins as `fftfreq` has them.
- `spectrum`: five arrays of waves, `shape`, `spacing`, `window`; the same.
- `shell`: `shape`, `spacing`, `wavenumber`, the water; `i`, `j`, `intrinsic` (n,), `omega`, `weight` (nt // 2 + 1,).
- `magnitude`: waves or a surface and a shell; `F` (n, nt // 2 + 1).
- `characteristic`: a shell and a `velocity` (2,); `G` (n, nt // 2 + 1).
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np

from leakref.golden import oracle
from leakref.golden.stages.stage import (
    Input,
    Output,
    Stage,
    both_routes,
    by_surface,
    grid_of,
    in_closed_form,
    listed,
    real_and_imaginary,
    relative,
    rounded,
    turns,
    water_of,
    waters,
)
from leakref.nsp import WIDTH, characteristic_function
from leakref.shell import Shell, shell_at
from leakref.spectrum import Spectrum
from leakref.window import window

__all__ = ["STAGES", "empty_spectrum", "in_order", "oracle_shell", "oracle_values", "shell_of", "width_of"]


def _all_bins(given: Input) -> oracle.Bins:
    nx, ny, _ = given["shape"]
    return [(i, j) for i in range(nx) for j in range(ny)]


def _spectrum_by_oracle(given: Input, _: Output) -> Output:
    nx, ny, nt = given["shape"]
    found = oracle.spectrum(
        listed(given), given["shape"], given["spacing"], given["window"], _all_bins(given), range(nt)
    )
    return {name: v.reshape(nx, ny, nt) for name, v in rounded(found).items()}


def _transform_by_oracle(given: Input, _: Output) -> Output:
    return rounded(oracle.transformed(given["surface"], given["window"]))


def _plain_transform(given: Input) -> Output:
    """By matrices of exponentials instead of the FFT."""
    eta = np.asarray(given["surface"], dtype=np.float64)
    for axis, sign in enumerate((-1, -1, 1)):
        n = eta.shape[axis]
        m = np.arange(n)
        matrix = np.exp(sign * 2j * np.pi * (np.outer(m, m) % n) / n) * window(given["window"]).samples(n)
        eta = np.moveaxis(np.tensordot(matrix, eta, axes=(1, axis)), 0, axis)
    return real_and_imaginary(eta)


def _spectrum_conditioning(given: Input, found: Output) -> Output:
    """Real and imaginary parts by the largest magnitude, since that is what rounds."""
    largest = float(np.hypot(found["real"], found["imag"]).max())
    return {"real": largest * turns(given), "imag": largest * turns(given)}


def shell_of(spectrum: Spectrum, given: Input) -> Shell:
    """The shell that the input of an entry asks for. The input names `wavenumber`, and the water."""
    return shell_at(spectrum, given["wavenumber"], water=water_of(given))


def in_order(shell: Shell, given: Input) -> Any:
    """Columns by bin numbers (i, j), ascending.

    Returned are i, j (n,) and the order that sorts the columns.
    """
    grid = grid_of(given)
    i, j = (np.rint(k / dk).astype(int) for k, dk in zip((shell.kx, shell.ky), grid.bin_widths, strict=False))
    return i, j, np.lexsort((j, i))


def empty_spectrum(given: Input) -> Spectrum:
    """A spectrum of the right bins that holds nothing, for what depends on the bins alone.

    Its shape is that of the grid with half of the frequencies; all values are 1, so that shells find their bins.
    """
    grid = grid_of(given)
    nx, ny, nt = grid.shape
    return Spectrum(grid, "box", grid.bins(0), grid.bins(1), np.ones((nx, ny, nt // 2 + 1), dtype=np.complex128))


def _membership(given: Input) -> Output:
    """Which bins a shell has, their omega0, and the weights of frequencies; no magnitudes are needed for that."""
    shell = shell_of(empty_spectrum(given), given)
    i, j, order = in_order(shell, given)
    return {
        "i": i[order],
        "j": j[order],
        "intrinsic": shell.intrinsic[order],
        "weight": shell.weight,
        "omega": shell.omega,
    }


def _membership_by_oracle(given: Input, _: Output) -> Output:
    """From the definition, bin by bin."""
    shell, bins = oracle_shell(given, None)
    return {
        "i": [i for i, _ in bins],
        "j": [j for _, j in bins],
        "intrinsic": shell.omega0,
        "weight": shell.weight,
        "omega": shell.omega,
    }


def oracle_shell(
    given: Input, values: Callable[[oracle.Bins], Any] | None, wavenumber: float | None = None
) -> tuple[oracle.Shell, oracle.Bins]:
    """A shell as the high-precision oracle makes it, and its bins; `values` gives what the bins hold.

    `wavenumber` is that of the input unless given; `values` None makes a shell without magnitudes, for membership
    alone.
    """
    bins = sorted(oracle.shell_bins(given["shape"], given["spacing"], wavenumber or given["wavenumber"]))
    found = values(bins) if values is not None else None
    return oracle.Shell(found, bins, given["shape"], given["spacing"], **waters(given)), bins


def oracle_values(given: Input) -> Callable[[oracle.Bins], Any]:
    """S at given columns, from waves or from a surface."""
    if "surface" not in given:
        return lambda bins: oracle.spectrum(listed(given), given["shape"], given["spacing"], given["window"], bins)
    everything = oracle.transformed(given["surface"], given["window"])
    return lambda bins: [everything[i][j][: given["shape"][2] // 2 + 1] for i, j in bins]


def _magnitude(spectrum: Callable[[Input], Spectrum]) -> Callable[[Input], Output]:
    """F on the columns of the shell, in the order of their numbers."""

    def run(given: Input) -> Output:
        shell = shell_of(spectrum(given), given)
        return {"F": shell.magnitude[in_order(shell, given)[2]]}

    return run


def _magnitude_by_oracle(given: Input, _: Output) -> Output:
    return {"F": oracle_shell(given, oracle_values(given))[0].f}


def width_of(given: Input) -> float:
    """The width a of G, in rad per unit time.

    `WIDTH` frequency bins (a of eq:DSVkernel, sec:parameters).
    """
    return WIDTH * grid_of(given).frequency_resolution


def _characteristic(given: Input) -> Output:
    shell = shell_of(empty_spectrum(given), given)
    return {"G": characteristic_function(shell, given["velocity"], width_of(given))[in_order(shell, given)[2]]}


def _characteristic_by_oracle(given: Input, _: Output) -> Output:
    return {"G": oracle.characteristic(oracle_shell(given, None)[0], given["velocity"])}


def _characteristic_conditioning(given: Input, _: Output) -> Output:
    """An exponent 2 z^2 is off by 4 z times the rounding of z, and z exp(-2 z^2) < 0.31."""
    shell = shell_of(empty_spectrum(given), given)
    reach = shell.omega[-1] + shell.intrinsic.max() + np.hypot(shell.kx, shell.ky).max() * np.hypot(*given["velocity"])
    return {"G": float(4 + 4 * reach / width_of(given))}


STAGES = {
    "transform": Stage(
        "sec:leakage",
        {"chain": lambda g: real_and_imaginary(by_surface(g).whole()), "matrices": _plain_transform},
        _transform_by_oracle,
        _spectrum_conditioning,
    ),
    "spectrum": Stage(
        "sec:NSP_and_leakage",
        {
            "A": lambda g: real_and_imaginary(by_surface(g).whole()),
            "B": lambda g: real_and_imaginary(in_closed_form(g).whole()),
        },
        _spectrum_by_oracle,
        _spectrum_conditioning,
    ),
    "shell": Stage("eq:g", {"chain": _membership}, _membership_by_oracle, relative(4, "i", "j", "weight")),
    "magnitude": Stage(
        "eq:maskedSpec",
        both_routes(_magnitude),
        _magnitude_by_oracle,
        lambda g, f: {"F": in_closed_form(g).strongest[0] * turns(g)},
    ),
    "characteristic": Stage(
        "eq:DSVkernel", {"chain": _characteristic}, _characteristic_by_oracle, _characteristic_conditioning
    ),
}

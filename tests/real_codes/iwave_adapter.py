"""IWaVE behind protocol 1, for the Python of an environment in which it is installed (not that of leakref).

It is handed metres, seconds and metres of depth as they come, and says for which waves it is made. IWaVE fits one
velocity to the whole spectrum of a picture sequence; it knows one size of pixel for both axes, even numbers of pixels,
one gravity and one surface tension.

`--waves-only` sets what its documentation recommends where waves dominate and the velocity is known roughly: no branch
for floating particles, no penalty on fast velocities; and no normalisation of each pixel by its own variation in time,
which undoes a taper in space. `--fastest` is its `smax`, in m/s (4 if not given).
"""

from __future__ import annotations

import argparse
import contextlib
import json
import sys
from typing import Any

import numpy as np
from iwave import Iwave, __version__, const, optimise
from iwave.iwave import OPTIM_KWARGS_SADE

PASSES = [2, 1]  # its default: half the spectrum first, then all of it


def declaration(options: argparse.Namespace) -> dict[str, Any]:
    """What is true of it."""
    how = "waves only" if options.waves_only else "as it comes"
    return {
        "op": "ready",
        "protocol": 1,
        "name": f"iwave ({how})",
        "version": __version__,
        "format": "npz",
        "units": "si",
        "axes": "tyx",
        "y": "up",
        "direction": "to",
        "fixed": ["wavenumbers", "dy", "gravity (9.81)", "profile (even)", "width (1 rad/s)"],
        "cube": {"multiple": 2, "duration": 5.0},  # s: of its README
        "water": {"depth": "given", "surface_tension": const.surf_tens / const.density},
        "waves": {"peak_wavelength": options.waves, "fastest": options.fastest},
        "can": {"extract": {"methods": ["fit"], "windows": [], "resolves": "band"}},
    }


def velocity(eta: np.ndarray, p: dict[str, Any], options: argparse.Namespace) -> list[float]:
    """(cx, cy) in m/s. As `Iwave.velocimetry` does it for one window, but in this process and with a fixed seed."""
    if not np.isfinite(eta).all():
        raise ValueError("the pictures hold values that are not finite")
    code = Iwave(
        p["dx"],
        window_size=eta.shape[1:],
        time_size=len(eta),
        fps=1 / p["dt"],
        smax=options.fastest,
        norm=None if options.waves_only else "time",
    )
    code.imgs = eta[:, ::-1]  # the first row of a picture is at its top
    north, east, *_ = optimise.optimize_single_spectrum_velocity(
        code.spectrum[0:1][0],
        [(-options.fastest, options.fastest)] * 2 + [(p["depth"], p["depth"])],
        vel_indx=1.0,
        window_dims=code.spectrum_dims,
        res=p["dx"],
        fps=1 / p["dt"],
        penalty_weight=0 if options.waves_only else 1,
        gravity_waves_switch=True,
        turbulence_switch=not options.waves_only,
        pass_downsampling=PASSES,
        gauss_width=1,
        kwargs={**OPTIM_KWARGS_SADE, "seed": 1},
    )
    return [float(east), float(north)]


def answer(request: dict[str, Any], options: argparse.Namespace) -> dict[str, Any]:
    """To one request."""
    try:
        with np.load(request["input"]) as arrays, contextlib.redirect_stdout(sys.stderr):
            found = velocity(arrays["eta"], request["parameters"], options)
    except Exception as error:
        return {"id": request["id"], "status": "error", "message": f"{type(error).__name__}: {error}"}
    return {"id": request["id"], "status": "ok", "velocities": [found]}


def main() -> None:
    """The loop of protocol 1."""
    parser = argparse.ArgumentParser()
    parser.add_argument("--waves-only", action="store_true")
    parser.add_argument("--fastest", type=float, default=4.0)
    parser.add_argument("--waves", type=float, nargs=2, default=[0.5, 4.0])
    options = parser.parse_args()
    for line in sys.stdin:
        request = json.loads(line)
        if request["op"] == "stop":
            break
        said = declaration(options) if request["op"] == "start" else answer(request, options)
        print(json.dumps(said), flush=True)


if __name__ == "__main__":
    main()

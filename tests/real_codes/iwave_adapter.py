"""IWaVE behind protocol 1, for the Python of an environment in which it is installed (not that of leakref).

IWaVE fits one velocity to the whole spectrum of a picture sequence; it knows one size of pixel for both axes, and even
numbers of pixels, so that an odd last row or column is left out.

`--waves-only` switches off what is of no use on water without floating particles: their branch of the dispersion
relation, the normalisation of each pixel by its own variation in time (which undoes a taper in space), and the penalty
on fast velocities; then `--fastest` should not be far above the velocities that there are (in m/s, 4 if not given).
`--shrink N` shows it every sea N times shorter by Froude's law, since its width of 1 rad/s is meant for waves of
metres, not of 25 m.
"""

from __future__ import annotations

import argparse
import contextlib
import json
import sys
from typing import Any

import numpy as np
from iwave import Iwave, __version__, optimise
from iwave.iwave import OPTIM_KWARGS_SADE

DEPTH = 1000.0  # in metres: deep water for all waves
PASSES = [2, 1]  # its default: half the spectrum first, then all of it


def declaration(options: argparse.Namespace) -> dict[str, Any]:
    """What is true of it."""
    how = "waves only" if options.waves_only else "as it comes"
    return {
        "op": "ready",
        "protocol": 1,
        "name": f"iwave ({how}, seas shrunk {options.shrink:g} times)",
        "version": __version__,
        "format": "npz",
        "units": "si",
        "axes": "tyx",
        "y": "up",
        "direction": "to",
        "fixed": [
            "wavenumbers",
            "dy",
            "gravity (9.81)",
            "depth (1000 m)",
            "profile (even)",
            "width (1 rad/s)",
            f"velocities (up to {options.fastest:g} m/s)",
        ],
        "can": {"extract": {"methods": ["fit"], "windows": [], "resolves": "band"}},
    }


def velocity(eta: np.ndarray, p: dict[str, Any], options: argparse.Namespace) -> list[float]:
    """(cx, cy) in m/s. As `Iwave.velocimetry` does it for one window, but in this process and with a fixed seed."""
    if not np.isfinite(eta).all():
        raise ValueError("the pictures hold values that are not finite")
    pictures = eta[:, : eta.shape[1] // 2 * 2, : eta.shape[2] // 2 * 2]
    size, fps = p["dx"] / options.shrink, options.shrink**0.5 / p["dt"]
    code = Iwave(
        size,
        window_size=pictures.shape[1:],
        time_size=len(pictures),
        fps=fps,
        smax=options.fastest,
        norm=None if options.waves_only else "time",
    )
    code.imgs = pictures[:, ::-1]  # the first row of a picture is at its top
    waves_only = (
        {"penalty_weight": 0, "turbulence_switch": False}
        if options.waves_only
        else {"penalty_weight": 1, "turbulence_switch": True}
    )
    north, east, *_ = optimise.optimize_single_spectrum_velocity(
        code.spectrum[0:1][0],
        [(-options.fastest, options.fastest)] * 2 + [(DEPTH, DEPTH)],
        vel_indx=1.0,
        window_dims=code.spectrum_dims,
        res=size,
        fps=fps,
        gravity_waves_switch=True,
        pass_downsampling=PASSES,
        gauss_width=1,
        kwargs={**OPTIM_KWARGS_SADE, "seed": 1},
        **waves_only,
    )
    return [float(east) * options.shrink**0.5, float(north) * options.shrink**0.5]


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
    parser.add_argument("--shrink", type=float, default=1.0)
    options = parser.parse_args()
    for line in sys.stdin:
        request = json.loads(line)
        if request["op"] == "stop":
            break
        said = declaration(options) if request["op"] == "start" else answer(request, options)
        print(json.dumps(said), flush=True)


if __name__ == "__main__":
    main()

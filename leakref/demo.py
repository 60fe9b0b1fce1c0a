"""`leakref demo`: the paper's central result, seen to appear.

It needs no input: a narrow sea in still water, measured with and without a taper, by the surface and
its FFT and in closed form; then the reference and a code with a planted fault are certified by a few checks. Each step
states its figure and whether it is as it should be.
"""

from __future__ import annotations

from contextlib import nullcontext
from dataclasses import replace
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np
from rich.console import Console

from leakref import chain
from leakref._base import FloatArray
from leakref._output import console, dump, envelope, folder, progress_bar, write_whole
from leakref.cases import Configuration, configurations
from leakref.certify.commands import Request, named
from leakref.certify.report import page as render
from leakref.certify.runner import certify, select
from leakref.certify.strength.diagnosis import explain
from leakref.certify.strength.faults import FAULTS
from leakref.certify.subject.inprocess import InProcess
from leakref.certify.targets import load
from leakref.ensemble import Ensemble
from leakref.paper.reproduce import table
from leakref.shell import Extraction

__all__ = ["CASE", "run"]

CASE = "theta0-dtheta/direction=60,spread=15"
"""In still water, going to 60 degrees: leakage runs along the axes and not along the waves."""
_REALIZATIONS = 3
_SPECTRA = 1e-13  # of the largest |S|: rounding over 22 million samples
_CHECKS = ("signs", "recovery.pair", "conformance.window", "conformance.spectrum", "conformance.surface")
_FAULT = "exchanged-axes"
_VELOCITIES = 1e-11  # c0, in shells without a note: what a rounding of F can move


def run(out: Path, *, json: bool = False) -> bool:
    """One narrow sea of the paper in still water, untapered and tapered, by both routes; whether all came true.

    Written to `out` are the picture and the certificate of the faulty code. The steps are printed, or in the JSON.
    """
    from leakref.figures import result_figure, save

    folder(out)
    configuration = replace(configurations([CASE])[0], varied=())
    wavenumbers = configuration.wavenumbers[::2]
    console().print(
        f"Still water, a narrow sea travelling at {configuration.direction:g}°: {_REALIZATIONS} videos of "
        f"{' x '.join(map(str, configuration.grid.shape))} samples, {wavenumbers.size} wavenumbers each."
    )
    ensembles, spectra, velocities = _measure(configuration, wavenumbers)
    title = f"Measured in still water, where nothing should be: {_REALIZATIONS} realisations"
    pictures = save(result_figure(list(ensembles.values()), title), out / "demo")

    box, hann = ensembles["box"].bias, ensembles["hann"].bias
    smaller, larger = np.sort(ensembles["box"].resolutions, axis=0)
    high = wavenumbers > 1.2
    spurious, cured = float(np.mean((box > larger)[high])), float(np.mean((hann < smaller)[high]))
    steps: list[dict[str, Any]] = [
        {
            "name": "FFT of the surface against closed form of the leakage, difference over the largest |S|",
            "ok": spectra <= _SPECTRA,
            "figure": spectra,
        },
        {
            "name": "velocities by both routes, largest difference in c0",
            "ok": velocities <= _VELOCITIES,
            "figure": velocities,
        },
        {
            "name": "untapered: share of wavenumbers above 1.2 whose spurious current exceeds both resolutions",
            "ok": spurious > 0.5,
            "figure": spurious,
        },
        {"name": "tapered: share of them where it is below the smaller resolution", "ok": cured > 0.5, "figure": cured},
    ]
    certified, page = _certify(out)
    steps += certified
    ok = all(step["ok"] for step in steps)
    if json:
        print(dump(envelope("demo", ok, steps=steps, pictures=pictures, page=page)))
        return ok
    show = Console()
    show.print(table(list(ensembles.values())))
    for step in steps:
        verdict = "[green]holds[/green]" if step["ok"] else "[red]FAILS[/red]"
        figure = step["figure"] if isinstance(step["figure"], str) else f"{step['figure']:.2g}"
        show.print(f"{verdict}  {step['name']}: {figure}", soft_wrap=True)
    worst = int(np.argmax(np.where(high, box, 0)))
    show.print(
        f"\nThere is no current, yet without a window one of {box[worst]:.2f} c0 is measured at k = "
        f"{wavenumbers[worst]:.1f}, {box[worst] / smaller[worst]:.0f} times the resolution: energy of the "
        f"spectral peak, leaked along the axes of the transform. A Hann window brings it down to "
        f"{hann[worst]:.3f} c0.\n"
    )
    show.print(
        f"Picture: {pictures[0]}\nCertificate of the code with the planted fault, to open in a browser: {page}",
        soft_wrap=True,
    )
    return ok


def _certify(out: Path) -> tuple[list[dict[str, Any]], Path]:
    """The reference certified and a planted fault caught and named, on a few of the checks, in this process; steps, and
    the page of the faulty code.
    """
    found = {}
    checks = select(_CHECKS, profile="quick")
    with progress_bar("checks of the reference, and of a planted fault", 2 * len(checks)) as step:
        for target in ("reference", f"fault:{_FAULT}"):
            subject = InProcess(load(target))
            found[target] = certify(
                target,
                [nullcontext(subject)],
                checks,
                profile="quick",
                only=_CHECKS,
                after_each=lambda finding: step(),
            )
    with progress_bar("faults and repairs tried on what fell short", None) as step:
        caught = explain(found[f"fault:{_FAULT}"], subject, after_each=step)
    caught = named(caught, Request(f"fault:{_FAULT}", None, only=_CHECKS))
    page = write_whole(out / "certificate.html", partial(_write_text, render(caught)))
    right_name = bool(caught.diagnosis) and caught.diagnosis[0]["fault"] == _FAULT
    right = found["reference"]
    return [
        {
            "name": f"the reference certified by {len(checks)} checks",
            "ok": right.grade == "conformant",
            "figure": str(right.grade),
        },
        {
            "name": f"a planted fault ({FAULTS[_FAULT].words}) caught and named",
            "ok": caught.status == 1 and right_name,
            "figure": f"{caught.grade}; {caught.explanation}",
        },
    ], page


def _write_text(text: str, path: Path) -> None:
    path.write_text(text, encoding="utf-8")


def _measure(configuration: Configuration, wavenumbers: FloatArray) -> tuple[dict[str, Ensemble], float, float]:
    """Ensembles by window from route A, and how far route B is from it: spectra (relative) and velocities (c0).

    Spectra are compared for all realisations, velocities for the first. Spectra are held to 1e-13 of the largest
    magnitude and velocities to 1e-11 `c0`, in shells without a note.
    """
    grid = configuration.grid
    found: dict[str, list[Extraction]] = {name: [] for name in configuration.windows}
    spectra = velocities = 0.0
    reach = float(wavenumbers[-1]) + 3 * grid.wavenumber_resolution
    with progress_bar("videos, each untapered and tapered", _REALIZATIONS * len(found)) as step:
        for number in range(_REALIZATIONS):
            waves = configuration.components(number)
            closed = chain.transform(waves, grid, configuration.windows, route="B", largest_wavenumber=reach)
            for a, b in zip(chain.transform(waves, grid, configuration.windows, route="A"), closed, strict=True):
                difference = np.abs(a.values[np.ix_(b.i, b.j)] - b.values).max()
                spectra = max(spectra, float(difference / a.strongest[0]))
                found[a.window].append(chain.analyse(a, wavenumbers, search=False, gravity=1.0))
                if number == 0:
                    mine, other = found[a.window][0], chain.analyse(b, wavenumbers, search=False, gravity=1.0)
                    plain = [not one and not two for one, two in zip(mine.notes, other.notes, strict=True)]
                    velocities = max(velocities, float(np.abs(mine.velocities - other.velocities)[plain].max()))
                step()
    ensembles = {
        name: Ensemble(
            configuration,
            name,
            "nsp",
            wavenumbers,
            np.array([e.velocities for e in all_of_it]),
            np.array([[note.value for note in e.notes] for e in all_of_it]),
        )
        for name, all_of_it in found.items()
    }
    return ensembles, spectra, velocities

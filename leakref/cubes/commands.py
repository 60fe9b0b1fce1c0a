"""`leakref extract`: one's own cube comes in.

It reads a cube, measures, screens if asked to, and prints or writes what it found, in the units of the file. It says in
notes whatever was done to the samples, and in a line what was taken for granted. All refusals name the file and what to
do about it.
"""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np
from rich.console import Console
from rich.markup import escape

from leakref._base import FloatArray, LeakrefError
from leakref._output import console, dump, envelope, folder
from leakref.cubes import blocks, files, reporting, screen
from leakref.cubes.asked import parse_crop, parse_range, parse_spacing
from leakref.cubes.cube import UNITS, Cube
from leakref.cubes.measuring import Measured, Request, measure
from leakref.cubes.waters import is_metric
from leakref.cubes.wavenumbers import parse_wavenumbers
from leakref.dispersion import velocity_resolutions
from leakref.methods import method as named_method
from leakref.scope import Scope
from leakref.shell import Extraction
from leakref.window import window as named_window

__all__ = ["extract"]


def extract(
    file: Path,
    *,
    window: str,
    method: str,
    wavenumbers: str | None,
    screening: bool,
    rotate: float | None,
    detrend: str,
    out: Path | None,
    json: bool,
    spacing: str | None = None,
    crop: str | None = None,
    frames: str | None = None,
    **said: Any,
) -> bool:
    """The chain on the cube in `file`: print a table or JSON, write everything to `out` if given.

    Returns whether the velocities can be trusted as far as was looked: False if the spectrum shows no dispersion shell,
    or none where gravity and the steps put it, and if they are untapered and the screen found leakage in them. Raises
    LeakrefError.

    `wavenumbers` are a list or a range as typed; without them every dk is taken where there is signal. `rotate` is in
    degrees and needs `screening`; `spacing` (dx,dy,dt), `crop` and `frames` are as typed, `said` other fields of
    `Asked`: they go before what the file says; `detrend` is one of `blocks.TRENDS`. Refused is also `rotate` for a cube
    that is not held in memory. The JSON has `wavenumbers`, `doppler_shift_velocities` (null where there is none),
    `flags`, both resolutions, `score` and the contrasts `shell`, n each; `shell_band`; what was `assumed` and
    `removed`; `verdicts` and `screen` (null if not screened); and in `notes` what was done to the cube.
    """
    named_window(window)
    named_method(method, "extract")
    if rotate is not None and not screening:
        raise LeakrefError("extract", "--rotate belongs to the screen", "add --screen")
    if detrend not in blocks.TRENDS:
        raise LeakrefError("extract", f"--detrend {detrend} is unknown", f"choose one of {', '.join(blocks.TRENDS)}")
    asked = None if wavenumbers is None else parse_wavenumbers(wavenumbers)
    parsers = {"spacing": (parse_spacing, spacing), "crop": (parse_crop, crop), "frames": (_frames, frames)}
    typed = {name: parse(text) for name, (parse, text) in parsers.items() if text is not None}
    cube = files.read(file, **typed, **said)
    if out is not None:
        folder(out)
    request = Request(window, method, asked, screening, rotate, detrend)
    try:
        measured = measure(cube, request)
    except LeakrefError as error:
        raise LeakrefError("extract", f"{file}: {error.fault}", error.remedy) from None
    record, flags, resolutions = _record(file, cube, measured, request)
    if out is not None:
        reporting.write(out, record, measured.found, flags, resolutions, measured.screened, cube)
    if json:
        print(dump(record))
    else:
        _show(file, cube, measured, window, flags, resolutions, out)
    return bool(record["ok"])


def _frames(text: str) -> slice:
    return parse_range("--frames", text)


def _record(
    file: Path, cube: Cube, measured: Measured, request: Request
) -> tuple[dict[str, Any], list[list[str]], Sequence[FloatArray]]:
    """What stands in the JSON, the flags of each wavenumber, and the two resolutions."""
    found, screened, shell, window = measured.found, measured.screened, measured.shell, request.window
    dk, domega = cube.grid.wavenumber_resolution, cube.grid.frequency_resolution
    resolutions = velocity_resolutions(found.wavenumbers, dk, domega, cube.water)
    flags = [list(note.names) for note in found.notes]
    if screened is not None and window == "box":  # flags belong to the velocities reported: the untapered ones
        for names, verdict in zip(flags, screened.verdicts, strict=True):
            names += [screen.LEAKAGE] * (verdict == screen.LEAKAGE)
    ok = screened is None or window != "box" or screen.LEAKAGE not in screened.verdicts
    record = envelope(
        "extract",
        ok and (shell is None or shell.holds),
        wavenumbers=found.wavenumbers,
        doppler_shift_velocities=reporting.rows(found.velocities),
        flags=flags,
        resolution_frequency=resolutions[0],
        resolution_wavenumber=resolutions[1],
        score=found.score,
        file=file,
        window=window,
        method=request.method,
        units={"system": cube.units, "wavenumber": reporting.PER_LENGTH[cube.units], "velocity": UNITS[cube.units]},
        gravity=cube.gravity,
        depth=cube.depth,
        surface_tension=cube.surface_tension,
        shape=cube.grid.shape,
        spacing=cube.grid.spacing,
        axes="xyt",
        removed={"trend": request.detrend, "mean": measured.trend[0], "slopes_per_sample": measured.trend[1:]},
        current=cube.current,
        peak_wavenumber=cube.peak_wavenumber,
        assumed=None if cube.assumed is None else cube.assumed.record(),
        shell=measured.contrasts,
        shell_band=reporting.shell_record(shell),
        notes=measured.notes,
        scope=scope_of(cube, found).record(),
        verdicts=None if screened is None else screened.verdicts,
        screen=reporting.screen_record(screened, window),
    )
    return record, flags, resolutions


def scope_of(cube: Cube, found: Extraction) -> Scope:
    """In which waves, water and current the velocities were had, in the words of certificates."""
    there = np.isfinite(found.velocities).all(axis=1)
    lengths = 2 * np.pi / found.wavenumbers[there]
    speeds = np.hypot(*found.velocities[there].T)
    metric = is_metric(cube.units, cube.gravity)
    units = {"scaled": ("/ k0", "c0")}.get(cube.units, ("m", "m/s") if metric else ("of its lengths", "of its speeds"))
    return Scope(
        (float(lengths.min()), float(lengths.max())) if lengths.size else None,
        cube.depth,
        cube.surface_tension,
        float(speeds.max()) if speeds.size else None,
        None if cube.peak_wavenumber is None else float(2 * np.pi / cube.peak_wavenumber),
        units,
        metric,
    )


def _show(
    file: Path,
    cube: Cube,
    measured: Measured,
    window: str,
    flags: list[list[str]],
    resolutions: Sequence[FloatArray],
    out: Path | None,
) -> None:
    """Everything on the terminal: what was taken for granted, the table, the notes, the verdicts."""
    show, screened = Console(), measured.screened
    lines = [] if cube.assumed is None else [cube.assumed.line()]
    for line in lines:
        show.print(line, soft_wrap=True, highlight=False, markup=False)
    show.print(reporting.table(file, measured.found, flags, resolutions, screened, cube, window))
    for note in measured.notes:
        show.print(f"- {note}", soft_wrap=True, highlight=False, markup=False)
    if measured.shell is None:
        show.print("- whether there is a dispersion shell was not looked for: the cube is too small", soft_wrap=True)
    for line in () if measured.shell is None else measured.shell.words:
        style = "yellow" if measured.shell is not None and measured.shell.holds else "red"
        show.print(line, soft_wrap=True, highlight=False, markup=False, style=style)
    if screened is not None:
        for line in reporting.summary(screened):
            show.print(line, soft_wrap=True, highlight=False)
    scope = scope_of(cube, measured.found)
    for line in filter(None, (scope.words, scope.advice)):
        show.print(f"{line}.", soft_wrap=True, highlight=False, markup=False)
    if out is not None:
        there = ", ".join(
            kind
            for kind, name in (("JSON", "json"), ("CSV", "csv"), ("NetCDF", "nc"))
            if (out / f"extract.{name}").exists()
        )
        console().print(f"[dim]table ({there}) and figures in {escape(str(out))}[/dim]", soft_wrap=True)

"""`leakref export` and `leakref extract`: a cube with a known truth goes out, one's own cube comes in.

`extract` reads a cube, removes what trend is asked for, measures, screens if asked to, and prints or writes what it
found, in the units of the file. It says in notes whatever was done to the samples. All refusals name the file and what
to do about it. `spectrum_of` is used by others that have a Cube.
"""

from __future__ import annotations

import csv
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
from rich.console import Console
from rich.markup import escape
from rich.table import Table

from leakref._base import FloatArray, LeakrefError, levelled
from leakref._output import console, dump, envelope, folder, write_whole
from leakref.chain import analyse
from leakref.cubes import blocks, files, formats, screen
from leakref.cubes.files import UNITS, Cube
from leakref.cubes.wavenumbers import default_wavenumbers, parse_numbers, parse_wavenumbers
from leakref.dispersion import Water, velocity_resolutions
from leakref.methods import method as named_method
from leakref.shell import HALF_WIDTH, Extraction
from leakref.spectrum import Spectrum, fourier
from leakref.window import window as named_window

__all__ = ["extract", "spectrum_of"]

IN_MEMORY = 2**30
"""A memory-mapped cube larger than this many bytes, as float64, is transformed in blocks."""
KEPT = 2**30
"""Bytes of spectrum kept of such a cube where no wavenumbers are asked for."""
_PER_LENGTH = {"si": "rad/m", "scaled": "k0", "given": "rad per length"}


def spectrum_of(cube: Cube, window: str, trend: FloatArray | None, reach: float | None, *, in_blocks: bool) -> Spectrum:
    """The spectrum of a cube less its trend, whole or (`in_blocks`) of what lies within `reach`.

    `trend` is from `blocks.trend`, None for none; `reach` is the largest wavenumber kept, in rad per length, and counts
    only `in_blocks`.
    """
    if in_blocks:
        return blocks.fourier_in_blocks(cube.surface, cube.grid, window, largest_wavenumber=reach, remove=trend)
    eta = cube.surface if trend is None else cube.surface - blocks.plane(trend, cube.grid.shape)
    return fourier(eta, cube.grid, window)


def extract(
    file: Path,
    *,
    window: str,
    method: str,
    wavenumbers: str | None,
    screening: bool,
    rotate: float | None,
    spacing: str | None,
    axes: str | None,
    gravity: float | None,
    detrend: str,
    out: Path | None,
    json: bool,
) -> bool:
    """The chain on the cube in `file`: print a table or JSON, write everything to `out` if given.

    Returns whether the velocities can be trusted as far as was looked: False if they are untapered and the screen found
    leakage in them. Raises LeakrefError.

    `wavenumbers` are a list or a range as typed; without them every dk is taken where there is signal. `rotate` is in
    degrees and needs `screening`; `spacing` (dx,dy,dt), `axes` and `gravity` go before what the file says; `detrend` is
    one of `blocks.TRENDS`. Refused are also a cube with no signal at all, and `rotate` for one that is not held in
    memory. The JSON has `wavenumbers`, `doppler_shift_velocities` (null where there is none), `flags`, both resolutions
    and `score`, n each; what was `removed`; `verdicts` and `screen` (null if not screened); and in `notes` what was
    done to the cube.
    """
    named_window(window)
    named_method(method, "extract")
    if rotate is not None and not screening:
        raise LeakrefError("extract", "--rotate belongs to the screen", "add --screen")
    if detrend not in blocks.TRENDS:
        raise LeakrefError("extract", f"--detrend {detrend} is unknown", f"choose one of {', '.join(blocks.TRENDS)}")
    asked = None if wavenumbers is None else parse_wavenumbers(wavenumbers)
    cube = files.read(
        file, spacing=None if spacing is None else parse_numbers("--spacing", spacing, 3), axes=axes, gravity=gravity
    )
    if out is not None:
        folder(out)
    try:
        found, screened, notes, trend = _measure(cube, window, method, asked, screening, rotate, detrend)
    except LeakrefError as error:
        raise LeakrefError("extract", f"{file}: {error.fault}", error.remedy) from None
    resolutions = velocity_resolutions(
        found.wavenumbers, cube.grid.wavenumber_resolution, cube.grid.frequency_resolution, Water(cube.gravity)
    )
    flags = [list(note.names) for note in found.notes]
    if screened is not None and window == "box":  # flags belong to the velocities reported: the untapered ones
        for names, verdict in zip(flags, screened.verdicts, strict=True):
            names += [screen.LEAKAGE] * (verdict == screen.LEAKAGE)
    ok = screened is None or window != "box" or screen.LEAKAGE not in screened.verdicts
    record = envelope(
        "extract",
        ok,
        wavenumbers=found.wavenumbers,
        doppler_shift_velocities=_rows(found.velocities),
        flags=flags,
        resolution_frequency=resolutions[0],
        resolution_wavenumber=resolutions[1],
        score=found.score,
        file=file,
        window=window,
        method=method,
        units={"system": cube.units, "wavenumber": _PER_LENGTH[cube.units], "velocity": UNITS[cube.units]},
        gravity=cube.gravity,
        shape=cube.grid.shape,
        spacing=cube.grid.spacing,
        axes="xyt",
        removed={"trend": detrend, "mean": trend[0], "slopes_per_sample": trend[1:]},
        current=cube.current,
        peak_wavenumber=cube.peak_wavenumber,
        notes=notes,
        verdicts=None if screened is None else screened.verdicts,
        screen=_screen_record(screened, window),
    )
    if out is not None:
        _write(out, record, found, flags, resolutions, screened, cube)
    if json:
        print(dump(record))
        return ok
    show = Console()
    show.print(_table(file, found, flags, resolutions, screened, cube, window))
    for note in notes:
        show.print(f"- {note}", soft_wrap=True, highlight=False)
    if screened is not None:
        show.print(_summary(screened), soft_wrap=True, highlight=False)
    if out is not None:
        there = ", ".join(
            kind
            for kind, name in (("JSON", "json"), ("CSV", "csv"), ("NetCDF", "nc"))
            if (out / f"extract.{name}").exists()
        )
        console().print(f"[dim]table ({there}) and figures in {escape(str(out))}[/dim]", soft_wrap=True)
    return ok


def _measure(
    cube: Cube, window: str, method: str, asked: FloatArray | None, screening: bool, angle: float | None, detrend: str
) -> tuple[Extraction, screen.Screening | None, list[str], FloatArray]:
    """The velocities, the screening if wanted, what to say, and the trend that was removed (zeros if none). In this
    order: decide whether blocks are needed, remove the trend, transform under the window, choose wavenumbers by where
    the tapered spectrum has signal, extract, and if asked for screen, turned or not. A cube whose samples are extreme
    is scaled by a power of two first, which moves no velocity.
    """
    grid, notes = cube.grid, list(cube.notes)
    in_blocks = isinstance(cube.surface, np.memmap) and 8 * cube.surface.size > IN_MEMORY
    reach = None
    if in_blocks:
        notes.append("the cube was transformed in blocks: it is larger than what is held in memory")
        if angle is not None:
            raise LeakrefError("rotate", "the cube is too large to be turned in memory", "leave out --rotate or cut it")
        bins = KEPT / (16 * grid.shape[2])  # in the plane
        reach = float(np.sqrt(bins * grid.bin_widths[0] * grid.bin_widths[1]) / 2)
        if asked is not None:
            reach = float(asked.max()) + (HALF_WIDTH + 1) * grid.wavenumber_resolution
    surface, exponent = (cube.surface, 0) if in_blocks else levelled(cube.surface)
    level = replace(cube, surface=surface)
    removed = blocks.trend(surface, detrend)
    trend = np.ldexp(removed, exponent)  # as it is in the file
    if detrend == "mean":
        notes.append(f"the mean, {trend[0]:.6g}, was removed")
    elif detrend == "linear":
        slopes = ", ".join(f"{b:.3g}" for b in trend[1:])
        notes.append(
            f"the mean, {trend[0]:.6g}, and a plane with the slopes {slopes} per sample along x, y, t were removed"
        )
    else:
        notes.append("neither mean nor trend was removed (--detrend mean or linear does)")

    def spectrum(name: str) -> Spectrum:
        return spectrum_of(level, name, removed if detrend != "none" else None, reach, in_blocks=in_blocks)

    main = spectrum(window)
    taper = "hann" if window == "box" else window
    smooth = spectrum(taper) if window == "box" and (screening or asked is None) else main
    if asked is None:
        limit = np.inf if reach is None else reach - (HALF_WIDTH + 1) * grid.wavenumber_resolution
        k = default_wavenumbers(grid, limit)
        k = k[screen.shells_with_signal(smooth, k, 0.5)]  # at the wavenumber itself, not at the edge of its shell only
        if not k.size:
            raise LeakrefError(
                "extract",
                "no shell holds more than noise",
                "remove the mean with --detrend mean, check gravity and spacing, or pass --wavenumbers",
            )
        notes.append(f"wavenumbers: every dk from {k[0]:.4g} to {k[-1]:.4g}, where there is signal")
    else:
        k = asked
    found = analyse(main, k, gravity=cube.gravity, method=method)
    if not screening:
        return found, None, notes, trend
    pair = main if window == "box" else spectrum("box"), smooth
    rotated = None
    if angle is not None:
        flat = np.asarray(surface) if detrend == "none" else surface - blocks.plane(removed, grid.shape)
        turned, smaller = screen.rotate(flat, grid, angle)
        rotated = screen.turn(
            [fourier(turned, smaller, name) for name in ("box", taper)], k, angle, gravity=cube.gravity, method=method
        )
        notes.append(
            f"turned by {angle:g} degrees by interpolation on the inscribed square of {smaller.shape[0]} x "
            f"{smaller.shape[1]} samples: not lossless, and of coarser resolution"
        )
    return found, screen.screen(*pair, k, gravity=cube.gravity, method=method, rotated=rotated), notes, trend


def _rows(velocities: FloatArray) -> list[list[float] | None]:
    """Rows for JSON: null where there is no number (guide protocol, section 14)."""
    return [None if np.isnan(c).any() else c.tolist() for c in velocities]


def _screen_record(s: screen.Screening | None, window: str) -> dict[str, Any] | None:
    """The screening as it stands in the JSON, None if there was none."""
    if s is None:
        return None
    turned = (
        None
        if s.turned is None
        else {
            "angle": s.turned.angle,
            "untapered": _rows(s.turned.untapered),
            "tapered": _rows(s.turned.tapered),
            "resolution": s.turned.resolution,
            "side": s.turned.side,
            "lossless": False,
        }
    )
    return {
        "taper": "hann" if window == "box" else window,
        "untapered": _rows(s.untapered.velocities),
        "tapered": _rows(s.tapered.velocities),
        "disagreement": s.disagreement,
        "resolution": s.resolution,
        "leaked_share": s.leaked,
        "rotated": turned,
    }


def _summary(s: screen.Screening) -> str:
    """The verdicts counted, in a line, and what to do if there is leakage."""
    counts = {v: s.verdicts.count(v) for v in (screen.FINE, screen.LEAKAGE, screen.NO_SIGNAL)}
    said = ", ".join(f"{verdict} at {count}" for verdict, count in counts.items())
    if not counts[screen.LEAKAGE]:
        return f"Screen, of {len(s.verdicts)} wavenumbers: {said}."
    return (
        f"Screen, of {len(s.verdicts)} wavenumbers: {said}. Where there is leakage, the untapered velocity changes "
        "by more than both resolutions: use the tapered one."
    )


def _table(
    file: Path,
    found: Extraction,
    flags: list[list[str]],
    resolutions: Sequence[FloatArray],
    screened: screen.Screening | None,
    cube: Cube,
    window: str,
) -> Table:
    """A row a wavenumber: velocity, both resolutions, and if it was screened by how much the taper moves it and the
    verdict.
    """
    result = Table(
        title=f"{file.name}: Doppler shift velocities, window {window}, {found.method}, in {UNITS[cube.units]}"
    )
    for name in (f"k ({_PER_LENGTH[cube.units]})", "cx", "cy", "domega / k", "cg dk / k"):
        result.add_column(name, justify="right")
    if screened is not None:
        result.add_column("change by taper", justify="right")
        result.add_column("verdict")
    result.add_column("flags", overflow="fold")
    for n, (k, c) in enumerate(zip(found.wavenumbers, found.velocities, strict=True)):
        row = [f"{k:.4g}", *("-" if np.isnan(v) else f"{v:.4f}" for v in c), *(f"{r[n]:.4f}" for r in resolutions)]
        if screened is not None:
            verdict = screened.verdicts[n]
            row += [
                f"{screened.disagreement[n]:.4f}",
                f"[red]{verdict}[/red]" if verdict == screen.LEAKAGE else verdict,
            ]
        result.add_row(*row, ", ".join(name for name in flags[n] if name != screen.LEAKAGE))
    return result


def _write(
    out: Path,
    record: dict[str, Any],
    found: Extraction,
    flags: list[list[str]],
    resolutions: Sequence[FloatArray],
    screened: screen.Screening | None,
    cube: Cube,
) -> None:
    """JSON, CSV, figures, and NetCDF where xarray is there. Columns of the CSV are those of the NetCDF file; a number
    that is not there is an empty cell.
    """
    from leakref.cubes.figures import extraction_figure, screening_figure
    from leakref.figures import save

    columns = {
        "wavenumber": found.wavenumbers,
        "cx": found.velocities[:, 0],
        "cy": found.velocities[:, 1],
        "resolution_frequency": resolutions[0],
        "resolution_wavenumber": resolutions[1],
    }
    words = {"flags": [";".join(names) for names in flags]}
    if screened is not None:
        columns |= {"disagreement": screened.disagreement, "leaked_share": screened.leaked}
        words["verdict"] = list(screened.verdicts)

    def table(path: Path) -> None:
        with path.open("w", newline="", encoding="utf-8") as stream:
            writer = csv.writer(stream)
            writer.writerow([*columns, *words])
            numbers = ([("" if v != v else v) for v in values.tolist()] for values in columns.values())
            writer.writerows(zip(*numbers, *words.values(), strict=True))

    write_whole(out / "extract.json", lambda path: path.write_text(dump(record) + "\n", encoding="utf-8"))
    write_whole(out / "extract.csv", table)
    units = (_PER_LENGTH[cube.units], UNITS[cube.units])
    name = Path(record["file"]).name
    title = f"{name}: {record['method']}, window {record['window']}"
    save(extraction_figure(found, flags, resolutions, units, title, cube.current), out / "extract")
    if screened is not None:
        save(screening_figure(screened, resolutions, units, f"{name}: is leakage at work?"), out / "screen")
    try:
        library = formats.netcdf_library()
    except LeakrefError as error:
        console().print(escape(f"no extract.nc was written: {error}"), soft_wrap=True)
        return
    metric = cube.units == "si"
    unit = {"wavenumber": "m-1" if metric else "1", "leaked_share": "1"}
    dataset = library.Dataset(
        {
            name: ("wavenumber", values, {"units": unit.get(name, "m s-1" if metric else "1")})
            for name, values in columns.items()
        }
        | {name: ("wavenumber", np.array(values, dtype=str)) for name, values in words.items()},
        attrs={
            "Conventions": "CF-1.10",
            "units": cube.units,
            "gravity": cube.gravity,
            "window": record["window"],
            "method": record["method"],
            "trend_removed": record["removed"]["trend"],
        },
    )
    write_whole(out / "extract.nc", lambda path: path.write_bytes(files.netcdf(dataset)))

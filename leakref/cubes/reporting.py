"""How an extraction is told: the table and the lines on the terminal, the record in JSON, the files in a folder.

Nothing is measured here. Numbers are in the units of the file, and one that is not there is null, a dash or an empty
cell.
"""

from __future__ import annotations

import csv
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np
from rich.markup import escape

from leakref._base import FloatArray, LeakrefError
from leakref._output import console, dump, write_whole
from leakref._tables import Table
from leakref.cubes import files, screen
from leakref.cubes.causes import Verdict
from leakref.cubes.cube import UNITS, Cube
from leakref.cubes.hdf import netcdf_library
from leakref.shell import Extraction

__all__ = ["LOOKS", "PER_LENGTH", "rows", "screen_record", "shell_record", "summary", "table", "write"]

PER_LENGTH = {"si": "rad/m", "scaled": "k0", "given": "rad per length"}
"""The unit of a wavenumber, by the units of a cube."""


def rows(velocities: FloatArray) -> list[list[float] | None]:
    """Rows for JSON: null where there is no number (guide protocol, section 14)."""
    return [None if np.isnan(c).any() else c.tolist() for c in velocities]


def screen_record(s: screen.Screening | None, window: str) -> dict[str, Any] | None:
    """The screening as it stands in the JSON, None if there was none.

    `window` is that of the velocities reported; the taper that was compared with is the same unless there was none.
    """
    if s is None:
        return None
    turned = (
        None
        if s.turned is None
        else {
            "angle": s.turned.angle,
            "untapered": rows(s.turned.untapered),
            "tapered": rows(s.turned.tapered),
            "resolution": s.turned.resolution,
            "side": s.turned.side,
            "lossless": False,
        }
    )
    return {
        "taper": "hann" if window == "box" else window,
        "untapered": rows(s.untapered.velocities),
        "tapered": rows(s.tapered.velocities),
        "disagreement": s.disagreement,
        "resolution": s.resolution,
        "leaked_share": s.leaked,
        "rotated": turned,
    }


def shell_record(shell: Verdict | None) -> dict[str, Any] | None:
    """Whether there is a dispersion shell as it stands in the JSON; a depth without end is null there."""
    if shell is None:
        return None
    return {"holds": shell.holds, "share": shell.share, "words": shell.words, "depths": shell.depths}


LOOKS = {
    screen.NO_CHANGE: ("green", "the taper moves the velocity by less than a tenth"),
    screen.UNRESOLVED: (
        "yellow",
        "the taper moves it by more, but by less than the resolution: it may be off by as much, or not",
    ),
    screen.LEAKAGE: ("red", "the untapered velocity changes by more than both resolutions: use the tapered one"),
    screen.NO_SIGNAL: ("dim", "nothing there but noise or what has leaked: use no velocity"),
}
"""The colour of each verdict on the terminal, and what it says. That a velocity is right is said of none."""


def summary(s: screen.Screening) -> list[str]:
    """The verdicts counted, a line each, and what they mean."""
    lines = [f"Screen, of {len(s.verdicts)} wavenumbers (the screen sees leakage, no other error):"]
    for verdict, (colour, words) in LOOKS.items():
        if count := s.verdicts.count(verdict):
            lines.append(f"  [{colour}]{verdict}[/{colour}] at {count}: {words}")
    return lines


def table(
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
        title=f"{file.name}: Doppler shift velocities, window {window}, {found.method}, {cube.water_words}, in "
        f"{UNITS[cube.units]}"
    )
    for name in (f"k ({PER_LENGTH[cube.units]})", "cx", "cy", "domega / k", "cg dk / k"):
        result.add_column(name, justify="right")
    if screened is not None:
        result.add_column("change by taper", justify="right")
        result.add_column("verdict", no_wrap=True)
    result.add_column("flags", overflow="fold")
    digits = int(np.clip(2 - np.floor(np.log10(min(r.min() for r in resolutions))), 4, 12))  # two of the finest
    for n, (k, c) in enumerate(zip(found.wavenumbers, found.velocities, strict=True)):
        row = [f"{k:.4g}", *("-" if np.isnan(v) else f"{v:.{digits}f}" for v in (*c, *(r[n] for r in resolutions)))]
        if screened is not None:
            verdict = screened.verdicts[n]
            row += [
                "-" if np.isnan(screened.disagreement[n]) else f"{screened.disagreement[n]:.{digits}f}",
                f"[{LOOKS[verdict][0]}]{verdict}[/{LOOKS[verdict][0]}]",
            ]
        result.add_row(*row, ", ".join(name for name in flags[n] if name != screen.LEAKAGE))
    return result


def write(
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

    def comma_separated(path: Path) -> None:
        with path.open("w", newline="", encoding="utf-8") as stream:
            writer = csv.writer(stream)
            writer.writerow([*columns, *words])
            numbers = ([("" if v != v else v) for v in values.tolist()] for values in columns.values())
            writer.writerows(zip(*numbers, *words.values(), strict=True))

    write_whole(out / "extract.json", lambda path: path.write_text(dump(record) + "\n", encoding="utf-8"))
    write_whole(out / "extract.csv", comma_separated)
    units = (PER_LENGTH[cube.units], UNITS[cube.units])
    name = Path(record["file"]).name
    title = f"{name}: {record['method']}, window {record['window']}, {cube.water_words}"
    if record["shell_band"] is not None and not record["shell_band"]["holds"]:
        title += " (no dispersion shell where it should be: these are no currents)"
    save(extraction_figure(found, flags, resolutions, units, title, cube.current), out / "extract")
    if screened is not None:
        save(
            screening_figure(
                screened,
                resolutions,
                units,
                f"{name}, {cube.water_words}: is leakage at work?",
            ),
            out / "screen",
        )
    try:
        library = netcdf_library()
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
            "depth": cube.depth,
            "surface_tension": cube.surface_tension,
            "window": record["window"],
            "method": record["method"],
            "trend_removed": record["removed"]["trend"],
        },
    )
    write_whole(out / "extract.nc", lambda path: path.write_bytes(files.netcdf(dataset)))

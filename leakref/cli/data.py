"""Commands for your own data and campaigns."""

from __future__ import annotations

import os
from pathlib import Path
from typing import Annotated

import typer

from leakref.cli.base import DATA, PAPERS, Json, Methods, Workers, command, methods_named

__all__ = ["export", "extract", "plan"]


@command(DATA)
def extract(
    file: Annotated[
        Path,
        typer.Argument(
            help="A cube: npz, mat, NetCDF, zarr or npy; or a folder of PNG or TIFF images, a TIFF stack, mp4 or avi."
        ),
    ],
    window: Annotated[str, typer.Option(help="box (none), hann, blackman or kaiser-bessel.")] = "hann",
    method: Annotated[str, typer.Option(help="nsp, ls, or another of `leakref guide methods`.")] = "nsp",
    wavenumbers: Annotated[
        str | None,
        typer.Option(
            help="0.4,0.5 or first:last:step, in the file's units; default: "
            "every dk from 4 dk up where there is signal."
        ),
    ] = None,
    screen: Annotated[bool, typer.Option("--screen", help="Is leakage at work? Untapered against tapered.")] = False,
    rotate: Annotated[float | None, typer.Option(help="With --screen: also turn the images, degrees.")] = None,
    variable: Annotated[
        str | None, typer.Option(help="What the samples are called in the file, such as IMG_SEQ.IMG.")
    ] = None,
    spacing: Annotated[
        str | None, typer.Option(help="dx,dy,dt, instead of coordinates in the file; 0.3,0.3,1/29.97.")
    ] = None,
    axes: Annotated[
        str | None, typer.Option(help="Order in which the samples are stored, such as txy, where it is not known.")
    ] = None,
    y: Annotated[
        str | None, typer.Option("--y", help="up or down: where rows with a larger index lie; down in images.")
    ] = None,
    crop: Annotated[
        str | None, typer.Option(help="Region of interest, x0:x1,y0:y1 in samples as they are stored.")
    ] = None,
    frames: Annotated[str | None, typer.Option(help="Which frames: first:end, counted from 0; 0:600:2.")] = None,
    fill_holes: Annotated[
        float,
        typer.Option(help="Share of samples that may be missing (NaN, filled with the mean) or lost (interpolated)."),
    ] = 0.0,
    drop_doubled: Annotated[
        bool, typer.Option("--drop-doubled", help="Leave out frames that are the same as the one before.")
    ] = False,
    gravity: Annotated[float | None, typer.Option(help="In the file's units, if it does not say.")] = None,
    depth: Annotated[
        str | None, typer.Option(help="Of the water: 4m, a plain number in the file's unit of length, or deep.")
    ] = None,
    surface_tension: Annotated[
        str | None, typer.Option(help="Over the density: 7.3e-5m3/s2, a plain number in the file's units, or water.")
    ] = None,
    detrend: Annotated[str, typer.Option(help="Remove first: none, mean, or linear (a plane in x, y, t).")] = "none",
    out: Annotated[Path | None, typer.Option(help="Folder for JSON, CSV, NetCDF and figures.")] = None,
    json: Json = False,
) -> bool:
    """The chain on your own cube: a Doppler shift velocity for each wavenumber, in the file's units."""
    from leakref.cubes.commands import extract as run

    return run(
        file,
        window=window,
        method=method,
        wavenumbers=wavenumbers,
        screening=screen,
        rotate=rotate,
        detrend=detrend,
        out=out,
        json=json,
        spacing=spacing,
        crop=crop,
        frames=frames,
        variable=variable,
        axes=axes,
        y=y,
        gravity=gravity,
        depth=depth,
        surface_tension=surface_tension,
        holes=fill_holes,
        drop_doubled=drop_doubled,
    )


@command(DATA)
def export(
    case: Annotated[str, typer.Argument(help="One configuration, as in `leakref reproduce --list`.")],
    out: Annotated[Path, typer.Option(help="File to write.")],
    realization: Annotated[int, typer.Option(min=0, help="Which realisation.")] = 0,
    format: Annotated[
        str | None, typer.Option(help="npz, mat (v5) or netcdf; default: as the file's name says, else npz.")
    ] = None,
    peak_wavenumber: Annotated[float | None, typer.Option(help="k0 in rad/m, with --gravity: SI units.")] = None,
    gravity: Annotated[float | None, typer.Option(help="In m/s2, with --peak-wavenumber.")] = None,
    json: Json = False,
) -> bool:
    """A cube of a case with its truth, its waves, current and water, for any code to try."""
    from leakref.cubes.exporting import export as run

    return run(
        case,
        realization=realization,
        format=format,
        out=out,
        peak_wavenumber=peak_wavenumber,
        gravity=gravity,
        json=json,
    )


@command(DATA)
def plan(
    field_of_view: Annotated[str, typer.Option(help="Side of the area, 128m, or both: '128m x 96m'.")],
    duration: Annotated[str, typer.Option(help="Of the video, 30s.")],
    peak_wavelength: Annotated[str, typer.Option(help="Of the waves, 15m.")],
    direction: Annotated[
        str, typer.Option(help="Where the waves go, anticlockwise from x; along an axis is kindest.")
    ] = "90deg",
    spread: Annotated[str, typer.Option(help="Full width of the cosine-square spreading.")] = "60deg",
    gamma: Annotated[str, typer.Option(help="JONSWAP peakedness.")] = "3.3",
    current: Annotated[str, typer.Option(help="The true current, 0.3m/s.")] = "0m/s",
    current_direction: Annotated[str | None, typer.Option(help="Where it goes; default: with the waves.")] = None,
    pixel: Annotated[str | None, typer.Option(help="Default: 1/28 of the peak's wavelength.")] = None,
    frame_rate: Annotated[str | None, typer.Option(help="2Hz; default: 14 images in a period of the peak.")] = None,
    depth: Annotated[str, typer.Option(help="Of the water, 4m, or deep.")] = "deep",
    surface_tension: Annotated[
        str | None, typer.Option(help="Over the density: water, or 7.3e-5m3/s2; matters below 0.3 m. Default: none.")
    ] = None,
    sweep: Annotated[
        str | None, typer.Option(help="Also over any one of these: spread=15deg:90deg:6, first, last and how many.")
    ] = None,
    realizations: Annotated[int | None, typer.Option(min=2, help="Simulated flights; default: 8 to 30.")] = None,
    out: Annotated[Path, typer.Option(help="Folder for the tables, the data and the pictures.")] = Path("leakref-plan"),
    methods: Methods = PAPERS,
    workers: Workers = 0,
    json: Json = False,
) -> bool:
    """What a campaign will measure: expected errors at each wavelength, in m/s, and what would improve them."""
    from leakref.planning.command import run

    given = {
        "field-of-view": field_of_view,
        "duration": duration,
        "peak-wavelength": peak_wavelength,
        "direction": direction,
        "spread": spread,
        "gamma": gamma,
        "current": current,
        "current-direction": current_direction,
        "pixel": pixel,
        "frame-rate": frame_rate,
        "depth": depth,
        "surface-tension": surface_tension,
    }
    return run(
        given,
        sweep=sweep,
        realizations=realizations,
        out=out,
        workers=workers,
        cores=os.cpu_count() or 1,
        json=json,
        methods=methods_named(methods, "plan"),
    )

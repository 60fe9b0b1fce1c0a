"""`leakref export`: a sea of the paper, or of case depth, as a cube, for another implementation.

The cube holds what the reference would see, and the file also its truth: the waves, the current, the water and the
units. It is the way to try a code by hand; judging one is `leakref certify`, which shows it cubes of its own.
"""

from __future__ import annotations

import hashlib
from pathlib import Path

from leakref._base import LeakrefError, positive
from leakref._output import dump, envelope, folder
from leakref.cases import configurations
from leakref.cubes import files
from leakref.cubes.hdf import netcdf_library
from leakref.dispersion import Scales

__all__ = ["export"]

_SUFFIXES = {".mat": "mat", ".nc": "netcdf", ".npz": "npz"}


def export(
    case: str,
    *,
    realization: int,
    format: str | None,
    out: Path,
    peak_wavenumber: float | None,
    gravity: float | None,
    json: bool,
) -> bool:
    """Write one realisation of a case with its truth to `out`; returns True. Raises LeakrefError.

    `case` is the id of one configuration; `realization` counts from 0. `format` is that of the suffix of `out` unless
    given. With `peak_wavenumber` (rad/m) and `gravity` (m/s2) the cube is in SI, without both in scaled units.
    LeakrefError is raised for an unknown case or one of several configurations, an unknown format, one of the two
    alone, a folder in the place of `out`, and NetCDF without its library. The path, the SHA-256 and the sizes are
    printed; where the water is not deep, the file has its depth and surface tension beside the gravity.
    """
    format = format or _SUFFIXES.get(out.suffix.lower(), "npz")
    if format not in files.FORMATS:
        raise LeakrefError("export", f"no format is called {format!r}", f"choose one of {', '.join(files.FORMATS)}")
    chosen = configurations([case])
    if len(chosen) > 1:
        raise LeakrefError(
            "export", f"{case} has {len(chosen)} configurations", f"name one of {' '.join(c.id for c in chosen)}"
        )
    if (peak_wavenumber is None) != (gravity is None):
        raise LeakrefError(
            "export",
            "only one of --peak-wavenumber and --gravity was given",
            "give both for SI units, or neither for scaled ones",
        )
    scales = None
    if peak_wavenumber is not None and gravity is not None:
        positive("export", peak_wavenumber=peak_wavenumber, gravity=gravity)
        scales = Scales(peak_wavenumber, gravity)
    if format == "netcdf":
        netcdf_library()
    folder(out.parent)
    if out.is_dir():
        raise LeakrefError("export", f"{out} is a folder", "name the file to write")
    configuration = chosen[0]
    cube = files.of_configuration(configuration, realization, scales)
    files.write(out, cube, format, {"case": configuration.id, "realization": str(realization)})
    with out.open("rb") as stream:
        digest = hashlib.file_digest(stream, "sha256").hexdigest()
    if json:
        print(
            dump(
                envelope(
                    "export",
                    True,
                    path=out,
                    sha256=digest,
                    case=configuration.id,
                    realization=realization,
                    format=format,
                    units=cube.units,
                    gravity=cube.gravity,
                    depth=cube.depth,
                    surface_tension=cube.surface_tension,
                    shape=cube.grid.shape,
                    spacing=cube.grid.spacing,
                    current=cube.current,
                )
            )
        )
    else:
        print(f"{out}  {' x '.join(map(str, cube.grid.shape))} samples, units: {cube.units}, sha256 {digest}")
    return True

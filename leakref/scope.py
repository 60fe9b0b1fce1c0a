"""In which waves, water and current something holds: the same words on certificates, plans and extractions.

A code is judged in certain waves, a campaign is planned for some, and velocities are measured in those that a cube
holds. What is said of them here is said alike, so that one can be held against the other; `peaks` goes from the waves
in which one measures to the seas in which `leakref certify --waves` asks.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

__all__ = ["ASKED", "Scope", "current_words", "judge_line", "peaks", "seas_words", "water_words", "waves_words"]

ASKED = (1.25, 2.15)
"""Of the peak's wavenumber: the longest and the shortest waves in which certify asks for velocities in a sea."""
_NARROWEST = 1.1  # the ratio of either end to the middle: seas of one length alone are none


def waves_words(shortest: float, longest: float, unit: str = "m") -> str:
    """Such as "waves of 0.5 to 4 m"."""
    short, long = f"{shortest:.3g}", f"{longest:.3g}"
    return f"waves of {short} to {long} {unit}" if short != long else f"waves of {long} {unit}"


def water_words(
    depths: Sequence[float], surface_tension: float, *, deep: bool = False, unit: str = "m", felt: str = ""
) -> str:
    """The water: `depths` are the least and the greatest of those that are finite, none for deep water alone; with
    `deep` water was also that. The surface tension is over density; `felt` says in which waves it is.
    """
    said, unit = "Deep water", f" {unit}"
    if depths:
        low, high = (f"{value:.3g}" for value in (depths[0], depths[-1]))
        finite = f"depths of {low} to {high}{unit}" if low != high else f"a depth of {low}{unit}"
        said = f"Deep water and {finite}" if deep else f"Water of {finite}"
    return f"{said}, {f'surface tension {felt}' if surface_tension else 'no surface tension'}"


def current_words(fastest: float, unit: str, profile: str = "") -> str:
    """The current: how fast at most, and whether it is uniform."""
    return f"one current in the picture, {profile}of {fastest:.2g} {unit} at most"


def seas_words(water: str, peak: float | None, fastest: float, unit: str) -> str:
    """Random seas that were made from parameters: in which water, with which peak (in m), on how fast a current."""
    waves = "with their peak in scaled units" if peak is None else f"with a peak at {peak:.3g} m"
    return f"random seas ({water[0].lower()}{water[1:]}, {waves}, on a uniform current of {fastest:.2g} {unit} at most)"


def peaks(shortest: float, longest: float, peak: float | None = None) -> tuple[float, float]:
    """The shortest and the longest peak wavelength of seas of which certify asks within `shortest` to `longest` only.

    With a `peak`, that of the sea there is, it is in the middle of them (on a scale of factors).
    """
    low, high = ASKED[1] * shortest, ASKED[0] * longest
    middle = peak or math.sqrt(low * high)
    ratio = min(middle / low, high / middle) if peak else math.sqrt(max(high / low, 1.0))
    ratio = max(ratio, _NARROWEST)
    return middle / ratio, middle * ratio


def judge_line(shortest: float, longest: float) -> str:
    """The command that judges a code in seas with such peak wavelengths, in m."""
    return f"leakref certify TARGET --waves {shortest:.3g}m:{longest:.3g}m"


@dataclass(frozen=True)
class Scope:
    """Where velocities were, or will be, measured: `wavelengths` [shortest, longest], none if nowhere.

    - `depth`: infinite in deep water; `surface_tension`: over density; `fastest`: of the current.
    - `peak`: wavelength of the sea's peak, None where it is not known.
    - `units`: of a length and a velocity; `metric`: whether these are m and m/s.
    - `profile`: whether the current is uniform, where that is known.
    """

    wavelengths: tuple[float, float] | None
    depth: float
    surface_tension: float
    fastest: float | None
    peak: float | None = None
    units: tuple[str, str] = ("m", "m/s")
    metric: bool = True
    profile: str = ""

    @property
    def words(self) -> str:
        """In the words of a certificate."""
        length, speed = self.units
        depths = [] if self.depth == math.inf else [self.depth]
        felt = f"{self.surface_tension:.3g}" + " m3/s2" * self.metric
        parts = [water_words(depths, self.surface_tension, unit=length, felt=felt)]
        parts.append(f"linear {waves_words(*self.wavelengths, length)}" if self.wavelengths else "no waves at all")
        if self.peak is not None and self.wavelengths:
            parts[-1] += f" in a sea whose peak is {self.peak:.3g} {length} long"
        if self.fastest is not None:
            parts.append(current_words(self.fastest, speed, self.profile))
        return ", ".join(parts)

    @property
    def certify(self) -> str | None:
        """The line that judges a code for such waves; None where these are not known in metres."""
        if not self.metric or self.wavelengths is None:
            return None
        return judge_line(*peaks(*self.wavelengths, self.peak))

    @property
    def advice(self) -> str:
        """That line, with what the code is to declare besides; empty if there is none."""
        if self.certify is None:
            return ""
        besides = []
        if self.depth != math.inf or self.surface_tension:
            besides.append("told of this water (`water` in its declaration)")
        if self.fastest:
            besides.append(f"`fastest`, if declared, no less than {self.fastest:.2g} m/s")
        return f"A code for these waves is judged by `{self.certify}`" + (f"; {', '.join(besides)}" if besides else "")

    def record(self) -> dict[str, Any]:
        """For the JSON; the names are those of a certificate's scope."""
        return {
            "depth": "deep" if self.depth == math.inf else self.depth,
            "surface_tension": self.surface_tension,
            "units": self.units,
            "peak_wavelength": self.peak,
            "wavelengths": [] if self.wavelengths is None else list(self.wavelengths),
            "fastest_current": self.fastest,
            "words": self.words,
            "certify": self.certify,
        }

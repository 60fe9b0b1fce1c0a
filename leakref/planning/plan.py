"""What a campaign will measure: the asked-for sea, area and duration simulated, in metres and seconds.

A campaign is turned into a configuration in the paper's scaled units (`Campaign.flight`), realised as often as asked,
and the statistics of its errors are turned back (`Expected`). The waves are those of the paper's JONSWAP seas with a
uniform current, in deep water or any other, seen without noise and extracted in the water that they are in. Used by
`leakref plan`; `runs` does the computing.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from concurrent.futures import Executor
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any

import numpy as np
import numpy.typing as npt

from leakref import runs
from leakref._base import FloatArray, LeakrefError, finite, integer, number, positive
from leakref.dispersion import Scales, Water
from leakref.ensemble import Ensemble
from leakref.grid import SPACING, TIME_STEP
from leakref.methods import DEFAULT
from leakref.planning.flight import Flight, default_realizations, work
from leakref.planning.quantities import depth_fault, tension_fault
from leakref.shell import HALF_WIDTH

__all__ = [
    "FEWEST",
    "GRAVITY",
    "MOST",
    "Campaign",
    "Expected",
    "Plan",
    "expected",
    "plan",
    "swept",
]

GRAVITY = 9.81
"""In m/s2."""
FEWEST = 3.0
"""Peak wavelengths across an area, and peak periods in a video, below which nothing is left to extract from."""
MOST = 60e6
"""Bins of one spectrum beyond which a realisation takes gigabytes (`work`)."""


@dataclass(frozen=True)
class Campaign:
    """What is asked for, in metres, seconds, Hz and degrees; directions are going-to, anticlockwise from +x.

    `field_of_view` is the area's extent along x and y; `spread` the full width of eq:angularspread, `peakedness` gamma;
    without `pixel` and `frame_rate` they are the paper's, 1/28 of a wavelength and 14 images a period at the peak.
    Raises LeakrefError for what cannot be, or leaves nothing to extract from.

    - `duration`: of the video, s; `peak_wavelength`: m; `speed`: of the current, m/s, below the waves' own.
    - `pixel`: m; `frame_rate`: images a second, by default 14 in what would be a period in deep water.
    - `depth`: m, infinite in deep water; `surface_tension`: over the density, m3/s2, 7.3e-5 for clean water.

    Refused are numbers that are not finite or not positive, a gamma below 1, a spread above 360 degrees, a current as
    fast as the waves, an area or a video of fewer than `FEWEST` wavelengths or periods, one of more than `MOST` bins,
    and a pixel or a frame rate that does not resolve the waves at the peak.
    """

    field_of_view: tuple[float, float]
    duration: float
    peak_wavelength: float
    direction: float = 90.0
    spread: float = 60.0
    peakedness: float = 3.3
    speed: float = 0.0
    current_direction: float = 90.0
    pixel: float | None = None
    frame_rate: float | None = None
    depth: float = np.inf
    surface_tension: float = 0.0

    def __post_init__(self) -> None:
        for name in ("direction", "current_direction", "speed"):
            finite("plan", name.replace("_", " "), getattr(self, name), 0)
        given = {name: getattr(self, name) for name in ("pixel", "frame_rate") if getattr(self, name) is not None}
        positive(
            "plan",
            **{
                "field of view": self.field_of_view,
                "duration": self.duration,
                "peak wavelength": self.peak_wavelength,
                "spread": self.spread,
                "gamma": self.peakedness,
                **given,
            },
        )
        if self.peakedness < 1:
            raise LeakrefError(
                "plan",
                f"a gamma of {self.peakedness:g}, where the JONSWAP spectrum has 1 and more",
                "give 1 for a fully developed sea, 3.3 for a usual one, up to 7 for a young one",
            )
        if self.spread > 360:
            raise LeakrefError("plan", f"a spread of {self.spread:g} degrees", "give a full width of at most 360deg")
        _in_water(self.depth, self.surface_tension)
        if not 0 <= self.speed < self.phase_velocity:
            raise LeakrefError(
                "plan",
                f"a current of {self.speed:g} m/s, where waves of {self.peak_wavelength:g} m "
                f"travel at {self.phase_velocity:.3g} m/s",
                "give a speed from 0 to below that, and its sense by the current's direction",
            )
        self._measurable()

    def _measurable(self) -> None:
        period = self.peak_wavelength / self.phase_velocity
        across, long = min(self.field_of_view) / self.peak_wavelength, self.duration / period
        if across < FEWEST:
            raise LeakrefError(
                "plan",
                f"the field of view is {across:.3g} peak wavelengths across",
                f"take at least {FEWEST:g} ({FEWEST * self.peak_wavelength:.4g} m); the paper has 5 and more",
            )
        if long < FEWEST * (1 - 1e-9):
            raise LeakrefError(
                "plan",
                f"the video is {long:.3g} peak periods of {period:.3g} s long",
                f"take at least {FEWEST:g} ({FEWEST * period:.3g} s); the paper has 5 and more",
            )
        flight = self.flight
        if work(flight) > MOST:
            raise LeakrefError(
                "plan",
                f"an area of {across:.3g} wavelengths for {long:.3g} periods has "
                f"{work(flight):.1e} bins, beyond {MOST:.0e}",
                "plan for less of it: biases of a larger area or a longer video are smaller than what you will see",
            )
        if min(flight.grid.shape) < 2 or not flight.wavenumbers.size or flight.wavenumbers.max() < 1:
            dk = flight.grid.wavenumber_resolution
            most = self.peak_wavelength / (2 * (1 + (HALF_WIDTH + 1) * dk))
            raise LeakrefError(
                "plan", f"pixels of {self.pixel} m do not resolve the waves at the peak", f"take {most:.2g} m or less"
            )
        if flight.grid.nyquist[2] <= flight.water.frequency(1.0) + self.speed / self.scales.velocity:
            raise LeakrefError(
                "plan",
                f"{self.frame_rate} images a second do not resolve the peak's period of {period:.3g} s",
                f"take {4 / period:.2g} Hz or more",
            )

    @property
    def scales(self) -> Scales:
        """From the paper's scaled units to metres and seconds, those of deep water in any other too (decision D26)."""
        return Scales(2 * np.pi / self.peak_wavelength, GRAVITY)

    @property
    def water(self) -> Water:
        """The law of dispersion in metres and seconds, with a gravity of 9.81 m/s2."""
        return Water(GRAVITY, self.depth, self.surface_tension)

    @property
    def phase_velocity(self) -> float:
        """Of waves at the peak in this water, m/s."""
        return float(self.water.phase_velocity(self.scales.wavenumber))

    @cached_property
    def flight(self) -> Flight:
        """The same in scaled units. Lengths in peak wavelengths, times in peak periods, speeds in `c0`."""
        sides = tuple(side / self.peak_wavelength for side in self.field_of_view)
        period, still = 2 * np.pi * self.scales.time, self.water.to_scaled(self.scales)
        pixel = SPACING if self.pixel is None else self.pixel / self.peak_wavelength
        frame = TIME_STEP if self.frame_rate is None else 1 / (self.frame_rate * period)
        return Flight(
            "plan",
            self.direction,
            self.spread,
            self.peakedness,
            max(sides),
            self.duration / period,
            self.speed / self.scales.velocity,
            self.current_direction,
            depth=still.depth,
            surface_tension=still.surface_tension,
            sides=(sides[0], sides[1]),
            pixel=pixel,
            frame=frame,
        )

    def enlarged(self, area: float = 1.0, duration: float = 1.0) -> Campaign:
        """With so many times the area, in the same proportions, and so many times the duration. Pixel and frame rate
        stay what they are.
        """
        x, y = (side * float(np.sqrt(area)) for side in self.field_of_view)
        return replace(self, field_of_view=(x, y), duration=self.duration * duration)

    def aliased_below(self) -> float | None:
        """The wavelength (m) below which the frame rate is too low for the waves, or None if there is no such one.
        Waves along the current are the fastest: omega0(k) + k U at the Nyquist frequency. Looked at are the shells'
        wavenumbers.
        """
        k = np.linspace(1, self.flight.wavenumbers.max(), 400)
        fastest = self.flight.water.frequency(k) + k * self.speed / self.scales.velocity
        beyond = k[fastest >= self.flight.grid.nyquist[2]]
        return float(self.peak_wavelength / beyond[0]) if beyond.size else None


def _in_water(depth: float, surface_tension: float) -> None:
    """Refuse what no water has."""
    number("plan", depth=depth, surface_tension=surface_tension)
    if fault := depth_fault(depth):
        raise LeakrefError("plan", f"a depth of {depth:g} m {fault}", "give one such as 4m, or deep")
    if fault := tension_fault(surface_tension):
        raise LeakrefError("plan", f"a surface tension of {surface_tension:g} m3/s2 {fault}", "give water, or 0")


def swept(campaign: Campaign, name: str, values: Sequence[float]) -> list[Campaign]:
    """`campaign` with each of `values` for the parameter `name`; a field of view keeps its proportions.

    `name` is that of a field of `Campaign`, `values` in its unit. Raises LeakrefError as `Campaign` does.
    """
    if name == "field_of_view":
        x, y = campaign.field_of_view
        return [replace(campaign, field_of_view=(value, value * y / x)) for value in values]
    fields: list[dict[str, Any]] = [{name: float(value)} for value in values]
    return [replace(campaign, **field) for field in fields]


@dataclass(frozen=True, eq=False)
class Expected:
    """What one window and method will measure, at n wavelengths, longest first; metres and seconds.

    An error is the vector c - U, measured less true, of one realisation; where there is no current its length is the
    paper's spurious velocity |c|.

    - `measured`: the Ensemble in scaled units; `scales`: to metres and seconds.
    """

    measured: Ensemble
    scales: Scales

    @cached_property
    def errors(self) -> Ensemble:
        """c - U, still in scaled units."""
        return replace(self.measured, velocities=self.measured.velocities - self.measured.configuration.current)

    @property
    def window(self) -> str:
        """Its name."""
        return self.measured.window

    @property
    def method(self) -> str:
        """Its name."""
        return self.measured.method

    @property
    def wavelengths(self) -> FloatArray:
        """2 pi / k, (n,) in m."""
        return 2 * np.pi / (self.measured.wavenumbers * self.scales.wavenumber)

    @property
    def bias(self) -> FloatArray:
        """Mean of |c - U|, (n,) in m/s; without a current that of the paper."""
        return self.errors.bias * self.scales.velocity

    @property
    def random(self) -> FloatArray:
        """Standard deviation of |c - U|, (n,) in m/s (decision D12)."""
        return self.errors.random * self.scales.velocity

    @property
    def standard_error(self) -> FloatArray:
        """Of the bias, (n,) in m/s."""
        return self.errors.standard_error * self.scales.velocity

    @property
    def mean_error(self) -> FloatArray:
        """Mean of c - U, (n, 2) in m/s: what is left of the errors after many flights."""
        return self.errors.mean * self.scales.velocity

    @property
    def resolutions(self) -> tuple[FloatArray, FloatArray]:
        """eq:dcdwk from frequency and from wavenumber, (n,) each in m/s."""
        frequency, wavenumber = self.measured.resolutions
        return frequency * self.scales.velocity, wavenumber * self.scales.velocity

    @property
    def trusted(self) -> npt.NDArray[np.bool_]:
        """Where bias and twice the random part are within the smaller resolution, and within the current if there is
        one, (n,): so is a single flight. A wavelength at which one realisation has no number is not trusted.

        Text, tables, pictures and JSON all ask here.
        """
        all_there = self.measured.count == len(self.measured.velocities)
        speed = self.measured.configuration.speed * self.scales.velocity
        return np.asarray(
            all_there & (self.single <= np.minimum(*self.resolutions)) & (self.single < (speed or np.inf))
        )

    @property
    def single(self) -> FloatArray:
        """Bias and twice the random part, (n,) in m/s: what a single flight errs by at most, but for one in twenty."""
        return np.asarray(self.bias + 2 * np.nan_to_num(self.random))

    def level(self) -> tuple[float, float]:
        """The bias over the wavelengths up to the peak's, which matter most, and its standard error; m/s. Each
        realisation is averaged over these wavelengths first, so that the error counts realisations. NaN of one.
        """
        short = self.measured.wavenumbers >= 1 - 1e-9
        each = np.nanmean(self.errors.magnitudes[:, short], axis=1) * self.scales.velocity
        return float(each.mean()), float(each.std(ddof=1) / np.sqrt(each.size)) if each.size > 1 else float("nan")

    def record(self) -> dict[str, Any]:
        """For the JSON of `leakref plan`. `speed` and what follows are of |c| itself, not of the error."""
        speed = self.scales.velocity
        return {
            "window": self.window,
            "method": self.method,
            "wavelengths": self.wavelengths,
            "bias": self.bias,
            "random": self.random,
            "standard_error": self.standard_error,
            "mean_error": self.mean_error,
            "resolution_frequency": self.resolutions[0],
            "resolution_wavenumber": self.resolutions[1],
            "speed": self.measured.bias * speed,
            "speed_random": self.measured.random * speed,
            "speed_standard_error": self.measured.standard_error * speed,
            "trusted": self.trusted,
            "count": self.measured.count,
        }


@dataclass(frozen=True, eq=False)
class Plan:
    """What to expect of a campaign by (window, method); tapered, by NSP, also with twice the area or the duration.

    `ways` has both windows, NSP, LS and what else is asked for; `larger` and `longer` are Hann and NSP only, of half as
    many realisations.
    """

    campaign: Campaign
    ways: Mapping[tuple[str, str], Expected]
    larger: Expected
    longer: Expected

    @property
    def best(self) -> Expected:
        """The paper's recommendation: a Hann window and NSP."""
        return self.ways["hann", "nsp"]


def expected(
    campaigns: Sequence[Campaign],
    realizations: int,
    *,
    windows: tuple[str, ...] = ("box", "hann"),
    methods: tuple[str, ...] = DEFAULT,
    executor: Executor | None = None,
    after_each: Callable[[], object] = lambda: None,
) -> list[dict[tuple[str, str], Expected]]:
    """What to expect of each campaign, by (window, method), from realisations 0 ... `realizations` - 1.

    Campaigns that differ in spread, gamma, direction, current or duration alone share their random phases (D11).
    """
    integer("plan", "realizations", realizations, 2)
    flights = [replace(campaign.flight, windows=windows) for campaign in campaigns]
    found = runs.run(flights, realizations=realizations, methods=methods, executor=executor, after_each=after_each)
    return [
        {(e.window, e.method): Expected(e, campaign.scales) for e in ensembles}
        for campaign, ensembles in zip(campaigns, found, strict=True)
    ]


def plan(
    campaign: Campaign,
    realizations: int | None = None,
    *,
    methods: Sequence[str] = DEFAULT,
    executor: Executor | None = None,
    after_each: Callable[[], object] = lambda: None,
) -> Plan:
    """Simulate `campaign`, and half as often what twice the area or twice the duration would give. Raises LeakrefError.

    `after_each` is called after every realisation: twice `realizations` times, if that is even. `realizations` None
    takes `default_realizations`; `methods` are those beside NSP and LS, on which the advice rests.
    """
    count = realizations or default_realizations(campaign.flight)
    methods = tuple(dict.fromkeys((*DEFAULT, *methods)))
    ways = expected([campaign], count, methods=methods, executor=executor, after_each=after_each)[0]
    others = expected(
        [campaign.enlarged(area=2), campaign.enlarged(duration=2)],
        max(2, count // 2),
        windows=("hann",),
        methods=("nsp",),
        executor=executor,
        after_each=after_each,
    )
    larger, longer = (other["hann", "nsp"] for other in others)
    return Plan(campaign, ways, larger, longer)

"""The high-precision oracle: the paper's formulas with 40 digits, sums term by term.

It shares only the paper with the chain.

Slow, and for small inputs only. Everything here takes and returns mpmath numbers in nested lists; floats that come in
count as exact. The constants are written out here a second time on purpose.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence
from functools import lru_cache, wraps
from typing import Any

from mpmath import mp, mpf

from leakref.golden.oraclewater import depth_factor, dispersion, doppler, group_velocity

__all__ = [
    "Bins", "Shell", "at_digits", "characteristic", "closed_lobe", "components", "depth_factor", "dispersion",
    "doppler", "group_velocity", "jonswap", "kernel", "lattice_phase", "least_squares", "lobe", "mean_square",
    "nearest_root", "newton", "score", "shell_bins", "spectrum", "spreading", "statistics", "surface", "transformed",
    "window",
]  # fmt: skip

DIGITS = 40
Bins = list[tuple[int, int]]
Number = Any  # mpf or mpc


def at_digits(function: Callable[..., Any]) -> Callable[..., Any]:
    """Run `function` with its digits. The module itself sets no precision: what is called without this runs at mpmath's
    own.
    """

    @wraps(function)
    def run(*args: Any, **kwargs: Any) -> Any:
        with mp.workdps(DIGITS):
            return function(*args, **kwargs)

    return run


# ---------------------------------------------------------------- sea


def jonswap(w: Number, peakedness: Number) -> Number:
    """eq:JONSWAP. `w` is in units of the peak's frequency; N = 1."""
    w = mpf(w)
    sigma = mpf(7) / 100 if w <= 1 else mpf(9) / 100
    r = mp.exp(-((w - 1) ** 2) / (2 * sigma**2))
    return mp.exp(-mpf(5) / 4 / w**4) / w**5 * mpf(peakedness) ** r


def spreading(theta: Number, mean: Number, spread: Number) -> Number:
    """eq:angularspread, degrees."""
    off = mpf(theta) - mpf(mean)
    while off > 180:
        off -= 360
    while off <= -180:
        off += 360
    return mp.cos(mp.pi * off / mpf(spread)) ** 2 if abs(off) <= mpf(spread) / 2 else mpf(0)


def _philox(counter: Sequence[int], key: Sequence[int]) -> int:
    """The first word of a block of Philox4x64-10 (Salmon et al., Random123), on Python's integers."""
    mask = 2**64 - 1
    c, k = list(counter), list(key)
    for _ in range(10):
        high0, low0 = divmod(0xD2E7470EE14C6C93 * c[0], 2**64)
        high1, low1 = divmod(0xCA5A826395121157 * c[2], 2**64)
        c = [high1 ^ c[1] ^ k[0], low1, high0 ^ c[3] ^ k[1], low0]
        k = [(k[0] + 0x9E3779B97F4A7C15) & mask, (k[1] + 0xBB67AE8584CAA73B) & mask]
    return c[0]


def lattice_phase(realization: int, i: int, j: int) -> Number:
    """Decision D11: 53 bits of one word over 2^53, times 2 pi; the product is rounded once, as in any float64 code."""
    word = _philox([j + 2**32, i + 2**32, 0, 0], [realization, 0])
    return mpf((word >> 11) * (2 * float(mp.pi) * 2.0**-53))


def components(sea: Mapping[str, Any], shift: Callable[[Number], tuple[Number, Number]]) -> list[list[Number]]:
    """sec:spectrum on the lattice of decision D10: kx, ky, omega, amplitude, phase; `shift` is eq:SJ at k.

    `sea` may hold a `depth` and a `surface_tension`, in scaled units: the spectrum is then that of TMA, in
    omega / omega0(k0), and its density over the plane is 2 (d omega0 / d k) / k times that over frequencies.
    """
    dk = mpf(341) / 1000 / mpf(sea["length"])
    water = (1, sea.get("depth"), sea.get("surface_tension", 0))
    peak = dispersion(1, *water)
    m = int(mpf("3.5") / dk)
    waves = []
    for i in range(-m, m + 1):
        for j in range(-m, m + 1):
            k = dk * mp.sqrt(i * i + j * j)
            if not 0 < k <= mpf("3.5"):
                continue
            f = spreading(mp.degrees(mp.atan2(j, i)), sea["direction"], sea["spread"])
            energy = jonswap(dispersion(k, *water) / peak, sea["peakedness"]) * f * dk**2
            if energy > 0 and any(water[1:]):
                energy *= depth_factor(k, water[1]) * 2 * group_velocity(k, *water) / k
            else:
                energy /= k ** mpf("1.5")
            if energy > 0:
                u, v = shift(k)
                waves.append(
                    [
                        dk * i,
                        dk * j,
                        dispersion(k, *water) + dk * (i * u + j * v),
                        mp.sqrt(energy),
                        lattice_phase(sea["realization"], i, j),
                    ]
                )
    turn, centre = mp.radians(mpf(sea.get("rotation", 0))), sea.get("centre", (0, 0))
    if turn:
        c, s = mp.cos(turn), mp.sin(turn)
        waves = [
            [
                c * p - s * q,
                s * p + c * q,
                w,
                a,
                phase + (p - c * p + s * q) * centre[0] + (q - s * p - c * q) * centre[1],
            ]
            for p, q, w, a, phase in waves
        ]
    return [list(column) for column in zip(*waves, strict=True)]


def surface(
    waves: Sequence[Sequence[float]], x: Sequence[float], y: Sequence[float], t: Sequence[float]
) -> list[list[list[Number]]]:
    """eta[x][y][t], wave by wave. In the units of the waves; axes as given."""
    listed = [[mpf(v) for v in wave] for wave in zip(*waves, strict=True)]
    return [
        [
            [
                mp.fsum(a * mp.cos(kx * mpf(p) + ky * mpf(q) - w * mpf(s) + phase) for kx, ky, w, a, phase in listed)
                for s in t
            ]
            for q in y
        ]
        for p in x
    ]


# ---------------------------------------------------------------- windows and spectra


def window(name: str, s: Number) -> Number:
    """A window at s = t / T (eq:hann, app:window_comparison, decision D14)."""
    if name == "box":
        return mpf(1)
    if name == "hann":
        return mp.sin(mp.pi * s) ** 2
    if name == "blackman":
        return (21 - 25 * mp.cos(2 * mp.pi * s) + 4 * mp.cos(4 * mp.pi * s)) / 50
    _kaiser_bessel(name)
    b = mp.pi * mp.sqrt(3)
    return mp.besseli(0, b * mp.sqrt(4 * s * (1 - s))) / mp.besseli(0, b)


def _kaiser_bessel(name: str) -> None:
    """The last of the windows, or none."""
    if name != "kaiser-bessel":
        raise ValueError(f"oracle: no window named {name!r}; write its formula here first")


@lru_cache(4096)
def _samples(name: str, size: int) -> list[Number]:
    return [window(name, mpf(n) / size) for n in range(size)]


def kernel(name: str, n: int, position: Number, size: int) -> Number:
    """sum of w exp(-2 pi i m (n - u) / size), term by term."""
    turn = -2 * (n - mpf(position)) / size
    return mp.fsum(w * mp.expjpi(turn * m) for m, w in enumerate(_samples(name, size)))


def lobe(name: str, v: Number) -> Number:
    """Integral of w(s) cos(2 pi v (s - 1/2)) over 0 < s < 1, by quadrature."""
    points = mp.linspace(0, 1, 9 + 2 * int(abs(v)))
    return mp.quad(lambda s: window(name, s) * mp.cos(2 * mp.pi * mpf(v) * (s - mpf(1) / 2)), points)


def closed_lobe(name: str, v: Number) -> Number:
    """The same integral in closed form: sums of sinc, or sinh(z) / z with z^2 = b^2 - (pi v)^2."""
    sums = {"box": [mpf(1)], "hann": [mpf(1) / 2] * 2, "blackman": [mpf(21) / 50, mpf(1) / 2, mpf(2) / 25]}
    v = mpf(v)
    if name in sums:
        a = sums[name]
        return a[0] * mp.sincpi(v) + mp.fsum(
            w / 2 * (mp.sincpi(v - j) + mp.sincpi(v + j)) for j, w in enumerate(a) if j
        )
    _kaiser_bessel(name)
    b = mp.pi * mp.sqrt(3)
    z = mp.sqrt(mp.mpc(b**2 - (mp.pi * v) ** 2))
    return ((mp.sinh(z) / z).real if z else mpf(1)) / mp.besseli(0, b)


def mean_square(name: str) -> Number:
    """Integral of w(s)^2 over 0 < s < 1."""
    return mp.quad(lambda s: window(name, s) ** 2, mp.linspace(0, 1, 9))


def nearest_root(function: Callable[[Number], Number], start: Number) -> Number:
    """The root of `function` by the secant method from `start`."""
    return mp.findroot(function, (mpf(start), mpf(start) * (1 + mpf(10) ** -8)))


def spectrum(
    waves: Sequence[Sequence[float]],
    shape: Sequence[int],
    spacing: Sequence[float],
    name: str,
    columns: Bins,
    frequencies: Sequence[int] | None = None,
) -> list[list[Number]]:
    """S at the bins (i, j) of `columns` and `frequencies` m, (n, nw), as a sum over waves and their mirror images.

    Frequencies are 0 ... nt // 2 unless given.
    """
    length = [n * mpf(d) for n, d in zip(shape, spacing, strict=True)]
    numbers = range(shape[2] // 2 + 1) if frequencies is None else frequencies
    total = [[mpf(0)] * len(numbers) for _ in columns]
    for kx, ky, omega, amplitude, phase in zip(*waves, strict=True):
        for sign in (1, -1):
            u, v, w = (sign * mpf(q) * side / (2 * mp.pi) for q, side in zip((kx, ky, omega), length, strict=True))
            along_x = {i: kernel(name, i, u, shape[0]) for i in {i for i, _ in columns}}
            along_y = {j: kernel(name, j, v, shape[1]) for j in {j for _, j in columns}}
            along_t = [mp.conj(kernel(name, m, w, shape[2])) for m in numbers]
            factor = mpf(amplitude) / 2 * mp.expj(sign * mpf(phase))
            for column, (i, j) in zip(total, columns, strict=True):
                start = factor * along_x[i] * along_y[j]
                for index, value in enumerate(along_t):
                    column[index] += start * value
    return total


def transformed(eta: Any, name: str) -> list[list[list[Number]]]:
    """S of a given surface eta[x][y][t] on all bins, as fftfreq orders them: three plain sums, one an axis."""
    shape = len(eta), len(eta[0]), len(eta[0][0])
    wx, wy, wt = (_samples(name, n) for n in shape)
    ex, ey, et = (
        [[mp.expjpi(sign * 2 * mpf(a * b % n) / n) for b in range(n)] for a in range(n)]
        for n, sign in zip(shape, (-1, -1, 1), strict=True)
    )
    nx, ny, nt = (range(n) for n in shape)
    in_t = [[[mp.fsum(wt[c] * mpf(eta[a][b][c]) * et[m][c] for c in nt) for m in nt] for b in ny] for a in nx]
    in_y = [[[mp.fsum(wy[b] * in_t[a][b][m] * ey[j][b] for b in ny) for m in nt] for j in ny] for a in nx]
    return [[[mp.fsum(wx[a] * in_y[a][j][m] * ex[i][a] for a in nx) for m in nt] for j in ny] for i in nx]


# ---------------------------------------------------------------- shells and velocities


class Shell:
    """F on the bins around a wavenumber: `columns` (i, j), their k and omega0; frequencies and their weights.

    omega0 is that of water of the `gravity`, `depth` (None: without a bottom) and `surface_tension` that are given.
    """

    def __init__(
        self,
        values: list[list[Number]] | None,
        columns: Bins,
        shape: Sequence[int],
        spacing: Sequence[float],
        gravity: float,
        width: Number = 4,
        depth: float | None = None,
        surface_tension: float = 0,
    ) -> None:
        sides = [n * mpf(d) for n, d in zip(shape, spacing, strict=True)]
        self.kx = [2 * mp.pi * i / sides[0] for i, _ in columns]
        self.ky = [2 * mp.pi * j / sides[1] for _, j in columns]
        water = (gravity, depth, surface_tension)
        self.omega0 = [dispersion(mp.hypot(p, q), *water) for p, q in zip(self.kx, self.ky, strict=True)]
        nt, resolution = shape[2], 2 * mp.pi / sides[2]
        self.omega = [m * resolution for m in range(nt // 2 + 1)]
        self.weight = [mpf(1) / 2 if m in (0, nt / 2) else mpf(1) for m in range(nt // 2 + 1)]
        self.width = mpf(width) * resolution  # a of eq:DSVkernel
        self.f = [[abs(v) for v in row] for row in values] if values else []

    def centres(self, c: Sequence[Number]) -> Iterable[tuple[int, Number]]:
        """(column, frequency) where either branch is: eq:SnJ and its mirror image (decision D2)."""
        for n, (p, q, w) in enumerate(zip(self.kx, self.ky, self.omega0, strict=True)):
            shift = p * mpf(c[0]) + q * mpf(c[1])
            yield n, w + shift
            yield n, shift - w


def shell_bins(shape: Sequence[int], spacing: Sequence[float], wavenumber: Number) -> Bins:
    """Bins (i, j) with |k - k_i| <= 2 dk, those on the edge included (decisions D3, D20)."""
    dkx, dky = (2 * mp.pi / (n * mpf(d)) for n, d in zip(shape[:2], spacing, strict=False))
    reach = (2 + mpf(10) ** -9) * max(dkx, dky)
    return [
        (i, j)
        for i in range(-(shape[0] // 2), (shape[0] + 1) // 2)
        for j in range(-(shape[1] // 2), (shape[1] + 1) // 2)
        if abs(mp.hypot(i * dkx, j * dky) - mpf(wavenumber)) <= reach
    ]


def characteristic(shell: Shell, c: Sequence[Number]) -> list[list[Number]]:
    """G of eq:DSVkernel, (n, nw)."""
    g = [[mpf(0)] * len(shell.omega) for _ in shell.kx]
    for n, centre in shell.centres(c):
        for m, w in enumerate(shell.omega):
            g[n][m] += mp.exp(-2 * (w - centre) ** 2 / shell.width**2)
    return g


def score(shell: Shell, c: Sequence[Number]) -> tuple[Number, list[Number], list[list[Number]]]:
    """N of eq:normSp, its gradient and Hessian: first and second derivatives of a quotient of two sums."""
    top, bottom = [mpf(0)] * 6, [mpf(0)] * 6  # value, x, y, xx, xy, yy
    a = shell.width
    for n, centre in shell.centres(c):
        p, q = shell.kx[n], shell.ky[n]
        for m, w in enumerate(shell.omega):
            d = w - centre
            g = shell.weight[m] * mp.exp(-2 * d * d / a**2)
            first, second = 4 * d / a**2 * g, (16 * d * d / a**4 - 4 / a**2) * g
            for s, value in enumerate((g, first * p, first * q, second * p * p, second * p * q, second * q * q)):
                top[s] += value * shell.f[n][m]
                bottom[s] += value
    energy = mp.fsum(w * v for row in shell.f for w, v in zip(shell.weight, row, strict=True))
    scale = len(shell.kx) * mp.fsum(shell.weight) / energy
    t, b = top[0], bottom[0]
    gradient = [scale * (top[s] * b - t * bottom[s]) / b**2 for s in (1, 2)]

    def second_derivative(s: int, r: int, q: int) -> Number:
        return scale * (
            top[s] / b
            - (top[r] * bottom[q] + top[q] * bottom[r] + t * bottom[s]) / b**2
            + 2 * t * bottom[r] * bottom[q] / b**3
        )

    xy = second_derivative(4, 1, 2)
    return scale * t / b, gradient, [[second_derivative(3, 1, 1), xy], [xy, second_derivative(5, 2, 2)]]


def newton(shell: Shell, start: Sequence[float]) -> list[Number]:
    """The stationary point of N nearest to `start`, which has to be close."""
    c = [mpf(v) for v in start]
    for _ in range(8):
        _, (gx, gy), ((xx, xy), (_, yy)) = score(shell, c)
        determinant = xx * yy - xy * xy
        step = (yy * gx - xy * gy) / determinant, (xx * gy - xy * gx) / determinant
        c = [c[0] - step[0], c[1] - step[1]]
        if mp.hypot(*step) < mpf(10) ** (8 - DIGITS):
            return c
    return [mp.nan, mp.nan]


def least_squares(shell: Shell) -> list[Number]:
    """The minimum of eq:LS1 over the bins above 0.2 of the largest power, by Cramer's rule (decisions D7, D8, D19)."""
    largest = max(max(row) for row in shell.f)
    xx = xy = yy = xb = yb = mpf(0)
    for p, q, omega0, row in zip(shell.kx, shell.ky, shell.omega0, shell.f, strict=True):
        for w, value in zip(shell.omega, row, strict=True):
            if (value / largest) ** 2 >= mpf(1) / 5:
                xx, xy, yy = xx + p * p, xy + p * q, yy + q * q
                xb, yb = xb + p * (w - omega0), yb + q * (w - omega0)
    determinant = xx * yy - xy * xy
    if abs(determinant) < mpf(10) ** -9 * (xx + yy) ** 2:
        return [mp.nan, mp.nan]
    return [(yy * xb - xy * yb) / determinant, (xx * yb - xy * xb) / determinant]


def statistics(velocities: Any) -> dict[str, list[Any]]:
    """Bias, random part (n - 1, decision D12), mean vector and standard error over the first axis of [R][n][2].

    null stands for no number; a velocity without one is left out.
    """
    out: dict[str, list[Any]] = {"bias": [], "random": [], "mean": [], "standard_error": [], "count": []}
    for column in zip(*velocities, strict=True):
        there = [[mpf(v) for v in c] for c in column if None not in c]
        size = len(there)
        length = [mp.hypot(*c) for c in there]
        bias = mp.fsum(length) / size
        random = mp.sqrt(mp.fsum((v - bias) ** 2 for v in length) / (size - 1))
        out["bias"].append(bias)
        out["random"].append(random)
        out["mean"].append([mp.fsum(c[axis] for c in there) / size for axis in (0, 1)])
        out["standard_error"].append(random / mp.sqrt(size))
        out["count"].append(size)
    return out

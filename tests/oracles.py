"""Deliberately dumb oracles: loops and direct sums, written from the paper and from nothing in leakref."""

from __future__ import annotations

import cmath
import math
from collections.abc import Callable, Iterable, Sequence

import mpmath

Wave = tuple[float, float, float, float, float]  # kx, ky, omega, amplitude, phase


def waves(components) -> list[Wave]:
    """The components as plain tuples."""
    c = components
    return [tuple(map(float, w)) for w in zip(c.kx, c.ky, c.omega, c.amplitude, c.phase, strict=True)]


def surface(components, x: Sequence[float], y: Sequence[float], t: Sequence[float]) -> list[list[list[float]]]:
    """eta[x][y][t] by a loop over samples and waves."""
    listed = waves(components)
    return [
        [
            [
                math.fsum(a * math.cos(kx * p + ky * q - omega * s + phase) for kx, ky, omega, a, phase in listed)
                for s in t
            ]
            for q in y
        ]
        for p in x
    ]


def window(name: str, size: int) -> list[float]:
    """Periodic samples: box, eq:hann, Blackman, and Kaiser-Bessel with its zero at two bins."""
    if name == "box":
        return [1.0] * size
    s = [n / size for n in range(size)]
    if name == "hann":
        return [0.5 - 0.5 * math.cos(2 * math.pi * u) for u in s]
    if name == "blackman":
        return [0.42 - 0.5 * math.cos(2 * math.pi * u) + 0.08 * math.cos(4 * math.pi * u) for u in s]
    b = math.pi * math.sqrt(3)
    return [float(mpmath.besseli(0, b * mpmath.sqrt(1 - (2 * u - 1) ** 2)) / mpmath.besseli(0, b)) for u in s]


def spectral_sum(eta, name: str, bin_numbers: tuple[int, int, int]) -> complex:
    """sum w eta exp(-i (k.x - omega t)) at one bin, sample by sample."""
    nx, ny, nt = len(eta), len(eta[0]), len(eta[0][0])
    wx, wy, wt = (window(name, n) for n in (nx, ny, nt))
    i, j, m = bin_numbers
    total = 0j
    for a in range(nx):
        for b in range(ny):
            for c in range(nt):
                turn = (i * a % nx) / nx + (j * b % ny) / ny - (m * c % nt) / nt
                total += wx[a] * wy[b] * wt[c] * float(eta[a][b][c]) * cmath.exp(-2j * math.pi * turn)
    return total


def exponential_sum(bin_number: int, position: float, size: int, weights: Iterable[float] | None = None) -> mpmath.mpc:
    """sum over m of w_m exp(-2 pi i m (n - u) / size), with 40 digits."""
    with mpmath.workdps(40):
        u = mpmath.mpf(position)
        w = [mpmath.mpf(1)] * size if weights is None else [mpmath.mpf(v) for v in weights]
        return mpmath.fsum(w[m] * mpmath.expjpi(-2 * m * (bin_number - u) / size) for m in range(size))


def window_transform(name: str, offset: float) -> float:
    """Integral of w(s) cos(2 pi v (s - 1/2)) over 0 < s < 1."""
    b = mpmath.pi * mpmath.sqrt(3)
    w = {
        "box": lambda s: mpmath.mpf(1),
        "hann": lambda s: 0.5 - 0.5 * mpmath.cos(2 * mpmath.pi * s),
        "blackman": lambda s: 0.42 - 0.5 * mpmath.cos(2 * mpmath.pi * s) + 0.08 * mpmath.cos(4 * mpmath.pi * s),
        "kaiser-bessel": lambda s: mpmath.besseli(0, b * mpmath.sqrt(1 - (2 * s - 1) ** 2)) / mpmath.besseli(0, b),
    }
    return float(
        mpmath.quad(lambda s: w[name](s) * mpmath.cos(2 * mpmath.pi * offset * (s - 0.5)), mpmath.linspace(0, 1, 9))
    )


def shell_bins(n: int, grid_shape: tuple[int, int], ratio: int = 1) -> list[tuple[int, int]]:
    """Bins (i, j) with |k - n dk| <= 2 dk where dkx = dk and dky = dk / ratio, in exact integer arithmetic."""
    found = []
    for i in range(-(grid_shape[0] // 2), (grid_shape[0] + 1) // 2):
        for j in range(-(grid_shape[1] // 2), (grid_shape[1] + 1) // 2):
            squared = (ratio * i) ** 2 + j**2
            if (ratio * max(n - 2, 0)) ** 2 <= squared <= (ratio * (n + 2)) ** 2:
                found.append((i, j))
    return found


def mirrored(k: tuple[float, float], c: Sequence[float], omega0: float) -> float:
    """Where a real signal's mirror image is seen: omega = -omega0 + k.c."""
    return -omega0 + k[0] * c[0] + k[1] * c[1]


def as_printed(k: tuple[float, float], c: Sequence[float], omega0: float) -> float:
    """Where eq:DSVkernel as printed puts its other branch: omega = -omega_DR = -omega0 - k.c."""
    return -omega0 - k[0] * c[0] - k[1] * c[1]


def normalized_scalar_product(
    whole,
    bin_widths: Sequence[float],
    wavenumber: float,
    velocity: Sequence[float],
    width: float,
    *,
    half: bool = False,
    gravity: float = 1.0,
    branch: Callable[..., float] = mirrored,
) -> float:
    """N of eq:normSp, bin by bin, over the whole space or the half omega >= 0; `whole` is S[i][j][m] in FFT order."""
    shape = len(whole), len(whole[0]), len(whole[0][0])
    dk = max(bin_widths[:2])
    count = gf = g = f = 0.0
    for i in range(-(shape[0] // 2), (shape[0] + 1) // 2):
        for j in range(-(shape[1] // 2), (shape[1] + 1) // 2):
            k = i * bin_widths[0], j * bin_widths[1]
            modulus = math.hypot(*k)
            if abs(modulus - wavenumber) > 2 * dk * (1 + 1e-12):
                continue
            omega0 = math.sqrt(gravity * modulus)
            centres = omega0 + k[0] * velocity[0] + k[1] * velocity[1], branch(k, velocity, omega0)
            for m in range(0 if half else -(shape[2] // 2), shape[2] // 2 + 1 if half else (shape[2] + 1) // 2):
                weight = 0.5 if half and m in (0, shape[2] / 2) else 1.0
                characteristic = sum(math.exp(-2 * ((m * bin_widths[2] - centre) / width) ** 2) for centre in centres)
                magnitude = abs(whole[i % shape[0]][j % shape[1]][m % shape[2]])
                count += weight
                gf += weight * characteristic * magnitude
                g += weight * characteristic
                f += weight * magnitude
    return (gf / count) / ((g / count) * (f / count))


def least_squares(
    whole, bin_widths: Sequence[float], wavenumber: float, threshold: float, gravity: float = 1.0
) -> tuple[tuple[float, float], list[tuple[float, float, float, float]]]:
    """The minimum of eq:LS1 over omega >= 0 by Cramer's rule, and its data (kx, ky, omega, omega0)."""
    shape = len(whole), len(whole[0]), len(whole[0][0])
    inside = []
    for i in range(-(shape[0] // 2), (shape[0] + 1) // 2):
        for j in range(-(shape[1] // 2), (shape[1] + 1) // 2):
            kx, ky = i * bin_widths[0], j * bin_widths[1]
            if abs(math.hypot(kx, ky) - wavenumber) <= 2 * max(bin_widths[:2]) * (1 + 1e-12):
                inside += [
                    (abs(whole[i % shape[0]][j % shape[1]][m]) ** 2, kx, ky, m * bin_widths[2])
                    for m in range(shape[2] // 2 + 1)
                ]
    largest = max(power for power, *_ in inside)
    data = [
        (kx, ky, omega, math.sqrt(gravity * math.hypot(kx, ky)))
        for power, kx, ky, omega in inside
        if power >= threshold * largest
    ]
    xx, xy, yy, xb, yb = (
        math.fsum(terms)
        for terms in zip(
            *(
                (kx * kx, kx * ky, ky * ky, kx * (omega - omega0), ky * (omega - omega0))
                for kx, ky, omega, omega0 in data
            ),
            strict=True,
        )
    )
    determinant = xx * yy - xy * xy
    return ((yy * xb - xy * yb) / determinant, (xx * yb - xy * xb) / determinant), data


def philox4x64_10(counter: Sequence[int], key: Sequence[int]) -> list[int]:
    """One block of Philox4x64-10 (Salmon et al., Random123), on Python's integers."""
    mask = 2**64 - 1
    c, k = list(counter), list(key)
    for _ in range(10):
        high0, low0 = divmod(0xD2E7470EE14C6C93 * c[0], 2**64)
        high1, low1 = divmod(0xCA5A826395121157 * c[2], 2**64)
        c = [high1 ^ c[1] ^ k[0], low1, high0 ^ c[3] ^ k[1], low0]
        k = [(k[0] + 0x9E3779B97F4A7C15) & mask, (k[1] + 0xBB67AE8584CAA73B) & mask]
    return c


def differences(function: Callable[[float, float], float], at: Sequence[float], step: float) -> list[float]:
    """Gradient by central differences of fourth order: error step^4 f^(5) / 30, plus rounding over step."""
    x, y = at
    return [
        (
            8 * (function(x + a, y + b) - function(x - a, y - b))
            - function(x + 2 * a, y + 2 * b)
            + function(x - 2 * a, y - 2 * b)
        )
        / (12 * step)
        for a, b in ((step, 0.0), (0.0, step))
    ]


def _in_shell(whole, bin_widths: Sequence[float], wavenumber: float) -> list[tuple[float, float, list[float]]]:
    """kx, ky and the power at every omega >= 0 of the bins in the plane with |k - wavenumber| <= 2 dk."""
    shape, found = (len(whole), len(whole[0]), len(whole[0][0])), []
    for i in range(-(shape[0] // 2), (shape[0] + 1) // 2):
        for j in range(-(shape[1] // 2), (shape[1] + 1) // 2):
            kx, ky = i * bin_widths[0], j * bin_widths[1]
            if abs(math.hypot(kx, ky) - wavenumber) <= 2 * max(bin_widths[:2]) * (1 + 1e-12):
                row = whole[i % shape[0]][j % shape[1]]
                found.append((kx, ky, [abs(row[m]) ** 2 for m in range(shape[2] // 2 + 1)]))
    return found


def crest(whole, bin_widths: Sequence[float], wavenumber: float, threshold: float) -> list[tuple[float, float, float]]:
    """kx, ky, and by how much the crest is off sqrt k: the mean of three bins around the strongest, by their power."""
    inside = _in_shell(whole, bin_widths, wavenumber)
    largest, points = max(max(row) for *_, row in inside), []
    for kx, ky, row in inside:
        if max(row) >= threshold * largest:
            top = row.index(max(row))
            three = [m for m in (top - 1, top, top + 1) if 0 <= m < len(row)]
            mean = math.fsum(m * row[m] for m in three) / math.fsum(row[m] for m in three)
            points.append((kx, ky, mean * bin_widths[2] - math.sqrt(math.hypot(kx, ky))))
    return points


def iterative_least_squares(whole, bin_widths: Sequence[float], wavenumber: float) -> tuple[tuple[float, float], int]:
    """Bins above 0.02 within 4 domega of the nearer branch, again and again; and how often they changed."""
    (u, v), _ = least_squares(whole, bin_widths, wavenumber, 0.2)
    inside = _in_shell(whole, bin_widths, wavenumber)
    largest = max(max(row) for *_, row in inside)
    before: list[tuple[float, float, float]] = []
    for count in range(100):
        taken = []
        for kx, ky, row in inside:
            for m, power in enumerate(row):
                if power < 0.02 * largest:
                    continue
                omega0, omega = math.sqrt(math.hypot(kx, ky)), m * bin_widths[2]
                off = min((omega - s * omega0 for s in (1, -1)), key=lambda w: abs(w - kx * u - ky * v))
                if abs(off - kx * u - ky * v) <= 4 * bin_widths[2]:
                    taken.append((kx, ky, off))
        if taken == before:
            return (u, v), count
        before = taken
        xx, xy, yy, xb, yb = (
            math.fsum(terms) for terms in zip(*((p * p, p * q, q * q, p * w, q * w) for p, q, w in taken), strict=True)
        )
        u, v = (yy * xb - xy * yb) / (xx * yy - xy * xy), (xx * yb - xy * xb) / (xx * yy - xy * xy)
    raise AssertionError("the bins never settle")

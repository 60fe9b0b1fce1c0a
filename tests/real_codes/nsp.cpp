// Near-surface currents by the normalized scalar product, as one writes it for oneself in C++17, behind protocol 1 in
// plain files. It is handed pictures: [t][y][x], the first row at the top. The search is a lattice of velocities, and
// from the best of them ever smaller steps.

#include <algorithm>
#include <array>
#include <cmath>
#include <complex>
#include <cstdio>
#include <fstream>
#include <iostream>
#include <stdexcept>
#include <string>
#include <vector>

using Complex = std::complex<double>;
using Velocity = std::array<double, 2>;
const double pi = 3.14159265358979323846;

// ---- a line of JSON as leakref writes it: the text that follows a key

std::string value(const std::string& line, const std::string& key) {
  const auto at = line.find("\"" + key + "\": ");
  if (at == std::string::npos) throw std::runtime_error("no " + key + " was given");
  return line.substr(at + key.size() + 4);
}

double number(const std::string& line, const std::string& key) { return std::stod(value(line, key)); }

std::string word(const std::string& line, const std::string& key) {
  const std::string rest = value(line, key).substr(1);
  std::string found;
  for (std::size_t n = 0; n < rest.size() && rest[n] != '"'; ++n) found += rest[n] == '\\' ? rest[++n] : rest[n];
  return found;
}

std::vector<double> list(const std::string& line, const std::string& key) {
  const std::string rest = value(line, key);
  std::vector<double> found;
  std::size_t at = 0, used = 0;
  while (rest.at(at) != ']') {
    found.push_back(std::stod(rest.substr(at + 1, 32), &used));
    at = rest.find_first_of(",]", at + 1 + used);
  }
  return found;
}

// ---- the spectrum

struct Wave {  // a column of the spectrum: a wavenumber, y upwards, and the magnitudes at all frequencies >= 0
  double kx, ky, k;
  std::vector<double> F;
};

struct Spectrum {
  std::vector<Wave> waves;
  double domega, dk, nyquist, largest;
  int nt;
  double weight(std::size_t m) const { return m == 0 || int(2 * m) == nt ? 0.5 : 1.0; }
};

// The sum of x[j] exp(sign 2 pi i m j / n), for all m, of n values that are `stride` apart.
void transform(Complex* x, int n, std::size_t stride, int sign, const std::vector<double>& taper) {
  std::vector<Complex> turn(n), sum(n);
  for (int j = 0; j < n; ++j) turn[j] = std::polar(1.0, sign * 2 * pi * j / n);
  for (int m = 0; m < n; ++m)
    for (int j = 0, at = 0; j < n; ++j, at = (at + m) % n) sum[m] += taper[j] * x[j * stride] * turn[at];
  for (int m = 0; m < n; ++m) x[m * stride] = sum[m];
}

std::vector<double> taper(const std::string& name, int n) {
  std::vector<double> w(n, 1.0);
  for (int j = 0; j < n && name == "hann"; ++j) w[j] = std::pow(std::sin(pi * j / n), 2);
  return w;
}

Spectrum spectrum(const std::string& line) {
  const auto shape = list(line, "eta");
  const int nt = int(shape.at(0)), ny = int(shape.at(1)), nx = int(shape.at(2));
  const std::size_t row = nx, frame = row * ny, all = frame * nt;
  std::vector<double> pixels(all);
  std::ifstream file(word(line, "input") + "/eta.f64", std::ios::binary);
  if (!file.read(reinterpret_cast<char*>(pixels.data()), std::streamsize(8 * all)))
    throw std::runtime_error("the pictures cannot be read");
  if (!std::all_of(pixels.begin(), pixels.end(), [](double v) { return std::isfinite(v); }))
    throw std::runtime_error("there are gaps in the pictures");
  std::vector<Complex> S(pixels.begin(), pixels.end());
  const std::string window = word(line, "window");
  for (std::size_t n = 0; n < all; n += row) transform(&S[n], nx, 1, -1, taper(window, nx));
  for (std::size_t t = 0; t < all; t += frame)
    for (int i = 0; i < nx; ++i) transform(&S[t + i], ny, row, -1, taper(window, ny));
  for (std::size_t n = 0; n < frame; ++n) transform(&S[n], nt, frame, +1, taper(window, nt));

  const double ux = 2 * pi / (nx * number(line, "dx")), uy = 2 * pi / (ny * number(line, "dy"));
  Spectrum found{{}, 2 * pi / (nt * number(line, "dt")), std::max(ux, uy), 0, 0, nt};
  found.nyquist = pi / std::max(number(line, "dx"), number(line, "dy"));
  for (int j = 0; j < ny; ++j)
    for (int i = 0; i < nx; ++i) {
      const double kx = ux * (2 * i < nx ? i : i - nx), down = uy * (2 * j < ny ? j : j - ny);
      Wave wave{kx, -down, std::hypot(kx, down), {}};
      for (int m = 0; 2 * m <= nt; ++m) wave.F.push_back(std::abs(S[m * frame + j * row + i]));
      found.largest = std::max(found.largest, *std::max_element(wave.F.begin(), wave.F.end()));
      found.waves.push_back(wave);
    }
  return found;
}

// ---- the velocity

double overlap(const Spectrum& s, const std::vector<const Wave*>& shell, double gravity, Velocity c) {
  const double a = 4 * s.domega;
  double product = 0, sum = 0;
  for (const Wave* wave : shell) {
    const double shift = wave->kx * c[0] + wave->ky * c[1], omega0 = std::sqrt(gravity * wave->k);
    for (std::size_t m = 0; m < wave->F.size(); ++m) {
      const double up = (m * s.domega - omega0 - shift) / a, down = (m * s.domega + omega0 - shift) / a;
      const double G = s.weight(m) * (std::exp(-2 * up * up) + std::exp(-2 * down * down));
      product += G * wave->F[m];
      sum += G;
    }
  }
  return sum > 0 ? product / sum : 0;
}

std::string velocity(const Spectrum& s, double wavenumber, double gravity) {
  std::vector<const Wave*> shell;
  double largest = 0;
  for (const Wave& wave : s.waves)
    if (std::abs(wave.k - wavenumber) <= 2 * s.dk * (1 + 1e-9)) {
      shell.push_back(&wave);
      largest = std::max(largest, *std::max_element(wave.F.begin(), wave.F.end()));
    }
  if (wavenumber + 2 * s.dk >= s.nyquist || !(largest > 1e-12 * s.largest)) return "null";
  // further out the dispersion surface leaves the frequencies that there are, and its overlap means nothing
  const double unit = std::sqrt(gravity / wavenumber), last = s.domega * (s.nt / 2);
  const double reach = std::min(1.2 * unit, (last - std::sqrt(gravity * wavenumber) - 12 * s.domega) / wavenumber);
  const double apart = 2 * s.domega / wavenumber;
  if (reach <= 0) return "null";
  Velocity best{0, 0};
  double most = overlap(s, shell, gravity, best);
  auto attempt = [&](Velocity c) {
    const double N = std::hypot(c[0], c[1]) <= reach ? overlap(s, shell, gravity, c) : 0;
    if (N <= most) return false;
    best = c, most = N;
    return true;
  };
  for (double u = -reach; u <= reach; u += apart)
    for (double v = -reach; v <= reach; v += apart)
      attempt({u, v});
  for (double step = apart / 2; step > 1e-8 * unit; step /= 2) {
    bool moved = true;
    while (moved) {
      const auto [u, v] = best;
      moved = attempt({u + step, v}) || attempt({u - step, v}) || attempt({u, v + step}) || attempt({u, v - step});
    }
  }
  char row[64];
  std::snprintf(row, sizeof row, "[%.15g, %.15g]", best[0], -best[1]);  // as the rows are counted, downwards
  return row;
}

int main() {
  for (std::string line; std::getline(std::cin, line);) {
    const std::string op = word(line, "op");
    if (op == "stop") break;
    if (op == "start") {
      std::cout << R"({"op": "ready", "protocol": 1, "name": "nsp.cpp", "version": "1", "format": "raw", )"
                << R"("units": "si", "axes": "tyx", "y": "down", "direction": "to", "can": {"extract": )"
                << R"({"methods": ["nsp"], "windows": ["box", "hann"], "resolves": "wavenumber"}}})" << std::endl;
      continue;
    }
    std::string said;
    try {
      const Spectrum s = spectrum(line);
      for (const double wavenumber : list(line, "wavenumbers"))
        said += (said.empty() ? "" : ", ") + velocity(s, wavenumber, number(line, "gravity"));
      said = "\"ok\", \"velocities\": [" + said + "]";
    } catch (const std::exception& fault) {
      said = std::string("\"error\", \"message\": \"") + fault.what() + "\"";
    }
    std::cout << "{\"id\": " << long(number(line, "id")) << ", \"status\": " << said << "}" << std::endl;
  }
}

// An adapter in C++17: put your own code in place of what `currents` does here.
// It speaks protocol 1: a line of JSON in, a line of JSON out, arrays in plain files of little-endian float64.

#include <algorithm>
#include <array>
#include <cmath>
#include <complex>
#include <cstdio>
#include <fstream>
#include <iostream>
#include <limits>
#include <stdexcept>
#include <string>
#include <vector>

using Values = std::vector<double>;
using Waves = std::vector<std::complex<double>>;

const double pi = std::acos(-1.0);

// What the code expects and returns; leakref converts to it and back.
const char* const ready =
    R"({"op": "ready", "protocol": 1, "name": "my code", "version": "1", "format": "raw", "units": "si", )"
    R"("axes": "xyt", "y": "up", "direction": "to", "water": {"depth": "given"}, )"
    R"("can": {"window": {"names": ["box", "hann"]}, )"
    R"("extract": {"methods": ["ls"], "windows": ["box", "hann"], "resolves": "wavenumber"}}})";

// The values of keys on the line: enough for what leakref sends.
std::size_t after(const std::string& line, const std::string& key) {
  const auto at = line.find("\"" + key + "\":");
  if (at == std::string::npos) throw std::runtime_error("there is no " + key);
  return line.find_first_not_of(' ', at + key.size() + 3);
}

std::string text(const std::string& line, const std::string& key) {
  std::string value;
  for (auto at = after(line, key) + 1; at < line.size() && line[at] != '"'; ++at) {
    if (line[at] == '\\') ++at;
    value += line[at];
  }
  return value;
}

double number(const std::string& line, const std::string& key) { return std::stod(line.substr(after(line, key), 40)); }

Values numbers(const std::string& line, const std::string& key) {
  Values found;
  auto at = after(line, key) + 1;
  while (line.at(at) != ']') {
    std::size_t used = 0;
    found.push_back(std::stod(line.substr(at, 40), &used));
    at = line.find_first_not_of(", ", at + used);
  }
  return found;
}

Values read(const std::string& path, std::size_t size) {
  Values values(size);
  std::ifstream file(path, std::ios::binary);
  if (!file.read(reinterpret_cast<char*>(values.data()), static_cast<std::streamsize>(8 * size)))
    throw std::runtime_error("cannot read " + path);
  return values;
}

void write(const std::string& path, const Values& values) {
  std::ofstream file(path, std::ios::binary);
  if (!file.write(reinterpret_cast<const char*>(values.data()), static_cast<std::streamsize>(8 * values.size())))
    throw std::runtime_error("cannot write " + path);
}

Values taper(const std::string& name, int size) {
  Values w(size, 1.0);
  for (int n = 0; n < size && name == "hann"; ++n) w[n] = 0.5 - 0.5 * std::cos(2 * pi * n / size);
  return w;
}

// The plain sum of values exp(sign i 2 pi m j / size) along one axis of a cube.
void transform(Waves& values, int size, int stride, int sign) {
  Waves turn(size), line(size);
  for (int m = 0; m < size; ++m) turn[m] = std::polar(1.0, sign * 2 * pi * m / size);
  for (std::size_t base = 0; base < values.size(); ++base) {
    if (base / stride % size != 0) continue;
    for (int j = 0; j < size; ++j) line[j] = values[base + j * stride];
    for (int m = 0; m < size; ++m) {
      std::complex<double> sum = 0;
      for (int j = 0, at = 0; j < size; ++j, at = (at + m) % size) sum += line[j] * turn[at];
      values[base + m * stride] = sum;
    }
  }
}

// The current (cx, cy) that the waves near each wavenumber see, NaN where there is none: a fit of
// omega = sqrt(g k tanh(k h)) + k.c by least squares to the strong bins around each. The cube eta is [x][y][t], h the
// depth.
std::vector<std::array<double, 2>> currents(const Values& eta, int nx, int ny, int nt, double dx, double dy, double dt,
                                            double g, double h, const std::string& window, const Values& wavenumbers) {
  const Values wx = taper(window, nx), wy = taper(window, ny), wt = taper(window, nt);
  Waves S(eta.size());
  for (std::size_t n = 0; n < eta.size(); ++n) {
    if (!std::isfinite(eta[n])) throw std::runtime_error("the surface holds values that are not finite");
    S[n] = eta[n] * wx[n / nt / ny] * wy[n / nt % ny] * wt[n % nt];
  }
  transform(S, nt, 1, +1);  // forwards in space and backwards in time: a wave that goes along k is found at k
  transform(S, ny, nt, -1);
  transform(S, nx, ny * nt, -1);

  const double ux = 2 * pi / (nx * dx), uy = 2 * pi / (ny * dy), ut = 2 * pi / (nt * dt), width = std::max(ux, uy),
               none = std::numeric_limits<double>::quiet_NaN();
  std::vector<std::array<double, 2>> found;
  for (const double wavenumber : wavenumbers) {
    struct Bin { double kx, ky, shift, power; };
    std::vector<Bin> shell;
    double largest = 0;
    for (int i = -(nx / 2); i < (nx + 1) / 2; ++i)
      for (int j = -(ny / 2); j < (ny + 1) / 2; ++j) {
        const double k = std::hypot(i * ux, j * uy);
        if (std::abs(k - wavenumber) > 2.000001 * width) continue;
        for (int m = 0; m <= nt / 2; ++m) {
          const double power = std::norm(S[(std::size_t((i + nx) % nx) * ny + (j + ny) % ny) * nt + m]);
          shell.push_back({i * ux, j * uy, m * ut - std::sqrt(g * k * std::tanh(k * h)), power});
          largest = std::max(largest, power);
        }
      }
    double xx = 0, xy = 0, yy = 0, xs = 0, ys = 0;
    for (const Bin& bin : shell)
      if (bin.power >= 0.2 * largest) {
        xx += bin.kx * bin.kx, xy += bin.kx * bin.ky, yy += bin.ky * bin.ky;
        xs += bin.kx * bin.shift, ys += bin.ky * bin.shift;
      }
    const double determinant = xx * yy - xy * xy;  // waves in one direction say nothing of the current across it
    if (largest > 0 && wavenumber + 2 * width < pi / std::max(dx, dy) && determinant > 1e-9 * (xx + yy) * (xx + yy))
      found.push_back({(yy * xs - xy * ys) / determinant, (xx * ys - xy * xs) / determinant});
    else
      found.push_back({none, none});
  }
  return found;
}

std::string extract(const Values& eta, int nx, int ny, int nt, const std::string& line) {
  std::string rows;
  for (const auto& c : currents(eta, nx, ny, nt, number(line, "dx"), number(line, "dy"), number(line, "dt"),
                                number(line, "gravity"), number(line, "depth"), text(line, "window"),
                                numbers(line, "wavenumbers"))) {
    char row[80] = "null";
    if (std::isfinite(c[0])) std::snprintf(row, sizeof row, "[%.17g, %.17g]", c[0], c[1]);
    rows += (rows.empty() ? "" : ", ") + std::string(row);
  }
  return ", \"velocities\": [" + rows + "]";
}

std::string answer(const std::string& line) {
  if (text(line, "stage") == "window") {
    write(text(line, "output") + "/w.f64", taper(text(line, "name"), static_cast<int>(number(line, "size"))));
    return "";
  }
  const Values shape = numbers(line, "eta");
  const int nx = static_cast<int>(shape.at(0)), ny = static_cast<int>(shape.at(1)), nt = static_cast<int>(shape.at(2));
  return extract(read(text(line, "input") + "/eta.f64", std::size_t(nx) * ny * nt), nx, ny, nt, line);
}

int main() {
  for (std::string line; std::getline(std::cin, line);) {
    if (text(line, "op") == "stop") break;
    if (text(line, "op") == "start") {
      std::cout << ready << std::endl;
      continue;
    }
    std::string status;
    try {
      status = "\"ok\"" + answer(line);
    } catch (const std::exception& fault) {
      status = std::string("\"error\", \"message\": \"") + fault.what() + "\"";
    }
    std::cout << "{\"id\": " << static_cast<long>(number(line, "id")) << ", \"status\": " << status << "}" << std::endl;
  }
}

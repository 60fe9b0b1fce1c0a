// A small least-squares fit that answers the examination in this folder: put your own code in the place of `extract`.
#include "leakref_exam.hpp"

using Waves = std::vector<std::complex<double>>;
const double pi = std::acos(-1.0);

std::vector<double> taper(const std::string& name, std::size_t size) {
  std::vector<double> w(size, 1.0);
  for (std::size_t n = 0; n < size && name == "hann"; ++n) w[n] = 0.5 - 0.5 * std::cos(2 * pi * n / size);
  return w;
}

// The plain sum of values exp(sign i 2 pi m j / size) along one axis of a cube.
void transform(Waves& values, std::size_t size, std::size_t stride, int sign) {
  Waves turn(size), line(size);
  for (std::size_t m = 0; m < size; ++m) turn[m] = std::polar(1.0, sign * 2 * pi * m / size);
  for (std::size_t base = 0; base < values.size(); ++base) {
    if (base / stride % size != 0) continue;
    for (std::size_t j = 0; j < size; ++j) line[j] = values[base + j * stride];
    for (std::size_t m = 0; m < size; ++m) {
      std::complex<double> sum = 0;
      for (std::size_t j = 0, at = 0; j < size; ++j, at = (at + m) % size) sum += line[j] * turn[at];
      values[base + m * stride] = sum;
    }
  }
}

// A fit of omega = sqrt(g k tanh(k h)) + k.c by least squares to the strong bins around each wavenumber.
leakref::Rows extract(const leakref::Given& given, const leakref::Question& q) {
  const std::vector<double>& eta = given.at("eta");
  const auto shape = q.shape("eta");
  const long nx = long(shape[0]), ny = long(shape[1]), nt = long(shape[2]);
  const double g = q.number("gravity"), h = q.has("depth") ? q.number("depth") : std::numeric_limits<double>::infinity();
  const auto wx = taper(q.text("window"), shape[0]), wy = taper(q.text("window"), shape[1]),
             wt = taper(q.text("window"), shape[2]);
  Waves S(eta.size());
  for (std::size_t n = 0; n < eta.size(); ++n) {
    if (!std::isfinite(eta[n])) throw std::runtime_error("the surface holds values that are not finite");
    S[n] = eta[n] * wx[n / shape[2] / shape[1]] * wy[n / shape[2] % shape[1]] * wt[n % shape[2]];
  }
  transform(S, shape[2], 1, +1);  // forwards in space and backwards in time: a wave that goes along k is found at k
  transform(S, shape[1], shape[2], -1);
  transform(S, shape[0], shape[1] * shape[2], -1);

  const double dx = q.number("dx"), dy = q.number("dy");
  const double ux = 2 * pi / (nx * dx), uy = 2 * pi / (ny * dy), ut = 2 * pi / (nt * q.number("dt"));
  const double width = std::max(ux, uy), none = std::numeric_limits<double>::quiet_NaN();
  leakref::Rows found;
  for (const double wavenumber : q.numbers("wavenumbers")) {
    struct Bin { double kx, ky, shift, power; };
    std::vector<Bin> shell;
    double largest = 0;
    for (long i = -(nx / 2); i < (nx + 1) / 2; ++i)
      for (long j = -(ny / 2); j < (ny + 1) / 2; ++j) {
        const double k = std::hypot(i * ux, j * uy);
        if (std::abs(k - wavenumber) > 2.000001 * width) continue;
        for (long m = 0; m <= nt / 2; ++m) {
          const double power = std::norm(S[std::size_t(((i + nx) % nx * ny + (j + ny) % ny) * nt + m)]);
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
    const bool there = largest > 0 && wavenumber + 2 * width < pi / std::max(dx, dy) &&
                       determinant > 1e-9 * (xx + yy) * (xx + yy);
    if (there) found.velocities.push_back({(yy * xs - xy * ys) / determinant, (xx * ys - xy * xs) / determinant});
    else found.velocities.push_back({none, none});
  }
  return found;
}

int main() {
  leakref::Code code;
  code.extract = extract;
  code.window = [](const leakref::Given&, const leakref::Question& q) {
    return taper(q.text("name"), static_cast<std::size_t>(q.number("size")));
  };
  return leakref::exam(code);
}

// Answers the questions in this folder with functions of yours (C++17, a little-endian machine, no library):
//
//   leakref::Code code;
//   code.extract = [](const leakref::Given& given, const leakref::Question& q) { ...; return leakref::Rows{...}; };
//   return leakref::exam(code);
//
// given["eta"] is the cube, eta[(i * n1 + j) * n2 + m] with n = q.shape("eta"); given["x"], ["y"], ["t"] its axes.
// q.number("dx"), dy, dt, gravity (and depth, surface_tension if they were declared), q.numbers("wavenumbers"),
// q.text("window"), q.text("method"). Rows holds (cx, cy) for each wavenumber, NaN where there is no number; a code with
// wavenumbers of its own fills in those too. For other stages set code.window, of q.text("name") and q.number("size");
// code.spectrum, S in the order of eta; code.synthesize, of given["kx"], ["ky"], ["omega"], ["amplitude"], ["phase"] and
// the axes. What a function cannot do it says by throw leakref::Unsupported("why"). Stopped, the program goes on where
// it was; to start anew remove answers.part.
#pragma once

#include <algorithm>
#include <array>
#include <chrono>
#include <cmath>
#include <complex>
#include <cstdint>
#include <cstdio>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <functional>
#include <iterator>
#include <limits>
#include <map>
#include <set>
#include <sstream>
#include <stdexcept>
#include <string>
#include <vector>

namespace leakref {

using Values = std::vector<double>;
using Given = std::map<std::string, Values>;

struct Unsupported : std::runtime_error { using std::runtime_error::runtime_error; };
struct Stale : std::runtime_error { using std::runtime_error::runtime_error; };

inline std::vector<std::string> split(const std::string& text, char at) {
  std::vector<std::string> parts(1);
  for (const char c : text) {
    if (c == at) parts.emplace_back();
    else parts.back() += c;
  }
  return parts;
}

struct Question {
  std::string id, stage, input, output;
  std::map<std::string, std::string> parameters;

  bool has(const std::string& name) const { return parameters.count(name) > 0; }
  std::string text(const std::string& name) const { return parameters.at(name); }
  double number(const std::string& name) const { return std::stod(parameters.at(name)); }
  Values numbers(const std::string& name) const {
    Values found;
    for (const auto& part : split(parameters.at(name), ',')) found.push_back(std::stod(part));
    return found;
  }
  std::vector<std::size_t> shape(const std::string& name) const {
    const Values sizes = numbers("shape_" + name);
    return {sizes.begin(), sizes.end()};
  }
};

struct Rows {
  std::vector<std::array<double, 2>> velocities;
  Values wavenumbers;
};

struct Code {
  std::function<Rows(const Given&, const Question&)> extract;
  std::function<std::vector<std::complex<double>>(const Given&, const Question&)> spectrum;
  std::function<Values(const Given&, const Question&)> synthesize, window;
};

inline std::string content(const std::filesystem::path& path) {
  std::ifstream file(path, std::ios::binary);
  if (!file) throw Stale(path.string() + " is not there: copy the whole folder again");
  return {std::istreambuf_iterator<char>(file), {}};
}

inline void put(const std::filesystem::path& path, const std::string& text, std::ios::openmode mode = std::ios::trunc) {
  std::ofstream file(path, std::ios::binary | mode);
  if (!(file << text).flush()) throw std::runtime_error(path.string() + " cannot be written");
}

// The arrays of a question. Refuses those of another examination, by their Adler-32.
inline Given arrays(const std::filesystem::path& place, const Question& question, std::uint32_t should) {
  Given given;
  std::uint32_t a = 1, b = 0;
  for (const auto& [name, unused] : question.parameters) {  // by name: in the order of the sum
    const auto path = place / (name.substr(0, 6) == "shape_" ? name.substr(6) + ".f64" : "-");
    if (!std::filesystem::exists(path)) continue;
    const std::string bytes = content(path);
    for (const unsigned char byte : bytes) a = (a + byte) % 65521, b = (b + a) % 65521;
    Values& values = given[path.stem().string()];
    values.resize(bytes.size() / 8);
    std::memcpy(values.data(), bytes.data(), 8 * values.size());
  }
  if (b * 65536 + a != should) throw Stale(place.string() + " is not of this examination: copy the whole folder again");
  return given;
}

inline std::string number(double value) {
  char text[40];
  std::snprintf(text, sizeof text, "%.17g", value);
  return std::isinf(value) ? (value > 0 ? "1e999" : "-1e999") : text;  // JSON has no word for it
}

inline std::string row(const std::array<double, 2>& c) {
  return std::isnan(c[0]) || std::isnan(c[1]) ? "null" : "[" + number(c[0]) + ", " + number(c[1]) + "]";
}

template <class T>
std::string array(const std::filesystem::path& folder, const Question& question, const char* name, const T& values) {
  std::filesystem::create_directories(folder / question.output);
  const char* const start = reinterpret_cast<const char*>(values.data());
  put(folder / question.output / name, {start, values.size() * sizeof values[0]});
  return ", \"output\": \"" + question.output + "\"";
}

// What comes after the status: velocities on the line, arrays in a file.
inline std::string result(const Code& code, const std::filesystem::path& folder, const Question& q, const Given& given) {
  const std::string lacking = "no function was given for " + q.stage;
  if (q.stage == "extract" && code.extract) {
    const Rows found = code.extract(given, q);
    std::string rows, at;
    for (const auto& c : found.velocities) rows += (rows.empty() ? "" : ", ") + row(c);
    for (const double k : found.wavenumbers) at += (at.empty() ? "" : ", ") + number(k);
    return ", \"velocities\": [" + rows + "]" + (at.empty() ? "" : ", \"wavenumbers\": [" + at + "]");
  }
  if (q.stage == "spectrum" && code.spectrum) return array(folder, q, "S.f64", code.spectrum(given, q));
  if (q.stage == "synthesize" && code.synthesize) return array(folder, q, "eta.f64", code.synthesize(given, q));
  if (q.stage == "window" && code.window) return array(folder, q, "w.f64", code.window(given, q));
  throw Unsupported(lacking);
}

inline std::string answered(const Code& code, const std::filesystem::path& folder, const Question& q, std::uint32_t sum) {
  std::string status = "ok", rest;
  try {
    rest = result(code, folder, q, q.input == "-" ? Given() : arrays(folder / q.input, q, sum));
  } catch (const Stale&) {
    throw;
  } catch (const std::exception& fault) {
    status = dynamic_cast<const Unsupported*>(&fault) ? "unsupported" : "error";
    std::string message = fault.what();
    for (char& c : message) if (c < 32 || c > 126 || c == '"' || c == '\\') c = ' ';
    rest = ", \"message\": \"" + message + "\"";
  }
  return "{\"id\": \"" + q.id + "\", \"status\": \"" + status + "\"" + rest + "}";
}

inline int examine(const Code& code, const std::filesystem::path& folder) {
  const auto lines = split(content(folder / "questions.tsv"), '\n');
  const auto head = split(lines.at(0), '\t');
  if (head.at(0) != "leakref/exam/1" || head.at(2) != "raw")
    throw Stale("questions.tsv is no examination in raw: have it written with --format raw");
  const std::string digest = head.at(1);
  std::string declared = content(folder / "declaration.json");
  declared.erase(declared.find_last_not_of(" \r\n") + 1);

  std::set<std::string> done;  // what was answered before: a line each, the id and the answer
  std::string answers, kept = digest + "\n";
  if (std::filesystem::exists(folder / "answers.part")) {
    std::string text = content(folder / "answers.part");
    text.erase(text.rfind('\n') + 1);  // a line that was cut off is answered again
    if (text.substr(0, text.find('\n')) != digest)
      throw Stale("answers.part answers another examination: remove it, and answers.json, to answer this one");
    kept = text;
    for (const auto& line : split(text, '\n'))
      if (const auto at = line.find('\t'); at != std::string::npos) {
        done.insert(line.substr(0, at));
        answers += (answers.empty() ? "" : ",\n") + line.substr(at + 1);
      }
  } else if (std::filesystem::exists(folder / "answers.json")) {
    throw Stale("there is an answers.json that no answers.part goes with: move it away");
  }
  put(folder / "answers.part", kept);

  const auto keep = [&] {  // after each question: answers.json is whole at any time
    put(folder / "answers.new", "{\"digest\": \"" + digest + "\", \"code\": " + declared + ", \"answers\": [\n" + answers + "\n]}\n");
    std::filesystem::rename(folder / "answers.new", folder / "answers.json");
  };
  const auto begun = std::chrono::steady_clock::now();
  std::size_t count = 0, asked = 0, number_of = 0;
  for (std::size_t n = 2; n < lines.size(); ++n) count += !lines[n].empty();
  for (std::size_t n = 2; n < lines.size(); ++n) {
    if (lines[n].empty()) continue;
    ++number_of;
    const auto cells = split(lines[n], '\t');
    if (done.count(cells.at(0))) continue;
    Question q{cells.at(0), cells.at(1), cells.at(2), cells.at(4), {}};
    for (std::size_t m = 5; m < cells.size(); ++m)
      q.parameters[cells[m].substr(0, cells[m].find('='))] = cells[m].substr(cells[m].find('=') + 1);
    const std::string answer = answered(code, folder, q, static_cast<std::uint32_t>(std::stoul(cells.at(3))));
    put(folder / "answers.part", q.id + "\t" + answer + "\n", std::ios::app);
    answers += (answers.empty() ? "" : ",\n") + answer;
    done.insert(q.id);
    keep();
    const std::chrono::duration<double> spent = std::chrono::steady_clock::now() - begun;
    const double left = spent.count() / static_cast<double>(++asked) * static_cast<double>(count - done.size());
    std::printf("%4zu of %zu  %-44s about %.0f s to go\n", number_of, count, q.id.c_str(), left);
    std::fflush(stdout);
  }
  keep();
  std::printf("All %zu questions are answered, in answers.json. For the marks, where leakref is installed:\n\n", count);
  std::printf("    leakref exam grade %s\n\n", std::filesystem::absolute(folder).lexically_normal().string().c_str());
  return 0;
}

// Answer the folder; the exit status.
inline int exam(const Code& code, const std::filesystem::path& folder = ".") {
  try {
    return examine(code, folder);
  } catch (const std::exception& fault) {
    std::fprintf(stderr, "leakref_exam: %s\n", fault.what());
    return 2;
  }
}

}  // namespace leakref

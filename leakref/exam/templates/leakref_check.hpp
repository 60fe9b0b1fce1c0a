// Compares your functions with the golden values in this folder (C++17, no library but leakref_exam.hpp beside it):
//
//   leakref::Stages stages;
//   stages["window"] = [](const leakref::Given& given, const leakref::Question& q) {
//     return leakref::Given{{"w", my_window(q.text("window"), int(q.number("size")))}}; };
//   return leakref::check(stages);
//
// A function is that of a stage. It is handed the arrays of a vector and, in q, its id and its words and numbers, and
// returns the outputs by name, the last index fastest. A table of ids, digits that agree, and pass or FAIL is printed;
// the exit status is 0 if all pass, 1 if not, 2 if nothing was compared. What is allowed is `times` the tolerance.
#pragma once

#include "leakref_exam.hpp"

namespace leakref {

using Stages = std::map<std::string, std::function<Given(const Given&, const Question&)>>;

// The fewest digits of all outputs; what fell short is added to `why`.
inline double agreement(const Given& found, const Given& golden, double times, std::string& why) {
  double digits = 15.6;
  for (const auto& [name, right] : golden) {
    if (name.substr(0, 8) == "allowed_") continue;
    const Values& allowed = golden.at("allowed_" + name);
    const auto own = found.find(name);
    if (own == found.end()) throw std::runtime_error(name + " is missing");
    const Values& mine = own->second;
    if (mine.size() != right.size())
      throw std::runtime_error(name + " has " + std::to_string(mine.size()) + " values, should be " + std::to_string(right.size()));
    double largest = 0, scale = 0;
    std::size_t worst = right.size();
    for (std::size_t n = 0; n < right.size(); ++n) {
      if (std::isnan(mine[n]) && std::isnan(right[n])) continue;
      const double off = std::isnan(mine[n] - right[n]) ? std::numeric_limits<double>::infinity() : std::abs(mine[n] - right[n]);
      if (!(off <= times * allowed[n]) && (worst == right.size() || off > std::abs(mine[worst] - right[worst]))) worst = n;
      largest = std::max(largest, off);
      scale = std::isnan(right[n]) ? scale : std::max(scale, std::abs(right[n]));
    }
    if (worst < right.size())
      why += " " + name + "(" + std::to_string(worst) + ") is " + number(mine[worst]) + ", should be " +
             number(right[worst]) + " within " + number(times * allowed[worst]);
    if (largest > 0 && scale > 0) digits = std::min(digits, std::max(0.0, std::floor(-10 * std::log10(largest / scale)) / 10));
  }
  return digits;
}

inline int compare(const Stages& stages, const std::filesystem::path& folder, double times) {
  const auto lines = split(content(folder / "vectors.tsv"), '\n');
  if (lines.at(0) != "leakref/pack/1\traw") throw Stale("vectors.tsv is no pack in raw: have it written with --format raw");
  std::size_t all = 0, compared = 0, failed = 0;
  for (std::size_t n = 2; n < lines.size(); ++n) {
    if (lines[n].empty()) continue;
    ++all;
    const auto cells = split(lines[n], '\t');
    const auto stage = stages.find(cells.at(1));
    if (stage == stages.end()) continue;
    Question given{cells[0], cells[1], cells[2], cells[4], {}}, golden = given;
    for (std::size_t m = 6; m < cells.size(); ++m) {
      const std::string name = cells[m].substr(0, cells[m].find('=')), value = cells[m].substr(cells[m].find('=') + 1);
      if (name.substr(0, 7) == "golden_") golden.parameters[name.substr(7)] = value;
      else given.parameters[name] = value;
    }
    const auto sum = [&](std::size_t cell) { return static_cast<std::uint32_t>(std::stoul(cells[cell])); };
    const Given inputs = given.input == "-" ? Given() : arrays(folder / given.input, given, sum(3));
    const Given right = arrays(folder / golden.output, golden, sum(5));
    double digits = 0;
    std::string why;
    try {
      digits = agreement(stage->second(inputs, given), right, times, why);
    } catch (const std::exception& fault) {
      why = std::string(" ") + fault.what();
    }
    ++compared;
    failed += !why.empty();
    std::printf("%-40s %5.1f  %s\n", given.id.c_str(), digits, why.empty() ? "pass" : ("FAIL " + why).c_str());
  }
  if (compared == 0) throw Stale("nothing was compared: no stage of the pack is offered");
  std::printf("%zu of %zu vectors pass; %zu are of stages that were not offered.\n", compared - failed, compared, all - compared);
  return failed > 0;
}

// Compare with the folder; the exit status.
inline int check(const Stages& stages, const std::filesystem::path& folder = ".", double times = 1) {
  try {
    return compare(stages, folder, times);
  } catch (const std::exception& fault) {
    std::fprintf(stderr, "leakref_check: %s\n", fault.what());
    return 2;
  }
}

}  // namespace leakref

// Two reports of `bench`, an earlier one and today's: each figure with its ratio, and whether what was measured differs by more than it varies.
// Reports are the JSON that `bench --json` prints (app/README.md), also with --effects.
#pragma once

#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <string>
#include <vector>

namespace warpscope {

/// A median of repeated timings in milliseconds, or a number of bytes: less is better.
struct BenchFigure {
  std::string where;             ///< "cuda: spheres, 25°": backend, technique or effect, view; what is said twice in a report is one
  std::string what;              ///< its key: "drawMs", "bytes"
  double value = 0.0;
  std::optional<double> spread;  ///< between quartiles; nothing where it is not known, 0 of bytes
};

/// In the report's order. Differences (`addsMs`, `savesMs`) and rates (`fps`) are none: others have what they are made of.
std::vector<BenchFigure> figuresOf(const nlohmann::json& report);

enum class BenchVerdict {
  less,     ///< today, by more than both spreads explain
  more,     ///< likewise
  unclear,  ///< the ranges between quartiles meet, each taken to lie about its median; or one is not known
};

struct ComparedFigure {
  BenchFigure before, now;
  BenchVerdict verdict = BenchVerdict::unclear;

  /// Below 1: less today. Nothing where there was 0.
  std::optional<double> ratio() const { return before.value > 0.0 ? std::optional(now.value / before.value) : std::nullopt; }
};

struct BenchComparison {
  std::vector<ComparedFigure> figures;   ///< that both have
  std::vector<std::string> onlyBefore;   ///< "cuda: spheres, buildMs"
  std::vector<std::string> onlyNow;
  std::vector<std::string> differences;  ///< sentences: another device or version, which do not forbid to compare
};

/// Why figures of both would not be of the same thing: another scene, size or knob; empty if they are. Of what stands in both.
std::string whyNotComparable(const nlohmann::json& before, const nlohmann::json& now);

/// What both say; see whyNotComparable().
BenchComparison compared(const nlohmann::json& before, const nlohmann::json& now);

/// For people: a line for each figure, and what else there is to say.
std::string textOf(const BenchComparison& comparison);
nlohmann::json toJson(const BenchComparison& comparison);

}  // namespace warpscope

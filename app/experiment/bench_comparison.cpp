// Walking through reports, whose figures are known by their keys.
// See bench_comparison.h.
#include "app/experiment/bench_comparison.h"

#include <algorithm>
#include <array>
#include <nlohmann/json.hpp>
#include <string_view>

#include "render/base/formatted.h"

namespace warpscope {
namespace {

using Json = nlohmann::json;

constexpr std::string_view kMs = "Ms", kSpread = "SpreadMs", kBytes = "bytes";
constexpr std::array<std::string_view, 2> kDifferences{"addsMs", "savesMs"};
/// What is no condition of a measurement at the top of a report: how often, with what, and on what.
constexpr std::array<std::string_view, 6> kOfTheRun{"runs", "version", "device", "backend", "samples", "rawBytes"};

template <size_t N>
bool isAmong(std::string_view name, const std::array<std::string_view, N>& names) {
  return std::ranges::find(names, name) != names.end();
}

bool isFigure(std::string_view key, const Json& value) {
  return value.is_number() && !key.ends_with(kSpread) && !isAmong(key, kDifferences) && (key.ends_with(kMs) || key == kBytes);
}

std::optional<double> spreadOf(const Json& object, std::string_view key) {
  if (key == kBytes) return 0.0;
  const auto spread = object.find(std::string(key.substr(0, key.size() - kMs.size())) + std::string(kSpread));
  return spread != object.end() && spread->is_number() ? std::optional(spread->get<double>()) : std::nullopt;
}

/// How an element of a list is told from the others; empty if it is not.
std::string nameOf(const Json& element) {
  for (const char* key : {"technique", "effect"})
    if (const auto name = element.find(key); name != element.end() && name->is_string()) return name->get<std::string>();
  if (const auto angle = element.find("angleDeg"); angle != element.end() && angle->is_number()) return formatted("%g", angle->get<double>()) + "°";
  return "";
}

/// The figures of the object, then those of the objects in its lists; with `backend` views are a technique's, which stand in the backend as well.
void collect(const Json& object, const std::string& where, bool isBackend, std::vector<BenchFigure>& figures) {
  for (const auto& [key, value] : object.items()) {
    // The paper's method once more, for Table 1.
    if (isBackend && key == "buildMs") continue;
    if (isFigure(key, value)) figures.push_back({where, key, value.get<double>(), spreadOf(object, key)});
  }
  for (const auto& [key, value] : object.items()) {
    if (!value.is_array() || (isBackend && key == "views")) continue;
    for (const Json& element : value)
      if (const std::string name = element.is_object() ? nameOf(element) : ""; !name.empty()) collect(element, where.ends_with(":") ? where + " " + name : where + ", " + name, false, figures);
  }
}

std::string labelOf(const BenchFigure& figure) { return figure.where + ", " + figure.what; }

BenchVerdict verdictOf(const BenchFigure& before, const BenchFigure& now) {
  if (!before.spread || !now.spread) return BenchVerdict::unclear;
  if (now.value + 0.5 * *now.spread < before.value - 0.5 * *before.spread) return BenchVerdict::less;
  if (now.value - 0.5 * *now.spread > before.value + 0.5 * *before.spread) return BenchVerdict::more;
  return BenchVerdict::unclear;
}

std::string_view wordOf(const ComparedFigure& figure) {
  const bool isTime = figure.now.what != kBytes;
  switch (figure.verdict) {
    case BenchVerdict::less: return isTime ? "faster" : "fewer";
    case BenchVerdict::more: return isTime ? "slower" : "more";
    case BenchVerdict::unclear: break;
  }
  if (!isTime) return "the same";
  return figure.before.spread && figure.now.spread ? "within the spread" : "no spread is known";
}

/// With blanks before it; a character may have several bytes.
std::string rightAligned(const std::string& text, size_t width) {
  const auto characters = static_cast<size_t>(std::ranges::count_if(text, [](char byte) { return (static_cast<unsigned char>(byte) & 0xc0) != 0x80; }));
  return std::string(width - std::min(width, characters), ' ') + text;
}

std::string valueText(const BenchFigure& figure) {
  if (figure.what == kBytes) return formatted("%.0f", figure.value);
  return formatted("%.4g", figure.value) + (figure.spread ? " ±" + formatted("%.2g", 0.5 * *figure.spread) : "");
}

}  // namespace

std::vector<BenchFigure> figuresOf(const Json& report) {
  std::vector<BenchFigure> figures;
  const auto backends = report.find("backends");
  if (backends == report.end() || !backends->is_array()) return figures;
  for (const Json& backend : *backends)
    if (backend.is_object() && backend.value("backend", Json()).is_string()) collect(backend, backend["backend"].get<std::string>() + ":", true, figures);
  return figures;
}

std::string whyNotComparable(const Json& before, const Json& now) {
  for (const auto& [key, value] : now.items()) {
    const auto other = before.find(key);
    if (other == before.end() || value.is_structured() || isAmong(key, kOfTheRun) || key.ends_with(kMs) || key == kBytes) continue;
    if (*other != value) return key + " was " + other->dump() + " then and is " + value.dump() + " now";
  }
  return "";
}

BenchComparison compared(const Json& before, const Json& now) {
  BenchComparison comparison;
  const std::vector<BenchFigure> then = figuresOf(before), today = figuresOf(now);
  const auto find = [](const std::vector<BenchFigure>& figures, const BenchFigure& wanted) {
    return std::ranges::find_if(figures, [&](const BenchFigure& figure) { return figure.where == wanted.where && figure.what == wanted.what; });
  };
  for (const BenchFigure& figure : today) {
    const auto other = find(then, figure);
    if (other == then.end())
      comparison.onlyNow.push_back(labelOf(figure));
    else
      comparison.figures.push_back({*other, figure, verdictOf(*other, figure)});
  }
  for (const BenchFigure& figure : then)
    if (find(today, figure) == today.end()) comparison.onlyBefore.push_back(labelOf(figure));

  const auto textAt = [](const Json& object, const char* key) {
    return object.is_object() && object.value(key, Json()).is_string() ? object[key].get<std::string>() : std::string("an unknown one");
  };
  if (const std::string was = textAt(before, "version"), is = textAt(now, "version"); was != is) comparison.differences.push_back("version " + was + " then, " + is + " now");
  for (const Json& backend : now.value("backends", Json::array()))
    for (const Json& other : before.value("backends", Json::array()))
      if (textAt(backend, "backend") == textAt(other, "backend") && textAt(backend, "device") != textAt(other, "device"))
        comparison.differences.push_back(textAt(backend, "backend") + " was " + textAt(other, "device") + " then and is " + textAt(backend, "device") + " now");
  return comparison;
}

std::string textOf(const BenchComparison& comparison) {
  std::string text = rightAligned("then", 38) + rightAligned("now", 22) + rightAligned("ratio", 9) + "\n", where;
  for (const ComparedFigure& figure : comparison.figures) {
    if (where != figure.now.where) text += (where = figure.now.where) + "\n";
    const std::optional<double> ratio = figure.ratio();
    text += "  " + figure.now.what + rightAligned(valueText(figure.before), 36 - std::min<size_t>(36, figure.now.what.size())) + rightAligned(valueText(figure.now), 22) +
            rightAligned(ratio ? formatted("%.3f", *ratio) : "-", 9) + "  " + std::string(wordOf(figure)) + "\n";
  }
  for (const std::string& difference : comparison.differences) text += "note: " + difference + "\n";
  if (!comparison.onlyBefore.empty()) text += "then alone: " + std::to_string(comparison.onlyBefore.size()) + " figures, the first " + comparison.onlyBefore.front() + "\n";
  if (!comparison.onlyNow.empty()) text += "now alone: " + std::to_string(comparison.onlyNow.size()) + " figures, the first " + comparison.onlyNow.front() + "\n";
  return text;
}

Json toJson(const BenchComparison& comparison) {
  Json figures = Json::array();
  for (const ComparedFigure& figure : comparison.figures) {
    const auto orNull = [](const std::optional<double>& value) { return value ? Json(*value) : Json(nullptr); };
    figures.push_back({{"where", figure.now.where},
                       {"what", figure.now.what},
                       {"before", figure.before.value},
                       {"beforeSpread", orNull(figure.before.spread)},
                       {"now", figure.now.value},
                       {"nowSpread", orNull(figure.now.spread)},
                       {"ratio", orNull(figure.ratio())},
                       {"verdict", wordOf(figure)}});
  }
  return {{"figures", figures}, {"onlyBefore", comparison.onlyBefore}, {"onlyNow", comparison.onlyNow}, {"differences", comparison.differences}};
}

}  // namespace warpscope

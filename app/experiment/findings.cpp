// Fronts and the answer.
// See findings.h.
#include "app/experiment/findings.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <limits>
#include <map>
#include <nlohmann/json.hpp>
#include <numeric>

#include "app/experiment/averages.h"
#include "app/experiment/effect_findings.h"

namespace warpscope {
namespace {

constexpr double kBudgetsMs[] = {1.0, 4.0, 16.0, kHeadlineBudgetMs};
constexpr double kFlipGoals[] = {0.02, 0.05, 0.1};

std::string whatOf(const Summary& summary) {
  char text[160];
  std::snprintf(text, sizeof text, "FLIP %.4f, holes %.1f %%, in %.3g ms", summary.flip, 100.0 * summary.holeFraction, summary.frameMs);
  return text;
}

nlohmann::json toJson(const Summary& summary) {
  nlohmann::json json = toJson(summary.configuration);
  json["flip"] = summary.flip;
  json["holeFraction"] = summary.holeFraction;
  json["frameMs"] = summary.frameMs;
  json["drawMs"] = summary.drawMs;
  json["serverMs"] = summary.serverMs;
  json["bytes"] = summary.bytes;
  return json;
}

nlohmann::json orNull(const std::optional<Summary>& summary) { return summary ? toJson(*summary) : nlohmann::json(nullptr); }

/// The least by `value` among the summaries that `may` be taken; of equals the faster.
template <class May, class Value>
std::optional<Summary> least(const std::vector<Summary>& summaries, const May& may, const Value& value) {
  const Summary* best = nullptr;
  for (const Summary& summary : summaries) {
    if (!summary.configuration.technique->usesFrame || !may(summary)) continue;
    if (best == nullptr || std::pair(value(summary), summary.frameMs) < std::pair(value(*best), best->frameMs)) best = &summary;
  }
  return best == nullptr ? std::nullopt : std::optional(*best);
}

/// "12 % less error than", "as much error as": `value` against `other`.
std::string errorAgainst(double value, double other) {
  if (value == other) return "as much error as";
  if (other == 0.0) return "more error than";
  char text[64];
  const double change = value / other - 1.0;
  std::snprintf(text, sizeof text, std::abs(change) < 0.0995 ? "%.1f %% %s error than" : "%.0f %% %s error than", 100.0 * std::abs(change),
                change < 0.0 ? "less" : "more");
  return text;
}

/// The paper's method, that of 2012, and what is best in time: each as a sentence.
std::string headlineOf(const Findings& findings, const std::vector<Summary>& summaries) {
  const auto is = [&](const char* subject, const std::optional<Summary>& summary) {
    return std::string(subject) + " (" + nameAmong(summary->configuration, summaries) + ") has " + whatOf(*summary);
  };
  std::string text;
  const std::optional<Summary>&paper = findings.papersMethod, &points = findings.pointBaseline, &best = findings.bestInTime;
  text += paper ? is("The paper's method", paper) + ".\n" : "The paper's method was not measured.\n";
  text += points ? is("The method of 2012", points) : "The method of 2012 was not measured";
  if (points && paper) text += ": " + errorAgainst(points->flip, paper->flip) + " the paper's";
  text += ".\n";
  char within[64];
  std::snprintf(within, sizeof within, "within %g ms a frame", kHeadlineBudgetMs);
  if (!best) return text + "Nothing that was measured gets ready " + within + ".\n";
  const auto isBest = [&](const std::optional<Summary>& other) { return other && keyOf(other->configuration) == keyOf(best->configuration); };
  if (isBest(paper) || isBest(points)) return text + "Nothing that was measured has less error " + within + " than " + (isBest(paper) ? "the paper's method" : "the method of 2012") + ".\n";
  text += is((std::string("The best ") + within).c_str(), best);
  if (paper) text += ": " + errorAgainst(best->flip, paper->flip) + " the paper's" + (points ? ", " + errorAgainst(best->flip, points->flip) + " that of 2012" : "");
  return text + ".\n";
}

}  // namespace

std::vector<size_t> paretoFront(const std::vector<CostAndError>& points) {
  std::vector<size_t> order(points.size());
  std::iota(order.begin(), order.end(), size_t{0});
  std::stable_sort(order.begin(), order.end(), [&](size_t a, size_t b) {
    return std::pair(points[a].cost, points[a].error) < std::pair(points[b].cost, points[b].error);
  });
  std::vector<size_t> front;
  double error = std::numeric_limits<double>::infinity();
  for (const size_t i : order) {
    if (!(points[i].error < error)) continue;
    error = points[i].error;
    front.push_back(i);
  }
  return front;
}

std::vector<Summary> summariesOf(const std::vector<SweepRow>& rows) {
  std::vector<Summary> summaries;
  std::vector<std::vector<AngleFigures>> angles;  // of each
  std::map<std::string, size_t> places;
  for (const SweepRow& row : rows) {
    if (!row.link.empty()) continue;
    const auto [place, isNew] = places.emplace(keyOf(row.configuration), summaries.size());
    if (isNew) {
      summaries.push_back({row.configuration, 0.0, 0.0, 0.0, 0.0, row.cost.serverMs(), row.cost.bytes});
      angles.emplace_back();
    }
    angles[place->second].push_back({row.errors.flip, row.errors.holeFraction, row.frameMs(), row.draw.medianMs});
  }
  for (size_t i = 0; i < summaries.size(); ++i) {
    const AngleFigures over = overAngles(angles[i]);
    summaries[i].flip = over.flip;
    summaries[i].holeFraction = over.holeFraction;
    summaries[i].frameMs = over.frameMs;
    summaries[i].drawMs = over.drawMs;
  }
  return summaries;
}

std::string nameAmong(const Configuration& configuration, const std::vector<Summary>& all) {
  std::vector<Configuration> others;
  for (const Summary& summary : all) others.push_back(summary.configuration);
  return nameAmong(configuration, others);
}

std::vector<size_t> frontOf(const std::vector<Summary>& summaries) {
  std::vector<size_t> candidates;
  std::vector<CostAndError> points;
  for (size_t i = 0; i < summaries.size(); ++i)
    if (summaries[i].configuration.technique->usesFrame) {
      candidates.push_back(i);
      points.push_back({summaries[i].frameMs, summaries[i].flip});
    }
  std::vector<size_t> front;
  for (const size_t i : paretoFront(points)) front.push_back(candidates[i]);
  return front;
}

Findings findingsOf(const std::vector<SweepRow>& rows) {
  const std::vector<Summary> summaries = summariesOf(rows);
  Findings findings;
  const auto flipOf = [](const Summary& summary) { return summary.flip; };
  const auto timeOf = [](const Summary& summary) { return summary.frameMs; };
  for (const double budgetMs : kBudgetsMs)
    findings.equalTime.push_back({budgetMs, least(summaries, [&](const Summary& summary) { return summary.frameMs <= budgetMs; }, flipOf)});
  for (const double flip : kFlipGoals)
    findings.equalError.push_back({flip, least(summaries, [&](const Summary& summary) { return summary.flip <= flip; }, timeOf)});
  const auto coarseness = [](const Summary& summary) {
    return std::pair(-static_cast<double>(summary.configuration.serverSidePx), summary.configuration.march.render.step);
  };
  findings.papersMethod = least(summaries, [](const Summary& summary) { return isPapersMethod(summary.configuration); }, coarseness);
  findings.pointBaseline = least(summaries, [](const Summary& summary) { return isPointBaseline(summary.configuration); }, coarseness);
  findings.bestInTime = least(summaries, [](const Summary& summary) { return summary.frameMs <= kHeadlineBudgetMs; }, flipOf);
  findings.headline = headlineOf(findings, summaries);
  findings.least = least(summaries, [](const Summary&) { return true; }, flipOf);
  for (const SweepRow& row : rows) {
    if (!row.link.empty() || !row.configuration.technique->usesFrame) continue;
    const auto place = std::find_if(findings.atAngles.begin(), findings.atAngles.end(),
                                    [&](const Findings::AtAngle& other) { return other.angleDeg == row.angleDeg; });
    if (place == findings.atAngles.end())
      findings.atAngles.push_back({row.angleDeg, row.configuration, row.errors.flip});
    else if (row.errors.flip < place->flip)
      *place = {row.angleDeg, row.configuration, row.errors.flip};
  }

  std::string& answer = findings.answer;
  for (const Findings::WithinTime& row : findings.equalTime) {
    char within[48];
    std::snprintf(within, sizeof within, "Within %g ms a frame ", row.budgetMs);
    answer += within;
    answer += row.best ? "use " + nameAmong(row.best->configuration, summaries) + ": " + whatOf(*row.best) + ".\n" : "nothing measured here gets ready.\n";
  }
  if (findings.least) answer += "Whatever it takes, " + nameAmong(findings.least->configuration, summaries) + ": " + whatOf(*findings.least) + ".\n";
  for (const Findings::AtAngle& row : findings.atAngles) {
    char at[64];
    std::snprintf(at, sizeof at, "At %g degrees alone FLIP %.4f with ", row.angleDeg, row.flip);
    answer += at + nameAmong(row.best, summaries) + ".\n";
  }
  answer += effectSentences(summaries);
  if (findings.papersMethod)
    answer += "The paper's method (" + nameAmong(findings.papersMethod->configuration, summaries) + "): " + whatOf(*findings.papersMethod) + ".\n";
  if (findings.pointBaseline)
    answer += "The 2012 method (" + nameAmong(findings.pointBaseline->configuration, summaries) + "): " + whatOf(*findings.pointBaseline) + ".\n";
  return findings;
}

nlohmann::json toJson(const Findings& findings) {
  nlohmann::json equalTime = nlohmann::json::array(), equalError = nlohmann::json::array();
  for (const Findings::WithinTime& row : findings.equalTime) equalTime.push_back({{"budgetMs", row.budgetMs}, {"best", orNull(row.best)}});
  for (const Findings::WithinError& row : findings.equalError) equalError.push_back({{"flip", row.flip}, {"fastest", orNull(row.fastest)}});
  nlohmann::json atAngles = nlohmann::json::array();
  for (const Findings::AtAngle& row : findings.atAngles) {
    atAngles.push_back(toJson(row.best));
    atAngles.back()["angleDeg"] = row.angleDeg;
    atAngles.back()["flip"] = row.flip;
  }
  return {{"equalTime", equalTime},
          {"atAngles", atAngles},
          {"equalError", equalError},
          {"papersMethod", orNull(findings.papersMethod)},
          {"pointBaseline", orNull(findings.pointBaseline)},
          {"least", orNull(findings.least)},
          {"answer", findings.answer}};
}

}  // namespace warpscope

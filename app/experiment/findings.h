// What a sweep's rows say: which configurations nothing beats, what is reachable within a time or an error, and the answer in a sentence.
// Pareto dominance: a point is on the front if no other is at least as good in both and better in one.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "app/experiment/sweep_result.h"

namespace warpscope {

struct CostAndError {
  double cost = 0.0;
  double error = 0.0;
};

/// Indices of the points on the front, by rising cost. Of equal points the first.
std::vector<size_t> paretoFront(const std::vector<CostAndError>& points);

/// One configuration over all angles.
struct Summary {
  Configuration configuration;
  double flip = 0.0;          ///< mean over the angles
  double holeFraction = 0.0;  ///< likewise
  double frameMs = 0.0;       ///< in the slowest view
  double drawMs = 0.0;        ///< likewise
  double serverMs = 0.0;
  size_t bytes = 0;
};

/// In the order of the rows; those behind links are left out.
std::vector<Summary> summariesOf(const std::vector<SweepRow>& rows);

/// A configuration's label with the server's image, step and codec where they tell it from the others of `all`.
std::string nameAmong(const Configuration& configuration, const std::vector<Summary>& all);

/// Indices of the summaries that nothing beats in time and error, among those that a client without the volume can draw.
std::vector<size_t> frontOf(const std::vector<Summary>& summaries);

/// About 30 pictures a second, each of a new frame.
inline constexpr double kHeadlineBudgetMs = 33.0;

struct Findings {
  struct WithinTime {
    double budgetMs = 0.0;
    std::optional<Summary> best;  ///< least error; nothing if all take longer
  };
  struct WithinError {
    double flip = 0.0;
    std::optional<Summary> fastest;  ///< nothing if all are worse
  };
  std::vector<WithinTime> equalTime;    ///< 1, 4, 16, 33 ms
  std::vector<WithinError> equalError;  ///< FLIP 0.02, 0.05, 0.1
  struct AtAngle {
    double angleDeg = 0.0;
    Configuration best;  ///< least error, whatever it takes
    double flip = 0.0;
  };
  std::vector<AtAngle> atAngles;  ///< in the order of the rows
  /// Least: of all errors, whatever it takes. The baselines at the largest of the server's images and the finest step.
  std::optional<Summary> papersMethod, pointBaseline, least;
  std::optional<Summary> bestInTime;  ///< least error within kHeadlineBudgetMs
  std::string headline;  ///< the paper's method, that of 2012 and the best within kHeadlineBudgetMs: three sentences, each on its own line
  std::string answer;    ///< sentences, each on its own line
};

/// `rows` that are behind a link are left out.
Findings findingsOf(const std::vector<SweepRow>& rows);
nlohmann::json toJson(const Findings& findings);

}  // namespace warpscope

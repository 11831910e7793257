// A sweep as one page that explains itself: answer, tables, plots, pictures. Self-contained, and readable without scripts.
// HTML 5 with inline SVG and PNG; the one script sorts the table.
#pragma once

#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "app/experiment/findings.h"
#include "app/experiment/sweep.h"

namespace warpscope {

/// One configuration's pictures, at the sweep's angles.
struct PictureStrip {
  Configuration configuration;
  std::vector<SweepPicture> pictures;
};

struct SweepReport {
  std::string title;
  nlohmann::json head;  ///< scene, plan, machine, version
  glm::vec3 background{0.0f};  ///< linear RGB
  std::vector<SweepRow> rows;
  std::vector<SweepFloor> floors;
  std::vector<SweepBound> bounds;  ///< of both kinds; may be empty
  std::vector<Summary> summaries;
  Findings findings;
  std::vector<SweepLink> links;  ///< of the plan
  std::vector<PictureStrip> strips;
};

/// Those worth looking at: the ground truth, the paper's method and that of 2012, and what is least in error of each technique; each once.
std::vector<Configuration> shownConfigurations(const std::vector<Summary>& summaries, const Findings& findings);

std::string htmlOf(const SweepReport& report);

}  // namespace warpscope

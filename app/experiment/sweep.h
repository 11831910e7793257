// Accuracy against time: every configuration of a plan, at every angle and behind every link, against the ground truth.
// After a warm-up that does not count, stages are timed several times; medians and spreads are kept. Work that configurations share (a march, a
// coding) is done once and charged to each. Errors are of whole pictures: what a configuration leaves empty counts as it is shown.
#pragma once

#include <functional>
#include <memory>
#include <stop_token>
#include <string>
#include <vector>

#include "app/experiment/journal.h"
#include "app/experiment/sweep_plan.h"
#include "app/experiment/sweep_result.h"
#include "app/scene/scene.h"

namespace warpscope {

struct SweepSettings {
  SweepPlan plan;
  uint32_t width = 0;  ///< of the pictures
  uint32_t height = 0;
  WarpSettings warp;   ///< what configurations do not name
};

/// One configuration with the camera standing still, or behind one link.
struct SweepUnit {
  Configuration configuration;
  const SweepLink* link = nullptr;  ///< null: at all angles

  std::string name() const;  ///< the journal's
  /// Whether these are the rows that measuring it under `plan` gives.
  bool hasRows(const std::vector<SweepRow>& rows, const SweepPlan& plan) const;
};
std::vector<SweepUnit> unitsOf(const SweepPlan& plan);

/// A configuration's picture at one of the plan's angles, as the sweep saw it.
struct SweepPicture {
  WarpedImage image;
  double flip = 0.0;
  Image<float> flipMap;  ///< for each pixel, 0..1
};

class Sweep {
 public:
  using Step = std::function<void(const std::string&)>;

  /// The scene must outlive the sweep. All that it does throws as marching and warping do, and OperationCancelled if `stop` is set.
  Sweep(const Scene& scene, const WarpResources& resources, SweepSettings settings, std::stop_token stop);
  ~Sweep();

  /// What the journal does not hold yet, or not as it should.
  std::vector<SweepUnit> unfinished(const SweepJournal& journal) const;

  /// Measures what the journal does not hold yet, and tells it at once, so that nothing is lost if it ends early. `onStep` is called before
  /// each unit that is measured. The rows are in the order of the configurations: angles first, then links.
  std::vector<SweepRow> run(SweepJournal& journal, const Step& onStep);

  /// For each of the plan's angles.
  std::vector<SweepFloor> floors();

  /// Both kinds for each of the plan's angles, of frames of the plan's largest image. Takes its time.
  std::vector<SweepBound> bounds();

  /// For each of the plan's angles.
  std::vector<SweepPicture> pictures(const Configuration& configuration);

 private:
  class Run;

  const SweepSettings settings_;
  const std::stop_token stop_;
  const std::unique_ptr<Run> run_;
};

}  // namespace warpscope

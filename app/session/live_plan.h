// What the march of the newest frame has to do and why, found out in the background; and, where somebody looks, what each part of it costs: measured
// when everything has come to rest, so that what is measured runs alone.
#pragma once

#include <functional>
#include <memory>
#include <optional>
#include <string>

#include "app/experiment/stage_costs.h"
#include "render/base/newest_worker.h"
#include "render/core/crew.h"
#include "render/march/marcher.h"

namespace warpscope {

/// A frame whose march is planned, or measured too.
struct PlanJob {
  MarcherPtr marcher;
  Camera camera;
  MarchSettings settings;
  bool isMeasured = false;

  bool operator==(const PlanJob&) const = default;
};

struct PlanResult {
  PlanJob job;
  std::optional<EffectPlan> plan;   ///< nothing where another process plans
  std::optional<StageCosts> costs;  ///< where the job is measured and there is a plan
  std::string error;
};

using PlanWorker = NewestWorker<PlanJob, PlanResult>;

class LivePlan {
 public:
  /// `onNews` is called on another thread after each result. Loops run on `crew`; null: on all cores.
  explicit LivePlan(std::function<void()> onNews, std::shared_ptr<Crew> crew = nullptr);

  /// Forgets all; what is at work ends.
  void clear();
  /// The frame that is planned from now on, by a marcher of the same volume. True if it is another one than before.
  bool follow(const MarcherPtr& marcher, const SampleFrame& frame);
  /// `mayMeasure`: somebody looks, and nothing else is at work. Begins to measure, or gives it up.
  void measure(bool mayMeasure);
  /// Collects a result. True if there was one that is of use.
  bool take();

  /// Of settings as the newest frame's; nothing while it is not known, or where another process plans.
  const std::optional<EffectPlan>& plan() const { return plan_; }
  /// True if the newest frame was planned, which need not give a plan.
  bool isKnown() const { return isKnown_; }
  /// The newest that were measured with these settings; nothing before. See areCurrent().
  const std::optional<StageCosts>& costs() const { return costs_; }
  /// Whether the costs are those of the newest frame's camera.
  bool areCurrent() const { return costs_ && measured_ == wanted_; }
  bool isMeasuring() const { return isMeasuring_; }
  /// Why it could not be planned or measured; empty if it could.
  const std::string& error() const { return error_; }

  void requestStop() { worker_.requestStop(); }
  bool waitForEnd(std::chrono::steady_clock::time_point time) const { return worker_.waitForEnd(time); }

 private:
  PlanJob wanted_, measured_;  // isMeasured is false in both
  std::optional<EffectPlan> plan_;
  std::optional<StageCosts> costs_;
  bool isKnown_ = false, isMeasuring_ = false;
  std::string error_;
  PlanWorker worker_;
};

}  // namespace warpscope

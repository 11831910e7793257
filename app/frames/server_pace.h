// How coarse the frames of a camera that moves are, so that each takes about as long as its client allows.
// Feedback on what frames took: a march of step s takes a + b/s, and the next step is chosen as if a were 0 (see CoarseningRule).
#pragma once

#include <optional>

#include "render/base/clock.h"
#include "render/core/camera.h"
#include "render/march/march_settings.h"

namespace warpscope {

/// Chooses the factor on the step. It is what would have met the target last, were the time in proportion to pixels / step: of a + b/s the true share of b
/// is smaller, so that each choice goes a part of the rest of the way, never beyond it; the geometric mean with what was known before keeps single slow
/// frames from showing. A factor stays as long as the one that it would become is within kTolerance of it, so that pictures do not flicker.
class CoarseningRule {
 public:
  static constexpr double kTolerance = 1.15;

  /// The factor for a march of so many pixels, 1..kMostCoarsening; 1 as long as nothing is known.
  double factorFor(double pixels, double step, double targetMs);
  /// What a march took.
  void note(double pixels, double step, double tookMs);

 private:
  std::optional<double> logCost_;  // of milliseconds, times the step, a pixel
  double last_ = 1.0;              // factor
};

/// Of one client. The camera moves if it is another one than that of the request before, and came within kMovingFor of that one's answer: whatever a
/// march and the way to the client take, does not count. What is asked for again from the same camera is never coarser: that is how clients refine.
class ServerPace {
 public:
  static constexpr std::chrono::milliseconds kMovingFor{1000};

  /// What to march with. `targetMs`: above 0. `arrivedAt`: when the request came.
  MarchSettings settingsFor(const Camera& camera, const MarchSettings& asked, double targetMs, Clock::TimePoint arrivedAt);
  /// That was marched and answered, and took the server so long.
  void note(const Camera& camera, const MarchSettings& marched, double tookMs, Clock::TimePoint answeredAt);

 private:
  CoarseningRule rule_;
  std::optional<Camera> last_;
  Clock::TimePoint answeredAt_{};
};

}  // namespace warpscope

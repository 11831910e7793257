// How coarse the frames of a camera that moves are, and without which effects, so that each takes about as long as its client allows.
// Feedback on what frames took: a march of step s takes a + b/s, and the next step is chosen as if a were 0 (see CoarseningRule).
#pragma once

#include <optional>
#include <vector>

#include "app/frames/coarsening.h"
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
  /// The factor that would be needed, whatever it is; nothing as long as nothing is known.
  std::optional<double> needFor(double pixels, double step, double targetMs) const;
  /// What a march took.
  void note(double pixels, double step, double tookMs);
  /// All marches take so many times as long from now on.
  void scale(double factor);

 private:
  std::optional<double> logCost_;  // of milliseconds, times the step, a pixel
  double last_ = 1.0;              // factor
};

/// Chooses what is left out as well: the fewest groups of effects without which the greatest step is enough, each number of them with a rule of its own.
/// What has gone stays away until the camera rests, so that pictures do not change to and fro. What its march would take then is known in proportion to
/// what the one in full takes that refines; and a little is forgotten at each, so that it is tried again after some rests.
class LeavingOutRule {
 public:
  /// For a camera that moves.
  Coarsening choose(double pixels, const MarchSettings& asked, double targetMs);
  /// What a march took while the camera moved.
  void noteMoving(double pixels, const MarchSettings& asked, const Coarsening& coarsening, double tookMs);
  /// What a march in full took of a camera that rests.
  void noteAtRest(double pixels, const MarchSettings& asked, double tookMs);

 private:
  struct OfGroups {
    CoarseningRule rule;
    bool isKnownMoving = false;
    bool isFresh = false;  ///< noted since the last rest
  };
  /// Begins anew with other settings. With the copy of the volume or without it a march is the same.
  void follow(MarchSettings asked);

  MarchSettings asked_;  // that all of this is of, without that copy
  std::vector<OfGroups> groups_;  // by how many are left out
  std::optional<double> fullMs_;  // of a pixel, at the last rest
  int leftOut_ = 0;
};

/// Of one client. The camera moves if it is another one than that of the request before, and came within kMovingFor of that one's answer: whatever a
/// march and the way to the client take, does not count. What is asked for again from the same camera is never coarser: that is how clients refine. One
/// request after another: what is noted is of what was chosen last.
class ServerPace {
 public:
  static constexpr std::chrono::milliseconds kMovingFor{1000};

  /// What to march with. `targetMs`: above 0. `arrivedAt`: when the request came.
  MarchSettings settingsFor(const Camera& camera, const MarchSettings& asked, double targetMs, Clock::TimePoint arrivedAt);
  /// What was marched for what was asked, answered, and took the server so long.
  void note(const Camera& camera, const MarchSettings& asked, const MarchSettings& marched, double tookMs, Clock::TimePoint answeredAt);

 private:
  LeavingOutRule rule_;
  bool isMoving_ = false;  // for what was chosen last
  std::optional<Camera> last_;
  Clock::TimePoint answeredAt_{};
};

}  // namespace warpscope

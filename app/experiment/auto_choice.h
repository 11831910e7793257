// The adaptive default: of what was measured, the configuration with the least error at this angle within the time there is.
// Errors between measured angles are interpolated linearly. What was not measured that far out counts only where nothing was.
#pragma once

#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "app/experiment/sweep_result.h"
#include "render/core/camera.h"

namespace warpscope {

inline constexpr Range kBudgetMsRange{0.01, 10000.0};
inline constexpr double kDefaultBudgetMs = 33.0;

class AutoChoice {
 public:
  /// What a picture may take.
  struct Budget {
    double ms = kDefaultBudgetMs;  ///< decoding, building, drawing
    uint64_t bytes = 0;            ///< of its frame, without the copy of the volume; 0: whatever it takes
  };

  /// Rows of a sweep; those behind links, and what needs the volume, are left out.
  explicit AutoChoice(const std::vector<SweepRow>& rows);

  struct Choice {
    Configuration configuration;
    double flip = 0.0;      ///< to be expected
    double frameMs = 0.0;   ///< likewise: decoding, building, drawing
    std::string reason;     ///< a sentence without its full stop: what was picked, and why
  };
  /// `angleDeg`: between the frame's camera and the view; neither its sign nor whole turns matter. If nothing keeps to the milliseconds the fastest is chosen, and the
  /// reason says so. `may`: which configurations are free to be chosen. Nothing if none is that keeps to the bytes.
  std::optional<Choice> choose(double angleDeg, const Budget& budget, const std::function<bool(const Configuration&)>& may) const;

  bool empty() const { return candidates_.empty(); }
  /// Longer side of the largest of the server's images that were measured; 0 without any.
  uint32_t largestSidePx() const;

 private:
  struct AtAngle {
    double angleDeg, flip, frameMs;
    uint64_t bytes;
  };
  struct Candidate {
    Configuration configuration;
    std::vector<AtAngle> angles;  // by rising angle, at least one

    AtAngle at(double angleDeg) const;
    /// Whether it was measured at angles around that one; as far out as it was, to a few degrees.
    bool covers(double angleDeg) const;
  };

  std::vector<Candidate> candidates_;
};

/// By how much another view of a scene differs, as an angle: degrees between the directions in which the cameras look, or that the step from eye to
/// eye spans as seen from the volume's centre, whichever is more; 0..180. Above or below the horizon that is less than the camera was turned by.
double angleBetweenDeg(const Camera& a, const Camera& b);

}  // namespace warpscope

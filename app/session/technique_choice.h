// For a panel that chooses its technique by itself: of what was measured, what is best for this frame at this angle within the budget.
// See experiment/auto_choice.h.
#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <string>

#include "app/experiment/auto_choice.h"
#include "app/experiment/live_front.h"
#include "render/march/sample_frame.h"

namespace warpscope {

class TechniqueChoice {
 public:
  struct Input {
    SampleFramePtr frame;  ///< that pictures are drawn from; not null
    MarchSettings askable; ///< what the next may be asked for: segments and the copy of the volume, which the frame lacks where nothing on show draws them
    Camera camera;         ///< of the pictures
    double budgetMs = 0.0;
    uint32_t serverSidePx = 0;                ///< that the frame was made with; without a front, configurations of that size may be chosen
    std::shared_ptr<const AutoChoice> front;  ///< a sweep to choose by; null: by what was on show so far
  };
  struct Choice {
    const WarpDescriptor* technique = nullptr;
    std::optional<Configuration> configuration;  ///< nothing if nothing that was measured fits the frame
    std::string text;                            ///< what, and why: a sentence without its full stop
  };

  /// Nothing if all that the choice depends on is as it was.
  std::optional<Choice> choose(const Input& input, const LiveFront& live);
  /// Forgets what was chosen.
  void clear() { *this = {}; }

 private:
  struct Seen {
    SampleFramePtr frame;
    MarchSettings askable;
    Camera camera;
    double budgetMs = 0.0;
    std::shared_ptr<const AutoChoice> front;
    uint64_t liveVersion = 0;
    bool operator==(const Seen&) const = default;
  };

  std::optional<Seen> seen_;
  std::optional<Configuration> last_;
};

}  // namespace warpscope

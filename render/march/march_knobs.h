// The knobs of marching: one row each for what the picture is and for what is sent of it.
// MarchSettings holds the values; whatever offers, reads, writes or checks them goes through these rows.
#pragma once

#include <span>
#include <string_view>

#include "render/base/knob.h"
#include "render/march/march_settings.h"

namespace warpscope {

/// What of a frame a knob shapes. A technique that does not look at that is not affected by it.
enum class FramePart {
  picture,  ///< all of it, and the ground truth too
  depth,    ///< where samples lie
  radius,   ///< how large they are
  samples,  ///< how many there are, and with it all that is drawn of them
};

struct MarchKnob : KnobRow<MarchSettings> {
  FramePart shapes = FramePart::picture;
  /// Whether it changes anything as the others are set.
  bool (*matters)(const MarchSettings&) = nullptr;
};

/// Every row, in the order in which they are listed.
std::span<const MarchKnob> marchKnobs();

extern const Knob kStepKnob, kContributionKnob, kSkipEmptyKnob, kTerminateEarlyKnob;
extern const Knob kHeuristicKnob, kThresholdKnob, kRadiusKnob, kRadiusScaleKnob, kSamplesPerRayKnob;

}  // namespace warpscope

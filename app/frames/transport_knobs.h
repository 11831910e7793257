// The knobs of how frames travel: one row each.
// TransportSettings holds the values. The simulated link has words of its own: net/link_settings.h.
#pragma once

#include <span>

#include "app/frames/frame_source.h"
#include "render/base/knob.h"

namespace warpscope {

struct TransportKnob : KnobRow<TransportSettings> {
  /// Whether it changes anything as the others are set.
  bool (*matters)(const TransportSettings&) = nullptr;
  bool isOfServer = false;  ///< not of the way from there
};

/// Every row, in the order in which they are listed.
std::span<const TransportKnob> transportKnobs();

/// Of those what a server is asked for with every frame: rows of the wishes alone.
std::span<const KnobRow<ServerWishes>> serverKnobs();

extern const Knob kFormatKnob, kColorKnob, kQualityKnob, kDepthKnob, kFrameKibKnob, kServerMsKnob, kServerLoadKnob;

}  // namespace warpscope

// The knobs of marching: one row each for what the picture is and for what is sent of it.
// MarchSettings holds the values; whatever offers, reads, writes or checks them goes through these rows.
#pragma once

#include <span>
#include <string>
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
  planes,   ///< what is said of them besides
  segments, ///< what is said of rays besides samples
  proxy,    ///< what is known where no frame has seen anything
};

struct MarchKnob : KnobRow<MarchSettings> {
  FramePart shapes = FramePart::picture;
  /// Whether it changes anything as the others are set.
  bool (*matters)(const MarchSettings&) = nullptr;
};

/// Every row, in the order in which they are listed.
std::span<const MarchKnob> marchKnobs();

/// A setting that is no number but a list: lights, planes, values. Written as one text everywhere, described once like a knob.
struct MarchText {
  std::string_view key;     ///< in JSON, scene files and on the wire
  std::string_view option;  ///< on the command line
  std::string_view label;   ///< beside its field in the window
  std::string_view noun;    ///< in sentences
  std::string_view help;    ///< one sentence without its full stop
  std::string_view values;  ///< what may be written, as help texts and tables say it
  std::string (*get)(const MarchSettings&) = nullptr;
  /// Throws UsageError that begins with `name` and says what is wrong; the settings are then as they were.
  void (*set)(MarchSettings&, std::string_view text, std::string_view name) = nullptr;
  bool (*matters)(const MarchSettings&) = nullptr;  ///< whether it changes anything as the others are set
};

/// Every one, in the order in which they are listed. They shape the picture, like knobs of effects.
std::span<const MarchText> marchTexts();

/// The one of that key; null if there is none.
const MarchText* findMarchText(std::string_view key);

extern const Knob kStepKnob, kContributionKnob, kSkipEmptyKnob, kTerminateEarlyKnob;
extern const Knob kHeuristicKnob, kThresholdKnob, kRadiusKnob, kRadiusScaleKnob, kSamplesPerRayKnob, kSpreadKnob, kSegmentsKnob, kProxyKnob;

}  // namespace warpscope

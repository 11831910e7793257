// What a sweep measures: lists of values for each axis, and the configurations that they make together.
// From a small JSON file, from the command line, or the default, which is meant to end within three minutes on two cores.
#pragma once

#include <functional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "app/experiment/configuration.h"
#include "net/link_settings.h"

namespace warpscope {

struct SweepLink {
  std::string name;  ///< as it was given
  net::DuplexLinkSettings settings;

  bool operator==(const SweepLink&) const = default;
};

/// What a sweep goes through of one knob.
struct KnobValuesAxis {
  const Knob* knob = nullptr;
  std::vector<double> values;  ///< at least one

  bool operator==(const KnobValuesAxis&) const = default;
};

/// Every axis has at least one value, links alone may be empty.
struct SweepPlan {
  std::vector<const WarpDescriptor*> techniques;
  std::vector<KnobValuesAxis> knobs;    ///< one for each of configurationKnobs(), in their order
  std::vector<CodecSettings> codecs;
  std::vector<double> anglesDeg;        ///< that the camera is turned by, away from the frame's
  std::vector<SweepLink> links;         ///< behind which the camera moves, in virtual time
  double speedDegPerS = 30.0;           ///< of that motion, about the vertical axis
  int instants = 3;                     ///< of the motion that are looked at
  int draws = 3;                        ///< that are timed, after one that is not
  MarchSettings base;                   ///< of the scene: what no axis names

  /// Of one knob of configurationKnobs().
  std::vector<double>& values(const Knob& knob);
  const std::vector<double>& values(const Knob& knob) const;

  bool operator==(const SweepPlan&) const = default;
};

/// For a scene that is marched with `base`, shown at `width` x `height`.
SweepPlan defaultPlan(const MarchSettings& base, uint32_t width, uint32_t height);

/// What is worth measuring before one picture, `angleDeg` away from its frame, is drawn: some seconds' work.
SweepPlan quickPlan(const MarchSettings& base, uint32_t width, uint32_t height, double angleDeg);

/// One axis or number of a plan: what the file, the option and the report call it, and how its values are read.
struct SweepAxis {
  std::string_view key;     ///< in the file: "pointSizes"
  std::string_view option;  ///< on the command line: "--point-sizes"
  std::string_view help;
  char separator = ',';     ///< between values of the option
  size_t most = 64;         ///< values
  /// Replaces the plan's values. Throws UsageError for one that is unknown or out of range.
  std::function<void(SweepPlan& plan, std::span<const std::string> values)> set;
};
/// Techniques first, then one for each of configurationKnobs(), then the rest.
std::vector<SweepAxis> sweepAxes();

/// Replaces what the file names. Throws InputError that names the file, the line and the key.
void applyPlanFile(const Node& root, SweepPlan& plan);
/// Replaces an axis by what was typed: values joined by its separator. Throws UsageError naming the option.
void applyPlanOption(const SweepAxis& axis, std::string_view text, SweepPlan& plan);

/// All combinations, equal ones once, in the order of the axes; the paper's method and that of 2012 are always among them, at the first
/// step, the largest server's image and the first codec.
std::vector<Configuration> configurationsOf(const SweepPlan& plan);

/// As JSON that applyPlanFile() reads back.
nlohmann::json toJson(const SweepPlan& plan);

}  // namespace warpscope

// One way to get from a volume to a picture: what the server does, how frames travel, what the client draws.
// What sweeps measure, plots show and `auto` chooses among. Its knobs are rows (render/base/knob.h): keys, names and JSON come from them.
#pragma once

#include <cstdint>
#include <nlohmann/json_fwd.hpp>
#include <string>
#include <string_view>
#include <vector>

#include "render/codec/codec.h"
#include "render/warp/warp.h"

namespace warpscope {

class Node;

struct Configuration {
  const WarpDescriptor* technique = nullptr;
  MarchSettings march;
  uint32_t serverSidePx = 0;  ///< longer side of the server's image
  CodecSettings codec;
  KnobValues knobs;           ///< the technique's own

  /// The client's settings; ground truth is marched with `reference`.
  WarpSettings warp(const WarpSettings& base) const;
  bool operator==(const Configuration&) const = default;
};

/// Longer side of the server's image, pixels.
extern const Knob kServerSideKnob;

/// A knob that configurations have, and where they hold it.
class ConfigurationKnob {
 public:
  /// Of the marching, or (without a row) a technique's own, or kServerSideKnob.
  ConfigurationKnob(const Knob& knob, const MarchKnob* march) : knob_(&knob), march_(march) {}

  const Knob& knob() const { return *knob_; }
  double get(const Configuration& configuration) const;
  void set(Configuration& configuration, double value) const;
  /// Whether the picture of the configuration's technique depends on it.
  bool concerns(const WarpDescriptor& technique) const;
  /// Whether it does, as the configuration's other knobs are set.
  bool matters(const Configuration& configuration) const;
  /// Whether it is part of what is sent: where samples lie, how large and how many they are.
  bool isOfFrame() const { return march_ != nullptr || knob_ == &kServerSideKnob; }

 private:
  const Knob* knob_;
  const MarchKnob* march_;
};

/// Those that sweeps go through, in the order in which they nest: samples, techniques' own, the marching, the server's image.
std::vector<ConfigurationKnob> configurationKnobs();

/// Takes over those settings that its technique's picture depends on, but for what the picture is (the step and the like), which every technique's does.
void takeOver(const Configuration& configuration, MarchSettings& march, WarpSettings& warp);

/// With what the technique's picture does not depend on set to its default, so that equal work is equal.
Configuration normalized(Configuration configuration);

/// All that tells it from others of one sweep, in one line: "points heuristic=median pointSize=2 step=0.5 serverSide=512 jpeg95". Equal for those that
/// differ in nothing that sweeps go through.
std::string keyOf(const Configuration& configuration);

/// All that tells its frames from others', in one line.
std::string frameKeyOf(const Configuration& configuration);

/// As a person would name it among configurations of one sweep: "spheres, median, voxel".
std::string labelOf(const Configuration& configuration);

/// With all else that its pictures depend on: "spheres, median, voxel, 512 px, jpeg95, step 0.5".
std::string fullNameOf(const Configuration& configuration);

/// What sweeps do not go through and is not as usual: ", mode of rendering mip, lights ..."; empty where there is nothing like that.
std::string othersOf(const Configuration& configuration);

/// As labelOf, and whatever else tells it from any of `others`.
std::string nameAmong(const Configuration& configuration, const std::vector<Configuration>& others);

/// "raw", "lossless" (packed) or "jpeg95" (packed, of that quality): one word for what sweeps call a codec.
std::string codecWord(const CodecSettings& codec);
/// Back. Throws UsageError.
CodecSettings codecOfWord(std::string_view word);
/// Those words, for help and errors: "raw, lossless, jpeg1 to jpeg100".
std::string_view codecWords();

/// Its members under the names of metrics.json; what the technique does not depend on is null.
nlohmann::json toJson(const Configuration& configuration);
/// Back; settings that the JSON does not hold are those of `base`. Throws InputError.
Configuration configurationFrom(const Node& node, const MarchSettings& base);

/// The method of Zellmann 2020: spheres of half a voxel's diagonal at the steepest rise of opacity.
bool isPapersMethod(const Configuration& configuration);
/// The method of Zellmann, Aumueller, Lang 2012: points of two pixels where half the light comes from before them.
bool isPointBaseline(const Configuration& configuration);

inline constexpr Range kServerSideRange{1, kMaxImageSide};

}  // namespace warpscope

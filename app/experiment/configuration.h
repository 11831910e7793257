// One way to get from a volume to a picture: what the server does, how frames travel, what the client draws.
// What sweeps measure, plots show and `auto` chooses among. The words are those of the command line.
#pragma once

#include <cstdint>
#include <nlohmann/json.hpp>
#include <string>
#include <string_view>

#include "app/scene/json_document.h"
#include "render/codec/codec.h"
#include "render/warp/warp.h"

namespace warpscope {

struct Configuration {
  const WarpDescriptor* technique = nullptr;
  MarchSettings march;
  uint32_t serverSidePx = 0;  ///< longer side of the server's image
  CodecSettings codec;
  int pointSize = WarpSettings{}.pointSize;
  int hits = WarpSettings{}.hits;

  /// The client's knobs; ground truth is marched with `reference`.
  WarpSettings warp(const WarpSettings& base) const;
  bool operator==(const Configuration&) const = default;
};

/// Takes over those settings that its technique's picture depends on, but for the step, which every picture does.
void takeOver(const Configuration& configuration, MarchSettings& march, WarpSettings& warp);

/// With what the technique's picture does not depend on set to its default, so that equal work is equal.
Configuration normalized(Configuration configuration);

/// All that tells it from others, in one line: "points median size=2 step=0.5 side=512 jpeg95". Equal for equal configurations only.
std::string keyOf(const Configuration& configuration);

/// As a person would name it among configurations of one sweep: "spheres, median, voxel".
std::string labelOf(const Configuration& configuration);

/// "raw", "lossless" (packed) or "jpeg95" (packed, of that quality): one word for what sweeps call a codec.
std::string codecWord(const CodecSettings& codec);
/// Back. Throws UsageError.
CodecSettings codecOfWord(std::string_view word);

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

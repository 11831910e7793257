// Corners by Hounsfield units or by shares of the range.
// See transfer_presets.h.
#include "app/scene/transfer_presets.h"

#include <array>
#include <cmath>
#include <string>
#include <vector>

#include "render/base/error.h"
#include "render/core/color.h"

namespace warpscope {
namespace {

/// A corner: where it lies in Hounsfield units (not used by presets without) and as a share of the range; sRGB; opacity.
struct Corner {
  double hounsfield, share;
  float red, green, blue, alpha;
};

// Usual values of tissues, as textbooks of radiology have them: fat about -100, muscle 40 to 60, blood with contrast agent 150 to 400, spongy bone from 200 and
// cortical bone from 700 on.
constexpr std::array<Corner, 5> kBone{{{150, 0.35, 0.55f, 0.25f, 0.15f, 0.0f},
                                       {280, 0.42, 0.75f, 0.55f, 0.40f, 0.08f},
                                       {500, 0.55, 0.90f, 0.82f, 0.68f, 0.45f},
                                       {1000, 0.75, 0.97f, 0.94f, 0.86f, 0.85f},
                                       {2000, 1.00, 1.00f, 1.00f, 0.97f, 0.95f}}};
constexpr std::array<Corner, 6> kSoft{{{-160, 0.10, 0.35f, 0.18f, 0.10f, 0.0f},
                                       {-90, 0.18, 0.80f, 0.62f, 0.35f, 0.03f},
                                       {20, 0.30, 0.72f, 0.30f, 0.24f, 0.12f},
                                       {60, 0.38, 0.85f, 0.45f, 0.36f, 0.30f},
                                       {200, 0.55, 0.95f, 0.80f, 0.70f, 0.55f},
                                       {1000, 1.00, 1.00f, 0.98f, 0.92f, 0.85f}}};
constexpr std::array<Corner, 6> kAngiography{{{100, 0.40, 0.45f, 0.05f, 0.05f, 0.0f},
                                              {160, 0.50, 0.75f, 0.10f, 0.08f, 0.10f},
                                              {250, 0.62, 0.92f, 0.25f, 0.15f, 0.55f},
                                              {400, 0.75, 0.98f, 0.55f, 0.35f, 0.85f},
                                              {700, 0.88, 0.95f, 0.88f, 0.78f, 0.30f},
                                              {1500, 1.00, 1.00f, 1.00f, 0.95f, 0.60f}}};
constexpr std::array<Corner, 5> kMr{{{0, 0.08, 0.10f, 0.10f, 0.12f, 0.0f},
                                     {0, 0.20, 0.35f, 0.36f, 0.40f, 0.04f},
                                     {0, 0.45, 0.62f, 0.60f, 0.58f, 0.20f},
                                     {0, 0.75, 0.86f, 0.84f, 0.80f, 0.45f},
                                     {0, 1.00, 1.00f, 0.99f, 0.96f, 0.80f}}};
constexpr std::array<Corner, 2> kFog{{{0, 0.00, 0.92f, 0.94f, 0.97f, 0.0f}, {0, 1.00, 0.92f, 0.94f, 0.97f, 0.06f}}};
// Moreland 2009, "Diverging Color Maps for Scientific Visualization": its two ends and the grey between them, sampled.
constexpr std::array<Corner, 7> kCoolWarm{{{0, 0.00, 0.230f, 0.299f, 0.754f, 0.30f},
                                           {0, 0.17, 0.436f, 0.571f, 0.952f, 0.10f},
                                           {0, 0.33, 0.662f, 0.778f, 0.993f, 0.03f},
                                           {0, 0.50, 0.865f, 0.865f, 0.865f, 0.00f},
                                           {0, 0.67, 0.967f, 0.722f, 0.609f, 0.03f},
                                           {0, 0.83, 0.897f, 0.446f, 0.351f, 0.10f},
                                           {0, 1.00, 0.706f, 0.016f, 0.150f, 0.30f}}};
// Smith, van der Walt 2015 (matplotlib, CC0), sampled.
constexpr std::array<Corner, 7> kViridis{{{0, 0.00, 0.267f, 0.005f, 0.329f, 0.00f},
                                          {0, 0.17, 0.270f, 0.228f, 0.508f, 0.02f},
                                          {0, 0.33, 0.192f, 0.407f, 0.556f, 0.06f},
                                          {0, 0.50, 0.128f, 0.567f, 0.551f, 0.14f},
                                          {0, 0.67, 0.208f, 0.719f, 0.473f, 0.28f},
                                          {0, 0.83, 0.565f, 0.842f, 0.263f, 0.50f},
                                          {0, 1.00, 0.993f, 0.906f, 0.144f, 0.80f}}};

constexpr std::array<TransferPreset, 7> kPresets{{
    {"CT bone", "Bone, from spongy to compact; the rest is not seen"},
    {"CT soft tissue", "Skin, fat and muscle before bone"},
    {"CT angiography", "Vessels with contrast agent, bone faintly behind them"},
    {"MR", "Grey, opaque where the signal is strong"},
    {"Fog", "The same faint white everywhere: how much there is along a ray"},
    {"Cool-warm", "Blue below the middle and red above it, both opaque at the ends (Moreland 2009)"},
    {"Viridis", "Dark violet to yellow, equally bright steps for every eye (Smith, van der Walt 2015)"},
}};

struct PresetCorners {
  std::span<const Corner> corners;
  bool isOfTomography = false;
};
PresetCorners cornersOf(std::string_view name) {
  if (name == kPresets[0].name) return {kBone, true};
  if (name == kPresets[1].name) return {kSoft, true};
  if (name == kPresets[2].name) return {kAngiography, true};
  if (name == kPresets[3].name) return {kMr};
  if (name == kPresets[4].name) return {kFog};
  if (name == kPresets[5].name) return {kCoolWarm};
  if (name == kPresets[6].name) return {kViridis};
  throw UsageError("there is no transfer function named '" + std::string(name) + "'");
}

}  // namespace

std::span<const TransferPreset> transferPresets() { return kPresets; }

bool areHounsfield(const VoxelStatistics& statistics) { return statistics.lowest < -500.0 && statistics.highest > 500.0 && statistics.highest < 40000.0; }

bool isSpread(std::string_view name, const VoxelStatistics& statistics) { return cornersOf(name).isOfTomography && !areHounsfield(statistics); }

TransferFunction presetFunction(std::string_view name, const VoxelStatistics& statistics) {
  const PresetCorners preset = cornersOf(name);
  const bool isByUnits = preset.isOfTomography && !isSpread(name, statistics);
  TransferFunction function;
  for (const Corner& corner : preset.corners) {
    const double value = isByUnits ? corner.hounsfield : std::lerp(statistics.rangeLower, statistics.rangeUpper, corner.share);
    function.points.push_back({value, {linearFromSrgb(corner.red), linearFromSrgb(corner.green), linearFromSrgb(corner.blue)}, corner.alpha});
  }
  return function;
}

}  // namespace warpscope

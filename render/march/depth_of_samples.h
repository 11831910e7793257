// Depths of rays whose samples that count are at hand, or have been folded as they came. Host only.
// The heuristics: depth_heuristic.h.
#pragma once

#include <vector>

#include "render/march/ray_relay.h"

namespace warpscope {

using DepthFunction = DepthResult (*)(const std::vector<CountingSample>&, float threshold);

/// Depth of a finished ray or part of one. The argument holds every sample that counted: a second pass folds over them again.
DepthFunction depthFunctionOf(Heuristic heuristic, bool hasSecondPass);

/// How far samples are spread along their ray, whatever depth stands for them.
float spreadOf(const std::vector<CountingSample>& counting);

/// What stands for samples that count, and how far they are spread about it if the plan has that.
struct DepthOfSamples {
  DepthFunction depth = nullptr;
  float threshold = 0.0f;
  bool hasSpread = false;

  DepthResult operator()(const std::vector<CountingSample>& counting) const {
    DepthResult result = depth(counting, threshold);
    if (hasSpread) result.spread = spreadOf(counting);
    return result;
  }
};

/// Whether a heuristic needs no second pass, so that samples can be folded as they come.
bool hasOnePass(Heuristic heuristic);

/// What a ray comes to that was handed on and has one sample at most: as its folds have it if anything was folded, else by its list. `premultiplied`: its light.
void findSampleOf(const RelayedRay& ray, const DepthOfSamples& ofList, Heuristic heuristic, const glm::vec4& premultiplied, RaySamples& found);

}  // namespace warpscope

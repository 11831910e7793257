// Frames of several samples a ray, put together from frames of one: what a marcher of several would make.
// Where they lie is real: several heuristics' choices along the very same rays.
#pragma once

#include <algorithm>
#include <cmath>
#include <span>
#include <string>
#include <vector>

#include "render/march/marcher.h"

namespace warpscope {

/// A plane named `name` of these values.
template <class Value>
SamplePlane planeOf(std::string_view name, PlaneElement element, std::span<const Value> values) {
  SamplePlane plane{std::string(name), element, {}};
  const std::span<const std::byte> bytes = std::as_bytes(values);
  plane.values.assign(bytes.begin(), bytes.end());
  return plane;
}

inline SamplePlane layerPlane(const std::vector<uint8_t>& layers) {
  return planeOf(kLayerPlane, PlaneElement::uint8, std::span(layers));
}

/// March once for each of `heuristics`; each ray's samples, near to far, those at the same place once. Their colours over one another are
/// nearly the ray's. With one heuristic it is the frame that the marcher makes, without layers.
inline SampleFrame marchLayers(Marcher& marcher, const Camera& camera, MarchSettings settings, std::span<const Heuristic> heuristics) {
  std::vector<SampleFrame> fronts;
  for (const Heuristic heuristic : heuristics) {
    settings.sample.heuristic = heuristic;
    fronts.push_back(marcher.march(camera, settings));
  }
  SampleFrame frame = fronts.front();
  if (fronts.size() == 1) return frame;
  frame.samples.clear();
  frame.colors.clear();
  std::vector<uint8_t> layers;
  for (size_t ray = 0; ray < fronts.front().size(); ++ray) {
    std::vector<std::pair<float, PackedSample>> along;
    for (const SampleFrame& front : fronts)
      along.emplace_back(decodeDepth(depthCode(front.samples[ray]), front.quantization.depthStep), front.samples.at(ray));
    std::ranges::sort(along);
    along.erase(std::unique(along.begin(), along.end()), along.end());
    const Rgba8 color = fronts.front().colors[ray];
    const float clear = std::pow(1.0f - static_cast<float>(color >> 24) / 255.0f, 1.0f / static_cast<float>(along.size()));
    for (size_t k = 0; k < along.size(); ++k) {
      frame.samples.push_back(along[k].second);
      frame.colors.push_back((color & 0xffffffu) | quantizeUnorm8(1.0f - clear) << 24);
      layers.push_back(static_cast<uint8_t>(k));
    }
  }
  frame.planes.push_back(layerPlane(layers));
  frame.settings.sample.samplesPerRay = static_cast<int>(heuristics.size());
  return frame;
}

}  // namespace warpscope

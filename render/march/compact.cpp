// Parallel compaction.
// See compact.h.
#include "render/march/compact.h"

#include <algorithm>
#include <vector>

#include "render/core/parallel.h"

namespace warpscope {

void setLayers(TransferVector<std::byte> layers, SampleFrame& frame) {
  std::erase_if(frame.planes, [](const SamplePlane& plane) { return plane.name == kLayerPlane; });
  if (std::all_of(layers.begin(), layers.end(), [](std::byte layer) { return layer == std::byte{0}; })) return;
  frame.planes.push_back({std::string(kLayerPlane), PlaneElement::uint8, std::move(layers)});
}

void compact(std::span<const PackedSample> samples, std::span<const Rgba8> colors, size_t slots, SampleFrame& frame) {
  constexpr size_t kBlock = 1 << 14;
  const size_t blocks = (samples.size() + kBlock - 1) / kBlock;
  std::vector<size_t> offsets(blocks + 1, 0);
  parallelForRanges(blocks, 1, [&](size_t begin, size_t end) {
    for (size_t block = begin; block < end; ++block) {
      const size_t last = std::min(samples.size(), (block + 1) * kBlock);
      size_t kept = 0;
      for (size_t i = block * kBlock; i < last; ++i) kept += radiusCode(samples[i]) != 0;
      offsets[block + 1] = kept;
    }
  });
  for (size_t block = 0; block < blocks; ++block) offsets[block + 1] += offsets[block];
  frame.samples.resize(offsets[blocks]);
  frame.colors.resize(offsets[blocks]);
  TransferVector<std::byte> layers;
  if (slots > 1) layers.resize(offsets[blocks]);
  parallelForRanges(blocks, 1, [&](size_t begin, size_t end) {
    for (size_t block = begin; block < end; ++block) {
      const size_t last = std::min(samples.size(), (block + 1) * kBlock);
      size_t out = offsets[block];
      for (size_t i = block * kBlock; i < last; ++i) {
        if (radiusCode(samples[i]) == 0) continue;
        frame.samples[out] = samples[i];
        frame.colors[out] = colors[i];
        if (slots > 1) layers[out] = static_cast<std::byte>(i % slots);
        ++out;
      }
    }
  });
  setLayers(std::move(layers), frame);
}

}  // namespace warpscope

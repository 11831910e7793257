// Parallel compaction.
// See compact.h.
#include "render/march/compact.h"

#include <algorithm>
#include <bit>
#include <cstring>
#include <vector>

#include "render/core/parallel.h"

namespace warpscope {

namespace {

void dropPlane(std::string_view name, SampleFrame& frame) {
  std::erase_if(frame.planes, [&](const SamplePlane& plane) { return plane.name == name; });
}

/// A float's sign and exponent and 7 bits of its fraction are its upper half; carries go where they should, and infinity is far.
float roundedSpread(float spread) { return std::bit_cast<float>((std::bit_cast<uint32_t>(spread) + 0x8000u) & 0xffff0000u); }

}  // namespace

void setSpreads(TransferVector<std::byte> spreads, SampleFrame& frame) {
  dropPlane(kSpreadPlane, frame);
  parallelForRanges(spreads.size() / sizeof(float), 1 << 16, [&](size_t begin, size_t end) {
    for (size_t i = begin; i < end; ++i) {
      std::byte* const place = spreads.data() + i * sizeof(float);
      float spread;
      std::memcpy(&spread, place, sizeof spread);
      spread = roundedSpread(spread);
      std::memcpy(place, &spread, sizeof spread);
    }
  });
  frame.planes.push_back({std::string(kSpreadPlane), PlaneElement::float32, std::move(spreads)});
}

void setLayers(TransferVector<std::byte> layers, SampleFrame& frame) {
  dropPlane(kLayerPlane, frame);
  if (std::all_of(layers.begin(), layers.end(), [](std::byte layer) { return layer == std::byte{0}; })) return;
  frame.planes.push_back({std::string(kLayerPlane), PlaneElement::uint8, std::move(layers)});
}

void compact(const DenseSegments& dense, FrameSegments& segments) {
  segments.rays = dense.rays;
  constexpr size_t kBlock = 1 << 12;
  const size_t blocks = (dense.rays.size() + kBlock - 1) / kBlock;
  std::vector<size_t> offsets(blocks + 1, 0);
  const auto endOf = [&](size_t block) { return std::min(dense.rays.size(), (block + 1) * kBlock); };
  parallelForRanges(blocks, 1, [&](size_t begin, size_t end) {
    for (size_t block = begin; block < end; ++block)
      for (size_t pixel = block * kBlock; pixel < endOf(block); ++pixel) offsets[block + 1] += static_cast<size_t>(dense.rays[pixel].count());
  });
  for (size_t block = 0; block < blocks; ++block) offsets[block + 1] += offsets[block];
  segments.depths.resize(offsets[blocks]);
  segments.colors.resize(offsets[blocks]);
  segments.normals.resize(dense.normals.empty() ? 0 : offsets[blocks]);
  parallelForRanges(blocks, 1, [&](size_t begin, size_t end) {
    for (size_t block = begin; block < end; ++block) {
      size_t out = offsets[block];
      for (size_t pixel = block * kBlock; pixel < endOf(block); ++pixel)
        for (int i = 0; i < dense.rays[pixel].count(); ++i, ++out) {
          const size_t place = pixel * static_cast<size_t>(dense.slots) + static_cast<size_t>(i);
          segments.depths[out] = dense.depths[place];
          segments.colors[out] = dense.colors[place];
          if (!dense.normals.empty()) segments.normals[out] = dense.normals[place];
        }
    }
  });
}

void compact(std::span<const PackedSample> samples, std::span<const Rgba8> colors, size_t slots, SampleFrame& frame) {
  compact(samples, colors, {}, slots, frame);
}

void compact(std::span<const PackedSample> samples, std::span<const Rgba8> colors, std::span<const float> spreads, size_t slots, SampleFrame& frame) {
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
  TransferVector<std::byte> keptSpreads;
  if (!spreads.empty()) keptSpreads.resize(offsets[blocks] * sizeof(float));
  parallelForRanges(blocks, 1, [&](size_t begin, size_t end) {
    for (size_t block = begin; block < end; ++block) {
      const size_t last = std::min(samples.size(), (block + 1) * kBlock);
      size_t out = offsets[block];
      for (size_t i = block * kBlock; i < last; ++i) {
        if (radiusCode(samples[i]) == 0) continue;
        frame.samples[out] = samples[i];
        frame.colors[out] = colors[i];
        if (slots > 1) layers[out] = static_cast<std::byte>(i % slots);
        if (!spreads.empty()) std::memcpy(keptSpreads.data() + out * sizeof(float), &spreads[i], sizeof(float));
        ++out;
      }
    }
  });
  setLayers(std::move(layers), frame);
  if (!spreads.empty()) setSpreads(std::move(keptSpreads), frame);
}

}  // namespace warpscope

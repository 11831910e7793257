// Packing.
// See finished_ray.h.
#include "render/march/finished_ray.h"

#include <algorithm>

#include "render/march/segment_encoder.h"

namespace warpscope {
namespace {

/// The ray's segments into its pixel's places; their number.
RaySegmentCount storeSegments(const SampleRule& rule, const FinishedRay& ray, DenseSegments& dense, size_t pixel) {
  const size_t first = pixel * static_cast<size_t>(dense.slots);
  if (ray.encoded != nullptr) {
    const auto count = static_cast<size_t>(ray.encoded->count);
    std::copy_n(ray.encoded->depths, count, &dense.depths[first]);
    std::copy_n(ray.encoded->colors, count, &dense.colors[first]);
    if (!dense.normals.empty()) std::copy_n(ray.encoded->normals, count, &dense.normals[first]);
    return {ray.encoded->count, ray.isEnded};
  }
  if (ray.segments == nullptr) return {};
  const SegmentEncoder encoder(ColorTables::instance(), rule.quantization, ray.cosine, !dense.normals.empty());
  const SegmentSlots slots{dense.depths.data() + first, dense.colors.data() + first, dense.normals.empty() ? nullptr : dense.normals.data() + first};
  return storeSegments(*ray.segments, ray.isEnded, encoder, slots, [&](int i) { return ray.normals != nullptr ? ray.normals[i] : NormalCode{0}; });
}

}  // namespace

void DenseRays::put(size_t pixel, const FinishedRay& ray, const SampleRule& rule, const PixelGrid& pixels) {
  const int found = ray.samples != nullptr ? ray.samples->size() : 0;
  for (size_t slot = 0; slot < slots; ++slot) {
    const size_t place = pixel * slots + slot;
    samples[place] = 0;
    if (static_cast<int>(slot) >= found) continue;
    const RaySample& sample = (*ray.samples)[static_cast<int>(slot)];
    samples[place] = packRaySample(rule, pixels, ray.x, ray.y, ray.cosine, sample.depth, sample.color.a);
    colors[place] = ColorTables::instance().encode(sample.color);
    if (!spreads.empty()) spreads[place] = sample.depth.spread;
  }
  if (segments.slots > 0) segments.rays[pixel] = storeSegments(rule, ray, segments, pixel);
}

void DenseRays::take(size_t pixel, const DenseRays& other, size_t from) {
  const auto copy = [&](const auto& source, auto& target, size_t each) {
    if (!target.empty()) std::copy_n(source.begin() + static_cast<std::ptrdiff_t>(from * each), each, target.begin() + static_cast<std::ptrdiff_t>(pixel * each));
  };
  copy(other.samples, samples, slots);
  copy(other.colors, colors, slots);
  copy(other.spreads, spreads, slots);
  const auto segmentSlots = static_cast<size_t>(segments.slots);
  copy(other.segments.rays, segments.rays, 1);
  copy(other.segments.depths, segments.depths, segmentSlots);
  copy(other.segments.colors, segments.colors, segmentSlots);
  copy(other.segments.normals, segments.normals, segmentSlots);
}

}  // namespace warpscope

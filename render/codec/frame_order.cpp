// See frame_order.h.
#include "render/codec/frame_order.h"

#include <algorithm>
#include <atomic>
#include <string>

#include "render/base/error.h"
#include "render/codec/segment_coding.h"
#include "render/core/parallel.h"
#include "render/core/picture_size.h"

namespace warpscope {

bool countUp(std::span<const uint8_t> layers, int samplesPerRay) {
  if (layers.empty()) return true;
  if (samplesPerRay < 1) return false;
  const auto last = static_cast<uint8_t>(std::min(samplesPerRay, static_cast<int>(kSamplesPerRayRange.highest)) - 1);
  std::atomic<bool> doAll = layers.front() == 0;
  parallelForRanges(layers.size() - 1, 1 << 16, [&](size_t begin, size_t end) {
    // Bytes alone, in locals: many at once.
    const uint8_t* const layer = layers.data();
    const uint8_t most = last;
    uint8_t faults = 0;
    for (size_t i = begin; i < end; ++i) {
      const uint8_t own = layer[i + 1], next = static_cast<uint8_t>(layer[i] + 1);
      faults |= static_cast<uint8_t>((own != 0 && own != next) || own > most);
    }
    if (faults != 0) doAll = false;
  });
  return doAll;
}

bool areInOrder(const SampleFrame& frame) {
  const Camera& camera = frame.camera;
  if (frame.size() == 0) return true;
  if (camera.width > kMaxImageSide || camera.height > kMaxImageSide) return false;
  const std::span<const uint8_t> layers = frame.layers();
  std::atomic<bool> areAll = columnOf(frame.samples.front()) < camera.width && rowOf(frame.samples.back()) < camera.height;
  parallelForRanges(frame.size() - 1, 1 << 16, [&](size_t begin, size_t end) {
    // Words alone, in locals: many at once.
    const PackedSample* const sample = frame.samples.data();
    const uint32_t width = camera.width;
    uint32_t faults = 0;
    if (layers.empty()) {
      for (size_t i = begin; i < end; ++i) {
        const uint32_t last = pixelKey(sample[i]), own = pixelKey(sample[i + 1]);
        faults |= (own <= last ? 1u : 0u) | (columnOf(sample[i + 1]) >= width ? 1u : 0u);
      }
    } else {
      const uint8_t* const layer = layers.data();
      for (size_t i = begin; i < end; ++i) {
        const uint32_t last = pixelKey(sample[i]), own = pixelKey(sample[i + 1]), begins = layer[i + 1] == 0 ? 1u : 0u;
        faults |= (own < last + begins ? 1u : 0u) | ((begins ^ 1u) & (own != last ? 1u : 0u)) | (columnOf(sample[i + 1]) >= width ? 1u : 0u);
      }
    }
    if (faults != 0) areAll = false;
  });
  return areAll;
}

void requireConsistent(const SampleFrame& frame) {
  if (frame.samples.size() != frame.colors.size()) throw InputError("a frame must have a colour for each sample");
  if (frame.planes.size() > kMaxPlanes) throw InputError("a frame must have at most " + std::to_string(kMaxPlanes) + " planes");
  for (const SamplePlane& plane : frame.planes) {
    if (plane.name.empty() || plane.name.size() > kMaxPlaneName)
      throw InputError("a plane's name must have 1 to " + std::to_string(kMaxPlaneName) + " bytes, not \"" + plane.name + "\"");
    if (&plane != frame.plane(plane.name)) throw InputError("a frame must not have two planes named \"" + plane.name + "\"");
    if (bytesOf(plane.element) == 0 || plane.values.size() != frame.size() * bytesOf(plane.element))
      throw InputError("the frame's plane \"" + plane.name + "\" must have a value for each sample");
  }
  if (!countUp(frame.layers(), frame.settings.sample.samplesPerRay))
    throw InputError("a frame's layers must count up along each ray, from 0, to less than its settings' samplesPerRay");
  requireConsistentSegments(frame);
  if (!areInOrder(frame)) throw InputError("a frame's rays must be in pixels of its picture, each in one of its own, in their order");
}

}  // namespace warpscope

// Places along pixels' rays. Loops are kept plain, without branches, so that compilers turn them into vector code.
// See pixel_path.h.
#include "render/codec/pixel_path.h"

#include <algorithm>
#include <array>
#include <limits>

#include "render/codec/step_counts.h"

namespace warpscope {

void PixelPaths::narrow(std::span<const uint32_t> kept) {
  const auto keep = [&](auto& values) {
    for (size_t k = 0; k < kept.size(); ++k) values[k] = values[kept[k]];
    values.resize(kept.size());
  };
  keep(origin_);
  if (placement_ == Placement::depth) return;
  for (TransferVector<float>* values : {&cosine_, &t0_, &length_}) keep(*values);
  keep(count_);
}

void PixelPaths::aim(const SampleFrame& frame, Placement placement, std::span<const uint32_t> columns, std::span<const uint32_t> rows) {
  placement_ = placement;
  step_ = frame.settings.render.step;
  depthStep_ = frame.quantization.depthStep;
  fineBits_ = 0;
  const size_t count = columns.size();
  origin_.resize(count);
  if (placement == Placement::depth) {
    std::fill(origin_.begin(), origin_.end(), 0);
    return;
  }
  fineBits_ = fineBitsOf(placement);
  for (auto* values : {&cosine_, &t0_, &length_}) values->resize(count);
  count_.resize(count);
  // Loops read and write through locals only: what they write cannot be what they read then.
  const PixelGrid grid = makePixelGrid(frame.camera, frame.quantization.nearDepth);
  const Box bounds = frame.quantization.bounds;
  float* const cosines = cosine_.data();
  const uint32_t* const column = columns.data();
  const uint32_t* const row = rows.data();
  float* const t0s = t0_.data();
  float* const lengths = length_.data();
  int32_t* const counts = count_.data();
  int32_t* const placeOrigins = origin_.data();
  const float step = step_;
  const Jitter jitter = jitterFor(frame.settings.render);
  constexpr size_t kAtOnce = 512;  // whose values stay in the nearest cache from one loop to the next
  using Coordinates = std::array<std::array<float, kAtOnce>, 3>;
  Coordinates from, direction;  // of rays
  for (size_t begin = 0; begin < count; begin += kAtOnce) {
    const size_t end = std::min(begin + kAtOnce, count);
    // Two loops: of one with seven results GCC 12 makes no vectors.
    for (size_t k = begin; k < end; ++k) {
      const PixelRay pixel = grid.ray(column[k], row[k]);
      direction[0][k - begin] = pixel.ray.direction.x;
      direction[1][k - begin] = pixel.ray.direction.y;
      direction[2][k - begin] = pixel.ray.direction.z;
      cosines[k] = pixel.cosine;
    }
    for (size_t k = begin; k < end; ++k) {
      const glm::vec3 origin = grid.ray(column[k], row[k]).ray.origin;
      from[0][k - begin] = origin.x;
      from[1][k - begin] = origin.y;
      from[2][k - begin] = origin.z;
    }
    // intersectBox, axis by axis.
    std::fill(t0s + begin, t0s + end, 0.0f);
    std::fill(lengths + begin, lengths + end, bounds.isEmpty() ? -1.0f : std::numeric_limits<float>::infinity());
    for (int axis = 0; axis < 3; ++axis) {
      const float *const origins = from[axis].data(), *const directions = direction[axis].data();
      const float lower = bounds.lower[axis], upper = bounds.upper[axis];
      for (size_t k = begin; k < end; ++k) {
        RayInterval inside{t0s[k], lengths[k]};
        clipToSlab(inside, origins[k - begin], reciprocalOf(directions[k - begin]), lower, upper);
        t0s[k] = inside.tNear;
        lengths[k] = inside.tFar;
      }
    }
    for (size_t k = begin; k < end; ++k) {
      const PixelPath path = pathInside({t0s[k], lengths[k]}, 1.0f, step, jitter.shiftOf(column[k], row[k]));
      t0s[k] = path.t0;
      lengths[k] = path.length;
      placeOrigins[k] = path.origin;
    }
    countSteps({lengths + begin, end - begin}, step, {counts + begin, end - begin});
  }
}

void PixelPaths::locate(std::span<const PackedSample> samples, std::span<int32_t> places) const {
  const size_t count = samples.size();
  const PackedSample* const sample = samples.data();
  int32_t* const out = places.data();
  if (placement_ == Placement::depth) {
    for (size_t k = 0; k < count; ++k) out[k] = static_cast<int32_t>(depthCode(sample[k]));
    return;
  }
  const bool isHalf = placement_ == Placement::halfSteps;
  const float step = step_;
  const float depthStep = depthStep_;
  const float* const cosines = cosine_.data();
  const float* const t0s = t0_.data();
  const int32_t* const counts = count_.data();
  for (size_t k = 0; k < count; ++k)
    out[k] = placeOnPath({cosines[k], t0s[k], 0.0f, counts[k], 0}, depthCode(sample[k]), step, depthStep, isHalf);
}

void PixelPaths::locateBorders(std::span<const uint32_t> depthCodes, std::span<int32_t> places) const {
  const size_t count = depthCodes.size();
  const uint32_t* const code = depthCodes.data();
  int32_t* const out = places.data();
  if (placement_ == Placement::depth) {
    for (size_t k = 0; k < count; ++k) out[k] = static_cast<int32_t>(code[k]);
    return;
  }
  const float step = step_, depthStep = depthStep_;
  const float* const cosines = cosine_.data();
  const float* const t0s = t0_.data();
  const float* const lengths = length_.data();
  const int32_t* const counts = count_.data();
  for (size_t k = 0; k < count; ++k)
    out[k] = borderOnPath({cosines[k], t0s[k], lengths[k], counts[k], 0}, code[k], step, depthStep);
}

void PixelPaths::place(std::span<const int32_t> places, std::span<uint32_t> depthCodes) const {
  const size_t count = places.size();
  const int32_t* const place = places.data();
  uint32_t* const out = depthCodes.data();
  if (placement_ == Placement::depth) {
    for (size_t k = 0; k < count; ++k) out[k] = static_cast<uint32_t>(place[k]) & kDepthCodeMax;
    return;
  }
  const float step = step_, depthStep = depthStep_;
  const float* const cosines = cosine_.data();
  const float* const t0s = t0_.data();
  const float* const lengths = length_.data();
  const int32_t* const counts = count_.data();
  const auto placeAll = [&](auto depthOf) {
    for (size_t k = 0; k < count; ++k) {
      const RayLattice lattice{t0s[k], lengths[k], step, counts[k]};
      out[k] = encodeDepth(depthOf(lattice, place[k], glm::max(lattice.count - 1, 0)) * cosines[k], depthStep);
    }
  };
  if (placement_ == kBorders) return placeAll([](const RayLattice& lattice, int i, int last) { return borderDepth(lattice, i, last); });
  if (placement_ == Placement::halfSteps)
    placeAll([](const RayLattice& lattice, int halves, int last) { return halfStepDepth(lattice, halves, last); });
  else
    placeAll([](const RayLattice& lattice, int i, int last) { return stepDepth(lattice, i, last); });
}

}  // namespace warpscope

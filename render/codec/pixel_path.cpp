// Places along pixels' rays. Loops are kept plain, without branches, so that compilers turn them into vector code.
// See pixel_path.h.
#include "render/codec/pixel_path.h"

#include <algorithm>
#include <cmath>

#include "render/march/lattice.h"

namespace warpscope {
namespace {

constexpr int kStepFineBits = 4;

/// As RayLattice::t on a machine that fuses multiplication and addition, on every machine.
inline float latticeDepth(const RayLattice& lattice, int i) {
  const float inside = std::fma(static_cast<float>(i) + 0.5f, lattice.dt, lattice.t0);
  const float last = lattice.t0 + (lattice.length - 0.5f * lattice.stepLength(i));
  return i + 1 < lattice.count ? inside : last;
}

inline int clamped(float value, int largest) {
  if (!(value > 0.0f)) return 0;  // NaN too
  return value < static_cast<float>(largest) ? static_cast<int>(value) : largest;
}

/// The component of `axis`, without an address that depends on it.
inline float chosen(int axis, float x, float y, float z) { return axis == 0 ? x : axis == 1 ? y : z; }

}  // namespace

void PixelPaths::aim(const SampleFrame& frame, Placement placement, std::span<const uint32_t> columns, std::span<const uint32_t> rows) {
  camera_ = frame.camera;
  quantization_ = frame.quantization;
  placement_ = placement;
  step_ = frame.settings.render.step;
  const size_t count = columns.size();
  x_.resize(count);
  y_.resize(count);
  z_.resize(count);
  origin_.resize(count);
  axis_.resize(count);
  // Loops read and write through locals only: what they write cannot be what they read then.
  const Camera camera = frame.camera;
  const Box bounds = frame.quantization.bounds;
  float* const xs = x_.data();
  float* const ys = y_.data();
  float* const zs = z_.data();
  int32_t* const origins = origin_.data();
  int32_t* const axes = axis_.data();
  const uint32_t* const column = columns.data();
  const uint32_t* const row = rows.data();
  for (size_t k = 0; k < count; ++k) {
    const Ray ray = pixelRay(camera, {static_cast<float>(column[k]) + 0.5f, static_cast<float>(row[k]) + 0.5f});
    xs[k] = ray.direction.x;
    ys[k] = ray.direction.y;
    zs[k] = ray.direction.z;
  }
  fineBits_ = 0;
  isOneKind_ = true;
  if (placement == Placement::axis) {
    const glm::vec3 extent = bounds.extent();
    const float rateX = extent.x > 0.0f ? 1.0f / extent.x : 0.0f, rateY = extent.y > 0.0f ? 1.0f / extent.y : 0.0f,
                rateZ = extent.z > 0.0f ? 1.0f / extent.z : 0.0f;
    for (size_t k = 0; k < count; ++k) {
      const float byX = std::abs(xs[k]) * rateX, byY = std::abs(ys[k]) * rateY, byZ = std::abs(zs[k]) * rateZ;
      const int32_t ofXY = byX >= byY ? 0 : 1;
      axes[k] = glm::max(byX, byY) >= byZ ? ofXY : 2;
      origins[k] = 0;
    }
    const int32_t first = count > 0 ? axes[0] : 0;
    int32_t differing = 0;
    for (size_t k = 0; k < count; ++k) differing |= axes[k] ^ first;
    isOneKind_ = differing == 0;
    return;
  }
  fineBits_ = placement == Placement::steps ? kStepFineBits : kStepFineBits - 1;
  t0_.resize(count);
  length_.resize(count);
  count_.resize(count);
  const float step = step_;
  const float finePerUnit = static_cast<float>(1 << kStepFineBits) / step;
  float* const t0s = t0_.data();
  float* const lengths = length_.data();
  int32_t* const counts = count_.data();
  // intersectBox, axis by axis.
  std::fill_n(t0s, count, 0.0f);
  std::fill_n(lengths, count, bounds.isEmpty() ? -1.0f : std::numeric_limits<float>::infinity());
  for (int axis = 0; axis < 3; ++axis) {
    const float* const directions = axis == 0 ? xs : axis == 1 ? ys : zs;
    const float origin = camera.eye[axis], lower = bounds.lower[axis], upper = bounds.upper[axis];
    for (size_t k = 0; k < count; ++k) {
      RayInterval inside{t0s[k], lengths[k]};
      clipToSlab(inside, origin, reciprocalOf(directions[k]), lower, upper);
      t0s[k] = inside.tNear;
      lengths[k] = inside.tFar;
    }
  }
  for (size_t k = 0; k < count; ++k) {
    const RayLattice lattice = makeLattice({t0s[k], lengths[k]}, step);
    t0s[k] = lattice.t0;
    lengths[k] = lattice.length;
    counts[k] = lattice.count;
    origins[k] = clamped(lattice.t0 * finePerUnit + 0.5f, 1 << 24);
    axes[k] = 0;
  }
}

void PixelPaths::locate(std::span<const PackedSample> samples, std::span<int32_t> places) const {
  const size_t count = samples.size();
  const PackedSample* const sample = samples.data();
  int32_t* const out = places.data();
  if (placement_ == Placement::axis) {
    const int32_t* const axes = axis_.data();
    for (size_t k = 0; k < count; ++k)
      out[k] = static_cast<int32_t>(sample[k] >> static_cast<int64_t>(kPositionBits) * axes[k] & kPositionMax);
    return;
  }
  const bool isHalf = placement_ == Placement::halfSteps;
  const float perStep = (isHalf ? 2.0f : 1.0f) / step_;
  const float offset = isHalf ? -0.5f : 0.0f;  // a half step is rounded to; a step's middle lies between integers
  const Box bounds = quantization_.bounds;
  const glm::vec3 eye = camera_.eye;
  const float* const xs = x_.data();
  const float* const ys = y_.data();
  const float* const zs = z_.data();
  const float* const t0s = t0_.data();
  const int32_t* const counts = count_.data();
  for (size_t k = 0; k < count; ++k) {
    const glm::vec3 behind = unpackPosition(sample[k], bounds) - eye;
    const float t = behind.x * xs[k] + behind.y * ys[k] + behind.z * zs[k];
    const int last = glm::max(glm::min(counts[k], kMaxSamplesPerRay / 2) - 1, 0);
    out[k] = clamped((t - t0s[k]) * perStep + offset, isHalf ? 2 * last : last);
  }
}

void PixelPaths::place(std::span<const int32_t> places, std::span<PackedSample> positions, std::span<float> depths) const {
  const size_t count = places.size();
  const Box bounds = quantization_.bounds;
  const glm::vec3 eye = camera_.eye;
  const int32_t* const place = places.data();
  PackedSample* const out = positions.data();
  float* const depth = depths.data();
  const float* const xs = x_.data();
  const float* const ys = y_.data();
  const float* const zs = z_.data();
  if (placement_ == Placement::axis) {
    const int32_t* const axes = axis_.data();
    const glm::vec3 lower = bounds.lower, upper = bounds.upper;
    for (size_t k = 0; k < count; ++k) {
      const int32_t axis = axes[k];
      const float own = dequantizeCoordinate(static_cast<uint32_t>(place[k]) & kPositionMax, chosen(axis, lower.x, lower.y, lower.z),
                                             chosen(axis, upper.x, upper.y, upper.z));
      depth[k] = (own - chosen(axis, eye.x, eye.y, eye.z)) / chosen(axis, xs[k], ys[k], zs[k]);
    }
    for (size_t k = 0; k < count; ++k) {
      const Ray ray{eye, {xs[k], ys[k], zs[k]}};
      out[k] = packPosition(ray.at(depth[k]), bounds);
    }
    for (size_t k = 0; k < count; ++k) {
      const uint64_t code = static_cast<uint32_t>(place[k]) & kPositionMax;
      const int32_t shift = static_cast<int32_t>(kPositionBits) * axes[k];
      out[k] = (out[k] & ~(uint64_t{kPositionMax} << shift)) | code << shift;
    }
    return;
  }
  const float step = step_;
  const bool isHalf = placement_ == Placement::halfSteps;
  const float* const t0s = t0_.data();
  const float* const lengths = length_.data();
  const int32_t* const counts = count_.data();
  const auto placeAll = [&](auto depthOf) {
    for (size_t k = 0; k < count; ++k) {
      const Ray ray{eye, {xs[k], ys[k], zs[k]}};
      const RayLattice lattice{t0s[k], lengths[k], step, counts[k]};
      const float t = depthOf(lattice, place[k], glm::max(lattice.count - 1, 0));
      out[k] = packPosition(ray.at(t), bounds);
      depth[k] = t;
    }
  };
  if (isHalf)
    placeAll([](const RayLattice& lattice, int halves, int last) {
      const int first = glm::clamp(halves >> 1, 0, last), second = glm::clamp(first + (halves & 1), 0, last);
      return 0.5f * (latticeDepth(lattice, first) + latticeDepth(lattice, second));
    });
  else
    placeAll([](const RayLattice& lattice, int i, int last) { return latticeDepth(lattice, glm::clamp(i, 0, last)); });
}

}  // namespace warpscope

// Places along pixels' rays. Loops are kept plain, without branches, so that compilers turn them into vector code.
// See pixel_path.h.
#include "render/codec/pixel_path.h"

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

inline PackedSample packPosition(const glm::vec3& position, const Box& bounds) {
  const uint64_t x = quantizeCoordinate(position.x, bounds.lower.x, bounds.upper.x);
  const uint64_t y = quantizeCoordinate(position.y, bounds.lower.y, bounds.upper.y);
  const uint64_t z = quantizeCoordinate(position.z, bounds.lower.z, bounds.upper.z);
  return x | y << 18 | z << 36;
}

}  // namespace

void PixelPaths::aim(const SampleFrame& frame, Placement placement, std::span<const uint32_t> columns, std::span<const uint32_t> rows) {
  camera_ = frame.camera;
  quantization_ = frame.quantization;
  placement_ = placement;
  step_ = frame.settings.step;
  const size_t count = columns.size();
  x_.resize(count);
  y_.resize(count);
  z_.resize(count);
  origin_.resize(count);
  axis_.resize(count);
  const Camera camera = camera_;
  for (size_t k = 0; k < count; ++k) {
    const Ray ray = pixelRay(camera, {static_cast<float>(columns[k]) + 0.5f, static_cast<float>(rows[k]) + 0.5f});
    x_[k] = ray.direction.x;
    y_[k] = ray.direction.y;
    z_[k] = ray.direction.z;
  }
  fineBits_ = 0;
  if (placement == Placement::axis) {
    const glm::vec3 extent = quantization_.bounds.extent();
    glm::vec3 rate(0.0f);
    for (int axis = 0; axis < 3; ++axis) rate[axis] = extent[axis] > 0.0f ? 1.0f / extent[axis] : 0.0f;
    for (size_t k = 0; k < count; ++k) {
      const float byX = std::abs(x_[k]) * rate.x, byY = std::abs(y_[k]) * rate.y, byZ = std::abs(z_[k]) * rate.z;
      axis_[k] = byX >= byY ? (byX >= byZ ? 0 : 2) : (byY >= byZ ? 1 : 2);
      origin_[k] = 0;
    }
    return;
  }
  fineBits_ = placement == Placement::steps ? kStepFineBits : kStepFineBits - 1;
  t0_.resize(count);
  length_.resize(count);
  count_.resize(count);
  const float finePerUnit = static_cast<float>(1 << kStepFineBits) / step_;
  const Box bounds = quantization_.bounds;
  const float step = step_;
  for (size_t k = 0; k < count; ++k) {
    const RayInterval inside =
        intersectBox(reciprocalOf(camera.eye, {x_[k], y_[k], z_[k]}), bounds, 0.0f, std::numeric_limits<float>::infinity());
    const RayLattice lattice = makeLattice(inside, step);
    t0_[k] = lattice.t0;
    length_[k] = lattice.length;
    count_[k] = lattice.count;
    origin_[k] = clamped(lattice.t0 * finePerUnit + 0.5f, 1 << 24);
    axis_[k] = 0;
  }
}

void PixelPaths::locate(std::span<const PackedSample> samples, std::span<int32_t> places) const {
  if (placement_ == Placement::axis) {
    for (size_t k = 0; k < samples.size(); ++k)
      places[k] = static_cast<int32_t>(samples[k] >> kPositionBits * axis_[k] & kPositionMax);
    return;
  }
  const bool isHalf = placement_ == Placement::halfSteps;
  const float perStep = (isHalf ? 2.0f : 1.0f) / step_;
  const float offset = isHalf ? -0.5f : 0.0f;  // a half step's middle is rounded to, a step's middle lies between integers
  for (size_t k = 0; k < samples.size(); ++k) {
    const glm::vec3 behind = unpackSample(samples[k] & ((uint64_t{1} << 54) - 1), quantization_).center - camera_.eye;
    const float t = behind.x * x_[k] + behind.y * y_[k] + behind.z * z_[k];
    const int largest = isHalf ? 2 * glm::max(glm::min(count_[k], 1 << 29) - 1, 0) : glm::max(count_[k] - 1, 0);
    places[k] = clamped((t - t0_[k]) * perStep + offset, largest);
  }
}

void PixelPaths::place(std::span<const int32_t> places, std::span<PackedSample> positions, std::span<float> depths) const {
  const Box bounds = quantization_.bounds;
  const glm::vec3 eye = camera_.eye;
  if (placement_ == Placement::axis) {
    for (size_t k = 0; k < places.size(); ++k) {
      const Ray ray{eye, {x_[k], y_[k], z_[k]}};
      const int axis = axis_[k];
      const uint32_t code = static_cast<uint32_t>(places[k]) & kPositionMax;
      const float t = (dequantizeCoordinate(code, bounds.lower[axis], bounds.upper[axis]) - eye[axis]) / ray.direction[axis];
      const PackedSample around = packPosition(ray.at(t), bounds);
      const int shift = static_cast<int>(kPositionBits) * axis;
      positions[k] = (around & ~(static_cast<uint64_t>(kPositionMax) << shift)) | static_cast<uint64_t>(code) << shift;
      depths[k] = t;
    }
    return;
  }
  const bool isHalf = placement_ == Placement::halfSteps;
  for (size_t k = 0; k < places.size(); ++k) {
    const Ray ray{eye, {x_[k], y_[k], z_[k]}};
    const RayLattice lattice{t0_[k], length_[k], step_, count_[k]};
    const int last = glm::max(lattice.count - 1, 0);
    float t;
    if (isHalf) {
      const int first = glm::clamp(places[k] >> 1, 0, last), second = glm::clamp(static_cast<int>((static_cast<uint32_t>(places[k]) + 1u) >> 1), 0, last);
      t = 0.5f * (latticeDepth(lattice, first) + latticeDepth(lattice, second));
    } else {
      t = latticeDepth(lattice, glm::clamp(places[k], 0, last));
    }
    positions[k] = packPosition(ray.at(t), bounds);
    depths[k] = t;
  }
}

}  // namespace warpscope

// What the procedural volumes share: a portable random sequence, gradient noise, the few functions whose libm versions
// differ in the last bit from machine to machine, and the loop over voxels. Noise: Perlin 2002, "Improving Noise";
// hash: Jarzynski, Olano 2020 (pcg).
#pragma once

#include <cmath>
#include <cstdint>

#include "render/base/error.h"
#include "render/core/crew.h"
#include "render/core/parallel.h"
#include "render/volume/volume.h"

namespace warpscope::procedural {

/// Which voxels are to be filled, of which volume.
struct Wanted {
  glm::uvec3 dims{0};  ///< of all of it
  VoxelRows rows;      ///< of these
  uint32_t seed = 1;

  /// All of a volume.
  static Wanted all(const glm::uvec3& dims, uint32_t seed) { return {dims, {{0, 0}, {dims.y, dims.z}}, seed}; }
  glm::uvec3 lower() const { return {0, rows.lower.x, rows.lower.y}; }
  glm::uvec3 upper() const { return {dims.x, rows.upper.x, rows.upper.y}; }
};

// Each fills every voxel that is wanted, and throws OperationCancelled if `stop` is set. `voxels`: where the volume's first one is.
void fillVessels(uint8_t* voxels, const Wanted& wanted, const std::stop_token& stop);
void fillShells(uint8_t* voxels, const Wanted& wanted, const std::stop_token& stop);
void fillMarschnerLobb(uint8_t* voxels, const Wanted& wanted, const std::stop_token& stop);
void fillBlock(uint8_t* voxels, const Wanted& wanted, const std::stop_token& stop);

inline uint32_t hash(uint32_t value) {
  const uint32_t state = value * 747796405u + 2891336453u;
  const uint32_t word = ((state >> ((state >> 28u) + 4u)) ^ state) * 277803737u;
  return (word >> 22u) ^ word;
}

/// A sequence of numbers that follows from the seed alone, with every standard library.
class RandomSequence {
 public:
  explicit RandomSequence(uint32_t seed) : key_(hash(seed)) {}
  /// Uniform in [0, 1).
  float uniform() { return static_cast<float>(hash(key_ ^ hash(counter_++)) >> 8) * 0x1p-24f; }
  float uniform(float lower, float upper) { return lower + (upper - lower) * uniform(); }
  glm::vec3 inCube() {
    const float x = uniform(-1.0f, 1.0f), y = uniform(-1.0f, 1.0f), z = uniform(-1.0f, 1.0f);
    return {x, y, z};
  }

 private:
  uint32_t key_;
  uint32_t counter_ = 0;
};

/// Smooth noise in about [-1, 1], zero at lattice points.
inline float gradientNoise(const glm::vec3& position, uint32_t seed) {
  const glm::vec3 base(std::floor(position.x), std::floor(position.y), std::floor(position.z));
  const glm::vec3 f = position - base;
  const glm::vec3 fade = f * f * f * (f * (f * 6.0f - 15.0f) + 10.0f);
  // Odd multipliers tell the lattice points apart, the hash mixes them.
  constexpr uint32_t kX = 0x8da6b343u, kY = 0xd8163841u, kZ = 0xcb1ab31fu;
  const uint32_t key = seed + kX * static_cast<uint32_t>(static_cast<int>(base.x)) +
                       kY * static_cast<uint32_t>(static_cast<int>(base.y)) +
                       kZ * static_cast<uint32_t>(static_cast<int>(base.z));
  // The twelve edges of a cube, four of them twice, as in the paper.
  static constexpr float kGradients[16][3] = {{1, 1, 0},  {-1, 1, 0},  {1, -1, 0}, {-1, -1, 0}, {1, 0, 1},  {-1, 0, 1},
                                              {1, 0, -1}, {-1, 0, -1}, {0, 1, 1},  {0, -1, 1},  {0, 1, -1}, {0, -1, -1},
                                              {1, 1, 0},  {0, -1, 1},  {-1, 1, 0}, {0, -1, -1}};
  const auto corner = [&](uint32_t cornerKey, float x, float y, float z) {
    const float* gradient = kGradients[hash(cornerKey) >> 28];
    return gradient[0] * x + gradient[1] * y + gradient[2] * z;
  };
  const auto alongX = [&](uint32_t rowKey, float y, float z) {
    const float a = corner(rowKey, f.x, y, z);
    return a + fade.x * (corner(rowKey + kX, f.x - 1.0f, y, z) - a);
  };
  const auto alongY = [&](uint32_t sliceKey, float z) {
    const float a = alongX(sliceKey, f.y, z);
    return a + fade.y * (alongX(sliceKey + kY, f.y - 1.0f, z) - a);
  };
  const float a = alongY(key, f.z);
  return a + fade.z * (alongY(key + kZ, f.z - 1.0f) - a);
}

/// cos(2 pi turns), to 1e-12: by the Taylor series after reduction to an eighth of a turn.
inline double cosTurns(double turns) {
  double t = std::abs(turns - std::floor(turns + 0.5));  // [0, 1/2], cos is even
  const bool negative = t > 0.25;
  if (negative) t = 0.5 - t;  // [0, 1/4]
  const double x = t * 6.283185307179586;
  const double q = x * x;
  double series = 1.0;
  for (int n = 20; n >= 2; n -= 2) series = 1.0 - series * q / (n * (n - 1.0));
  return negative ? -series : series;
}

/// Cube root of a value in [0, 1], by Newton's iteration from above (it converges monotonically).
inline double cubeRoot(double value) {
  if (!(value > 0.0)) return 0.0;
  double root = 1.0;
  for (int i = 0; i < 64; ++i) root -= (root * root * root - value) / (3.0 * root * root);
  return root;
}

inline float smoothStep(float t) {
  t = glm::clamp(t, 0.0f, 1.0f);
  return t * t * (3.0f - 2.0f * t);
}

/// A value in [0, 255] to the nearest code.
inline uint8_t quantize(float value) { return static_cast<uint8_t>(glm::clamp(value, 0.0f, 255.0f) + 0.5f); }

/// Sets every voxel that is wanted to quantize(value(x, y, z)), rows in parallel. `value` must depend on its arguments alone.
/// Throws OperationCancelled if `stop` is set.
template <class F>
void fillVoxels(uint8_t* voxels, const Wanted& wanted, const std::stop_token& stop, const F& value) {
  const glm::uvec2 lower = wanted.rows.lower, extent = wanted.rows.upper - lower;
  parallelForRanges(size_t{extent.x} * extent.y, 8, stop, [&](size_t begin, size_t end) {
    for (size_t row = begin; row < end; ++row) {
      Crew::pauseForBreaks();
      const uint32_t y = lower.x + static_cast<uint32_t>(row % extent.x), z = lower.y + static_cast<uint32_t>(row / extent.x);
      uint8_t* const line = voxels + (size_t{z} * wanted.dims.y + y) * wanted.dims.x;
      for (uint32_t x = 0; x < wanted.dims.x; ++x) line[x] = quantize(value(x, y, z));
    }
  });
}

/// Calls `fill(brick, lower, upper)` for the bricks of `side` voxels that have any that are wanted, in parallel: the brick's place among bricks and, of its voxels, those.
/// Throws OperationCancelled if `stop` is set.
template <class F>
void fillBricks(uint32_t side, const Wanted& wanted, size_t atOnce, const std::stop_token& stop, const F& fill) {
  const glm::uvec3 first = wanted.lower() / side, end = (wanted.upper() + side - 1u) / side, bricks = end - first;
  parallelForRanges(size_t{bricks.x} * bricks.y * bricks.z, atOnce, stop, [&](size_t begin, size_t last) {
    for (size_t i = begin; i < last; ++i) {
      Crew::pauseForBreaks();
      const glm::uvec3 brick = first + glm::uvec3(i % bricks.x, i / bricks.x % bricks.y, i / bricks.x / bricks.y);
      fill(brick, glm::max(brick * side, wanted.lower()), glm::min((brick + 1u) * side, wanted.upper()));
    }
  });
}

}  // namespace warpscope::procedural

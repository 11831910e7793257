// Four closed shells inside one another, wrinkled by turbulence: the level sets of one function, so they never touch.
// Turbulence: Perlin 1985, "An Image Synthesizer" (a sum of absolute values of noise).
#include "render/volume/procedural.h"
#include "render/volume/procedural_fields.h"

namespace warpscope::procedural {
namespace {

// Lengths are in units of half the volume's sides.
constexpr float kOuterRadius = 0.80f;
constexpr float kSpacing = 0.185f;
constexpr float kHalfThickness = 0.026f;  // before turbulence, which takes it from 0.4 to 1.6 times that
constexpr float kDisplacement = 0.30f;

/// Turbulence with its mean taken off, about [-0.35, 0.45].
float turbulence(const glm::vec3& p, uint32_t seed) {
  float sum = 0.0f;
  float amplitude = 1.0f, frequency = 2.1f;
  for (uint32_t octave = 0; octave < 4; ++octave) {
    sum += amplitude * std::abs(gradientNoise(p * frequency + 17.3f, seed + octave * 101u));
    amplitude *= 0.46f;
    frequency *= 2.07f;
  }
  return sum - 0.46f;
}

}  // namespace

void fillShells(uint8_t* voxels, const Wanted& wanted, const std::stop_token& stop) {
  const glm::uvec3& dims = wanted.dims;
  const float voxel = 2.0f / static_cast<float>(glm::min(dims.x, glm::min(dims.y, dims.z)));
  const uint32_t key = hash(wanted.seed);
  fillVoxels(voxels, wanted, stop, [&](uint32_t x, uint32_t y, uint32_t z) {
    const glm::vec3 p = (2.0f * glm::vec3(x, y, z) + 1.0f) / glm::vec3(dims) - 1.0f;
    const float radius = glm::length(p);
    if (radius < 0.04f || radius > 1.0f) return 0.0f;
    // Fades out towards the volume's faces, which the outer shell must not reach, and towards the centre, so that the
    // inner shell stays around it.
    const float fade = smoothStep(radius / 0.3f) * smoothStep((1.0f - radius) / 0.12f);
    const float level = radius - kDisplacement * fade * turbulence(p, key);
    const float depth = (kOuterRadius - level) / kSpacing;  // 0 on the outer shell's middle, 1 on the next one's
    const int shell = static_cast<int>(std::floor(depth + 0.5f));
    if (shell < 0 || shell >= static_cast<int>(kShellBands.size())) return 0.0f;
    const float distance = std::abs(depth - static_cast<float>(shell)) * kSpacing;
    if (distance > 1.6f * kHalfThickness + voxel) return 0.0f;
    const float grain = gradientNoise(p * 5.3f + 3.1f, key + 7u);
    const float half = kHalfThickness * (1.0f + 0.6f * glm::clamp(1.4f * grain, -1.0f, 1.0f));
    const float coverage = glm::clamp((half - distance) / voxel + 0.5f, 0.0f, 1.0f);
    const float inside = glm::clamp(1.0f - distance / half, 0.0f, 1.0f);
    const ShellBand& band = kShellBands[static_cast<size_t>(shell)];
    return coverage * glm::mix(static_cast<float>(band.lower), static_cast<float>(band.upper), inside);
  });
}

}  // namespace warpscope::procedural

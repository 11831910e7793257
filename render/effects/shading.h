// Light that surfaces within a volume send back: ambient, diffuse and specular, two-sided, from the gradient. For host and device.
// Phong 1975 with the half vector of Blinn 1977 ("Models of light reflection for computer synthesized pictures"); normals of volumes after Levoy 1988.
#pragma once

#include <cstdint>
#include <type_traits>

#include "render/core/counters.h"
#include "render/core/numeric.h"
#include "render/core/ray.h"
#include "render/effects/effects.h"
#include "render/effects/gradient.h"
#include "render/effects/light_volume.h"
#include "render/march/light.h"

namespace warpscope {

/// As the formulas want it: in volume space.
struct PreparedLight {
  LightKind kind = LightKind::headlight;  ///< `camera` and `world` are the same here
  glm::vec3 vector{0.0f};                 ///< unit, towards the light; of a point light its place
  float strength = 1.0f;
};

/// What is the same for all samples of a picture.
struct ShadingSetup {
  Shading shading;
  bool isLit = false;           ///< by whatever light: without, no gradient
  bool hasDiffuse = false;      ///< beside ambient light
  bool hasHighlights = false;
  bool hasHalfVectors = false;  ///< of lights that are not at the eye
  /// Squared gradient below which there is no surface: what rounding of the volume's values to its type's steps can make of a constant; at least 2^-100.
  float noiseSquared = 0.0f;
  /// Of gradients as they are read, interpolants a voxel: turns them into volume space, and into what can be squared.
  glm::vec3 gradientScale{1.0f};
  int lightCount = 0;
  PreparedLight lights[Lights::kMost];
};

/// Exponents up to which powerOfCosine() multiplies: roundings grow with the exponent.
inline constexpr float kMostMultiplied = 32.0f;

/// x^exponent for x in [0, 1] and exponent > 0, the same bits on every processor: within 2e-6 of 1 of the truth. By squaring where the exponent is a
/// small whole number, else by logarithm and power to the base 2, in series (exact_math.h names them). Float is float or a vector of floats.
template <class Float>
WARPSCOPE_HD inline Float powerOfCosine(const Float& x, float exponent) {
  if (exponent <= kMostMultiplied && exponent == static_cast<float>(static_cast<int>(exponent))) {
    Float square = minOf(x, Float(1.0f)), power(1.0f);
    const int whole = static_cast<int>(exponent);
    for (int bit = 1; bit <= static_cast<int>(kMostMultiplied); bit *= 2) {  // unrolled
      if (whole & bit) power = power * square;
      square = square * square;
    }
    return power;
  }
  // x = mantissa * 2^power, mantissa in [sqrt(1/2), sqrt(2)).
  constexpr int32_t kRoot = 0x3f3504f3;
  const auto bits = bitsOf(minOf(maxOf(x, Float(0x1p-64f)), Float(1.0f)));
  const auto power = (bits - kRoot) >> 23;
  const Float mantissa = floatOfBits(bits - (power << 23));
  const Float s = (mantissa - Float(1.0f)) / (mantissa + Float(1.0f)), square = s * s;  // |s| < 0.172: what follows is below 5e-8
  const Float series =
      mulAdd(mulAdd(mulAdd(Float(0.412198583f), square, Float(0.577078016f)), square, Float(0.961796694f)), square, Float(2.88539008f));
  const Float y = maxOf(Float(exponent) * mulAdd(s, series, converted(power)), Float(-126.0f));
  const auto whole = truncated(y - Float(0.5f));  // rounds to the nearest, since y < 0
  const Float r = y - converted(whole);
  Float result = mulAdd(Float(1.54035304e-4f), r, Float(1.33335581e-3f));
  for (const float coefficient : {9.61812911e-3f, 5.55041087e-2f, 0.240226507f, 0.693147181f, 1.0f}) result = mulAdd(result, r, Float(coefficient));
  return selected(y > Float(-126.0f), result * floatOfBits((whole + 127) << 23), Float(0.0f));
}

/// 1 / sqrt(x) for x in [2^-100, 2^100], the same bits on every processor: within kReciprocalRootError, relative to itself. From a first guess by the
/// float's bits (Blinn 1997, "Floating-point tricks") by Newton's steps; in a fraction of the time of a root and a division that are rounded rightly.
inline constexpr double kReciprocalRootError = 4 * 0x1p-24;
template <class Float>
WARPSCOPE_HD inline Float reciprocalRoot(const Float& x) {
  Float y = floatOfBits(0x5f375a86 - (bitsOf(x) >> 1));
  const Float half = Float(-0.5f) * x;
  for (int step = 0; step < 3; ++step) y = y * mulAdd(half * y, y, Float(1.5f));
  return y;
}

/// What light makes of a colour c of opacity a, premultiplied: kept * c + white * a.
template <class Float>
struct LightFactors {
  Float kept, white;
};

template <class Float>
WARPSCOPE_HD inline Float dot3(const Float (&a)[3], const Float (&b)[3]) {
  return mulAdd(a[2], b[2], mulAdd(a[1], b[1], a[0] * b[0]));
}

/// Nothing stands in the light's way.
struct AllLight {};

/// `gradient`: as gradientOf() gives it. `toEye`: unit vector. `place`: in volume space; for point lights alone. `arriving`: AllLight, or a function
/// that tells by how much the i-th light is multiplied there, and ambient light for i = -1.
template <class Float, class Arriving = AllLight>
WARPSCOPE_HD inline LightFactors<Float> lightFactors(const ShadingSetup& setup, const Float (&gradient)[3], const Float (&toEye)[3], const Float (&place)[3],
                                                     const Arriving& arriving = {}) {
  constexpr bool kIsShadowed = !std::is_same_v<Arriving, AllLight>;
  const Float kZero(0.0f), kOne(1.0f);
  const Shading& shading = setup.shading;
  const Float scaled[3] = {gradient[0] * Float(setup.gradientScale.x), gradient[1] * Float(setup.gradientScale.y), gradient[2] * Float(setup.gradientScale.z)};
  const Float squared = dot3(scaled, scaled);
  const auto isSurface = squared > Float(setup.noiseSquared);
  const Float toUnit = reciprocalRoot(selected(isSurface, squared, kOne));
  const Float facingEye = absOf(dot3(scaled, toEye)) * toUnit;
  Float diffuse(shading.ambient), specular = kZero;
  if constexpr (kIsShadowed) diffuse = diffuse * arriving(-1);
  for (int i = 0; i < setup.lightCount; ++i) {
    const PreparedLight& light = setup.lights[i];
    const float diffuseStrength = light.strength * shading.diffuse, specularStrength = light.strength * shading.specular;
    if (light.kind == LightKind::headlight) {  // its direction is the viewer's, and so is the half vector
      if (setup.hasDiffuse) {
        WARPSCOPE_COUNT(diffuse, 1);
        diffuse = mulAdd(Float(diffuseStrength), facingEye, diffuse);
      }
      if (!setup.hasHighlights) continue;
      WARPSCOPE_COUNT(highlights, 1);
      specular = mulAdd(Float(specularStrength), powerOfCosine(facingEye, shading.exponent), specular);
      continue;
    }
    Float toLight[3] = {Float(light.vector.x), Float(light.vector.y), Float(light.vector.z)};
    Float strength = kOne;
    if (light.kind == LightKind::point) {
      for (int axis = 0; axis < 3; ++axis) toLight[axis] = toLight[axis] - place[axis];
      const Float distanceSquared = dot3(toLight, toLight);
      const auto isOutside = distanceSquared > Float(0x1p-100f);  // else the light is in the sample, and everywhere around it
      const Float toUnitLight = reciprocalRoot(selected(isOutside, distanceSquared, kOne));
      for (int axis = 0; axis < 3; ++axis) toLight[axis] = toLight[axis] * toUnitLight;
      strength = selected(isOutside, kOne, kZero);
    }
    if constexpr (kIsShadowed) strength = strength * arriving(i);
    if (setup.hasDiffuse) {
      WARPSCOPE_COUNT(diffuse, 1);
      diffuse = mulAdd(Float(diffuseStrength) * strength, absOf(dot3(scaled, toLight)) * toUnit, diffuse);
    }
    if (!setup.hasHalfVectors) continue;
    WARPSCOPE_COUNT(halfVectors, 1);
    WARPSCOPE_COUNT(highlights, 1);
    const Float half[3] = {toLight[0] + toEye[0], toLight[1] + toEye[1], toLight[2] + toEye[2]};
    const Float halfSquared = dot3(half, half);
    const auto isHalf = halfSquared > Float(1e-12f);  // else the light is opposite the eye
    const Float mirrored = absOf(dot3(scaled, half)) * toUnit * reciprocalRoot(selected(isHalf, halfSquared, kOne));
    specular = mulAdd(Float(specularStrength) * strength, selected(isHalf, powerOfCosine(mirrored, shading.exponent), kZero), specular);
  }
  const float strength = shading.strength;
  return {selected(isSurface, mulAdd(Float(strength), diffuse, Float(1.0f - strength)), kOne), selected(isSurface, Float(strength) * specular, kZero)};
}

/// As gradientAt(), of a sample that the source has looked at, at distance `t`: a source that knows its cell is not asked to find it again.
template <class Source>
WARPSCOPE_HD inline void gradientOfSample(const Source& source, const Ray& ray, float t, float (&gradient)[3]) {
  if constexpr (requires { source.cell(); })
    gradientIn<Source::kLoadsCells, Source::kLeavesOutHoles>(source.view(), source.cell(), gradient);
  else
    gradientAt<Source::kLoadsCells, Source::kLeavesOutHoles>(source.view(), ray, t, gradient);
}

/// Colours lit by the setup's lights (light.h says what a light is).
struct Lit {
  ShadingSetup setup;

  template <class Source>
  WARPSCOPE_HD glm::vec3 shade(const ClassifiedSample& sample, const Ray& ray, const Source& source, int /*k*/) const {
    WARPSCOPE_COUNT(gradients, 1);
    WARPSCOPE_COUNT(voxels, 32);
    float gradient[3];
    gradientOfSample(source, ray, sample.t, gradient);
    const float toEye[3] = {-ray.direction.x, -ray.direction.y, -ray.direction.z};
    const float place[3] = {mulAdd(sample.t, ray.direction.x, ray.origin.x), mulAdd(sample.t, ray.direction.y, ray.origin.y),
                            mulAdd(sample.t, ray.direction.z, ray.origin.z)};
    const LightFactors<float> factors = lightFactors(setup, gradient, toEye, place);
    return lit(factors.kept, factors.white, sample);
  }
  WARPSCOPE_HD static glm::vec3 lit(float kept, float white, const ClassifiedSample& sample) {
    return kept * sample.color + glm::vec3(white * sample.alpha);
  }
};

/// `towards` becomes the unit vector from `place` to a point light, which is so far away; 0 if it is there, and any vector.
WARPSCOPE_HD inline float unitTowards(const PreparedLight& light, const glm::vec3& place, glm::vec3& towards) {
  const float way[3] = {light.vector.x - place.x, light.vector.y - place.y, light.vector.z - place.z};
  const float squared = dot3(way, way);
  if (!(squared > 0.0f)) return 0.0f;
  const float distance = sqrtOf(squared), toUnit = 1.0f / distance;
  towards = {way[0] * toUnit, way[1] * toUnit, way[2] * toUnit};
  return distance;
}

/// Lit, as far as light arrives.
struct ShadowedLit {
  ShadingSetup setup;
  LightVolume volume;

  /// By how much the i-th light is multiplied at a place, in volume space and in voxels; ambient light for i = -1. Of a light what arrives one edge of the
  /// grid before the sample is taken: a surface would lie in the shadow of the matter that it is made of otherwise. What is nearer casts none.
  template <class View>
  WARPSCOPE_HD float arriving(int i, const View& view, const float (&place)[3], const float (&voxel)[3]) const {
    if (i < 0) return volume.ofAmbient < 0 ? 1.0f : LightVolume::factorOf(volume.at(volume.ofAmbient, voxel), volume.occlusionStrength);
    if (volume.ofLight[i] < 0) return 1.0f;
    const PreparedLight& light = setup.lights[i];
    glm::vec3 toLight = light.vector;
    float ahead = volume.edge;
    if (light.kind == LightKind::point) ahead = minOf(unitTowards(light, {place[0], place[1], place[2]}, toLight), ahead);
    float before[3];
    for (int axis = 0; axis < 3; ++axis) before[axis] = ahead > 0.0f ? mulAdd(toLight[axis] * ahead, view.voxelsPerUnit[axis], voxel[axis]) : voxel[axis];
    return LightVolume::factorOf(volume.at(volume.ofLight[i], before), volume.shadowStrength);
  }

  template <class Source>
  WARPSCOPE_HD glm::vec3 shade(const ClassifiedSample& sample, const Ray& ray, const Source& source, int /*k*/) const {
    float gradient[3];
    gradientOfSample(source, ray, sample.t, gradient);
    const glm::vec3 origin = source.view().voxelOrigin(ray), direction = source.view().voxelDirection(ray);
    const float toEye[3] = {-ray.direction.x, -ray.direction.y, -ray.direction.z};
    float place[3], voxel[3];
    for (int axis = 0; axis < 3; ++axis) {
      place[axis] = mulAdd(sample.t, ray.direction[axis], ray.origin[axis]);
      voxel[axis] = mulAdd(sample.t, direction[axis], origin[axis]);
    }
    const LightFactors<float> factors = lightFactors(setup, gradient, toEye, place, [&](int i) { return arriving(i, source.view(), place, voxel); });
    return Lit::lit(factors.kept, factors.white, sample);
  }
};

/// Calls `f` with the light that the setup asks for, of those that nothing stands in the way of.
template <class F>
decltype(auto) visitLight(const ShadingSetup& setup, F&& f) {
  if (!setup.isLit) return f(Unlit{});
  return f(Lit{setup});
}
/// Of all: one line for each. `volume`: with channels where something stands in the light's way.
template <class F>
decltype(auto) visitLight(const ShadingSetup& setup, const LightVolume& volume, F&& f) {
  if (setup.isLit && volume.channels > 0) return f(ShadowedLit{setup, volume});
  return visitLight(setup, f);
}

}  // namespace warpscope

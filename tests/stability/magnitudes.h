// Inputs of all magnitudes for properties: numbers whose logarithm is uniform, of either sign; directions, rays,
// spheres, boxes, cameras. Claessen, Hughes 2000 ("QuickCheck"), by rapidcheck. Everything shrinks: numbers towards 1,
// places towards simple ones, lists to fewer.
#pragma once

#include <gtest/gtest-spi.h>
#include <rapidcheck.h>
#include <rapidcheck/gtest.h>

#include <cmath>
#include <ios>
#include <ostream>
#include <tuple>
#include <vector>

#include "render/core/box.h"
#include "render/core/camera.h"
#include "render/core/ray.h"

namespace warpscope {

/// A property of the running test: rc::check for GoogleTest, which prints the seed and the least counterexample.
/// What EXPECT and ASSERT find in it is found of this input alone. Left to GoogleTest, the first failure would stay the
/// test's, every smaller input would look like another one, and the least of all would be printed.
template <class Property>
void checkProperty(const Property& property) {
  rc::detail::checkGTest([&] {
    testing::TestPartResultArray found;
    {
      const testing::ScopedFakeTestPartResultReporter reporter(
          testing::ScopedFakeTestPartResultReporter::INTERCEPT_ALL_THREADS, &found);
      property();
    }
    for (int i = 0; i < found.size(); ++i)
      if (found.GetTestPartResult(i).failed()) RC_FAIL(found.GetTestPartResult(i).message());
  });
}

/// Exponents of 1e-30 and 1e30.
inline constexpr int kLeastExponent = -100, kLargestExponent = 100;

/// least..most, which hold 0; shrinks towards 0.
inline rc::Gen<int> anyInteger(int least, int most) {
  return rc::gen::map(rc::gen::inRange(0, most - least + 1), [=](int v) {
    const int both = std::min(-least, most);
    if (v <= 2 * both) return v % 2 == 0 ? v / 2 : -(v / 2 + 1) + (-(v / 2 + 1) < -both ? 1 : 0);
    return -least < most ? v - both : both - v;
  });
}

/// 0..1 in 2^24 steps; shrinks towards 0.
inline rc::Gen<float> anyFraction() {
  return rc::gen::map(rc::gen::inRange<uint32_t>(0, (1u << 24) + 1),
                      [](uint32_t steps) { return static_cast<float>(steps) * 0x1p-24f; });
}

/// 2^least to 2^(most + 1), positive.
inline rc::Gen<float> anyPositive(int least = kLeastExponent, int most = kLargestExponent) {
  return rc::gen::map(
      rc::gen::tuple(anyInteger(std::min(least, 0), std::max(most, 0)), rc::gen::inRange<uint32_t>(0, 1u << 23)),
      [=](const std::tuple<int, uint32_t>& parts) {
        const int exponent = std::clamp(std::get<0>(parts), least, most);
        return std::ldexp(1.0f + static_cast<float>(std::get<1>(parts)) * 0x1p-23f, exponent);
      });
}

/// Of either sign.
inline rc::Gen<float> anyNumber(int least = kLeastExponent, int most = kLargestExponent) {
  return rc::gen::map(rc::gen::tuple(anyPositive(least, most), rc::gen::arbitrary<bool>()),
                      [](const std::tuple<float, bool>& parts) {
                        return std::get<1>(parts) ? -std::get<0>(parts) : std::get<0>(parts);
                      });
}

/// Each coordinate of a magnitude of its own.
inline rc::Gen<glm::vec3> anyVector(int least = kLeastExponent, int most = kLargestExponent) {
  return rc::gen::map(rc::gen::tuple(anyNumber(least, most), anyNumber(least, most), anyNumber(least, most)),
                      [](const std::tuple<float, float, float>& v) {
                        return glm::vec3(std::get<0>(v), std::get<1>(v), std::get<2>(v));
                      });
}

/// Any way to look, axes among them; unit to the last bit of float.
inline rc::Gen<glm::vec3> anyDirection() {
  const auto component = [] { return anyInteger(-4096, 4096); };
  return rc::gen::map(rc::gen::tuple(component(), component(), component()), [](const std::tuple<int, int, int>& v) {
    const glm::dvec3 wanted(std::get<0>(v), std::get<1>(v), std::get<2>(v));
    return wanted == glm::dvec3(0.0) ? glm::vec3(0.0f, 0.0f, 1.0f) : glm::vec3(glm::normalize(wanted));
  });
}

/// A sphere, and a ray towards it.
struct SphereCase {
  Ray ray;
  glm::vec3 center;
  float radius;
};

/// Most rays pass near the outline; eyes from inside the sphere to 2^17 radii away, `least` and `most` are the radius's
/// exponents.
inline rc::Gen<SphereCase> anySphereCase(int least, int most) {
  return rc::gen::map(
      rc::gen::tuple(anyPositive(least, most), anyPositive(-2, 16), anyDirection(), anyDirection(), anyDirection(),
                     rc::gen::tuple(rc::gen::inRange(0, 26), anyInteger(-64, 64), anyInteger(-4, 4))),
      [](const auto& parts) {
        const auto& [radius, radii, forward, to, from, pass] = parts;
        const auto& [closeness, off, far] = pass;
        const float distance = radius * radii;
        const float beside = 1.0f + std::ldexp(static_cast<float>(off) / 64.0f, -closeness);
        glm::vec3 side = glm::cross(forward, to);
        if (!(glm::dot(side, side) > 1e-6f))
          side = glm::cross(forward, glm::vec3(forward.y, forward.z, -forward.x + 0.5f));
        const glm::vec3 origin = std::ldexp(distance, far) * from;
        return SphereCase{
            {origin, forward}, origin + distance * forward + beside * radius * glm::normalize(side), radius};
      });
}

/// A box, and a ray towards a point of it: a corner, on an edge, in a face or inside.
struct BoxCase {
  glm::vec3 origin, direction;
  Box box;
};

inline rc::Gen<BoxCase> anyBoxCase(int least, int most) {
  return rc::gen::map(
      rc::gen::tuple(anyVector(least, most), rc::gen::tuple(anyFraction(), anyFraction(), anyFraction()),
                     anyPositive(-14, 6), anyPositive(-14, 14), anyDirection(),
                     rc::gen::tuple(rc::gen::inRange(0, 4), rc::gen::inRange(0, 4), rc::gen::inRange(0, 4))),
      [](const auto& parts) {
        const auto& [center, share, size, away, from, place] = parts;
        const float reach = glm::max(std::abs(center.x), glm::max(std::abs(center.y), std::abs(center.z)));
        const glm::vec3 half = size * reach * glm::vec3(std::get<0>(share), std::get<1>(share), std::get<2>(share));
        BoxCase result{center + away * reach * from, {}, {center - half, center + half}};
        const int at[3] = {std::get<0>(place), std::get<1>(place), std::get<2>(place)};
        glm::vec3 target;
        for (int axis = 0; axis < 3; ++axis)
          target[axis] = at[axis] == 0   ? center[axis]
                         : at[axis] == 1 ? result.box.lower[axis]
                         : at[axis] == 2 ? result.box.upper[axis]
                                         : center[axis] + 0.37f * half[axis];
        const glm::dvec3 towards = glm::dvec3(target) - glm::dvec3(result.origin);
        result.direction =
            towards == glm::dvec3(0.0) ? glm::vec3(1.0f, 0.0f, 0.0f) : glm::vec3(glm::normalize(towards));
        return result;
      });
}

/// Any place up to 2^`most`, direction, field of view, size, either handedness. Axes are unit and orthogonal up to
/// rounding.
inline rc::Gen<Camera> anyCamera(int least, int most) {
  return rc::gen::map(rc::gen::tuple(anyVector(least, most), anyDirection(), anyDirection(), anyPositive(-7, 3),
                                     rc::gen::tuple(rc::gen::inRange(1u, 4097u), rc::gen::inRange(1u, 4097u),
                                                    rc::gen::arbitrary<bool>())),
                      [](const auto& parts) {
                        const auto& [eye, forward, to, tangent, rest] = parts;
                        glm::dvec3 right = glm::cross(glm::dvec3(forward), glm::dvec3(to));
                        if (!(glm::dot(right, right) > 1e-6))
                          right = glm::cross(glm::dvec3(forward), glm::dvec3(forward.y, forward.z, -forward.x + 0.5f));
                        right = glm::normalize(right);
                        Camera camera;
                        camera.eye = eye;
                        camera.forward = forward;
                        camera.right = glm::vec3(std::get<2>(rest) ? -right : right);
                        camera.up = glm::vec3(glm::normalize(glm::cross(right, glm::dvec3(forward))));
                        camera.tanHalfFovY = tangent;
                        camera.width = std::get<0>(rest);
                        camera.height = std::get<1>(rest);
                        return camera;
                      });
}

// --- How counterexamples are printed: to the last bit.

inline std::ostream& showBits(std::ostream& out, const glm::vec3& v) {
  return out << std::hexfloat << '{' << v.x << ", " << v.y << ", " << v.z << '}' << std::defaultfloat;
}
inline void showValue(const SphereCase& c, std::ostream& out) {
  showBits(out << "eye ", c.ray.origin);
  showBits(out << ", direction ", c.ray.direction);
  showBits(out << ", centre ", c.center) << ", radius " << std::hexfloat << c.radius << std::defaultfloat;
}
inline void showValue(const BoxCase& c, std::ostream& out) {
  showBits(out << "origin ", c.origin);
  showBits(out << ", direction ", c.direction);
  showBits(out << ", box ", c.box.lower);
  showBits(out << " to ", c.box.upper);
}
inline void showValue(const Camera& c, std::ostream& out) {
  showBits(out << "eye ", c.eye);
  showBits(out << ", right ", c.right);
  showBits(out << ", up ", c.up);
  showBits(out << ", forward ", c.forward)
      << ", tangent " << std::hexfloat << c.tanHalfFovY << std::defaultfloat << ", " << c.width << "x" << c.height;
}

}  // namespace warpscope

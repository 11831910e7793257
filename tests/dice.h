// Seeded random numbers and directions for tests.
#pragma once

#include <cmath>
#include <cstdint>
#include <random>

#include <glm/geometric.hpp>
#include <glm/vec3.hpp>

namespace warpscope {

class Dice {
 public:
  explicit Dice(uint32_t seed) : random_(seed) {}
  float uniform(float low, float high) { return std::uniform_real_distribution<float>(low, high)(random_); }
  /// 10^low to 10^high.
  float magnitude(float low, float high) { return std::pow(10.0f, uniform(low, high)); }
  uint32_t below(uint32_t count) { return static_cast<uint32_t>(random_() % count); }
  glm::vec3 direction() {
    for (;;) {
      const glm::vec3 v(uniform(-1, 1), uniform(-1, 1), uniform(-1, 1));
      const float length2 = glm::dot(v, v);
      if (length2 > 0.01f && length2 <= 1.0f) return glm::normalize(v);
    }
  }

 private:
  std::mt19937 random_;
};

}  // namespace warpscope

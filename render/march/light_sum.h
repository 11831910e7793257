// Light that a ray has gathered.
// Sums of sums, as pairwise summation: errors grow with the number of blocks, not of samples (Higham 2002, section 4.2).
#pragma once

#include "render/core/numeric.h"

namespace warpscope {

/// Light that a ray has gathered: a sum of sums. It is added up in float over a block of the lattice's samples, blocks
/// in double, for the same reason as transmittance. Blocks are those of the lattice, so that it does not matter in
/// which pieces a ray is marched.
class LightSum {
 public:
  /// Takes the light of the lattice's i-th sample, whose colour (times its opacity) is seen through `transmittance`.
  WARPSCOPE_HD void add(int i, const glm::vec3& color, float through) {
    if (i >> kBlockBits != block_) {
      sum_ += glm::dvec3(ofBlock_);
      ofBlock_ = glm::vec3(0.0f);
      block_ = i >> kBlockBits;
    }
    for (int channel = 0; channel < 3; ++channel) ofBlock_[channel] = mulAdd(through, color[channel], ofBlock_[channel]);
  }
  WARPSCOPE_HD glm::dvec3 color() const { return sum_ + glm::dvec3(ofBlock_); }  ///< linear, premultiplied

 private:
  static constexpr int kBlockBits = 4;

  glm::dvec3 sum_{0.0};
  glm::vec3 ofBlock_{0.0f};
  int block_ = 0;
};

}  // namespace warpscope

// What gradients of a batch of places are taken of, on the CPU: loaded place by place, in as few words as there are, and turned into numbers at once.
// Mirrors loadStencil() of gradient.h, whose values these are.
#pragma once

#include <algorithm>
#include <bit>
#include <cstddef>
#include <cstring>

#include "render/effects/gradient.h"
#include "render/march/voxel_words.h"

namespace warpscope {

/// Room for the stencils of a batch as they are read.
template <class Voxel, bool kHasHoles>
class GradientLoads {
 public:
  GradientLoads() {}  // a ray that meets nothing has nothing to set

  /// Reads those of the cells `at` of which bit k of `lanes` is set; the others' numbers mean nothing, but are finite.
  void load(const VolumeView<Voxel>& view, const int32_t (&at)[3][kBatchLanes], uint32_t lanes, GradientStencil<FloatBatch>& s) {
    if (!isUsed_) {
      isUsed_ = true;
      std::memset(own_, 0, sizeof own_);  // of lanes that nobody sees; later they are of an earlier batch
      std::memset(below_, 0, sizeof below_);
      std::memset(above_, 0, sizeof above_);
    }
    for (; lanes != 0; lanes &= lanes - 1) {
      const int k = std::countr_zero(lanes);
      const int ofLane[3] = {at[0][k], at[1][k], at[2][k]};
      GradientStencil<float> stencil;
      loadStencil<false>(view, ofLane, stencil);
      if constexpr (kHasHoles) replaceMissing(stencil);
      for (int c = 0; c < 8; ++c) own_[c][k] = stencil.own[c];
      for (int axis = 0; axis < 3; ++axis)
        for (int c = 0; c < 4; ++c) {
          below_[axis][c][k] = stencil.below[axis][c];
          above_[axis][c][k] = stencil.above[axis][c];
        }
    }
    for (int c = 0; c < 8; ++c) s.own[c] = FloatBatch::load_aligned(own_[c]);
    for (int axis = 0; axis < 3; ++axis)
      for (int c = 0; c < 4; ++c) {
        s.below[axis][c] = FloatBatch::load_aligned(below_[axis][c]);
        s.above[axis][c] = FloatBatch::load_aligned(above_[axis][c]);
      }
  }

 private:
  bool isUsed_ = false;
  alignas(64) float own_[8][kBatchLanes];
  alignas(64) float below_[3][4][kBatchLanes];
  alignas(64) float above_[3][4][kBatchLanes];
};

/// Of small voxels: along x a word for each row, or two; across it a word for each edge that is parallel to x.
template <class Voxel>
  requires kHasPairs<Voxel>
class GradientLoads<Voxel, false> {
 public:
  GradientLoads() {}

  void load(const VolumeView<Voxel>& view, const int32_t (&at)[3][kBatchLanes], uint32_t lanes, GradientStencil<FloatBatch>& s) {
    if (!isUsed_) {
      isUsed_ = true;
      std::memset(words_, 0, sizeof words_);
    }
    const auto strideY = static_cast<ptrdiff_t>(view.dims.x);
    const ptrdiff_t strideZ = strideY * view.dims.y;
    for (; lanes != 0; lanes &= lanes - 1) {
      const int k = std::countr_zero(lanes);
      const int x = at[0][k], y = at[1][k], z = at[2][k];
      const bool isInside = x > 0 && x + 2 < view.dims.x && y > 0 && y + 2 < view.dims.y && z > 0 && z + 2 < view.dims.z;
      const auto put = [&](const auto& wordAt) {  // wordAt<kCount>(dx, dy, dz): the word of the voxels from there on
        for (int row = 0; row < 4; ++row) {
          const int dy = row & 1, dz = row >> 1;
          if constexpr (kHasQuads<Voxel>) {
            words_[row][k] = wordAt.template operator()<4>(-1, dy, dz);
          } else {
            words_[2 * row][k] = wordAt.template operator()<2>(-1, dy, dz);
            words_[2 * row + 1][k] = wordAt.template operator()<2>(1, dy, dz);
          }
        }
        uint32_t(*const edges)[kBatchLanes] = words_ + kRowWords;
        for (int across = 0; across < 2; ++across) {
          edges[0 + across][k] = wordAt.template operator()<2>(0, -1, across);
          edges[2 + across][k] = wordAt.template operator()<2>(0, 2, across);
          edges[4 + across][k] = wordAt.template operator()<2>(0, across, -1);
          edges[6 + across][k] = wordAt.template operator()<2>(0, across, 2);
        }
      };
      if (isInside) {
        const Voxel* const place = view.voxels + (z * strideZ + y * strideY + x);
        put([&]<int kCount>(int dx, int dy, int dz) { return loadWord<kCount>(place + (dz * strideZ + dy * strideY + dx)); });
      } else {
        put([&]<int kCount>(int dx, int dy, int dz) {
          Voxel voxels[kCount];
          for (int i = 0; i < kCount; ++i)
            voxels[i] = view.voxels[within(z + dz, view.dims.z) * strideZ + within(y + dy, view.dims.y) * strideY + within(x + dx + i, view.dims.x)];
          return loadWord<kCount>(voxels);
        });
      }
    }
    for (int row = 0; row < 4; ++row) {
      if constexpr (kHasQuads<Voxel>) {
        const UintBatch quad = UintBatch::load_aligned(words_[row]);
        s.below[0][row] = voxelsOf<Voxel, 4, 0>(quad);
        s.own[2 * row] = voxelsOf<Voxel, 4, 1>(quad);
        s.own[2 * row + 1] = voxelsOf<Voxel, 4, 2>(quad);
        s.above[0][row] = voxelsOf<Voxel, 4, 3>(quad);
      } else {
        takePair(words_[2 * row], s.below[0][row], s.own[2 * row]);
        takePair(words_[2 * row + 1], s.own[2 * row + 1], s.above[0][row]);
      }
    }
    const uint32_t(*const edges)[kBatchLanes] = words_ + kRowWords;
    for (int axis = 1; axis < 3; ++axis)
      for (int across = 0; across < 2; ++across) {
        takePair(edges[4 * (axis - 1) + across], s.below[axis][2 * across], s.below[axis][2 * across + 1]);
        takePair(edges[4 * (axis - 1) + 2 + across], s.above[axis][2 * across], s.above[axis][2 * across + 1]);
      }
  }

 private:
  static constexpr int kRowWords = kHasQuads<Voxel> ? 4 : 8;

  static ptrdiff_t within(int i, int count) { return std::clamp(i, 0, count - 1); }
  static void takePair(const uint32_t (&words)[kBatchLanes], FloatBatch& first, FloatBatch& second) {
    const UintBatch pair = UintBatch::load_aligned(words);
    first = voxelsOf<Voxel, 2, 0>(pair);
    second = voxelsOf<Voxel, 2, 1>(pair);
  }

  bool isUsed_ = false;
  alignas(64) uint32_t words_[kRowWords + 8][kBatchLanes];
};

}  // namespace warpscope

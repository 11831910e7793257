// What a ray sees of a volume, batch by batch: the source that march.h's loop takes on the CPU.
// Positions, weights and table indices of a batch are computed lane by lane in plain loops that compilers vectorise.
#pragma once

#include <bit>
#include <cstdint>
#include <cstring>
#include <type_traits>

#include "render/core/transfer_function.h"
#include "render/core/ray.h"
#include "render/march/lattice.h"
#include "render/volume/voxel_access.h"

namespace warpscope {

/// Two neighbouring voxels of a small type as one integer, the one with the lower address in `firstOf`.
template <class Voxel>
inline constexpr bool kHasPairs = sizeof(Voxel) <= 2;
template <class Voxel>
using VoxelPair = std::conditional_t<sizeof(Voxel) == 1, uint16_t, uint32_t>;

template <class Voxel>
VoxelPair<Voxel> loadPair(const Voxel* p) {
  VoxelPair<Voxel> pair;
  std::memcpy(&pair, p, sizeof pair);
  return pair;
}

template <class Voxel>
Voxel firstOf(VoxelPair<Voxel> pair) {
  return static_cast<Voxel>(std::endian::native == std::endian::little ? pair : pair >> (8 * sizeof(Voxel)));
}

template <class Voxel>
Voxel secondOf(VoxelPair<Voxel> pair) {
  return static_cast<Voxel>(std::endian::native == std::endian::little ? pair >> (8 * sizeof(Voxel)) : pair);
}

/// Everything about a volume and a baked transfer function that rays share. Pointers are not owned.
template <class Voxel>
struct VolumeView {
  const Voxel* voxels = nullptr;
  glm::ivec3 dims{0};
  ValueScale scale;
  glm::vec3 lower{0.0f};          ///< volume-space position of the volume's lower corner
  glm::vec3 voxelsPerUnit{1.0f};  ///< along each axis
  const glm::vec4* table = nullptr;
  const float* tableAlpha = nullptr;           ///< the table's alphas alone, densely
  const uint8_t* emptyDistances = nullptr;     ///< of macrocells, or null: nothing is skipped
  glm::ivec3 cellDims{0};
  int cellEdge = 1;
};

/// kHasHoles: some voxels are not finite and are left out of interpolation.
template <class Voxel, bool kHasHoles>
class VolumeSource {
 public:
  static constexpr int kBatch = 8;

  VolumeSource(const VolumeView<Voxel>& view, const Ray& ray, const RayLattice& lattice)
      : view_(view),
        lattice_(lattice),
        origin_((ray.origin - view.lower) * view.voxelsPerUnit - 0.5f),
        direction_(ray.direction * view.voxelsPerUnit),
        invDirection_(1.0f / (direction_ + 0.0f)),
        margin_(1e-3f + 1e-6f * static_cast<float>(glm::max(view.dims.x, glm::max(view.dims.y, view.dims.z))) / lattice.dt) {}

  int skip(int i) const {
    if (view_.emptyDistances == nullptr) return i;
    while (i < lattice_.count) {
      const glm::vec3 place = origin_ + lattice_.t(i) * direction_;
      const glm::ivec3 cell =
          glm::clamp(glm::ivec3(place / static_cast<float>(view_.cellEdge)), glm::ivec3(0), view_.cellDims - 1);
      const int distance =
          view_.emptyDistances[(size_t(cell.z) * view_.cellDims.y + cell.y) * view_.cellDims.x + cell.x];
      if (distance == 0) return i;
      // Everything less than `distance` cells away is empty: go on where the ray leaves that block. What lies within rounding of the
      // block's border is looked at for itself.
      const glm::vec3 blockLower((cell - (distance - 1)) * view_.cellEdge);
      const glm::vec3 blockUpper((cell + distance) * view_.cellEdge);
      float exit = lattice_.t0 + lattice_.length + lattice_.dt;
      for (int axis = 0; axis < 3; ++axis) {
        const float bound = direction_[axis] < 0.0f ? blockLower[axis] : blockUpper[axis];
        const float t = (bound - origin_[axis]) * invDirection_[axis];
        if (t < exit) exit = t;  // false for NaN: parallel to this side
      }
      const float index = (exit - lattice_.t0) / lattice_.dt - 0.5f - margin_;
      const int next = index < static_cast<float>(lattice_.count) ? static_cast<int>(std::ceil(index)) : lattice_.count;
      i = next > i + 1 ? next : i + 1;
    }
    return i;
  }

  void classify(int i, int n) {
    float weight[3][kBatch];
    int index[3][kBatch];
    float t[kBatch];
    for (int k = 0; k < kBatch; ++k) t[k] = lattice_.t0 + (static_cast<float>(i + k) + 0.5f) * lattice_.dt;
    if (i + n == lattice_.count) t[n - 1] = lattice_.t(i + n - 1);
    int step[3] = {0, 0, 0};
    for (int axis = 0; axis < 3; ++axis) {
      const int voxels = view_.dims[axis];
      step[axis] = voxels > 1 ? 1 : 0;
      for (int k = 0; k < kBatch; ++k) {
        const AxisCell cell = axisCell(origin_[axis] + t[k] * direction_[axis], voxels);
        index[axis][k] = cell.index;
        weight[axis][k] = cell.weight;
      }
    }
    const size_t strideY = static_cast<size_t>(view_.dims.x);
    const size_t strideZ = strideY * view_.dims.y;
    const size_t dx = step[0], dy = step[1] * strideY, dz = step[2] * strideZ;
    float corner[8][kBatch];
    if (kHasPairs<Voxel> && view_.dims.x > 1) {
      // Two neighbours along x in one load: half the loads, and converting them vectorises.
      VoxelPair<Voxel> pairs[4][kBatch];
      for (int k = 0; k < kBatch; ++k) {
        const Voxel* p = view_.voxels + (index[2][k] * strideZ + index[1][k] * strideY + index[0][k]);
        pairs[0][k] = loadPair(p);
        pairs[1][k] = loadPair(p + dy);
        pairs[2][k] = loadPair(p + dz);
        pairs[3][k] = loadPair(p + dz + dy);
      }
      for (int row = 0; row < 4; ++row)
        for (int k = 0; k < kBatch; ++k) {
          corner[2 * row][k] = interpolant(firstOf<Voxel>(pairs[row][k]), view_.scale);
          corner[2 * row + 1][k] = interpolant(secondOf<Voxel>(pairs[row][k]), view_.scale);
        }
    } else {
      for (int k = 0; k < kBatch; ++k) {
        const Voxel* p = view_.voxels + (index[2][k] * strideZ + index[1][k] * strideY + index[0][k]);
        const size_t offsets[8] = {0, dx, dy, dy + dx, dz, dz + dx, dz + dy, dz + dy + dx};
        for (int i = 0; i < 8; ++i) corner[i][k] = interpolant(p[offsets[i]], view_.scale);
      }
    }
    for (int k = 0; k < kBatch; ++k) {
      const float c[8] = {corner[0][k], corner[1][k], corner[2][k], corner[3][k],
                          corner[4][k], corner[5][k], corner[6][k], corner[7][k]};
      float value;
      if constexpr (kHasHoles)
        value = trilinearOfFinite(c, weight[0][k], weight[1][k], weight[2][k]);
      else
        value = trilinear(c, weight[0][k], weight[1][k], weight[2][k]);
      const float unit = unitFromInterpolant<Voxel>(value, view_.scale);
      index_[k] = transferIndex(unit);
      if constexpr (kHasHoles) missing_[k] = !isFiniteVoxel(unit);
    }
  }

  float alpha(int k) const {
    if constexpr (kHasHoles)
      if (missing_[k]) return 0.0f;
    return view_.tableAlpha[index_[k]];
  }
  glm::vec3 color(int k) const { return glm::vec3(view_.table[index_[k]]); }

 private:
  const VolumeView<Voxel>& view_;
  const RayLattice& lattice_;
  glm::vec3 origin_;        // in voxel coordinates
  glm::vec3 direction_;     // voxels per unit of t
  glm::vec3 invDirection_;
  float margin_;            // in steps
  int index_[kBatch];
  bool missing_[kBatch];
};

}  // namespace warpscope

// A scalar volume: voxels in their stored type (never widened), where they lie in the world, and what a renderer wants to know of them.
// Volume space, in which everything is rendered: axes along the voxel grid, origin at the centre, unit = the smallest voxel edge.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <memory>
#include <mutex>
#include <stop_token>
#include <string>
#include <string_view>
#include <vector>

#include "render/core/box.h"

namespace warpscope {

class Ranks;  // base/ranks.h
using RanksPtr = std::shared_ptr<Ranks>;

enum class VoxelType { uint8, int8, uint16, int16, uint32, int32, float32, float64 };

size_t sizeBytes(VoxelType type);
std::string_view nameOf(VoxelType type);

/// Calls `f(T{})` with a value of the C++ type that `type` stands for.
template <class F>
decltype(auto) visitVoxelType(VoxelType type, F&& f) {
  switch (type) {
    case VoxelType::uint8: return f(uint8_t{});
    case VoxelType::int8: return f(int8_t{});
    case VoxelType::uint16: return f(uint16_t{});
    case VoxelType::int16: return f(int16_t{});
    case VoxelType::uint32: return f(uint32_t{});
    case VoxelType::int32: return f(int32_t{});
    case VoxelType::float32: return f(float{});
    case VoxelType::float64: break;
  }
  return f(double{});
}

/// Where the voxel grid lies in the world, in millimetres where the file says so. Host only, double.
struct VolumeGeometry {
  glm::uvec3 dims{0};              ///< voxels along x, y, z; x is fastest in memory
  glm::dvec3 spacing{1.0};         ///< voxel edges, > 0
  glm::dvec3 origin{0.0};          ///< world position of the centre of voxel (0,0,0)
  glm::dmat3 direction{1.0};       ///< columns: unit world directions of the grid's axes; may be left-handed
  bool hasOrientation = false;     ///< the file states patient or world axes (+z up); otherwise +y is taken to be up

  double unitEdge = 0.0;           ///< of a copy with other voxels, the unit of the volume that it is of; 0: its own

  /// One unit of volume space, in world units: the smallest voxel edge, unless it is another's.
  double unit() const { return unitEdge > 0.0 ? unitEdge : glm::min(spacing.x, glm::min(spacing.y, spacing.z)); }
  /// Voxel edges in volume space; the smallest is 1, unless the unit is another's.
  glm::vec3 voxelEdges() const { return glm::vec3(spacing / unit()); }
  /// The box that the voxels fill, in volume space: symmetric about 0.
  Box bounds() const;
};

/// Throws InputError naming `source` unless dims and spacing make sense and the voxel count is representable.
/// Returns the number of voxels.
size_t validate(const VolumeGeometry& geometry, VoxelType type, const std::string& source);

/// Facts about the values, gathered once at load. Non-finite voxels are left out of everything but their count.
struct VoxelStatistics {
  double lowest = 0.0;   ///< least finite value; 0 if there is none
  double highest = 0.0;  ///< greatest finite value
  /// What transfer functions and tables span: the type's range for uint8, [lowest, highest] otherwise.
  double rangeLower = 0.0;
  double rangeUpper = 0.0;
  size_t nonFinite = 0;                    ///< NaN and infinite voxels
  std::array<size_t, 256> histogram{};     ///< over [rangeLower, rangeUpper]
};

/// Rows of voxels, each as long as the volume: from `lower` up to, without, `upper`.
struct VoxelRows {
  glm::uvec2 lower{0}, upper{0};  ///< y and z
};

/// Where voxels come from that are not all in memory from the beginning.
class VoxelSource {
 public:
  virtual ~VoxelSource() = default;

  /// The voxels of these rows are in their places from now on, until they are released. Throws InputError where they cannot be read, OperationCancelled if `stop` is set.
  /// Not while others read voxels.
  virtual void provide(const VoxelRows& rows, const std::stop_token& stop) = 0;
  /// As provide(), for whoever looks at some rows after the other: others' memory is let go of where there is no room for all. They stay as long as what is returned is kept;
  /// nobody else holds any meanwhile, where the same thread is never to ask twice.
  virtual std::unique_lock<std::mutex> hold(const VoxelRows& rows, const std::stop_token& stop) {
    provide(rows, stop);
    return {};
  }
  /// No voxel is needed for now: their memory is let go of. Not while others read voxels.
  virtual void release() = 0;
  /// Where two processes have the same here, they read the same voxels: file_stamp.h. Empty: nothing but the voxels tells.
  virtual std::string stamp() const { return ""; }
};

/// Immutable after construction and shared between threads.
class Volume {
 public:
  /// `storage` keeps `voxels` alive (a mapped file, a vector). Scans all voxels once or twice, in parallel.
  /// `ranks`: processes that have the same volume and make this object, and whatever is made of all of its voxels, at the same time, each from a share of them; null:
  /// this one alone.
  /// `source`: of voxels that are in their places once they have been asked for (provide(), hold()); null: all are.
  /// Throws InputError if the geometry makes no sense or ranks have different volumes, OperationCancelled if `stop` is set.
  Volume(std::string name, VoxelType type, const VolumeGeometry& geometry, std::shared_ptr<const void> storage, const void* voxels, const std::stop_token& stop = {},
         RanksPtr ranks = nullptr, std::shared_ptr<VoxelSource> source = nullptr);

  const std::string& name() const { return name_; }
  VoxelType type() const { return type_; }
  const VolumeGeometry& geometry() const { return geometry_; }
  const glm::uvec3& dims() const { return geometry_.dims; }
  const Box& bounds() const { return bounds_; }
  const VoxelStatistics& statistics() const { return statistics_; }
  size_t voxelCount() const { return size_t{dims().x} * dims().y * dims().z; }
  size_t sizeBytes() const { return voxelCount() * warpscope::sizeBytes(type_); }

  /// Null where this process has the volume for itself.
  const RanksPtr& ranks() const { return ranks_; }
  /// Whoever reads voxels of a volume that ranks share asks for them first, and lets go of them: VoxelSource. Where no ranks do he holds them.
  void provide(const VoxelRows& rows, const std::stop_token& stop = {}) const {
    if (source_) source_->provide(rows, stop);
  }
  /// VoxelSource::hold().
  std::unique_lock<std::mutex> hold(const VoxelRows& rows, const std::stop_token& stop = {}) const {
    return source_ ? source_->hold(rows, stop) : std::unique_lock<std::mutex>();
  }
  void releaseVoxels() const {
    if (source_) source_->release();
  }

  const void* voxels() const { return voxels_; }
  template <class T>
  const T* voxelsAs() const {
    return static_cast<const T*>(voxels_);
  }

 private:
  std::string name_;
  VoxelType type_;
  VolumeGeometry geometry_;
  Box bounds_;
  std::shared_ptr<const void> storage_;
  const void* voxels_;
  RanksPtr ranks_;
  std::shared_ptr<VoxelSource> source_;
  VoxelStatistics statistics_;
};

using VolumePtr = std::shared_ptr<const Volume>;

}  // namespace warpscope

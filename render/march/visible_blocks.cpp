// Boxes to rectangles of blocks, each with its nearest depth.
// See visible_blocks.h.
#include "render/march/visible_blocks.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace warpscope {

namespace {

/// So few that drawing them takes less than a millisecond.
constexpr size_t kMostBoxes = 1 << 15;

constexpr float kInfinity = std::numeric_limits<float>::infinity();

/// By how much a ray's places and a box's, in volume space, may be apart from where they are in exact arithmetic, relative to the size of what is added
/// up: kPositionError of the former is the most of it. Sixteen times as much costs nothing.
constexpr float kPlaceMargin = 0x1p-17f;

/// The same of columns and rows, beside roundings of numbers of up to 2^14: rays pass through pixels' centres.
constexpr float kPixelMargin = 0.5f;

}  // namespace

std::vector<Box> visibleSurface(const EmptyCells& cells, const glm::ivec3& voxels) {
  const glm::ivec3 dims = cells.dims;
  const size_t rowStride = static_cast<size_t>(dims.x), sliceStride = rowStride * static_cast<size_t>(dims.y);
  std::vector<glm::ivec3> surface;
  for (int z = 0; z < dims.z; ++z)
    for (int y = 0; y < dims.y; ++y) {
      const uint8_t* row = cells.distances + static_cast<size_t>(z) * sliceStride + static_cast<size_t>(y) * rowStride;
      const bool isInner = y > 0 && y + 1 < dims.y && z > 0 && z + 1 < dims.z;
      for (int x = 0; x < dims.x; ++x) {
        const uint8_t* cell = row + x;
        if (*cell != 0) continue;
        if (isInner && x > 0 && x + 1 < dims.x &&
            (cell[-1] | cell[1] | *(cell - rowStride) | cell[rowStride] | *(cell - sliceStride) | cell[sliceStride]) == 0)
          continue;
        surface.emplace_back(x, y, z);
      }
    }
  int bits = 0;
  while (surface.size() > kMostBoxes) {
    ++bits;
    for (glm::ivec3& cell : surface) cell >>= 1;
    const auto before = [](const glm::ivec3& a, const glm::ivec3& b) {
      return a.z != b.z ? a.z < b.z : a.y != b.y ? a.y < b.y : a.x < b.x;
    };
    surface.erase(std::unique(surface.begin(), surface.end()), surface.end());  // neighbours along x, before sorting
    std::sort(surface.begin(), surface.end(), before);
    surface.erase(std::unique(surface.begin(), surface.end()), surface.end());
  }
  std::vector<Box> boxes;
  boxes.reserve(surface.size());
  for (const glm::ivec3& cell : surface) {
    const glm::vec3 lower(cell << bits << cells.edgeBits), upper((cell + 1) << bits << cells.edgeBits);
    // Cells at the ends hold what lies beyond the outermost voxels' centres.
    Box box;
    for (int axis = 0; axis < 3; ++axis) {
      const float last = static_cast<float>(voxels[axis]) - 0.5f;
      box.lower[axis] = lower[axis] > 0.0f ? lower[axis] : -0.5f;
      box.upper[axis] = upper[axis] < last - 0.5f ? upper[axis] : last;
    }
    boxes.push_back(box);
  }
  return boxes;
}

VisibleBlocks::VisibleBlocks(const PixelGrid& pixels, uint32_t width, uint32_t height, std::span<const Box> surface, const glm::vec3& lower,
                             const glm::vec3& voxelEdges)
    : columns_((width + kSide - 1) / kSide), depths_(size_t{columns_} * ((height + kSide - 1) / kSide), VisibleDepths{kInfinity, -kInfinity}) {
  if (!draw(pixels, width, height, surface, lower, voxelEdges)) std::fill(depths_.begin(), depths_.end(), VisibleDepths{0.0f, kInfinity});
}

bool VisibleBlocks::draw(const PixelGrid& pixels, uint32_t width, uint32_t height, std::span<const Box> surface, const glm::vec3& lower,
                         const glm::vec3& voxelEdges) {
  if (surface.empty()) return true;
  if (!(pixels.nearDepth > 0.0f)) return false;
  const auto rows = static_cast<uint32_t>(depths_.size() / columns_);
  Box all;
  for (const Box& box : surface) all.include(box);
  const auto inVolume = [&](const glm::vec3& voxel) { return lower + (voxel + 0.5f) * voxelEdges; };
  const glm::vec3 farthest = glm::max(glm::abs(inVolume(all.lower) - pixels.anchor), glm::abs(inVolume(all.upper) - pixels.anchor));
  const float size = glm::length(pixels.anchor) + glm::length(lower) + 2.0f * glm::length(farthest);
  const float margin = kPlaceMargin * size;
  const glm::vec3 right = glm::abs(pixels.right), up = glm::abs(pixels.up), forward = glm::abs(pixels.forward);
  const float pixelsPerUnit = 1.0f / pixels.edge;
  const auto lastColumn = static_cast<float>(width - 1), lastRow = static_cast<float>(height - 1);
  for (const Box& box : surface) {
    const glm::vec3 half = 0.5f * (box.upper - box.lower) * voxelEdges + margin;
    const glm::vec3 center = inVolume(box.center()) - pixels.anchor;
    const float behind = glm::dot(center, pixels.forward), halfDepth = glm::dot(half, forward) + margin;
    const float begins = pixels.nearDepth + (behind - halfDepth), ends = pixels.nearDepth + (behind + halfDepth);
    if (!(begins > 0.0f)) return false;
    const float x = glm::dot(center, pixels.right), halfX = glm::dot(half, right) + margin;
    const float y = glm::dot(center, pixels.up), halfY = glm::dot(half, up) + margin;
    // The largest and the least of a coordinate's quotients by any depth of the box, in pixels.
    const auto largest = [&](float coordinate) { return coordinate / (coordinate > 0.0f ? begins : ends) * pixelsPerUnit; };
    const float left = pixels.halfWidth - 0.5f - largest(halfX - x) - kPixelMargin, rightmost = pixels.halfWidth - 0.5f + largest(x + halfX) + kPixelMargin;
    const float top = pixels.halfHeight - 0.5f - largest(y + halfY) - kPixelMargin, bottom = pixels.halfHeight - 0.5f + largest(halfY - y) + kPixelMargin;
    if (std::isnan(left + rightmost) || std::isnan(top + bottom)) return false;  // beyond single precision's range
    if (rightmost < 0.0f || left > lastColumn || bottom < 0.0f || top > lastRow) continue;
    const auto column0 = static_cast<uint32_t>(std::max(left, 0.0f)) / kSide, column1 = static_cast<uint32_t>(std::min(rightmost, lastColumn)) / kSide;
    const auto row0 = static_cast<uint32_t>(std::max(top, 0.0f)) / kSide, row1 = static_cast<uint32_t>(std::min(bottom, lastRow)) / kSide;
    const VisibleDepths depths{std::max(behind - halfDepth, 0.0f), behind + halfDepth};
    for (uint32_t row = row0; row <= row1 && row < rows; ++row)
      for (uint32_t column = column0; column <= column1; ++column) {
        VisibleDepths& held = depths_[size_t{row} * columns_ + column];
        held.nearest = std::min(held.nearest, depths.nearest);
        held.farthest = std::max(held.farthest, depths.farthest);
      }
  }
  return true;
}

}  // namespace warpscope

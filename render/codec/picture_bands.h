// How a picture is cut into pieces that are coded by themselves, on all cores: whole rows, a multiple of those of a JPEG's blocks.
// Ours; of samples and of segments alike.
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>

#include "render/core/camera.h"

namespace warpscope {

class PictureBands {
 public:
  /// None.
  PictureBands() = default;
  explicit PictureBands(const Camera& camera)
      : height_(camera.height), rows_(std::max(kPixels / std::max(camera.width, 1u) / kBlockRows, 1u) * kBlockRows), count_((height_ + rows_ - 1) / rows_) {}

  size_t count() const { return count_; }
  uint32_t firstRow(size_t band) const { return static_cast<uint32_t>(band) * rows_; }
  uint32_t rowCount(size_t band) const { return std::min(rows_, height_ - firstRow(band)); }

 private:
  static constexpr uint32_t kPixels = 1 << 17, kBlockRows = 16;

  uint32_t height_ = 0, rows_ = kBlockRows;
  size_t count_ = 0;
};

}  // namespace warpscope

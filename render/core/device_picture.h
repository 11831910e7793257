// A finished picture where a device left it: a window on the same device shows it without a way through host memory.
// Free of CUDA itself.
#pragma once

#include <cstdint>
#include <memory>
#include <span>

#include "render/core/color.h"

namespace warpscope {

class DevicePicture {
 public:
  virtual ~DevicePicture() = default;

  virtual uint32_t width() const = 0;
  virtual uint32_t height() const = 0;
  /// Copies width x height pixels, row by row from the top; fastest into page-locked memory (cuda/pinned_memory.h). Throws DeviceError.
  virtual void download(std::span<Rgba8> pixels) const = 0;
};

using DevicePicturePtr = std::shared_ptr<const DevicePicture>;

}  // namespace warpscope

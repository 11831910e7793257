// A finished picture, wherever it lies: in host memory, or on the device that drew it.
#pragma once

#include <memory>

#include "render/core/device_picture.h"
#include "render/core/image.h"

namespace warpscope {

/// Holds one of the two, or none.
struct ShownPicture {
  std::shared_ptr<const Image<Rgba8>> host;
  DevicePicturePtr device;

  explicit operator bool() const { return host || device; }
  uint32_t width() const { return host ? host->width() : device ? device->width() : 0; }
  uint32_t height() const { return host ? host->height() : device ? device->height() : 0; }
  bool operator==(const ShownPicture&) const = default;
};

}  // namespace warpscope

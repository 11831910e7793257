// Device pictures into OpenGL textures, without a way through host memory. Free of CUDA and of OpenGL's headers.
// CUDA Runtime API, "OpenGL Interoperability".
#pragma once

#include <memory>
#include <string>

#include "render/core/device_picture.h"

namespace warpscope::cuda {

/// Why the current OpenGL context cannot take pictures from the CUDA device; empty if it can. A context must be current.
std::string whyNoInterop();

/// A texture of the current context, registered with CUDA. That context must be current whenever it is used or destroyed, and the texture
/// must keep its storage for as long.
class InteropTexture {
 public:
  /// `texture`: a 2D texture of format RGBA8 with storage of width x height. Throws DeviceError.
  InteropTexture(unsigned texture, uint32_t width, uint32_t height);
  ~InteropTexture();

  /// Copies a picture of the texture's size. Throws DeviceError; InputError for a picture of another size or device.
  void show(const DevicePicture& picture);

 private:
  struct Registration;
  std::unique_ptr<Registration> registration_;
};

}  // namespace warpscope::cuda

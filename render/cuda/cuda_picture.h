// A picture in CUDA memory. For .cu files and what they include.
#pragma once

#include "render/core/device_picture.h"
#include "render/cuda/memory.h"

namespace warpscope::cuda {

/// Its maker writes to it before anybody else holds it, and waits until that is done.
class CudaPicture final : public DevicePicture {
 public:
  void resize(uint32_t width, uint32_t height) {
    pixels_.reserve(size_t{width} * height);
    width_ = width;
    height_ = height;
  }
  Rgba8* data() { return pixels_.data(); }
  const Rgba8* data() const { return pixels_.data(); }
  uint32_t width() const override { return width_; }
  uint32_t height() const override { return height_; }
  void download(std::span<Rgba8> pixels) const override {
    const size_t count = size_t{width_} * height_;
    if (pixels.size() < count) throw std::logic_error("a picture needs room for all of its pixels");
    WARPSCOPE_CUDA_CHECK(cudaMemcpy(pixels.data(), pixels_.data(), count * sizeof(Rgba8), cudaMemcpyDeviceToHost));
  }

 private:
  DeviceBuffer<Rgba8> pixels_;
  uint32_t width_ = 0;
  uint32_t height_ = 0;
};

}  // namespace warpscope::cuda

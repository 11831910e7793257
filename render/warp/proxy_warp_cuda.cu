// A march for each pixel, on the device.
// See proxy_warp_cuda.h.
#include "render/warp/proxy_warp_cuda.h"

#include "render/cuda/pixel_tiles.cuh"
#include "render/warp/device/device_proxy.h"
#include "render/warp/device/device_warp.h"
#include "render/warp/proxy_fill.h"

namespace warpscope {
namespace {

template <class March>
__global__ void __launch_bounds__(kTileBlockThreads)
    marchProxy(const __grid_constant__ PixelGrid pixels, uint32_t width, uint32_t height, const __grid_constant__ March march, DevicePixels out) {
  const PixelPlace pixel = pixelOfThread(0);
  if (pixel.x >= width || pixel.y >= height) return;
  const glm::vec4 color = march(pixels.ray(pixel.x, pixel.y).ray, 0.0f, std::numeric_limits<float>::infinity(), 1.0f).premultiplied();
  const size_t i = size_t{pixel.y} * width + pixel.x;
  out.color[i] = color;
  out.samples[i] = color.a > 0.0f ? kNotASample : kNoSample;
}

class CudaProxyWarp final : public DeviceWarp {
 private:
  bool blends() const override { return true; }

  void upload(const SampleFrame& frame, cudaStream_t) override {
    proxy_ = frame.proxy;
    settings_ = frame.settings.render;
  }
  void build(const DeviceFrameView&, const WarpSettings&, cudaStream_t) override {}

  void trace(const DeviceFrameView&, const Camera& camera, const WarpSettings&, const DevicePixels& pixels, cudaStream_t stream) override {
    if (!proxy_) return clearPixels(camera, pixels, stream);
    fill_.visit(proxy_, settings_, camera, [&](const auto& march, const auto& baked) {
      const PixelGrid grid = makePixelGrid(camera, depthRangeOf(camera, march.clip.bounds).nearDepth);
      deviceProxy_.visit(proxy_, march, baked, stream, [&](const auto& onDevice) {
        marchProxy<<<tileGrid(camera.width, camera.height), kTileBlockThreads, 0, stream>>>(grid, camera.width, camera.height, onDevice, pixels);
        WARPSCOPE_CUDA_CHECK_LAUNCH();
      });
    });
  }

  ProxyPtr proxy_;
  RenderSettings settings_;
  ProxyFill fill_;
  DeviceProxy deviceProxy_;
};

}  // namespace

std::unique_ptr<Warp> makeCudaProxyWarp() { return std::make_unique<CudaProxyWarp>(); }

}  // namespace warpscope

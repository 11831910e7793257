// Splats: nothing to build.
// See splats_warp_cuda.h.
#include "render/warp/splats_warp_cuda.h"

#include "render/warp/device/device_warp.h"
#include "render/warp/splats/device_splats.h"

namespace warpscope {
namespace {

class CudaSplatsWarp final : public DeviceWarp {
 private:
  void build(const DeviceFrameView&, const WarpSettings&, cudaStream_t) override {}
  void trace(const DeviceFrameView& frame, const Camera& camera, const WarpSettings&, const DevicePixels& pixels,
             cudaStream_t stream) override {
    splats_.draw(frame, camera, pixels.samples, nullptr, stream);
  }

  DeviceSplats splats_;
};

}  // namespace

std::unique_ptr<Warp> makeCudaSplatsWarp() { return std::make_unique<CudaSplatsWarp>(); }

}  // namespace warpscope

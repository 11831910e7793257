// Spheres behind one of two hierarchies.
// See spheres_warp_cuda.h.
#include "render/warp/spheres_warp_cuda.h"

#include "render/warp/arithmetic_knob.h"
#include "render/warp/clusters/cluster_tree.h"
#include "render/warp/device/device_warp.h"
#include "render/warp/lbvh/device_lbvh.h"
#include "render/warp/spheres_warp.h"

namespace warpscope {
namespace {

class CudaSpheresWarp final : public DeviceWarp {
 private:
  static Arithmetic arithmeticOf(const WarpSettings& settings) { return settings.knobs.choice<Arithmetic>(kArithmeticKnob); }
  static bool usesLbvh(const WarpSettings& settings) {
    const auto tracing = settings.knobs.choice<SphereTracing>(kSphereTracingKnob);
    if (tracing == SphereTracing::embree) throw UsageError("Embree traces on the CPU: choose --backend cpu, or another hierarchy");
    requireTraceable(settings);
    return tracing == SphereTracing::lbvh || arithmeticOf(settings) == Arithmetic::textbook;
  }

  bool needsBuild(const WarpSettings& settings) const override { return usesLbvh(settings) != isLbvh_; }

  void build(const DeviceFrameView& frame, const WarpSettings& settings, cudaStream_t stream) override {
    isLbvh_ = usesLbvh(settings);
    if (isLbvh_)
      lbvh_.build(frame, stream);
    else
      clusters_.build(frame, stream);
  }

  void trace(const DeviceFrameView&, const Camera& camera, const WarpSettings& settings, const DevicePixels& pixels, cudaStream_t stream) override {
    if (!isLbvh_) return clusters_.trace(camera, pixels.samples, nullptr, stream);
    WARPSCOPE_CUDA_CHECK(cudaMemsetAsync(deviceOverflow_.data(), 0, sizeof(uint32_t), stream));
    lbvh_.trace(camera, pixels.samples, nullptr, deviceOverflow_.data(), stream, arithmeticOf(settings));
    WARPSCOPE_CUDA_CHECK(cudaMemcpyAsync(overflow_.data(), deviceOverflow_.data(), sizeof(uint32_t), cudaMemcpyDeviceToHost, stream));
  }

  void checkTrace() override {
    if (isLbvh_ && *overflow_ != 0) throw std::logic_error("the sphere hierarchy is deeper than its keys allow");
  }

  bool isLbvh_ = false;
  DeviceClusterTree clusters_;
  DeviceLbvh lbvh_;
  cuda::DeviceBuffer<uint32_t> deviceOverflow_{1};
  cuda::PinnedValue<uint32_t> overflow_;
};

}  // namespace

std::unique_ptr<Warp> makeCudaSpheresWarp() { return std::make_unique<CudaSpheresWarp>(); }

}  // namespace warpscope

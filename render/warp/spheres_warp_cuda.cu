// Spheres behind one of two hierarchies, or of none; drawn out to capsules behind one of them.
// See spheres_warp_cuda.h.
#include "render/warp/spheres_warp_cuda.h"

#include "render/warp/arithmetic_knob.h"
#include "render/warp/clusters/cluster_tree.h"
#include "render/warp/device/device_warp.h"
#include "render/warp/device/sphere_samples.h"
#include "render/warp/lbvh/device_lbvh.h"
#include "render/warp/lbvh/sample_capsules.h"
#include "render/warp/sphere_ways.h"
#include "render/warp/splats/device_splats.h"
#include "render/warp/spheres_warp.h"

namespace warpscope {
namespace {

constexpr unsigned kTracedThreads = 256;

__global__ void drawOut(DeviceFrameView frame, const float* spreads, float factor, glm::vec3* halfLines) {
  const uint32_t i = blockIdx.x * kTracedThreads + threadIdx.x;
  if (i < frame.count) halfLines[i] = halfLineOf(frame.grid, frame.samples[i], spreads[i], factor);
}

class CudaSpheresWarp final : public DeviceWarp {
 private:
  static float smearOf(const WarpSettings& settings) { return settings.knobs.number(kSmearKnob); }

  static Arithmetic arithmeticOf(const WarpSettings& settings) { return settings.knobs.choice<Arithmetic>(kArithmeticKnob); }

  /// What the settings ask for; automatic where that depends on the view.
  SphereTracing askedFor(const WarpSettings& settings) const {
    const auto tracing = settings.knobs.choice<SphereTracing>(kSphereTracingKnob);
    if (tracing == SphereTracing::embree) throw UsageError("Embree traces on the CPU: choose --backend cpu, or another way of tracing (--via)");
    requireTraceable(settings);
    if (isSmeared(settings)) requireCapsules(settings);
    return isSmeared(settings) || arithmeticOf(settings) == Arithmetic::textbook ? SphereTracing::lbvh : tracing;
  }

  bool isSmeared(const WarpSettings& settings) const { return hasSpreads_ && smearOf(settings) > 0.0f; }

  bool prepare(const WarpSettings& settings, const Camera& camera) override {
    way_ = askedFor(settings);
    if (way_ == SphereTracing::automatic) way_ = sphereCosts(probe_.loadFor(camera)).favourFootprints() ? SphereTracing::footprints : SphereTracing::clusters;
    if (way_ == SphereTracing::footprints) return false;
    return way_ != built_ || (hasSpreads_ && smearOf(settings) != smear_);
  }

  void upload(const SampleFrame& frame, cudaStream_t stream) override {
    DeviceWarp::upload(frame, stream);
    const SamplePlane* const plane = spreadsOf(frame);
    hasSpreads_ = plane != nullptr;
    if (hasSpreads_) spreads_.upload(plane->values, stream);
    probe_ = spheres_.probeOf(frame, frameThere().view(), stream);
    way_ = SphereTracing::automatic;
  }

  /// Where the way depends on the view nothing is built before there is one.
  void build(const DeviceFrameView& frame, const WarpSettings& settings, cudaStream_t stream) override {
    const SphereTracing wanted = way_ == SphereTracing::automatic ? askedFor(settings) : way_;
    built_ = SphereTracing::automatic;  // if this fails
    smear_ = smearOf(settings);
    if (wanted == SphereTracing::clusters) clusters_.build(frame, stream);
    if (wanted == SphereTracing::lbvh) buildLbvh(frame, settings, stream);
    built_ = wanted;
  }

  void buildLbvh(const DeviceFrameView& frame, const WarpSettings& settings, cudaStream_t stream) {
    if (!isSmeared(settings)) return lbvh_.build(frame, stream);
    halfLines_.reserve(frame.count);
    if (frame.count > 0) {
      drawOut<<<cuda::blocksFor(frame.count, kTracedThreads), kTracedThreads, 0, stream>>>(frame, reinterpret_cast<const float*>(spreads_.data()), smear_, halfLines_.data());
      WARPSCOPE_CUDA_CHECK_LAUNCH();
    }
    lbvh_.build(frame, stream, halfLines_.data());
  }

  void trace(const DeviceFrameView& frame, const Camera& camera, const WarpSettings& settings, const DevicePixels& pixels, cudaStream_t stream) override {
    if (way_ == SphereTracing::footprints) return splats_.draw(frame, camera, pixels.samples, nullptr, stream);
    if (way_ == SphereTracing::clusters) return clusters_.trace(camera, pixels.samples, nullptr, stream);
    WARPSCOPE_CUDA_CHECK(cudaMemsetAsync(deviceOverflow_.data(), 0, sizeof(uint32_t), stream));
    lbvh_.trace(camera, pixels.samples, nullptr, deviceOverflow_.data(), stream, arithmeticOf(settings));
    WARPSCOPE_CUDA_CHECK(cudaMemcpyAsync(overflow_.data(), deviceOverflow_.data(), sizeof(uint32_t), cudaMemcpyDeviceToHost, stream));
  }

  void checkTrace() override {
    if (way_ == SphereTracing::lbvh && *overflow_ != 0) throw std::logic_error("the sphere hierarchy is deeper than its keys allow");
  }

  SphereTracing way_ = SphereTracing::automatic;  // of the picture being made; automatic before the first of a frame
  SphereTracing built_ = SphereTracing::automatic;  // the hierarchy that stands, if it is one
  float smear_ = 0.0f;
  bool hasSpreads_ = false;
  SphereSamples spheres_;
  SphereLoadProbe probe_;
  cuda::DeviceBuffer<std::byte> spreads_;  // floats; see kSpreadPlane
  cuda::DeviceBuffer<glm::vec3> halfLines_;
  DeviceClusterTree clusters_;
  DeviceLbvh lbvh_;
  DeviceSplats splats_;
  cuda::DeviceBuffer<uint32_t> deviceOverflow_{1};
  cuda::PinnedValue<uint32_t> overflow_;
};

}  // namespace

std::unique_ptr<Warp> makeCudaSpheresWarp() { return std::make_unique<CudaSpheresWarp>(); }

}  // namespace warpscope

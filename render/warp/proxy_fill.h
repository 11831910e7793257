// How pictures of a frame go on where the frame knows nothing: through the coarse copy of the volume that came with it. On the host.
// The copy is marched as the volume is, by the same formulas (march/proxy_march.h), with a longer step.
#pragma once

#include <limits>
#include <stop_token>
#include <type_traits>

#include "render/base/error.h"
#include "render/core/floating_point.h"
#include "render/core/parallel.h"
#include "render/march/march_setup.h"
#include "render/march/proxy_march.h"
#include "render/march/sample_frame.h"

namespace warpscope {

/// Whether what `proxy` has in part of a ray is what pictures of the volume by `settings` have there: values are the volume's, and nothing changes light that a march through a copy does not know.
bool showsTheVolume(const Proxy& proxy, const RenderSettings& settings);

/// Keeps what pictures of a copy are marched by, from picture to picture. One thread at a time.
class ProxyFill {
 public:
  /// Calls f(march, baked) with the ProxyMarch of `proxy` seen by `camera`, where pictures of the volume are by `settings`, and what it points into.
  template <class F>
  decltype(auto) visit(const ProxyPtr& proxy, const RenderSettings& settings, const Camera& camera, F&& f) {
    take(proxy);
    const RenderSettings own = settingsFor(settings);
    const std::shared_ptr<const BakedTransfer> baked = marched_->bakedFor(own);
    const EffectPlan plan = planFor(*marched_, *baked, baked->visibleCells, own, std::nullopt);
    VolumeView<uint8_t> view = makeVolumeView<uint8_t>(*marched_);
    view.voxels = marched_->volume->voxelsAs<uint8_t>();
    view.transfer = baked->table.lookup();
    view.cells.distances = baked->emptyDistances.data();
    const ShadingSetup shading = shadingFor(*marched_, camera, own, plan);
    const ClipSetup clip = prepareClip(own.effects.clip, *marched_->volume, camera);
    const auto with = [&]<class Source>(std::type_identity<Source>, const typename ProxySetup<Source>::Type& setup, const auto& light) {
      return f(ProxyMarch<Source, std::decay_t<decltype(light)>>{view, setup, light, clip, limitsOf(own, plan), own.step, plan.has(PlanStage::clip)},
               baked);
    };
    if (own.effects.mode == RenderMode::mip) return with(std::type_identity<MipProxySource>(), {}, Unlit{});  // so small that nothing is leapt over
    return visitLight(shading, [&](const auto& light) {
      if (own.effects.mode == RenderMode::isosurface) return with(std::type_identity<IsosurfaceProxySource>(), baked->surfaces, light);
      return with(std::type_identity<CompositeProxySource>(), {}, light);
    });
  }

  /// Calls f(x, y, lightOf) for each pixel of `camera`, in parallel; lightOf() is what the frame's copy alone shows there: linear, premultiplied. Throws
  /// OperationCancelled if `stop` is set.
  template <class F>
  void drawRays(const SampleFrame& frame, const Camera& camera, const std::stop_token& stop, const F& f) {
    visit(frame.proxy, frame.settings.render, camera, [&](const auto& march, const auto& /*baked*/) {
      const PixelGrid pixels = makePixelGrid(camera, depthRangeOf(camera, march.clip.bounds).nearDepth);
      constexpr uint32_t kTileSide = 32;
      parallelForTiles(camera.width, camera.height, kTileSide, stop, [&](uint32_t x0, uint32_t y0, uint32_t x1, uint32_t y1) {
        for (uint32_t y = y0; y < y1; ++y)
          for (uint32_t x = x0; x < x1; ++x)
            f(x, y, [&] { return exceptionsExpected([&] { return march(pixels.ray(x, y).ray, 0.0f, std::numeric_limits<float>::infinity(), 1.0f).premultiplied(); }); });
      });
    });
  }

 private:
  void take(const ProxyPtr& proxy);
  /// Half of the copy's shortest voxel edge is step enough, and what is not worth its time is left out.
  RenderSettings settingsFor(const RenderSettings& settings) const;

  ProxyPtr proxy_;
  MarchedVolumePtr marched_;  // of it
};

}  // namespace warpscope

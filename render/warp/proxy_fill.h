// How pictures of a frame go on where the frame knows nothing: through the coarse copy of the volume that came with it. On the host.
#pragma once

#include "render/march/march_setup.h"
#include "render/march/proxy_march.h"
#include "render/march/sample_frame.h"

namespace warpscope {

/// Keeps what a copy's pictures are marched by, from picture to picture.
class ProxyFill {
 public:
  /// Calls f(march) with the ProxyMarch of `proxy` seen by `camera`, for pictures by `settings`, which are those of the volume.
  template <class F>
  decltype(auto) visit(const ProxyScene& proxy, const RenderSettings& settings, const Camera& camera, F&& f) {
    const RenderSettings own = proxy.settingsFor(settings);
    const MarchedVolume& marched = *proxy.marched();
    const std::shared_ptr<const BakedTransfer> baked = marched.bakedFor(own);
    const EffectPlan plan = planFor(marched, *baked, baked->visibleCells, own, std::nullopt);
    VolumeView<uint8_t> view = makeVolumeView<uint8_t>(marched);
    view.voxels = marched.volume->voxelsAs<uint8_t>();
    view.transfer = baked->table.lookup();
    view.cells.distances = baked->emptyDistances.data();
    return visitLight(shadingFor(marched, camera, own, plan), [&](const auto& light) {
      return f(ProxyMarch<std::decay_t<decltype(light)>>{view, light, prepareClip(own.effects.clip, *marched.volume, camera), limitsOf(own, plan), own.step,
                                                         plan.has(PlanStage::clip)});
    });
  }
};

}  // namespace warpscope

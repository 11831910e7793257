// The copy as a marched volume.
// See proxy_fill.h.
#include "render/warp/proxy_fill.h"

#include <algorithm>

namespace warpscope {
bool showsTheVolume(const Proxy& proxy, const RenderSettings& settings) {
  const Effects& effects = settings.effects;
  const bool isShadowed = effects.shading.strength > 0.0f && (effects.shadows.strength > 0.0f || effects.shadows.occlusion > 0.0f);
  // The greatest value of a ray is not that of its parts.
  return proxy.isExact && effects.mode != RenderMode::mip && !effects.preIntegration && !isShadowed;
}

void ProxyFill::take(const ProxyPtr& proxy) {
  if (proxy == proxy_) return;
  marched_ = std::make_shared<const MarchedVolume>(proxy->volume, functionOfCodes(*proxy));
  proxy_ = proxy;
}

RenderSettings ProxyFill::settingsFor(const RenderSettings& settings) const {
  const glm::vec3 edges = proxy_->volume->geometry().voxelEdges();
  RenderSettings own = settings;
  own.step = std::max(settings.step, 0.5f * std::min({edges.x, edges.y, edges.z}));
  own.effects.jitter = 0.0f;
  own.effects.preIntegration = false;
  IsoValues codes;
  for (IsoValue value : settings.effects.isoValues) {
    value.value = proxy_->scale.codeOf(value.value);
    codes.add(value);
  }
  own.effects.isoValues = codes;
  return own;
}

}  // namespace warpscope

// The copy as a marched volume.
// See proxy_fill.h.
#include "render/warp/proxy_fill.h"

#include <algorithm>

namespace warpscope {
namespace {

/// What is faithful loses no more: a share of full light or opacity, as pixels may disagree by (pixel_views.h).
constexpr float kMostLostByRounding = 1.0f / 32;

}  // namespace

bool ProxyFill::showsTheVolume(const ProxyPtr& proxy, const RenderSettings& settings) {
  take(proxy);
  const Effects& effects = settings.effects;
  const bool isShadowed = effects.shading.strength > 0.0f && (effects.shadows.strength > 0.0f || effects.shadows.occlusion > 0.0f);
  // The greatest value of a ray is not that of its parts.
  return isFaithful_ && effects.mode != RenderMode::mip && !effects.preIntegration && !isShadowed;
}

void ProxyFill::take(const ProxyPtr& proxy) {
  if (proxy == proxy_) return;
  marched_ = std::make_shared<const MarchedVolume>(proxy->volume, functionOfCodes(*proxy));
  isFaithful_ = proxy->hasAllVoxels && looksLostByRounding(*proxy) <= kMostLostByRounding;
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

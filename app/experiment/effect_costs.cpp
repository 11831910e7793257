// Rounds of marches, each with other effects.
// See effect_costs.h.
#include "app/experiment/effect_costs.h"

#include <algorithm>
#include <array>
#include <cstring>
#include <optional>

#include "render/base/error.h"

namespace warpscope {
namespace {

constexpr std::array<MeasuredEffect, 8> kEffects{{
    {"shading", "by a light at the eye", [](const Effects& effects) { return effects.shading.strength > 0.0f; },
     [](Effects& effects) { effects.shading.strength = 0.0f; }, [](Effects& effects, const Volume&) { effects.shading.strength = 1.0f; }},
    {"shadows", "of a light at the upper left", [](const Effects& effects) { return effects.shadows.strength > 0.0f; },
     [](Effects& effects) { effects.shadows.strength = 0.0f; },
     [](Effects& effects, const Volume&) {
       effects.shadows.strength = 1.0f;
       if (std::ranges::all_of(effects.lights, [](const Light& light) { return light.kind == LightKind::headlight; }))  // whose shadows nobody sees
         effects.lights = parseLights("camera:-1,1,1", "the example");
     },
     "shading"},
    {"occlusion", "of ambient light", [](const Effects& effects) { return effects.shadows.occlusion > 0.0f; },
     [](Effects& effects) { effects.shadows.occlusion = 0.0f; }, [](Effects& effects, const Volume&) { effects.shadows.occlusion = 1.0f; }, "shading"},
    {"jitter", "of half a step", [](const Effects& effects) { return effects.jitter > 0.0f; },
     [](Effects& effects) { effects.jitter = 0.0f; }, [](Effects& effects, const Volume&) { effects.jitter = 1.0f; }},
    {"pre-integration", "of steps", [](const Effects& effects) { return effects.preIntegration; },
     [](Effects& effects) { effects.preIntegration = false; }, [](Effects& effects, const Volume&) { effects.preIntegration = true; }},
    {"clip-planes", "through the centre", [](const Effects& effects) { return effects.clip.planes.size() > 0; },
     [](Effects& effects) { effects.clip.planes = {}; },
     [](Effects& effects, const Volume&) { effects.clip.planes.add({glm::vec3(1.0f, 0.0f, 0.0f), 0.0f}); }},
    {"clip-box", "three quarters along each axis", [](const Effects& effects) { return effects.clip.box != ClipBox{}; },
     [](Effects& effects) { effects.clip.box = {}; },
     [](Effects& effects, const Volume&) { effects.clip.box = {glm::vec3(0.125f), glm::vec3(0.875f)}; }},
    {"slab", "half as thick as the volume", [](const Effects& effects) { return effects.clip.slab.thickness > 0.0f; },
     [](Effects& effects) { effects.clip.slab = {}; },
     [](Effects& effects, const Volume& volume) {
       const glm::vec3 extent = volume.bounds().extent();
       effects.clip.slab.thickness = 0.5f * glm::max(extent.x, glm::max(extent.y, extent.z));
     }},
}};

/// Of the effect without which this one does nothing, its place; nothing if there is none.
std::optional<size_t> neededBy(const MeasuredEffect& effect) {
  for (size_t i = 0; i < kEffects.size(); ++i)
    if (kEffects[i].name == effect.needs) return i;
  return std::nullopt;
}

/// A march that is timed, round after round.
struct Timed {
  MarchSettings settings;
  std::vector<double> ms;
};

std::vector<double> differences(const Timed& more, const Timed& less) {
  std::vector<double> result;
  for (size_t i = 0; i < more.ms.size(); ++i) result.push_back(more.ms[i] - less.ms[i]);
  return result;
}

}  // namespace

std::span<const MeasuredEffect> measuredEffects() { return kEffects; }

size_t effectSteps(int runs) { return static_cast<size_t>(runs) + 1; }

EffectCosts measureEffects(Marcher& marcher, const Camera& camera, const MarchSettings& settings, int runs, const std::function<void()>& onStep,
                           const std::stop_token& stop) {
  if (!marcher.volume()) throw InputError("the volume is in another process: what its effects cost is measured there");
  const Volume& volume = *marcher.volume();
  Timed none{settings, {}}, all{settings, {}};
  for (const MeasuredEffect& effect : kEffects) {
    effect.leaveOut(none.settings.render.effects);
    if (!effect.isOn(settings.render.effects)) effect.set(all.settings.render.effects, volume);
  }
  std::vector<Timed> alone, leftOut;
  for (const MeasuredEffect& effect : kEffects) {
    alone.push_back(all);
    for (const MeasuredEffect& other : kEffects)
      if (&other != &effect && other.name != effect.needs) other.leaveOut(alone.back().settings.render.effects);
    leftOut.push_back(all);
    effect.leaveOut(leftOut.back().settings.render.effects);
  }

  const auto beforeAlone = [&](size_t i) -> const Timed& {
    const auto needed = neededBy(kEffects[i]);
    return needed ? alone[*needed] : none;
  };
  Image<glm::vec4> plain, changed;
  for (size_t i = 0; i < kEffects.size(); ++i) {
    marcher.render(camera, beforeAlone(i).settings.render, plain, stop);
    marcher.render(camera, alone[i].settings.render, changed, stop);
    if (std::memcmp(plain.data(), changed.data(), plain.size() * sizeof(glm::vec4)) == 0)
      throw InputError(std::string(kEffects[i].name) + " does not change this picture; nothing was timed");
  }

  std::vector<Timed*> marches{&none, &all};
  for (Timed& timed : alone) marches.push_back(&timed);
  for (Timed& timed : leftOut) marches.push_back(&timed);
  for (int round = -1; round < runs; ++round) {
    onStep();
    for (Timed* const timed : marches) {
      if (stop.stop_requested()) throw OperationCancelled();
      const double ms = marcher.march(camera, timed->settings, stop).timings.marchMs;
      if (round >= 0) timed->ms.push_back(ms);  // the first warms up
    }
  }

  EffectCosts costs{measuredOf(none.ms), measuredOf(all.ms), measuredOf(differences(all, none)), {}};
  for (size_t i = 0; i < kEffects.size(); ++i)
    costs.effects.push_back({&kEffects[i], !kEffects[i].isOn(settings.render.effects), measuredOf(alone[i].ms), measuredOf(differences(alone[i], beforeAlone(i))),
                             measuredOf(leftOut[i].ms), measuredOf(differences(all, leftOut[i]))});
  return costs;
}

}  // namespace warpscope

// For each stage of the plan a scene that has it and one that has not, and the counter of its work.
// For marches on the CPU and on devices, compiled with counters.
#pragma once

#include <cmath>
#include <functional>
#include <ostream>
#include <string>
#include <thread>
#include <vector>

#include "marcher_cases.h"
#include "render/core/counters.h"
#include "render/march/march_setup.h"
#include "test_volumes.h"

namespace warpscope {

/// Blobs that are seen from a corner.
struct CountedScene {
  MarchSettings settings;
  VoxelType type = VoxelType::uint8;
  bool hasHoles = false;  ///< some voxels are NaN
  bool isSteep = false;   ///< the transfer function has a needle and a voxel is far from it, so that bins are too coarse
  float opacity = 0.3f;   ///< of what is seen
};

struct CountedRun {
  EffectPlan plan;
  Counts counts;
  Image<glm::vec4> image;
  SampleFrame frame;

  bool isSame(const CountedRun& other) const { return sameBits(image, other.image) && sameFrame(frame, other.frame); }
};

using MakeMarcher = std::function<MarcherPtr(VolumePtr, TransferFunction)>;

inline CountedRun countedMarch(const MakeMarcher& makeMarcher, const CountedScene& scene, const std::optional<DecidedStage>& decided = std::nullopt) {
  const glm::uvec3 dims(30, 28, 26);
  const FieldFunction field = blobs(dims, 3);
  const VolumePtr volume = makeTestVolume(scene.type, dims, [&](const glm::ivec3& p) {
    if (scene.isSteep && p == glm::ivec3(3)) return 2e9;
    return scene.hasHoles && (p.x * 7 + p.y * 5 + p.z * 3) % 11 == 0 ? std::nan("") : field(p);
  });
  const glm::vec3 color(0.9f, 0.5f, 0.2f);
  TransferFunction function{{{20.0, color, 0.0f}, {60.0, color, scene.opacity}}};
  if (scene.isSteep) function = {{{0.0, color, 0.0f}, {29.9, color, 0.0f}, {30.0, color, 0.9f}, {50.2, color, 0.0f}, {1e6, color, 0.1f}}};
  if (scene.opacity >= 1.0f) function = {{{20.0, color, 0.0f}, {20.0, color, 1.0f}}};
  decidedStage = decided;
  HostCounts::instance().take();
  const MarcherPtr marcher = makeMarcher(volume, function);
  const Camera camera = lookingFrom({40.0f, 30.0f, 35.0f}, glm::vec3(0.0f), 61, 47);
  CountedRun run{*marcher->plan(scene.settings.render, scene.settings.sample), {}, {}, {}};
  marcher->render(camera, scene.settings.render, run.image);
  run.frame = marcher->march(camera, scene.settings);
  run.counts = HostCounts::instance().take();
  decidedStage.reset();
  return run;
}

struct CountedCase {
  PlanStage stage;
  Counter counter;
  CountedScene without, with;
  bool isWork = true;       ///< the stage, decided in where it is not needed, does something; else its being left out is seen where it is
  bool isAskedOf = true;    ///< by marches; else by what they are given: the table is baked by the step, and modes are the settings'
};

inline std::string nameOfCase(const testing::TestParamInfo<CountedCase>& info) {
  std::string name(kStages[static_cast<size_t>(info.param.stage)].name);
  std::erase(name, '-');
  return name;
}
inline void PrintTo(const CountedCase& one, std::ostream* out) { *out << kStages[static_cast<size_t>(one.stage)].name; }

inline CountedScene litScene(std::string_view lights, const Shading& shading = {.strength = 1.0f}) {
  CountedScene scene;
  scene.settings.render.effects.shading = shading;
  scene.settings.render.effects.lights = parseLights(lights, "it");
  return scene;
}

inline CountedScene shadowed(float strength, float occlusion) {
  CountedScene scene = litScene("camera:1,1,1");
  scene.settings.render.effects.shadows.strength = strength;
  scene.settings.render.effects.shadows.occlusion = occlusion;
  return scene;
}

inline std::vector<CountedCase> countedCases() {
  const CountedScene plain;
  const auto changed = [&](auto&& change) {
    CountedScene scene;
    change(scene);
    return scene;
  };
  const auto render = [&](auto member, auto value) { return changed([&](CountedScene& s) { s.settings.render.*member = value; }); };
  return {
      {PlanStage::march, Counter::samples, changed([](CountedScene& s) { s.opacity = 0.0f; }), plain, false},
      {PlanStage::jitter, Counter::movedRays, plain, changed([](CountedScene& s) { s.settings.render.effects.jitter = 1.0f; }), false},
      {PlanStage::maximum, Counter::maxima, plain, changed([](CountedScene& s) { s.settings.render.effects.mode = RenderMode::mip; }), false, false},
      {PlanStage::surfaces, Counter::surfaces, plain, changed([](CountedScene& s) {
         s.settings.render.effects.mode = RenderMode::isosurface;
         s.settings.render.effects.isoValues = parseIsoValues("50", "it");
       }), false, false},
      {PlanStage::clip, Counter::clippedRays, plain,
       changed([](CountedScene& s) { s.settings.render.effects.clip.planes = parseClipPlanes("1,0.2,0,0", "it"); })},
      {PlanStage::skipping, Counter::leaps, render(&RenderSettings::skipEmpty, false), plain},
      {PlanStage::missingVoxels, Counter::finiteChecks, changed([](CountedScene& s) { s.type = VoxelType::float32; }),
       changed([](CountedScene& s) { s.type = VoxelType::float32, s.hasHoles = true; })},
      {PlanStage::segments, Counter::segments, plain, changed([](CountedScene& s) { s.settings.render.effects.preIntegration = true; }), false},
      {PlanStage::refinement, Counter::refinements, changed([](CountedScene& s) { s.type = VoxelType::float32; }),
       changed([](CountedScene& s) { s.type = VoxelType::float32, s.isSteep = true; }), false},
      {PlanStage::correction, Counter::corrections, render(&RenderSettings::step, 1.0f), plain, false, false},
      {PlanStage::gradient, Counter::gradients, plain, litScene("headlight")},
      {PlanStage::diffuse, Counter::diffuse, litScene("headlight", {.strength = 1.0f, .diffuse = 0.0f}), litScene("headlight")},
      {PlanStage::specular, Counter::highlights, litScene("headlight", {.strength = 1.0f, .specular = 0.0f}), litScene("headlight")},
      {PlanStage::halfVector, Counter::halfVectors, litScene("camera:1,1,1", {.strength = 1.0f, .specular = 0.0f}), litScene("camera:1,1,1")},
      {PlanStage::shadows, Counter::secondaryRays, litScene("camera:1,1,1"), shadowed(1.0f, 0.0f)},
      {PlanStage::occlusion, Counter::secondaryRays, litScene("camera:1,1,1"), shadowed(0.0f, 1.0f)},
      {PlanStage::lightVolume, Counter::secondaryRays, litScene("camera:1,1,1"), shadowed(0.5f, 0.5f), false},
      {PlanStage::earlyEnd, Counter::earlyEnds, changed([](CountedScene& s) { s.opacity = 0.9f, s.settings.render.terminateEarly = false; }),
       changed([](CountedScene& s) { s.opacity = 0.9f; })},
      {PlanStage::secondPass, Counter::secondPasses, plain, changed([](CountedScene& s) { s.settings.sample.heuristic = Heuristic::median; }), false},
      {PlanStage::severalSamples, Counter::dividedRays, plain, changed([](CountedScene& s) { s.settings.sample.samplesPerRay = 4; })},
      {PlanStage::spread, Counter::spreads, plain, changed([](CountedScene& s) { s.settings.sample.sendsSpread = true; })},
      {PlanStage::raySegments, Counter::segmentedRays, plain, changed([](CountedScene& s) { s.settings.sample.segments = 3; }), false},
  };
}

/// Effects with all there is to be set, and nothing that they are to do.
inline std::vector<CountedScene> scenesWithoutStrength() {
  CountedScene unlit = litScene("point:1,2,3@9 world:1,0,0", {.strength = 0.0f, .ambient = 4.0f, .diffuse = 3.0f, .specular = 2.0f, .exponent = 7.0f});
  CountedScene uncut;
  uncut.settings.render.effects.clip.slab.depth = 5.0f;
  CountedScene unshadowed;
  unshadowed.settings.render.effects.shadows = {.occlusionRadius = 3.0f, .gridEdge = 1.0f};
  CountedScene composited;
  composited.settings.render.effects.isoValues = parseIsoValues("50", "it");
  return {unlit, uncut, unshadowed, composited};
}

}  // namespace warpscope

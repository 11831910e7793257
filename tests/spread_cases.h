// What is asked of volumes that are spread over ranks, wherever these march.
#pragma once

#include <gtest/gtest.h>

#include <chrono>
#include <deque>
#include <stop_token>
#include <string>
#include <thread>
#include <utility>
#include <vector>

#include "marcher_cases.h"
#include "render/base/error.h"
#include "render/march/march_settings.h"

namespace warpscope {

inline constexpr glm::uvec3 kDims(44, 37, 40);

inline std::vector<Camera> cameras() {
  return {lookingFrom({70.0f, 30.0f, 45.0f}, {}, 100, 70), lookingFrom({0.0f, 0.0f, -70.0f}, {}, 66, 50), lookingFrom({-3.0f, 4.0f, 2.0f}, {20.0f, 5.0f, 1.0f}, 64, 48),
          lookingFrom({-40.0f, -60.0f, 12.0f}, {4.0f, 2.0f, 0.0f}, 90, 33)};
}

/// Settings that march otherwise, by name.
inline std::deque<std::pair<std::string, MarchSettings>> variants() {
  std::deque<std::pair<std::string, MarchSettings>> cases;
  const auto add = [&](const std::string& name) -> MarchSettings& { return cases.emplace_back(name, MarchSettings{}).second; };
  add("plain");
  add("segments").sample.segments = 4;
  add("many segments").sample.segments = 16;
  add("pre-integrated").render.effects.preIntegration = true;
  add("jittered").render.effects.jitter = 1.0f;
  add("coarse").render.step = 2.7f;
  add("fine").render.step = 0.11f;
  add("without early ends").render.terminateEarly = false;
  add("without skipping").render.skipEmpty = false;
  add("lit").render.effects.shading.strength = 0.8f;
  MarchSettings& litSegments = add("lit segments");
  litSegments.render.effects.shading.strength = 1.0f;
  litSegments.sample.segments = 5;
  MarchSettings& parts = add("several samples");
  parts.sample.samplesPerRay = 4;
  parts.sample.heuristic = Heuristic::median;
  MarchSettings& all = add("lit segments and several samples, jittered");
  all.render.effects.shading.strength = 0.7f;
  all.render.effects.jitter = 0.8f;
  all.sample.segments = 3;
  all.sample.samplesPerRay = 8;
  Clip& clip = add("clipped").render.effects.clip;
  clip.planes.add({{1.0f, 0.4f, 0.2f}, 18.0f});
  clip.box.upper = {0.9f, 0.7f, 1.0f};
  add("greatest").render.effects.mode = RenderMode::mip;
  MarchSettings& greatest = add("greatest with segments");
  greatest.render.effects.mode = RenderMode::mip;
  greatest.sample.segments = 2;
  MarchSettings& surfaces = add("surfaces");
  surfaces.render.effects.mode = RenderMode::isosurface;
  for (const double value : {25.0, 60.0}) surfaces.render.effects.isoValues.add({value, 0.5f});
  MarchSettings& opaque = add("opaque surfaces with segments");
  opaque.render.effects.mode = RenderMode::isosurface;
  opaque.render.effects.isoValues.add({25.0, 1.0f});
  opaque.sample.segments = 4;
  MarchSettings& lit = add("lit surfaces");
  lit = surfaces;
  lit.render.effects.shading.strength = 1.0f;
  return cases;
}

/// A march of thousands of samples a ray, which is asked to stop after a while, does; the camera has this many pixels a side.
inline void expectStops(Marcher& marcher, std::chrono::milliseconds after, uint32_t side) {
  MarchSettings fine;
  fine.render.step = 1e-3f;
  std::stop_source source;
  const std::jthread stopper([&] {
    std::this_thread::sleep_for(after);
    source.request_stop();
  });
  EXPECT_THROW(marcher.march(lookingFrom({80.0f, 30.0f, 45.0f}, {}, side, side), fine, source.get_token()), OperationCancelled);
}

/// However soon it is stopped, the next frame is that of the other one.
inline void expectWorksWhenStopped(Marcher& marcher, Marcher& alone) {
  const Camera small = cameras().front();
  for (int i = 0; i < 5; ++i) {
    expectStops(marcher, std::chrono::milliseconds(10 * i), 512);
    EXPECT_TRUE(sameFrame(marcher.march(small, {}), alone.march(small, {})));
  }
}

}  // namespace warpscope

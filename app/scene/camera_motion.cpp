// Sines about the view that it began from.
// See camera_motion.h.
#include "app/scene/camera_motion.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

namespace warpscope {
namespace {

constexpr std::array<CameraMotionDescriptor, 6> kMotions{{
    {"none", CameraMotion::none, "None", "The camera is the user's alone"},
    {"orbit", CameraMotion::orbit, "Orbit", "Around the vertical axis, a turn in 12 s"},
    {"shake", CameraMotion::shake, "Shake", "As a head that looks around: some degrees to the sides and a few up and down"},
    {"dolly", CameraMotion::dolly, "Dolly", "Nearer and farther, there and back in 6 s"},
    {"fly-through", CameraMotion::flyThrough, "Fly-through", "Around, up and down, nearer and farther at once"},
    {"recorded", CameraMotion::recorded, "Recorded", "The path that was recorded, back and forth"},
}};

constexpr double kOrbitDegPerS = 30.0;

double wave(double seconds, double periodS) { return std::sin(2.0 * std::numbers::pi * seconds / periodS); }

double around(double degrees) { return std::remainder(degrees, 360.0); }

}  // namespace

std::span<const CameraMotionDescriptor> cameraMotions() { return kMotions; }
const CameraMotionDescriptor& describe(CameraMotion motion) { return kMotions[static_cast<size_t>(motion)]; }

void CameraPath::add(double seconds, const View& view) {
  if (!views_.empty() && seconds <= views_.back().seconds)
    views_.back().view = view;
  else if (views_.size() < kMost)
    views_.push_back({seconds, view});
}

View CameraPath::at(double seconds) const {
  const auto next = std::ranges::upper_bound(views_, seconds, {}, &TimedView::seconds);
  if (next == views_.begin()) return next->view;
  if (next == views_.end()) return views_.back().view;
  const TimedView& before = *std::prev(next);
  const double share = (seconds - before.seconds) / (next->seconds - before.seconds);
  View view = before.view;
  view.angleDeg = around(before.view.angleDeg + share * around(next->view.angleDeg - before.view.angleDeg));
  view.elevationDeg = std::lerp(before.view.elevationDeg, next->view.elevationDeg, share);
  view.distance = std::lerp(before.view.distance, next->view.distance, share);
  view.pan = glm::mix(before.view.pan, next->view.pan, share);
  return view;
}

View movedView(CameraMotion motion, const View& home, double seconds, double speed, const CameraPath& path) {
  const double t = seconds * speed;
  View view = home;
  switch (motion) {
    case CameraMotion::none: break;
    case CameraMotion::orbit: view.angleDeg = around(home.angleDeg + kOrbitDegPerS * t); break;
    case CameraMotion::shake:
      view.angleDeg = around(home.angleDeg + 7.0 * wave(t, 1.4) + 3.0 * wave(t, 0.9));
      view.elevationDeg = std::clamp(home.elevationDeg + 3.0 * wave(t, 1.1), -90.0, 90.0);
      break;
    case CameraMotion::dolly: view.distance = home.distance * std::exp(-0.55 * wave(t, 6.0)); break;
    case CameraMotion::flyThrough:
      view.angleDeg = around(home.angleDeg + 70.0 * wave(t, 11.0));
      view.elevationDeg = std::clamp(home.elevationDeg + 25.0 * wave(t, 7.0), -90.0, 90.0);
      view.distance = home.distance * std::exp(-0.6 * std::pow(wave(t, 9.0), 2.0));
      view.pan = home.pan + glm::dvec2(0.15 * wave(t, 8.0), 0.1 * wave(t, 6.5));
      break;
    case CameraMotion::recorded: {
      if (path.empty()) break;
      const double length = path.seconds(), phase = length > 0.0 ? std::fmod(t, 2.0 * length) : 0.0;
      return path.at(phase <= length ? phase : 2.0 * length - phase);
    }
  }
  view.distance = std::clamp(view.distance, kViewDistanceRange.lowest, kViewDistanceRange.highest);
  view.pan = glm::clamp(view.pan, glm::dvec2(-kMostViewPan), glm::dvec2(kMostViewPan));
  return view;
}

}  // namespace warpscope

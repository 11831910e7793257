// What stable arithmetic buys, and what it costs: pictures of hard cases by the forms that the program uses and by those of textbooks, each against the
// same picture in double. The forms: core/arithmetic.h; the pictures without rounding: exact_picture.h.
#pragma once

#include <functional>
#include <span>
#include <stop_token>
#include <string>
#include <string_view>
#include <vector>

#include "app/experiment/measured.h"
#include "app/scene/scene.h"
#include "render/core/arithmetic.h"
#include "render/core/backend.h"
#include "render/core/image.h"

namespace warpscope {

/// What is looked at.
enum class StabilitySubject {
  march,       ///< rays through the volume: premultiplied colours and opacity, linear
  spheres,     ///< samples as spheres: which is hit
  similarity,  ///< SSIM of two flat pictures
};

struct StabilityWords {
  std::string_view name;
  std::string_view error;  ///< what a case's error is of
};
const StabilityWords& wordsOf(StabilitySubject subject);

struct StabilityCase {
  std::string_view name;
  StabilitySubject subject = StabilitySubject::march;
  std::string_view scene;       ///< built-in; empty for `similarity`
  std::string_view hazard;      ///< what makes it hard
  std::string_view textbook;    ///< the form that fails, or that no form is known to fail
  uint32_t sidePx = 256;
  float radiusScale = 1.0f;     ///< of samples
  /// What the stable form keeps to: march: the largest difference; spheres: the share of wrong pixels; similarity: the difference.
  double bound = 0.0;
  std::string_view boundFrom;   ///< why it is that
};

std::span<const StabilityCase> stabilityCases();

/// By one arithmetic.
struct StabilityForm {
  Image<glm::vec4> picture;  ///< linear, premultiplied; none for `similarity`
  double worst = 0.0;        ///< largest difference of a channel from the exact picture's; similarity: of the number
  double wrongShare = 0.0;   ///< march: pixels off by more than 1/255; spheres: that show one which is not the first
  Measured time;             ///< of a picture, or a comparison

  /// What the bound is of.
  double error(StabilitySubject subject) const { return subject == StabilitySubject::spheres ? wrongShare : worst; }
};

struct StabilityResult {
  const StabilityCase* what = nullptr;
  Backend backend = Backend::cpu;
  glm::vec3 background{0.0f};
  Image<glm::vec4> exact;
  StabilityForm stable, textbook;

  bool isStable() const { return stable.error(what->subject) <= what->bound; }
  /// What stability costs: nanoseconds a pixel, that is a ray.
  double costNs() const;
};

struct StabilitySettings {
  std::vector<const StabilityCase*> cases;
  std::vector<Backend> backends;  ///< cpu, cuda
  int runs = 5;                   ///< that are timed, after one that is not; fewer where one takes long
};

/// Runs every case on every backend; `similarity` on the CPU alone. `onStep` is told what comes next. Throws OperationCancelled if `stop` is set.
std::vector<StabilityResult> runStability(const StabilitySettings& settings, const std::function<void(const std::string&)>& onStep,
                                          const std::stop_token& stop);

}  // namespace warpscope

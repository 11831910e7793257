// The cases, and how each is run.
// See stability.h; the cases' numbers are those that tests/stability names its tests by.
#include "app/experiment/stability.h"

#include <algorithm>
#include <cmath>

#include "app/experiment/exact_picture.h"
#include "app/experiment/textbook_ssim.h"
#include "app/frames/backend.h"
#include "render/base/stopwatch.h"
#include "render/metrics/ssim.h"
#include "render/warp/arithmetic_knob.h"
#include "render/warp/spheres_warp.h"

namespace warpscope {
namespace {

constexpr StabilitySubject kMarch = StabilitySubject::march, kSpheres = StabilitySubject::spheres,
                           kSimilarity = StabilitySubject::similarity;

constexpr StabilityWords kWords[] = {  // in the order of StabilitySubject
    {"march", "largest difference"},
    {"spheres", "share of wrong pixels"},
    {"similarity", "difference"},
};
static_assert(std::size(kWords) == static_cast<size_t>(StabilitySubject::similarity) + 1);

constexpr StabilityCase kCases[] = {
    {"far-origin", kMarch, "torture/far-origin", "the volume lies at 1e7 mm",
     "none: rays are in the volume's own space in both", 256, 1.0f, 4e-3, "TransferTable::kMostVariation of a sample"},
    {"tiny-spacing", kMarch, "torture/tiny-spacing", "voxels of 1e-9 mm",
     "none: a voxel's edge is the unit in both", 256, 1.0f, 4e-3, "TransferTable::kMostVariation of a sample"},
    {"thin-slab", kMarch, "torture/thin-slab", "a step longer than the volume",
     "1 - (1 - a)^(ds/dt) of an opacity that rounding made 1", 256, 1.0f, 2e-4,
     "lengths: eight roundings of the distance, 7e-5, times 2.3 of opacity for a unit"},
    {"label-steps", kMarch, "torture/label-steps", "a label among 65,536",
     "an entry of the table is wider than the label", 256, 1.0f, 0.2,
     "a sample within rounding of a step may be on either side: its opacity"},
    {"outlier", kMarch, "torture/outlier", "one voxel of -9999 beside values of 0 to 1",
     "an entry of the table is wider than all other values", 256, 1.0f, 4e-3, "TransferTable::kMostVariation of a sample"},
    {"nan-sprinkled", kMarch, "torture/nan-sprinkled", "one voxel in a hundred is not a number",
     "what is blended with it is not a number either", 256, 1.0f, 0.05,
     "a sample within rounding of where half the weight is missing may have a value or none: its opacity"},
    {"grazing-planes", kMarch, "torture/grazing-planes", "planes of one voxel, looked along from three million voxels away",
     "distances counted from the eye", 256, 1.0f, 4e-3, "TransferTable::kMostVariation of a sample"},
    {"long-way", kMarch, "torture/long-way", "three hundred thousand steps to a thin wall", "t += dt", 24, 1.0f, 4e-3,
     "places along a ray: 2^-21 of its length"},
    {"haze", kMarch, "torture/haze", "opacity of 1e-8, a million steps",
     "1 - (1 - a)^ds rounds to 0", 24, 1.0f, 1e-6, "light and transmittance are sums of sums"},
    {"eye-inside-march", kMarch, "torture/eye-inside", "the eye inside visible matter",
     "none: rays begin at the eye in both", 256, 1.0f, 4e-3, "TransferTable::kMostVariation of a sample"},
    {"camera-far", kMarch, "torture/camera-far", "a slab of one voxel, four million voxels away",
     "distances counted from the eye", 256, 1.0f, 1e-3, "the near plane's place: half a unit in the last place of its coordinates"},
    {"spheres", kSpheres, "torture/far-origin", "samples as large as voxels", "b^2 - 4ac", 96, 1.0f, 0.0,
     "hits within eight roundings of the distance are undecided"},
    {"far-spheres", kSpheres, "torture/far-spheres", "samples of a quarter of a voxel, seven thousand voxels away", "b^2 - 4ac", 96, 0.25f, 0.0,
     "hits within eight roundings of the distance are undecided"},
    {"eye-inside", kSpheres, "torture/eye-inside", "the eye amid large samples", "the eye is inside of spheres, and sees none",
     96, 8.0f, 0.0, "hits within eight roundings of the distance are undecided"},
    {"flat-pictures", kSimilarity, "", "SSIM of two pictures of nearly one colour", "E[x^2] - E[x]^2", 256, 1.0f, 1.2e-4,
     "sums of 121 squares of differences of at most 1/2"},
};

/// Runs once, then for as many times as are wanted, or as fit into two seconds.
template <class F>
Measured timesOf(int runs, const F& f) {
  constexpr double kEnoughMs = 2000.0;
  const double firstMs = milliseconds(f);
  std::vector<double> timesMs;
  double sumMs = firstMs;
  while (static_cast<int>(timesMs.size()) < runs && (timesMs.empty() ? firstMs < kEnoughMs : sumMs < kEnoughMs)) {
    timesMs.push_back(milliseconds(f));
    sumMs += timesMs.back();
  }
  if (timesMs.empty()) timesMs.push_back(firstMs);
  return measuredOf(std::move(timesMs));
}

double largestDifference(const glm::vec4& a, const glm::vec4& b) {
  double largest = 0.0;
  for (int channel = 0; channel < 4; ++channel)
    largest = std::max(largest, std::abs(static_cast<double>(a[channel]) - static_cast<double>(b[channel])));
  // What is no number is as wrong as can be.
  return std::isfinite(a.r + a.g + a.b + a.a) ? largest : 1.0;
}

/// Fills in `worst`, and `wrongShare` by `isWrong(x, y, difference)`.
template <class F>
void judge(StabilityForm& form, const Image<glm::vec4>& exact, const F& isWrong) {
  size_t wrong = 0;
  for (uint32_t y = 0; y < exact.height(); ++y)
    for (uint32_t x = 0; x < exact.width(); ++x) {
      const double difference = largestDifference(form.picture(x, y), exact(x, y));
      form.worst = std::max(form.worst, difference);
      wrong += isWrong(x, y, difference) ? 1u : 0u;
    }
  form.wrongShare = static_cast<double>(wrong) / static_cast<double>(exact.size());
}

/// Both forms, one after the other.
template <class F>
void forBoth(StabilityResult& result, const F& f) {
  f(Arithmetic::stable, result.stable);
  f(Arithmetic::textbook, result.textbook);
}

void runMarch(StabilityResult& result, const Scene& scene, const StabilitySettings& settings, const std::stop_token& stop) {
  const uint32_t side = result.what->sidePx;
  const Camera camera = makeCamera(scene, scene.views.back(), side, side);
  RenderSettings render = scene.march.render;
  render.terminateEarly = false;  // what is left out there is no error of rounding
  result.exact = exactPicture(*scene.volume, scene.transferFunction, camera, render, stop);
  const MarcherPtr marcher = makeMarcher(result.backend, scene.volume, scene.transferFunction);
  forBoth(result, [&](Arithmetic arithmetic, StabilityForm& form) {
    render.arithmetic = arithmetic;
    form.time = timesOf(settings.runs, [&] { marcher->render(camera, render, form.picture, stop); });
    judge(form, result.exact, [](uint32_t, uint32_t, double difference) { return difference > 1.0 / 255.0; });
  });
}

void runSpheres(StabilityResult& result, const Scene& scene, const StabilitySettings& settings, const std::stop_token& stop) {
  const uint32_t side = result.what->sidePx;
  MarchSettings march = neededBy({}, scene.march);
  march.sample.radiusScale = result.what->radiusScale;
  const MarcherPtr marcher = makeMarcher(Backend::cpu, scene.volume, scene.transferFunction);  // the same samples for all
  const auto frame = std::make_shared<const SampleFrame>(marcher->march(makeCamera(scene, scene.views.front(), side, side), march, stop));
  std::vector<Sphere> spheres;
  const SampleGrid grid = frame->grid();
  for (const PackedSample sample : frame->samples) spheres.push_back(unpackSample(sample, grid));
  const Camera camera = makeCamera(scene, scene.views.back(), side, side);
  const ExactHits exact(spheres, camera, stop);
  resolveColors(*frame, exact.ids(), result.exact);

  WarpResources resources;
  resources.backend = result.backend;
  resources.marcher = marcher;
  forBoth(result, [&](Arithmetic arithmetic, StabilityForm& form) {
    WarpSettings warp;
    warp.knobs.set(kArithmeticKnob, arithmetic);
    warp.knobs.set(kSphereTracingKnob, SphereTracing::lbvh);  // the one that has both
    const auto technique = makeWarp(kSpheresWarp, resources);
    technique->setFrame(frame, warp, stop);
    WarpedImage image;
    form.time = timesOf(settings.runs, [&] { technique->draw(camera, warp, image, stop); });
    form.picture = image.color;
    judge(form, result.exact, [&](uint32_t x, uint32_t y, double) { return !exact.allows(x, y, image.samples(x, y)); });
  });
}

/// Two greys that differ by one code, and the second with a faint grain.
void runSimilarity(StabilityResult& result, const StabilitySettings& settings) {
  const uint32_t side = result.what->sidePx;
  Image<float> a(side, side), b(side, side);
  for (uint32_t y = 0; y < side; ++y)
    for (uint32_t x = 0; x < side; ++x) {
      a(x, y) = 240.0f / 255.0f;
      b(x, y) = 241.0f / 255.0f + ((x * 7 + y * 13) % 5 == 0 ? 1e-4f : 0.0f);
    }
  const ColorPlanes planesA{a, a, a}, planesB{b, b, b};
  const double exact = exactSsim(a, b);
  forBoth(result, [&](Arithmetic arithmetic, StabilityForm& form) {
    double similarity = 0.0;
    form.time = timesOf(settings.runs, [&] {
      similarity = arithmetic == Arithmetic::stable ? SsimReference(planesB).similarity(planesA) : textbookSsim(planesA, planesB);
    });
    form.worst = std::abs(similarity - exact);
  });
}

}  // namespace

const StabilityWords& wordsOf(StabilitySubject subject) { return kWords[static_cast<size_t>(subject)]; }

std::span<const StabilityCase> stabilityCases() { return kCases; }

double StabilityResult::costNs() const {
  const double pixels = static_cast<double>(what->sidePx) * what->sidePx;
  return 1e6 * (stable.time.medianMs - textbook.time.medianMs) / pixels;
}

std::vector<StabilityResult> runStability(const StabilitySettings& settings, const std::function<void(const std::string&)>& onStep,
                                          const std::stop_token& stop) {
  std::vector<StabilityResult> results;
  for (const StabilityCase* what : settings.cases)
    for (const Backend backend : settings.backends) {
      if (what->subject == StabilitySubject::similarity && backend != Backend::cpu) continue;
      onStep(std::string(what->name) + " on " + std::string(nameOf(backend)));
      StabilityResult result;
      result.what = what;
      result.backend = backend;
      if (what->subject == StabilitySubject::similarity) {
        runSimilarity(result, settings);
      } else {
        const Scene scene = openScene(std::string(what->scene), {}, stop);
        result.background = scene.background;
        (what->subject == StabilitySubject::march ? runMarch : runSpheres)(result, scene, settings, stop);
      }
      results.push_back(std::move(result));
    }
  return results;
}

}  // namespace warpscope

// Running a comparison.
// See comparison.h.
#include "app/experiment/comparison.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <limits>
#include <optional>

#include "render/base/error.h"
#include "render/metrics/holes.h"
#include "render/metrics/picture_errors.h"
#include "render/warp/fill.h"

namespace warpscope {
namespace {

/// Two decimals where they say something: 0.75, 1.25, 2, 12.5. Small factors keep two digits: 0.0042.
std::string factorText(double factor) {
  char text[48];
  if (factor < 0.095) {
    std::snprintf(text, sizeof text, "%.2g", factor);
    return text;
  }
  std::snprintf(text, sizeof text, "%.2f", factor);
  std::string shown = text;
  shown.erase(shown.find_last_not_of('0') + 1);
  if (shown.ends_with('.')) shown.pop_back();
  return shown;
}

}  // namespace

std::vector<const WarpDescriptor*> comparedTechniques(const MarchSettings& march) {
  std::vector<const WarpDescriptor*> techniques;
  for (const WarpDescriptor& technique : warpRegistry())
    if (lackOf(technique, march).empty()) techniques.push_back(&technique);
  return techniques;
}

Comparison compareTechniques(const Scene& scene, const WarpResources& resources, const ComparisonSettings& settings,
                             const std::function<void(const WarpDescriptor&, size_t, const WarpedImage&)>& onPicture,
                             const std::function<void(const std::string&)>& onStep, const std::stop_token& stop) {
  Comparison comparison;
  for (const View& view : scene.views)
    comparison.cameras.push_back(makeCamera(scene, view, settings.width, settings.height));
  onStep("the server's frame");
  comparison.served = settings.fetch(comparison.cameras.front(), settings.march, stop);
  comparison.frame = comparison.served.frame;

  // One technique after the other through all views would keep every reference; view by view keeps one.
  struct Contender {
    const WarpDescriptor* descriptor;
    std::unique_ptr<Warp> warp;
    MeasuredBuild build;
    size_t bytes;
    size_t proxyBytes = 0;
  };
  const Measuring measuring(settings.draws, stop);
  std::vector<Contender> contenders;
  for (const WarpDescriptor* const technique : settings.techniques) {
    const WarpDescriptor& descriptor = *technique;
    Contender contender{&descriptor, makeWarp(descriptor, resources), {}, 0};
    contender.build = measureBuild(measuring, *contender.warp, comparison.frame, settings.warp);
    if (descriptor.usesFrame)
      contender.bytes = drawsPictureAlone(descriptor) ? pictureBytes(comparison.frame, scene.background, settings.codec)
                                                      : bytesFor(descriptor, comparison.served.bytes);
    if (drawsProxy(descriptor, settings.warp.knobs)) contender.proxyBytes = comparison.served.bytes.proxy;
    contenders.push_back(std::move(contender));
  }

  WarpedImage reference, image;
  std::optional<PictureJudge> judge;  // of the view's reference, which comes first
  for (size_t view = 0; view < scene.views.size(); ++view) {
    for (const Contender& contender : contenders) {
      onStep(std::string(contender.descriptor->name) + ", " + viewCaption(scene.views[view], scene.views.front()));
      const bool isReference = !contender.descriptor->usesFrame;
      WarpedImage& drawn = isReference ? reference : image;
      const Drawing drawing{*contender.warp, settings.warp, scene.background};
      const Camera& camera = comparison.cameras[view];
      const MeasuredDraw measured = isReference ? drawOnce(drawing, camera, drawn, stop) : measureDraw(measuring, drawing, camera, drawn);
      if (measured.isOnDevice) contender.warp->draw(camera, settings.warp, drawn, stop);

      ComparisonRow row;
      row.draw = measured.draw;
      row.draws = isReference ? 1 : settings.draws;
      row.technique = contender.descriptor;
      row.view = view;
      if (isReference) {
        judge.emplace(reference.color, scene.background);
        row.psnrDb = std::numeric_limits<double>::infinity();
        row.holeFraction = countHoles(reference, reference.color).fraction();
      } else {
        const PictureErrors errors = judge->errorsOf(drawn);
        row.psnrDb = errors.psnrDb;
        row.ssim = errors.ssim;
        row.flip = errors.flip;
        row.holeFraction = errors.holeFraction;
        row.filledFraction = errors.filledFraction;
      }
      row.build = contender.build;
      row.bytes = contender.bytes;
      row.proxyBytes = contender.proxyBytes;
      comparison.rows.push_back(row);
      onPicture(*contender.descriptor, view, drawn);
    }
  }
  return comparison;
}

std::vector<Gain> gainsOf(const Comparison& comparison, std::string_view technique, std::string_view over) {
  const auto rowOf = [&](const WarpDescriptor& descriptor, size_t view) {
    return std::ranges::find_if(comparison.rows, [&](const ComparisonRow& row) { return row.technique == &descriptor && row.view == view; });
  };
  std::vector<Gain> gains;
  for (size_t view = 0; view < comparison.cameras.size(); ++view) {
    const auto better = rowOf(findWarp(technique), view), worse = rowOf(findWarp(over), view);
    if (better == comparison.rows.end() || worse == comparison.rows.end()) return {};
    gains.push_back({view, better->psnrDb - worse->psnrDb, worse->flip - better->flip, worse->holeFraction - better->holeFraction});
  }
  return gains;
}

std::string viewCaption(const View& view, const View& first) {
  char text[96];
  std::snprintf(text, sizeof text, "%g°", view.angleDeg - first.angleDeg);
  std::string caption = text;
  if (view.elevationDeg != first.elevationDeg) {
    std::snprintf(text, sizeof text, ", %+g° up", view.elevationDeg - first.elevationDeg);
    caption += text;
  }
  const double ratio = view.distance / first.distance;
  if (std::abs(ratio - 1.0) > 1e-6) {
    caption += (ratio < 1.0 ? ", nearer (" : ", farther (") + factorText(ratio) + "×)";
  }
  return caption;
}

}  // namespace warpscope

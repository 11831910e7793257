// A ground truth of few pixels for each camera, and what pictures differ by from it.
// See moving_errors.h.
#include "app/session/moving_errors.h"

#include <algorithm>
#include <utility>

#include "render/core/crew_work.h"

namespace warpscope {
namespace {

/// Of one camera.
struct SparseTruth {
  Camera camera;  ///< of the whole picture
  PictureJudge judge;
};

}  // namespace

MovingErrors::MovingErrors(std::function<void()> onNews, std::shared_ptr<Crew> crew)
    : worker_(std::make_unique<NewestWorker<Job, Result>>(workOfCrew([]() -> NewestWorker<Job, Result>::Work { return findErrors; }, std::move(crew), Crew::kOfMarches),
                                                          std::move(onNews))) {}

void MovingErrors::findErrors(const Job& job, Result& result, const std::stop_token& stop) {
  // Panels that follow one camera share a ground truth.
  std::vector<SparseTruth> truths;
  for (const Seen& seen : job.seen) {
    auto truth = std::ranges::find(truths, seen.camera, &SparseTruth::camera);
    if (truth == truths.end()) {
      const SparsePixels pixels = sparsePixels({seen.camera.width, seen.camera.height}, kPixels);
      Image<glm::vec4> color;
      job.truth.marcher->render(sparseCamera(seen.camera, pixels), job.truth.settings, color, stop);
      // As large in the field of view as the whole picture.
      const float perDegree = std::max(1.0f, kFlipPixelsPerDegree / static_cast<float>(pixels.every));
      truths.push_back({seen.camera, PictureJudge(color, job.truth.background, perDegree)});
      truth = truths.end() - 1;
    }
    result.found.push_back({seen.panel, seen.technique, truth->judge.errorsOf(*seen.sparse)});
  }
}

void MovingErrors::see(Seen seen) {
  forget(seen.panel);
  seen_.push_back(std::move(seen));
}

void MovingErrors::forget(uint64_t panel) {
  std::erase_if(seen_, [&](const Seen& one) { return one.panel == panel; });
}

void MovingErrors::follow(const ReferenceJob& truth, TimePoint now) {
  if (isAtWork_ || seen_.empty() || now - endedAt_ < kPause) return;
  isAtWork_ = true;
  worker_->post({truth, std::exchange(seen_, {})});
}

std::vector<MovingErrors::Found> MovingErrors::take(TimePoint now) {
  std::optional<Result> result = worker_->tryTake();
  if (!result) return {};
  isAtWork_ = false;
  endedAt_ = now;
  return result->error.empty() ? std::move(result->found) : std::vector<Found>{};
}

void MovingErrors::clear() {
  seen_.clear();
  worker_->cancel();
  static_cast<void>(worker_->tryTake());
  isAtWork_ = false;
}

}  // namespace warpscope

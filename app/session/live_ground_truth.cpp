// When the ground truth is marched, and which results are still of use.
// See live_ground_truth.h.
#include "app/session/live_ground_truth.h"

#include <optional>
#include <utility>

#include "app/session/frame_requests.h"

namespace warpscope {
namespace {

/// Where it follows the moving camera: how often. Each costs the panels a drawing, and the CPU what judging takes.
constexpr std::chrono::milliseconds kLivePeriod(200);

}  // namespace

bool differOnlyInPlace(const ReferenceJob& a, const ReferenceJob& b) {
  ReferenceJob moved = a;
  moved.camera = b.camera;
  return moved == b && a.camera.width == b.camera.width && a.camera.height == b.camera.height;
}

LiveGroundTruth::LiveGroundTruth(std::function<void()> onNews, std::shared_ptr<Crew> crew)
    : worker_(makeReferenceWorker(std::move(onNews), std::move(crew))) {}

void LiveGroundTruth::clear() {
  worker_->forget();
  wanted_ = asked_ = {};
  image_.reset();
  error_.clear();
}

bool LiveGroundTruth::followsCamera() const {
  return wanted_.marcher && wanted_.marcher->capabilities().pace == MarchPace::followsCamera;
}

bool LiveGroundTruth::follow(ReferenceJob wanted, TimePoint now) {
  if (wanted != wanted_) {
    const bool isOfUse = differOnlyInPlace(wanted_, wanted);
    wanted_ = std::move(wanted);
    movedAt_ = now;
    if (!(isOfUse && followsCamera())) {
      asked_ = {};
      image_.reset();
      worker_->cancel();
    }
  }
  if (isAsked()) return false;
  const bool isTime = followsCamera() ? now - askedAt_ >= kLivePeriod : now - movedAt_ >= FrameRequests::kRest;
  if (!isTime) return true;  // the time passes without further events
  asked_ = wanted_;
  askedAt_ = now;
  worker_->post(asked_);
  return true;
}

bool LiveGroundTruth::take() {
  std::optional<ReferenceResult> result = worker_->tryTake();
  if (!result) return false;
  const bool isOfUse = result->job == asked_ || (followsCamera() && differOnlyInPlace(result->job, wanted_));
  if (!isOfUse) return false;
  error_ = std::move(result->error);
  if (result->image) image_ = std::move(result->image);
  return true;
}

}  // namespace warpscope

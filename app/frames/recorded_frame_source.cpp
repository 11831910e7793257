// A worker that decodes, and which recorded view a frame is of.
// See recorded_frame_source.h.
#include "app/frames/recorded_frame_source.h"

#include <algorithm>
#include <limits>
#include <utility>

namespace warpscope {
namespace {

/// How unlike two cameras are: their directions, and their places by how far the second is from the volume's middle, which is 0. Pictures of other shapes have
/// other distances (makeCamera), so that a few thousandths say nothing.
double unlikeness(const Camera& a, const Camera& b) {
  const glm::dvec3 eye(b.eye);
  return glm::distance(glm::dvec3(a.forward), glm::dvec3(b.forward)) + glm::distance(glm::dvec3(a.up), glm::dvec3(b.up)) +
         glm::distance(glm::dvec3(a.eye), eye) / std::max(glm::length(eye), 1e-300);
}

size_t viewOf(const Recording& recording, const Recording::Frame& arrived, const SampleFrame& frame) {
  constexpr size_t kMostBefore = 1200;  // 20 seconds of them
  const std::vector<TimedView>& views = recording.path.views();
  const auto after = static_cast<size_t>(std::ranges::upper_bound(views, arrived.seconds, {}, &TimedView::seconds) - views.begin());
  size_t best = after > 0 ? after - 1 : 0;
  double least = std::numeric_limits<double>::max();
  for (size_t i = after; i > 0 && after - i < kMostBefore; --i) {
    const double unlike = unlikeness(makeCamera(recording.scene, views[i - 1].view, frame.camera.width, frame.camera.height), frame.camera);
    if (unlike >= least) continue;
    least = unlike;
    best = i - 1;
  }
  return best;
}

}  // namespace

RecordedFrameSource::RecordedFrameSource(std::shared_ptr<const Recording> recording, std::function<void()> onNews)
    : recording_(std::move(recording)),
      worker_(
          [recorded = recording_]() -> NewestWorker<size_t, Result>::Work {
            return [recorded, frames = std::make_shared<RecordedFrames>(*recorded)](size_t index, Result& result, const std::stop_token&) {
              result.index = index;
              const Recording::Frame& wanted = recorded->frames[index];
              ServedFrame& served = result.taken.served;
              served.requestId = wanted.head.id;
              const SampleFramePtr frame = frames->at(wanted.seconds);
              served.bytes = frames->bytes();
              served.latency = latencyOf(frame->timings);
              result.taken.view = viewOf(*recorded, wanted, *frame);
              served.frame = frame;
            };
          },
          std::move(onNews)) {}

void RecordedFrameSource::seek(double seconds) {
  const std::optional<size_t> index = frameAt(*recording_, seconds);
  if (index && index != sought_) worker_.post(*index);
  sought_ = index;
}

std::optional<RecordedFrameSource::Taken> RecordedFrameSource::take() {
  std::optional<Result> result = worker_.tryTake();
  if (!result) return std::nullopt;
  taken_ = result->index;
  result->taken.served.error = std::move(result->error);
  return std::move(result->taken);
}

std::optional<ServedFrame> RecordedFrameSource::tryTake() {
  std::optional<Taken> taken = take();
  return taken ? std::optional(std::move(taken->served)) : std::nullopt;
}

}  // namespace warpscope

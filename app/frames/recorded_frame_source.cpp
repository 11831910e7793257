// A worker that decodes.
// See recorded_frame_source.h.
#include "app/frames/recorded_frame_source.h"

#include <utility>

#include "app/frames/recorded_frames.h"
#include "render/core/crew_work.h"

namespace warpscope {
RecordedFrameSource::RecordedFrameSource(std::shared_ptr<const Recording> recording, std::function<void()> onNews)
    : recording_(std::move(recording)),
      worker_(
          workOfCrew(
              [recorded = recording_]() -> NewestWorker<size_t, Result>::Work {
                return [recorded, frames = std::make_shared<RecordedFrames>(*recorded)](size_t index, Result& result, const std::stop_token&) {
                  result.index = index;
                  const Recording::Frame& wanted = recorded->frames[index];
                  ServedFrame& served = result.taken.served;
                  served.requestId = wanted.head.id;
                  const SampleFramePtr frame = frames->at(wanted.seconds);
                  served.bytes = frames->bytes();
                  served.latency = latencyOf(frame->timings);
                  result.taken.view = viewAskedWith(*recorded, wanted, frame->camera);
                  served.frame = frame;
                };
              },
              ownCrewBesideThisThreads(Crew::kOfPictures), Crew::kOfPictures),
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

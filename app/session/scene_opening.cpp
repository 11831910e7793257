// One load at a time, and scenes that end.
// See scene_opening.h.
#include "app/session/scene_opening.h"

#include <optional>
#include <utility>

#include "render/core/crew_work.h"

namespace warpscope {

SceneOpening::SceneOpening(const std::function<void()>& onNews, std::shared_ptr<Crew> crew)
    : loader_(std::make_unique<Loader>(
          workOfCrew(
              [onNews]() -> Loader::Work {
                return [onNews](const LoadJob& job, Result& result, const std::stop_token& stop) {
                  result.name = job.name;
                  result.origin = job.origin;
                  result.whenOpened = job.whenOpened;
                  result.scene = std::make_shared<const ConnectedScene>(job.open(onNews, stop));
                };
              },
              std::move(crew), Crew::kOfPictures),
          onNews)) {}

void SceneOpening::open(LoadJob job) {
  cancel();
  name_ = job.name;
  error_.clear();
  loader_->post(std::move(job));
}

void SceneOpening::cancel() {
  loader_->cancel();
  if (std::optional<Result> unwanted = loader_->tryTake()) retire(std::move(unwanted->scene));
  name_.clear();
}

SceneOpening::Outcome SceneOpening::take() {
  std::optional<Result> result = loader_->tryTake();
  if (!result) return Outcome::nothing;
  if (result->name != name_) {
    retire(std::move(result->scene));
    return Outcome::nothing;
  }
  name_.clear();
  error_ = std::move(result->error);
  if (!result->scene) return Outcome::failed;
  retire(std::exchange(current_, std::move(result->scene)));
  origin_ = std::move(result->origin);
  if (result->whenOpened) result->whenOpened();
  return Outcome::opened;
}

void SceneOpening::setTransferFunction(TransferFunction function, MarcherPtr display) {
  ConnectedScene changed = *current_;
  changed.scene.transferFunction = std::move(function);
  changed.display = std::move(display);
  current_ = std::make_shared<const ConnectedScene>(std::move(changed));
}

void SceneOpening::retire(std::shared_ptr<const ConnectedScene> scene) {
  std::erase_if(retired_, [](const std::future<void>& one) { return one.wait_for(std::chrono::seconds(0)) == std::future_status::ready; });
  if (!scene) return;
  scene->source->requestStop();
  retired_.push_back(std::async(std::launch::async, [ending = std::move(scene)]() mutable {
    Crew::standBack(Crew::kOfMarches);
    ending.reset();
  }));
}

void SceneOpening::requestStop() {
  cancel();
  loader_->requestStop();
  retire(std::exchange(current_, nullptr));
}

bool SceneOpening::waitForEnd(std::chrono::steady_clock::time_point time) const {
  if (!loader_->waitForEnd(time)) return false;
  for (const std::future<void>& scene : retired_)
    if (scene.wait_until(time) != std::future_status::ready) return false;
  return true;
}

}  // namespace warpscope

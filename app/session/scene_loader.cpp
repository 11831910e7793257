// One load.
// See scene_loader.h.
#include "app/session/scene_loader.h"

namespace warpscope {

std::unique_ptr<SceneLoader> makeSceneLoader(std::function<void()> onNews) {
  return std::make_unique<SceneLoader>(
      [onNews]() -> SceneLoader::Work {
        return [onNews](const LoadJob& job, LoadResult& result, const std::stop_token& stop) {
          result.name = job.name;
          result.loaded = std::make_shared<const ConnectedScene>(job.open(onNews, stop));
        };
      },
      onNews);
}

}  // namespace warpscope

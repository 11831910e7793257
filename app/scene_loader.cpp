// One load.
// See scene_loader.h.
#include "app/scene_loader.h"

namespace warpscope {

std::unique_ptr<SceneLoader> makeSceneLoader(MarcherMaker makeMarcher, std::function<void()> onResult) {
  return std::make_unique<SceneLoader>(
      [makeMarcher = std::move(makeMarcher)]() -> SceneLoader::Work {
        return [makeMarcher](const LoadJob& job, LoadResult& result, const std::stop_token& stop) {
          result.name = job.name;
          auto loaded = std::make_shared<LoadedScene>();
          loaded->scene = job.open(stop);
          if (stop.stop_requested()) return;
          loaded->server = makeMarcher(loaded->scene);
          if (stop.stop_requested()) return;
          loaded->display = loaded->server->twin();
          result.loaded = std::move(loaded);
        };
      },
      std::move(onResult));
}

}  // namespace warpscope

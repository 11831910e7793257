// Opens scenes in the background, so that the window goes on while a volume is read.
// What comes out holds everything that depends on the scene alone.
#pragma once

#include <functional>
#include <memory>
#include <string>

#include "app/newest_worker.h"
#include "app/scene.h"
#include "render/march/marcher.h"

namespace warpscope {

struct LoadedScene {
  Scene scene;
  MarcherPtr server;   ///< the server's
  MarcherPtr display;  ///< of the reference and of techniques that march; apart from the server's, whose calls it would wait for
};

struct LoadJob {
  std::string name;                ///< as the user called it
  std::function<Scene(const std::stop_token&)> open;  ///< may throw; OperationCancelled if the token is set
};

struct LoadResult {
  std::string name;
  std::shared_ptr<const LoadedScene> loaded;  ///< null if there is an error
  std::string error;
};

using SceneLoader = NewestWorker<LoadJob, LoadResult>;
using MarcherMaker = std::function<MarcherPtr(const Scene&)>;

std::unique_ptr<SceneLoader> makeSceneLoader(MarcherMaker makeMarcher, std::function<void()> onResult);

}  // namespace warpscope

// Opens scenes in the background, so that the window goes on while a volume is read.
// What comes out holds everything that depends on the scene alone.
#pragma once

#include <functional>
#include <memory>
#include <string>

#include "app/frames/scene_connection.h"
#include "render/base/newest_worker.h"

namespace warpscope {

struct LoadJob {
  std::string name;  ///< as the user called it
  /// Opens the scene, whose source then calls the function. May throw; OperationCancelled if the token is set.
  std::function<ConnectedScene(const std::function<void()>& onNews, const std::stop_token&)> open;
};

struct LoadResult {
  std::string name;
  std::shared_ptr<const ConnectedScene> loaded;  ///< null if there is an error
  std::string error;
};

using SceneLoader = NewestWorker<LoadJob, LoadResult>;

/// `onNews` is called after each load and by the sources of the scenes.
std::unique_ptr<SceneLoader> makeSceneLoader(std::function<void()> onNews);

}  // namespace warpscope

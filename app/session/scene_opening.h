// The scene that is open, and the one that is being opened in the background, so that the window goes on while a volume is read.
// Scenes that were replaced end in the background too: a server may take its time.
#pragma once

#include <functional>
#include <future>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "app/frames/scene_connection.h"
#include "render/base/newest_worker.h"
#include "render/core/crew.h"

namespace warpscope {

struct LoadJob {
  std::string name;  ///< as the user called it
  /// Opens the scene, whose source then calls the function. May throw; OperationCancelled if the token is set.
  std::function<ConnectedScene(const std::function<void()>& onNews, const std::stop_token&)> open;
  std::optional<SceneOrigin> origin{};  ///< if it can be opened again by that
  std::function<void()> whenOpened{};   ///< called by SceneOpening::take() where the scene has opened, before anybody sees it; empty: nothing is
};

class SceneOpening {
 public:
  /// `onNews` is called after each load and by the sources of the scenes, on other threads. Loops of loads run on `crew`; null: on all cores.
  explicit SceneOpening(const std::function<void()>& onNews, std::shared_ptr<Crew> crew = nullptr);

  /// Opens a scene; the current one stays until it is there. The newest request wins and ends the one before it.
  void open(LoadJob job);
  /// Gives up opening; the current scene stays.
  void cancel();

  enum class Outcome { nothing, failed, opened };
  /// What became of the last request, once. Where it was opened, current() is the new scene, and the one before it is ending: nobody may use its
  /// source any more.
  Outcome take();

  /// The current scene by another function, marched for display by `display`.
  void setTransferFunction(TransferFunction function, MarcherPtr display);

  /// Null until the first scene is there.
  const ConnectedScene* current() const { return current_.get(); }
  /// Of the current scene; nothing if that cannot be opened again.
  const std::optional<SceneOrigin>& origin() const { return origin_; }
  /// Of the scene that is being opened; empty if none is.
  const std::string& name() const { return name_; }
  /// Why the last scene could not be opened; empty if it could.
  const std::string& error() const { return error_; }
  void dismissError() { error_.clear(); }

  /// Asks all threads to end; current() is null from then on.
  void requestStop();
  /// Waits until they have, but not beyond `time`. True if they have.
  bool waitForEnd(std::chrono::steady_clock::time_point time) const;

 private:
  struct Result {
    std::string name;
    std::shared_ptr<const ConnectedScene> scene;  // null if there is an error
    std::optional<SceneOrigin> origin;
    std::function<void()> whenOpened;
    std::string error;
  };
  using Loader = NewestWorker<LoadJob, Result>;

  /// Lets a scene end, if there is one.
  void retire(std::shared_ptr<const ConnectedScene> scene);

  std::shared_ptr<const ConnectedScene> current_;
  std::optional<SceneOrigin> origin_;
  std::string name_, error_;
  std::vector<std::future<void>> retired_;  // scenes that end
  std::unique_ptr<Loader> loader_;
};

}  // namespace warpscope

// Files that the user hands over, whatever they are: by a dialog, by dropping them onto the window, on the command line.
// Looking into one may take longer than the window may wait, hence the worker.
#pragma once

#include <deque>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "app/experiment/sweep_file.h"
#include "app/session/session_file.h"
#include "render/base/newest_worker.h"

namespace warpscope {

/// A sweep, a transfer function, a session (that of a recording, too), or else something to be opened as a scene: at most one of them.
struct HandedFile {
  std::string path;
  std::optional<SweepFile> sweep;
  std::optional<TransferFunction> transferFunction;
  std::optional<SessionFile> session;
  std::string error;  ///< why it cannot be read, where it is plain what it is; of others, opening them as scenes says what is wrong

  /// Whether what is on show is another scene with it.
  bool isScene() const { return error.empty() && !sweep && !transferFunction; }
};

using FileSorter = NewestWorker<std::string, HandedFile>;
std::unique_ptr<FileSorter> makeFileSorter(std::function<void()> onResult);

/// Files that were handed over together: the scene among them first, then what is about a scene. Of several scenes the last one is opened, as if they had been handed
/// over one after the other.
class HandedFiles {
 public:
  /// `onResult` is called on another thread whenever a file has been looked at.
  explicit HandedFiles(std::function<void()> onResult);

  /// In place of those that were handed over before and not taken.
  void hand(std::vector<std::string> paths);
  /// The next one, once all have been looked at, and what is about a scene only when none is being loaded (`isLoading`).
  std::optional<HandedFile> tryTake(bool isLoading);

 private:
  void put(HandedFile file);

  std::unique_ptr<FileSorter> sorter_;
  std::deque<std::string> unsorted_;  // the sorter has the first
  std::deque<HandedFile> sorted_;
};

}  // namespace warpscope

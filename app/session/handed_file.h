// Files that the user hands over, whatever they are: by a dialog, by dropping them onto the window, on the command line.
// Looking into one may take longer than the window may wait, hence the worker.
#pragma once

#include <functional>
#include <memory>
#include <optional>
#include <string>

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
};

using FileSorter = NewestWorker<std::string, HandedFile>;
std::unique_ptr<FileSorter> makeFileSorter(std::function<void()> onResult);

}  // namespace warpscope

// What `sweep` wrote, read back for the window's plot: the sweep.json of any scene and machine.
// Reading may take longer than the window may wait, hence the worker.
#pragma once

#include <filesystem>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "app/experiment/auto_choice.h"
#include "app/experiment/findings.h"
#include "render/base/newest_worker.h"
#include "render/core/transfer_function.h"

namespace warpscope {

struct SweepFile {
  std::string name;   ///< of the file, without its folder
  std::string scene;  ///< that was swept
  std::vector<Summary> summaries;
  std::vector<size_t> front;  ///< frontOf(summaries)
  std::shared_ptr<const AutoChoice> choice;  ///< for panels that choose by themselves; null if nothing there draws a frame
};

/// Nothing if the file is JSON without "rows": it is something else, a scene perhaps. Throws InputError that names the file and the line.
std::optional<SweepFile> readSweepFile(const std::filesystem::path& path);

/// A file that the user handed over: a sweep, a transfer function, or else a scene to be opened.
struct HandedFile {
  std::string path;
  std::optional<SweepFile> sweep;
  std::optional<TransferFunction> transferFunction;
  std::string error;  ///< why the sweep or the function cannot be read; files that are no JSON have none: opening them as scenes says what is wrong
};

using FileSorter = NewestWorker<std::string, HandedFile>;
std::unique_ptr<FileSorter> makeFileSorter(std::function<void()> onResult);

}  // namespace warpscope

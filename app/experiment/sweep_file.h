// What `sweep` wrote, read back for the window's plot: the sweep.json of any scene and machine.
#pragma once

#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "app/experiment/auto_choice.h"
#include "app/experiment/findings.h"

namespace warpscope {

class JsonDocument;

struct SweepFile {
  std::string name;   ///< of the file, without its folder
  std::string scene;  ///< that was swept
  std::vector<Summary> summaries;
  std::vector<size_t> front;  ///< frontOf(summaries)
  std::shared_ptr<const AutoChoice> choice;  ///< for panels that choose by themselves; null if nothing there draws a frame
};

/// Nothing if the file is JSON without "rows": it is something else, a scene perhaps. Throws InputError that names the file and the line.
std::optional<SweepFile> readSweepFile(const std::filesystem::path& path);
/// The same, of what was read of it.
std::optional<SweepFile> readSweep(const JsonDocument& document, const std::filesystem::path& path);

}  // namespace warpscope

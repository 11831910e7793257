// Rows from JSON.
// See sweep_file.h.
#include "app/experiment/sweep_file.h"

#include "app/scene/json_document.h"

namespace warpscope {
std::optional<SweepFile> readSweep(const JsonDocument& document, const std::filesystem::path& path) {
  const std::optional<Node> rows = document.root().find("rows");
  if (!rows) return std::nullopt;
  SweepFile file;
  file.name = path.filename().string();
  if (const std::optional<Node> scene = document.root().find("scene")) file.scene = scene->string();
  const std::vector<SweepRow> read = sweepRowsFrom(*rows, {});
  file.summaries = summariesOf(read);
  file.front = frontOf(file.summaries);
  if (auto choice = std::make_shared<const AutoChoice>(read); !choice->empty()) file.choice = std::move(choice);
  return file;
}

std::optional<SweepFile> readSweepFile(const std::filesystem::path& path) {
  return readSweep(JsonDocument::fromFile(path, JsonDocument::kLargestMeasured), path);
}

}  // namespace warpscope

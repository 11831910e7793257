// Rows from JSON.
// See sweep_file.h.
#include "app/experiment/sweep_file.h"

#include "app/scene/json_document.h"
#include "app/scene/transfer_file.h"
#include "render/base/error.h"

namespace warpscope {
namespace {

/// Nothing if the file is no JSON.
std::optional<JsonDocument> documentIn(const std::filesystem::path& path) {
  try {
    return JsonDocument::fromFile(path, JsonDocument::kLargestMeasured);
  } catch (const InputError&) {
    return std::nullopt;
  }
}

std::optional<SweepFile> sweepIn(const JsonDocument& document, const std::filesystem::path& path) {
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

}  // namespace

std::optional<SweepFile> readSweepFile(const std::filesystem::path& path) {
  const JsonDocument document = JsonDocument::fromFile(path, JsonDocument::kLargestMeasured);
  return sweepIn(document, path);
}

std::unique_ptr<FileSorter> makeFileSorter(std::function<void()> onResult) {
  const auto sort = [](const std::string& path, HandedFile& file, const std::stop_token&) {
    file.path = path;
    const std::optional<JsonDocument> document = documentIn(path);
    if (!document) return;
    if (isTransferFile(*document))
      file.transferFunction = readTransferFile(path);
    else
      file.sweep = sweepIn(*document, path);
  };
  return std::make_unique<FileSorter>([sort]() -> FileSorter::Work { return sort; }, std::move(onResult));
}

}  // namespace warpscope

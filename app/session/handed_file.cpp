// What a file is, by what it begins with or by its keys.
// See handed_file.h.
#include "app/session/handed_file.h"

#include "app/scene/json_document.h"
#include "app/scene/transfer_file.h"
#include "app/session/recorded_scene.h"
#include "render/base/error.h"
#include "render/volume/volume_format.h"

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

void sort(const std::string& path, HandedFile& file, const std::stop_token& stop) {
  file.path = path;
  if (isRecording(path)) {
    file.session = sessionFileOfRecording(path, stop);
    return;
  }
  // By its contents, whatever its name ends with; those of volumes are large, and no documents.
  if (formatOf(path) || !std::filesystem::is_regular_file(path)) return;
  const std::optional<JsonDocument> document = documentIn(path);
  if (!document) return;
  if (isSession(*document))
    file.session = readSession(*document);
  else if (isTransferFile(*document))
    file.transferFunction = readTransferFile(path);
  else
    file.sweep = readSweep(*document, path);
}

}  // namespace

std::unique_ptr<FileSorter> makeFileSorter(std::function<void()> onResult) {
  return std::make_unique<FileSorter>([]() -> FileSorter::Work { return sort; }, std::move(onResult));
}

}  // namespace warpscope

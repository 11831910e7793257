// What a file is, by what it begins with or by its keys.
// See handed_file.h.
#include "app/session/handed_file.h"

#include <iterator>
#include <utility>

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

HandedFiles::HandedFiles(std::function<void()> onResult) : sorter_(makeFileSorter(std::move(onResult))) {}

void HandedFiles::hand(std::vector<std::string> paths) {
  if (paths.empty()) return;
  sorted_.clear();
  unsorted_.assign(std::make_move_iterator(paths.begin()), std::make_move_iterator(paths.end()));
  sorter_->post(unsorted_.front());
}

void HandedFiles::put(HandedFile file) {
  if (!file.isScene()) return sorted_.push_back(std::move(file));
  if (!sorted_.empty() && sorted_.front().isScene()) sorted_.pop_front();
  sorted_.push_front(std::move(file));
}

std::optional<HandedFile> HandedFiles::tryTake(bool isLoading) {
  if (!unsorted_.empty()) {
    std::optional<HandedFile> file = sorter_->tryTake();
    if (!file || file->path != unsorted_.front()) return std::nullopt;  // one of before
    unsorted_.pop_front();
    put(std::move(*file));
    if (!unsorted_.empty()) {
      sorter_->post(unsorted_.front());
      return std::nullopt;
    }
  }
  const bool isToWait = !sorted_.empty() && isLoading && !sorted_.front().isScene() && sorted_.front().error.empty();
  if (sorted_.empty() || isToWait) return std::nullopt;
  std::optional<HandedFile> next(std::move(sorted_.front()));
  sorted_.pop_front();
  return next;
}

}  // namespace warpscope

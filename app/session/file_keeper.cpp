// Numbers and names.
// See file_keeper.h.
#include "app/session/file_keeper.h"

#include <algorithm>
#include <charconv>
#include <limits>
#include <mutex>
#include <utility>

#include "app/shell/output_files.h"

namespace warpscope {
namespace {

constexpr std::string_view kStem = "warpscope-";

/// One more than the greatest that a file in the folder has.
int freeNumber(const std::filesystem::path& folder) {
  int highest = 0;
  std::error_code failed;
  for (std::filesystem::directory_iterator at(folder, failed), end; !failed && at != end; at.increment(failed)) {
    const std::string name = at->path().filename().string();
    if (!name.starts_with(kStem)) continue;
    int number = 0;
    const auto [rest, error] = std::from_chars(name.data() + kStem.size(), name.data() + name.size(), number);
    if (error == std::errc() && number < std::numeric_limits<int>::max() && rest != name.data() + name.size() && (*rest == '.' || *rest == '-')) highest = std::max(highest, number);
  }
  return highest + 1;
}

/// Of the program: a number is found and taken by one at a time.
std::mutex numbering;

std::string write(const std::filesystem::path& folder, const std::vector<FileKeeper::File>& files) {
  try {
    std::vector<std::string> contents;
    for (const FileKeeper::File& file : files) contents.push_back(file.content());
    const std::scoped_lock lock(numbering);
    const std::string stem = std::string(kStem) + std::to_string(freeNumber(folder));
    requireWritable(folder / (stem + files.front().ending));  // a folder that is gone is not made again
    StagedFolder together(folder);
    for (size_t i = 0; i < files.size(); ++i) together.write(stem + files[i].ending, contents[i]);
    together.commit();
    std::string note = "saved " + (folder / (stem + files.front().ending)).string();
    for (size_t i = 1; i < files.size(); ++i) note += (i + 1 == files.size() ? " and " : ", ") + stem + files[i].ending;
    return note;
  } catch (const std::exception& error) {
    return error.what();
  }
}

}  // namespace

FileKeeper::FileKeeper(std::filesystem::path folder, std::function<void()> onNews) : folder_(std::move(folder)), onNews_(std::move(onNews)) {}

void FileKeeper::keep(std::vector<File> files) {
  if (files.empty()) return;
  work_.push_back(std::async(std::launch::async, [folder = folder_, files = std::move(files), onNews = onNews_] {
    std::string note = write(folder, files);
    onNews();
    return note;
  }));
}

std::optional<std::string> FileKeeper::takeNote() {
  const auto done = std::ranges::find_if(work_, [](const std::future<std::string>& one) { return one.wait_for(std::chrono::seconds(0)) == std::future_status::ready; });
  if (done == work_.end()) return std::nullopt;
  std::string note = done->get();
  work_.erase(done);
  return note;
}

}  // namespace warpscope

// Lines that are appended whole.
// See journal.h. POSIX: open, flock, write.
#include "app/experiment/journal.h"

#include <fcntl.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <cstring>

#include "app/scene/json_document.h"
#include "app/shell/log.h"
#include "render/base/error.h"

namespace warpscope {
namespace fs = std::filesystem;
namespace {

constexpr const char* kName = "sweep-unfinished.jsonl";

std::string lineOf(const nlohmann::json& json) { return json.dump(-1, ' ', false, nlohmann::json::error_handler_t::replace) + "\n"; }

}  // namespace

SweepJournal::SweepJournal(const fs::path& folder, const nlohmann::json& identity, const MarchSettings& base)
    : SweepJournal() {  // whole from here on: what throws below is closed by the destructor
  path_ = folder / kName;
  std::error_code error;
  fs::create_directories(folder, error);
  if (error) throw InputError(folder.string() + ": cannot be made: " + error.message());
  // Nothing is waited for in a file; and a link, which anybody may leave in a folder that others write to, is not followed.
  file_ = ::open(path_.c_str(), O_RDWR | O_CREAT | O_APPEND | O_CLOEXEC | O_NONBLOCK | O_NOFOLLOW, 0666);
  if (file_ < 0 && errno == ELOOP)
    throw InputError(path_.string() + ": is a symbolic link, which is not followed: what is done so far is kept in a file of that name; remove the link");
  if (file_ < 0) throw InputError(path_.string() + ": cannot be written: " + std::strerror(errno));
  if (struct stat status{}; ::fstat(file_, &status) != 0 || !S_ISREG(status.st_mode))
    throw InputError(path_.string() + ": is no file, so what is done cannot be kept there");
  if (::flock(file_, LOCK_EX | LOCK_NB) != 0)
    throw InputError(path_.string() + ": another sweep is at work in this folder; choose another one with --out");
  read(lineOf(identity), base);
}

SweepJournal::~SweepJournal() {
  if (file_ >= 0) ::close(file_);
}

void SweepJournal::read(const std::string& identity, const MarchSettings& base) {
  std::string text;
  std::array<char, 1 << 16> piece;
  while (true) {  // what is open, not what has the name by now
    const ssize_t count = ::read(file_, piece.data(), piece.size());
    if (count < 0 && errno == EINTR) continue;
    if (count < 0) throw InputError(path_.string() + ": cannot be read: " + std::strerror(errno));
    if (count == 0) break;
    text.append(piece.data(), static_cast<size_t>(count));
  }
  size_t at = 0;
  size_t kept = 0;
  bool isFirst = true;
  for (size_t end; (end = text.find('\n', at)) != std::string::npos; at = end + 1) {
    const std::string_view line(text.data() + at, end + 1 - at);
    if (isFirst && line != identity)
      throw InputError(path_.string() + ": an unfinished sweep of other settings, another scene or another version is here; run that one to its end, "
                                        "delete the file (also if it is damaged), or choose another folder with --out");
    if (!isFirst) readUnit(line, base);
    isFirst = false;
    kept = end + 1;
  }
  found_ = done_.size();
  if (kept < text.size() && ::ftruncate(file_, static_cast<off_t>(kept)) != 0)
    throw InputError(path_.string() + ": cannot be written: " + std::strerror(errno));
  if (isFirst) append(identity);
}

void SweepJournal::readUnit(std::string_view line, const MarchSettings& base) {
  try {
    const JsonDocument document(line, path_.string());
    std::vector<SweepRow> rows = sweepRowsFrom(document.root().at("rows"), base);
    if (!rows.empty()) done_[document.root().at("unit").string()] = std::move(rows);
  } catch (const InputError& error) {
    logWarning("a damaged line is passed over, and its part measured anew: " + std::string(error.what()));
  }
}

const std::vector<SweepRow>* SweepJournal::find(const std::string& unit) const {
  const auto found = done_.find(unit);
  return found == done_.end() ? nullptr : &found->second;
}

void SweepJournal::add(const std::string& unit, std::vector<SweepRow> rows) {
  nlohmann::json list = nlohmann::json::array();
  for (const SweepRow& row : rows) list.push_back(toJson(row));
  append(lineOf({{"unit", unit}, {"rows", list}}));
  done_[unit] = std::move(rows);
}

void SweepJournal::append(const std::string& line) {
  if (file_ < 0) return;
  for (size_t at = 0; at < line.size();) {
    const ssize_t written = ::write(file_, line.data() + at, line.size() - at);
    if (written < 0 && errno == EINTR) continue;
    if (written < 0) throw InputError(path_.string() + ": cannot be written: " + std::strerror(errno));
    at += static_cast<size_t>(written);
  }
}

void SweepJournal::remove() {
  if (file_ < 0) return;
  std::error_code ignored;
  fs::remove(path_, ignored);
}

}  // namespace warpscope

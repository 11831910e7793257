// Writing, renaming, cleaning up.
// See output_files.h.
#include "app/shell/output_files.h"

#include <algorithm>
#include <bitset>
#include <cerrno>
#include <charconv>
#include <cstdio>
#include <cstring>
#include <fstream>
#include <optional>
#include <random>

#if defined(_WIN32)
#include <io.h>
#else
#include <fcntl.h>
#include <sys/file.h>
#include <unistd.h>
#endif

#include "render/base/error.h"
#include "render/volume/reader.h"

namespace warpscope {
namespace fs = std::filesystem;
namespace {

bool mayWrite(const fs::path& path) {
#if defined(_WIN32)
  constexpr int kWrite = 2;
  return _waccess(path.c_str(), kWrite) == 0;
#else
  return access(path.c_str(), W_OK) == 0;
#endif
}

constexpr std::string_view kPartial = ".partial-";  // before a unique suffix
constexpr const char* kReplaced = ".replaced";      // what was there before, while files are put in place
constexpr char kDigits[] = "0123456789abcdef";
constexpr size_t kSuffixLength = 8;

std::string uniqueSuffix() {
  std::random_device random;
  std::string suffix;
  for (size_t i = 0; i < kSuffixLength; ++i) suffix += kDigits[random() % 16];
  return suffix;
}

bool isStagingName(const std::string& name) {
  return name.size() == kPartial.size() + kSuffixLength && name.starts_with(kPartial) &&
         name.find_first_not_of(kDigits, kPartial.size()) == std::string::npos;
}

/// An open folder that this process alone has locked; -1 if another one has, or if that is not possible there. `waits`: until it is free.
int lockFolder([[maybe_unused]] const fs::path& folder, [[maybe_unused]] bool waits) {
#if !defined(_WIN32)
  const int file = ::open(folder.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC | O_NOFOLLOW);
  if (file >= 0 && ::flock(file, waits ? LOCK_EX : LOCK_EX | LOCK_NB) == 0) return file;
  if (file >= 0) ::close(file);
#endif
  return -1;
}

void unlockFolder([[maybe_unused]] int file) {
#if !defined(_WIN32)
  if (file >= 0) ::close(file);
#endif
}

/// Removes what killed writers had gathered in `folder`: folders that nobody has locked. Those that hold what was there before stay.
void removeAbandoned(const fs::path& folder) {
  std::error_code ignored;
  std::vector<fs::path> found;
  for (const fs::directory_entry& entry : fs::directory_iterator(folder, ignored))
    if (isStagingName(entry.path().filename().string())) found.push_back(entry.path());
  for (const fs::path& staging : found) {
    const int lock = lockFolder(staging, false);
    if (lock < 0) continue;
    if (!fs::exists(staging / kReplaced, ignored) || fs::is_empty(staging / kReplaced, ignored)) fs::remove_all(staging, ignored);
    unlockFolder(lock);
  }
}

/// The permissions of the file that `target` is; none if there is no such file.
std::optional<fs::perms> permissionsOf(const fs::path& target) {
  std::error_code error;
  const fs::file_status status = fs::status(target, error);
  return fs::is_regular_file(status) ? std::optional(status.permissions() & fs::perms::all) : std::nullopt;
}

/// `like`: permissions that the file gets before the first byte is in it.
void writeBytes(const fs::path& path, const fs::path& shownAs, std::string_view bytes, std::optional<fs::perms> like = {},
                const std::stop_token& stop = {}) {
  constexpr size_t kPiece = 16 << 20;  // how often a stop is looked for
  errno = 0;
  std::ofstream file(path, std::ios::binary | std::ios::trunc);
  if (file && like) {
    std::error_code ignored;  // file systems without permissions
    fs::permissions(path, *like, ignored);
    errno = 0;
  }
  for (size_t at = 0; at < bytes.size() && file && !stop.stop_requested(); at += kPiece)
    file.write(bytes.data() + at, static_cast<std::streamsize>(std::min(kPiece, bytes.size() - at)));
  file.close();
  if (file && !stop.stop_requested()) return;
  const bool isInterrupted = errno == EINTR;  // while a pipe waited for its reader
  const std::string reason = errno != 0 ? std::strerror(errno) : "unknown reason";
  std::error_code ignored;
  if (fs::is_regular_file(path, ignored)) fs::remove(path, ignored);
  if (file || isInterrupted) throw OperationCancelled();
  throw InputError(shownAs.string() + ": cannot be written: " + reason);
}

/// A folder, or a file that its permissions protect, is not replaced, though the rights in its folder may suffice for that.
void requireReplaceable(const fs::path& target, const fs::path& shownAs) {
  std::error_code error;
  if (fs::is_directory(target, error)) throw InputError(shownAs.string() + ": cannot be written: it is a folder");
  if (fs::exists(target, error) && !mayWrite(target))
    throw InputError(shownAs.string() + ": cannot be written: " + std::make_error_code(std::errc::permission_denied).message());
}

/// Where a link leads that nothing is behind yet, however many there are in a row; `path` itself where there is no such link.
fs::path behindLinks(fs::path path) {
  constexpr int kMostLinks = 40;  // as Linux
  std::error_code error;
  for (int links = 0; links < kMostLinks && fs::is_symlink(fs::symlink_status(path, error)) && !fs::exists(path, error); ++links) {
    const fs::path next = fs::read_symlink(path, error);
    if (error) break;
    path = next.is_absolute() ? next : path.parent_path() / next;
  }
  return path;
}

/// Where `path` leads to, through links, whether something is there or not. Throws InputError for what can never become a file.
fs::path targetOf(const fs::path& path) {
  if (path.empty()) throw InputError("the file to write has no name: it cannot be written");
  if (!path.has_filename()) throw InputError(path.string() + ": cannot be written: it is a folder");
  std::error_code error;
  const fs::path behind = behindLinks(path);
  if (const fs::path folder = behind.parent_path(); !folder.empty() && fs::status(folder, error).type() == fs::file_type::not_found)
    throw InputError(path.string() + ": cannot be written: there is no folder " + folder.string());
  fs::path target = fs::weakly_canonical(behind, error);
  if (error) {
    const std::string reason = error.message();
    if (!fs::exists(path, error)) throw InputError(path.string() + ": cannot be written: " + reason);
    target = path;  // there, but without a path of its own: a pipe behind /dev/stdout
  }
  requireReplaceable(target, path);
  return target;
}

/// Beside it, in a name that is no longer than file systems take: of a long one the end is left out.
fs::path partialOf(const fs::path& target) {
  constexpr size_t kLongestName = 255;
  const std::string name = target.filename().string();
  return target.parent_path() / (name.substr(0, kLongestName - kPartial.size() - kSuffixLength) + std::string(kPartial) + uniqueSuffix());
}

constexpr int kMostInherited = 1024;
std::optional<std::bitset<kMostInherited>> inheritedFiles;  // nothing: nobody has noted them, and all are

/// The descriptor of this process that a path is a name of: /dev/stdout, /dev/fd/3. None for others.
std::optional<int> descriptorOf([[maybe_unused]] fs::path path) {
#if !defined(_WIN32)
  constexpr int kMostLinks = 16;
  for (int links = 0; links < kMostLinks; ++links) {
    const std::string folder = path.parent_path().string(), name = path.filename().string();
    int number = 0;
    const auto [end, failed] = std::from_chars(name.data(), name.data() + name.size(), number);
    if ((folder == "/dev/fd" || folder == "/proc/self/fd") && failed == std::errc() && end == name.data() + name.size()) return number;
    std::error_code error;
    const fs::path next = fs::read_symlink(path, error);
    if (error) break;
    path = next.is_absolute() ? next : path.parent_path() / next;
  }
#endif
  return {};
}

/// Behind what has been written there: a shell that appends to a file has it open, and goes on with it.
void writeTo([[maybe_unused]] int descriptor, const fs::path& shownAs, [[maybe_unused]] std::string_view bytes, [[maybe_unused]] const std::stop_token& stop) {
#if !defined(_WIN32)
  if (inheritedFiles && (descriptor >= kMostInherited || !inheritedFiles->test(static_cast<size_t>(descriptor))))
    throw InputError(shownAs.string() + ": cannot be written: " + std::strerror(EBADF));
  std::fflush(nullptr);
  constexpr size_t kPiece = 1 << 20;
  while (!bytes.empty()) {
    if (stop.stop_requested()) throw OperationCancelled();
    const ssize_t written = ::write(descriptor, bytes.data(), std::min(kPiece, bytes.size()));
    if (written < 0 && errno == EINTR) continue;
    if (written < 0) throw InputError(shownAs.string() + ": cannot be written: " + std::strerror(errno));
    bytes.remove_prefix(static_cast<size_t>(written));
  }
#endif
}

/// Files put in place one after the other, all of which can be taken back.
class Moves {
 public:
  /// Moves `staged` to `target`; what is there becomes `kept`.
  std::error_code put(const fs::path& staged, const fs::path& target, const fs::path& kept) {
    std::error_code error;
    Move move{target, kept, fs::exists(fs::symlink_status(target, error)), false};
    if (fs::is_directory(target, error)) return std::make_error_code(std::errc::is_a_directory);
    error.clear();
    if (move.isKept) {
      fs::create_hard_link(target, kept, error);  // so that there is no moment without the file
      if (error) fs::rename(target, kept, error);  // on file systems without hard links
      if (error) return error;
    }
    fs::rename(staged, target, error);
    move.isPlaced = !error;
    moves_.push_back(std::move(move));
    return error;
  }

  /// Removes what was put in place, and what was there comes back. False if some of that could not be done.
  bool undo() {
    bool isUndone = true;
    for (auto move = moves_.rbegin(); move != moves_.rend(); ++move) {
      std::error_code error;
      if (move->isKept)
        fs::rename(move->kept, move->target, error);
      else if (move->isPlaced)
        fs::remove(move->target, error);
      isUndone = isUndone && !error;
    }
    moves_.clear();
    return isUndone;
  }

 private:
  struct Move {
    fs::path target, kept;
    bool isKept, isPlaced;
  };
  std::vector<Move> moves_;
};

}  // namespace

bool isSpecial(const fs::path& path) {
  std::error_code unknown;
  return fs::exists(path, unknown) && !fs::is_regular_file(path, unknown);
}

void noteInheritedFiles() {
#if !defined(_WIN32)
  inheritedFiles.emplace();
  for (int descriptor = 0; descriptor < kMostInherited; ++descriptor)
    if (fcntl(descriptor, F_GETFD) >= 0) inheritedFiles->set(static_cast<size_t>(descriptor));
  for (int descriptor = 0; descriptor < 3; ++descriptor)
    if (!inheritedFiles->test(static_cast<size_t>(descriptor)))
      [[maybe_unused]] const int same = ::open("/dev/null", descriptor == 0 ? O_RDONLY : O_WRONLY);  // the lowest that is free
#endif
}

bool isSameFile(const fs::path& a, const fs::path& b) {
  std::error_code ignored;  // what cannot be looked at cannot be written to, which is said then
  const auto placeOf = [&](const fs::path& path) { return fs::weakly_canonical(fs::absolute(path, ignored), ignored); };
  return !a.empty() && !b.empty() && placeOf(a) == placeOf(b);
}

void requireNoneOf(const fs::path& written, const std::vector<fs::path>& read) {
  std::error_code unknown;
  if (!fs::exists(written, unknown)) return;  // nothing is lost, and no header need be looked at
  for (const fs::path& one : read) {
    if (one.empty()) continue;
    for (const fs::path& file : filesOfVolume(one))
      if (fs::equivalent(written, file, unknown) && !unknown) throw UsageError(written.string() + " is read here, and would be lost: give what is written another name");
  }
}

void requireWritable(const fs::path& path) {
  if (const std::optional<int> descriptor = descriptorOf(path)) return writeTo(*descriptor, path, {}, {});
  const fs::path target = targetOf(path);
  if (isSpecial(target)) return;
  const fs::path probe = partialOf(target);
  writeBytes(probe, path, {});
  std::error_code ignored;
  fs::remove(probe, ignored);
}

void writeFileWhole(const fs::path& path, std::string_view bytes, const std::stop_token& stop) {
  if (const std::optional<int> descriptor = descriptorOf(path)) return writeTo(*descriptor, path, bytes, stop);
  const fs::path target = targetOf(path);
  if (stop.stop_requested()) throw OperationCancelled();
  if (isSpecial(target)) return writeBytes(target, path, bytes, {}, stop);
  const fs::path partial = partialOf(target);
  writeBytes(partial, path, bytes, permissionsOf(target), stop);
  std::error_code error;
  fs::rename(partial, target, error);
  if (!error) return;
  std::error_code ignored;
  fs::remove(partial, ignored);
  throw InputError(path.string() + ": cannot be written: " + error.message());
}

void writeFilesWhole(const std::vector<FileBytes>& files, const std::stop_token& stop) {
  struct Staged {
    fs::path shownAs, target, partial, kept;
  };
  std::vector<Staged> staged;
  const auto removeAll = [&](fs::path Staged::*which) {
    std::error_code ignored;
    for (const Staged& one : staged) fs::remove(one.*which, ignored);
  };
  try {
    std::vector<const FileBytes*> others;
    for (const FileBytes& file : files) {
      const bool isOpen = descriptorOf(file.path).has_value();
      const fs::path target = isOpen ? fs::path() : targetOf(file.path);
      if (isOpen || isSpecial(target)) {
        others.push_back(&file);
        continue;
      }
      staged.push_back({file.path, target, partialOf(target), partialOf(target)});
      writeBytes(staged.back().partial, file.path, file.bytes, permissionsOf(target), stop);
    }
    for (const FileBytes* file : others) writeFileWhole(file->path, file->bytes, stop);  // cannot be taken back: before anything is replaced
    if (stop.stop_requested()) throw OperationCancelled();
    Moves moves;
    for (const Staged& one : staged)
      if (const std::error_code error = moves.put(one.partial, one.target, one.kept)) {
        std::string reason = one.shownAs.string() + ": cannot be written: " + error.message();
        if (!moves.undo()) reason += "; what was there before is beside it, in names with " + std::string(kPartial);
        throw InputError(reason);
      }
  } catch (...) {
    removeAll(&Staged::partial);
    throw;
  }
  removeAll(&Staged::kept);
}

StagedFolder::StagedFolder(fs::path folder, const std::vector<std::string>& names) : folder_(std::move(folder)) {
  if (folder_.empty()) throw InputError("the output folder has no name");
  std::error_code error;
  for (fs::path at = folder_; !at.empty() && !fs::exists(fs::symlink_status(at, error)); at = at.parent_path()) made_.insert(made_.begin(), at);
  fs::create_directories(folder_, error);
  if (!error && !fs::is_directory(folder_, error) && !error) error = std::make_error_code(std::errc::not_a_directory);
  if (!error) {
    removeAbandoned(folder_);
    error = makeStaging();
  }
  try {
    if (error) throw InputError(folder_.string() + ": cannot be used as output folder: " + error.message());
    for (const std::string& name : names) requireReplaceable(folder_ / name, folder_ / name);
  } catch (const InputError&) {
    cleanUp();
    throw;
  }
}

StagedFolder::~StagedFolder() { cleanUp(); }

std::error_code StagedFolder::makeStaging() {
  std::error_code error;
  // Another writer may take it for abandoned before it is locked, and remove it; then the next one is made.
  for (int attempt = 0; attempt < 10; ++attempt) {
    staging_ = partialOf(folder_ / "");
    fs::create_directory(staging_, error);
    if (error) break;
    lock_ = lockFolder(staging_, true);
    if (fs::exists(staging_)) return {};
    unlockFolder(lock_);
    lock_ = -1;
    error = std::make_error_code(std::errc::device_or_resource_busy);
  }
  staging_.clear();
  return error;
}

void StagedFolder::cleanUp() {
  std::error_code ignored;
  if (!staging_.empty()) fs::remove_all(staging_, ignored);
  unlockFolder(lock_);
  lock_ = -1;
  for (auto it = made_.rbegin(); it != made_.rend(); ++it) fs::remove(*it, ignored);  // removes only empty folders
}

void StagedFolder::write(const std::string& name, std::string_view bytes) {
  writeBytes(staging_ / name, folder_ / name, bytes, permissionsOf(folder_ / name));
  add(name);
}

void StagedFolder::add(const std::string& name) {
  const std::scoped_lock lock(mutex_);
  std::erase(names_, name);
  names_.push_back(name);
}

void StagedFolder::commit() {
  for (const std::string& name : names_) requireReplaceable(folder_ / name, folder_ / name);
  const fs::path replaced = staging_ / kReplaced;
  std::error_code error;
  fs::create_directory(replaced, error);
  if (error) throw InputError(folder_.string() + ": cannot be used as output folder: " + error.message());
  Moves moves;
  for (const std::string& name : names_) {
    error = moves.put(staging_ / name, folder_ / name, replaced / name);
    if (!error) continue;
    std::string reason = (folder_ / name).string() + ": cannot be written: " + error.message();
    if (!moves.undo()) {
      reason += "; files that were there before are now in " + replaced.string();
      staging_.clear();
    }
    throw InputError(reason);
  }
  made_.clear();
  fs::remove_all(staging_, error);
}

}  // namespace warpscope

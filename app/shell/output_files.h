// Output that is there whole or not at all.
// Files are written under another name in the same folder and renamed when complete (POSIX rename is atomic).
#pragma once

#include <filesystem>
#include <mutex>
#include <stop_token>
#include <string>
#include <string_view>
#include <system_error>
#include <vector>

namespace warpscope {

/// Writes `bytes` to `path`, replacing the file that is there, or that a link there leads to; its permissions stay, and if they forbid the
/// user to write, it is not replaced. What is there but no file (a device, a pipe) is written to as it is, and behind what is there what this process has open (/dev/stdout). Throws InputError naming the
/// path and the reason, or OperationCancelled if `stop` is set before the file is in its place; then nothing has changed.
void writeFileWhole(const std::filesystem::path& path, std::string_view bytes, const std::stop_token& stop = {});

struct FileBytes {
  std::filesystem::path path;
  std::string_view bytes;
};

/// As writeFileWhole, several files: where one of them cannot be written all are as they were, but for devices and pipes.
void writeFilesWhole(const std::vector<FileBytes>& files, const std::stop_token& stop = {});

/// Throws as writeFileWhole would, as far as that can be told without the bytes: to be asked before work that takes long.
void requireWritable(const std::filesystem::path& path);

/// Before any file is opened, of a program: the descriptors that whoever started it has given it are those that it may write to by name (/dev/fd/3), and its own are not. Of the first three
/// those that are closed become /dev/null, so that no file takes their place.
void noteInheritedFiles();

/// Whether what is there is no regular file: a folder, a device, or a pipe, which would wait for a reader.
bool isSpecial(const std::filesystem::path& path);

/// Whether two paths lead to one file, which need not be there, however they are written and whatever links lead there. Empty ones lead nowhere.
bool isSameFile(const std::filesystem::path& a, const std::filesystem::path& b);

/// Throws UsageError where what is to be written is one of the files that are read, by whatever name, or that the header of such a file names. Empty paths are none.
void requireNoneOf(const std::filesystem::path& written, const std::vector<std::filesystem::path>& read);

/// Gathers files for a folder and puts them there together. Without commit() everything that was written goes again, and the folder too
/// if it was made here. What a writer that was killed had gathered goes when the next one comes.
class StagedFolder {
 public:
  /// Makes the folder if need be and makes sure that it can be written to. `names`: files that are to come; one that is there and must not
  /// be replaced is noticed now, before the work, and not when it is done. Throws InputError.
  explicit StagedFolder(std::filesystem::path folder, const std::vector<std::string>& names = {});
  ~StagedFolder();
  StagedFolder(const StagedFolder&) = delete;
  StagedFolder& operator=(const StagedFolder&) = delete;

  /// Safe to call from several threads for different names. Throws InputError.
  void write(const std::string& name, std::string_view bytes);
  /// Where another program may write a file of that name, to be added then; what is not added goes.
  std::filesystem::path placeOf(const std::string& name) const { return staging_ / name; }
  /// As written: a file that is at its place. Safe as write().
  void add(const std::string& name);
  /// Moves everything into the folder in the order in which it was written, replacing files of the same names. Throws InputError; then
  /// what was moved is gone again and what it replaced is back.
  void commit();

 private:
  /// Makes the folder that files are gathered in, and locks it. Returns why not.
  std::error_code makeStaging();
  void cleanUp();

  std::filesystem::path folder_;
  std::filesystem::path staging_;
  int lock_ = -1;                   // of staging_, for as long as this lives; -1 where there are no locks
  std::mutex mutex_;                // of names_
  std::vector<std::string> names_;  // what was written
  std::vector<std::filesystem::path> made_;  // folders that did not exist, outermost first
};

}  // namespace warpscope

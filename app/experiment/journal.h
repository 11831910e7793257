// What an unfinished sweep has done so far, kept on disk line by line, so that the next run goes on from there.
// One JSON document a line (jsonlines.org); lines that were cut off or damaged are passed over.
#pragma once

#include <filesystem>
#include <map>
#include <nlohmann/json_fwd.hpp>
#include <string>
#include <string_view>
#include <vector>

#include "app/experiment/sweep_result.h"

namespace warpscope {

class SweepJournal {
 public:
  /// In memory alone.
  SweepJournal() = default;
  /// `identity` is all that results depend on. Goes on from the file in `folder` if it is of the same identity. The folder is made if need be.
  /// Throws InputError if the file is another sweep's, another process writes it, or it cannot be written.
  SweepJournal(const std::filesystem::path& folder, const nlohmann::json& identity, const MarchSettings& base);
  ~SweepJournal();
  SweepJournal(const SweepJournal&) = delete;
  SweepJournal& operator=(const SweepJournal&) = delete;

  /// The rows of a unit of work that is done; null if it is not.
  const std::vector<SweepRow>* find(const std::string& unit) const;
  /// Keeps them, on disk as well. Throws InputError.
  void add(const std::string& unit, std::vector<SweepRow> rows);
  /// How many units the file held.
  size_t found() const { return found_; }
  /// The sweep is done: the file goes.
  void remove();

 private:
  void read(const std::string& identity, const MarchSettings& base);
  /// A line that is damaged is passed over, with a warning.
  void readUnit(std::string_view line, const MarchSettings& base);
  void append(const std::string& line);

  std::filesystem::path path_;
  int file_ = -1;
  std::map<std::string, std::vector<SweepRow>> done_;
  size_t found_ = 0;
};

}  // namespace warpscope

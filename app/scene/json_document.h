// JSON from files, read with checks: every complaint names the file, the line and the key.
// RFC 8259, parsed by nlohmann-json; its values do not know their lines, so that a complaint walks over the text again to find its own.
#pragma once

#include <cmath>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "render/base/range.h"

namespace warpscope {

/// A document as the program prints it: indented, a line end at its end. Bytes that are not UTF-8 (in names of files) are replaced, and characters
/// that a terminal would obey are written as \u....
std::string textOf(const nlohmann::json& document);

/// The number, or null: JSON has no infinity and nothing that is no number.
inline nlohmann::json finiteOrNull(double value) { return std::isfinite(value) ? nlohmann::json(value) : nlohmann::json(nullptr); }

/// A parsed text, and the means to say on which line of it a key or an element begins.
class JsonDocument {
 public:
  /// Parses `text`; `source` names it in complaints. Throws InputError.
  JsonDocument(std::string_view text, std::string source);
  /// Reads and parses a regular file of at most `maxBytes`: what a person writes, or kLargestMeasured for what was measured. Throws InputError.
  static JsonDocument fromFile(const std::filesystem::path& path, uint64_t maxBytes = kLargestWritten);
  static constexpr uint64_t kLargestWritten = 16 << 20;
  static constexpr uint64_t kLargestMeasured = 256 << 20;  ///< a sweep of a quarter of a million rows

  class Node root() const;
  /// For whoever compares documents of this program instead of reading them.
  const nlohmann::json& value() const { return value_; }

 private:
  friend class Node;
  std::string text_;
  std::string source_;
  nlohmann::json value_;
};

/// One value of a document, with the means to complain about it. Refers to the document, which must outlive it.
class Node {
 public:
  /// `path`: the keys and indices that lead to the value from the root.
  Node(const JsonDocument& document, const nlohmann::json& value, std::vector<std::string> path)
      : document_(&document), value_(&value), path_(std::move(path)) {}

  /// Throws InputError "FILE:LINE: KEY TEXT".
  [[noreturn]] void fail(std::string_view text) const;

  /// Throws unless this is an object whose keys are all among `known`; proposes the nearest.
  void requireObject(std::span<const std::string_view> known) const;

  /// The member, or nothing if there is none. This must be an object.
  std::optional<Node> find(std::string_view key) const;
  /// As find, but a missing member is an error.
  Node at(std::string_view key) const;
  /// The elements; throws unless this is an array of lowest..highest elements.
  std::vector<Node> elements(size_t lowest, size_t highest) const;

  bool isString() const { return value_->is_string(); }
  bool isArray() const { return value_->is_array(); }
  bool isObject() const { return value_->is_object(); }
  bool isNull() const { return value_->is_null(); }
  /// Throw unless this is of that type (and within the range).
  std::string string() const;
  bool boolean() const;
  double number(double lowest, double highest) const;
  double number(const Range& range) const { return number(range.lowest, range.highest); }
  int64_t integer(int64_t lowest, int64_t highest) const;

 private:
  Node child(std::string key, const nlohmann::json& value) const;

  const JsonDocument* document_;
  const nlohmann::json* value_;
  std::vector<std::string> path_;
};

}  // namespace warpscope

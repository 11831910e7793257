// Looking a name up in a table, and "unknown X; did you mean Y?": the nearest of the names that would have been right, if it is near.
// Edit distance: Levenshtein 1966, by the dynamic programme of Wagner, Fischer 1974.
#pragma once

#include <iterator>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace warpscope {

/// Least number of insertions, deletions and replacements that turn one into the other.
size_t editDistance(std::string_view a, std::string_view b);

/// The nearest of `known`: one that begins so, or differs least; nothing if even that differs in more than about half the word.
std::optional<std::string_view> nearestName(std::string_view name, std::span<const std::string_view> known);

/// The end of a sentence about a name that is not known: `; did you mean 'NEAREST'? Known: ...` or, without a near name, `; known: ...`.
std::string knownInstead(std::string_view name, std::span<const std::string_view> known);

/// A sentence: `unknown KIND 'NAME'; did you mean 'NEAREST'? Known: ...`. Without a near name: `unknown KIND 'NAME'; known: ...`.
std::string unknownName(std::string_view kind, std::string_view name, std::span<const std::string_view> known);

/// The entry of that name; null if there is none. A table is a range of entries with a member `name` that outlives the answer.
template <class Table>
auto findNamed(const Table& table, std::string_view name) -> decltype(&*std::begin(table)) {
  for (const auto& entry : table)
    if (entry.name == name) return &entry;
  return nullptr;
}

/// The table's names: "auto cpu cuda".
template <class Table>
std::string listOf(const Table& table) {
  std::string text;
  for (const auto& entry : table) text += (text.empty() ? "" : " ") + std::string(entry.name);
  return text;
}

/// The sentence for a name that is not in the table.
template <class Table>
std::string unknownNameIn(const Table& table, std::string_view kind, std::string_view name) {
  std::vector<std::string_view> names;
  for (const auto& entry : table) names.push_back(entry.name);
  return unknownName(kind, name, names);
}

}  // namespace warpscope

// "Unknown X; did you mean Y?": the nearest of the names that would have been right.
// Edit distance: Levenshtein 1966, by the dynamic programme of Wagner, Fischer 1974.
#pragma once

#include <span>
#include <string>
#include <string_view>

namespace warpscope {

/// Least number of insertions, deletions and replacements that turn one into the other.
size_t editDistance(std::string_view a, std::string_view b);

/// A sentence: `unknown KIND 'NAME'; did you mean 'NEAREST'? Known: ...`.
std::string unknownName(std::string_view kind, std::string_view name, std::span<const std::string_view> known);

}  // namespace warpscope

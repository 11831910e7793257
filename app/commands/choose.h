// Options whose values have names: finding what was typed among them.
// For tables of entries with `name` and `value`, as NamedValue.
#pragma once

#include <string_view>

#include "render/base/error.h"
#include "render/base/nearest_name.h"

namespace warpscope {

/// The value that `name` stands for. Throws UsageError, which says what `kind` of name it should be and proposes the nearest.
template <class Table>
auto choose(std::string_view kind, std::string_view name, const Table& table) {
  if (const auto* entry = findNamed(table, name)) return entry->value;
  throw UsageError(unknownNameIn(table, kind, name));
}

}  // namespace warpscope

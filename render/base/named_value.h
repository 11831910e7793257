// Values that have names: what users type, files hold and menus list. A table is a range of NamedValue.
// The name is for machines and people alike; the summary is one phrase for people.
#pragma once

#include <string_view>

namespace warpscope {

template <class Enum>
struct NamedValue {
  Enum value;
  std::string_view name;
  std::string_view summary;
};

/// "?" for a value that the table lacks.
template <class Table>
constexpr std::string_view nameOf(const Table& table, decltype(table[0].value) value) {
  for (const auto& entry : table)
    if (entry.value == value) return entry.name;
  return "?";
}

}  // namespace warpscope

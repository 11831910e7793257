// What the program knows of itself, as tables of Markdown: the READMEs hold them, and a test compares.
// `warpscope info --table NAME` prints one.
#pragma once

#include <CLI/CLI.hpp>
#include <string>
#include <string_view>
#include <vector>

namespace warpscope {

/// The tables' names, in a fixed order.
std::vector<std::string_view> tableNames();

/// One table with its head, a line each. `program` has all commands. Throws UsageError for an unknown name.
std::string tableText(std::string_view name, const CLI::App& program);

}  // namespace warpscope

// Whose address that is.
// Mirrors render/base/mapped_files.h.
#include "render/base/mapped_files.h"

#include <gtest/gtest.h>
#include <unistd.h>

#include <optional>
#include <string>
#include <vector>

namespace warpscope {
namespace {

std::string named(const void* address, size_t room = 200) {
  std::string text(room, '?');
  text.resize(nameMappedPage(address, text.data(), room));
  return text;
}

TEST(MappedFiles, APageIsNamedForAsLongAsItsFileIsThere) {
  const auto page = static_cast<size_t>(getpagesize());
  const std::vector<char> memory(2 * page + 10), others(page);
  EXPECT_EQ(named(memory.data()), "");
  {
    const MappedFileNote note(memory.data(), memory.size(), "fish\n.raw"), other(others.data(), others.size(), "other.raw");
    EXPECT_EQ(named(memory.data()), "fish .raw: bytes 0 to " + std::to_string(page - 1));
    EXPECT_EQ(named(memory.data() + page + 7), "fish .raw: bytes " + std::to_string(page) + " to " + std::to_string(2 * page - 1));
    EXPECT_EQ(named(memory.data() + 2 * page + 9), "fish .raw: bytes " + std::to_string(2 * page) + " to " + std::to_string(2 * page + 9)) << "and where the file ends";
    EXPECT_EQ(named(memory.data() + 2 * page + 10), "");
    EXPECT_EQ(named(others.data()), "other.raw: bytes 0 to " + std::to_string(page - 1));
    EXPECT_EQ(named(memory.data(), 11), "fish .raw: ") << "as far as there is room";
  }
  EXPECT_EQ(named(memory.data()), "");
}

TEST(MappedFiles, MoreFilesThanAreKeptAccountOfDoNoHarm) {
  const std::vector<char> memory(1000);
  {
    std::vector<std::optional<MappedFileNote>> notes(200);
    for (size_t i = 0; i < notes.size(); ++i) notes[i].emplace(memory.data() + i, 1, std::to_string(i));
    EXPECT_EQ(named(memory.data() + 3), "3: bytes 0 to 0");
    EXPECT_EQ(named(memory.data() + 199), "");
  }
  const MappedFileNote note(memory.data() + 199, 1, "last");
  EXPECT_EQ(named(memory.data() + 199), "last: bytes 0 to 0");
}

}  // namespace
}  // namespace warpscope

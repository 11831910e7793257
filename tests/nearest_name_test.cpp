// Edit distance against its recursive definition, the sentence made of it, and looking names up in tables.
// Mirrors render/base/nearest_name.h.
#include "render/base/nearest_name.h"

#include <gmock/gmock.h>
#include <rapidcheck/gtest.h>

#include <array>

namespace warpscope {
namespace {

size_t naiveDistance(std::string_view a, std::string_view b) {
  if (a.empty() || b.empty()) return a.size() + b.size();
  if (a[0] == b[0]) return naiveDistance(a.substr(1), b.substr(1));
  return 1 + std::min({naiveDistance(a.substr(1), b), naiveDistance(a, b.substr(1)), naiveDistance(a.substr(1), b.substr(1))});
}

TEST(EditDistance, KnownValues) {
  EXPECT_EQ(editDistance("", ""), 0u);
  EXPECT_EQ(editDistance("", "abc"), 3u);
  EXPECT_EQ(editDistance("abc", ""), 3u);
  EXPECT_EQ(editDistance("kitten", "sitting"), 3u);
  EXPECT_EQ(editDistance("spheres", "sphere"), 1u);
  EXPECT_EQ(editDistance("ab", "ba"), 2u);
}

RC_GTEST_PROP(EditDistance, AgreesWithItsDefinition, ()) {
  const auto word = rc::gen::mapcat(rc::gen::inRange(0, 7), [](int length) {
    return rc::gen::container<std::string>(static_cast<size_t>(length), rc::gen::elementOf(std::string("abc")));
  });
  const std::string a = *word, b = *word;
  RC_ASSERT(editDistance(a, b) == naiveDistance(a, b));
  RC_ASSERT(editDistance(a, b) == editDistance(b, a));
}

TEST(UnknownName, ProposesTheNearestAndListsAll) {
  constexpr std::array<std::string_view, 3> known{"points", "spheres", "reference"};
  const std::string text = unknownName("technique", "spheers", known);
  EXPECT_THAT(text, testing::HasSubstr("unknown technique 'spheers'"));
  EXPECT_THAT(text, testing::HasSubstr("did you mean 'spheres'?"));
  for (const std::string_view name : known) EXPECT_THAT(text, testing::HasSubstr(std::string(name)));
}

TEST(UnknownName, ProposesNothingThatIsFar) {
  constexpr std::array<std::string_view, 3> known{"points", "spheres", "reference"};
  for (const std::string_view far : {"", "x", "bogus", "median", "sp"})
    EXPECT_EQ(unknownName("technique", far, known), "unknown technique '" + std::string(far) + "'; known: points spheres reference");
  EXPECT_EQ(nearestName("poi", known), "points") << "half of it";
  EXPECT_EQ(nearestName("POINTS", known), std::nullopt);
  constexpr std::array<std::string_view, 2> letters{"a", "egl"};
  EXPECT_EQ(nearestName("b", letters), std::nullopt);
  EXPECT_EQ(nearestName("elg", letters), "egl");
}

TEST(UnknownName, TiesGoToTheFirst) {
  constexpr std::array<std::string_view, 2> known{"bat", "cat"};
  EXPECT_THAT(unknownName("x", "rat", known), testing::HasSubstr("did you mean 'bat'?"));
  const std::string_view keys[] = {"front", "fovYDeg"};
  EXPECT_THAT(unknownName("key", "fov", keys), testing::HasSubstr("did you mean 'fovYDeg'?"));
  constexpr std::array<std::string_view, 2> options{"tf", "out"};
  EXPECT_EQ(nearestName("otu", options), "out") << "unless another has the first letter";
}

TEST(UnknownName, NothingKnownAndEndlessNames) {
  EXPECT_EQ(unknownName("key", "a", {}), "unknown key 'a'");
  constexpr std::array<std::string_view, 1> known{"a"};
  EXPECT_LT(unknownName("key", std::string(10'000'000, 'x'), known).size(), 200u);
}

TEST(FindNamed, GivesTheTablesOwnEntryOrNone) {
  struct Entry {
    std::string_view name;
    int value;
  };
  static constexpr std::array<Entry, 3> table{{{"one", 1}, {"two", 2}, {"two", 3}}};
  EXPECT_EQ(findNamed(table, "two"), &table[1]);
  EXPECT_EQ(findNamed(table, "Two"), nullptr);
  EXPECT_EQ(findNamed(table, ""), nullptr);
  EXPECT_EQ(unknownNameIn(table, "number", "twu"), "unknown number 'twu'; did you mean 'two'? Known: one two two");
}

}  // namespace
}  // namespace warpscope

// Who goes: the silent, the longest of no use, of the same address where that has too many; never who is kept.
// Mirrors net/places.h.
#include "net/places.h"

#include <gtest/gtest.h>

#include <vector>

namespace warpscope::net {
namespace {

using namespace std::chrono_literals;

TimePoint at(std::chrono::seconds time) { return TimePoint(time); }

TEST(Places, ThereIsRoomUntilAllAreTaken) {
  const std::vector<Occupant> one{{1, "a", at(1s)}};
  EXPECT_TRUE(admit({}, "a", {1, 1}, at(9s)).isPossible);
  const Admission second = admit(one, "b", {2, 1}, at(9s));
  EXPECT_TRUE(second.isPossible);
  EXPECT_FALSE(second.whoGoes);
}

TEST(Places, TheLongestOfNoUseGoes) {
  const std::vector<Occupant> three{{1, "a", at(5s)}, {2, "b", at(3s)}, {3, "c", at(4s)}};
  EXPECT_EQ(admit(three, "d", {3, 3}, at(9s)).whoGoes, 2u);
}

TEST(Places, TheSilentGoFirst) {
  const std::vector<Occupant> three{{1, "a", at(1s)}, {2, "b", at(3s), true}, {3, "c", at(4s), true}};
  EXPECT_EQ(admit(three, "d", {3, 3}, at(9s)).whoGoes, 2u);
}

TEST(Places, AnAddressWithTooManyLosesOneOfItsOwn) {
  const std::vector<Occupant> three{{1, "a", at(1s)}, {2, "b", at(3s)}, {3, "b", at(4s)}};
  EXPECT_EQ(admit(three, "b", {100, 2}, at(9s)).whoGoes, 2u) << "though there is room";
  EXPECT_EQ(admit(three, "b", {3, 2}, at(9s)).whoGoes, 2u) << "though another one was of no use for longer";
  EXPECT_EQ(admit(three, "a", {3, 2}, at(9s)).whoGoes, 1u);
}

TEST(Places, WhoIsKeptOrWasOfUseLatelyStays) {
  const std::vector<Occupant> two{{1, "a", at(1s), false, true}, {2, "b", at(8s)}};
  EXPECT_FALSE(admit(two, "c", {2, 2, 2s}, at(9s)).isPossible);
  EXPECT_EQ(admit(two, "c", {2, 2, 1s}, at(9s)).whoGoes, 2u);
}

}  // namespace
}  // namespace warpscope::net

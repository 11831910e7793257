// Bytes that wait to be sent.
// Mirrors net/held_bytes.h.
#include "net/held_bytes.h"

#include <gtest/gtest.h>

#include <array>
#include <utility>
#include <vector>

namespace warpscope::net {
namespace {

std::vector<std::byte> bytesOf(const HeldBytes& held) {
  const std::span<const std::byte> view = held;
  return {view.begin(), view.end()};
}

TEST(HeldBytes, AreThoseOfTheContainerThatWasGiven) {
  const std::vector<std::byte> own{std::byte{1}, std::byte{2}, std::byte{3}};
  HeldBytes held{std::vector(own)};
  EXPECT_EQ(held.size(), 3u);
  EXPECT_EQ(bytesOf(held), own);
  EXPECT_EQ(bytesOf(HeldBytes(std::array{std::byte{7}})), std::vector{std::byte{7}});
}

TEST(HeldBytes, GoWithTheLastOfTheCopies) {
  HeldBytes last;
  {
    const HeldBytes first{std::vector<std::byte>(1000, std::byte{5})};
    last = first;
  }
  EXPECT_EQ(bytesOf(last), std::vector<std::byte>(1000, std::byte{5}));
}

TEST(HeldBytes, AreNoneAtFirstAndAfterAMove) {
  EXPECT_TRUE(HeldBytes().empty());
  HeldBytes from{std::vector<std::byte>(9)};
  const HeldBytes to = std::move(from);
  EXPECT_EQ(to.size(), 9u);
  EXPECT_TRUE(from.empty());
  EXPECT_TRUE(bytesOf(from).empty());
}

}  // namespace
}  // namespace warpscope::net

// The ring of bytes against a plain string, over many pushes and pops.
// Mirrors net/byte_queue.h.
#include "net/byte_queue.h"

#include <gtest/gtest.h>

#include <random>
#include <string>

namespace warpscope::net {
namespace {

TEST(ByteQueue, GivesBackWhatWasPushed) {
  std::mt19937 dice(7);
  ByteQueue queue;
  std::string expected;
  unsigned char next = 0;
  for (int i = 0; i < 5000; ++i) {
    std::string pushed(dice() % 3000, '\0');
    for (char& c : pushed) c = static_cast<char>(next++);
    queue.push(asio::buffer(pushed));
    expected += pushed;
    const size_t count = i % 500 == 499 ? expected.size() : dice() % (expected.size() + 1) / (i % 3 + 1);
    std::string got(count, '\0');
    EXPECT_EQ(asio::buffer_copy(asio::buffer(got), queue.front(count)), count);
    ASSERT_EQ(got, expected.substr(0, count));
    queue.pop(count);
    expected.erase(0, count);
    ASSERT_EQ(queue.size(), expected.size());
  }
}

}  // namespace
}  // namespace warpscope::net

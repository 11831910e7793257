// Buffers that one large use made: they are given back once as many smaller uses as recent_need.h says have come.
// Mirrors render/base/recent_need.h, and FrameCodec as its user.
#include "render/base/recent_need.h"

#include <gtest/gtest.h>
#ifdef __GLIBC__
#include <malloc.h>
#endif

#include "tests/codec_frames.h"

namespace warpscope {
namespace {

TEST(RecentNeed, WhatNoneOfTheLastUsesNeededIsGivenBackOnce) {
  RecentNeed need;
  EXPECT_FALSE(need.exceedsRecent(1000));
  for (size_t i = 1; i < RecentNeed::kUses; ++i) EXPECT_FALSE(need.exceedsRecent(10)) << i;
  EXPECT_TRUE(need.exceedsRecent(10)) << "the large one is the seventeenth last";
  for (size_t i = 0; i < 100; ++i) EXPECT_FALSE(need.exceedsRecent(10)) << "given back is given back";
  EXPECT_FALSE(need.exceedsRecent(1000));
}

TEST(RecentNeed, WhatComesAgainAndAgainStays) {
  RecentNeed need;
  for (size_t i = 0; i < 1000; ++i) EXPECT_FALSE(need.exceedsRecent(i % RecentNeed::kUses == 0 ? 1000 : 1));
}

TEST(RecentNeed, SizesMayVaryALittle) {
  RecentNeed need;
  EXPECT_FALSE(need.exceedsRecent(1000));
  for (size_t i = 0; i < 100; ++i) EXPECT_FALSE(need.exceedsRecent(500));
  for (size_t i = 1; i < RecentNeed::kUses; ++i) EXPECT_FALSE(need.exceedsRecent(499));
  EXPECT_TRUE(need.exceedsRecent(499));
}

// What is held is asked of the C library: what is resident depends on what tests before this one left behind.
#if defined(__GLIBC__) && !defined(__SANITIZE_ADDRESS__) && !defined(__SANITIZE_THREAD__)
size_t heldBytes() {
  const struct mallinfo2 info = mallinfo2();
  return info.uordblks + info.hblkhd;
}

TEST(RecentNeed, OneLargeFrameDoesNotInflateADecoderForGood) {
  constexpr size_t kMiB = size_t{1} << 20;
  FrameCodec encoder, decoder;
  const auto decode = [&](const SampleFrame& frame, const ByteVector& payload) {
    SampleFrame decoded = headOf(frame);
    ASSERT_EQ(decoder.decode(payload, frame.size(), decoded), std::nullopt);
  };
  const SampleFrame small = garbageFrame(256, 256, 256 * 256, 1);
  const ByteVector smallPayload = encoder.encode(small, kLossless);
  for (size_t i = 0; i < 20; ++i) decode(small, smallPayload);
  const size_t before = heldBytes();
  {
    const SampleFrame large = garbageFrame(4096, 2048, 4096 * 2048, 2);
    const ByteVector payload = FrameCodec().encode(large, kLossless);
    decode(large, payload);
  }
  const size_t after = heldBytes();
  EXPECT_GT(after, before + 4 * kMiB) << "nothing was kept: this test shows nothing";
  for (size_t i = 0; i < RecentNeed::kUses; ++i) decode(small, smallPayload);
  EXPECT_LT(heldBytes(), before + 1 * kMiB) << "of " << (after - before) / kMiB << " MiB";
}
#endif

}  // namespace
}  // namespace warpscope

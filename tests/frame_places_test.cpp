// What a look at some of a frame's samples and segments says of where they lie.
// Mirrors render/march/frame_places.h.
#include "render/march/frame_places.h"

#include <gtest/gtest.h>

#include "tests/codec_frames.h"
#include "tests/held_frame.h"

namespace warpscope {
namespace {

TEST(FramePlaces, NeverMoreAreLookedAtThanThereIsRoomFor) {
  for (const size_t count : {size_t{1}, size_t{255}, size_t{256}, size_t{511}, size_t{512}, size_t{513}, size_t{767}, size_t{768}, size_t{1} << 20, (size_t{1} << 29) - 1}) {
    const size_t stride = probeStride(count), looked = (count + stride - 1) / stride;
    EXPECT_LE(looked, kMostFrameProbes) << count;
    EXPECT_GE(looked, std::min(count, kFrameProbes)) << count;
  }
}

TEST(FramePlaces, SevenOfEightDecide) {
  EXPECT_EQ((SampleVotes{.looked = 8, .onSteps = 7, .onHalfSteps = 8}).placement(), Placement::steps);
  EXPECT_EQ((SampleVotes{.looked = 8, .onSteps = 6, .onHalfSteps = 7}).placement(), Placement::halfSteps);
  EXPECT_EQ((SampleVotes{.looked = 8, .onSteps = 6, .onHalfSteps = 6}).placement(), Placement::depth);
  EXPECT_EQ((BorderVotes{.looked = 8, .nearBorders = 7}).placement(), kBorders);
  EXPECT_EQ((BorderVotes{.looked = 8, .nearBorders = 6}).placement(), Placement::depth);
}

/// `by` more in the depth codes of all samples, and of all segments' beginnings.
SampleFrame shifted(SampleFrame frame, uint32_t by) {
  for (PackedSample& sample : frame.samples) sample = packCodes(columnOf(sample), rowOf(sample), depthCode(sample) + by, radiusCode(sample));
  for (SegmentDepths& depths : frame.segments.depths) depths = {depths.begin + by, std::max(depths.begin + by, depths.end)};
  return frame;
}

TEST(FramePlaces, AreThoseOfTheMarch) {
  MarchSettings settings;
  settings.sample.segments = 3;
  const SampleFrame frame = marched(shells(), settings, 80, 50);
  EXPECT_EQ(placementOf(frame), Placement::steps);
  EXPECT_EQ(borderPlacementOf(frame), kBorders);
  settings.sample.heuristic = Heuristic::gradient;
  const SampleFrame between = marched(shells(), settings, 80, 50);
  EXPECT_NE(placementOf(between), Placement::depth);
  const SampleFrame beside = shifted(frame, 17);
  EXPECT_EQ(placementOf(beside), Placement::depth);
  EXPECT_EQ(borderPlacementOf(beside), Placement::depth);
  EXPECT_EQ(borderPlacementOf(marched(shells(), {}, 80, 50)), Placement::depth) << "no segments";
  SampleFrame stepless = frame;
  stepless.settings.render.step = 0.0f;
  EXPECT_EQ(placementOf(stepless), Placement::depth);
  EXPECT_EQ(borderPlacementOf(stepless), Placement::depth);
}

TEST(FramePlaces, OfWhatIsAwayAreThoseThatItsMarcherFound) {
  MarchSettings settings;
  settings.sample.segments = 3;
  SampleFrame frame = leftOnDevice(marched(shells(), settings, 80, 50));
  for (const FramePlacements& found : {FramePlacements{Placement::halfSteps, kBorders}, FramePlacements{Placement::depth, Placement::depth}}) {
    frame.device = std::make_shared<const HeldFrame>(onHost(frame), found);
    EXPECT_EQ(placementOf(frame), found.samples);
    EXPECT_EQ(borderPlacementOf(frame), found.borders);
  }
}

}  // namespace
}  // namespace warpscope

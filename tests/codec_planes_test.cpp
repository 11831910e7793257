// Planes of frames as bytes and back: known ones as they were, unknown ones left out, wrong ones refused.
#include "render/codec/codec.h"

#include <gtest/gtest.h>

#include "render/base/error.h"
#include "tests/codec_frames.h"

namespace warpscope {
namespace {

TEST(Codec, KnownPlanesComeBack) {
  for (const SampleFrame& frame :
       {marched(shells(), {}), framedPixels(9, 9, {1, 2, 7}), garbageFrame(20, 30, 700, 2), garbageFrame(9, 9, 0, 0)})
    expectRoundTrips(withExtents(frame), std::to_string(frame.size()));
}

/// What is not known is skipped, by name and length; samples, colours and the other planes are as if it had not been
/// there.
TEST(Codec, UnknownPlanesAreLeftOut) {
  constexpr Heuristic kTwo[] = {Heuristic::entrance, Heuristic::exit};
  const SampleFrame known = withExtents(marchedLayers(shells(), kTwo));
  const std::vector<uint16_t> future(known.size(), 4711);
  SampleFrame frame = known;
  frame.planes.insert(frame.planes.begin() + 1,
                      planeOf("future", PlaneElement::uint16, std::span<const uint16_t>(future)));
  SampleFrame otherKind = known;
  otherKind.planes[1] = planeOf(kExtentPlane, PlaneElement::uint16, std::span<const uint16_t>(future));
  for (const CodecSettings& settings : {kRaw, kLossless, kTiled}) {
    SampleFrame decoded = headOf(frame);
    ASSERT_EQ(FrameCodec().decode(FrameCodec().encode(frame, settings), frame.size(), decoded), std::nullopt);
    EXPECT_TRUE(sameFrame(decoded, known));
    // Of an element that there is not yet.
    decoded = headOf(frame);
    decoded.planes[1].element = static_cast<PlaneElement>(200);
    ASSERT_EQ(FrameCodec().decode(FrameCodec().encode(frame, settings), frame.size(), decoded), std::nullopt);
    EXPECT_TRUE(sameFrame(decoded, known));
    // Of a name that is known, but of other values.
    decoded = headOf(otherKind);
    ASSERT_EQ(FrameCodec().decode(FrameCodec().encode(otherKind, settings), frame.size(), decoded), std::nullopt);
    ASSERT_EQ(decoded.planes.size(), 1u);
    EXPECT_EQ(decoded.planes[0], known.planes[0]);
    EXPECT_EQ(decoded.samples, known.samples);
  }
}

TEST(Codec, FramesWithoutPlanesHaveNoBytesForThem) {
  const SampleFrame frame = marched(shells(), {}, 24, 20);
  EXPECT_EQ(FrameCodec().encode(frame, kRaw).size(), 9 + 12 * frame.size());
  for (const CodecSettings& settings : kEveryCoding) {
    const size_t bytes = FrameCodec().encode(frame, settings).size();
    SampleFrame layered = frame;
    layered.planes.push_back(layerPlane(std::vector<uint8_t>(frame.size(), 0)));
    constexpr size_t kModelOfOneSymbol = 3;  // that no pixel has further samples
    const size_t more = settings.format == PayloadFormat::raw ? frame.size() : settings.format == PayloadFormat::tiled ? kModelOfOneSymbol : 0;
    EXPECT_EQ(FrameCodec().encode(layered, settings).size(), bytes + 4 + more);
  }
}

TEST(Codec, PlanesThatAreNotWhatTheySayAreRefused) {
  const SampleFrame frame = withExtents(framedPixels(8, 8, {1, 2, 3, 4}));
  const auto refuses = [](const SampleFrame& changed) {
    EXPECT_THROW(FrameCodec().encode(changed, kLossless), InputError);
  };
  SampleFrame changed = frame;
  changed.planes[0].values.pop_back();
  refuses(changed);
  changed = frame;
  changed.planes[0].name = "";
  refuses(changed);
  changed.planes[0].name = std::string(kMaxPlaneName + 1, 'p');
  refuses(changed);
  changed = frame;
  changed.planes.push_back(changed.planes[0]);
  refuses(changed);
  changed = frame;
  changed.planes[0].element = static_cast<PlaneElement>(200);
  refuses(changed);
  changed = frame;
  for (size_t i = 0; i < kMaxPlanes; ++i) {
    changed.planes.push_back(changed.planes[0]);
    changed.planes.back().name += std::to_string(i);
  }
  refuses(changed);
  for (const std::vector<uint8_t>& layers :
       {std::vector<uint8_t>{1, 0, 0, 0}, {0, 2, 0, 0}, {0, 1, 1, 0}, {0, 0, 255, 0}}) {
    changed = frame;
    changed.planes.push_back(layerPlane(layers));
    refuses(changed);
  }
}

TEST(Codec, LayersThatDoNotCountUpAreRefused) {
  const std::vector<uint32_t> pixels{1, 1, 1, 5};
  const SampleFrame frame = withLayers(framedPixels(8, 8, pixels), pixels);
  ByteVector payload = FrameCodec().encode(frame, kRaw);
  SampleFrame decoded = headOf(frame);
  ASSERT_EQ(FrameCodec().decode(payload, frame.size(), decoded), std::nullopt);
  payload.at(9 + 4 + 1) = std::byte{2};
  EXPECT_NE(FrameCodec().decode(sealed(payload), frame.size(), decoded), std::nullopt);
  EXPECT_TRUE(decoded.samples.empty());
  EXPECT_TRUE(decoded.layers().empty());
}

}  // namespace
}  // namespace warpscope

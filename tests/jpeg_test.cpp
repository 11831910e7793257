// A frame's own picture as a JPEG, and damaged ones.
#include "render/codec/jpeg.h"

#include <gtest/gtest.h>

#include "render/core/color.h"
#include "render/march/own_picture.h"
#include "tests/codec_frames.h"

namespace warpscope {
namespace {

TEST(FramePicture, IsTheFramesOwnPicture) {
  const SampleFrame frame = marched(shells(), {}, 200, 150);
  const glm::vec3 background(0.1f, 0.2f, 0.3f);
  Image<Rgba8> picture;
  const ByteVector jpeg = encodeFramePicture(frame, background, 95);
  ASSERT_EQ(decodeFramePicture(jpeg, frame.camera, picture), std::nullopt);
  EXPECT_LT(encodeFramePicture(frame, background, 50).size(), jpeg.size());
  const Image<uint32_t> seen = ownPicture(frame);
  double squares = 0.0;
  for (size_t i = 0; i < picture.size(); ++i) {
    const glm::vec4 color = seen[i] == kNoSample ? glm::vec4(0.0f) : decodeRgba8(frame.colors[seen[i]]);
    const Rgba8 expected = ColorTables::instance().encodeOver(color, background);
    for (int shift = 0; shift < 24; shift += 8) {
      const double difference = (picture[i] >> shift & 255) / 255.0 - (expected >> shift & 255) / 255.0;
      squares += difference * difference / (3.0 * static_cast<double>(picture.size()));
    }
  }
  EXPECT_LT(squares, 1e-3);

  Camera other = frame.camera;
  other.width = 201;
  EXPECT_NE(decodeFramePicture(jpeg, other, picture), std::nullopt);
  EXPECT_TRUE(picture.empty());
}

TEST(FramePicture, DamagedOnesAreRefusedAndDoNotSpoilTheNext) {
  const SampleFrame frame = marched(shells(), {}, 40, 32);
  ByteVector jpeg = encodeFramePicture(frame, glm::vec3(0.0f), 80);
  Image<Rgba8> picture;
  for (size_t length = 0; length + 2 < jpeg.size(); ++length) {  // without its end marker alone a picture is whole
    EXPECT_NE(decodeFramePicture(std::span(jpeg).first(length), frame.camera, picture), std::nullopt) << length;
    ASSERT_EQ(decodeFramePicture(jpeg, frame.camera, picture), std::nullopt) << length;
  }
  const ByteVector whole = jpeg;
  for (size_t i = 0; i < jpeg.size(); ++i) {
    jpeg[i] ^= std::byte{0xff};
    decodeFramePicture(jpeg, frame.camera, picture);
    ASSERT_EQ(decodeFramePicture(whole, frame.camera, picture), std::nullopt) << i;
    jpeg[i] ^= std::byte{0xff};
  }
}

}  // namespace
}  // namespace warpscope

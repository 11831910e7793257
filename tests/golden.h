// Comparing pictures with golden ones, and what is left behind where they differ.
//
// The tolerance, for every picture and every platform alike: at most 0.1 % of the pixels may differ by more than 2/255 in any channel.
// Two rasterisers may disagree about a pixel whose centre lies on a point's edge, and two processors in the last bit of a colour or a
// depth; a picture that is upside down or one pixel off differs in far more pixels (golden_test.cpp shows that it does).
#pragma once

#include <gtest/gtest.h>

#include <algorithm>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <string>

#include "app/picture/picture.h"
#include "app/shell/output_files.h"

namespace warpscope {

inline constexpr int kGoldenChannelTolerance = 2;        ///< of 255
inline constexpr double kGoldenPixelTolerance = 0.001;   ///< fraction of all pixels

struct PictureDifference {
  bool sameSize = false;
  double fraction = 1.0;  ///< of the pixels that differ by more than kGoldenChannelTolerance
  int largest = 255;      ///< over all channels

  bool isTolerable() const { return sameSize && fraction <= kGoldenPixelTolerance; }
};

inline int channelDifference(Rgba8 a, Rgba8 b) {
  int largest = 0;
  for (int shift = 0; shift < 32; shift += 8)
    largest = std::max(largest, std::abs(static_cast<int>(a >> shift & 255) - static_cast<int>(b >> shift & 255)));
  return largest;
}

inline PictureDifference comparePictures(const Image<Rgba8>& image, const Image<Rgba8>& expected) {
  PictureDifference difference;
  difference.sameSize = image.width() == expected.width() && image.height() == expected.height() && !image.empty();
  if (!difference.sameSize) return difference;
  size_t different = 0;
  difference.largest = 0;
  for (size_t i = 0; i < image.size(); ++i) {
    const int largest = channelDifference(image[i], expected[i]);
    difference.largest = std::max(difference.largest, largest);
    different += largest > kGoldenChannelTolerance;
  }
  difference.fraction = static_cast<double>(different) / static_cast<double>(image.size());
  return difference;
}

/// Sixteen times the difference, opaque; black where the pictures are equal.
inline Image<Rgba8> amplifiedDifference(const Image<Rgba8>& image, const Image<Rgba8>& expected) {
  Image<Rgba8> result(std::min(image.width(), expected.width()), std::min(image.height(), expected.height()));
  for (uint32_t y = 0; y < result.height(); ++y)
    for (uint32_t x = 0; x < result.width(); ++x) {
      Rgba8 pixel = 0xff000000u;
      for (int shift = 0; shift < 24; shift += 8) {
        const int a = static_cast<int>(image(x, y) >> shift & 255), b = static_cast<int>(expected(x, y) >> shift & 255);
        pixel |= static_cast<Rgba8>(std::min(255, 16 * std::abs(a - b))) << shift;
      }
      result(x, y) = pixel;
    }
  return result;
}

/// Where failing tests leave pictures: $WARPSCOPE_TEST_ARTIFACTS (the launcher sets it), else beside the test program.
inline std::filesystem::path artifactFolder() {
  const char* variable = std::getenv("WARPSCOPE_TEST_ARTIFACTS");
  std::filesystem::path folder = variable != nullptr && *variable != '\0'
                                     ? std::filesystem::path(variable)
                                     : std::filesystem::read_symlink("/proc/self/exe").parent_path() / "test-artifacts";
  std::filesystem::create_directories(folder);
  return folder;
}

/// Writes image, expected and amplified difference; returns a text with their paths.
inline std::string leaveArtifacts(const std::string& name, const Image<Rgba8>& image, const Image<Rgba8>& expected) {
  const std::filesystem::path folder = artifactFolder();
  std::string paths;
  const auto leave = [&](const std::string& suffix, const Image<Rgba8>& picture) {
    if (picture.empty()) return;
    const std::filesystem::path path = folder / (name + suffix + ".png");
    writeFileWhole(path, encodePng(picture));
    paths += "\n  " + path.string();
  };
  leave("", image);
  leave("-expected", expected);
  leave("-difference", amplifiedDifference(image, expected));
  return paths;
}

/// True if golden pictures are to be written instead of compared with.
inline bool isUpdatingGolden() {
  const char* variable = std::getenv("WARPSCOPE_UPDATE_GOLDEN");
  return variable != nullptr && std::string(variable) == "1";
}

}  // namespace warpscope

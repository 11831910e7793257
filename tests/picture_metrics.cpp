// What the metrics say of 8-bit pictures in files, for tests that ask other implementations about the same bytes.
// Usage: picture_metrics REFERENCE.png PICTURE.png...; opaque pictures of one size. Prints a JSON array: psnrDb (null: equal), ssim, flip of each.
#include <cmath>
#include <cstdio>
#include <exception>
#include <iostream>
#include <nlohmann/json.hpp>

#include "app/picture/picture.h"
#include "render/base/error.h"
#include "render/core/color.h"
#include "render/metrics/picture_errors.h"

namespace warpscope {
namespace {

Image<glm::vec4> linearPicture(const char* path) {
  const Image<Rgba8> codes = readPng(path);
  Image<glm::vec4> picture(codes.width(), codes.height());
  for (size_t i = 0; i < codes.size(); ++i) {
    if (codes[i] >> 24 != 255) throw InputError(std::string(path) + ": a pixel is not opaque");
    picture[i] = decodeRgba8(codes[i]);
  }
  return picture;
}

int run(int count, char** paths) {
  const PictureJudge judge(linearPicture(paths[0]), glm::vec3(0.0f));
  nlohmann::json results = nlohmann::json::array();
  for (int i = 1; i < count; ++i) {
    WarpedImage image;
    image.color = linearPicture(paths[i]);
    image.samples.resize(image.color.width(), image.color.height(), 0);
    const PictureErrors errors = judge.errorsOf(image);
    results.push_back({{"psnrDb", std::isfinite(errors.psnrDb) ? nlohmann::json(errors.psnrDb) : nullptr}, {"ssim", errors.ssim}, {"flip", errors.flip}});
  }
  std::cout << results.dump(2) << "\n";
  return 0;
}

}  // namespace
}  // namespace warpscope

int main(int argc, char** argv) {
  if (argc < 3) {
    std::fputs("usage: picture_metrics REFERENCE.png PICTURE.png...\n", stderr);
    return 2;
  }
  try {
    return warpscope::run(argc - 1, argv + 1);
  } catch (const std::exception& error) {
    std::fprintf(stderr, "picture_metrics: %s\n", error.what());
    return 1;
  }
}

// Numbers that are not finite, from file to JSON, through the program: one policy, stated in render/README.md ("Numbers that are none").
// Voxels are shown as nothing, counted and reported; whatever else brings some in is refused; JSON has null for what has no number.
#include <cmath>
#include <functional>
#include <limits>

#include "tests/cli.h"

namespace warpscope {
namespace {

using nlohmann::json;

constexpr uint32_t kX = 24, kY = 22, kZ = 20;
constexpr float kInfinity = std::numeric_limits<float>::infinity();

/// A ball, of whose voxels those with x >= 12 and every 13th are `broken`. The count of those in `count`.
std::string brokenBall(float broken, size_t& count) {
  std::vector<float> voxels;
  count = 0;
  for (uint32_t z = 0; z < kZ; ++z)
    for (uint32_t y = 0; y < kY; ++y)
      for (uint32_t x = 0; x < kX; ++x) {
        const float distance = std::hypot(static_cast<float>(x) - 11.5f, static_cast<float>(y) - 10.5f, static_cast<float>(z) - 9.5f);
        const bool isBroken = x >= 12 || voxels.size() % 13 == 0;
        count += isBroken;
        voxels.push_back(isBroken ? broken : std::max(0.0f, 9.0f - distance));
      }
  return {reinterpret_cast<const char*>(voxels.data()), voxels.size() * sizeof(float)};
}

/// Every number of a document; `visit` gets where it stands, too.
void forEachNumber(const json& value, const std::string& path, const std::function<void(const std::string&, double)>& visit) {
  if (value.is_number()) visit(path, value.get<double>());
  if (value.is_structured())
    for (const auto& [key, child] : value.items()) forEachNumber(child, path + "/" + key, visit);
}

TEST_F(CommandLine, VoxelsThatAreNotFiniteAreNothingAndAreCounted) {
  size_t count = 0;
  std::vector<std::string> pictures;
  folder_.write("scene.json", R"({"name": "ball", "volume": {"file": "ball_24x22x20_float32.raw"}, "views": [{"distance": 0.7}, {"angleDeg": 25}],
    "transferFunction": {"points": [{"value": 1, "color": [1, 0.5, 0.2], "alpha": 0}, {"value": 6, "color": [0.3, 0.6, 1], "alpha": 0.9}]}})");
  for (const float broken : {std::nanf(""), kInfinity, -kInfinity}) {
    SCOPED_TRACE(broken);
    folder_.write("ball_24x22x20_float32.raw", brokenBall(broken, count));
    const ProgramResult shot = succeed({"shot", "scene.json", "--technique", "reference", "--size", "41x33", "--verbose",
                                        "--backend", "cpu", "-o", "a.png"});
    EXPECT_THAT(shot.err, testing::HasSubstr(", " + std::to_string(count) + " not finite"));
    pictures.push_back(folder_.read("a.png"));
    const json report = document({"compare", "scene.json", "--size", "41x33", "--backend", "cpu", "--out", "out", "--json"});
    EXPECT_EQ(report["nonFiniteVoxels"], count);
    forEachNumber(report, "", [](const std::string& path, double number) { EXPECT_TRUE(std::isfinite(number)) << path; });
    ASSERT_FALSE(report["rows"].empty());
    for (const json& row : report["rows"]) {
      // Nothing but equality leaves an error without a number.
      EXPECT_TRUE(row["psnrDb"].is_number() || (row["psnrDb"].is_null() && row["flip"] == 0.0)) << row;
      for (const char* key : {"ssim", "flip", "holeFraction"}) EXPECT_TRUE(row[key].is_number()) << key;
    }
    EXPECT_EQ(json::parse(folder_.read("out/metrics.json")), report);
  }
  EXPECT_EQ(pictures[1], pictures[0]) << "which kind of number it is not makes no difference";
  EXPECT_EQ(pictures[2], pictures[0]);
  // Half of the ball is gone: left and right of the picture differ.
  const Image<Rgba8> image = picture("a.png");
  size_t left = 0, right = 0;
  for (uint32_t y = 0; y < image.height(); ++y)
    for (uint32_t x = 0; x < image.width(); ++x) (2 * x < image.width() ? left : right) += image(x, y) >> 24 != 0;
  EXPECT_GT(std::max(left, right), 100u);
  EXPECT_LT(4 * std::min(left, right), std::max(left, right));
}

TEST_F(CommandLine, NumbersThatAreNotFiniteAreRefusedWhereverTheyAreWritten) {
  const auto function = [](const std::string& value, const std::string& color, const std::string& alpha) {
    return R"({"points": [{"value": 0, "color": [1, 1, 1], "alpha": 0}, {"value": )" + value + R"(, "color": [1, 1, )" + color + R"(], "alpha": )" + alpha + "}]}";
  };
  for (const char* number : {"1e999", "-1e999", "NaN", "Infinity", "nan"}) {
    for (const std::string& text : {function(number, "1", "1"), function("1", number, "1"), function("1", "1", number)}) {
      folder_.write("tf.json", text);
      expectRefused(quick({"shot", "block", "--tf", "tf.json", "-o", "a.png"}), kFailure, {"tf.json"});
    }
    for (const char* key : {"fovYDeg", "distance", "angleDeg", "step"}) {
      const std::string entry = std::string("\"") + key + "\": " + number;
      const std::string scene = R"({"name": "s", "volume": {"procedural": "block"}, )" +
                                (std::string(key) == "fovYDeg" ? entry : std::string(key) == "step" ? "\"march\": {" + entry + "}" : "\"views\": [{" + entry + "}]") + "}";
      folder_.write("scene.json", scene);
      expectRefused(quick({"shot", "scene.json", "-o", "a.png"}), kFailure, {"scene.json"});
    }
  }
}

}  // namespace
}  // namespace warpscope

// Sweeps read back, and told from scenes.
// Mirrors app/experiment/sweep_file.h and app/session/handed_file.h.
#include "app/session/handed_file.h"

#include <gmock/gmock.h>

#include <fstream>
#include <nlohmann/json.hpp>

#include "render/base/error.h"
#include "tests/test_folder.h"
#include "tests/wait_for.h"

namespace warpscope {
namespace {

using nlohmann::json;

SweepRow row(const char* technique, double angleDeg, double flip, double drawMs) {
  SweepRow row;
  row.configuration.technique = &findWarp(technique);
  row.configuration.serverSidePx = 512;
  row.angleDeg = angleDeg;
  row.errors.flip = flip;
  row.draw.medianMs = drawMs;
  return row;
}

json sweepOf(const std::vector<SweepRow>& rows) {
  json document{{"scene", "shells"}, {"rows", json::array()}};
  for (const SweepRow& one : rows) document["rows"].push_back(toJson(one));
  return document;
}

class SweepFileTest : public testing::Test {
 protected:
  std::string write(const char* name, const std::string& text) const {
    const std::filesystem::path path = folder_.path() / name;
    std::ofstream(path) << text;
    return path.string();
  }
  /// What the sorter says of it.
  HandedFile sorted(const std::string& path) const {
    const std::unique_ptr<FileSorter> sorter = makeFileSorter([] {});
    sorter->post(path);
    return waitFor([&] { return sorter->tryTake(); });
  }

  TestFolder folder_;
};

TEST_F(SweepFileTest, HoldsOnePointAConfigurationAndTheFront) {
  const std::string path = write("sweep.json", sweepOf({row("points", 0.0, 0.1, 4.0), row("points", 20.0, 0.3, 5.0), row("spheres", 0.0, 0.15, 20.0),
                                                       row("spheres", 20.0, 0.15, 18.0), row("multihit", 0.0, 0.5, 40.0)})
                                                   .dump());
  const HandedFile file = sorted(path);
  EXPECT_EQ(file.error, "");
  EXPECT_EQ(file.path, path);
  ASSERT_TRUE(file.sweep);
  EXPECT_EQ(file.sweep->name, "sweep.json");
  EXPECT_EQ(file.sweep->scene, "shells");
  ASSERT_EQ(file.sweep->summaries.size(), 3u);
  EXPECT_DOUBLE_EQ(file.sweep->summaries[0].flip, 0.2);
  EXPECT_DOUBLE_EQ(file.sweep->summaries[0].frameMs, 5.0);
  EXPECT_EQ(file.sweep->front, (std::vector<size_t>{0, 1}));
  EXPECT_EQ(readSweepFile(path)->summaries.size(), 3u);
}

TEST_F(SweepFileTest, AFileWithoutRowsIsAScene) {
  for (const char* text : {R"({"volume": "x.raw"})", "[1, 2]", "this is no JSON"}) {
    const HandedFile file = sorted(write("scene.json", text));
    EXPECT_FALSE(file.sweep) << text;
    EXPECT_EQ(file.error, "") << text;
  }
  EXPECT_FALSE(sorted((folder_.path() / "missing.json").string()).sweep);
  EXPECT_FALSE(readSweepFile(write("scene.json", "{}")));
  EXPECT_THROW(readSweepFile(folder_.path() / "missing.json"), InputError);
}

TEST_F(SweepFileTest, RowsThatCannotBeReadAreASentence) {
  json document = sweepOf({row("points", 0.0, 0.1, 4.0)});
  document["rows"][0]["technique"] = "sphere";
  const HandedFile file = sorted(write("sweep.json", document.dump(1)));
  EXPECT_FALSE(file.sweep);
  EXPECT_THAT(file.error, testing::AllOf(testing::HasSubstr("sweep.json:"), testing::HasSubstr("sphere")));
  EXPECT_NE(sorted(write("empty.json", R"({"rows": []})")).error, "");
}

}  // namespace
}  // namespace warpscope

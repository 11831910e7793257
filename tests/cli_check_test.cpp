// `check`: golden pictures that are made, kept, missed and changed; what is left behind; descriptions that are wrong.
// Mirrors app/commands/check.cpp and app/experiment/screenshot_check.h.
#include <sys/stat.h>

#include <fstream>

#include "app/experiment/screenshot_check.h"
#include "app/shell/output_files.h"
#include "tests/cli.h"

namespace warpscope {
namespace {

namespace fs = std::filesystem;

class Check : public CommandLine {
 protected:
  Check() { fs::create_directory(folder_.path() / "golden"); }

  fs::path golden(const std::string& name) const { return folder_.path() / "golden" / name; }
  void describe(const std::string& text) const { std::ofstream(golden("check.json")) << text; }
  /// Two techniques of a small block, from two angles; `more` are members beside them.
  void describeBlock(const std::string& more = "") const {
    describe(R"({"techniques": ["spheres", "hold"], "anglesDeg": [0, 12.5], "size": [48, 40], "volumeSize": [24, 22, 20], "cases": [{"scene": "block"}])" + more + "}");
  }
  ProgramResult check(const Arguments& more = {}) const {
    Arguments arguments{"check", "golden", "--out", "out"};
    arguments.insert(arguments.end(), more.begin(), more.end());
    return run(arguments);
  }
  /// Paints a square of `side` pixels into a golden picture.
  void spoil(const std::string& name, uint32_t side, Rgba8 color = 0xff0000ffu) const {
    Image<Rgba8> picture = readPng(golden(name));
    for (uint32_t y = 0; y < side; ++y)
      for (uint32_t x = 0; x < side; ++x) picture(x + 18, y + 14) = color;
    writeFileWhole(golden(name), encodePng(picture));
  }
  std::vector<std::string> left() const {
    std::vector<std::string> names;
    if (fs::exists(folder_.path() / "out"))
      for (const auto& entry : fs::directory_iterator(folder_.path() / "out")) names.push_back(entry.path().filename().string());
    std::ranges::sort(names);
    return names;
  }
};

TEST_F(Check, WhatWasMadeIsAsExpected) {
  describeBlock();
  const ProgramResult made = check({"--update"});
  EXPECT_EQ(made.code, kSuccess) << made.err;
  EXPECT_THAT(made.err, testing::HasSubstr("4 of them made now"));
  for (const char* name : {"block-spheres-0.png", "block-spheres-12.5.png", "block-hold-0.png", "block-hold-12.5.png"}) EXPECT_TRUE(fs::exists(golden(name))) << name;
  EXPECT_NE(contentOf(golden("block-spheres-0.png")), contentOf(golden("block-spheres-12.5.png")));

  const ProgramResult checked = check({"--junit", "results.xml"});
  EXPECT_EQ(checked.code, kSuccess) << checked.err;
  EXPECT_THAT(checked.err, testing::HasSubstr("same  block-spheres-12.5 (auto)\n"));
  EXPECT_THAT(checked.err, testing::HasSubstr("4 pictures are as expected\n"));
  EXPECT_EQ(left(), std::vector<std::string>{"check.html"});
  EXPECT_THAT(contentOf(folder_.path() / "results.xml"), testing::HasSubstr("tests=\"4\" failures=\"0\""));
}

TEST_F(Check, AChangedPictureFailsAndLeavesWhatItTakesToSeeWhy) {
  describeBlock();
  ASSERT_EQ(check({"--update"}).code, kSuccess);
  spoil("block-hold-0.png", 12);
  const std::string spoiled = contentOf(golden("block-hold-0.png"));
  const ProgramResult result = check({"--junit", "results.xml"});
  EXPECT_EQ(result.code, kFailure);
  EXPECT_THAT(result.err, testing::HasSubstr("FAIL  block-hold-0 (auto): "));
  EXPECT_THAT(result.err, testing::HasSubstr("1 of 4 pictures are not as expected; see out/check.html"));
  EXPECT_EQ(left(), (std::vector<std::string>{"block-hold-0-auto-actual.png", "block-hold-0-auto-difference.png", "block-hold-0-auto-expected.png", "check.html"}));
  EXPECT_EQ(readPng(folder_.path() / "out/block-hold-0-auto-expected.png"), readPng(golden("block-hold-0.png")));
  EXPECT_EQ(contentOf(golden("block-hold-0.png")), spoiled);  // a check changes nothing
  EXPECT_THAT(contentOf(folder_.path() / "results.xml"), testing::AllOf(testing::HasSubstr("failures=\"1\""), testing::HasSubstr("<failure message=\"")));
  EXPECT_THAT(contentOf(folder_.path() / "out/check.html"), testing::HasSubstr("data:image/png;base64,"));
}

TEST_F(Check, UpdateReplacesWhatFailsAlone) {
  describeBlock();
  ASSERT_EQ(check({"--update"}).code, kSuccess);
  const std::string before = contentOf(golden("block-hold-0.png"));
  spoil("block-hold-0.png", 12);
  spoil("block-spheres-0.png", 1, readPng(golden("block-spheres-0.png"))(18, 14) ^ 1);  // by the last bit of red: tolerable
  const std::string tolerable = contentOf(golden("block-spheres-0.png"));
  const ProgramResult result = check({"--update"});
  EXPECT_EQ(result.code, kSuccess) << result.err;
  EXPECT_THAT(result.err, testing::HasSubstr("made  block-hold-0"));
  EXPECT_EQ(contentOf(golden("block-hold-0.png")), before);
  EXPECT_EQ(contentOf(golden("block-spheres-0.png")), tolerable);
}

TEST_F(Check, AMissingPictureFails) {
  describeBlock();
  const ProgramResult result = check();
  EXPECT_EQ(result.code, kFailure);
  EXPECT_THAT(result.err, testing::HasSubstr("NONE  block-spheres-0 (auto): there is no golden picture"));
  EXPECT_FALSE(fs::exists(golden("block-spheres-0.png")));
  EXPECT_TRUE(fs::exists(folder_.path() / "out/block-spheres-0-auto-actual.png"));
}

TEST_F(Check, AGoldenPictureOfAnotherSizeOrThatIsNoneFails) {
  describeBlock();
  ASSERT_EQ(check({"--update"}).code, kSuccess);
  writeFileWhole(golden("block-hold-0.png"), encodePng(Image<Rgba8>(8, 8, 0xff000000u)));
  ProgramResult result = check();
  EXPECT_EQ(result.code, kFailure);
  EXPECT_THAT(result.err, testing::HasSubstr("the golden picture has 8x8 pixels instead of 48x40"));
  std::ofstream(golden("block-hold-0.png")) << "no picture";
  result = check();
  EXPECT_EQ(result.code, kFailure);
  EXPECT_THAT(result.err, testing::AllOf(testing::HasSubstr("FAIL  block-hold-0 (auto): the golden picture is damaged"), testing::HasSubstr("same  block-spheres-12.5"))) << "others are checked";
  EXPECT_TRUE(fs::exists(folder_.path() / "out/check.html"));
  EXPECT_TRUE(fs::exists(folder_.path() / "out/block-hold-0-auto-actual.png"));
  fs::remove(golden("block-hold-0.png"));
  ASSERT_EQ(mkfifo(golden("block-hold-0.png").c_str(), 0600), 0);
  result = check();
  EXPECT_EQ(result.code, kFailure);
  EXPECT_THAT(result.err, testing::HasSubstr("is no regular file but a pipe")) << "nobody is waited for";
  fs::remove(golden("block-hold-0.png"));
  result = check({"--update"});
  EXPECT_EQ(result.code, kSuccess) << result.err;
  EXPECT_EQ(readPng(golden("block-hold-0.png")).width(), 48u);
  EXPECT_EQ(left(), std::vector<std::string>{"check.html"}) << "what failed before is gone";
}

TEST_F(Check, ResultsDoNotTakeTheDescriptionsPlace) {
  describeBlock();
  const std::string before = contentOf(golden("check.json"));
  const ProgramResult result = check({"--junit", "golden/check.json"});
  EXPECT_EQ(result.code, kUsage);
  EXPECT_THAT(result.err, testing::HasSubstr("golden/check.json is read here, and would be lost"));
  EXPECT_EQ(contentOf(golden("check.json")), before);
}

TEST_F(Check, EachToleranceIsHeld) {
  const std::string none = R"("flip": null, "psnrDb": null, "holes": null, "pixels": null)";
  describeBlock();
  ASSERT_EQ(check({"--update"}).code, kSuccess);
  spoil("block-hold-0.png", 6, 0xff502030u);  // the colour of holes
  describeBlock(R"(, "tolerances": {)" + none + "}");
  EXPECT_EQ(check().code, kSuccess);
  const std::pair<const char*, const char*> tolerances[] = {{"\"flip\": null", "FLIP "}, {"\"psnrDb\": null", "PSNR "}, {"\"holes\": null", "nothing covers"}, {"\"pixels\": null", "of the pixels differ"}};
  for (const auto& [key, fault] : tolerances) {
    std::string held = none;
    const std::string name(key, std::string(key).find(':'));
    held.replace(held.find(key), std::string(key).size(), name + (name == "\"psnrDb\"" ? ": 60" : ": 0.001"));
    describeBlock(R"(, "tolerances": {)" + held + "}");
    const ProgramResult result = check();
    EXPECT_EQ(result.code, kFailure) << held;
    EXPECT_THAT(result.err, testing::HasSubstr(fault)) << held;
  }
}

TEST_F(Check, CasesHaveSettingsOfTheirOwn) {
  describe(R"({"techniques": ["points"], "size": [40, 30], "volumeSize": [24, 22, 20], "march": {"step": 1},
              "cases": [{"name": "one", "scene": "block"}, {"name": "large", "scene": "block", "size": [20, 20], "warp": {"pointSize": 7}, "march": {"heuristic": "exit"}}]})");
  ASSERT_EQ(check({"--update"}).code, kSuccess);
  EXPECT_EQ(readPng(golden("one-points-0.png")).width(), 40u);
  EXPECT_EQ(readPng(golden("large-points-0.png")).width(), 20u);
}

TEST_F(Check, WrongDescriptionsAreRefused) {
  const std::string start = R"({"techniques": ["hold"], "size": [8, 8], "volumeSize": [8, 8, 8], )";
  const std::pair<std::string, std::vector<std::string>> wrong[] = {
      {"", {"check.json"}},
      {"{", {"check.json:1"}},
      {R"({"cases": []})", {"check.json:1", "cases"}},
      {R"({"cases": [{"scene": "block"}]})", {"no techniques"}},
      {start + R"("cases": [{"scene": "blok"}]})", {"scene", "blok"}},
      {start + R"("cases": [{"scene": "block"}, {"scene": "block"}]})", {"pictures of the same names"}},
      {start + R"("cases": [{"scene": "block", "name": "../up"}]})", {"letters, digits"}},
      {start + "\n" + R"("cases": [{"scene": "block", "techniques": ["sphere"]}]})", {"check.json:2", "did you mean 'spheres'"}},
      {start + R"("cases": [{"scene": "block", "techniques": ["hold", "hold"]}]})", {"listed twice"}},
      {start + R"("cases": [{"scene": "block", "anglesDeg": [400]}]})", {"anglesDeg"}},
      {start + R"("cases": [{"scene": "block", "size": [0, 8]}]})", {"size"}},
      {start + R"("cases": [{"scene": "block", "tolerance": {}}]})", {"did you mean 'tolerances'"}},
      {start + R"("cases": [{"scene": "block", "tolerances": {"flip": 2}}]})", {"flip"}},
      {start + R"("cases": [{"scene": "block", "march": {"stp": 1}}]})", {"did you mean 'step'"}},
      {start + R"("cases": [{"scene": "block", "warp": {"pointSize": 99}}]})", {"pointSize"}},
      {start + R"("platforms": ["glx"], "cases": [{"scene": "block"}]})", {"platform", "glx"}},
      {start + R"("cases": [{"scene": "block", "techniques": ["segments"], "march": {"segments": 0}}]})", {"segments shows nothing"}},
  };
  for (const auto& [text, reasons] : wrong) {
    describe(text);
    const std::vector<std::string> before = folder_.listing();
    const ProgramResult result = check({"--update"});
    EXPECT_EQ(result.code, kUsage) << text << "\n" << result.err;
    for (const std::string& reason : reasons) EXPECT_THAT(result.err, testing::HasSubstr(reason)) << text;
    EXPECT_EQ(folder_.listing(), before) << text;
  }
  fs::remove(golden("check.json"));
  expectRefused({"check", "golden"}, kUsage, {"check.json"});
  expectRefused({"check", "nowhere"}, kUsage, {"nowhere"});
  expectRefused({"check"}, kUsage, {"folder"});
}

TEST_F(Check, TheProgramsOwnDescriptionHasAllItsScenes) {
  const CheckPlan plan = readCheckPlan(WARPSCOPE_GOLDEN_FOLDER);
  for (const BuiltinScene& scene : builtinScenes())
    EXPECT_TRUE(std::ranges::any_of(plan.cases, [&](const CheckCase& what) { return what.scene == scene.name && what.techniques.size() == warpRegistry().size(); })) << scene.name;
  EXPECT_EQ(plan.platforms.size(), 2u);
}

}  // namespace
}  // namespace warpscope

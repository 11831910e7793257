// Photographs of the window's parts in both themes against golden pictures: layout, text, colours, symbols. Figures of time, which differ from run to run, are
// covered first. WARPSCOPE_UPDATE_GOLDEN=1 writes them anew; look at what has changed.
// Mirrors app/ui/.
#include <cstdlib>
#include <filesystem>

#include "app/picture/picture.h"
#include "app/picture/picture_difference.h"
#include "app/shell/output_files.h"
#include "tests/scripted_window.h"

namespace warpscope::ui {
namespace {

constexpr glm::uvec2 kWindowSize(1280, 800);

struct Box {
  uint32_t left, top, right, bottom;
};
// What a picture took and how wrong it is, the plot's points, the status bar.
constexpr Box kMeasured[] = {{9, 472, 497, 559}, {507, 472, 995, 559}, {12, 598, 992, 762}, {0, 768, 1280, 800}};
// Hardly any: another version of the rasteriser may smooth an edge otherwise.
constexpr double kMostFraction = 0.002;

class WindowGolden : public SessionTest {
 protected:
  void SetUp() override {
    std::unique_ptr<DrawnWindow> drawn;
    try {
      drawn = std::make_unique<DrawnWindow>();
    } catch (const InputError& error) {
      GTEST_SKIP() << error.what();
    }
    window_.emplace(kWindowSize, session_, opener_, std::move(drawn));
    LoadJob block = builtin("block");
    block.origin = SceneOrigin{"block", {}};
    session_.load(block);
    ASSERT_TRUE(rest());
  }
  bool rest() {
    const auto isJudged = [&](size_t i) { return session_.panel(i).currentPixels() != nullptr && session_.panel(i).errorsAreCurrent && session_.panel(i).isContentFound(); };
    const bool isRest = window_->framesUntil([&] { return session_.scene() != nullptr && isJudged(0) && isJudged(1); });
    window_->frames(3);
    return isRest;
  }
  void expectGolden(const std::string& name, std::span<const Box> covered = kMeasured) {
    Image<Rgba8> picture = window_->picture();
    for (const Box& box : covered)
      for (uint32_t y = box.top; y < box.bottom; ++y) std::fill(picture.row(y) + box.left, picture.row(y) + box.right, Rgba8{0xff808080u});
    const std::filesystem::path golden = std::filesystem::path(WARPSCOPE_GOLDEN_FOLDER) / "window" / (name + ".png");
    if (std::getenv("WARPSCOPE_UPDATE_GOLDEN") != nullptr) return writeFileWhole(golden, encodePng(picture));
    ASSERT_TRUE(std::filesystem::exists(golden)) << golden;
    const Image<Rgba8> expected = readPng(golden);
    const PictureDifference difference = comparePictures(picture, expected);
    if (difference.isTolerable(kMostFraction)) return;
    const std::filesystem::path kept = std::filesystem::path(WARPSCOPE_TEST_ARTIFACTS) / name;
    std::filesystem::create_directories(kept.parent_path());
    writeFileWhole(kept.string() + ".png", encodePng(picture));
    writeFileWhole(kept.string() + "-difference.png", encodePng(amplifiedDifference(picture, expected)));
    ADD_FAILURE() << name << ": " << difference.fraction << " of the pixels differ, by up to " << difference.largest << "; see " << kept << ".png and -difference.png";
  }

  const SceneOpener opener_ = [this](const SceneOrigin& origin) { return builtin(origin.spec); };
  std::optional<ScriptedWindow> window_;
};

TEST_F(WindowGolden, PanelsAndKnobsInBothThemes) {
  window_->moveTo({640.0f, 784.0f});
  ASSERT_TRUE(rest());
  expectGolden("dark");
  window_->remembered.isLight = true;
  window_->frames(2);
  expectGolden("light");
}

TEST_F(WindowGolden, LoupeAndRay) {
  window_->key({.name = "I"});
  window_->click({250.0f, 280.0f});
  ASSERT_TRUE(rest());
  ASSERT_TRUE(window_->framesUntil([&] { return session_.ray().isCurrent(); }));
  window_->frames(3);
  constexpr Box kCovered[] = {{9, 472, 497, 559}, {507, 472, 995, 559}, {12, 598, 445, 762}, {0, 768, 1280, 800}};
  expectGolden("inspecting", kCovered);
}

TEST_F(WindowGolden, KeysAndMenusInBothThemes) {
  window_->key({.name = "F1"});
  window_->frames(2);
  // Beside the list.
  constexpr Box kCovered[] = {{9, 472, 331, 559}, {949, 472, 995, 559}, {12, 598, 331, 762}, {949, 598, 992, 762}, {0, 768, 1280, 800}};
  expectGolden("keys", kCovered);
  window_->key({.name = "F1"});
  window_->remembered.isLight = true;
  window_->click({63.0f, 12.0f});
  window_->click({110.0f, 12.0f});
  window_->frames(2);
  expectGolden("menu-light");
}

TEST_F(WindowGolden, ContentsOfPanels) {
  session_.setContent(0, PictureContent::flip);
  session_.setContent(1, PictureContent::depth);
  window_->moveTo({640.0f, 784.0f});
  ASSERT_TRUE(rest());
  expectGolden("contents");
}

}  // namespace
}  // namespace warpscope::ui

// The window in the hands of a script: every key, every entry of its menus, what the pointer does in panels, and a monkey.
// Mirrors app/ui/main_view.h, panel_grid.h, warp_panel.h, transfer_editor.h.
#include "tests/window_script.h"

#include <random>

#include "app/picture/picture.h"

namespace warpscope::ui {
namespace {

TEST_F(WindowScriptTest, KeysDoWhatTheyAreSaidToDo) {
  ASSERT_TRUE(openAndRest("block"));
  window_.moveTo(kLeftPicture);
  press(Action::freeze);
  EXPECT_TRUE(session_.knobs().isFrozen);
  press(Action::freeze);
  EXPECT_FALSE(session_.knobs().isFrozen);
  press(Action::showContent);
  EXPECT_EQ(session_.panel(0).content, PictureContent::flip);
  EXPECT_EQ(session_.panel(1).content, PictureContent::picture) << "the pointer is not there";
  press(Action::showContent);
  EXPECT_EQ(session_.panel(0).content, PictureContent::picture);
  window_.key({.name = "4"});
  EXPECT_EQ(session_.panel(0).technique, &warpRegistry()[3]);
  press(Action::chooseAutomatic);
  EXPECT_TRUE(session_.panel(0).isAutomatic);
  press(Action::ownCamera);
  EXPECT_TRUE(session_.hasOwnCamera(0));
  press(Action::ownCamera);
  EXPECT_FALSE(session_.hasOwnCamera(0));
  press(Action::showPlan);
  EXPECT_TRUE(session_.showsPlan());
  press(Action::showPlan);
  press(Action::addPanel);
  EXPECT_EQ(session_.panelCount(), 3u);
  window_.moveTo(kLeftPicture);
  press(Action::closePanel);
  EXPECT_EQ(session_.panelCount(), 2u);
  press(Action::quit);
  press(Action::fullScreen);
  EXPECT_EQ(window_.takeActions(), (std::vector{Action::quit, Action::fullScreen}));
  press(Action::help);
  EXPECT_TRUE(window_.view().showsKeys());
  press(Action::goBack);
  EXPECT_FALSE(window_.view().showsKeys());
  EXPECT_TRUE(window_.takeActions().empty()) << "there was something to go back from";
  press(Action::goBack);
  EXPECT_EQ(window_.takeActions(), std::vector{Action::goBack});
}

TEST_F(WindowScriptTest, PanelsAreArrangedByTheirTitles) {
  ASSERT_TRUE(openAndRest("block"));
  const uint64_t left = session_.panel(0).id;
  window_.drag(kLeftTitle, kRightPicture);
  EXPECT_EQ(session_.panel(1).id, left);
  window_.doubleClick(kRightTitle);
  window_.frame();
  EXPECT_TRUE(session_.panel(0).isHidden);
  EXPECT_FALSE(session_.panel(1).isHidden);
  const glm::uvec2 alone = session_.pictureSize();
  press(Action::goBack);
  window_.frame();
  EXPECT_FALSE(session_.panel(0).isHidden);
  EXPECT_LT(session_.pictureSize().x, alone.x);
  EXPECT_EQ(session_.panelCount(), 2u);
  window_.click({481.0f, 47.0f});  // the cross of the left one
  EXPECT_EQ(session_.panelCount(), 1u);
  EXPECT_EQ(session_.panel(0).id, left);
}

TEST_F(WindowScriptTest, PanelsThatAreGoneAreNotAskedAnyMore) {
  ASSERT_TRUE(openAndRest("block"));
  // Two keys before the next picture is drawn: the second finds no panel under the pointer.
  window_.moveTo(kRightPicture);
  window_.view().press({.name = "Delete"}, session_);
  window_.view().press({.name = "4"}, session_);
  window_.view().press({.name = "C"}, session_);
  EXPECT_EQ(session_.panelCount(), 1u);
  window_.hold(0, true);  // a click where a panel was
  window_.hold(0, false);
  // Closed while it is dragged: dropping it does nothing.
  press(Action::addPanel);
  press(Action::addPanel);
  ASSERT_EQ(session_.panelCount(), 3u);
  window_.frames(2);
  window_.moveTo({720.0f, 47.0f});  // the third one's title
  window_.hold(0, true);
  window_.moveTo({740.0f, 60.0f});
  session_.removePanel(2);
  window_.moveTo(kLeftPicture);
  window_.hold(0, false);
  EXPECT_EQ(session_.panelCount(), 2u);
  // "Close" by the menu, of the panel that was used last, which is the last of all.
  window_.click(kRightPicture);
  window_.view().perform(Action::closePanel, session_);
  window_.frames(2);
  EXPECT_EQ(session_.panelCount(), 1u);
  EXPECT_TRUE(rest());
}

TEST_F(WindowScriptTest, ThePointerTurnsMovesAndZooms) {
  ASSERT_TRUE(openAndRest("block"));
  const View home = session_.view();
  window_.drag(kLeftPicture, kLeftPicture + glm::vec2(60.0f, 20.0f));
  const View orbited = session_.view();
  EXPECT_NE(orbited.angleDeg, home.angleDeg);
  window_.drag(kRightPicture, kRightPicture + glm::vec2(40.0f, 0.0f), 1);
  EXPECT_NE(session_.view().pan, orbited.pan);
  window_.wheel(1.0f);
  EXPECT_LT(session_.view().distance, home.distance);
  window_.doubleClick(kRightPicture);
  EXPECT_EQ(session_.view(), home);
  // One with a camera of its own turns alone.
  session_.setOwnCamera(1, true);
  window_.drag(kRightPicture, kRightPicture + glm::vec2(60.0f, 20.0f));
  EXPECT_EQ(session_.view(0), home);
  EXPECT_NE(session_.view(1), home);
}

TEST_F(WindowScriptTest, AWipesBarIsDraggedWithoutTurningTheCamera) {
  ASSERT_TRUE(openAndRest("block"));
  window_.moveTo(kLeftPicture);
  press(Action::wipe);
  const View home = session_.view();
  window_.drag({253.0f, 200.0f}, {330.0f, 200.0f});
  EXPECT_EQ(session_.view(), home);
  window_.drag({253.0f, 200.0f}, {300.0f, 200.0f});
  EXPECT_NE(session_.view(), home) << "the bar is elsewhere now";
  press(Action::goBack);
}

TEST_F(WindowScriptTest, PixelsAreInspectedAndCopied) {
  ASSERT_TRUE(openAndRest("block"));
  window_.moveTo(kLeftPicture);
  press(Action::copyPixel);
  EXPECT_THAT(window_.clipboard(), testing::HasSubstr("colour\t"));
  window_.click(kLeftPicture);
  EXPECT_FALSE(session_.lookedAt()) << "without the loupe a click turns nothing and looks at nothing";
  press(Action::inspect);
  window_.click(kLeftPicture);
  ASSERT_TRUE(session_.lookedAt());
  EXPECT_EQ(session_.lookedAt()->panel, session_.panel(0).id);
  ASSERT_TRUE(waitUntil([&] { return session_.ray().isCurrent(); }));
  window_.frames(3);
  press(Action::goBack);
  window_.click(kRightPicture);
  EXPECT_FALSE(session_.lookedAt()) << "the loupe is gone, and its ray with it";
}

TEST_F(WindowScriptTest, HeldKeysShowTheGroundTruthAndBlink) {
  ASSERT_TRUE(openAndRest("block"));
  window_.moveTo(kLeftPicture);
  window_.held.reference = true;
  window_.frames(3);
  window_.held = {.reference = false, .blink = true};
  window_.frames(3);
  EXPECT_TRUE(window_.view().isAnimating());
  window_.held = {};
  window_.frame();
  EXPECT_FALSE(window_.view().isAnimating());
  EXPECT_TRUE(rest());
}

TEST_F(WindowScriptTest, TheTransferFunctionIsEditedAndTakenBack) {
  ASSERT_TRUE(openAndRest("block"));
  const TransferFunction before = session_.scene()->transferFunction;
  window_.click(kChart);  // adds a corner where there is none
  const TransferFunction added = session_.scene()->transferFunction;
  EXPECT_NE(added, before);
  window_.drag(kChart, kChart + glm::vec2(10.0f, -30.0f));
  const TransferFunction dragged = session_.scene()->transferFunction;
  EXPECT_NE(dragged, added);
  window_.drag({1050.0f, 175.0f}, {1080.0f, 175.0f}, 1);
  const TransferFunction windowed = session_.scene()->transferFunction;
  EXPECT_NE(windowed, dragged);
  press(Action::undo);
  EXPECT_EQ(session_.scene()->transferFunction, dragged) << "a drag is one step";
  press(Action::undo);
  EXPECT_EQ(session_.scene()->transferFunction, added);
  press(Action::undo);
  EXPECT_EQ(session_.scene()->transferFunction, before);
  press(Action::undo);
  EXPECT_EQ(session_.scene()->transferFunction, before) << "there was nothing before";
  press(Action::redo);
  EXPECT_EQ(session_.scene()->transferFunction, added);
  // A drag that begins on a corner moves all, a click there removes it.
  window_.drag(kChart, kChart + glm::vec2(20.0f, 0.0f), 1);
  EXPECT_NE(session_.scene()->transferFunction, added);
  EXPECT_FALSE(window_.view().note().starts_with("the corner")) << window_.view().note();
  press(Action::undo);
  ASSERT_EQ(session_.scene()->transferFunction, added);
  window_.click({1140.0f, 265.0f});  // the colours
  window_.click(kChart, 1);
  EXPECT_NE(session_.scene()->transferFunction, added);
  EXPECT_TRUE(window_.view().note().starts_with("the corner is gone")) << window_.view().note();
  EXPECT_TRUE(rest());
}

/// A corner that is led along the floor stays there: the faintest opacity would fill what is empty with fog.
TEST_F(WindowScriptTest, ACornerNearTheFloorIsOnIt) {
  ASSERT_TRUE(openAndRest("block"));
  const auto faint = [&] {
    return std::ranges::count_if(session_.scene()->transferFunction.points, [](const TransferPoint& point) { return point.alpha > 0.0f && point.alpha < 0.01f; });
  };
  constexpr float kFloor = 256.0f;
  window_.click(kChart);
  ASSERT_EQ(faint(), 0);
  window_.drag(kChart, {kChart.x, kFloor - 8.0f});
  EXPECT_EQ(faint(), 1);
  window_.drag({kChart.x, kFloor - 8.0f}, {kChart.x + 3.0f, kFloor - 2.0f});
  EXPECT_EQ(faint(), 0);
}

TEST_F(WindowScriptTest, AnErrorLiesOverThePicturesWhichStayAsLarge) {
  ASSERT_TRUE(openAndRest("block"));
  const glm::uvec2 size = session_.pictureSize();
  session_.load({"nothing", [](const std::function<void()>&, const std::stop_token&) -> ConnectedScene { throw InputError("there is no such scene"); }});
  ASSERT_TRUE(waitUntil([&] { return !session_.error().empty(); }));
  window_.frames(3);
  EXPECT_EQ(session_.pictureSize(), size);
  window_.click({952.0f, 745.0f});  // its button
  EXPECT_EQ(session_.error(), "");
}

TEST_F(WindowScriptTest, AboutSaysWhatItIsUntilEsc) {
  ASSERT_TRUE(openAndRest("block"));
  window_.view().perform(Action::about, session_);
  window_.frames(2);
  EXPECT_TRUE(window_.view().showsAbout());
  press(Action::goBack);
  EXPECT_FALSE(window_.view().showsAbout());
}

TEST_F(WindowScriptTest, KnobsAndPanelsAreTakenBackToo) {
  ASSERT_TRUE(openAndRest("block"));
  const LiveSettings before = session_.knobs();
  LiveSettings knobs = before;
  knobs.march.sample.heuristic = Heuristic::entrance;
  session_.setKnobs(knobs);
  window_.frames(2);
  window_.view().perform(Action::closePanel, session_);
  window_.frames(2);
  ASSERT_EQ(session_.panelCount(), 1u);
  press(Action::undo);
  EXPECT_EQ(session_.panelCount(), 2u);
  EXPECT_EQ(session_.knobs().march.sample.heuristic, Heuristic::entrance);
  press(Action::undo);
  window_.frames(2);
  EXPECT_TRUE(session_.knobs() == before);
  EXPECT_TRUE(rest());
  press(Action::redo);
  EXPECT_EQ(session_.knobs().march.sample.heuristic, Heuristic::entrance);
}

TEST_F(WindowScriptTest, AClickOnACornerChangesNothingAndUndoStaysWithItsScene) {
  ASSERT_TRUE(openAndRest("block"));
  window_.click(kChart);
  const TransferFunction added = session_.scene()->transferFunction;
  window_.click(kChart);  // the corner that is there now
  EXPECT_EQ(session_.scene()->transferFunction, added);
  window_.click(kChart + glm::vec2(9.0f, 0.0f));  // nearly
  EXPECT_EQ(session_.scene()->transferFunction, added);
  press(Action::hideSideBar);
  ASSERT_TRUE(openAndRest("shells"));
  const TransferFunction shells = session_.scene()->transferFunction;
  press(Action::undo);
  EXPECT_EQ(session_.scene()->transferFunction, shells) << "the step was another scene's";
  press(Action::hideSideBar);
}

TEST_F(WindowScriptTest, AWatchedFileIsLoadedWhenItIsWritten) {
  const TestFolder folder;
  const std::string file = folder.write("function.json", R"({"points": [{"value": 0, "color": [1, 1, 1], "alpha": 0.1}]})");
  window_.view().watchTransferFile(file, [] {});
  ASSERT_TRUE(openAndRest("block"));
  const TransferFunction before = session_.scene()->transferFunction;
  std::filesystem::last_write_time(file, std::filesystem::last_write_time(file) + std::chrono::seconds(2));
  ASSERT_TRUE(waitUntil([&] { return session_.scene()->transferFunction != before; }));
  EXPECT_FLOAT_EQ(session_.scene()->transferFunction.points.front().alpha, 0.1f);
  folder.write("function.json", "nonsense");
  std::filesystem::last_write_time(file, std::filesystem::last_write_time(file) + std::chrono::seconds(4));
  ASSERT_TRUE(waitUntil([&] { return window_.view().transferEditor().error().find("function.json:1: ") != std::string::npos; })) << "what is wrong is said";
  EXPECT_FLOAT_EQ(session_.scene()->transferFunction.points.front().alpha, 0.1f);
}

TEST_F(WindowScriptTest, FoldsThemeAndFilesAreRemembered) {
  const TestFolder folder;
  ASSERT_TRUE(openAndRest("block"));
  const glm::vec2 heading(1040.0f, 149.0f);  // TRANSFER FUNCTION
  window_.click(heading);
  EXPECT_TRUE(window_.remembered.folded.contains("TRANSFER FUNCTION"));
  window_.click(heading);
  EXPECT_TRUE(window_.remembered.folded.empty());
  const ImVec4 before = ImGui::GetStyleColorVec4(ImGuiCol_Text);
  press(Action::lightTheme);
  window_.frame();
  EXPECT_TRUE(window_.remembered.isLight);
  EXPECT_NE(ImGui::GetStyleColorVec4(ImGuiCol_Text).x, before.x);
  press(Action::lightTheme);
  window_.frame();
  EXPECT_EQ(ImGui::GetStyleColorVec4(ImGuiCol_Text).x, before.x);
  EXPECT_TRUE(window_.remembered.recentFiles.empty()) << "a built-in scene is no file";
  const std::string file = folder.write("mine.json", textOf(sessionFileOf(session_)));
  window_.view().open(file);
  ASSERT_TRUE(waitUntil([&] { return !window_.remembered.recentFiles.empty(); }));
  EXPECT_EQ(window_.remembered.recentFiles.front(), file);
}

TEST_F(WindowScriptTest, PanelsAndPlotAreKeptAsFiles) {
  press(Action::savePanels);  // there is none yet: a note, no file
  ASSERT_TRUE(openAndRest("block"));
  ASSERT_TRUE(waitUntil([&] { return !session_.liveFront().points().empty(); }));
  press(Action::savePanels);
  const auto path = [&](const char* name) { return window_.folder().path() / name; };
  ASSERT_TRUE(waitUntil([&] { return std::filesystem::exists(path("warpscope-1-2-spheres.png")); }));
  EXPECT_TRUE(std::filesystem::exists(path("warpscope-1-1-hold.png")));
  press(Action::savePlot);
  ASSERT_TRUE(waitUntil([&] { return std::filesystem::exists(path("warpscope-2.csv")); }));
  const std::string csv = window_.folder().read("warpscope-2.csv"), svg = window_.folder().read("warpscope-2.svg");
  EXPECT_THAT(csv, testing::StartsWith("source,technique,configuration,frameMs,flip,anglesDeg,width,height,isOnFront\nseen,"));
  EXPECT_THAT(svg, testing::StartsWith("<svg"));
  EXPECT_GE(readPng(path("warpscope-2.png")).width(), 1200u);
  window_.view().savePicture(Image<Rgba8>(3, 2, 0xff00ff00u));
  ASSERT_TRUE(waitUntil([&] { return std::filesystem::exists(path("warpscope-3.png")); }));
}

TEST_F(WindowScriptTest, EveryEntryOfEveryMenuCanBeChosen) {
  ASSERT_TRUE(openAndRest("block"));
  std::vector<Action> asked;
  for (const float x : {22.0f, 63.0f, 108.0f, 157.0f, 206.0f})
    for (float y = 34.0f; y < 330.0f; y += 10.0f) {
      window_.click({x, 12.0f});
      window_.click({x + 20.0f, y});
      for (const Action action : window_.takeActions()) asked.push_back(action);
      window_.click({900.0f, 790.0f});  // closes what is still open
      window_.frame();
    }
  EXPECT_THAT(asked, testing::Contains(Action::quit));
  EXPECT_THAT(asked, testing::Contains(Action::fullScreen));
  EXPECT_GE(session_.panelCount(), 1u);
  window_.moveTo(kLeftPicture);
  for (int i = 0; i < 4; ++i) press(Action::goBack);
  session_.setKnobs([&] {
    LiveSettings knobs = session_.knobs();
    knobs.isFrozen = false;
    return knobs;
  }());
  EXPECT_TRUE(rest());
}

/// Events of all kinds, in no order; where one of 20,000 breaks something, the seed and its number lead there.
TEST_F(WindowScriptTest, AMonkeyBreaksNothing) {
  const TestFolder folder;
  const std::filesystem::path before = std::filesystem::current_path();
  std::filesystem::current_path(folder.path());  // what it saves is saved here
  ASSERT_TRUE(openAndRest("block"));
  std::mt19937 random(20261125);
  const auto below = [&](int count) { return std::uniform_int_distribution<int>(0, count - 1)(random); };
  std::vector<KeyChord> keys;
  for (const ActionDescriptor& action : windowActions())
    for (const KeyChord& chord : chordsOf(action)) keys.push_back(chord);
  for (char digit = '0'; digit <= '9'; ++digit) keys.push_back({.name = std::string(1, digit)});
  std::array<bool, 3> isDown{};
  glm::uvec2 size = kSize;
  for (int i = 0; i < 20000; ++i) {
    const glm::vec2 somewhere(static_cast<float>(below(static_cast<int>(size.x))), static_cast<float>(below(static_cast<int>(size.y))));
    switch (below(12)) {
      case 0:
      case 1: window_.moveTo(somewhere); break;
      case 2: window_.moveTo(glm::vec2(ImGui::GetIO().MousePos.x, ImGui::GetIO().MousePos.y) + glm::vec2(below(21) - 10, below(21) - 10)); break;
      case 3:
      case 4:
      case 5: {
        const size_t button = below(4) == 0 ? 1 : 0;
        isDown[button] = !isDown[button];
        window_.hold(static_cast<int>(button), isDown[button]);
        break;
      }
      case 6: window_.wheel(static_cast<float>(below(5) - 2)); break;
      case 7: window_.key(keys[static_cast<size_t>(below(static_cast<int>(keys.size())))]); break;
      case 8: window_.type(std::string(1, static_cast<char>(' ' + below(95)))); break;
      case 9: window_.held = {.reference = below(3) == 0, .blink = below(3) == 0}; break;
      case 10: window_.doubleClick(somewhere); break;
      case 11:
        if (below(40) != 0) break;
        size = {640 + below(1300), 420 + below(700)};
        window_.resize(size);
        break;
    }
    window_.takeActions();
    if (window_.view().showsDialog()) press(Action::goBack);  // it would save into any folder
    ASSERT_GE(session_.panelCount(), 1u) << i;
    ASSERT_LE(session_.panelCount(), kMaxPanels) << i;
    ASSERT_TRUE(session_.scene() == nullptr || !session_.scene()->transferFunction.points.empty()) << i;
  }
  for (int button = 0; button < 3; ++button) window_.hold(button, false);
  std::filesystem::current_path(before);
}

}  // namespace
}  // namespace warpscope::ui

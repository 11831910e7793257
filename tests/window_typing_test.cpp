// The window in the hands of a script that types: dialogs, fields, and keys that are not theirs.
// Mirrors app/ui/file_dialog.h, type_ahead.h and what of app/ui/main_view.h is about keys.
#include <fstream>

#include "tests/window_script.h"

namespace warpscope::ui {
namespace {

constexpr glm::vec2 kFirstFound(1180.0f, 152.0f);  // where a search is under way, the first knob's field
constexpr glm::vec2 kFirstEntry(420.0f, 250.0f);       // of the dialog's list

class WindowTypingTest : public WindowScriptTest {
 protected:
  /// Saves by the dialog, under that name.
  void save(const std::string& name) {
    press(Action::saveSession);
    window_.type(name);
    confirm();
  }
  /// Enter, once the field has the keyboard.
  void confirm() {
    window_.frames(4);
    tap(ImGuiKey_Enter);
  }
};

TEST_F(WindowTypingTest, KeysOfNothingAndOfTextDoNothing) {
  window_.moveTo(kLeftPicture);
  for (const ActionDescriptor& action : windowActions())
    for (const KeyChord& chord : chordsOf(action)) window_.key(chord);  // there is no scene yet
  for (const std::string name : {"", "Ä", "F9", "J", "Shift"}) window_.key({.name = name});
  ASSERT_TRUE(openAndRest("block"));
  while (session_.panelCount() > 2) session_.removePanel(2);
  press(Action::goBack);
  press(Action::goBack);
  press(Action::hideSideBar);
  window_.moveTo({1140.0f, 500.0f});
  window_.wheel(100.0f);            // up again: the stages of a frame scroll into sight
  window_.click({1100.0f, 93.0f});  // the field for files
  ASSERT_TRUE(ImGui::GetIO().WantTextInput);
  const bool wasFrozen = session_.knobs().isFrozen;
  press(Action::freeze);
  EXPECT_EQ(session_.knobs().isFrozen, wasFrozen) << "it is typed";
}

TEST_F(WindowTypingTest, WhatIsSavedGoesWhereOneSavedLastAndNotAmongTheData) {
  const TestFolder data, results;
  ASSERT_TRUE(openAndRest("block"));
  window_.moveTo(kLeftPicture);
  save(results.file("a.json"));
  ASSERT_FALSE(window_.view().showsDialog());
  data.write("mine.json", results.read("a.json"));
  press(Action::open);
  window_.type(data.file("mine.json"));
  confirm();
  ASSERT_TRUE(rest());
  save("b.json");
  EXPECT_TRUE(std::filesystem::exists(results.file("b.json")));
  EXPECT_FALSE(std::filesystem::exists(data.file("b.json")));
  press(Action::open);
  window_.type("mine.json");
  confirm();
  EXPECT_FALSE(window_.view().showsDialog()) << "it is opened from where one was opened last";
}

TEST_F(WindowTypingTest, WhatIsOnShowIsNotSavedOver) {
  const TestFolder folder;
  folder.write("scene.json", R"({"name": "mine", "volume": {"procedural": "block", "size": [16, 16, 16]}})");
  const std::string before = folder.read("scene.json");
  ASSERT_TRUE(openAndRest("block"));
  window_.moveTo(kLeftPicture);
  window_.view().open(folder.file("scene.json"));
  ASSERT_TRUE(waitUntil([&] { return session_.scene()->name == "mine"; }));
  ASSERT_TRUE(rest());
  save(folder.file("scene.json"));
  confirm();  // it may have asked whether to replace it
  EXPECT_TRUE(window_.view().showsDialog()) << "the dialog says why, and goes on";
  EXPECT_EQ(folder.read("scene.json"), before);
  press(Action::goBack);
}

TEST_F(WindowTypingTest, ASessionIsSavedAndOpenedByTheDialog) {
  const TestFolder folder;
  ASSERT_TRUE(openAndRest("block"));
  window_.moveTo(kLeftPicture);
  window_.key({.name = "4"});
  ASSERT_TRUE(rest());
  press(Action::saveSession);
  ASSERT_TRUE(window_.view().showsDialog());
  // What is proposed is chosen, and the field has the keyboard: what is typed replaces it.
  window_.type(folder.file("mine.json"));
  confirm();
  ASSERT_FALSE(window_.view().showsDialog());
  ASSERT_TRUE(std::filesystem::exists(folder.file("mine.json")));
  // Once more: a file that is there is replaced only when it was asked for twice.
  save(folder.file("mine.json"));
  EXPECT_TRUE(window_.view().showsDialog()) << "asks first";
  confirm();
  EXPECT_FALSE(window_.view().showsDialog());
  window_.moveTo(kLeftPicture);
  window_.key({.name = "5"});
  window_.view().open(folder.file("mine.json"));  // as if it were dropped
  ASSERT_TRUE(waitUntil([&] { return session_.panel(0).technique == &warpRegistry()[3]; }));
  ASSERT_TRUE(rest());
  LiveSettings knobs = session_.knobs();
  knobs.serverSidePx = LiveSettings{}.serverSidePx;  // tests' is smaller, which no option says
  session_.setKnobs(knobs);
  press(Action::copyCommand);
  EXPECT_THAT(window_.clipboard(), testing::StartsWith("warpscope view block --panels points,spheres"));
}

TEST_F(WindowTypingTest, ADialogKeepsTheNameThatCannotBeWritten) {
  const TestFolder folder;
  ASSERT_TRUE(openAndRest("block"));
  save(folder.file("nowhere/mine.json"));
  EXPECT_TRUE(window_.view().showsDialog()) << "it says why";
  std::filesystem::create_directory(folder.file("nowhere"));
  confirm();
  EXPECT_FALSE(window_.view().showsDialog());
  EXPECT_TRUE(std::filesystem::exists(folder.file("nowhere/mine.json")));
}

TEST_F(WindowTypingTest, ADialogStaysWhereThereIsNoSuchFile) {
  const TestFolder folder;
  folder.write("there.json", R"({"name": "mine", "volume": {"procedural": "block", "size": [16, 16, 16]}})");
  ASSERT_TRUE(openAndRest("block"));
  window_.moveTo(kLeftPicture);
  const size_t panels = session_.panelCount();
  press(Action::open);
  window_.type(folder.file("nowhere/it.json"));
  confirm();
  EXPECT_TRUE(window_.view().showsDialog());
  window_.frames(3);  // the field has the keyboard again
  window_.type(folder.file("there.json"));  // no letter of it is a key's
  EXPECT_EQ(session_.panelCount(), panels);
  confirm();
  EXPECT_FALSE(window_.view().showsDialog());
  ASSERT_TRUE(waitUntil([&] { return session_.scene()->name == "mine"; }));
  ASSERT_TRUE(rest());
  save(folder.file("nowhere/session.json"));
  EXPECT_TRUE(window_.view().showsDialog());
  press(Action::goBack);
  EXPECT_EQ(session_.error(), "");
}

TEST_F(WindowTypingTest, ASessionsNameEndsAsTheDialogOffersThem) {
  const TestFolder folder;
  ASSERT_TRUE(openAndRest("block"));
  window_.moveTo(kLeftPicture);
  save(folder.file("my.session"));
  EXPECT_FALSE(window_.view().showsDialog());
  EXPECT_TRUE(std::filesystem::exists(folder.file("my.session.json")));
  EXPECT_FALSE(std::filesystem::exists(folder.file("my.session")));
}

TEST_F(WindowTypingTest, ANameWithoutAnEndingGetsOneAndFilesAreKnownByTheirContents) {
  const TestFolder folder;
  ASSERT_TRUE(openAndRest("block"));
  save(folder.file("my block"));
  ASSERT_TRUE(std::filesystem::exists(folder.file("my block.json")));
  EXPECT_EQ(window_.remembered.recentFiles.front(), folder.file("my block.json"));
  std::filesystem::rename(folder.file("my block.json"), folder.file("bare"));
  const uint64_t scenes = session_.sceneCount();
  window_.view().open(folder.file("bare"));
  ASSERT_TRUE(waitUntil([&] { return session_.sceneCount() > scenes; }));
  EXPECT_EQ(session_.error(), "");
}

TEST_F(WindowTypingTest, FilesDroppedTogetherAreOpenedInTheOrderThatMakesSense) {
  const TestFolder folder;
  ASSERT_TRUE(openAndRest("block"));
  save(folder.file("mine.json"));
  ASSERT_TRUE(openAndRest("shells"));
  const TransferFunction function{{{0.0, glm::vec3(1.0f, 0.0f, 0.0f), 0.25f}, {90.0, glm::vec3(0.0f, 0.0f, 1.0f), 0.5f}}};
  std::ofstream(folder.file("curve.json")) << R"({"points": [{"value": 0, "color": [1, 0, 0], "alpha": 0.25}, {"value": 90, "color": [0, 0, 1], "alpha": 0.5}]})";
  std::ofstream(folder.file("broken.json")) << R"({"rows": 5})";
  const uint64_t scenes = session_.sceneCount();
  window_.view().open(std::vector{folder.file("curve.json"), folder.file("broken.json"), std::string("vessels"), folder.file("mine.json")});
  ASSERT_TRUE(waitUntil([&] { return session_.sceneCount() > scenes && session_.scene()->transferFunction == function; }));
  EXPECT_EQ(session_.scene()->name, "block") << "the last scene, then what is about one";
  EXPECT_EQ(session_.sceneCount(), scenes + 1);
}

TEST_F(WindowTypingTest, WhatIsTypedIntoACornersFieldHoldsWhenTheFieldIsLeft) {
  ASSERT_TRUE(openAndRest("block"));
  window_.click(kChart);
  const TransferFunction before = session_.scene()->transferFunction;
  window_.doubleClick({1140.0f, 310.0f});  // its value
  window_.frames(2);
  tap(ImGuiKey_Backspace);
  window_.type("200");
  window_.click(kLeftPicture);
  const TransferFunction typed = session_.scene()->transferFunction;
  EXPECT_NE(typed, before);
  EXPECT_TRUE(std::ranges::any_of(typed.points, [](const TransferPoint& point) { return std::abs(point.value - 200.0) < 1e-3; }));
  press(Action::undo);
  EXPECT_EQ(session_.scene()->transferFunction, before);
}

TEST_F(WindowTypingTest, WhatIsTypedIsOfTheCornerThatItWasTypedFor) {
  ASSERT_TRUE(openAndRest("block"));
  window_.click(kChart);
  const TransferCurves before = curvesOf(session_.scene()->transferFunction);
  window_.doubleClick({1140.0f, 310.0f});  // its value
  window_.frames(2);
  tap(ImGuiKey_Backspace);
  window_.type("200");
  window_.click(kChart + glm::vec2(-60.0f, -30.0f));  // another corner, at once
  const TransferCurves after = curvesOf(session_.scene()->transferFunction);
  EXPECT_EQ(after.opacities.size(), before.opacities.size() + 1);
  size_t typed = 0;
  for (const OpacityCorner& corner : after.opacities) typed += std::abs(corner.value - 200.0) < 1e-3;
  EXPECT_EQ(typed, 1u);
  for (size_t i = 0, moved = 0; i < before.opacities.size(); ++i) {
    const bool isThere = std::ranges::any_of(after.opacities, [&](const OpacityCorner& corner) { return corner.value == before.opacities[i].value; });
    moved += !isThere;
    EXPECT_LE(moved, 1u) << "the one that was chosen";
  }
}

TEST_F(WindowTypingTest, EscLeavesACornerAsItIs) {
  ASSERT_TRUE(openAndRest("block"));
  window_.click(kChart);
  const TransferFunction before = session_.scene()->transferFunction;
  window_.doubleClick({1140.0f, 310.0f});
  window_.frames(2);
  window_.type("77");
  tap(ImGuiKey_Escape);
  window_.frames(2);
  EXPECT_EQ(session_.scene()->transferFunction, before) << "to the last digit, which the field does not show";
}

TEST_F(WindowTypingTest, AListThatIsRefusedIsForgottenWithAnother) {
  ASSERT_TRUE(openAndRest("block"));
  const MarchText& text = *findMarchText("clipBox");
  const auto withBox = [&](const char* box) {
    LiveSettings knobs = session_.knobs();
    text.set(knobs.march, box, "box");
    session_.setKnobs(knobs);
  };
  press(Action::searchKnob);
  window_.frames(4);
  window_.type("cut to");
  window_.frames(2);
  window_.doubleClick(kFirstFound);
  window_.frames(2);
  tap(ImGuiKey_Backspace);
  window_.type("foo");
  window_.click(kLeftPicture);  // refused: it says why, and the field keeps what was typed
  const std::string before = text.get(session_.knobs().march);
  withBox("0,0,0,1,1,0.5");  // as undo, or another scene, may
  window_.frames(2);
  // What the field shows now is the setting: a digit behind its end is one more digit of that.
  window_.click(kFirstFound);
  tap(ImGuiKey_End);
  window_.type("5");
  window_.click(kLeftPicture);
  EXPECT_NE(text.get(session_.knobs().march), before);
  EXPECT_EQ(text.get(session_.knobs().march), "0,0,0,1,1,0.55");
}

TEST_F(WindowTypingTest, KnobsOfPanelsAndListsAreFoundAsOthersAre) {
  ASSERT_TRUE(openAndRest("block"));
  for (const char* const words : {"shortcuts", "keep", "cut by", "frames kept"}) {
    press(Action::searchKnob);
    window_.frames(4);
    window_.type(words);
    window_.frames(2);
    EXPECT_GT(window_.view().foundKnobs(), 0u) << words;
  }
  press(Action::searchKnob);
  window_.frames(4);
  window_.type("no such knob");
  window_.frames(2);
  EXPECT_EQ(window_.view().foundKnobs(), 0u);
}

TEST_F(WindowTypingTest, EscEndsASearch) {
  ASSERT_TRUE(openAndRest("block"));
  press(Action::searchKnob);
  window_.frames(4);
  window_.type("jitter");
  window_.click(kLeftPicture);
  EXPECT_EQ(window_.view().searched(), "jitter");
  press(Action::goBack);
  EXPECT_EQ(window_.view().searched(), "");
  EXPECT_TRUE(window_.takeActions().empty());
}

TEST_F(WindowTypingTest, TheDialogsEntriesAreReachedByKeys) {
  ASSERT_TRUE(openAndRest("block"));
  const std::filesystem::path here = window_.folder().path();
  std::filesystem::create_directory(here / "below");
  window_.folder().write("below/mine.json", textOf(sessionFileOf(session_)));
  window_.folder().write("below/notes.txt", "nothing for this program");
  press(Action::open);
  window_.frames(4);
  window_.moveTo(kLeftPicture);
  press(Action::freeze);
  EXPECT_FALSE(session_.knobs().isFrozen) << "keys are the dialog's";
  tap(ImGuiKey_DownArrow);  // the folder
  tap(ImGuiKey_Enter);
  EXPECT_TRUE(window_.view().showsDialog());
  window_.frames(4);
  tap(ImGuiKey_DownArrow);
  tap(ImGuiKey_DownArrow);  // there is no other that could be opened
  tap(ImGuiKey_Enter);
  EXPECT_FALSE(window_.view().showsDialog());
  ASSERT_TRUE(waitUntil([&] { return !window_.remembered.recentFiles.empty(); }));
  EXPECT_EQ(window_.remembered.recentFiles.front(), (here / "below/mine.json").string());
  ASSERT_TRUE(rest());
}

TEST_F(WindowTypingTest, ADoubleClickOnAFolderOpensNothingInIt) {
  ASSERT_TRUE(openAndRest("block"));
  const std::filesystem::path here = window_.folder().path();
  std::filesystem::create_directory(here / "scans");
  for (const char* const name : {"scans/a.json", "scans/b.json"}) window_.folder().write(name, textOf(sessionFileOf(session_)));
  const uint64_t scenes = session_.sceneCount();
  press(Action::open);
  window_.frames(4);
  const auto clickTwice = [&] {
    window_.frames(30);  // half a second: two clicks are two, and not four
    window_.click(kFirstEntry);
    window_.click(kFirstEntry);
  };
  clickTwice();
  EXPECT_TRUE(window_.view().showsDialog());
  EXPECT_TRUE(window_.remembered.recentFiles.empty());
  clickTwice();
  EXPECT_FALSE(window_.view().showsDialog()) << "a file's own double click opens it";
  ASSERT_TRUE(waitUntil([&] { return session_.sceneCount() > scenes; }));
  EXPECT_EQ(window_.remembered.recentFiles.front(), (here / "scans/a.json").string());
}

TEST_F(WindowTypingTest, WhatMayBeReplacedIsAskedInEachFolder) {
  const TestFolder folder;
  ASSERT_TRUE(openAndRest("block"));
  std::filesystem::create_directory(folder.file("other"));
  folder.write("mine.json", "first");
  folder.write("other/mine.json", "second");
  save(folder.file("mine.json"));
  EXPECT_TRUE(window_.view().showsDialog()) << "asks";
  window_.frames(4);
  window_.type(folder.file("other/mine.json"));
  confirm();
  EXPECT_TRUE(window_.view().showsDialog()) << "asks once more: it is another file";
  EXPECT_EQ(folder.read("other/mine.json"), "second");
  confirm();
  EXPECT_FALSE(window_.view().showsDialog());
  EXPECT_NE(folder.read("other/mine.json"), "second");
  EXPECT_EQ(folder.read("mine.json"), "first");
}

TEST_F(WindowTypingTest, WhatIsTypedAfterAShortcutIsNone) {
  ASSERT_TRUE(openAndRest("block"));
  window_.moveTo(kLeftPicture);
  const size_t panels = session_.panelCount();
  // In one frame, as a fast hand or a program types.
  window_.view().press({.name = "F", .isControl = true}, session_);
  ImGui::GetIO().AddInputCharactersUTF8("fjit");
  for (const char* const letter : {"F", "J", "I", "T"}) window_.view().press({.name = letter}, session_);
  window_.frames(6);
  EXPECT_FALSE(session_.knobs().isFrozen);
  EXPECT_EQ(session_.panelCount(), panels);
  EXPECT_EQ(window_.view().searched(), "fjit");
  press(Action::searchKnob);
  window_.frames(4);
  window_.type("jitter");
  EXPECT_EQ(window_.view().searched(), "jitter") << "what was there was chosen";
}

TEST_F(WindowTypingTest, EscClosesMenusFirst) {
  ASSERT_TRUE(openAndRest("block"));
  window_.moveTo(kLeftPicture);
  press(Action::inspect);
  window_.click({22.0f, 12.0f});  // File
  ASSERT_TRUE(hasPopup());
  press(Action::goBack);
  window_.frames(2);
  EXPECT_FALSE(hasPopup());
  window_.moveTo(kLeftPicture);
  window_.click(kLeftPicture);
  EXPECT_TRUE(session_.lookedAt()) << "the loupe is still there";
  press(Action::inspect);
  window_.frame();
  EXPECT_FALSE(session_.lookedAt()) << "the ray goes with it";
}

}  // namespace
}  // namespace warpscope::ui

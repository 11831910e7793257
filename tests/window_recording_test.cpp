// The window in the hands of a script: recordings that are played, closed, and made films of.
// Mirrors app/ui/playback_bar.h, questions.h and what of app/ui/main_view.h is about recordings.
#include "tests/window_script.h"

namespace warpscope::ui {
namespace {

class WindowRecordingTest : public WindowScriptTest {};

TEST_F(WindowRecordingTest, ARecordingIsPlayedSteppedAndSought) {
  const TestFolder folder;
  ASSERT_TRUE(openAndRest("block"));
  press(Action::play);  // there is none
  EXPECT_FALSE(session_.playback().isPlaying());
  session_.startRecording(folder.file("a.warpscope"), textOf(sessionFileOf(session_)));
  window_.drag(kLeftPicture, kLeftPicture + glm::vec2(60.0f, 0.0f));
  ASSERT_TRUE(rest());
  window_.drag(kLeftPicture, kLeftPicture + glm::vec2(60.0f, 0.0f));
  ASSERT_TRUE(rest());
  session_.stopRecording();
  std::this_thread::sleep_for(milliseconds(100));  // what waits is written
  window_.view().open(folder.file("a.warpscope"));
  ASSERT_TRUE(waitUntil([&] { return session_.playback().isOpen(); }));
  const LivePlayback& playback = session_.playback();
  EXPECT_TRUE(playback.isPlaying());
  window_.moveTo(kLeftPicture);
  press(Action::play);
  EXPECT_FALSE(playback.isPlaying());
  press(Action::stepOn);
  press(Action::stepOn);
  const size_t frame = playback.frame();
  EXPECT_GT(frame, 0u);
  press(Action::stepBack);
  EXPECT_EQ(playback.frame(), frame - 1);
  // The track begins behind three buttons, beneath the panels.
  const glm::vec2 track(300.0f, 543.0f);
  window_.drag(track, track + glm::vec2(-250.0f, 0.0f));
  EXPECT_DOUBLE_EQ(playback.seconds(), playback.firstSeconds()) << "at its left end";
  window_.drag(track, track + glm::vec2(2000.0f, 0.0f));
  EXPECT_DOUBLE_EQ(playback.seconds(), playback.lastSeconds());
  press(Action::play);
  EXPECT_LT(playback.seconds(), playback.lastSeconds()) << "from the beginning";
  ASSERT_TRUE(waitUntil([&] { return session_.panel(0).picture && session_.frames().newest() && !playback.isPlaying(); }));
  EXPECT_EQ(session_.error(), "");
}

TEST_F(WindowRecordingTest, ARecordingIsClosedAndAFilmOfItIsAskedAbout) {
  const TestFolder folder;
  ASSERT_TRUE(openAndRest("block"));
  const View live = session_.view();
  const auto isAsked = [] { return ImGui::IsPopupOpen(nullptr, ImGuiPopupFlags_AnyPopup); };
  press(Action::exportFilm);  // of what?
  window_.frame();
  EXPECT_FALSE(isAsked());
  press(Action::closeRecording);
  session_.startRecording(folder.file("a.warpscope"), textOf(sessionFileOf(session_)));
  window_.drag(kLeftPicture, kLeftPicture + glm::vec2(60.0f, 0.0f));
  ASSERT_TRUE(rest());
  std::this_thread::sleep_for(milliseconds(1200));  // as long as the film is to be at least
  window_.drag(kLeftPicture, kLeftPicture + glm::vec2(-60.0f, 0.0f));
  ASSERT_TRUE(rest());
  session_.stopRecording();
  session_.setView(live);
  std::this_thread::sleep_for(milliseconds(100));  // what waits is written
  window_.view().open(folder.file("a.warpscope"));
  ASSERT_TRUE(waitUntil([&] { return session_.playback().isOpen(); }));
  ASSERT_TRUE(waitUntil([&] { return session_.panel(0).picture && session_.frames().newest(); }));

  press(Action::exportFilm);
  window_.frame();
  EXPECT_TRUE(isAsked());
  window_.key({.name = "Esc"});
  window_.frames(2);
  EXPECT_FALSE(isAsked()) << "Esc means no";
  EXPECT_FALSE(session_.exporting().isAtWork());

  // Who quits while a film is being written is asked, once.
  press(Action::quit);
  EXPECT_EQ(window_.takeActions(), std::vector{Action::quit});
  session_.startExport(folder.file("film.png"), {{1600, 1200}, false});
  press(Action::quit);
  window_.frame();
  EXPECT_TRUE(window_.takeActions().empty());
  EXPECT_TRUE(isAsked());
  EXPECT_TRUE(session_.exporting().isAtWork());
  press(Action::quit);
  EXPECT_EQ(window_.takeActions(), std::vector{Action::quit});
  window_.key({.name = "Esc"});
  window_.frames(2);
  ASSERT_TRUE(waitUntil([&] { return session_.exporting().begun() >= 3 || !session_.exporting().isAtWork(); }));
  const std::optional<double> left = session_.exporting().secondsLeft();
  ASSERT_TRUE(left);
  EXPECT_GT(*left, 0.0);
  EXPECT_FALSE(session_.exporting().isFilming()) << "pictures, no film";
  session_.exporting().cancel();
  EXPECT_FALSE(session_.exporting().secondsLeft());
  EXPECT_TRUE(window_.view().mayClose(session_));

  press(Action::closeRecording);
  ASSERT_TRUE(waitUntil([&] { return !session_.playback().isOpen(); }));
  ASSERT_TRUE(rest());
  EXPECT_EQ(session_.scene()->name, "block");
  EXPECT_NEAR(session_.view().angleDeg, live.angleDeg, 1e-9);
  EXPECT_EQ(session_.error(), "");
}

TEST_F(WindowRecordingTest, ARecordingThatTheWindowBeganWithIsClosed) {
  const TestFolder folder;
  ASSERT_TRUE(openAndRest("block"));
  session_.startRecording(folder.file("a.warpscope"), textOf(sessionFileOf(session_)));
  window_.drag(kLeftPicture, kLeftPicture + glm::vec2(60.0f, 0.0f));
  ASSERT_TRUE(rest());
  session_.stopRecording();
  std::this_thread::sleep_for(milliseconds(100));  // what waits is written
  session_.load(jobOf({folder.file("a.warpscope"), {}}));  // as the command line does
  ASSERT_TRUE(waitUntil([&] { return session_.playback().isOpen(); }));
  press(Action::closeRecording);
  ASSERT_TRUE(waitUntil([&] { return !session_.playback().isOpen(); }));
  ASSERT_TRUE(rest());
  EXPECT_EQ(session_.scene()->name, kDefaultScene);
  EXPECT_EQ(session_.error(), "");
}

}  // namespace
}  // namespace warpscope::ui

// The desktop's dialogs, by programs that pass for them: what is chosen, what is not, and what fails.
// Mirrors app/shell/desktop_dialog.h and app/shell/child_process.h.
#include "app/shell/desktop_dialog.h"

#include <gmock/gmock.h>

#include <chrono>
#include <cstdlib>
#include <thread>

#include "app/shell/child_process.h"
#include "render/base/error.h"
#include "tests/test_folder.h"
#include "tests/wait_for.h"

namespace warpscope {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;

class DesktopDialogTest : public testing::Test {
 protected:
  DesktopDialogTest() {
    for (const char* name : kNames)
      if (const char* value = std::getenv(name)) before_.emplace_back(name, value);
    setenv("PATH", (folder_.path().string() + ":/usr/bin:/bin").c_str(), 1);
    setenv("DISPLAY", ":99", 1);
    unsetenv("XDG_CURRENT_DESKTOP");
  }
  ~DesktopDialogTest() override {
    for (const char* name : kNames) unsetenv(name);
    for (const auto& [name, value] : before_) setenv(name.c_str(), value.c_str(), 1);
  }
  void install(const std::string& name, const std::string& script) {
    folder_.write(name, "#!/bin/sh\n" + script + "\n");
    std::filesystem::permissions(folder_.path() / name, std::filesystem::perms::owner_all);
  }
  DesktopDialog::Answer answerOf(DesktopDialog& dialog) {
    return waitFor([&] { return dialog.tryTake(); });
  }

  static constexpr const char* kNames[] = {"PATH", "DISPLAY", "WAYLAND_DISPLAY", "XDG_CURRENT_DESKTOP"};
  const TestFolder folder_;
  std::vector<std::pair<std::string, std::string>> before_;
};

TEST_F(DesktopDialogTest, TheCommandIsThatOfTheDesktop) {
  if (hasProgram("zenity") || hasProgram("kdialog")) GTEST_SKIP() << "this machine has some of its own";
  EXPECT_THAT(desktopDialogCommand({"Open", "/data", ""}), testing::IsEmpty());
  install("kdialog", "");
  EXPECT_THAT(desktopDialogCommand({"Open", "/data", ""}), ElementsAre("kdialog", "--title", "Open", "--getopenfilename", "/data/"));
  install("zenity", "");
  EXPECT_THAT(desktopDialogCommand({"Open", "/data", ""}), ElementsAre("zenity", "--file-selection", "--title=Open", "--filename=/data/"));
  EXPECT_THAT(desktopDialogCommand({"Save", "/data", "a b.json"}),
              ElementsAre("zenity", "--file-selection", "--title=Save", "--filename=/data/a b.json", "--save", "--confirm-overwrite"));
  setenv("XDG_CURRENT_DESKTOP", "KDE", 1);
  EXPECT_THAT(desktopDialogCommand({"Save", "/data", "a.json"}), ElementsAre("kdialog", "--title", "Save", "--getsavefilename", "/data/a.json"));
  EXPECT_THAT(desktopDialogCommand({"Open", "/data", "", {".raw", ".nii.gz"}}),
              ElementsAre("kdialog", "--title", "Open", "--getopenfilename", "/data/", "Open (*.raw *.nii.gz)\nAll files (*)"));
  setenv("XDG_CURRENT_DESKTOP", "GNOME", 1);
  EXPECT_THAT(desktopDialogCommand({"Open", "/data", "", {".raw", ".nii.gz"}}),
              ElementsAre("zenity", "--file-selection", "--title=Open", "--filename=/data/", "--file-filter=Open | *.raw *.nii.gz", "--file-filter=All files | *"));
  unsetenv("DISPLAY");
  EXPECT_THAT(desktopDialogCommand({"Open", "/data", ""}), testing::IsEmpty());
}

TEST_F(DesktopDialogTest, WhatIsChosenComesAndWhatIsNotDoesNot) {
  install("zenity", "echo '/data/of mine/ä.json'");
  DesktopDialog dialog([] {});
  ASSERT_TRUE(dialog.show({"Open", "/data", ""}));
  EXPECT_TRUE(dialog.isOpen());
  DesktopDialog::Answer answer = answerOf(dialog);
  EXPECT_FALSE(answer.hasFailed) << answer.error;
  EXPECT_EQ(answer.path, std::filesystem::path("/data/of mine/ä.json"));
  EXPECT_FALSE(dialog.isOpen());
  install("zenity", "exit 1");
  ASSERT_TRUE(dialog.show({"Open", "/data", ""}));
  answer = answerOf(dialog);
  EXPECT_FALSE(answer.hasFailed);
  EXPECT_FALSE(answer.path);
}

TEST_F(DesktopDialogTest, WhatFailsSaysSo) {
  install("zenity", "echo 'cannot open display' >&2; exit 255");
  DesktopDialog dialog([] {});
  ASSERT_TRUE(dialog.show({"Open", "/data", ""}));
  const DesktopDialog::Answer answer = answerOf(dialog);
  EXPECT_TRUE(answer.hasFailed);
  EXPECT_THAT(answer.error, HasSubstr("cannot open display"));
}

TEST_F(DesktopDialogTest, OneThatIsStillOpenEndsWithTheWindow) {
  install("zenity", "exec sleep 300");
  const auto began = std::chrono::steady_clock::now();
  {
    DesktopDialog dialog([] {});
    ASSERT_TRUE(dialog.show({"Open", "/data", ""}));
    EXPECT_TRUE(dialog.show({"Open", "/data", ""})) << "it is open already";
    std::this_thread::sleep_for(std::chrono::milliseconds(200));
  }
  EXPECT_LT(std::chrono::steady_clock::now() - began, std::chrono::seconds(5));
}

TEST_F(DesktopDialogTest, ProgramsWriteToBothStreams) {
  install("talker", "for i in 1 2 3 4 5 6 7 8 9; do echo out $i; echo err $i >&2; done; exit 3");
  const ProgramEnd end = endOfProgram({"talker"});
  EXPECT_EQ(end.exitCode, 3);
  EXPECT_THAT(end.written, testing::EndsWith("out 9\n"));
  EXPECT_THAT(end.said, testing::EndsWith("err 9\n"));
  install("flood", "head -c 1000000 /dev/zero; echo the end");
  EXPECT_THAT(endOfProgram({"flood"}).written, testing::EndsWith("the end\n"));
  EXPECT_THROW(endOfProgram({"no-such-program"}), InputError);
}

TEST_F(DesktopDialogTest, WhatAProgramLeavesBehindIsNotWaitedFor) {
  const auto from = std::chrono::steady_clock::now();
  install("leaver", "sleep 20 & echo hi; exit 4");
  const ProgramEnd end = endOfProgram({"leaver"});
  EXPECT_EQ(end.exitCode, 4);
  EXPECT_EQ(end.written, "hi\n");
  install("hider", "setsid sleep 20 & wait");
  std::stop_source stop;
  const std::jthread stopper([&] {
    std::this_thread::sleep_for(std::chrono::milliseconds(200));
    stop.request_stop();
  });
  EXPECT_THROW(endOfProgram({"hider"}, stop.get_token()), OperationCancelled);
  EXPECT_LT(std::chrono::steady_clock::now() - from, std::chrono::seconds(10));
}

}  // namespace
}  // namespace warpscope

// Processes that watch others, started here: what comes of the one that is watched is what whoever started them is told.
#include "app/shell/watched_process.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/wait.h>
#include <unistd.h>

#include <array>
#include <csignal>
#include <functional>
#include <optional>
#include <string>

namespace warpscope {
namespace {

/// The watcher, a child of this process; the one that it watches says its number, and does something until it ends.
class WatchedProcess : public ::testing::Test {
 protected:
  /// `work`: what the watched one does; its exit code. `before`: what the watcher does before anything else.
  void start(const std::function<int()>& work, const std::function<void()>& before = [] {}) {
    std::array<int, 2> numbers{}, errors{};
    ASSERT_EQ(pipe(numbers.data()), 0);
    ASSERT_EQ(pipe(errors.data()), 0);
    watcher_ = fork();
    if (watcher_ == 0) {
      dup2(errors[1], STDERR_FILENO);
      for (const int end : {errors[0], errors[1], numbers[0]}) close(end);
      before();
      if (const std::optional<int> code = goOnInChild("self: it ")) _exit(*code);
      const pid_t self = getpid();
      if (write(numbers[1], &self, sizeof self) != sizeof self) _exit(99);
      _exit(work());
    }
    ASSERT_GT(watcher_, 0);
    close(numbers[1]);
    close(errors[1]);
    errors_ = errors[0];
    ASSERT_EQ(read(numbers[0], &watched_, sizeof watched_), static_cast<ssize_t>(sizeof watched_));
    close(numbers[0]);
  }

  /// The watcher's.
  int exitCode() const {
    int status = 0;
    EXPECT_EQ(waitpid(watcher_, &status, 0), watcher_);
    return WIFEXITED(status) ? WEXITSTATUS(status) : -WTERMSIG(status);
  }
  /// What both have said, once both have ended.
  std::string said() const {
    std::string text;
    std::array<char, 256> bytes{};
    for (ssize_t count = 0; (count = read(errors_, bytes.data(), bytes.size())) > 0;) text.append(bytes.data(), static_cast<size_t>(count));
    return text;
  }
  static int waitForEver() {
    for (;;) pause();
  }

  pid_t watcher_ = 0, watched_ = 0;
  int errors_ = -1;
};

TEST_F(WatchedProcess, ItsCodeIsTheOneThatIsToldOf) {
  for (const int code : {0, 2, 77}) {
    start([code] { return code; });
    EXPECT_EQ(exitCode(), code);
    EXPECT_EQ(said(), "");
  }
}

TEST_F(WatchedProcess, ASignalThatEndsItIsSaid) {
  start(waitForEver);
  EXPECT_NE(watched_, watcher_);
  kill(watched_, SIGKILL);
  EXPECT_EQ(exitCode(), 1);
  EXPECT_THAT(said(), testing::HasSubstr("self: it was ended by signal 9 (Killed)\n"));
}

TEST_F(WatchedProcess, WhatItsWatcherIsToldComesToIt) {
  for (const int number : {SIGINT, SIGTERM, SIGHUP}) {
    start(waitForEver);
    kill(watcher_, number);
    EXPECT_EQ(exitCode(), 1);
    EXPECT_EQ(said(), "") << "who told it knows";
  }
  start(waitForEver);
  kill(watcher_, SIGUSR1);
  EXPECT_EQ(exitCode(), 1);
  EXPECT_THAT(said(), testing::HasSubstr("signal 10"));
  static volatile sig_atomic_t isTold = 0;
  start(
      [] {
        while (isTold == 0) usleep(1000);
        return 5;
      },
      [] { std::signal(SIGTERM, [](int) { isTold = 1; }); });  // the watched one has it from the beginning
  kill(watcher_, SIGTERM);
  EXPECT_EQ(exitCode(), 5);
}

TEST_F(WatchedProcess, StopsAndGoesOnWithItsWatcher) {
  start(waitForEver);
  kill(watcher_, SIGTSTP);
  int status = 0;
  ASSERT_EQ(waitpid(watcher_, &status, WUNTRACED), watcher_);
  EXPECT_TRUE(WIFSTOPPED(status));
  kill(watcher_, SIGCONT);
  kill(watcher_, SIGTERM);
  EXPECT_EQ(exitCode(), 1);
}

TEST_F(WatchedProcess, DoesNotOutliveItsWatcher) {
  start(waitForEver);
  kill(watcher_, SIGKILL);
  EXPECT_EQ(exitCode(), -SIGKILL);
  EXPECT_EQ(said(), "") << "its end of the pipe is closed: it has ended, or this would wait for ever";
}

TEST_F(WatchedProcess, WhoIgnoresTheEndOfChildrenHearsOfIt) {
  start([] { return 3; }, [] { std::signal(SIGCHLD, SIG_IGN); });
  EXPECT_EQ(exitCode(), 3);
}

}  // namespace
}  // namespace warpscope

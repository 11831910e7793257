// Interrupts of work that does not end: one asks, the next one ends the process, and a line in between says so.
// Mirrors app/shell/interrupt.h, in a process of its own.
#include "app/shell/interrupt.h"

#include <gmock/gmock.h>
#include <poll.h>
#include <signal.h>
#include <sys/wait.h>
#include <unistd.h>

#include <chrono>
#include <string>
#include <thread>

namespace warpscope {
namespace {

using std::chrono::milliseconds, std::chrono::seconds, std::chrono::steady_clock;

/// A process that waits for an interrupt, says "stopped" and then goes on for `more`.
class Stubborn {
 public:
  explicit Stubborn(milliseconds more) {
    int ends[2];
    EXPECT_EQ(pipe(ends), 0);
    process_ = fork();
    if (process_ == 0) {
      dup2(ends[1], STDERR_FILENO);
      const Interrupt interrupt;
      say("ready");
      while (!interrupt.token().stop_requested()) std::this_thread::sleep_for(milliseconds(1));
      say("stopped");
      std::this_thread::sleep_for(more);
      _exit(7);
    }
    close(ends[1]);
    err_ = ends[0];
  }
  ~Stubborn() {
    if (process_ > 0) {
      kill(process_, SIGKILL);
      waitpid(process_, nullptr, 0);
    }
    close(err_);
  }

  void interrupt() const { kill(process_, SIGINT); }

  /// What it says until `text` is there, or it has ended.
  const std::string& readUntil(const std::string& text) {
    char piece[256];
    pollfd waiting{err_, POLLIN, 0};
    while (said_.find(text) == std::string::npos && poll(&waiting, 1, 30'000) > 0) {
      const ssize_t count = read(err_, piece, sizeof piece);
      if (count <= 0) break;
      said_.append(piece, static_cast<size_t>(count));
    }
    return said_;
  }

  /// How it ends: an exit code, or minus a signal.
  int wait() {
    int status = 0;
    waitpid(process_, &status, 0);
    process_ = -1;
    return WIFEXITED(status) ? WEXITSTATUS(status) : -WTERMSIG(status);
  }

 private:
  static void say(const std::string& text) { static_cast<void>(write(STDERR_FILENO, text.data(), text.size()) + 0); }

  pid_t process_ = -1;
  int err_ = -1;
  std::string said_;
};

TEST(Interrupt, TheSecondOneEndsAtOnceAndALineSaysSo) {
  Stubborn process(seconds(60));
  process.readUntil("ready");
  process.interrupt();
  EXPECT_THAT(process.readUntil("at once"), testing::HasSubstr("warpscope: stopping takes a while; press Ctrl-C again to end at once"));
  const auto start = steady_clock::now();
  process.interrupt();
  EXPECT_EQ(process.wait(), -SIGINT);
  EXPECT_LT(steady_clock::now() - start, seconds(2));
}

TEST(Interrupt, TheSecondOneNeedsNoLine) {
  Stubborn process(seconds(60));
  process.readUntil("ready");
  process.interrupt();
  process.readUntil("stopped");
  std::this_thread::sleep_for(milliseconds(400));
  process.interrupt();
  EXPECT_EQ(process.wait(), -SIGINT);
}

TEST(Interrupt, ABouncingKeyIsOne) {
  Stubborn process(milliseconds(300));
  process.readUntil("ready");
  for (int i = 0; i < 4; ++i) {
    process.interrupt();
    std::this_thread::sleep_for(milliseconds(10));
  }
  EXPECT_EQ(process.wait(), 7);
  EXPECT_THAT(process.readUntil("end"), testing::Not(testing::HasSubstr("warpscope:")));
}

}  // namespace
}  // namespace warpscope

// The bar on a terminal: it appears and moves while one step takes long, and leaves the line empty.
// Mirrors app/shell/progress.h; the terminal is a POSIX pseudo-terminal.
#include "app/shell/progress.h"

#include <fcntl.h>
#include <gmock/gmock.h>
#include <poll.h>
#include <stdlib.h>
#include <unistd.h>

namespace warpscope {
namespace {

using testing::HasSubstr;

/// Both ends of a terminal.
class Terminal {
 public:
  Terminal() : screen_(posix_openpt(O_RDWR | O_NOCTTY)) {
    if (screen_ < 0 || grantpt(screen_) != 0 || unlockpt(screen_) != 0) return;
    program_ = std::fopen(ptsname(screen_), "w");
  }
  ~Terminal() {
    if (program_ != nullptr) std::fclose(program_);
    if (screen_ >= 0) ::close(screen_);
  }
  std::FILE* program() const { return program_; }

  /// What appears until `text` has; all there is if it does not within a minute.
  std::string readUntil(const std::string& text) {
    std::string seen;
    pollfd waiting{screen_, POLLIN, 0};
    char piece[256];
    while (seen.find(text) == std::string::npos && poll(&waiting, 1, 60'000) > 0) {
      const ssize_t got = read(screen_, piece, sizeof piece);
      if (got <= 0) break;
      seen.append(piece, static_cast<size_t>(got));
    }
    return seen;
  }

 private:
  int screen_;
  std::FILE* program_ = nullptr;
};

TEST(Progress, SaysHowFarAVolumeIsLookedThrough) {
  EXPECT_EQ(lookingText({17'200'000'000, 3'210'000'000}, 2.0), "3.2 of 17.2 GB, 1.60 GB/s");
  EXPECT_EQ(lookingText({}, 0.0), "0.0 of 0.0 GB, 0.00 GB/s");
  Terminal terminal;
  if (terminal.program() == nullptr) GTEST_SKIP() << "no pseudo-terminals here";
  beginLooking(1000);  // somebody else's, long before
  Progress progress("opening", 1, false, terminal.program());
  progress.step("fish.raw");
  beginLooking(4'000'000'000);
  noteLooked(1'000'000'000);
  EXPECT_THAT(terminal.readUntil("GB/s"), HasSubstr("opening [######..................] 0/1 fish.raw (1 s, 1.0 of 4.0 GB, "));
  noteLooked(3'000'000'000);
  EXPECT_THAT(terminal.readUntil("fish.raw (2 s)"), HasSubstr("fish.raw (2 s)")) << "and no more of it";
}

TEST(Progress, AppearsAndMovesDuringOneStepAndCleansUp) {
  Terminal terminal;
  if (terminal.program() == nullptr) GTEST_SKIP() << "no pseudo-terminals here";
  const auto start = std::chrono::steady_clock::now();
  {
    Progress progress("baking", 4, false, terminal.program());
    progress.step("flour");
    progress.step("eggs");
    EXPECT_THAT(terminal.readUntil("eggs (1 s)"), HasSubstr("baking [######..................] 1/4 eggs (1 s)"));
    EXPECT_GE(std::chrono::steady_clock::now() - start, std::chrono::seconds(1));
    EXPECT_THAT(terminal.readUntil("(2 s)"), HasSubstr("1/4 eggs (2 s)"));
    progress.step("sugar");
    EXPECT_THAT(terminal.readUntil("sugar"), HasSubstr("[############............] 2/4 sugar"));
  }
  std::fputs("end", terminal.program());
  std::fflush(terminal.program());
  EXPECT_THAT(terminal.readUntil("end"), testing::EndsWith("\r\x1b[Kend"));
}

TEST(Progress, SaysWhatIsLeftOnceItCanTell) {
  EXPECT_EQ(remainingText(2, 100, 60.0), "");   // too few
  EXPECT_EQ(remainingText(10, 100, 2.0), "");   // too soon
  EXPECT_EQ(remainingText(10, 10, 60.0), "");   // done
  EXPECT_EQ(remainingText(10, 50, 10.0), "about 40 s left");
  EXPECT_EQ(remainingText(999, 1000, 5.0), "about 1 s left");
  EXPECT_EQ(remainingText(10, 130, 15.0), "about 3 min left");

  Terminal terminal;
  if (terminal.program() == nullptr) GTEST_SKIP() << "no pseudo-terminals here";
  Progress progress("baking", 8, false, terminal.program());
  for (const char* what : {"flour", "eggs", "sugar", "milk", "salt"}) progress.step(what);  // four are done
  EXPECT_THAT(terminal.readUntil("left"), HasSubstr("4/8 salt (3 s, about 3 s left"));
}

TEST(Progress, QuickAndQuietWorkShowsNothing) {
  Terminal terminal;
  if (terminal.program() == nullptr) GTEST_SKIP() << "no pseudo-terminals here";
  {
    Progress quick("baking", 1, false, terminal.program());
    quick.step("flour");
  }
  {
    Progress quiet("baking", 1, true, terminal.program());
    Progress loud("boiling", 1, false, terminal.program());
    loud.step("water");
    EXPECT_THAT(terminal.readUntil("water"), HasSubstr("boiling"));  // by then the other would have appeared
  }
  std::fputs("end", terminal.program());
  std::fflush(terminal.program());
  EXPECT_THAT(terminal.readUntil("end"), testing::Not(HasSubstr("baking")));
}

}  // namespace
}  // namespace warpscope

// Output that cannot be written, and interrupts, through the built program: a failure with a sentence, and nothing half-written stays.
// The contract is in README.
#include "tests/cli.h"

namespace warpscope {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;

TEST_F(CommandLine, AFullDeviceIsAFailure) {
  if (!fs::exists("/dev/full")) GTEST_SKIP() << "no /dev/full here";
  fs::create_symlink("/dev/full", folder_.path() / "full.png");
  expectRefused(quick({"shot", "-o", "full.png"}), kFailure, {"full.png", "No space left"});
}

/// The reader of the pipe has gone before anything is printed.
TEST_F(CommandLine, PipesThatNobodyReadsAreAFailureThatLeavesNothing) {
  for (const std::string stream : {"", "2>&1"}) {
    const bool isOut = stream.empty();
    const std::string printing = isOut ? " --json 2>err" : " 2>&1";
    runShell("{ sleep 0.3; \"$W\" compare block --out out --volume-size 24x22x20 --size 40x30" + printing + "; echo $? >code; } | true", folder_.path());
    EXPECT_EQ(folder_.read("code"), isOut ? "1\n" : "0\n");
    if (isOut) EXPECT_THAT(folder_.read("err"), testing::StartsWith("warpscope: standard output cannot be written to"));
    // The pictures are there all the same.
    EXPECT_TRUE(json::accept(folder_.read("out/metrics.json")));
    for (const std::string& name : folder_.listing()) EXPECT_THAT(name, testing::Not(testing::HasSubstr("partial")));
    fs::remove_all(folder_.path() / "out");
  }
  succeed(quick({"shot", "-o", "plain.png"}));
  runShell("\"$W\" shot --volume-size 24x22x20 --size 40x30 -o /dev/stdout | cat >piped.png", folder_.path());
  EXPECT_EQ(folder_.read("piped.png"), folder_.read("plain.png"));
}

TEST_F(CommandLine, FilesThatMayNotGrowAreAFailureThatLeavesNothing) {
  for (const std::string command : {"shot -o a.png", "export --ply a.ply", "compare --out out"}) {
    const ProgramResult result = runShell("ulimit -f 8; exec \"$W\" " + command + " block --volume-size 24x22x20 --size 300x300", folder_.path());
    EXPECT_EQ(result.code, kFailure) << command;
    EXPECT_THAT(result.err, testing::StartsWith("warpscope: ")) << command;
    EXPECT_THAT(result.err, testing::HasSubstr("cannot be written: File too large")) << command;
    EXPECT_EQ(std::count(result.err.begin(), result.err.end(), '\n'), 1) << result.err;
    EXPECT_TRUE(folder_.listing().empty()) << testing::PrintToString(folder_.listing());
  }
}

/// A volume that takes many seconds to compute.
TEST_F(CommandLine, InterruptingTheOpeningOfAVolumeEndsItAtOnce) {
  for (const Arguments& command : {Arguments{"shot", "-o", "a.png"}, {"export", "--ply", "a.ply"}, {"compare", "--out", "out"}}) {
    SCOPED_TRACE(command[0]);
    Arguments arguments = command;
    arguments.insert(arguments.end(), {"vessels", "--volume-size", "800x800x800", "--verbose"});
    Program program(arguments, folder_.path());
    while (program.errSoFar().find("backend: ") == std::string::npos && !program.hasEnded()) std::this_thread::sleep_for(std::chrono::milliseconds(1));
    const auto start = std::chrono::steady_clock::now();
    program.signal(SIGINT);
    const ProgramResult result = program.wait();
    EXPECT_LT(std::chrono::steady_clock::now() - start, std::chrono::seconds(2));
    EXPECT_EQ(result.code, kFailure);
    EXPECT_THAT(result.err, testing::EndsWith("warpscope: stopped; nothing was written\n"));
    EXPECT_THAT(result.err, testing::Not(testing::HasSubstr("volume ")));
    EXPECT_TRUE(folder_.listing().empty());
  }
}

/// After the march, while the picture or the cloud is made: work of a second or more at this size.
TEST_F(CommandLine, InterruptingWhatComesAfterTheMarchLeavesNothing) {
  const std::pair<Arguments, std::string> commands[] = {
      {{"shot", "block", "--technique", "hold", "-o", "a.png"}, "drew "},
      {{"export", "block", "--ply", "a.ply", "--heuristic", "entrance"}, "marched "},
  };
  for (const auto& [command, event] : commands) {
    SCOPED_TRACE(command[0]);
    Arguments arguments = quick(command, "4096x4096");
    arguments.push_back("--verbose");
    Program program(arguments, folder_.path());
    while (program.errSoFar().find(event) == std::string::npos && !program.hasEnded()) std::this_thread::sleep_for(std::chrono::milliseconds(1));
    ASSERT_FALSE(program.hasEnded()) << "too quick to be interrupted";
    program.signal(SIGINT);
    const ProgramResult result = program.wait();
    EXPECT_EQ(result.code, kFailure);
    EXPECT_THAT(result.err, testing::HasSubstr("warpscope: stopped"));
    EXPECT_THAT(result.err, testing::Not(testing::HasSubstr("wrote")));
    EXPECT_TRUE(folder_.listing().empty()) << testing::PrintToString(folder_.listing());
  }
}

TEST_F(CommandLine, WhatIsStartedToOutliveItsTerminalDoes) {
  const ProgramResult result = runShell("trap '' HUP; \"$W\" compare block --out out --volume-size 24x22x20 --size 200x200 --quiet & sleep 0.2; kill -HUP $!; wait $!",
                                        folder_.path());
  EXPECT_EQ(result.code, kSuccess) << result.err;
  EXPECT_TRUE(fs::exists(folder_.path() / "out/metrics.json"));
}

TEST_F(CommandLine, InterruptingCompareLeavesNothing) {
  const auto picturesSoFar = [&] {
    const std::vector<std::string> names = folder_.listing();
    return std::count_if(names.begin(), names.end(), [](const std::string& name) { return name.ends_with(".png"); });
  };
  // Whichever signal it is, and whenever it comes, of four techniques or more in five views; in steps that are long as well.
  struct Interruption {
    int signal, pictures;
    std::string size;
  };
  const std::string large = "1501x1499", small = "701x699";
  for (const auto& [number, pictures, size] : {Interruption{SIGINT, 0, large}, {SIGINT, 1, large}, {SIGINT, 6, small}, {SIGTERM, 1, small}, {SIGHUP, 1, small}}) {
    SCOPED_TRACE(std::to_string(number) + " after " + std::to_string(pictures) + " pictures");
    Program program({"compare", "block", "--out", "out/deep", "--size", size}, folder_.path());
    while ((!fs::exists(folder_.path() / "out/deep") || picturesSoFar() < pictures) && !program.hasEnded())
      std::this_thread::sleep_for(std::chrono::milliseconds(5));
    ASSERT_FALSE(program.hasEnded()) << "it ended before it was interrupted";
    const auto start = std::chrono::steady_clock::now();
    // The impatient press the keys again.
    for (const int pauseMs : {0, 1, 7, 30}) {
      program.signal(number);
      std::this_thread::sleep_for(std::chrono::milliseconds(pauseMs));
    }
    const ProgramResult result = program.wait();
    const double seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
    EXPECT_LT(seconds, 2.0);
    EXPECT_EQ(result.code, kFailure);
    EXPECT_THAT(result.err, testing::StartsWith("warpscope: stopped"));
    EXPECT_EQ(std::count(result.err.begin(), result.err.end(), '\n'), 1) << result.err;
    EXPECT_TRUE(folder_.listing().empty()) << testing::PrintToString(folder_.listing());
  }
}

}  // namespace
}  // namespace warpscope

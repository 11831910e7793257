// Files that somebody else made, through the built program: they end in a sentence, and neither stop the program, fill the machine nor steer a terminal.
// What is promised is in README.
#include <sys/stat.h>

#include <fstream>

#include "tests/cli.h"

namespace warpscope {
namespace {

namespace fs = std::filesystem;
using std::chrono::milliseconds, std::chrono::seconds, std::chrono::steady_clock;
using testing::HasSubstr, testing::Not;

class HostileFiles : public CommandLine {
 protected:
  /// As expectRefused, and soon.
  void expectRefusedSoon(const Arguments& arguments, int code, const std::vector<std::string>& reasons) const {
    const auto start = steady_clock::now();
    expectRefused(arguments, code, reasons);
    EXPECT_LT(steady_clock::now() - start, seconds(10)) << testing::PrintToString(arguments);
  }
};

/// C1 controls as a byte and as UTF-8, C0 controls, half a character, a turn of the direction of writing.
TEST_F(HostileFiles, NoNameSteersTheTerminal) {
  const std::string name = "a\x9b" "31m\xc2\x9b" "2J\x1b]0;x\x07\xe2\x82\xe2\x80\xae.json";
  const std::string shown = "a\\x9b31m\\u009b2J\\x1b]0;x\\x07\\xe2\\x82\\u202e.json";
  expectRefused({"shot", "-o", "a.png", name}, kFailure, {shown + ": there is no such file"});
  folder_.write(name, "{\"name\": \"a\", \"na\xc2\x9bme\": 1}");
  expectRefused({"shot", "-o", "a.png", name}, kFailure, {shown, "na\\u009bme"});
  folder_.write("a.nrrd", "NRRD0004\ntype: \x9b" "31m\xc2\x9bhort\ndimension: 3\nsizes: 2 2 2\nencoding: raw\n\n12345678");
  const ProgramResult result = run({"shot", "-o", "a.png", "a.nrrd"});
  for (const char* steering : {"\x9b", "\x1b", "\xc2\x9b"}) EXPECT_THAT(result.err, Not(HasSubstr(steering)));
  // A document for machines, on a terminal all the same.
  folder_.write("scene.json", "{\"name\": \"a\\u009b2J\\u007f\", \"volume\": {\"procedural\": \"block\"}}");
  const ProgramResult printed = succeed(quick({"compare", "scene.json", "--json", "--out", "out"}));
  EXPECT_THAT(printed.out, Not(HasSubstr("\xc2\x9b")));
  EXPECT_EQ(nlohmann::json::parse(printed.out)["scene"], "a\xc2\x9b" "2J\x7f");
}

TEST_F(HostileFiles, ScenesAreNotLargerThanThePageSays) {
  const std::string scene = "{\"name\": \"a\", \"volume\": {\"procedural\": \"block\"}}";
  constexpr size_t kLargest = 16 << 20;
  folder_.write("fits.json", scene + std::string(kLargest - scene.size(), ' '));
  folder_.write("large.json", scene + std::string(kLargest - scene.size() + 1, ' '));
  succeed(quick({"shot", "fits.json", "-o", "a.png"}));
  fs::remove(folder_.path() / "a.png");
  expectRefused({"shot", "large.json", "-o", "a.png"}, kFailure, {"large.json", "too large", "16 MiB", std::to_string(kLargest + 1)});
  expectRefused({"shot", "block", "--tf", "large.json", "-o", "a.png"}, kFailure, {"large.json", "16 MiB"});
}

/// A pipe that nobody writes to would be waited for without an end.
TEST_F(HostileFiles, WhatIsNoFileIsNotWaitedFor) {
  for (const std::string name : {"pipe", "pipe.json", "pipe.nrrd", "pipe.nii.gz", "pipe.mha", "pipe.mrc", "pipe_2x2x2_uint8.raw", "voxels.pipe"})
    ASSERT_EQ(mkfifo(folder_.file(name).c_str(), 0600), 0);
  for (const std::string name : {"pipe.json", "pipe.nrrd", "pipe.nii.gz", "pipe.mha", "pipe.mrc", "pipe_2x2x2_uint8.raw"}) {
    expectRefusedSoon({"shot", "-o", "a.png", name}, kFailure, {name, "is no", "regular file"});
    expectRefusedSoon({"shot", "-o", "a.png", "block", "--tf", name}, kFailure, {name, "regular file"});
  }
  expectRefusedSoon({"sweep", "--out", "out", "--plan", "pipe"}, kFailure, {"pipe", "regular file"});
  expectRefusedSoon({"shot", "-o", "a.png", "--technique", "auto", "--front", "pipe"}, kFailure, {"pipe", "regular file"});
  expectRefusedSoon({"shot", "-o", "a.png", "--connect", "warp://127.0.0.1:1", "--link", "trace=pipe"}, kUsage, {"pipe", "regular file"});
  folder_.write("a.nhdr", "NRRD0004\ntype: uchar\ndimension: 3\nsizes: 2 2 2\nencoding: raw\ndata file: voxels.pipe\n");
  expectRefusedSoon({"shot", "-o", "a.png", "a.nhdr"}, kFailure, {"voxels.pipe", "pipe"});
  for (const std::string name : {"/dev/zero", "/dev/tty"}) expectRefusedSoon({"shot", "-o", "a.png", "block", "--tf", name}, kFailure, {name});
}

/// Numbers as text take ITK long, and it does not ask whether anybody still wants them.
TEST_F(HostileFiles, AReaderThatDoesNotListenIsLeftAlone) {
  constexpr int kSide = 300;
  std::string text = "NRRD0004\ntype: float\ndimension: 3\nsizes: 300 300 300\nencoding: ascii\n\n";
  for (int i = 0; i < kSide * kSide * kSide; ++i) text += "1\n";
  folder_.write("slow.nrrd", text);
  const std::vector<std::string> before = folder_.listing();
  for (const Arguments& command : {Arguments{"shot", "-o", "a.png"}, {"compare", "--out", "out"}}) {
    Arguments arguments = command;
    arguments.push_back("slow.nrrd");
    Program program(arguments, folder_.path());
    std::this_thread::sleep_for(milliseconds(1200));  // the program's own look at the file, which listens, is over
    ASSERT_FALSE(program.hasEnded()) << program.errSoFar();
    const auto start = steady_clock::now();
    program.signal(SIGINT);
    const ProgramResult result = program.wait();
    EXPECT_LT(steady_clock::now() - start, seconds(1));
    EXPECT_EQ(result.code, kFailure) << result.err;
    EXPECT_EQ(result.err, "warpscope: stopped; nothing was written\n");
    EXPECT_EQ(folder_.listing(), before);
  }
}

/// A header that a library would take minutes for, or more memory than the machine has.
TEST_F(HostileFiles, HeadersAreLimited) {
  std::string many = "NRRD0004\ntype: uchar\ndimension: 3\nsizes: 2 2 2\nencoding: raw\n";
  for (int i = 0; i < 100'000; ++i) many += "key" + std::to_string(i) + ":=v\n";
  folder_.write("many.nrrd", many + "\n12345678");
  expectRefusedSoon({"shot", "-o", "a.png", "many.nrrd"}, kFailure, {"many.nrrd: its header goes on after line 4096", "1 MiB"});
  folder_.write("minus.nrrd", "NRRD0004\ntype: uchar\ndimension: 3\nsizes: 2 -16 2\nencoding: raw\n\n12345678");
  expectRefused({"shot", "-o", "a.png", "minus.nrrd"}, kFailure, {"minus.nrrd: its header declares -16 voxels along axis 2"});
  folder_.write("large.json", "{\"name\": \"a\", \"volume\": {\"procedural\": \"block\", \"size\": [65536, 65536, 65536]}}");
  expectRefusedSoon({"shot", "-o", "a.png", "large.json"}, kFailure, {"block", "256 TiB", "are free"});
  const std::string honest = "NRRD0004\ntype: uchar\ndimension: 3\nsizes: 16384 16384 8192\nencoding: raw\n\n";
  folder_.write("honest.nrrd", honest);
  std::error_code error;
  fs::resize_file(folder_.path() / "honest.nrrd", honest.size() + (uint64_t{1} << 41), error);
  if (!error) expectRefusedSoon({"shot", "-o", "a.png", "honest.nrrd"}, kFailure, {"honest.nrrd: it needs 2 TiB of memory, and ", " are free"});
}

TEST_F(HostileFiles, ASweepsJournalFollowsNoLink) {
  folder_.write("precious", "of somebody else\n");
  fs::create_directory(folder_.path() / "out");
  fs::create_symlink("../precious", folder_.path() / "out/sweep-unfinished.jsonl");
  const Arguments sweep = quick({"sweep", "block", "--out", "out", "--techniques", "hold", "--angles", "0", "--quiet"});
  expectRefused(sweep, kFailure, {"out/sweep-unfinished.jsonl", "symbolic link", "remove the link"});
  EXPECT_EQ(folder_.read("precious"), "of somebody else\n");
  fs::remove(folder_.path() / "out/sweep-unfinished.jsonl");
  ASSERT_EQ(mkfifo(folder_.file("out/sweep-unfinished.jsonl").c_str(), 0600), 0);
  expectRefusedSoon(sweep, kFailure, {"out/sweep-unfinished.jsonl", "no file"});
}

}  // namespace
}  // namespace warpscope

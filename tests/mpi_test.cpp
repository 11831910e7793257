// The program as several processes that mpirun starts: it does what one does, and ends as one.
// Mirrors app/frames/process_ranks.h and render/bricks/mpi_ranks.cpp.
#include <dirent.h>

#include <fstream>
#include <map>
#include <random>

#include "tests/cli.h"

namespace warpscope {
namespace {

using std::chrono::milliseconds;
using std::chrono::seconds;

class Mpi : public CommandLine {
 protected:
  void SetUp() override {
    if (std::string(WARPSCOPE_MPIEXEC).empty()) GTEST_SKIP() << "MPI was not found when this was built";
    const ProgramResult probe = Program({"-n", "2", "/bin/true"}, folder_.path(), kEnvironment, WARPSCOPE_MPIEXEC).wait();
    if (probe.code != 0) GTEST_SKIP() << WARPSCOPE_MPIEXEC << " cannot start processes here: " << probe.err;
    // Soft balls, some in front of others.
    std::ofstream file(folder_.file(kVolume), std::ios::binary);
    for (int z = 0; z < 36; ++z)
      for (int y = 0; y < 40; ++y)
        for (int x = 0; x < 48; ++x) {
          double value = 0.0;
          for (const glm::dvec4& ball : {glm::dvec4(12, 14, 10, 11), glm::dvec4(30, 22, 20, 15), glm::dvec4(24, 8, 28, 9)})
            value = std::max(value, 1.0 - glm::length(glm::dvec3(x, y, z) - glm::dvec3(ball)) / ball.w);
          const auto voxel = static_cast<uint16_t>(40000.0 * value);
          file.write(reinterpret_cast<const char*>(&voxel), sizeof voxel);
        }
  }

  static Arguments underMpi(int count, Arguments arguments) {
    arguments.insert(arguments.begin(), {"-n", std::to_string(count), WARPSCOPE_PROGRAM});
    return arguments;
  }
  std::unique_ptr<Program> start(int count, const Arguments& arguments) const {
    return std::make_unique<Program>(underMpi(count, arguments), folder_.path(), kEnvironment, WARPSCOPE_MPIEXEC);
  }
  ProgramResult runAsMany(int count, const Arguments& arguments) const { return start(count, arguments)->wait(); }

  /// Process ids of those that were started in this folder, by rank: of those that march, or, where only these are left, of those that watch them.
  std::map<int, pid_t> processes() const {
    std::map<pid_t, int> ranks;
    for (const auto& entry : std::filesystem::directory_iterator("/proc")) {
      const std::string name = entry.path().filename().string();
      if (name.find_first_not_of("0123456789") != std::string::npos) continue;
      std::error_code error;
      if (std::filesystem::read_symlink(entry.path() / "exe", error) != std::filesystem::canonical(WARPSCOPE_PROGRAM)) continue;
      if (std::filesystem::read_symlink(entry.path() / "cwd", error) != std::filesystem::canonical(folder_.path())) continue;
      const std::string environment = contentOf(entry.path() / "environ");
      const size_t at = environment.find("OMPI_COMM_WORLD_RANK=");
      if (at != std::string::npos) ranks[std::atoi(name.c_str())] = std::atoi(environment.c_str() + at + 21);
    }
    std::map<int, pid_t> found;
    for (const auto& [process, rank] : ranks) {
      if (ranks.contains(parentOf(process)))
        found[rank] = process;
      else
        found.try_emplace(rank, process);
    }
    return found;
  }
  static pid_t parentOf(pid_t process) {
    const std::string status = contentOf("/proc/" + std::to_string(process) + "/status");
    const size_t at = status.find("PPid:");
    return at != std::string::npos ? std::atoi(status.c_str() + at + 5) : 0;
  }

  /// A server of four processes that is ready for clients; its URL.
  std::string startServer(const Arguments& scene = {kVolume}) {
    Arguments command{"serve", "--listen", "127.0.0.1:0", "--port-file", "port"};
    command.insert(command.begin() + 1, scene.begin(), scene.end());
    std::filesystem::remove(folder_.file("port"));
    server_ = start(4, command);
    const auto deadline = std::chrono::steady_clock::now() + seconds(30);
    while (folder_.read("port").empty() && !server_->hasEnded() && std::chrono::steady_clock::now() < deadline) std::this_thread::sleep_for(milliseconds(5));
    const std::string port = folder_.read("port");
    return "warp://127.0.0.1:" + port.substr(0, port.find('\n'));
  }

  /// Seconds until nothing of it is left.
  double secondsToTheEnd() const {
    const auto from = std::chrono::steady_clock::now();
    while (!server_->hasEnded() || !processes().empty()) {
      if (std::chrono::steady_clock::now() - from > seconds(30)) break;
      std::this_thread::sleep_for(milliseconds(10));
    }
    return std::chrono::duration<double>(std::chrono::steady_clock::now() - from).count();
  }

  static constexpr const char* kVolume = "balls_48x40x36_uint16.raw";
  // As root, more processes than cores, and without what containers forbid (copies from one process's memory to another's).
  inline static const Arguments kEnvironment{"OMPI_ALLOW_RUN_AS_ROOT=1", "OMPI_ALLOW_RUN_AS_ROOT_CONFIRM=1", "OMPI_MCA_rmaps_base_oversubscribe=1",
                                             "OMPI_MCA_btl_vader_single_copy_mechanism=none"};
  std::unique_ptr<Program> server_;
};

TEST_F(Mpi, FilesAreThoseOfOneProcess) {
  const Arguments size{"--size", "90x70"};
  const auto with = [&](Arguments arguments, const Arguments& more) {
    arguments.insert(arguments.end(), size.begin(), size.end());
    arguments.insert(arguments.end(), more.begin(), more.end());
    return arguments;
  };
  const std::vector<Arguments> commands{{"shot", kVolume, "--technique", "reference", "-o"},
                                        {"shot", kVolume, "--technique", "segments", "--segments", "4", "--view-angle", "20", "-o"},
                                        {"shot", kVolume, "--technique", "spheres", "--heuristic", "median", "--samples-per-ray", "3", "--view-angle", "20", "-o"},
                                        {"shot", kVolume, "--technique", "proxy", "--view-angle", "20", "-o"}};
  for (const Arguments& command : commands) {
    SCOPED_TRACE(testing::PrintToString(command));
    Arguments one = command, many = command;
    one.emplace_back("one.png");
    many.emplace_back("many.png");
    succeed(with(one, {}));
    for (const int count : {2, 5}) {
      const ProgramResult result = runAsMany(count, with(many, {}));
      ASSERT_EQ(result.code, kSuccess) << result.err;
      EXPECT_EQ(contentOf(folder_.file("many.png")), contentOf(folder_.file("one.png"))) << count;
      EXPECT_EQ(std::count(result.err.begin(), result.err.end(), '\n'), 1) << result.err;  // said once
    }
  }
  succeed(with({"export", kVolume, "--ply", "one.ply"}, {}));
  ASSERT_EQ(runAsMany(3, with({"export", kVolume, "--ply", "many.ply"}, {})).code, kSuccess);
  EXPECT_EQ(contentOf(folder_.file("many.ply")), contentOf(folder_.file("one.ply")));
}

TEST_F(Mpi, OtherFormatsAndBuiltInVolumesAreThoseOfOneProcess) {
  std::ofstream(folder_.file("balls.nrrd"), std::ios::binary) << "NRRD0004\ntype: ushort\ndimension: 3\nsizes: 48 40 36\nendian: little\nencoding: raw\n\n" << contentOf(folder_.file(kVolume));
  for (const Arguments& scene : {Arguments{"balls.nrrd"}, {"shells", "--volume-size", "60x50x40"}, {"vessels", "--volume-size", "50x60x70"}}) {
    SCOPED_TRACE(testing::PrintToString(scene));
    const auto shot = [&](const std::string& file) {
      Arguments command{"shot", "--technique", "segments", "--size", "90x70", "--view-angle", "20", "-o", file};
      command.insert(command.begin() + 1, scene.begin(), scene.end());
      return command;
    };
    succeed(shot("one.png"));
    const ProgramResult result = runAsMany(3, shot("many.png"));
    ASSERT_EQ(result.code, kSuccess) << result.err;
    EXPECT_EQ(contentOf(folder_.file("many.png")), contentOf(folder_.file("one.png")));
  }
}

TEST_F(Mpi, WhatIsWrongIsSaidOnceAndEndsAll) {
  const auto expectRefusal = [&](int count, const Arguments& arguments, int code, const std::string& reason) {
    SCOPED_TRACE(testing::PrintToString(arguments));
    const ProgramResult result = runAsMany(count, arguments);
    EXPECT_EQ(result.code, code);
    EXPECT_EQ(result.out, "");
    const size_t first = result.err.find("warpscope: ");
    ASSERT_NE(first, std::string::npos) << result.err;
    EXPECT_NE(result.err.find(reason), std::string::npos) << result.err;
    EXPECT_EQ(result.err.find("warpscope: ", first + 1), std::string::npos) << result.err;
    EXPECT_TRUE(processes().empty());
  };
  std::ofstream(folder_.file("some.nrrd")) << "NRRD0004\n";
  std::ofstream(folder_.file("short_9x9x9_uint8.raw")) << "short";
  expectRefusal(3, {"shot", "missing_8x8x8_uint8.raw", "-o", "a.png"}, kFailure, "there is no such file");
  expectRefusal(3, {"shot", "short_9x9x9_uint8.raw", "-o", "a.png"}, kFailure, "holds 5 bytes");
  expectRefusal(2, {"shot", "some.nrrd", "-o", "a.png"}, kFailure, "some.nrrd");
  std::ofstream(folder_.file("packed.nrrd")) << "NRRD0004\ntype: uchar\ndimension: 3\nsizes: 4 4 4\nencoding: gzip\n\n";
  expectRefusal(2, {"shot", "packed.nrrd", "-o", "a.png"}, kFailure, "not compressed");
  expectRefusal(2, {"shot", kVolume, "--technik", "x"}, kUsage, "did you mean '--technique'?");
  expectRefusal(2, {"info"}, kUsage, "is for one process");
  expectRefusal(2, {}, kUsage, "is for one process");
  expectRefusal(2, {"compare", "torture/fog", "--out", "o"}, kUsage, "torture");
  EXPECT_FALSE(std::filesystem::exists(folder_.file("a.png")));
}

TEST_F(Mpi, ProcessesThatDoNotAgreeAreFoundOut) {
  const std::string voxels = contentOf(folder_.file(kVolume));
  std::filesystem::create_directory(folder_.path() / "other");
  std::filesystem::create_directory(folder_.path() / "shorter");
  std::string changed = voxels;
  for (size_t i = 0; i < changed.size(); ++i) changed[i] = static_cast<char>(changed[i] ^ 1);
  std::ofstream(folder_.file(std::string("other/") + kVolume), std::ios::binary) << changed;
  // One bit of one voxel, where nobody looks who looks here and there, in a copy of the same date; a copy that is the same.
  std::filesystem::create_directory(folder_.path() / "nearly");
  std::filesystem::create_directory(folder_.path() / "alike");
  changed = voxels;
  changed[changed.size() - 1001] = static_cast<char>(changed[changed.size() - 1001] ^ 1);
  const auto written = std::filesystem::last_write_time(folder_.file(kVolume));
  for (const auto& [name, content] : {std::pair<std::string, const std::string&>{"nearly/", changed}, {"alike/", voxels}}) {
    std::ofstream(folder_.file(name + kVolume), std::ios::binary) << content;
    std::filesystem::last_write_time(folder_.file(name + kVolume), written);
  }
  std::ofstream(folder_.file("shorter/balls_48x40x35_uint16.raw"), std::ios::binary) << voxels.substr(0, 48 * 40 * 35 * 2);
  const std::vector<std::pair<Arguments, std::string>> others{{{std::string("other/") + kVolume}, ": voxels: process 1 of 2"},
                                                              {{std::string("nearly/") + kVolume}, ": voxels: process 1 of 2"},
                                                              {{"shorter/balls_48x40x35_uint16.raw"}, "size, type and spacing of voxels: process 1 of 2"},
                                                              {{kVolume, "--step", "0.7"}, "knobs of the march: process 1 of 2"}};
  for (const auto& [arguments, reason] : others) {
    Arguments both{"-n", "1", WARPSCOPE_PROGRAM, "shot", kVolume, "-o", "a.png", ":", "-n", "1", WARPSCOPE_PROGRAM, "shot"};
    both.insert(both.end(), arguments.begin(), arguments.end());
    both.insert(both.end(), {"-o", "a.png"});
    const ProgramResult result = Program(both, folder_.path(), kEnvironment, WARPSCOPE_MPIEXEC).wait();
    EXPECT_EQ(result.code, kFailure);
    EXPECT_THAT(result.err, testing::HasSubstr(reason));
  }
  // Two read one file, each a share, two others the other.
  const Arguments pairs{"-n", "2", WARPSCOPE_PROGRAM, "shot", kVolume, "-o", "a.png", ":", "-n", "2", WARPSCOPE_PROGRAM, "shot", std::string("nearly/") + kVolume, "-o", "a.png"};
  EXPECT_THAT(Program(pairs, folder_.path(), kEnvironment, WARPSCOPE_MPIEXEC).wait().err, testing::HasSubstr(": voxels: process 2 of 4"));
  const Arguments alike{"-n", "2", WARPSCOPE_PROGRAM, "shot", kVolume, "--size", "90x70", "-o", "a.png", ":", "-n", "1", WARPSCOPE_PROGRAM, "shot", std::string("alike/") + kVolume, "--size", "90x70", "-o", "a.png"};
  EXPECT_EQ(Program(alike, folder_.path(), kEnvironment, WARPSCOPE_MPIEXEC).wait().code, kSuccess);
}

TEST_F(Mpi, VersionAndHelpArePrintedOnce) {
  const ProgramResult version = runAsMany(3, {"--version"}), alone = run({"--version"});
  EXPECT_EQ(version.code, kSuccess);
  EXPECT_EQ(version.out, alone.out);
}

TEST_F(Mpi, AServerOfSeveralProcessesServesAsOneDoes) {
  const std::string url = startServer();
  for (const char* const angle : {"0", "30"}) {
    succeed({"shot", "--connect", url, "--size", "90x70", "--view-angle", angle, "-o", "served.png"});
    succeed({"shot", kVolume, "--size", "90x70", "--view-angle", angle, "-o", "one.png"});
    EXPECT_EQ(contentOf(folder_.file("served.png")), contentOf(folder_.file("one.png")));
  }
  EXPECT_EQ(processes().size(), 4u);
  server_->signal(SIGINT);
  EXPECT_LT(secondsToTheEnd(), 2.5);  // 1.4 to 1.5 on two busy cores; Open MPI sleeps for one of them
}

TEST_F(Mpi, AProcessThatDiesEndsAll) {
  const std::string url = startServer();
  succeed({"shot", "--connect", url, "--size", "90x70", "-o", "served.png"});
  const std::map<int, pid_t> all = processes();
  ASSERT_EQ(all.size(), 4u);
  // In the middle of a picture that takes long.
  Program client({"shot", "--connect", url, "--size", "900x700", "--step", "0.002", "-o", "never.png"}, folder_.path());
  std::this_thread::sleep_for(milliseconds(700));
  kill(all.at(2), SIGKILL);
  EXPECT_LT(secondsToTheEnd(), 5.0);
  const ProgramResult server = server_->wait();
  EXPECT_EQ(server.code, kFailure);
  EXPECT_THAT(server.err, testing::HasSubstr("warpscope: process 2 of 4 was ended by signal 9 (Killed)"));
  const auto deadline = std::chrono::steady_clock::now() + seconds(5);
  while (client.errSoFar().empty() && std::chrono::steady_clock::now() < deadline) std::this_thread::sleep_for(milliseconds(10));
  EXPECT_THAT(client.errSoFar(), testing::HasSubstr("trying again"));
  EXPECT_EQ(client.wait().code, kFailure);
  EXPECT_FALSE(std::filesystem::exists(folder_.file("never.png")));
}

TEST_F(Mpi, NothingIsLeftOfAProcessThatIsNotWatchedAnyMore) {
  startServer();
  const std::map<int, pid_t> all = processes();
  ASSERT_EQ(all.size(), 4u);
  kill(parentOf(all.at(1)), SIGKILL);
  EXPECT_LT(secondsToTheEnd(), 5.0);
  EXPECT_NE(server_->wait().code, kSuccess);  // the launcher's: it has started that one itself
}

TEST_F(Mpi, ABrickThatCannotBeReadNamesFileProcessAndBytes) {
  const std::string url = startServer();
  ASSERT_EQ(processes().size(), 4u);
  std::filesystem::resize_file(folder_.file(kVolume), 100);
  const Program client({"shot", "--connect", url, "--size", "90x70", "-o", "never.png"}, folder_.path());
  const ProgramResult result = server_->wait();
  EXPECT_NE(result.code, kSuccess);
  EXPECT_THAT(result.err, testing::ContainsRegex(std::string("warpscope: process [0-3] of 4: ") + kVolume + ": bytes [0-9]+ to [0-9]+ cannot be read: it has become shorter"));
}

TEST_F(Mpi, TheBarIsOnTheTerminalThatAllWereStartedAt) {
  // 2 GiB of nothing: a hole.
  const std::string name = "hole_1024x1024x1024_uint16.raw";
  std::ofstream(folder_.file(name), std::ios::binary);
  std::filesystem::resize_file(folder_.file(name), uint64_t{2} << 30);
  std::string command = WARPSCOPE_MPIEXEC;
  for (const std::string& word : underMpi(2, {"shot", name, "--size", "32x32", "-o", "one.png"})) command += " " + word;
  const ProgramResult result = Program({"-qec", command, "/dev/null"}, folder_.path(), kEnvironment, "/usr/bin/script").wait();
  if (result.code == 127) GTEST_SKIP() << "no script(1) here";
  EXPECT_EQ(result.code, kSuccess) << result.out << result.err;
  EXPECT_THAT(result.out, testing::ContainsRegex("opening \\[[#.]+\\] 0/1 hole_1024x1024x1024_uint16.raw \\([0-9]+ s, [0-9.]+ of [0-9.]+ GB, [0-9.]+ GB/s\\)"));
}

TEST_F(Mpi, AProcessThatIsLateIsWaitedFor) {
  const std::string url = startServer();
  const std::map<int, pid_t> all = processes();
  ASSERT_EQ(all.size(), 4u);
  kill(all.at(3), SIGSTOP);
  Program client({"shot", "--connect", url, "--size", "90x70", "-o", "served.png"}, folder_.path());
  std::this_thread::sleep_for(milliseconds(1200));
  EXPECT_FALSE(client.hasEnded());
  kill(all.at(3), SIGCONT);
  EXPECT_EQ(client.wait().code, kSuccess);
  succeed({"shot", kVolume, "--size", "90x70", "-o", "one.png"});
  EXPECT_EQ(contentOf(folder_.file("served.png")), contentOf(folder_.file("one.png")));
}

TEST_F(Mpi, AProcessThatIsStoppedWhileTheVolumeIsOpenedIsNotWaitedForForLong) {
  const std::string name = "hole_2048x1024x1024_uint16.raw";
  std::ofstream(folder_.file(name), std::ios::binary);
  std::filesystem::resize_file(folder_.file(name), uint64_t{4} << 30);
  for (const int stopped : {0, 2}) {
    SCOPED_TRACE(stopped);
    server_ = start(3, {"shot", name, "--size", "32x32", "-o", "never.png"});
    // It looks through its share once that is in its memory.
    const auto hasBegun = [&] {
      const std::map<int, pid_t> all = processes();
      if (all.size() != 3) return false;
      const std::string pages = contentOf("/proc/" + std::to_string(all.at(stopped)) + "/statm");
      return std::strtoull(pages.substr(std::min(pages.find(' '), pages.size())).c_str(), nullptr, 10) > (uint64_t{300} << 20) / 4096;
    };
    const auto deadline = std::chrono::steady_clock::now() + seconds(30);
    while (!hasBegun() && !server_->hasEnded() && std::chrono::steady_clock::now() < deadline) std::this_thread::sleep_for(milliseconds(2));
    ASSERT_FALSE(server_->hasEnded());
    kill(processes().at(stopped), SIGSTOP);
    EXPECT_LT(secondsToTheEnd(), 25.0);  // the others look through their shares first
    const ProgramResult result = server_->wait();
    EXPECT_EQ(result.code, kFailure);
    EXPECT_THAT(result.err, testing::HasSubstr("process " + std::to_string(stopped) + " of 3 does not answer"));
    EXPECT_FALSE(std::filesystem::exists(folder_.file("never.png")));
  }
}

/// A coarse copy, in which shadows are found, is what all make together.
TEST_F(Mpi, AProcessThatIsStoppedIsNotWaitedForForEverByThoseWhoMakeACopy) {
  const std::string url = startServer();
  const std::map<int, pid_t> all = processes();
  ASSERT_EQ(all.size(), 4u);
  kill(all.at(2), SIGSTOP);
  Program client({"shot", "--connect", url, "--technique", "reference", "--shadows", "1", "--size", "90x70", "-o", "never.png"}, folder_.path());
  EXPECT_LT(secondsToTheEnd(), 20.0);
  const ProgramResult result = server_->wait();
  EXPECT_EQ(result.code, kFailure);
  EXPECT_THAT(result.err, testing::HasSubstr("process 2 of 4 does not answer"));
  EXPECT_FALSE(std::filesystem::exists(folder_.file("never.png")));
}

TEST_F(Mpi, AClientThatLeavesEndsItsMarchEverywhere) {
  const std::string url = startServer();
  {
    Program client({"shot", "--connect", url, "--size", "900x700", "--step", "0.002", "-o", "never.png"}, folder_.path());
    std::this_thread::sleep_for(milliseconds(700));
  }  // is killed
  const auto from = std::chrono::steady_clock::now();
  succeed({"shot", "--connect", url, "--size", "90x70", "-o", "served.png"});
  EXPECT_LT(std::chrono::steady_clock::now() - from, seconds(5));
}

TEST_F(Mpi, EndsSoonWhileNobodyWaitsForWhatIsUnderWay) {
  const std::string url = startServer();
  {
    Program client({"shot", "--connect", url, "--size", "900x700", "--step", "0.002", "--segments", "16", "-o", "never.png"}, folder_.path());
    std::this_thread::sleep_for(milliseconds(700));
  }  // is killed
  const std::map<int, pid_t> all = processes();
  ASSERT_EQ(all.size(), 4u);
  kill(all.at(0), SIGTERM);
  EXPECT_LT(secondsToTheEnd(), 5.0);
}

/// What is sent while a volume is opened may be longer than MPI takes at once: the first process, which then waits for clients, has to see to the rest of it.
TEST_F(Mpi, ASignalToAnyProcessOfAnIdleServerEndsAll) {
  const std::string name = "hole_1024x1024x64_uint16.raw";
  std::ofstream(folder_.file(name), std::ios::binary);
  std::filesystem::resize_file(folder_.file(name), uint64_t{128} << 20);
  for (const auto& [told, isWatcher] : {std::pair(0, false), {3, false}, {2, true}}) {
    SCOPED_TRACE(told);
    startServer({name});
    const std::map<int, pid_t> all = processes();
    ASSERT_EQ(all.size(), 4u);
    kill(isWatcher ? parentOf(all.at(told)) : all.at(told), SIGTERM);
    EXPECT_LT(secondsToTheEnd(), 5.0);
    const int code = server_->wait().code;
    EXPECT_TRUE(code == kFailure || told == 0) << code;
  }
}

TEST_F(Mpi, AClientIsOneProcess) {
  const ProgramResult result = runAsMany(2, {"shot", "--connect", "warp://127.0.0.1:1", "-o", "a.png"});
  EXPECT_EQ(result.code, kUsage);
  EXPECT_THAT(result.err, testing::HasSubstr("--connect is for one process"));
}

TEST_F(Mpi, NoProcessHoldsAllOfTheVolume) {
  // The system maps what it has read or written at once, and 64 KiB at least: bricks' parts of a slice are to be much more than that, whichever way they are cut.
  constexpr size_t kSide = 1024, kSlices = 32, kAtOnce = (64 << 10) / sizeof(uint16_t);
  const std::string name = "layers_1024x1024x32_uint16.raw";
  {
    std::ofstream file(folder_.file(name), std::ios::binary);
    std::vector<uint16_t> voxels(kAtOnce);
    for (size_t first = 0; first < kSide * kSide * kSlices; first += kAtOnce) {
      for (size_t i = 0; i < kAtOnce; ++i) voxels[i] = static_cast<uint16_t>((first + i) * 7 % 1000 + 800 * (first / (kSide * kSide) % 13));
      file.write(reinterpret_cast<const char*>(voxels.data()), static_cast<std::streamsize>(kAtOnce * sizeof(uint16_t)));
    }
  }
  const std::string url = startServer({name});
  for (const char* const angle : {"0", "120"}) succeed({"shot", "--connect", url, "--size", "200x150", "--view-angle", angle, "-o", "a.png"});
  const double whole = 2.0 * kSide * kSide * kSlices / 1024.0;
  double sum = 0.0;
  const std::map<int, pid_t> all = processes();
  ASSERT_EQ(all.size(), 4u);
  for (const auto& [rank, process] : all) {
    std::ifstream maps("/proc/" + std::to_string(process) + "/smaps");
    double held = 0.0;
    bool isVolume = false;
    for (std::string line; std::getline(maps, line);) {
      if (line.find('-') != std::string::npos && line.find(':') > 20) isVolume = line.find(name) != std::string::npos;
      if (isVolume && line.starts_with("Rss:")) held += std::stod(line.substr(4));
    }
    EXPECT_LT(held, 0.6 * whole) << rank;
    sum += held;
  }
  EXPECT_GT(sum, 0.5 * whole);  // or this looks at something else
}

TEST_F(Mpi, NoProcessMakesAllOfABuiltInVolume) {
  const std::string url = startServer({"marschner-lobb", "--volume-size", "640x640x640"});
  for (const char* const angle : {"0", "120"}) succeed({"shot", "--connect", url, "--size", "100x75", "--view-angle", angle, "-o", "a.png"});
  const std::map<int, pid_t> all = processes();
  ASSERT_EQ(all.size(), 4u);
  for (const auto& [rank, process] : all) {
    std::ifstream status("/proc/" + std::to_string(process) + "/status");
    double kibibytes = 0.0;
    for (std::string line; std::getline(status, line);)
      if (line.starts_with("VmHWM:")) kibibytes = std::stod(line.substr(6));
    EXPECT_GT(kibibytes, 0.0);
    EXPECT_LT(kibibytes, 250.0 * 1024) << "of 250 MiB of voxels, beside all else: " << rank;
  }
}

}  // namespace
}  // namespace warpscope

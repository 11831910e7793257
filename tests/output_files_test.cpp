// Output that is there whole or not at all: what success, failure and giving up leave on the disk.
// Mirrors app/shell/output_files.h.
#include "app/shell/output_files.h"

#include <fcntl.h>
#include <gmock/gmock.h>
#include <sys/stat.h>
#include <sys/wait.h>
#include <unistd.h>

#include <csignal>
#include <fstream>
#include <functional>
#include <thread>

#include "render/base/error.h"
#include "render/volume/reader.h"
#include "tests/complaint.h"
#include "tests/test_folder.h"

namespace warpscope {
namespace {

namespace fs = std::filesystem;
using testing::HasSubstr;
using testing::IsEmpty;
using testing::UnorderedElementsAre;

class OutputFiles : public testing::Test {
 protected:
  static std::vector<std::string> namesIn(const fs::path& folder) {
    std::vector<std::string> names;
    for (const auto& entry : fs::directory_iterator(folder)) names.push_back(entry.path().filename().string());
    return names;
  }
  const TestFolder folder_;
  const fs::path root_ = folder_.path();
};

TEST_F(OutputFiles, WritesAndReplacesWhole) {
  const std::string bytes("a\0b\r\n\xff", 6);
  writeFileWhole(root_ / "f", bytes);
  EXPECT_EQ(contentOf(root_ / "f"), bytes);
  writeFileWhole(root_ / "f", "");
  EXPECT_EQ(contentOf(root_ / "f"), "");
  EXPECT_THAT(namesIn(root_), UnorderedElementsAre("f"));
}

TEST_F(OutputFiles, NamesMayBeAsLongAsTheSystemTakes) {
  const std::string name = std::string(251, 'n') + ".png";
  writeFileWhole(root_ / name, "1");
  EXPECT_EQ(contentOf(root_ / name), "1");
  requireWritable(root_ / name);
  EXPECT_THROW(writeFileWhole(root_ / ("x" + name), "1"), InputError);
  EXPECT_THAT(namesIn(root_), UnorderedElementsAre(name));
}

TEST_F(OutputFiles, WhatIsAddedByOthersComesWithTheRest) {
  {
    StagedFolder folder(root_);
    folder.write("a", "1");
    std::ofstream(folder.placeOf("b")) << "2";
    std::ofstream(folder.placeOf("scratch")) << "3";
    folder.add("b");
    folder.commit();
  }
  EXPECT_THAT(namesIn(root_), UnorderedElementsAre("a", "b"));
  EXPECT_EQ(contentOf(root_ / "b"), "2");
  StagedFolder folder(root_);
  folder.add("never written");
  EXPECT_THROW(folder.commit(), InputError);
}

TEST_F(OutputFiles, WhatIsReadIsNotWrittenByWhateverName) {
  std::ofstream(root_ / "volume") << "voxels";
  fs::create_symlink(root_ / "volume", root_ / "link");
  fs::create_hard_link(root_ / "volume", root_ / "other");
  for (const char* name : {"volume", "link", "other", "./volume"}) EXPECT_THROW(requireNoneOf(root_ / name, {"", root_ / "none", root_ / "volume"}), UsageError) << name;
  EXPECT_NO_THROW(requireNoneOf(root_ / "new", {root_ / "volume"}));
  EXPECT_NO_THROW(requireNoneOf(root_ / "volume", {"", root_ / "none"}));
}

TEST_F(OutputFiles, WhatAHeaderNamesIsReadAsWell) {
  const auto mayBeWritten = [&](const char* name, const char* read) {
    try {
      requireNoneOf(root_ / name, {root_ / read});
    } catch (const UsageError&) {
      return false;
    }
    return true;
  };
  std::ofstream(root_ / "a.raw") << "12345678";
  std::ofstream(root_ / "b.raw") << "12345678";
  std::ofstream(root_ / "meta.mhd") << "ObjectType = Image\nNDims = 3\nDimSize = 2 2 2\nElementType = MET_UCHAR\nElementDataFile = a.raw\n";
  std::ofstream(root_ / "nrrd.nhdr") << "NRRD0004\ntype: uint8\ndimension: 3\nsizes: 2 2 2\nencoding: raw\ndata file: a.raw\n";
  std::ofstream(root_ / "list.nhdr") << "NRRD0004\ntype: uint8\ndimension: 3\nsizes: 2 2 4\nencoding: raw\ndata file: LIST\na.raw\nb.raw\n";
  std::ofstream(root_ / "damaged.nhdr") << "nothing";
  if (filesOfVolume(root_ / "meta.mhd").size() == 1) GTEST_SKIP() << "built without ITK: there are no headers";
  EXPECT_FALSE(mayBeWritten("a.raw", "meta.mhd"));
  EXPECT_TRUE(mayBeWritten("b.raw", "meta.mhd"));
  EXPECT_FALSE(mayBeWritten("a.raw", "nrrd.nhdr"));
  EXPECT_FALSE(mayBeWritten("a.raw", "list.nhdr"));
  EXPECT_FALSE(mayBeWritten("b.raw", "list.nhdr"));
  EXPECT_TRUE(mayBeWritten("b.raw", "damaged.nhdr"));
  EXPECT_FALSE(mayBeWritten("damaged.nhdr", "damaged.nhdr"));
}

TEST_F(OutputFiles, SeveralAreWrittenOrNone) {
  writeFileWhole(root_ / "a", "old");
  fs::create_directory(root_ / "folder");
  for (const fs::path& bad : {fs::path("/dev/full"), root_ / "none" / "b", root_ / "folder"}) {
    EXPECT_THROW(writeFilesWhole({{root_ / "a", "new"}, {root_ / "c", "new"}, {bad, "new"}}), InputError) << bad;
    EXPECT_EQ(contentOf(root_ / "a"), "old") << bad;
    EXPECT_THAT(namesIn(root_), UnorderedElementsAre("a", "folder")) << bad;
  }
  writeFilesWhole({{root_ / "a", "new"}, {root_ / "c", "other"}});
  EXPECT_EQ(contentOf(root_ / "a"), "new");
  EXPECT_EQ(contentOf(root_ / "c"), "other");
  EXPECT_THAT(namesIn(root_), UnorderedElementsAre("a", "c", "folder"));
}

TEST_F(OutputFiles, ALinkToWhatIsNotThereYetIsFollowed) {
  fs::create_symlink("next", root_ / "link");
  fs::create_symlink("target", root_ / "next");
  writeFileWhole(root_ / "link", "1");
  EXPECT_TRUE(fs::is_symlink(root_ / "link"));
  EXPECT_EQ(contentOf(root_ / "target"), "1");
  fs::create_symlink(root_ / "nowhere" / "file", root_ / "lost");
  EXPECT_THROW(writeFileWhole(root_ / "lost", "1"), InputError);
  EXPECT_TRUE(fs::is_symlink(root_ / "lost"));
  fs::create_symlink("round", root_ / "round");
  EXPECT_THROW(writeFileWhole(root_ / "round", "1"), InputError);
}

TEST_F(OutputFiles, WhatThisProcessHasOpenIsWrittenBehindWhatIsThere) {
  const fs::path log = root_ / "log";
  std::ofstream(log) << "kept\n";
  const int file = ::open(log.c_str(), O_WRONLY | O_APPEND);
  ASSERT_GE(file, 0);
  const std::string name = "/dev/fd/" + std::to_string(file);
  fs::create_symlink(name, root_ / "link");
  EXPECT_NO_THROW(requireWritable(name));
  writeFileWhole(name, "more\n");
  writeFileWhole(root_ / "link", "by a link\n");
  ::close(file);
  EXPECT_EQ(contentOf(log), "kept\nmore\nby a link\n");
  const int reading = ::open(log.c_str(), O_RDONLY);
  EXPECT_THROW(writeFileWhole("/dev/fd/" + std::to_string(reading), "x"), InputError);
  ::close(reading);
}

TEST_F(OutputFiles, FailedWritesNameThePathAndChangeNothing) {
  std::ofstream(root_ / "file") << "old";
  fs::create_directory(root_ / "folder");
  for (const fs::path& path : {root_ / "absent" / "f", root_ / "file" / "f", root_ / "folder", fs::path("/proc/warpscope-test"),
                               root_ / std::string(300, 'n')}) {
    EXPECT_THAT(complaintOf([&] { writeFileWhole(path, "new"); }), HasSubstr(path.string() + ": cannot be written"));
  }
  EXPECT_THAT(namesIn(root_), UnorderedElementsAre("file", "folder"));
  EXPECT_EQ(contentOf(root_ / "file"), "old");
  EXPECT_THAT(namesIn(root_ / "folder"), IsEmpty());
}

TEST_F(OutputFiles, PermissionsOfWhatIsReplacedStay) {
  const auto permissionsOf = [&](const char* name) { return fs::status(root_ / name).permissions(); };
  for (const auto mode : {fs::perms(0600), fs::perms(0640), fs::perms(0666)}) {
    for (const char* name : {"alone", "staged"}) {
      std::ofstream(root_ / name) << "old";
      fs::permissions(root_ / name, mode);
    }
    writeFileWhole(root_ / "alone", "new");
    StagedFolder folder(root_);
    folder.write("staged", "new");
    folder.commit();
    for (const char* name : {"alone", "staged"}) {
      EXPECT_EQ(permissionsOf(name), mode) << name;
      EXPECT_EQ(contentOf(root_ / name), "new") << name;
    }
  }
  std::ofstream(root_ / "usual") << "x";
  writeFileWhole(root_ / "other", "x");
  EXPECT_EQ(permissionsOf("other"), permissionsOf("usual"));
}

/// The superuser may write to every file; then the file's permissions stay.
TEST_F(OutputFiles, FilesThatAreProtectedAreNotReplaced) {
  std::ofstream(root_ / "file") << "old";
  fs::permissions(root_ / "file", fs::perms(0444));
  if (access((root_ / "file").c_str(), W_OK) == 0) {
    writeFileWhole(root_ / "file", "new");
    EXPECT_EQ(contentOf(root_ / "file"), "new");
  } else {
    for (const auto& attempt : {std::function([&] { requireWritable(root_ / "file"); }), std::function([&] { writeFileWhole(root_ / "file", "new"); }),
                                std::function([&] { StagedFolder folder(root_, {"other", "file"}); }), std::function([&] {
                                  StagedFolder folder(root_);
                                  folder.write("file", "new");
                                  folder.commit();
                                })})
      EXPECT_THAT(complaintOf(attempt), testing::StartsWith((root_ / "file").string() + ": cannot be written: "));
    EXPECT_EQ(contentOf(root_ / "file"), "old");
  }
  EXPECT_EQ(fs::status(root_ / "file").permissions(), fs::perms(0444));
  EXPECT_THAT(namesIn(root_), UnorderedElementsAre("file"));
}

TEST_F(OutputFiles, LinksInACircleAreNotReplaced) {
  fs::create_symlink("b", root_ / "a");
  fs::create_symlink("a", root_ / "b");
  for (const auto& attempt : {std::function([&] { requireWritable(root_ / "a"); }), std::function([&] { writeFileWhole(root_ / "a", "new"); })})
    EXPECT_THAT(complaintOf(attempt), HasSubstr((root_ / "a").string() + ": cannot be written: "));
  EXPECT_TRUE(fs::is_symlink(root_ / "a"));
  EXPECT_THAT(namesIn(root_), UnorderedElementsAre("a", "b"));
}

TEST_F(OutputFiles, StoppedWritesChangeNothing) {
  std::ofstream(root_ / "file") << "old";
  std::stop_source stopped;
  stopped.request_stop();
  for (const char* name : {"file", "absent"})
    EXPECT_THROW(writeFileWhole(root_ / name, "new", stopped.get_token()), OperationCancelled) << name;
  EXPECT_THAT(namesIn(root_), UnorderedElementsAre("file"));
  EXPECT_EQ(contentOf(root_ / "file"), "old");
}

/// Through a pipe, whose reader asks for the stop once the first bytes are there.
TEST_F(OutputFiles, WritesStopInTheMiddle) {
  const fs::path pipe = root_ / "pipe";
  ASSERT_EQ(mkfifo(pipe.c_str(), 0600), 0);
  const std::string bytes(size_t{1} << 26, 'x');
  std::stop_source source;
  size_t arrived = 0;
  {
    std::jthread reader([&] {
      std::ifstream file(pipe, std::ios::binary);
      std::vector<char> piece(1 << 16);
      while (file.read(piece.data(), static_cast<std::streamsize>(piece.size())) || file.gcount() > 0) {
        arrived += static_cast<size_t>(file.gcount());
        source.request_stop();
      }
    });
    EXPECT_THROW(writeFileWhole(pipe, bytes, source.get_token()), OperationCancelled);
  }
  EXPECT_GT(arrived, 0u);
  EXPECT_LT(arrived, bytes.size());
}

TEST_F(OutputFiles, StagedFilesAppearTogether) {
  StagedFolder folder(root_ / "a" / "b");
  folder.write("x", "1");
  folder.write("y", "2");
  EXPECT_FALSE(fs::exists(root_ / "a" / "b" / "x"));
  folder.commit();
  EXPECT_EQ(contentOf(root_ / "a" / "b" / "x"), "1");
  EXPECT_EQ(contentOf(root_ / "a" / "b" / "y"), "2");
}

TEST_F(OutputFiles, CommittedFoldersHoldNothingElseAndStay) {
  std::ofstream(root_ / "x") << "old";
  std::ofstream(root_ / "other") << "kept";
  {
    StagedFolder folder(root_);
    folder.write("x", "new");
    EXPECT_EQ(contentOf(root_ / "x"), "old");
    folder.commit();
  }
  EXPECT_THAT(namesIn(root_), UnorderedElementsAre("x", "other"));
  EXPECT_EQ(contentOf(root_ / "x"), "new");
  EXPECT_EQ(contentOf(root_ / "other"), "kept");
}

TEST_F(OutputFiles, GivingUpLeavesNothingBehind) {
  for (const char* name : {"made", "made/", "made/by/us", "made/by/us/", "made/./by"}) {
    {
      StagedFolder folder(root_ / name);
      folder.write("x", "1");
      EXPECT_TRUE(fs::is_directory(root_ / "made"));
    }
    EXPECT_THAT(namesIn(root_), IsEmpty()) << name;
  }
}

TEST_F(OutputFiles, GivingUpKeepsWhatWasThere) {
  fs::create_directory(root_ / "was");
  std::ofstream(root_ / "was" / "x") << "old";
  try {
    StagedFolder folder(root_ / "was" / "new");
    folder.write("x", "1");
    StagedFolder beside(root_ / "was");
    beside.write("x", "2");
    throw InputError("the work failed");
  } catch (const InputError&) {
  }
  EXPECT_THAT(namesIn(root_ / "was"), UnorderedElementsAre("x"));
  EXPECT_EQ(contentOf(root_ / "was" / "x"), "old");
}

TEST_F(OutputFiles, FoldersThatOthersFilledStay) {
  {
    StagedFolder folder(root_ / "made");
    std::ofstream(root_ / "made" / "guest") << "g";
  }
  EXPECT_THAT(namesIn(root_ / "made"), UnorderedElementsAre("guest"));
}

TEST_F(OutputFiles, UnusableFoldersAreNamedAndLeaveNothing) {
  std::ofstream(root_ / "file") << "old";
  for (const fs::path& path : {root_ / "file", root_ / "file" / "sub", fs::path("/proc/warpscope-test/sub"), fs::path("/proc"),
                               root_ / "made" / std::string(300, 'n')})
    EXPECT_THAT(complaintOf([&] { StagedFolder folder(path); }), HasSubstr(path.string())) << path;
  EXPECT_NE(complaintOf([] { StagedFolder folder(fs::path{}); }), "");
  EXPECT_THAT(namesIn(root_), UnorderedElementsAre("file"));
  EXPECT_EQ(contentOf(root_ / "file"), "old");
}

TEST_F(OutputFiles, ALinkToNowhereStays) {
  fs::create_symlink("nowhere", root_ / "link");
  EXPECT_NE(complaintOf([&] { StagedFolder folder(root_ / "link"); }), "");
  EXPECT_TRUE(fs::is_symlink(root_ / "link"));
}

TEST_F(OutputFiles, FailedStagedWritesNameTheFinalPath) {
  {
    StagedFolder folder(root_ / "made");
    const std::string name(300, 'n');
    EXPECT_THAT(complaintOf([&] { folder.write(name, "1"); }), HasSubstr((root_ / "made" / name).string()));
  }
  EXPECT_THAT(namesIn(root_), IsEmpty());
}

TEST_F(OutputFiles, CommitsThatCannotBeWholeChangeNothing) {
  // One of the names is taken by a folder: none of the files may be replaced.
  fs::create_directory(root_ / "m");
  const std::vector<std::string> names{"a", "b", "c", "d", "e", "w", "x", "y", "z"};
  for (const std::string& name : names) std::ofstream(root_ / name) << "old";
  {
    StagedFolder folder(root_);
    folder.write("m", "new");
    for (const std::string& name : names) folder.write(name, "new");
    EXPECT_THAT(complaintOf([&] { folder.commit(); }), HasSubstr((root_ / "m").string()));
  }
  EXPECT_EQ(namesIn(root_).size(), names.size() + 1);
  for (const std::string& name : names) EXPECT_EQ(contentOf(root_ / name), "old") << name;
}

/// Something takes away a staged file, so that a move in the middle fails.
TEST_F(OutputFiles, CommitsThatFailHalfWayAreTakenBack) {
  const std::vector<std::string> names{"a", "b", "new", "m", "x", "y"};
  for (const std::string& name : names)
    if (name != "new") std::ofstream(root_ / name) << "old";
  fs::create_symlink("x", root_ / "link");
  {
    StagedFolder folder(root_);
    folder.write("link", "new");
    for (const std::string& name : names) folder.write(name, "new");
    for (const auto& entry : fs::directory_iterator(root_))
      if (entry.is_directory()) fs::remove(entry.path() / "m");
    EXPECT_THAT(complaintOf([&] { folder.commit(); }), testing::StartsWith((root_ / "m").string() + ": cannot be written: "));
  }
  EXPECT_THAT(namesIn(root_), UnorderedElementsAre("a", "b", "m", "x", "y", "link"));
  for (const std::string& name : namesIn(root_)) EXPECT_EQ(contentOf(root_ / name), "old") << name;
  EXPECT_TRUE(fs::is_symlink(root_ / "link"));
}

/// In a folder with the sticky bit only a file's owner may replace it. The superuser may everything and becomes somebody else for the
/// while, in a process of its own.
TEST_F(OutputFiles, CommitsOverFilesOfOthersAreTakenBack) {
  if (geteuid() != 0) GTEST_SKIP() << "only the superuser can make a file of somebody else";
  fs::permissions(root_, fs::perms::all | fs::perms::sticky_bit);
  std::ofstream(root_ / "foreign") << "old";
  const pid_t child = fork();
  ASSERT_GE(child, 0);
  if (child == 0) {
    constexpr uid_t kNobody = 65534;
    if (setuid(kNobody) != 0) _exit(2);
    std::ofstream(root_ / "mine") << "old";
    StagedFolder folder(root_);
    for (const char* name : {"mine", "new", "foreign", "z"}) folder.write(name, "new");
    const std::string complaint = complaintOf([&] { folder.commit(); });
    _exit(complaint.find("foreign: cannot be written") != std::string::npos && contentOf(root_ / "mine") == "old" ? 0 : 1);
  }
  int status = 0;
  ASSERT_EQ(waitpid(child, &status, 0), child);
  EXPECT_TRUE(WIFEXITED(status) && WEXITSTATUS(status) == 0) << status;
  EXPECT_EQ(contentOf(root_ / "foreign"), "old");
  EXPECT_FALSE(fs::exists(root_ / "new"));
  EXPECT_FALSE(fs::exists(root_ / "z"));
}

TEST_F(OutputFiles, WhatCannotBeReplacedIsNoticedBeforeTheWork) {
  fs::create_directories(root_ / "was" / "y");
  EXPECT_EQ(complaintOf([&] { StagedFolder folder(root_ / "was", {"x", "y"}); }), (root_ / "was" / "y").string() + ": cannot be written: it is a folder");
  EXPECT_THAT(namesIn(root_ / "was"), UnorderedElementsAre("y"));
  EXPECT_EQ(complaintOf([&] { StagedFolder folder(root_ / "was", {"x"}); }), "");
}

/// What a process that is killed leaves is removed by the next one; what one that lives has gathered is not.
TEST_F(OutputFiles, WhatKilledWritersLeftGoes) {
  const pid_t child = fork();
  ASSERT_GE(child, 0);
  if (child == 0) {
    StagedFolder folder(root_);
    folder.write("x", "1");
    raise(SIGKILL);
  }
  ASSERT_EQ(waitpid(child, nullptr, 0), child);
  ASSERT_EQ(namesIn(root_).size(), 1u);
  const fs::path kept = root_ / ".partial-0123abcd" / ".replaced" / "x";  // what was there before, and could not be put back
  fs::create_directories(kept.parent_path());
  std::ofstream(kept) << "old";
  fs::create_directory(root_ / ".partial-of-somebody");
  StagedFolder living(root_);
  living.write("y", "1");
  const std::vector<std::string> before = namesIn(root_);
  EXPECT_EQ(before.size(), 3u);
  {
    StagedFolder folder(root_);
    EXPECT_EQ(namesIn(root_).size(), 4u);
  }
  EXPECT_THAT(namesIn(root_), testing::UnorderedElementsAreArray(before));
  living.commit();
  EXPECT_EQ(contentOf(root_ / "y"), "1");
  EXPECT_THAT(namesIn(root_), UnorderedElementsAre("y", ".partial-0123abcd", ".partial-of-somebody"));
  EXPECT_EQ(contentOf(kept), "old");
}

TEST_F(OutputFiles, CommittedFoldersAreCleanBeforeTheyAreGivenUp) {
  StagedFolder folder(root_);
  folder.write("x", "1");
  folder.commit();
  EXPECT_THAT(namesIn(root_), UnorderedElementsAre("x"));
}

TEST_F(OutputFiles, WritesFromSeveralThreads) {
  StagedFolder folder(root_);
  {
    std::vector<std::jthread> threads;
    for (int i = 0; i < 8; ++i)
      threads.emplace_back([&folder, i] { folder.write("f" + std::to_string(i), std::string(100000, static_cast<char>('a' + i))); });
  }
  folder.commit();
  for (int i = 0; i < 8; ++i) EXPECT_EQ(contentOf(root_ / ("f" + std::to_string(i))), std::string(100000, static_cast<char>('a' + i)));
}

}  // namespace
}  // namespace warpscope

// What is left of the machine's memory, from folders that look like a kernel's.
// Mirrors render/base/memory.h.
#include "render/base/memory.h"

#include <gmock/gmock.h>

#include "render/base/error.h"
#include "render/base/memory_limit.h"
#include "render/core/image.h"
#include "tests/test_folder.h"

namespace warpscope {
namespace {

class Memory : public testing::Test {
 protected:
  void put(const std::string& name, const std::string& text) const {
    std::filesystem::create_directories((folder_.path() / name).parent_path());
    folder_.write(name, text);
  }
  std::optional<uint64_t> available() const { return availableMemoryBytes(folder_.path()); }
  const TestFolder folder_;
};

TEST_F(Memory, IsWhatTheMachineHasLeft) {
  EXPECT_EQ(available(), std::nullopt);
  put("proc/meminfo", "MemTotal:       32000000 kB\nMemFree:         1000000 kB\nMemAvailable:    8000000 kB\n");
  EXPECT_EQ(available(), uint64_t{8000000} * 1024);
}

TEST_F(Memory, OrWhatTheNarrowestGroupLeaves) {
  put("proc/meminfo", "MemAvailable:    8000000 kB\n");
  put("proc/self/cgroup", "0::/outer/inner\n");
  put("sys/fs/cgroup/outer/inner/memory.max", "max\n");
  put("sys/fs/cgroup/outer/inner/memory.current", "3000\n");
  EXPECT_EQ(available(), uint64_t{8000000} * 1024);
  put("sys/fs/cgroup/outer/memory.max", "10000\n");
  put("sys/fs/cgroup/outer/memory.current", "7000\n");
  EXPECT_EQ(available(), 3000u);
  // Pages of files are given back when they are needed.
  put("sys/fs/cgroup/outer/memory.stat", "anon 4000\ninactive_file 2000\nactive_file 500\n");
  EXPECT_EQ(available(), 5500u);
  put("sys/fs/cgroup/outer/inner/memory.max", "3500\n");
  EXPECT_EQ(available(), 500u);
  put("sys/fs/cgroup/outer/inner/memory.current", "4000\n");  // a limit that was lowered
  EXPECT_EQ(available(), 0u);
}

TEST_F(Memory, GroupsOfVersion1AreKnownAsWell) {
  put("proc/meminfo", "MemAvailable:    8000000 kB\n");
  put("proc/self/cgroup", "5:cpu,cpuacct:/job\n4:hugetlb,memory:/job\n0::/\n");
  put("sys/fs/cgroup/memory/job/memory.limit_in_bytes", "9223372036854771712\n");
  put("sys/fs/cgroup/memory/job/memory.usage_in_bytes", "5000\n");
  EXPECT_EQ(available(), uint64_t{8000000} * 1024);
  put("sys/fs/cgroup/memory/job/memory.limit_in_bytes", "20000\n");
  put("sys/fs/cgroup/memory/job/memory.stat", "cache 4000\ntotal_inactive_file 1000\n");
  EXPECT_EQ(available(), 16000u);
}

TEST(RequireMemory, SaysWhatIsNeededAndWhatIsThere) {
  ASSERT_TRUE(availableMemoryBytes()) << "this system does not say what it has";
  EXPECT_NO_THROW(requireMemory(1 << 20, "a"));
  std::string text;
  try {
    requireMemory(uint64_t{3} << 50, "a.nrrd:");
  } catch (const InputError& error) {
    text = error.what();
  }
  EXPECT_THAT(text, testing::StartsWith("a.nrrd: needs 3 PiB of memory, and "));
  EXPECT_THAT(text, testing::HasSubstr("are free"));
}

TEST(RequireMemory, KeepsToTheLimitThatWasSet) {
  EXPECT_FALSE(memoryLimit());
  const ResidentMemory before = residentMemory();
  EXPECT_GT(before.ownBytes, 0u);
  EXPECT_GT(before.bytes, before.ownBytes) << "of files there are the program's own at least";
  setMemoryLimit(before.ownBytes + (uint64_t{100} << 20));
  EXPECT_NO_THROW(requireMemory(uint64_t{10} << 20, "it"));
  std::string text;
  try {
    requireMemory(uint64_t{200} << 20, "a.nrrd: it");
  } catch (const InputError& error) {
    text = error.what();
  }
  EXPECT_THAT(text, testing::StartsWith("a.nrrd: it needs 200 MiB of memory, and of the "));
  setMemoryLimit(std::nullopt);
  EXPECT_NO_THROW(requireMemory(uint64_t{200} << 20, "it"));
}

TEST(MemoryLimit, OfWhatItHasNoRoomForSlicesAreKeptAtATime) {
  constexpr uint64_t kMiB = 1 << 20;
  EXPECT_EQ(slicesAtATime(4 * kMiB, 1024), 1024u) << "without a limit";
  setMemoryLimit(1024 * kMiB);
  EXPECT_EQ(slicesAtATime(4 * kMiB, 1024), 32u) << "an eighth of the limit";
  EXPECT_EQ(slicesAtATime(4 * kMiB, 64), 64u) << "a quarter of it: there is room for all";
  EXPECT_EQ(slicesAtATime(4 * kMiB, 65), 32u);
  EXPECT_EQ(slicesAtATime(64 * kMiB, 1000), 8u) << "a cell needs so many";
  EXPECT_EQ(slicesAtATime(1024 * kMiB, 3), 3u);
  setMemoryLimit(std::nullopt);
}

TEST(MemoryLimit, WhatCanBeDroppedIsKnownAndCalledWhereMemoryIsShort) {
  constexpr uint64_t kMiB = 1 << 20;
  const int one = 0, other = 0;
  int dropped = 0;
  {
    const Droppable droppable(&one, [&] { ++dropped; }, [](uint64_t) { return 0; });
    EXPECT_TRUE(isDroppable(&one));
    EXPECT_FALSE(isDroppable(&other));
    setMemoryLimit(residentMemory().bytes + (uint64_t{4096} * kMiB));
    keepWithinMemoryLimit();
    EXPECT_EQ(dropped, 0);
    setMemoryLimit(residentMemory().bytes);  // a share of it is to be free
    keepWithinMemoryLimit();
    EXPECT_EQ(dropped, 1);
    EXPECT_THROW(Droppable(&other, [] {}, [](uint64_t) { return 16 * kMiB; }), InputError);
    EXPECT_FALSE(isDroppable(&other));
  }
  EXPECT_FALSE(isDroppable(&one));
  setMemoryLimit(std::nullopt);
}

TEST(MemoryLimit, WhatIsSaidToDoDoes) {
  constexpr uint64_t kMiB = 1 << 20;
  const int memory = 0;
  // An eighth of the limit and something more, as of a volume's slices.
  const auto atOnce = [](uint64_t limit) { return limit / 8 + 10 * kMiB; };
  setMemoryLimit(residentMemory().bytes + 30 * kMiB);
  std::string text;
  try {
    const Droppable droppable(&memory, [] {}, atOnce);
  } catch (const InputError& error) {
    text = error.what();
  }
  const size_t at = text.find("it takes ");
  ASSERT_NE(at, std::string::npos) << text;
  const auto said = static_cast<uint64_t>(std::stod(text.substr(at + 9)) + 0.999);  // MiB
  EXPECT_THAT(text, testing::EndsWith(" MiB"));
  setMemoryLimit((said + 1) * kMiB);  // this process may have grown by what was said
  EXPECT_NO_THROW(Droppable(&memory, [] {}, atOnce));
  setMemoryLimit((said - 8) * kMiB);
  EXPECT_THROW(Droppable(&memory, [] {}, atOnce), InputError);
  setMemoryLimit(std::nullopt);
}

/// Pictures too large for this machine are refused before any of them is taken.
TEST(RequireMemory, IsAskedForLargePictures) {
  UnfilledAllocator<uint32_t> allocator;
  EXPECT_THROW(allocator.allocate(size_t{1} << 50), InputError);
  uint32_t* const small = allocator.allocate(16);
  ASSERT_NE(small, nullptr);
  allocator.deallocate(small, 16);
  EXPECT_NO_THROW(Image<uint32_t>(8192, 8192));  // 256 MiB: asked for, and there
}

}  // namespace
}  // namespace warpscope

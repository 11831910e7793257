// Small files: nothing that is no file is waited for, and nothing larger than allowed is read.
// Mirrors render/base/input_file.h.
#include "render/base/input_file.h"

#include <gmock/gmock.h>
#include <sys/socket.h>
#include <sys/stat.h>
#include <sys/un.h>
#include <unistd.h>

#include "render/base/error.h"
#include "tests/test_folder.h"

namespace warpscope {
namespace {

using testing::HasSubstr;

class InputFile : public testing::Test {
 protected:
  std::string complaint(const std::filesystem::path& path, uint64_t maxBytes = 100) const {
    try {
      readInputFile(path, maxBytes, "a plan");
    } catch (const InputError& error) {
      return error.what();
    }
    return "";
  }
  const TestFolder folder_;
};

TEST_F(InputFile, IsReadWholeUpToItsLimit) {
  const std::string bytes(100, 'x');
  folder_.write("a", bytes);
  EXPECT_EQ(readInputFile(folder_.file("a"), 100, "a plan"), bytes);
  EXPECT_EQ(complaint(folder_.file("a"), 99), folder_.file("a") + ": is too large for a plan: it holds 100 bytes, at most 99 bytes are read");
  folder_.write("empty", "");
  EXPECT_EQ(readInputFile(folder_.file("empty"), 0, "a plan"), "");
  EXPECT_THAT(complaint(folder_.file("gone")), HasSubstr("gone: there is no such file"));
}

TEST_F(InputFile, WhatIsNoFileIsRefusedAtOnce) {
  ASSERT_EQ(mkfifo(folder_.file("pipe").c_str(), 0600), 0);
  EXPECT_THAT(complaint(folder_.file("pipe")), HasSubstr("pipe: is no regular file but a pipe"));
  EXPECT_THAT(complaint(folder_.path()), HasSubstr(": is a directory, not a plan"));
  EXPECT_THAT(complaint("/dev/zero"), HasSubstr("/dev/zero: is no regular file but a device"));
  sockaddr_un address{};
  address.sun_family = AF_UNIX;
  ASSERT_LT(folder_.file("socket").size(), sizeof address.sun_path);
  folder_.file("socket").copy(address.sun_path, sizeof address.sun_path - 1);
  const int made = socket(AF_UNIX, SOCK_STREAM, 0);
  ASSERT_EQ(bind(made, reinterpret_cast<const sockaddr*>(&address), sizeof address), 0);
  EXPECT_THAT(complaint(folder_.file("socket")), HasSubstr("socket: is no regular file but a socket"));
  close(made);
}

TEST(SizeText, IsInTheUnitThatFits) {
  EXPECT_EQ(sizeText(0), "0 bytes");
  EXPECT_EQ(sizeText(1023), "1023 bytes");
  EXPECT_EQ(sizeText(1024), "1 KiB");
  EXPECT_EQ(sizeText(16 << 20), "16 MiB");
  EXPECT_EQ(sizeText((uint64_t{3} << 30) / 2), "1.5 GiB");
  EXPECT_EQ(sizeText((uint64_t{1} << 40) - 1), "1 TiB");
  EXPECT_EQ(sizeText(UINT64_MAX), "16 EiB");
}

}  // namespace
}  // namespace warpscope

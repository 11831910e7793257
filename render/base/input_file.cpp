// Opening without waiting, and reading no more than is allowed.
// See input_file.h.
#include "render/base/input_file.h"

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <cstdio>
#include <cstring>
#include <iterator>

#include "render/base/error.h"

namespace warpscope {
namespace {

class Descriptor {
 public:
  explicit Descriptor(int number) : number_(number) {}
  ~Descriptor() {
    if (number_ >= 0) ::close(number_);
  }
  Descriptor(const Descriptor&) = delete;
  Descriptor& operator=(const Descriptor&) = delete;
  operator int() const { return number_; }

 private:
  const int number_;
};

[[noreturn]] void fail(const std::filesystem::path& path, const std::string& reason) { throw InputError(path.string() + ": " + reason); }

}  // namespace

std::string readInputFile(const std::filesystem::path& path, uint64_t maxBytes, std::string_view what) {
  const auto failOfSystem = [&] { fail(path, std::string("cannot be read: ") + std::strerror(errno)); };
  // A pipe that nobody writes to, or a device, would be waited for.
  const Descriptor file(::open(path.c_str(), O_RDONLY | O_CLOEXEC | O_NONBLOCK | O_NOCTTY));
  if (file < 0 && errno == ENOENT) fail(path, "there is no such file");
  if (file < 0 && errno == ENXIO) fail(path, "is no regular file but a socket or a device");
  if (file < 0) failOfSystem();
  struct stat status {};
  if (::fstat(file, &status) != 0) failOfSystem();
  if (S_ISDIR(status.st_mode)) fail(path, "is a directory, not " + std::string(what));
  if (!S_ISREG(status.st_mode)) fail(path, std::string("is no regular file but a ") + (S_ISFIFO(status.st_mode) ? "pipe" : "device"));
  const auto refuseSize = [&](uint64_t bytes) {
    fail(path, "is too large for " + std::string(what) + ": it holds " + std::to_string(bytes) + " bytes, at most " + sizeText(maxBytes) + " are read");
  };
  if (static_cast<uint64_t>(status.st_size) > maxBytes) refuseSize(static_cast<uint64_t>(status.st_size));
  std::string bytes;
  bytes.reserve(static_cast<size_t>(status.st_size));
  char piece[1 << 16];
  while (true) {
    const ssize_t count = ::read(file, piece, sizeof piece);
    if (count < 0 && errno == EINTR) continue;
    if (count < 0) failOfSystem();
    if (count == 0) return bytes;
    bytes.append(piece, static_cast<size_t>(count));
    if (bytes.size() > maxBytes) refuseSize(bytes.size());  // it grows, or is one of those that the system makes up
  }
}

std::string sizeText(uint64_t bytes) {
  constexpr const char* kUnits[] = {"bytes", "KiB", "MiB", "GiB", "TiB", "PiB", "EiB"};
  if (bytes < 1024) return std::to_string(bytes) + " bytes";
  auto size = static_cast<double>(bytes);
  size_t unit = 0;
  for (; size >= 1023.95 && unit + 1 < std::size(kUnits); ++unit) size /= 1024.0;
  char text[32];
  std::snprintf(text, sizeof text, "%.1f", size);
  std::string number(text);
  if (number.ends_with(".0")) number.resize(number.size() - 2);
  return number + " " + kUnits[unit];
}

}  // namespace warpscope

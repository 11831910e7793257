// Volume files made up by libFuzzer, for the reader of the format that FUZZED_ENDING stands for: a volume of what the file holds, or an InputError.
// The limits on memory and time are fuzz.sh's. With -close_fd_mask=3, which leaves both standard streams to what is tested, nothing may be written there:
// such lines would reach a terminal.
#include <sys/mman.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cstdint>
#include <cstdlib>
#include <filesystem>
#include <fstream>

#include "render/base/error.h"
#include "render/volume/itk_reader.h"

namespace {

namespace fs = std::filesystem;

/// In memory where the system has such a place, and gone with the process.
struct Folder {
  Folder() {
    std::error_code error;
    const fs::path memory = "/dev/shm";
    path = (fs::is_directory(memory, error) ? memory : fs::temp_directory_path()) / ("warpscope-fuzz-" + std::to_string(getpid()));
    fs::create_directories(path);
  }
  ~Folder() {
    std::error_code ignored;
    fs::remove_all(path, ignored);
  }
  fs::path path;
};

/// The standard streams, if libFuzzer has left them: then they are /dev/null.
struct Streams {
  Streams() {
    struct stat null {}, out {}, err {};
    if (stat("/dev/null", &null) != 0 || fstat(STDOUT_FILENO, &out) != 0 || fstat(STDERR_FILENO, &err) != 0) return;
    if (out.st_rdev != null.st_rdev || err.st_rdev != null.st_rdev) return;
    file = memfd_create("said", 0);
    if (file < 0 || dup2(file, STDOUT_FILENO) < 0 || dup2(file, STDERR_FILENO) < 0) std::abort();
  }
  bool areSilent() const {
    struct stat status {};
    return file < 0 || (fstat(file, &status) == 0 && status.st_size == 0);
  }
  int file = -1;
};

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
  static const Folder folder;
  static const Streams streams;
  const fs::path file = folder.path / ("a" FUZZED_ENDING);
  std::ofstream(file, std::ios::binary | std::ios::trunc).write(reinterpret_cast<const char*>(data), static_cast<std::streamsize>(size));
  try {
    const warpscope::VolumePtr volume = warpscope::openItkVolume(file, {});
    if (volume->voxelCount() == 0 || !volume->voxels()) std::abort();
  } catch (const warpscope::InputError& error) {
    // Names the file, and is a sentence.
    if (!std::string_view(error.what()).starts_with(file.string() + ": ") || std::string_view(error.what()).size() < file.string().size() + 10) std::abort();
  }
  if (!streams.areSilent()) std::abort();
  return 0;
}

// Which file lies where in memory: for whoever is told of an address that could not be read (SIGBUS; sigaction(2), si_addr).
#pragma once

#include <cstddef>
#include <cstdint>
#include <string>

namespace warpscope {

/// A file's bytes lie there, from its first on, for as long as this lives. Of more files than are kept account of, some are not known.
class MappedFileNote {
 public:
  MappedFileNote(const void* memory, uint64_t bytes, const std::string& name);
  ~MappedFileNote();
  MappedFileNote(const MappedFileNote&) = delete;
  MappedFileNote& operator=(const MappedFileNote&) = delete;

 private:
  int place_ = -1;  // none
};

/// Writes "NAME: bytes 4096 to 8191" of the page that the address is in, for as far as there is room; how many characters. 0 where no file is known to lie there.
/// Allowed within a signal handler: takes no lock and no memory. Not while another thread lets go of that file.
size_t nameMappedPage(const void* address, char* text, size_t room) noexcept;

}  // namespace warpscope

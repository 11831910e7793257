// Some places, each of a file or free.
// See mapped_files.h.
#include "render/base/mapped_files.h"

#include <unistd.h>

#include <algorithm>
#include <array>
#include <atomic>
#include <charconv>
#include <cstring>
#include <mutex>

#include "render/base/printable.h"

namespace warpscope {
namespace {

struct MappedPlace {
  std::atomic<uintptr_t> begin = 0;  ///< 0: free
  uint64_t bytes = 0;
  std::array<char, 512> name{};  ///< ends with a zero
};

struct MappedPlaces {
  std::mutex mutex;  ///< of who writes
  std::array<MappedPlace, 64> all;
} mapped;

}  // namespace

MappedFileNote::MappedFileNote(const void* memory, uint64_t bytes, const std::string& name) {
  const std::scoped_lock lock(mapped.mutex);
  const auto place = std::ranges::find_if(mapped.all, [](const MappedPlace& one) { return one.begin == 0; });
  if (place == mapped.all.end()) return;
  const std::string text = printable(name);
  place->bytes = bytes;
  place->name = {};
  std::copy_n(text.begin(), std::min(text.size(), place->name.size() - 1), place->name.begin());
  place->begin = reinterpret_cast<uintptr_t>(memory);
  place_ = static_cast<int>(place - mapped.all.begin());
}

MappedFileNote::~MappedFileNote() {
  if (place_ >= 0) mapped.all[static_cast<size_t>(place_)].begin = 0;
}

size_t nameMappedPage(const void* address, char* text, size_t room) noexcept {
  const auto at = reinterpret_cast<uintptr_t>(address);
  for (const MappedPlace& place : mapped.all) {
    const uintptr_t begin = place.begin;
    if (begin == 0 || at < begin || at - begin >= place.bytes) continue;
    char* const end = text + room;
    char* next = text;
    const auto append = [&](const char* what, size_t length) { next = std::copy_n(what, std::min(length, static_cast<size_t>(end - next)), next); };
    const auto appendNumber = [&](uint64_t number) {
      char digits[20];
      append(digits, static_cast<size_t>(std::to_chars(digits, digits + sizeof digits, number).ptr - digits));
    };
    const uint64_t page = static_cast<uint64_t>(getpagesize()), first = (at - begin) / page * page;
    append(place.name.data(), std::strlen(place.name.data()));
    append(": bytes ", 8);
    appendNumber(first);
    append(" to ", 4);
    appendNumber(std::min(first + page, place.bytes) - 1);
    return static_cast<size_t>(next - text);
  }
  return 0;
}

}  // namespace warpscope

// Drawing the bar.
// See progress.h.
#include "app/progress.h"

#include <algorithm>
#include <cstdio>

#if defined(_WIN32)
#include <io.h>
#else
#include <unistd.h>
#endif

namespace warpscope {
namespace {

bool stderrIsTerminal() {
#if defined(_WIN32)
  return _isatty(_fileno(stderr)) != 0;
#else
  return isatty(fileno(stderr)) != 0;
#endif
}

}  // namespace

Progress::Progress(std::string title, size_t steps, bool quiet)
    : title_(std::move(title)),
      steps_(std::max<size_t>(steps, 1)),
      enabled_(!quiet && stderrIsTerminal()),
      start_(std::chrono::steady_clock::now()) {}

Progress::~Progress() {
  if (drawn_) std::fputs("\r\x1b[K", stderr);  // leaves the line empty for what is printed next
}

void Progress::step(const std::string& what) {
  const size_t now = std::min(done_++, steps_);
  if (!enabled_ || std::chrono::steady_clock::now() - start_ < std::chrono::seconds(1)) return;
  constexpr size_t kWidth = 24;
  const size_t filled = now * kWidth / steps_;
  const std::string bar = std::string(filled, '#') + std::string(kWidth - filled, '.');
  std::fprintf(stderr, "\r\x1b[K%s [%s] %zu/%zu %s", title_.c_str(), bar.c_str(), now, steps_, what.c_str());
  std::fflush(stderr);
  drawn_ = true;
}

}  // namespace warpscope

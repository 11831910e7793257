// Drawing the bar.
// See progress.h.
#include "app/shell/progress.h"

#include <algorithm>

#if defined(_WIN32)
#include <io.h>
#else
#include <signal.h>
#include <unistd.h>
#endif

#include "render/base/printable.h"

namespace warpscope {
namespace {

using std::chrono::steady_clock;

constexpr std::chrono::seconds kDelay(1);
constexpr std::chrono::milliseconds kPeriod(200);

bool isTerminal(std::FILE* file) {
#if defined(_WIN32)
  return _isatty(_fileno(file)) != 0;
#else
  return isatty(fileno(file)) != 0;
#endif
}

/// Where standard error is none; null: nowhere.
std::FILE* controllingTerminal = nullptr;

/// Where bars are drawn that were not told.
std::FILE* usualTerminal() { return controllingTerminal != nullptr && !isTerminal(stderr) ? controllingTerminal : stderr; }

}  // namespace

void showProgressAtControllingTerminal() {
#if !defined(_WIN32)
  if (controllingTerminal == nullptr) controllingTerminal = std::fopen("/dev/tty", "we");
#endif
}

std::string lookingText(const LookedThrough& looked, double elapsedS) {
  constexpr double kGigabyte = 1e9;
  char text[96];
  std::snprintf(text, sizeof text, "%.1f of %.1f GB, %.2f GB/s", static_cast<double>(looked.done) / kGigabyte, static_cast<double>(looked.wanted) / kGigabyte,
                elapsedS > 0.0 ? static_cast<double>(looked.done) / kGigabyte / elapsedS : 0.0);
  return text;
}

std::string remainingText(size_t done, size_t steps, double elapsedS) {
  constexpr size_t kFewestDone = 3;
  constexpr double kShortestS = 3.0;
  if (done < kFewestDone || done >= steps || elapsedS < kShortestS) return "";
  const double leftS = elapsedS * static_cast<double>(steps - done) / static_cast<double>(done);
  char text[64];
  if (leftS < 99.5)
    std::snprintf(text, sizeof text, "about %.0f s left", std::max(1.0, leftS));
  else
    std::snprintf(text, sizeof text, "about %.0f min left", leftS / 60.0);
  return text;
}

Progress::Progress(std::string title, size_t steps, bool quiet, std::FILE* terminal)
    : title_(std::move(title)), steps_(std::max<size_t>(steps, 1)), terminal_(terminal != nullptr ? terminal : usualTerminal()) {
  if (!quiet && isTerminal(terminal_)) thread_ = std::jthread([this](const std::stop_token& stop) { run(stop); });
}

Progress::~Progress() {
  if (!thread_.joinable()) return;
  thread_.request_stop();
  thread_.join();
}

void Progress::step(const std::string& what) {
  const std::scoped_lock lock(mutex_);
  ++begun_;
  what_ = what;
}

void Progress::run(const std::stop_token& stop) {
#if !defined(_WIN32)
  // Who does not have the terminal to itself, as a launcher's processes do not, may be stopped for writing to it (stty tostop).
  sigset_t writes;
  sigemptyset(&writes);
  sigaddset(&writes, SIGTTOU);
  pthread_sigmask(SIG_BLOCK, &writes, nullptr);
#endif
  std::unique_lock lock(mutex_);
  bool isDrawn = false;
  for (auto next = start_ + kDelay; !changed_.wait_until(lock, stop, next, [] { return false; }) && !stop.stop_requested();
       next = steady_clock::now() + kPeriod) {
    constexpr size_t kWidth = 24;
    const size_t done = std::min(begun_ > 0 ? begun_ - 1 : 0, steps_);
    const std::chrono::duration<double> elapsed = steady_clock::now() - start_;
    std::string remaining = remainingText(done, steps_, elapsed.count());
    LookedThrough looked = lookedThrough();
    looked = {looked.wanted - lookedBefore_.wanted, looked.done - lookedBefore_.done};
    const bool isLooking = looked.done < looked.wanted;
    if (isLooking) remaining = lookingText(looked, elapsed.count());
    // A part of the step that is under way.
    const double part = isLooking ? static_cast<double>(looked.done) / static_cast<double>(looked.wanted) : 0.0;
    const auto filled = std::min(static_cast<size_t>((static_cast<double>(done) + part) * kWidth / static_cast<double>(steps_)), kWidth);
    const std::string bar = std::string(filled, '#') + std::string(kWidth - filled, '.');
    std::fprintf(terminal_, "\r\x1b[K%s [%s] %zu/%zu %s (%lld s%s%s)", title_.c_str(), bar.c_str(), done, steps_, printable(what_).c_str(),
                 static_cast<long long>(elapsed.count()), remaining.empty() ? "" : ", ", remaining.c_str());
    std::fflush(terminal_);
    isDrawn = true;
  }
  if (!isDrawn) return;
  std::fputs("\r\x1b[K", terminal_);  // leaves the line empty for what is printed next
  std::fflush(terminal_);
}

}  // namespace warpscope

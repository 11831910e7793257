// A bar on the terminal for work that takes longer than a second.
// Written to standard error, and only if that is a terminal, or to the process's own; ECMA-48 control sequences.
#pragma once

#include <chrono>
#include <condition_variable>
#include <cstdio>
#include <mutex>
#include <string>
#include <thread>

#include "render/base/looked_through.h"

namespace warpscope {

/// "3.2 of 17.2 GB, 1.1 GB/s": of voxels that are looked through.
std::string lookingText(const LookedThrough& looked, double elapsedS);

/// "about 40 s left", "about 3 min left": if the steps to come take as long as those that are done. Empty while those are too few to tell.
std::string remainingText(size_t done, size_t steps, double elapsedS);

/// From now on, where standard error is no terminal, the terminal that the process belongs to is drawn on, if it has one (tty(4), /dev/tty): MPI's launchers keep standard error
/// for themselves. Before there are threads.
void showProgressAtControllingTerminal();

/// Draws itself from a thread of its own, so that it also moves while one step takes long. While volumes are looked through, it says how far that is, and how fast it goes.
class Progress {
 public:
  /// `steps` is how often step() will be called. Nothing is shown if `quiet`, or for the first second, or if `terminal` is none; null: on standard error.
  Progress(std::string title, size_t steps, bool quiet, std::FILE* terminal = nullptr);
  ~Progress();
  Progress(const Progress&) = delete;
  Progress& operator=(const Progress&) = delete;

  /// Says what is done next.
  void step(const std::string& what);

 private:
  void run(const std::stop_token& stop);

  const std::string title_;
  const size_t steps_;
  std::FILE* const terminal_;
  const LookedThrough lookedBefore_ = lookedThrough();
  const std::chrono::steady_clock::time_point start_ = std::chrono::steady_clock::now();
  std::mutex mutex_;  // of the next three
  size_t begun_ = 0;
  std::string what_;
  std::condition_variable_any changed_;
  std::jthread thread_;  // none if nothing is to be shown
};

}  // namespace warpscope

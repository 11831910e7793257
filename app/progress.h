// A bar on the terminal for work that takes longer than a second.
// Written to standard error, and only if that is a terminal.
#pragma once

#include <chrono>
#include <string>

namespace warpscope {

class Progress {
 public:
  /// `steps` is how often step() will be called. Nothing is shown if `quiet`, or for the first second.
  Progress(std::string title, size_t steps, bool quiet);
  ~Progress();
  Progress(const Progress&) = delete;
  Progress& operator=(const Progress&) = delete;

  /// Says what is done next.
  void step(const std::string& what);

 private:
  std::string title_;
  size_t steps_;
  size_t done_ = 0;
  bool enabled_;
  bool drawn_ = false;
  std::chrono::steady_clock::time_point start_;
};

}  // namespace warpscope

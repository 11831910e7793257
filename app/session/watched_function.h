// A transfer function's file that is read again whenever it has been written. In the background: it may be large, or lie where looking at it takes its time.
#pragma once

#include <chrono>
#include <filesystem>
#include <functional>
#include <memory>
#include <optional>
#include <string>

#include "render/base/clock.h"
#include "render/base/newest_worker.h"
#include "render/core/transfer_function.h"

namespace warpscope {

class WatchedFunction {
 public:
  using TimePoint = Clock::TimePoint;
  /// From one look at the file to the next.
  static constexpr std::chrono::milliseconds kPeriod{400};

  /// From now on that file, in which what is there is known. `onNews` is called on another thread when something else was written into it. Empty: none.
  void watch(const std::filesystem::path& path, std::function<void()> onNews);

  struct Written {
    TransferFunction function;
    std::string error;  ///< why it cannot be read; empty if it could
  };
  /// Has it looked at, now and then. What was written into it, once.
  std::optional<Written> follow(TimePoint now);

 private:
  struct Job {
    std::filesystem::path path;
    std::filesystem::file_time_type knownFrom;
  };
  struct Result : Written {
    std::filesystem::file_time_type writtenAt{};
  };

  static void look(const Job& job, Result& result, const std::stop_token& stop);

  std::filesystem::path path_;
  std::filesystem::file_time_type knownFrom_{};
  TimePoint lookedAt_{};
  std::unique_ptr<NewestWorker<Job, Result>> worker_;  // null while there is no file
};

}  // namespace warpscope

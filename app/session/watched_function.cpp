// By the time that the file was written last.
// See watched_function.h.
#include "app/session/watched_function.h"

#include <system_error>
#include <utility>

#include "app/scene/transfer_file.h"
#include "render/base/error.h"

namespace warpscope {

void WatchedFunction::look(const Job& job, Result& result, const std::stop_token& /*stop*/) {
  std::error_code failed;
  result.writtenAt = std::filesystem::last_write_time(job.path, failed);
  if (failed || result.writtenAt == job.knownFrom) throw OperationCancelled();  // there is no news; one that is gone may be about to be replaced
  result.function = readTransferFile(job.path);
}

void WatchedFunction::watch(const std::filesystem::path& path, std::function<void()> onNews) {
  worker_.reset();
  path_ = path;
  if (path.empty()) return;
  std::error_code ignored;
  knownFrom_ = std::filesystem::last_write_time(path, ignored);
  worker_ = std::make_unique<NewestWorker<Job, Result>>([]() -> NewestWorker<Job, Result>::Work { return look; }, std::move(onNews));
}

std::optional<WatchedFunction::Written> WatchedFunction::follow(TimePoint now) {
  if (!worker_) return std::nullopt;
  std::optional<Result> result = worker_->tryTake();
  if (result && result->writtenAt == knownFrom_) result.reset();  // it was looked at twice meanwhile
  if (result) knownFrom_ = result->writtenAt;
  if (now - lookedAt_ >= kPeriod) {
    lookedAt_ = now;
    worker_->post({path_, knownFrom_});
  }
  return result ? std::optional<Written>(std::move(*result)) : std::nullopt;
}

}  // namespace warpscope

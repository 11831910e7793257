// Work that cannot be interrupted, in a thread that can be left alone: libraries that read files, above all.
// A thread that is left ends with its work or with the process, whichever comes first; nothing waits for it.
#pragma once

#include <functional>
#include <future>
#include <memory>
#include <stop_token>
#include <type_traits>

#include "render/base/error.h"

namespace warpscope {

/// Calls `work` in a thread of its own and returns when it has. Once `stop` is set, `work` has a moment to end by itself, and is left alone after that.
/// False if it is left: then it must own all that it uses. It must not throw.
bool runAbandonable(std::function<void()> work, const std::stop_token& stop);

/// Something is left alone that does not say when it has ended.
void noteLeftAlone();

/// Whether anything that was left alone is still at work. A process ends by std::_Exit then: its statics are still in use.
bool isAnythingAbandoned();

/// What `work` returns or throws. It must own all that it uses. Throws OperationCancelled if it is left alone.
template <class Work>
std::invoke_result_t<Work> abandonable(Work work, const std::stop_token& stop) {
  auto task = std::make_shared<std::packaged_task<std::invoke_result_t<Work>()>>(std::move(work));
  auto result = task->get_future();
  if (!runAbandonable([task] { (*task)(); }, stop)) throw OperationCancelled();
  return result.get();
}

}  // namespace warpscope

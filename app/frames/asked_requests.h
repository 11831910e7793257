// Requests by their ids, as those remember them who ask: bounded also where nobody answers, while a camera that moves asks sixty times a second.
#pragma once

#include <cstddef>
#include <cstdint>
#include <iterator>
#include <map>

#include "net/messages.h"

namespace warpscope {

/// Forgets one request where there are more than `most`: the oldest of those that were replaced before they left. The first of all are on show or under way, the last
/// will leave.
template <class Asked>
void forgetReplaced(std::map<uint64_t, Asked>& requests, size_t most) {
  constexpr size_t kNotReplaced = net::kMaxDepth + 16;
  if (requests.size() > most && most >= kNotReplaced) requests.erase(std::next(requests.begin(), kNotReplaced));
}

}  // namespace warpscope

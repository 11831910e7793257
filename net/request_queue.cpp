// A list in the order of turns.
// See request_queue.h.
#include "net/request_queue.h"

#include <algorithm>

namespace warpscope::net {

void RequestQueue::join(ClientId client, uint16_t depth) {
  const std::scoped_lock lock(mutex_);
  clients_.push_back({.id = client, .depth = std::max<uint16_t>(depth, 1), .waiting = {}, .left = {}});
}

void RequestQueue::leave(ClientId client) {
  std::stop_source left(std::nostopstate);
  {
    const std::scoped_lock lock(mutex_);
    const auto found = find(client);
    if (found == clients_.end()) return;
    left = std::move(found->left);
    clients_.erase(found);
  }
  left.request_stop();  // without the lock: it calls what others have hung on it
}

bool RequestQueue::put(ClientId client, const FrameRequest& request, TimePoint arrivedAt) {
  const std::scoped_lock lock(mutex_);
  const auto found = find(client);
  if (found == clients_.end() || request.id <= found->lastId) return false;
  found->lastId = request.id;
  if (found->waiting.size() >= found->depth) found->waiting.pop_back();
  found->waiting.push_back({client, request, arrivedAt, found->left.get_token()});
  callOne();
  return true;
}

std::optional<RequestJob> RequestQueue::take(const std::stop_token& stop) {
  std::unique_lock lock(mutex_);
  Clients::iterator turn = next();
  while (turn == clients_.end() && !stop.stop_requested()) {
    Idle self;
    idle_.push_back(&self);
    self.changed.wait(lock, stop, [&] { return self.isCalled; });
    std::erase(idle_, &self);  // it may not have been called
    turn = next();
  }
  if (stop.stop_requested()) {
    callOne();  // another is to do what this one may have been called for
    return std::nullopt;
  }
  RequestJob job = std::move(turn->waiting.front());
  turn->waiting.pop_front();
  ++turn->atWork;
  turn->isWorkedFor = true;
  clients_.splice(clients_.end(), clients_, turn);
  return job;
}

void RequestQueue::finished(ClientId client, size_t answerBytes) {
  const std::scoped_lock lock(mutex_);
  const auto found = find(client);
  if (found == clients_.end()) return;
  found->isWorkedFor = false;
  found->waitingBytes += answerBytes;
  callOne();
}

void RequestQueue::done(ClientId client, size_t answerBytes) {
  const std::scoped_lock lock(mutex_);
  const auto found = find(client);
  if (found == clients_.end() || found->atWork == 0) return;
  --found->atWork;
  found->waitingBytes -= std::min(found->waitingBytes, answerBytes);
  callOne();
}

bool RequestQueue::isAwaited(ClientId client) const {
  const std::scoped_lock lock(mutex_);
  return std::ranges::any_of(clients_, [&](const Client& one) { return one.id == client && isAwaited(one); });
}

size_t RequestQueue::othersAwaited(ClientId client) const {
  const std::scoped_lock lock(mutex_);
  return static_cast<size_t>(std::ranges::count_if(clients_, [&](const Client& one) { return one.id != client && isAwaited(one); }));
}

size_t RequestQueue::clientCount() const {
  const std::scoped_lock lock(mutex_);
  return clients_.size();
}

size_t RequestQueue::waitingCount(ClientId client) const {
  const std::scoped_lock lock(mutex_);
  const auto found = std::find_if(clients_.begin(), clients_.end(), [&](const Client& one) { return one.id == client; });
  return found == clients_.end() ? 0 : found->waiting.size();
}

RequestQueue::Clients::iterator RequestQueue::find(ClientId client) {
  return std::find_if(clients_.begin(), clients_.end(), [&](const Client& one) { return one.id == client; });
}

void RequestQueue::callOne() {
  if (idle_.empty() || next() == clients_.end()) return;
  Idle* const one = idle_.back();
  idle_.pop_back();
  one->isCalled = true;
  one->changed.notify_one();
}

RequestQueue::Clients::iterator RequestQueue::next() {
  return std::find_if(clients_.begin(), clients_.end(),
                      [](const Client& one) {
                        return !one.waiting.empty() && !one.isWorkedFor && one.atWork < one.depth && one.waitingBytes < kMostWaitingBytes;
                      });
}

}  // namespace warpscope::net

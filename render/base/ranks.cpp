// Collective calls by messages through the first rank, and ranks that are threads.
// See ranks.h.
#include "render/base/ranks.h"

#include <algorithm>
#include <condition_variable>
#include <cstdlib>
#include <mutex>
#include <stdexcept>

#include "render/base/error.h"

namespace warpscope {
namespace {

using namespace std::chrono_literals;

constexpr std::chrono::microseconds kPatience = 100ms;  // between looks at what has come

/// What has been sent to one rank.
struct Inbox {
  std::mutex mutex;
  std::condition_variable changed;
  std::deque<RankMessage> messages;
  bool isWoken = false;
};

class LocalRanks final : public Ranks {
 public:
  LocalRanks(std::shared_ptr<std::vector<Inbox>> inboxes, int rank, bool areNear) : inboxes_(std::move(inboxes)), rank_(rank), areNear_(areNear) {}

  int rank() const override { return rank_; }
  int size() const override { return static_cast<int>(inboxes_->size()); }
  bool isNear(int other) const override { return areNear_ || other == rank_; }
  void send(int to, int kind, std::vector<std::byte> bytes) override {
    Inbox& inbox = (*inboxes_)[static_cast<size_t>(to)];
    const std::scoped_lock lock(inbox.mutex);
    inbox.messages.push_back({rank_, kind, std::move(bytes)});
    inbox.changed.notify_one();
  }
  void wake() override {
    Inbox& own = inbox();
    const std::scoped_lock lock(own.mutex);
    own.isWoken = true;
    own.changed.notify_one();
  }
  void abort(int code) override { std::exit(code); }

 private:
  std::optional<RankMessage> receiveNew(std::chrono::microseconds atMost) override {
    Inbox& own = inbox();
    std::unique_lock lock(own.mutex);
    own.changed.wait_for(lock, atMost, [&] { return own.isWoken || !own.messages.empty(); });
    own.isWoken = false;
    if (own.messages.empty()) return {};
    RankMessage message = std::move(own.messages.front());
    own.messages.pop_front();
    return message;
  }
  Inbox& inbox() const { return (*inboxes_)[static_cast<size_t>(rank_)]; }

  const std::shared_ptr<std::vector<Inbox>> inboxes_;
  const int rank_;
  const bool areNear_;
};

std::vector<std::byte> copyOf(std::span<const std::byte> bytes) { return {bytes.begin(), bytes.end()}; }

}  // namespace

std::optional<RankMessage> Ranks::receive(std::chrono::microseconds atMost) {
  if (kept_.empty()) return receiveOther(atMost);
  RankMessage message = std::move(kept_.front());
  kept_.pop_front();
  return message;
}

std::optional<RankMessage> Ranks::receiveOther(std::chrono::microseconds atMost) {
  std::optional<RankMessage> message = receiveNew(atMost);
  if (!message || message->kind != kLastWord) return message;
  lastWordOf_ = std::min(lastWordOf_, message->from);
  return {};
}

RankMessage Ranks::await(int kind, int from) {
  const auto isIt = [&](const RankMessage& message) { return message.kind == kind && message.from == from; };
  if (const auto found = std::ranges::find_if(kept_, isIt); found != kept_.end()) {
    RankMessage message = std::move(*found);
    kept_.erase(found);
    return message;
  }
  while (true) {
    if (stop_.stop_requested()) throw OperationCancelled();
    std::optional<RankMessage> message = receiveOther(kPatience);
    if (!message) continue;
    if (isIt(*message)) return std::move(*message);
    kept_.push_back(std::move(*message));
  }
}

std::vector<std::byte> Ranks::ofFirst(std::vector<std::byte> own) {
  if (!isFirst()) return await(kDealt, 0).bytes;
  for (int to = 1; to < size(); ++to) send(to, kDealt, own);
  return own;
}

std::vector<std::vector<std::byte>> Ranks::allGather(std::span<const std::byte> own) {
  if (!isTogether_) throw std::logic_error("what takes all voxels of a volume cannot be done where several processes share it");
  std::vector<std::vector<std::byte>> parts(static_cast<size_t>(size()));
  parts[static_cast<size_t>(rank())] = copyOf(own);
  if (!isFirst()) send(0, kGathered, copyOf(own));
  for (int from = 0; from < size(); ++from) {
    std::vector<std::byte>& part = parts[static_cast<size_t>(from)];
    if (isFirst() && from != 0) part = await(kGathered, from).bytes;
    part = ofFirst(std::move(part));
  }
  return parts;
}

void Ranks::requireSame(std::span<const std::byte> own, const std::string& what) {
  const std::vector<std::vector<std::byte>> all = allGather(own);
  for (size_t other = 1; other < all.size(); ++other)
    if (all[other] != all[0]) throw InputError(what + ": process " + std::to_string(other) + " of " + std::to_string(size()) + " has another than the first one");
}

bool Ranks::claimLastWord(std::chrono::milliseconds patience, bool isToldToEnd) {
  // True as soon as one of the first `count` has claimed it.
  const auto hearsOneOf = [&](int count, std::chrono::milliseconds length) {
    const auto end = std::chrono::steady_clock::now() + length;
    while (lastWordOf_ >= count && std::chrono::steady_clock::now() < end) receiveOther(10ms);
    return lastWordOf_ < count;
  };
  if ((!isFirst() || isToldToEnd) && hearsOneOf(size(), patience)) return false;
  for (int to = 0; to < size(); ++to)
    if (to != rank()) send(to, kLastWord, {});
  constexpr std::chrono::milliseconds kTogether(200);  // those that have waited as long
  return isFirst() || !hearsOneOf(rank(), kTogether);
}

std::vector<RanksPtr> makeLocalRanks(int count, bool areNear) {
  const auto inboxes = std::make_shared<std::vector<Inbox>>(static_cast<size_t>(count));
  std::vector<RanksPtr> ranks;
  for (int rank = 0; rank < count; ++rank) ranks.push_back(std::make_shared<LocalRanks>(inboxes, rank, areNear));
  return ranks;
}

}  // namespace warpscope

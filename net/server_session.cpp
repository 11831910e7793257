// A reader, a writer, and what they leave for each other.
// See server_session.h.
#include "net/server_session.h"

#include <algorithm>

#include "net/server.h"

namespace warpscope::net {

ServerSession::ServerSession(std::unique_ptr<Stream> stream, std::string network, const SessionSettings& settings, RequestQueue& queue,
                             const Bytes& scene)
    : network_(std::move(network)),
      settings_(settings),
      queue_(queue),
      scene_(scene),
      channel_(std::move(stream), settings.firstMessagePatience),
      wake_(channel_.stream().executor()),
      writerEnd_(channel_.stream().executor()),
      lastBusy_(now()),
      lastOfUse_(now()),
      awaitedSince_(lastOfUse_) {}

Awaitable<void> ServerSession::write() {
  co_await channel_.write(scene_, "sending the scene");
  TimePoint lastSaid = now();
  while (!isClosed_) {
    const bool isToldOfOthers = (settings_.capabilities & kCanHearBusy) != 0;
    if (pong_) {
      const Bytes message = beatMessage(MessageType::pong, *std::exchange(pong_, std::nullopt));
      co_await channel_.write(message, "sending a heartbeat");
    } else if (!outgoing_.empty()) {
      co_await send(outgoing_.front());
      waitingBytes_ -= outgoing_.front().bytes.size();
      const size_t queuedBytes = outgoing_.front().queuedBytes;
      outgoing_.pop_front();  // and gives its memory back
      lastOfUse_ = lastBusy_ = now();
      queue_.done(settings_.id, queuedBytes);
    } else if (isToldOfOthers && now() - lastBusy_ >= settings_.heartbeat) {
      lastBusy_ = now();
      const size_t others = queue_.isAwaited(settings_.id) ? queue_.othersAwaited(settings_.id) : 0;
      if (others == 0) continue;
      const Bytes message = busyMessage(static_cast<uint16_t>(std::min<size_t>(others, UINT16_MAX)));
      co_await channel_.write(message, "saying that others are served");
    } else if (now() - lastSaid >= settings_.heartbeat) {
      const Bytes message = beatMessage(MessageType::ping, ++pings_);
      co_await channel_.write(message, "sending a heartbeat");
    } else {
      co_await wake_.waitUntil(isToldOfOthers ? std::min(lastSaid, lastBusy_) + settings_.heartbeat : lastSaid + settings_.heartbeat);
      continue;
    }
    lastSaid = now();
  }
}

void ServerSession::put(Outgoing outgoing) {
  // No more than `depth` requests are given out for a client, so no more answers can wait here.
  if (isClosed_ || outgoing_.size() >= settings_.depth) return;
  outgoing_.push_back(fitting(std::move(outgoing)));
  waitingBytes_ += outgoing_.back().bytes.size();
  awaitedSince_ = now();
  wake_.wake();
}

Outgoing ServerSession::fitting(Outgoing outgoing) const {
  if (!outgoing.frame) return outgoing;
  const size_t bytes = frameMessage(*outgoing.frame, outgoing.bytes.size()).size() - kMessageHeadBytes + outgoing.bytes.size();
  if (bytes <= settings_.maxFrameBytes) return outgoing;
  const Failure failure{outgoing.frame->id, "the frame has " + std::to_string(bytes) + " bytes, more than this client takes"};
  return {.frame = {}, .bytes = failureMessage(failure), .readyAt = outgoing.readyAt, .queuedBytes = outgoing.queuedBytes};
}

void ServerSession::close(const std::exception_ptr& why) {
  reason_.add(why);
  isClosed_ = true;
  channel_.stream().abort();
  wake_.wake();
}

void ServerSession::writerEnds(const std::exception_ptr& why) {
  close(why);
  isWriting_ = false;
  outgoing_.clear();
  writerEnd_.wake();
}

Awaitable<void> ServerSession::untilWriterEnds() {
  while (isWriting_) co_await writerEnd_.waitUntil(now() + std::chrono::seconds(1));
}

bool ServerSession::isInUse() const {
  if (longestWait() >= Server::kLongestWait) return false;
  return !outgoing_.empty() || (queue_.isAwaited(settings_.id) && now() - awaitedSince_ < Server::kLongestUse);
}

Duration ServerSession::longestWait() const { return outgoing_.empty() ? Duration(0) : now() - outgoing_.front().readyAt; }

bool ServerSession::onRequest(const FrameRequest& request) {
  channel_.setPatience(settings_.patience);
  lastOfUse_ = now();
  if (!queue_.isAwaited(settings_.id)) lastBusy_ = awaitedSince_ = now();
  wake_.wake();
  return queue_.put(settings_.id, request, now());
}

void ServerSession::onPing(uint64_t number) {
  channel_.setPatience(settings_.patience);
  pong_ = number;  // of several, the last: the answers cannot pile up
  wake_.wake();
}

Awaitable<void> ServerSession::send(const Outgoing& next) {
  if (!next.frame) {
    co_await channel_.write(next.bytes, "sending an answer");
    co_return;
  }
  if (!next.processes.empty() && (settings_.capabilities & kCanHearProcesses) != 0) co_await channel_.write(next.processes, "saying what processes did");
  FrameHead head = *next.frame;
  head.stages.sendMs = millisecondsBetween(next.readyAt, now());
  const Bytes message = frameMessage(head, next.bytes.size());
  co_await channel_.write(message, "sending a frame");
  co_await channel_.write(next.bytes, "sending a frame");
}

}  // namespace warpscope::net

// Two lines with a pump each: one takes what was written to the inner stream when its time has come, one reads ahead of the reader.
// See linked_stream.h.
#include "net/linked_stream.h"

#include <algorithm>
#include <deque>
#include <exception>

#include "net/byte_queue.h"
#include "net/link_model.h"
#include "net/timer.h"

namespace warpscope::net {
namespace {

constexpr size_t kReadBytes = 64 << 10;  // the most that is read at once

/// Until the time has come, or somebody cancels the timer. One waits at a time.
Awaitable<void> waitFor(Timer& timer, TimePoint until) {
  timer.setTo(until);
  co_await timer.wait();
}

/// One direction: bytes, and when they arrive.
class Line {
 public:
  Line(const asio::any_io_executor& executor, LinkSettings settings, uint32_t stream)
      : model(std::move(settings), clockOf(executor).now(), stream), arrival(executor), room(executor) {}

  bool isEmpty() const { return segments_.empty(); }
  size_t sizeBytes() const { return bytes_.size(); }
  size_t roomBytes() const { return model.capacityBytes() - std::min(model.capacityBytes(), bytes_.size()); }
  TimePoint nextArrival() const { return segments_.front().arrivesAt; }

  /// Of `size` bytes, taken from `buffers` after the first `skipped` of them, with `behind` more to follow.
  void push(std::span<const asio::const_buffer> buffers, size_t skipped, size_t size, size_t behind) {
    scratch_.clear();
    model.send(size, arrival.clock().now(), scratch_, behind);
    segments_.insert(segments_.end(), scratch_.begin(), scratch_.end());
    for (const asio::const_buffer& buffer : buffers) {
      const asio::const_buffer part = asio::buffer(buffer + skipped, size);
      skipped -= std::min(skipped, buffer.size());
      bytes_.push(part);
      size -= part.size();
    }
    arrival.cancel();
  }
  /// Something without bytes that arrives in its turn.
  void pushEnd() { push({}, 0, 0, 0); }

  /// How many bytes have arrived, at most `most`; 0 if the next thing is an end.
  size_t arrivedBytes(TimePoint time, size_t most) const {
    size_t count = 0;
    for (const Segment& segment : segments_) {
      if (segment.arrivesAt > time || segment.sizeBytes == 0 || count >= most) break;
      count += segment.sizeBytes;
    }
    return std::min(count, most);
  }
  std::array<asio::const_buffer, 2> front(size_t count) const { return bytes_.front(count); }

  void pop(size_t count) {
    bytes_.pop(count);
    while (count > 0) {
      Segment& first = segments_.front();
      const size_t taken = std::min(count, first.sizeBytes);
      first.sizeBytes -= taken;
      count -= taken;
      if (first.sizeBytes == 0) segments_.pop_front();
    }
    room.cancel();
  }

  void clear() {
    bytes_.clear();
    segments_.clear();
    arrival.cancel();
    room.cancel();
  }

  LinkModel model;
  Timer arrival;  // waited for by who takes, woken by who sends
  Timer room;     // waited for by who sends, woken by who takes
  bool isPumping = false;

 private:
  ByteQueue bytes_;
  std::deque<Segment> segments_;
  std::vector<Segment> scratch_;
};

constexpr uint32_t kUpStream = 0, kDownStream = 1;

}  // namespace

/// Lives as long as somebody works on it: the pumps may outlast the stream by a moment.
struct LinkedStream::State {
  State(std::unique_ptr<Stream> stream, DuplexLinkSettings wanted)
      : inner(std::move(stream)),
        settings(std::move(wanted)),
        clock(clockOf(inner->executor())),
        up(inner->executor(), settings.up, kUpStream),
        down(inner->executor(), settings.down, kDownStream) {}

  void requireOpen(const char* what) const {
    if (isClosed) throw system_error(asio::error::operation_aborted, what + inner->peer());
  }
  bool passesThrough(const Line& line, const LinkSettings& of) const {
    return of.isTransparent() && line.isEmpty() && !line.isPumping;
  }
  void end(bool isAbort) noexcept {
    if (std::exchange(isClosed, true)) return;
    isAbort ? inner->abort() : inner->close();
    up.clear();
    down.clear();
  }

  static void startPumpingUp(const std::shared_ptr<State>& state);
  static void startPumpingDown(const std::shared_ptr<State>& state);
  static Awaitable<void> pumpUp(std::shared_ptr<State> state);
  static Awaitable<void> pumpDown(std::shared_ptr<State> state);

  const std::unique_ptr<Stream> inner;
  DuplexLinkSettings settings;
  Clock& clock;
  Line up, down;
  bool isClosed = false;
  bool isReadingThrough = false;  // the reader waits in the inner stream
  bool hasEnded = false;          // the inner stream has nothing more to read
  std::exception_ptr readError;   // why, if that was no clean end
  std::exception_ptr writeError;
  TimePoint writeErrorAt;  // when it has come back
};

void LinkedStream::State::startPumpingUp(const std::shared_ptr<State>& state) {
  if (std::exchange(state->up.isPumping, true)) return;
  asio::co_spawn(state->inner->executor(), pumpUp(state), asio::detached);
}

void LinkedStream::State::startPumpingDown(const std::shared_ptr<State>& state) {
  if (state->hasEnded || state->isClosed || std::exchange(state->down.isPumping, true)) return;
  asio::co_spawn(state->inner->executor(), pumpDown(state), asio::detached);
}

/// Runs until the line is empty.
Awaitable<void> LinkedStream::State::pumpUp(std::shared_ptr<State> state) {
  Line& line = state->up;
  try {
    while (!state->isClosed && !line.isEmpty()) {
      const size_t count = line.arrivedBytes(state->clock.now(), kReadBytes);
      if (count == 0) {
        co_await waitFor(line.arrival, line.nextArrival());
        continue;
      }
      // The ring may be moved while this waits, as bytes are added: what is written from must not.
      std::vector<std::byte> piece(count);
      asio::buffer_copy(asio::buffer(piece), line.front(count));
      co_await state->inner->write(asio::buffer(piece));
      if (!state->isClosed) line.pop(count);
    }
  } catch (...) {
    state->writeError = std::current_exception();
    state->writeErrorAt = state->down.model.arrivalOf(0, state->clock.now());
    line.clear();
  }
  line.isPumping = false;
  line.room.cancel();
}

/// Runs until the inner stream ends, or until there is nothing left to simulate.
Awaitable<void> LinkedStream::State::pumpDown(std::shared_ptr<State> state) {
  Line& line = state->down;
  std::vector<std::byte> piece(kReadBytes);
  try {
    while (!state->isClosed && !state->settings.down.isTransparent()) {
      // Not by the byte: what is read at once is what follows each other without a pause.
      const size_t leastRoom = std::min(kReadBytes, line.model.capacityBytes() / 4);
      if (line.roomBytes() < leastRoom) {
        co_await waitFor(line.room, TimePoint::max());
        continue;
      }
      const size_t count = co_await state->inner->readSome(asio::buffer(piece, line.roomBytes()));
      if (state->isClosed) break;
      if (count == 0) {
        state->hasEnded = true;
        line.pushEnd();
        break;
      }
      const asio::const_buffer read = asio::buffer(piece, count);
      line.push(std::span(&read, 1), 0, count, 0);
    }
  } catch (...) {
    state->hasEnded = true;
    if (!state->isClosed) {
      state->readError = std::current_exception();
      line.pushEnd();
    }
  }
  line.isPumping = false;
  line.arrival.cancel();
}

LinkedStream::LinkedStream(std::unique_ptr<Stream> inner, DuplexLinkSettings settings)
    : state_(std::make_shared<State>(std::move(inner), std::move(settings))) {
  if (!state_->settings.down.isTransparent()) State::startPumpingDown(state_);
}

LinkedStream::~LinkedStream() { close(); }

Awaitable<size_t> LinkedStream::readSome(asio::mutable_buffer buffer) {
  const std::shared_ptr<State> state = state_;
  Line& line = state->down;
  while (true) {
    state->requireOpen("reading from ");
    if (!line.isEmpty()) {
      const TimePoint time = state->clock.now();
      if (line.nextArrival() > time) {
        co_await waitFor(line.arrival, line.nextArrival());
        continue;
      }
      const size_t count = line.arrivedBytes(time, buffer.size());
      if (count == 0 && state->readError) std::rethrow_exception(state->readError);
      if (count == 0) co_return 0;  // the end stays
      asio::buffer_copy(buffer, line.front(count));
      line.pop(count);
      co_return count;
    }
    if (!state->passesThrough(line, state->settings.down)) {
      State::startPumpingDown(state);
      co_await waitFor(line.arrival, TimePoint::max());
      continue;
    }
    state->isReadingThrough = true;
    size_t count = 0;
    std::exception_ptr failure;
    try {
      count = co_await state->inner->readSome(buffer);
    } catch (const system_error&) {
      failure = std::current_exception();
    }
    state->isReadingThrough = false;
    state->requireOpen("reading from ");
    if (state->settings.down.isTransparent()) {
      if (failure) std::rethrow_exception(failure);
      co_return count;
    }
    // The link was changed while we waited: what came is on it.
    state->readError = failure;
    state->hasEnded = count == 0;
    if (count == 0) {
      line.pushEnd();
      continue;
    }
    const asio::const_buffer read = asio::buffer(buffer, count);
    line.push(std::span(&read, 1), 0, count, 0);
    State::startPumpingDown(state);
  }
}

Awaitable<void> LinkedStream::write(std::span<const asio::const_buffer> buffers) {
  const std::shared_ptr<State> state = state_;
  Line& line = state->up;
  const size_t size = asio::buffer_size(buffers);
  size_t done = 0;
  while (done < size) {
    state->requireOpen("writing to ");
    if (state->writeError) {
      if (state->clock.now() >= state->writeErrorAt) std::rethrow_exception(state->writeError);
      co_return;  // into the void: nobody here can know yet
    }
    if (done == 0 && state->passesThrough(line, state->settings.up)) {
      co_await state->inner->write(buffers);
      co_return;
    }
    const size_t count = std::min(size - done, line.roomBytes());
    if (count == 0) {
      co_await waitFor(line.room, TimePoint::max());
      continue;
    }
    line.push(buffers, done, count, size - done - count);
    done += count;
    State::startPumpingUp(state);
  }
}

Awaitable<void> LinkedStream::finish(TimePoint deadline) {
  const std::shared_ptr<State> state = state_;
  while (state->up.isPumping && !state->isClosed && state->clock.now() < deadline) co_await waitFor(state->up.room, deadline);
  if (!state->isClosed) co_await state->inner->finish(deadline);
  state->end(false);
}

void LinkedStream::close() noexcept { state_->end(false); }
void LinkedStream::abort() noexcept { state_->end(true); }
asio::any_io_executor LinkedStream::executor() { return state_->inner->executor(); }
const std::string& LinkedStream::peer() const { return state_->inner->peer(); }

void LinkedStream::setSettings(DuplexLinkSettings settings) {
  requireValid(settings);
  State& state = *state_;
  const TimePoint time = state.clock.now();
  if (settings.up != state.settings.up) state.up.model.setSettings(settings.up, time);
  if (settings.down != state.settings.down) state.down.model.setSettings(settings.down, time);
  state.settings = std::move(settings);
  state.up.room.cancel();  // there may be more of it now
  state.down.room.cancel();
  if (!state.settings.down.isTransparent() && !state.isReadingThrough) State::startPumpingDown(state_);
}

const DuplexLinkSettings& LinkedStream::settings() const { return state_->settings; }
size_t LinkedStream::bytesUp() const { return state_->up.sizeBytes(); }
size_t LinkedStream::bytesDown() const { return state_->down.sizeBytes(); }

}  // namespace warpscope::net

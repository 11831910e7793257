// Tiles as messages.
// See brick_frame.h.
#include "render/bricks/brick_frame.h"

#include <algorithm>

#include "render/bricks/packed_words.h"
#include "render/bricks/rank_bytes.h"

namespace warpscope {
namespace {

/// Of a ray in a message, beside what follows it.
struct RayHead {
  uint32_t place = 0;  ///< in its tile
  uint32_t counting = 0;  ///< samples that follow
};

/// What rays have that have not met anything: of what they hand on, most is as that, and is not sent. So it has the same bytes wherever it is made, where there is nothing
/// (places for samples that are not there) as well.
struct FreshRay {
  explicit FreshRay(const FrameOrder& order) : segments(mergerRoomFor(order.sample ? order.sample->segments : 0)) {}

  RelayedState state = RelayedState();
  SegmentMerger segments;
  RelayedAgain again = RelayedAgain();
};

/// Of a tile.
struct TileHead {
  uint64_t frame = 0;
  uint32_t tile = 0;
  uint32_t results = 0;
  bool hasSegments = false, isAgain = false, isPacked = false;
};

/// Columns of what rays have, where they are packed.
constexpr size_t kStateColumn = 0, kSegmentsColumn = kStateColumn + wordsOf<RelayedState>, kAgainColumn = kSegmentsColumn + wordsOf<SegmentMerger>;

/// What rays of the tile have gathered, but for those that have ended, unless they go along.
template <class Writer>
void writeRays(Writer& writer, const RelayedTile& tile, const FreshRay& fresh) {
  std::vector<uint8_t> done((tile.rays.size() + 7) / 8);
  for (size_t place = 0; place < tile.rays.size(); ++place)
    if (tile.rays[place].isDone) done[place / 8] |= static_cast<uint8_t>(1u << (place % 8));
  writer.putAll(done);
  for (uint32_t place = 0; place < tile.rays.size(); ++place) {
    const RelayedRay& ray = tile.rays[place];
    if ((ray.isDone && !tile.goesTwice) || !ray.hasMet()) continue;
    writer.put(RayHead{place, static_cast<uint32_t>(ray.counting.size())}).putBeside(ray.state, fresh.state, kStateColumn);
    for (const CountingSample& sample : ray.counting) writer.put(sample);
    if (!tile.segments.empty()) writer.putBeside(tile.segments[place], fresh.segments, kSegmentsColumn);
    if (tile.isAgain) writer.putBeside(tile.again[place], fresh.again, kAgainColumn);
  }
}

/// Back, into a tile without any.
template <class Reader>
void readRays(Reader& reader, RelayedTile& tile, const FreshRay& fresh) {
  std::vector<uint8_t> done;
  reader.getAll(done);
  for (size_t place = 0; place < tile.rays.size(); ++place) tile.rays[place].isDone = (done.at(place / 8) >> (place % 8) & 1) != 0;
  while (!reader.isAtEnd()) {
    const auto head = reader.template get<RayHead>();
    RelayedRay& ray = tile.rays.at(head.place);
    ray.state = reader.getBeside(fresh.state, kStateColumn);
    ray.counting.resize(head.counting);
    for (CountingSample& sample : ray.counting) sample = reader.template get<CountingSample>();
    if (!tile.segments.empty()) tile.segments[head.place] = reader.getBeside(fresh.segments, kSegmentsColumn);
    if (tile.isAgain) tile.again.at(head.place) = reader.getBeside(fresh.again, kAgainColumn);
  }
}

/// What rays of the tile have left since it was taken.
template <class Writer>
void writeFound(Writer& writer, const RelayedTile& tile) {
  const DenseRays& found = tile.found;
  writer.putAll(tile.finished).putAll(tile.colors);
  writer.put(found.slots).putAll(found.samples).putAll(found.colors).putAll(found.spreads);
  writer.put(found.segments.slots).putAll(found.segments.rays).putAll(found.segments.depths).putAll(found.segments.colors).putAll(found.segments.normals);
}

template <class Reader>
void readFound(Reader& reader, TileResult& result) {
  reader.getAll(result.finished);
  reader.getAll(result.colors);
  DenseRays& found = result.found;
  found.slots = reader.template get<size_t>();
  reader.getAll(found.samples);
  reader.getAll(found.colors);
  reader.getAll(found.spreads);
  found.segments.slots = reader.template get<int>();
  reader.getAll(found.segments.rays);
  reader.getAll(found.segments.depths);
  reader.getAll(found.segments.colors);
  reader.getAll(found.segments.normals);
}

}  // namespace

TileResult TileResult::ofBytes(std::span<const std::byte> bytes) {
  RankReader reader(bytes);
  TileResult result;
  result.frame = reader.get<uint64_t>();
  result.tile = reader.get<uint32_t>();
  result.results = reader.get<uint32_t>();
  if (reader.get<bool>()) {
    PackedReader packed(reader.rest());
    readFound(packed, result);
  } else {
    readFound(reader, result);
  }
  return result;
}

BrickFrame::BrickFrame(FrameOrder order, int rank, std::function<void()> onOutgoing, std::function<bool(int)> isNear)
    : order_(std::move(order)), rank_(rank), onOutgoing_(std::move(onOutgoing)), isNear_(std::move(isNear)) {}

void BrickFrame::arrive(std::vector<std::byte> bytes) {
  const std::scoped_lock lock(mutex_);
  arrived_.push_back(std::move(bytes));
  changed_.notify_one();
}

std::optional<BrickFrame::Outgoing> BrickFrame::takeOutgoing() {
  const std::scoped_lock lock(mutex_);
  if (outgoing_.empty()) return {};
  Outgoing outgoing = std::move(outgoing_.front());
  outgoing_.pop_front();
  if (outgoing.to != rank_) work_.sentBytes += outgoing.bytes.size();
  return outgoing;
}

void BrickFrame::put(Outgoing outgoing) {
  {
    const std::scoped_lock lock(mutex_);
    outgoing_.push_back(std::move(outgoing));
  }
  onOutgoing_();
}

void BrickFrame::fail(const std::string& reason) { put({0, kTroubleMessage, RankWriter().put(order_.frame).putAll(reason).take()}); }

void BrickFrame::close() noexcept {
  const std::scoped_lock lock(mutex_);
  isClosed_ = true;
  changed_.notify_all();
}

std::unique_ptr<RelayedTile> BrickFrame::take() {
  const auto from = std::chrono::steady_clock::now();
  std::unique_ptr<RelayedTile> tile = nextTile(true);
  const double fromMs = msSinceBegin(from), toMs = msSinceBegin(std::chrono::steady_clock::now());
  {
    const std::scoped_lock lock(mutex_);
    work_.waitMs += toMs - fromMs;
    work_.timeline.addWait(fromMs, toMs);
  }
  return begun(std::move(tile));
}

std::unique_ptr<RelayedTile> BrickFrame::takeReady() { return begun(nextTile(false)); }

std::unique_ptr<RelayedTile> BrickFrame::begun(std::unique_ptr<RelayedTile> tile) {
  if (tile == nullptr) return tile;
  const std::scoped_lock lock(mutex_);
  ++work_.tiles;
  tile->taken = std::chrono::steady_clock::now();
  return tile;
}

std::unique_ptr<RelayedTile> BrickFrame::nextTile(bool waits) {
  std::unique_lock lock(mutex_);
  while (!isClosed_) {
    // Those that begin here come first: others wait for them.
    for (; nextOwn_ < order_.tileCount(); ++nextOwn_) {
      if (order_.nextOf(nextOwn_, -1) != rank_) continue;
      auto tile = std::make_unique<RelayedTile>();
      tile->index = nextOwn_++;
      lock.unlock();
      tile->area = order_.areaOf(tile->index);
      tile->rays.resize(tile->area.count());
      tile->isLast = order_.nextOf(tile->index, rank_) < 0;
      return tile;
    }
    if (!arrived_.empty()) {
      const std::vector<std::byte> bytes = std::move(arrived_.front());
      arrived_.pop_front();
      lock.unlock();
      return tileOf(bytes);
    }
    if (!waits) break;
    changed_.wait(lock);
  }
  return nullptr;
}

void BrickFrame::handOn(std::unique_ptr<RelayedTile> tile) {
  {
    const double fromMs = msSinceBegin(tile->taken), toMs = msSinceBegin(tile->done.value_or(std::chrono::steady_clock::now()));
    const std::scoped_lock lock(mutex_);
    work_.marchMs += toMs - fromMs;
    work_.timeline.addMarch(fromMs, toMs);
    work_.deviceTiles += tile->isByDevice ? 1 : 0;
  }
  bool isComplete = std::ranges::all_of(tile->rays, &RelayedRay::isDone);
  int next = order_.nextOf(tile->index, rank_);
  if (isComplete && tile->goesTwice && !tile->isAgain) {
    isComplete = !tile->beginAgain();
    next = order_.nextOf(tile->index, -1);
  }
  if (isComplete || !tile->finished.empty()) {
    ++tile->results;
    put({0, kResultMessage, resultOf(*tile, isComplete)});
  }
  if (!isComplete && next >= 0) put({next, kTileMessage, bytesOf(*tile, !isNear_(next))});  // else the march has been stopped
}

std::vector<std::byte> BrickFrame::resultOf(const RelayedTile& tile, bool isComplete) const {
  RankWriter writer;
  const bool isPacked = !isNear_(0);
  writer.put(order_.frame).put(tile.index).put(isComplete ? tile.results : 0u).put(isPacked);
  if (!isPacked) {
    writeFound(writer, tile);
    return writer.take();
  }
  PackedWriter packed;
  writeFound(packed, tile);
  return writer.append(packed.take()).take();
}

std::vector<std::byte> BrickFrame::bytesOf(const RelayedTile& tile, bool isPacked) const {
  RankWriter writer;
  writer.put(TileHead{order_.frame, tile.index, tile.results, !tile.segments.empty(), tile.isAgain, isPacked});
  const FreshRay fresh(order_);
  if (!isPacked) {
    writeRays(writer, tile, fresh);
    return writer.take();
  }
  PackedWriter packed;
  writeRays(packed, tile, fresh);
  return writer.append(packed.take()).take();
}

std::unique_ptr<RelayedTile> BrickFrame::tileOf(const std::vector<std::byte>& bytes) const {
  RankReader reader(bytes);
  const auto head = reader.get<TileHead>();
  auto tile = std::make_unique<RelayedTile>();
  tile->index = head.tile;
  tile->results = head.results;
  tile->isAgain = head.isAgain;
  tile->area = order_.areaOf(tile->index);
  tile->isLast = order_.nextOf(tile->index, rank_) < 0;
  tile->rays.resize(tile->area.count());
  if (tile->isAgain) tile->again.resize(tile->rays.size());
  const FreshRay fresh(order_);
  if (head.hasSegments) tile->segments.assign(tile->rays.size(), fresh.segments);
  if (head.isPacked) {
    PackedReader packed(reader.rest());
    readRays(packed, *tile, fresh);
  } else {
    readRays(reader, *tile, fresh);
  }
  return tile;
}

RankWork BrickFrame::work() const {
  const std::scoped_lock lock(mutex_);
  RankWork work = work_;
  work.frame = order_.frame;
  work.block = block();
  return work;
}

uint64_t BrickFrame::frameOf(const RankMessage& message) { return RankReader(message.bytes).get<uint64_t>(); }

}  // namespace warpscope

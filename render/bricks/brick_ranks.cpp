// Who asks, and who is asked.
// See brick_ranks.h.
#include "render/bricks/brick_ranks.h"

#include <algorithm>
#include <chrono>
#include <condition_variable>
#include <deque>
#include <mutex>
#include <string>
#include <utility>

#include "render/base/error.h"
#include "render/bricks/brick_frame.h"
#include "render/bricks/brick_work.h"
#include "render/bricks/rank_bytes.h"
#include "render/march/march_setup.h"
#include "render/march/piecewise_marcher.h"

namespace warpscope {
namespace {

using namespace std::chrono_literals;

constexpr std::chrono::microseconds kPatience = 100ms;  // between looks at what was asked to stop
constexpr std::chrono::seconds kBetweenSigns(1);         // of life
// When a volume is cut anew, because a rank has more to do than others: for the first frames at once, later not so often that ranks would read their bricks again and again.
constexpr double kMostUneven = 1.25, kLeastMs = 5.0;
constexpr int kQuickRecuts = 6;
constexpr std::chrono::seconds kBetweenRecuts(2);
constexpr std::chrono::milliseconds kGrace(800);         // for the first rank to come to its end

std::vector<std::byte> bytesOf(const TransferFunction& function) { return RankWriter().putAll(function.points).take(); }
TransferFunction functionOf(std::span<const std::byte> bytes) {
  TransferFunction function;
  RankReader(bytes).getAll(function.points);
  return function;
}

/// Sends what the frame has to send. `onOwn` gets what is for this rank itself.
template <class OnOwn>
void sendOutgoing(BrickWork& work, const OnOwn& onOwn) {
  if (work.frame() == nullptr) return;
  while (std::optional<BrickFrame::Outgoing> outgoing = work.frame()->takeOutgoing()) {
    if (outgoing->to == work.ranks().rank())
      onOwn(RankMessage{outgoing->to, outgoing->kind, std::move(outgoing->bytes)});
    else
      work.ranks().send(outgoing->to, outgoing->kind, std::move(outgoing->bytes));
  }
}

/// Lets one in at a time, for std::unique_lock.
class Gate {
 public:
  void lock() {
    std::unique_lock lock(mutex_);
    free_.wait(lock, [&] { return !isTaken_; });
    isTaken_ = true;
  }
  /// Throws OperationCancelled if `stop` is set first.
  void lock(const std::stop_token& stop) {
    std::unique_lock lock(mutex_);
    if (!free_.wait(lock, stop, [&] { return !isTaken_; })) throw OperationCancelled();
    isTaken_ = true;
  }
  bool try_lock() {
    const std::scoped_lock lock(mutex_);
    return !std::exchange(isTaken_, true);
  }
  void unlock() {
    const std::scoped_lock lock(mutex_);
    isTaken_ = false;
    free_.notify_one();
  }

 private:
  std::mutex mutex_;
  std::condition_variable_any free_;
  bool isTaken_ = false;
};

}  // namespace

/// What marchers share. Its calls wait for each other.
class BrickLeader {
 public:
  BrickLeader(VolumePtr volume, std::chrono::milliseconds patience, PieceMaker makePieces)
      : backend_(makePieces.backend), roomBytes_(makePieces.roomBytes), work_(std::move(volume), std::move(makePieces)), patience_(patience), heard_(static_cast<size_t>(work_.ranks().size())), done_(heard_.size()) {
    work_.ranks().setTogether(false);
  }
  /// By which it marches its own brick.
  Backend backend() const { return backend_(); }

  ~BrickLeader() {
    withoutFailing([&] { tellAll(kQuitMessage, {}); });
  }

  uint32_t addFunction(TransferFunction function) {
    const std::unique_lock lock(mutex_);
    forgetUnused();
    uint32_t index = 0;
    if (const std::optional<uint32_t> known = work_.find(function)) {
      index = *known;
    } else {
      together([&] {
        tellAll(kFunctionMessage, bytesOf(function));
        index = work_.addFunction(std::move(function));
      });
    }
    requireRoom(work_.function(index)->macrocells, work_.volume()->dims(), work_.ranks().size());
    const std::scoped_lock usersLock(usersMutex_);
    users_.resize(std::max<size_t>(users_.size(), index + 1));
    ++users_[index];
    return index;
  }
  /// Another one needs what somebody has added. Waits for nobody, as forgetFunction() does not.
  void keepFunction(uint32_t index) {
    const std::scoped_lock usersLock(usersMutex_);
    ++users_.at(index);
  }
  /// One of those who need it does not any more.
  void forgetFunction(uint32_t index) noexcept {
    const std::scoped_lock usersLock(usersMutex_);
    --users_[index];
  }
  MarchedVolumePtr function(uint32_t index) {
    const std::unique_lock lock(mutex_);
    return work_.function(index);
  }
  ProxyPtr proxyFor(uint32_t function, int longest, const std::stop_token& stop) {
    const std::unique_lock lock = lockUnless(stop);
    ProxyPtr proxy;
    // Once all have begun they come to the end together: nobody is left alone with it.
    together([&] {
      tellAll(kProxyMessage, RankWriter().put(function).put(longest).take());
      proxy = work_.proxyFor(function, longest);
    });
    if (stop.stop_requested()) throw OperationCancelled();
    return proxy;
  }

  /// All have what shadows and occlusion are found in from now on.
  void findLight(uint32_t function, const std::stop_token& stop) {
    const std::unique_lock lock = lockUnless(stop);
    if (work_.hasLightCopy(function)) return;
    together([&] {
      tellAll(kLightMessage, RankWriter().put(function).take());
      work_.makeLightCopy(function);
    });
    if (stop.stop_requested()) throw OperationCancelled();
  }

  /// Has the order's picture marched by all; `onResult` gets what its rays leave. Of the order, frame, blocks, their order and routes are found here.
  /// Throws WorkLimitExceeded where it takes longer than `limit`, if that is more than 0.
  template <class OnResult>
  void march(FrameOrder order, std::chrono::nanoseconds limit, const std::stop_token& stop, const OnResult& onResult) {
    const std::unique_lock lock = lockUnless(stop);
    forgetUnused();
    const Volume& volume = *work_.volume();
    const MarchedVolume& marched = *work_.function(order.function);
    order.frame = ++frame_;
    takeWorkThatCame();
    const BrickTree& tree = treeFor(marched, order.render);
    order.blocks = tree.blocks();
    const glm::vec3 edges = volume.geometry().voxelEdges();
    order.nearToFar = tree.nearToFar((order.camera.eye - volume.bounds().lower) * (1.0f / edges) - 0.5f);  // as VolumeView has it
    const auto from = std::chrono::steady_clock::now();
    const EndOfFrame end(*this);
    tellAll(kOrderMessage, order.bytes());
    findRoutes(order, volume);
    const uint32_t tiles = order.tileCount();
    uint32_t left = 0;
    for (uint32_t tile = 0; tile < tiles; ++tile)
      if (order.nextOf(tile, -1) >= 0) ++left;
    if (left == 0) return;
    // Of each tile, results that have come and that there are, once that is known: what two ranks send may come in any order.
    std::vector<uint32_t> come(tiles), wanted(tiles);

    std::string trouble;
    const auto take = [&](RankMessage message) {
      if (message.kind == kWorkMessage) return takeWork(message);
      if (message.kind < kTileMessage || message.kind > kTroubleMessage || BrickFrame::frameOf(message) != frame_) return;  // of one that was given up
      if (message.kind == kTileMessage) return work_.frame()->arrive(std::move(message.bytes));
      if (message.kind == kTroubleMessage) {
        RankReader reader(message.bytes);
        reader.get<uint64_t>();
        reader.getAll(trouble);
        return;
      }
      const TileResult result = TileResult::ofBytes(message.bytes);
      onResult(result);
      ++come.at(result.tile);
      if (result.results > 0) wanted[result.tile] = result.results;
      if (come[result.tile] == wanted[result.tile]) --left;
    };
    const uint32_t all = left;
    work_.begin(std::move(order));
    {
      const std::stop_callback onStop(stop, [this] { work_.ranks().wake(); });
      std::ranges::fill(heard_, std::chrono::steady_clock::now());
      while (left > 0 && trouble.empty() && !stop.stop_requested()) {
        sendOutgoing(work_, take);
        if (left == 0) break;
        if (limit.count() > 0 && std::chrono::steady_clock::now() - from > limit) throw WorkLimitExceeded(limit, 1.0 - static_cast<double>(left) / all);
        if (std::optional<RankMessage> message = work_.ranks().receive(kPatience)) {
          heard_[static_cast<size_t>(message->from)] = std::chrono::steady_clock::now();
          take(std::move(*message));
        } else if (const int silent = silentRank(); silent > 0) {
          trouble = "process " + std::to_string(silent) + " of " + std::to_string(work_.ranks().size()) + " does not answer";
        }
      }
    }
    if (stop.stop_requested()) throw OperationCancelled();
    if (!trouble.empty()) throw InputError(trouble);
  }

  std::vector<RankWork> lastWork() {
    const std::unique_lock lock(mutex_);
    const auto end = std::chrono::steady_clock::now() + 1s;
    const auto isOther = [&](const RankWork& work) { return work.frame != frame_; };
    while (std::ranges::any_of(done_, isOther) && std::chrono::steady_clock::now() < end)
      if (std::optional<RankMessage> message = work_.ranks().receive(kPatience); message && message->kind == kWorkMessage) takeWork(*message);
    return done_;
  }

  /// Of each rank, for the last frame that it said it of. Waits for nobody.
  std::vector<RankWork> knownWork() {
    if (const std::unique_lock lock(mutex_, std::try_to_lock); lock) takeWorkThatCame();
    const std::scoped_lock lock(doneMutex_);
    return done_;
  }

 private:
  /// Where it fails, what ranks know of each other is not known any more: all end.
  template <class Work>
  void withoutFailing(const Work& work) noexcept {
    try {
      work();
      return;
    } catch (const OperationCancelled&) {
      work_.ranks().complain("stopped while all processes were at something together");
    } catch (const std::exception& error) {
      work_.ranks().complain(error.what());
    } catch (...) {
      work_.ranks().complain("something that all processes were at together has failed");
    }
    work_.ranks().abort(1);
  }
  /// What all ranks do at the same time.
  template <class Work>
  void together(const Work& work) {
    const Together all(work_.ranks());
    withoutFailing(work);
  }

  /// However a frame ends.
  struct EndOfFrame {
    explicit EndOfFrame(BrickLeader& leader) : leader_(leader) {}
    ~EndOfFrame() {
      leader_.withoutFailing([&] {
        if (const std::optional<RankWork> own = leader_.work_.end()) leader_.note(0, *own);
        leader_.tellAll(kEndMessage, RankWriter().put(leader_.frame_).take());
      });
    }
    EndOfFrame(const EndOfFrame&) = delete;
    EndOfFrame& operator=(const EndOfFrame&) = delete;

   private:
    BrickLeader& leader_;
  };

  /// Throws OperationCancelled if `stop` is set before it is this one's turn.
  std::unique_lock<Gate> lockUnless(const std::stop_token& stop) {
    mutex_.lock(stop);
    return {mutex_, std::adopt_lock};
  }

  void forgetUnused() {
    const std::scoped_lock usersLock(usersMutex_);
    for (uint32_t index = 0; index < users_.size(); ++index) {
      if (users_[index] > 0 || !work_.function(index)) continue;
      tellAll(kForgetMessage, RankWriter().put(index).take());
      work_.forgetFunction(index);
    }
  }

  /// One that has said nothing for too long; 0 if there is none.
  int silentRank() const {
    const auto now = std::chrono::steady_clock::now();
    for (size_t other = 1; other < heard_.size(); ++other)
      if (now - heard_[other] > patience_) return static_cast<int>(other);
    return 0;
  }
  /// Behind the last frame; nothing else that comes there is of use.
  void takeWorkThatCame() {
    while (std::optional<RankMessage> message = work_.ranks().receive(0us))
      if (message->kind == kWorkMessage) takeWork(*message);
  }
  void takeWork(const RankMessage& message) { note(message.from, RankReader(message.bytes).get<RankWork>()); }
  void note(int rank, const RankWork& work) {
    const std::scoped_lock lock(doneMutex_);
    done_[static_cast<size_t>(rank)] = work;
  }

  void tellAll(int kind, const std::vector<std::byte>& bytes) {
    for (int to = 1; to < work_.ranks().size(); ++to) work_.ranks().send(to, kind, bytes);
  }

  const BrickTree& treeFor(const MarchedVolume& marched, const RenderSettings& settings) {
    const std::shared_ptr<const BakedTransfer> baked = marched.bakedFor(settings);
    const auto now = std::chrono::steady_clock::now();
    if (baked != treeOf_ || !tree_) {
      weights_ = weightsOfVisible(baked->emptyDistances);
      recuts_ = 0;
      treeOf_ = baked;
    } else if (isUneven() && (recuts_ < kQuickRecuts || now - cutAt_ > kBetweenRecuts)) {
      std::vector<double> costs;
      for (const RankWork& work : done_) costs.push_back(work.marchMs);
      weighByCost(weights_, marched.macrocells, tree_->blocks(), costs);
      ++recuts_;
    } else {
      return *tree_;
    }
    tree_.emplace(marched.macrocells, weights_, marched.volume->dims(), work_.ranks().size(), mostShare(*marched.volume));
    cutAt_ = now;
    firstOfTree_ = frame_;
    return *tree_;
  }

  /// Of the volume's cells, that a block may have: as this rank has room, which is what is known of the others.
  double mostShare(const Volume& volume) const {
    constexpr double kOfRoom = 0.85;  // the rest is for what lies around a block, and for what is not a whole number of macrocells
    const double bytes = static_cast<double>(volume.voxelCount()) * static_cast<double>(std::min<size_t>(sizeBytes(volume.type()), sizeof(float)));  // as devices keep them
    return roomBytes_ > 0 ? std::min(kOfRoom * static_cast<double>(roomBytes_) / bytes, 1.0) : 1.0;
  }

  /// Whether one rank had much more to do than the others, as far as what they did for frames of this tree is known.
  bool isUneven() const {
    double most = 0.0, all = 0.0;
    for (size_t rank = 0; rank < done_.size(); ++rank) {
      const RankWork& work = done_[rank];
      if (work.frame < firstOfTree_ || work.block != tree_->blocks()[rank]) return false;  // it comes while the next frame is marched
      most = std::max(most, work.marchMs);
      all += work.marchMs;
    }
    return most > kLeastMs && most * static_cast<double>(done_.size()) > kMostUneven * all;
  }

  const std::function<Backend()> backend_;
  const uint64_t roomBytes_;
  Gate mutex_;              // of all that follows but the next two
  std::mutex usersMutex_;   // of the next
  std::vector<int> users_;  // of each function
  BrickWork work_;
  const std::chrono::milliseconds patience_;
  std::vector<std::chrono::steady_clock::time_point> heard_;  // of each rank, something: while a frame is marched
  std::mutex doneMutex_;                                      // of what follows, where it is written or others read it
  std::vector<RankWork> done_;                                // by each, for the last frame that it said it of
  uint64_t frame_ = 0;
  std::shared_ptr<const BakedTransfer> treeOf_;  // whose cells that cuts
  std::vector<float> weights_;                   // of these, as far as frames have told
  int recuts_ = 0;
  std::chrono::steady_clock::time_point cutAt_;
  uint64_t firstOfTree_ = 0;  // frame
  std::optional<BrickTree> tree_;
};

namespace {

class RanksMarcher final : public PiecewiseMarcher {
 public:
  RanksMarcher(BrickLeaderPtr leader, TransferFunction function, TurnsPtr turns = nullptr) : RanksMarcher(leader, leader->addFunction(std::move(function)), std::move(turns)) {}
  /// By the same function.
  RanksMarcher(const RanksMarcher& other, TurnsPtr turns) : RanksMarcher(other.leader_, other.kept(), std::move(turns)) {}
  ~RanksMarcher() override { leader_->forgetFunction(function_); }

  Backend backend() const override { return leader_->backend(); }
  MarcherCapabilities capabilities() const override { return {.pace = backend() == Backend::cuda ? MarchPace::followsCamera : MarchPace::afterRest}; }
  using Marcher::twin;
  /// Turns are whole frames: ranks do not stand still for another's.
  MarcherPtr twin(TurnsPtr turns) const override { return std::make_shared<RanksMarcher>(*this, std::move(turns)); }
  MarcherPtr withTransferFunction(TransferFunction function) const override {
    return std::make_shared<RanksMarcher>(leader_, std::move(function), turns_);
  }

 private:
  RanksMarcher(const BrickLeaderPtr& leader, uint32_t function, TurnsPtr turns)
      : PiecewiseMarcher(leader->function(function), "the volume is spread over several processes"), leader_(leader), turns_(std::move(turns)), function_(function) {}

  uint32_t kept() const {
    leader_->keepFunction(function_);
    return function_;
  }

  ProxyPtr proxyFor(int longest, const std::stop_token& stop) override { return leader_->proxyFor(function_, longest, stop); }

  void marchTiles(const Camera& camera, const RenderSettings& settings, const std::optional<SampleSettings>& sample, const std::stop_token& stop,
                  const OnOutcome& onOutcome) override {
    FrameOrder order;
    order.function = function_;
    order.camera = camera;
    order.render = settings;
    order.sample = sample;
    if (needsLightCopy(settings)) leader_->findLight(function_, stop);
    const std::chrono::nanoseconds limit = turns_ ? turns_->settings().limit : std::chrono::nanoseconds(0);
    leader_->march(order, limit, stop, [&](const TileResult& result) { onOutcome({areaOfTile(camera, result.tile), result.finished, result.found, result.colors}); });
  }

  const BrickLeaderPtr leader_;
  const TurnsPtr turns_;
  const uint32_t function_;
};

}  // namespace

BrickLeaderPtr leadRanks(VolumePtr volume, std::chrono::milliseconds patience, PieceMaker makePieces) {
  return std::make_shared<BrickLeader>(std::move(volume), patience, std::move(makePieces));
}

std::vector<RankWork> lastWork(const BrickLeaderPtr& leader) { return leader->lastWork(); }

std::vector<RankWork> knownWork(const BrickLeaderPtr& leader) { return leader->knownWork(); }

MarcherPtr makeRanksMarcher(BrickLeaderPtr leader, TransferFunction transferFunction) {
  return std::make_shared<RanksMarcher>(std::move(leader), std::move(transferFunction));
}

bool followRanks(const VolumePtr& volume, const std::stop_token& stop, PieceMaker makePieces) {
  BrickWork work(volume, std::move(makePieces));
  work.ranks().setTogether(false);
  std::deque<RankMessage> early;  // tiles of frames that this rank has not been told of yet
  const auto deliver = [&](RankMessage message) {
    const uint64_t frame = BrickFrame::frameOf(message);
    if (work.frame() != nullptr && frame == work.frame()->order().frame) return work.frame()->arrive(std::move(message.bytes));
    early.push_back(std::move(message));
  };
  const auto endFrame = [&] {
    if (const std::optional<RankWork> done = work.end()) work.ranks().send(0, kWorkMessage, RankWriter().put(*done).take());
  };
  std::optional<std::chrono::steady_clock::time_point> end;
  auto saidAlive = std::chrono::steady_clock::now();
  while (true) {
    if (stop.stop_requested() && !end) end = std::chrono::steady_clock::now() + kGrace;
    if (end && std::chrono::steady_clock::now() >= *end) return false;
    sendOutgoing(work, deliver);
    if (const auto now = std::chrono::steady_clock::now(); work.frame() != nullptr && now - saidAlive > kBetweenSigns) {
      work.ranks().send(0, kAliveMessage, RankWriter().put(work.frame()->order().frame).take());
      saidAlive = now;
    }
    std::optional<RankMessage> message = work.ranks().receive(kPatience);
    if (!message) continue;
    switch (message->kind) {
      case kFunctionMessage: {
        const Together all(work.ranks());
        work.addFunction(functionOf(message->bytes));
        break;
      }
      case kForgetMessage: work.forgetFunction(RankReader(message->bytes).get<uint32_t>()); break;
      case kProxyMessage: {
        RankReader reader(message->bytes);
        const auto function = reader.get<uint32_t>();
        const Together all(work.ranks());
        work.proxyFor(function, reader.get<int>());
        break;
      }
      case kLightMessage: {
        const Together all(work.ranks());
        work.makeLightCopy(RankReader(message->bytes).get<uint32_t>());
        break;
      }
      case kOrderMessage: {
        endFrame();
        FrameOrder order = FrameOrder::ofBytes(message->bytes);
        findRoutes(order, *volume);
        work.begin(std::move(order));
        std::deque<RankMessage> waiting = std::exchange(early, {});
        for (RankMessage& tile : waiting)
          if (BrickFrame::frameOf(tile) >= work.frame()->order().frame) deliver(std::move(tile));
        break;
      }
      case kTileMessage: deliver(std::move(*message)); break;
      case kEndMessage: endFrame(); break;
      case kQuitMessage: return true;
      default: throw std::runtime_error("a message between processes is of an unknown kind");
    }
  }
}

}  // namespace warpscope

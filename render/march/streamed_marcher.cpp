// All tiles through a slab, and what is left of them through the next.
// See streamed_marcher.h.
#include "render/march/streamed_marcher.h"

#include <algorithm>
#include <mutex>
#include <utility>
#include <vector>

#include "render/march/depth_of_samples.h"
#include "render/march/marcher_cpu.h"
#include "render/march/piecewise_marcher.h"
#include "render/volume/kept_slices.h"
#include "render/volume/proxy.h"

namespace warpscope {
namespace {

using Tiles = std::vector<std::unique_ptr<RelayedTile>>;

/// Cells of a volume: between voxels, one where there is but one voxel.
glm::ivec3 cellsOf(const Volume& volume) { return glm::max(glm::ivec3(volume.dims()) - 1, 1); }

/// Of at most so many slices of cells, what the transfer function shows anything in: the box around it.
std::vector<CellBlock> visibleSlabs(const MarchedVolume& marched, const BakedTransfer& baked, int most) {
  const Macrocells& cells = marched.macrocells;
  const glm::ivec3 all = cellsOf(*marched.volume), dims = cells.dims();
  std::vector<CellBlock> slabs;
  for (int lower = 0; lower < all.z; lower += most) {
    const int upper = std::min(lower + most, all.z);
    CellBlock slab{all, glm::ivec3(0)};
    for (int z = lower / cells.edge(); z * cells.edge() < upper && z < dims.z; ++z)
      for (int y = 0; y < dims.y; ++y)
        for (int x = 0; x < dims.x; ++x) {
          if (baked.emptyDistances[(static_cast<size_t>(z) * static_cast<size_t>(dims.y) + static_cast<size_t>(y)) * static_cast<size_t>(dims.x) + static_cast<size_t>(x)] > 0) continue;
          const glm::ivec3 corner = glm::ivec3(x, y, z) * cells.edge();
          slab.lower = glm::min(slab.lower, corner);
          slab.upper = glm::max(slab.upper, corner + cells.edge());
        }
    slab.lower.z = std::max(slab.lower.z, lower);
    slab.upper = glm::min(slab.upper, glm::ivec3(all.x, all.y, upper));
    if (glm::all(glm::lessThan(slab.lower, slab.upper))) slabs.push_back(slab);
  }
  return slabs;
}

/// All of the volume, in as many slices.
std::vector<CellBlock> allSlabs(const Volume& volume, int most) {
  const glm::ivec3 all = cellsOf(volume);
  std::vector<CellBlock> slabs;
  for (int lower = 0; lower < all.z; lower += most) slabs.push_back({{0, 0, lower}, {all.x, all.y, std::min(lower + most, all.z)}});
  return slabs;
}

/// Tiles whose rays have room for what they gather. No fewer than keep all cores at work.
uint32_t tilesAtATime(const StreamRoom& room, const std::optional<SampleSettings>& sample) {
  constexpr uint64_t kLeast = 64, kListed = 256;  // samples of a ray that a list keeps, where there is one
  uint64_t bytesOfRay = sizeof(RelayedRay);
  if (sample) bytesOfRay += (hasOnePass(sample->heuristic) && sample->samplesPerRay == 1 ? 0 : kListed * sizeof(CountingSample)) + (sample->segments > 0 ? sizeof(SegmentMerger) + sizeof(RelayedAgain) : 0);
  return static_cast<uint32_t>(std::clamp<uint64_t>(room.rayBytes / (bytesOfRay * kRelayedSide * kRelayedSide), kLeast, std::numeric_limits<uint32_t>::max()));
}

/// The nearest first: slabs on one side of the eye are in their order, and no ray comes through slabs on both.
void sortNearToFar(std::vector<CellBlock>& slabs, float eye) {
  const auto away = [&](const CellBlock& slab) { return std::max({static_cast<float>(slab.lower.z) - eye, eye - static_cast<float>(slab.upper.z), 0.0f}); };
  std::ranges::stable_sort(slabs, [&](const CellBlock& a, const CellBlock& b) { return away(a) < away(b); });
}

/// Each of these tiles once; what is left of them afterwards.
class SlabRelay final : public RayRelay {
 public:
  /// `onOutcome` must stay.
  SlabRelay(const CellBlock& block, Tiles tiles, bool isLast, const std::function<void(const PieceOutcome&)>& onOutcome) : block_(block), isLast_(isLast), tiles_(std::move(tiles)), onOutcome_(onOutcome) {}

  const CellBlock& block() const override { return block_; }
  std::unique_ptr<RelayedTile> take() override {
    std::unique_lock lock(mutex_);
    if (isClosed_ || next_ == tiles_.size()) return nullptr;
    std::unique_ptr<RelayedTile> tile = std::move(tiles_[next_++]);
    tile->isLast = isLast_;
    lock.unlock();
    tile->rays.resize(tile->area.count());  // of a new one: on all threads
    return tile;
  }
  std::unique_ptr<RelayedTile> takeReady() override { return take(); }
  void handOn(std::unique_ptr<RelayedTile> tile) override {
    const bool isDone = std::ranges::all_of(tile->rays, &RelayedRay::isDone), goesOn = !isDone || (tile->goesTwice && !tile->isAgain && tile->beginAgain());
    const std::scoped_lock lock(mutex_);
    if (!tile->finished.empty()) onOutcome_({tile->area, tile->finished, tile->found, tile->colors});
    if (!goesOn) return;
    tile->finished.clear(), tile->found = {}, tile->colors.clear();
    (isDone ? again_ : left_).push_back(std::move(tile));
  }
  void close() noexcept override {
    const std::scoped_lock lock(mutex_);
    isClosed_ = true;
  }

  Tiles takeLeft() { return std::move(left_); }    ///< with rays that have not ended
  Tiles takeAgain() { return std::move(again_); }  ///< that go a second way

 private:
  const CellBlock block_;
  const bool isLast_;
  std::mutex mutex_;  // of what follows
  Tiles tiles_;
  size_t next_ = 0;
  bool isClosed_ = false;
  const std::function<void(const PieceOutcome&)>& onOutcome_;
  Tiles left_, again_;
};

class StreamedMarcher final : public PiecewiseMarcher {
 public:
  StreamedMarcher(MarchedVolumePtr marched, PieceMaker makePieces, const StreamRoom& room, TurnsPtr turns)
      : PiecewiseMarcher(std::move(marched), "the volume is marched slab by slab"),
        makePieces_(std::move(makePieces)),
        room_(room),
        turns_(std::move(turns)),
        pieces_(makePieces_.make(this->marched())),
        hostPieces_(makePieceMarcher(this->marched())),
        whole_(makeCpuMarcherOf(this->marched(), turns_)) {}

  SampleFrame march(const Camera& camera, const MarchSettings& settings, const std::stop_token& stop) override {
    return room_.isForAll || looksAtVisibleAlone(settings.render, settings.sample) ? PiecewiseMarcher::march(camera, settings, stop) : whole_->march(camera, settings, stop);
  }
  void render(const Camera& camera, const RenderSettings& settings, Image<glm::vec4>& image, const std::stop_token& stop) override {
    room_.isForAll || looksAtVisibleAlone(settings, std::nullopt) ? PiecewiseMarcher::render(camera, settings, image, stop) : whole_->render(camera, settings, image, stop);
  }

  Backend backend() const override { return makePieces_.backend(); }
  MarcherCapabilities capabilities() const override { return {}; }
  using Marcher::twin;
  MarcherPtr twin(TurnsPtr turns) const override { return makeStreamedMarcher(marched(), makePieces_, room_, std::move(turns)); }
  MarcherPtr withTransferFunction(TransferFunction function) const override {
    return makeStreamedMarcher(std::make_shared<const MarchedVolume>(*marched(), std::move(function)), makePieces_, room_, turns_);
  }

 private:
  /// Whether a cell that shows nothing needs not be looked at, nor anything that does not lie on the ray.
  bool looksAtVisibleAlone(const RenderSettings& settings, const std::optional<SampleSettings>& sample) const {
    if (!whyNotInPieces(settings).empty() || settings.effects.mode != RenderMode::composite) return false;
    const EffectPlan plan = *this->plan(settings, sample);
    return !plan.has(PlanStage::segments) && !plan.has(PlanStage::lightVolume);
  }

  ProxyPtr proxyFor(int longest, const std::stop_token& stop) override { return marched()->proxyFor(longest, stop); }

  void marchTiles(const Camera& camera, const RenderSettings& settings, const std::optional<SampleSettings>& sample, const std::stop_token& stop,
                  const OnOutcome& onOutcome) override {
    const std::shared_ptr<const BakedTransfer> baked = marched()->bakedFor(settings);
    const Volume& volume = *this->volume();
    const int cells = std::max(room_.slices - 1 - 2 * marginOf(settings, volume.geometry(), 2), 1);
    const bool isVisibleEnough = looksAtVisibleAlone(settings, sample);
    if (baked != slabsOf_ || cells != slabCells_ || isVisibleEnough != areVisibleAlone_) {
      // Where segments are lit, and they may reach over what shows nothing, is in no box around what is visible.
      slabsAgain_ = allSlabs(volume, cells);
      slabs_ = isVisibleEnough ? visibleSlabs(*marched(), *baked, cells) : slabsAgain_;
      slabsOf_ = baked;
      slabCells_ = cells;
      areVisibleAlone_ = isVisibleEnough;
    }
    if (room_.isForAll && needsLightCopy(settings) && !hasLightCopy_) {
      const auto copy = std::make_shared<const Proxy>(makeProxy(volume, marched()->transferFunction, kLightCopyEdge, CopyFilter::means, stop));
      pieces_->setLightCopy(copy);
      hostPieces_->setLightCopy(copy);
      hasLightCopy_ = true;
    }
    for (std::vector<CellBlock>* const slabs : {&slabs_, &slabsAgain_}) sortNearToFar(*slabs, (camera.eye.z - volume.bounds().lower.z) / volume.geometry().voxelEdges().z - 0.5f);
    const uint32_t all = tilesOf(camera), atATime = tilesAtATime(room_, sample);
    uint32_t firstTile = 0, endTile = 0;  // of those under way
    Tiles tiles, again;
    size_t slab = 0;
    bool isAgain = false, goesTwice = false;
    const auto beginNextTiles = [&] {
      firstTile = endTile;
      endTile += std::min(atATime, all - endTile);
      tiles.clear();
      for (uint32_t tile = firstTile; tile < endTile; ++tile) {
        auto& next = tiles.emplace_back(std::make_unique<RelayedTile>());
        next->index = tile;
        next->area = areaOfTile(camera, tile);
      }
    };
    // True once all is done.
    const auto marchNext = [&] {
      while (slab == (isAgain ? slabsAgain_ : slabs_).size() || tiles.empty()) {
        isAgain = !again.empty();
        if (isAgain)
          tiles = std::exchange(again, {});
        else if (endTile < all)
          beginNextTiles();
        else
          return true;
        slab = 0;
      }
      const std::vector<CellBlock>& slabs = isAgain ? slabsAgain_ : slabs_;
      const auto held = volume.hold(rowsOf(slabs[slab], settings, volume.geometry()), stop);
      SlabRelay relay(slabs[slab], std::move(tiles), slab + 1 == slabs.size(), onOutcome);
      (isAgain ? *hostPieces_ : *pieces_).marchPieces(camera, settings, sample ? &*sample : nullptr, relay, stop);  // the second would have to copy all of the volume
      ++slab;
      tiles = relay.takeLeft();
      for (std::unique_ptr<RelayedTile>& tile : relay.takeAgain()) again.push_back(std::move(tile));
      goesTwice = isAgain || !again.empty() || (!tiles.empty() && tiles.front()->goesTwice);
      return false;
    };
    const auto done = [&] {
      const auto first = static_cast<double>(slabs_.size()), second = goesTwice ? static_cast<double>(slabsAgain_.size()) : 0.0;
      const double ofThese = ((isAgain ? first : 0.0) + static_cast<double>(slab)) / (first + second + 1.0);
      return (firstTile + ofThese * (endTile - firstTile)) / std::max(all, 1u);
    };
    TurnsOfJob turns(turns_.get());
    if (!turns.areLimited()) {
      while (!marchNext()) {
      }
      return;
    }
    const auto marchUntil = [&](std::chrono::steady_clock::time_point end) {
      do
        if (marchNext()) return true;
      while (std::chrono::steady_clock::now() < end);
      return false;
    };
    while (!turns.work(stop, marchUntil, done)) {
    }
  }

  const PieceMaker makePieces_;
  const StreamRoom room_;
  const TurnsPtr turns_;
  const std::unique_ptr<PieceMarcher> pieces_, hostPieces_;
  const MarcherPtr whole_;
  // Of the picture that is marched.
  std::shared_ptr<const BakedTransfer> slabsOf_;  // whose the slabs are
  int slabCells_ = 0;  // of at most so many slices each
  bool areVisibleAlone_ = false;
  std::vector<CellBlock> slabs_, slabsAgain_;  // on the first way, on the second
  bool hasLightCopy_ = false;
};

}  // namespace

MarcherPtr makeStreamedMarcher(MarchedVolumePtr marched, PieceMaker makePieces, const StreamRoom& room, TurnsPtr turns) {
  return std::make_shared<StreamedMarcher>(std::move(marched), std::move(makePieces), room, std::move(turns));
}

MarcherPtr makeFittingCpuMarcher(VolumePtr volume, TransferFunction transferFunction) {
  const uint32_t slices = volume->dims().z, atATime = slicesKept(*volume);
  auto marched = std::make_shared<const MarchedVolume>(std::move(volume), std::move(transferFunction));
  if (atATime == slices) return makeCpuMarcherOf(std::move(marched), nullptr);
  return makeStreamedMarcher(std::move(marched), {}, {.slices = static_cast<int>(atATime), .rayBytes = limitedShare(), .isForAll = true});
}

}  // namespace warpscope

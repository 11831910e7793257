// What relaying rays is measured against: every process marches its brick for all rays, and their pictures are put over one another by MPI_Reduce with an operation of
// the user's, associative and not commutative, in the order in which the eye sees the bricks (MPI Forum, MPI 4.0, 6.9.5). Colours alone: folds of depths and segments are
// not put together so. Both find the same picture up to rounding, and up to what lies behind a ray's early end, which a relayed ray alone leaves out; that is checked.
//   mpirun -n 4 build/reduce_bench SCENE [WIDTHxHEIGHT [XxYxZ of a built-in volume]]
#include <mpi.h>

#include <algorithm>
#include <chrono>
#include <cstdio>
#include <cstdlib>
#include <iostream>
#include <mutex>
#include <stdexcept>
#include <thread>

#include "app/frames/process_ranks.h"
#include "app/scene/scene.h"
#include "render/base/error.h"
#include "render/base/stopwatch.h"
#include "render/bricks/brick_tree.h"
#include "render/march/march_setup.h"
#include "render/march/ray_relay.h"

namespace warpscope {
namespace {

constexpr int kRuns = 9;
constexpr int kWarmUps = 4;         ///< runs before those; during the first the volume is cut anew for relayed rays
constexpr float kRounding = 1e-4f;  ///< of the two pictures
constexpr uint32_t kSide = 32;

/// All tiles of a picture, each for this brick alone.
class OneBrick final : public RayRelay {
 public:
  OneBrick(const CellBlock& block, Image<glm::vec4>& image) : block_(block), image_(image) {}

  const CellBlock& block() const override { return block_; }
  std::unique_ptr<RelayedTile> take() override {
    const std::scoped_lock lock(mutex_);
    const uint32_t columns = (image_.width() + kSide - 1) / kSide, rows = (image_.height() + kSide - 1) / kSide;
    if (next_ >= columns * rows) return nullptr;
    auto tile = std::make_unique<RelayedTile>();
    tile->index = next_++;
    const uint32_t x = tile->index % columns * kSide, y = tile->index / columns * kSide;
    tile->area = {x, y, std::min(kSide, image_.width() - x), std::min(kSide, image_.height() - y)};
    tile->rays.resize(tile->area.count());
    tile->isLast = true;
    return tile;
  }
  std::unique_ptr<RelayedTile> takeReady() override { return take(); }
  void handOn(std::unique_ptr<RelayedTile> tile) override {
    for (size_t i = 0; i < tile->finished.size(); ++i) {
      const uint32_t place = tile->finished[i];
      image_(tile->area.x + place % tile->area.width, tile->area.y + place / tile->area.width) = tile->colors[i];
    }
  }
  void close() noexcept override {}

 private:
  const CellBlock block_;
  Image<glm::vec4>& image_;
  std::mutex mutex_;
  uint32_t next_ = 0;
};

/// Premultiplied colours: those of lower ranks in front.
void over(void* in, void* inOut, int* count, MPI_Datatype* /*type*/) {
  const auto* const front = static_cast<const glm::vec4*>(in);
  auto* const back = static_cast<glm::vec4*>(inOut);
  for (int i = 0; i < *count; ++i) back[i] = front[i] + (1.0f - front[i].a) * back[i];
}

double median(std::vector<double> values) {
  std::ranges::sort(values);
  return values[values.size() / 2];
}

struct Asked {
  std::string scene;
  unsigned width = 1024, height = 1024;
  SceneOverrides overrides;
};

Asked askedBy(int count, char** words) {
  if (count < 2) throw UsageError("reduce_bench SCENE [WIDTHxHEIGHT [XxYxZ]]");
  Asked asked{.scene = words[1], .overrides = {}};
  if (count > 2 && std::sscanf(words[2], "%ux%u", &asked.width, &asked.height) != 2) throw UsageError("the second word is a size such as 1024x1024");
  glm::uvec3 dims;
  if (count > 3) {
    if (std::sscanf(words[3], "%ux%ux%u", &dims.x, &dims.y, &dims.z) != 3) throw UsageError("the third word is a number of voxels such as 256x256x256");
    asked.overrides.proceduralDims = dims;
  }
  return asked;
}

/// The picture by relayed rays; on the first process. Milliseconds of each run.
std::vector<double> relayed(const VolumePtr& volume, const TransferFunction& function, const Camera& camera, const RenderSettings& settings, Image<glm::vec4>& image) {
  std::vector<double> ms;
  const MarcherPtr marcher = makeRanksMarcher(leaderOf(volume, Backend::cpu), function);
  for (int run = 0; run < kRuns + kWarmUps; ++run) {
    const auto from = std::chrono::steady_clock::now();
    marcher->render(camera, settings, image, {});
    if (run >= kWarmUps) ms.push_back(millisecondsSince(from));
  }
  return ms;
}

void run(const Asked& asked) {
  const RanksPtr ranks = joinProcesses();
  if (!ranks) throw UsageError("start it by mpirun");
  SceneOverrides overrides = asked.overrides;
  overrides.ranks = ranks;
  const Scene scene = openScene(asked.scene, overrides);
  const VolumePtr& volume = scene.volume;
  const Camera camera = makeCamera(scene, scene.views.front(), asked.width, asked.height);
  const RenderSettings& settings = scene.march.render;
  Image<glm::vec4> image(camera.width, camera.height), expected;

  const auto marched = std::make_shared<const MarchedVolume>(volume, scene.transferFunction);
  const std::shared_ptr<const BakedTransfer> baked = marched->bakedFor(settings);
  const BrickTree tree(marched->macrocells, weightsOfVisible(baked->emptyDistances), volume->dims(), ranks->size());
  const std::vector<int> order = tree.nearToFar((camera.eye - volume->bounds().lower) * (1.0f / volume->geometry().voxelEdges()) - 0.5f);
  const auto place = std::ranges::find(order, ranks->rank()) - order.begin();
  const CellBlock& block = tree.blocks()[static_cast<size_t>(ranks->rank())];
  volume->provide(rowsOf(block, settings, volume->geometry()));
  // From here on MPI is called beside Ranks, which has to be still: nobody is waited for by it, and what was sent last has come.
  ranks->requireSame({}, "nothing");
  ranks->setTogether(false);
  std::this_thread::sleep_for(std::chrono::milliseconds(300));
  MPI_Comm sorted;
  MPI_Comm_split(MPI_COMM_WORLD, 0, static_cast<int>(place), &sorted);
  const int root = static_cast<int>(std::ranges::find(order, 0) - order.begin());
  MPI_Datatype color;
  MPI_Type_contiguous(4, MPI_FLOAT, &color);
  MPI_Type_commit(&color);
  MPI_Op operation;
  MPI_Op_create(over, 0, &operation);
  const std::unique_ptr<PieceMarcher> pieces = makePieceMarcher(marched);
  Image<glm::vec4> whole(camera.width, camera.height);
  std::vector<double> marchMs, allMs;
  for (int run = 0; run < kRuns + kWarmUps; ++run) {
    std::fill(image.begin(), image.end(), glm::vec4(0.0f));
    MPI_Barrier(MPI_COMM_WORLD);
    const auto from = std::chrono::steady_clock::now();
    OneBrick brick(block, image);
    pieces->marchPieces(camera, settings, nullptr, brick, {});
    const double ownMs = millisecondsSince(from);
    MPI_Reduce(image.data(), whole.data(), static_cast<int>(image.size()), color, operation, root, sorted);
    if (run < kWarmUps) continue;
    marchMs.push_back(ownMs);
    allMs.push_back(millisecondsSince(from));
  }
  double ownMarch = median(marchMs), slowest = 0.0;
  MPI_Reduce(&ownMarch, &slowest, 1, MPI_DOUBLE, MPI_MAX, 0, MPI_COMM_WORLD);
  volume->releaseVoxels();

  if (!ranks->isFirst()) {
    followFirst(volume, Backend::cpu, {});
    return leaveProcesses(0);
  }
  const double relayMs = median(relayed(volume, scene.transferFunction, camera, settings, expected));
  float difference = 0.0f;
  for (size_t i = 0; i < whole.size(); ++i)
    for (int channel = 0; channel < 4; ++channel) difference = std::max(difference, std::abs(whole.data()[i][channel] - expected.data()[i][channel]));
  std::printf("%d processes, %ux%u: march of the slowest and MPI_Reduce %.1f ms, of which the march %.1f; relayed %.1f ms; pictures differ by %.2g\n", ranks->size(), camera.width, camera.height,
              median(allMs), slowest, relayMs, static_cast<double>(difference));
  const float behindEnds = settings.terminateEarly ? settings.contribution : 0.0f;
  if (!(difference <= behindEnds + kRounding)) throw std::runtime_error("the pictures differ by more than rounding and early ends");
  leaveProcesses(0);
}

}  // namespace
}  // namespace warpscope

int main(int count, char** words) {
  try {
    warpscope::run(warpscope::askedBy(count, words));
  } catch (const warpscope::FollowedToTheEnd&) {
  } catch (const std::exception& error) {
    std::cerr << "reduce_bench: " << error.what() << "\n";
    return 1;
  }
  return 0;
}

// Rays that are marched piece by piece, each by whoever holds the voxels there: what one hands on to the next, near to far.
//
// A picture is cut into tiles of pixels, the volume into blocks of cells (cell_block.h). A tile goes from block to block as its rays do; with it goes all that its
// rays have gathered, in the very variables that one march of the whole ray would have. So each sample is looked at once, by the transmittance that really lies
// in front of it: light, opacity, depths and segments are those of a ray that was marched at once, bit for bit, and a ray that has ended costs nothing further on.
// (Pieces that are marched side by side and put together afterwards, as ray_state.h has it, round otherwise and march what cannot be seen; segments, which are merged as
// they come, would be others.)
#pragma once

#include <chrono>
#include <functional>
#include <memory>
#include <optional>
#include <stop_token>
#include <string>
#include <vector>

#include "render/core/backend.h"
#include "render/core/camera.h"
#include "render/effects/light_volume.h"
#include "render/effects/mip.h"
#include "render/march/cell_block.h"
#include "render/march/finished_ray.h"
#include "render/volume/volume.h"

namespace warpscope {

struct MarchedVolume;

/// What a ray under way has gathered, but for lists. Default: nothing.
struct RelayedState {
  RayColor color;
  int next = 0;            ///< of its lattice, the first sample that nobody has looked at
  GreatestValue greatest;  ///< of the mode mip, so far
  bool hasCounted = false;  ///< what follows has been begun
  AnyDepth<false>::Fold fold;  ///< of its samples that count, where one sample is wanted by a heuristic of one pass
  MomentsFold moments;         ///< likewise, where their spread is

  WARPSCOPE_HD bool hasMet() const { return hasCounted || greatest.any || color.transmittance.exact() < 1.0 || color.color() != glm::dvec3(0.0); }
};

/// Pixels along the side of a tile, and a picture's tiles, row by row.
inline constexpr uint32_t kRelayedSide = 32;
uint32_t tilesOf(const Camera& camera);
PixelArea areaOfTile(const Camera& camera, uint32_t tile);

/// A ray under way.
struct RelayedRay {
  RelayedState state;
  bool isDone = false;  ///< it has ended: nothing of it is left to march
  std::vector<CountingSample> counting;  ///< its samples that count, where they are not folded; on the second way those of the part under way

  /// Whether anything has been gathered.
  bool hasMet() const { return state.hasMet() || !counting.empty(); }
};

/// What a ray gathers on its second way.
struct RelayedAgain {
  bool isDivided = false;       ///< several of its samples count, and it is cut into parts
  float accumulatedEnd = 0.0f;  ///< RayParts', of such a ray
  RayPart<RayPiece> part;
  RaySamples found;  ///< of the parts that are done
  NormalCode normals[kMostMergerRoom] = {};  ///< of segments, by their places
};

/// Rays of a tile, from block to block.
struct RelayedTile {
  PixelArea area;
  uint32_t index = 0;    ///< among the picture's tiles
  bool isLast = false;   ///< of the tile, no other block has anything: what has not ended ends here
  bool goesTwice = false;  ///< what the first way has found out is what the second one asks for: rays are cut into parts by what they come to, or segments want the normals
                           ///< of their places, which are known when they have been merged. Rays that have ended go along then
  bool isAgain = false;    ///< this is the second way
  bool isDivided = false;  ///< rays are cut into parts
  std::vector<RelayedRay> rays;         ///< area.count(), row by row
  std::vector<SegmentMerger> segments;  ///< as many, or none where nobody wants any
  std::vector<RelayedAgain> again;      ///< likewise; on the second way

  /// Keeps what a ray of it has found that has ended; rays that have found nothing are not spoken of. `sample`: how samples are sent, or null where colours alone are
  /// wanted. `pixels` and the ray's x and y are the picture's.
  void keep(const FinishedRay& ray, const SampleSettings* sample, bool hasNormals, const SampleRule& rule, const PixelGrid& pixels);

  /// The first way is done; what rays have gathered is taken along. False if there is nothing to go for.
  bool beginAgain();

  uint32_t results = 0;    ///< of it that have been sent
  // What the rays that have ended since it was taken have left.
  std::vector<uint32_t> finished;  ///< their places in `rays`
  DenseRays found;                 ///< of each of these, in their order; where samples are wanted
  std::vector<glm::vec4> colors;   ///< likewise; where they are not: linear, premultiplied

  std::chrono::steady_clock::time_point taken;  ///< when
  std::optional<std::chrono::steady_clock::time_point> done;  ///< its part here; nothing: when it is handed on
  bool isByDevice = false;                      ///< its part here was marched by a device

  RelayedRay& ray(uint32_t x, uint32_t y) { return rays[size_t{y - area.y} * area.width + (x - area.x)]; }
};

/// Where tiles come from and go to.
class RayRelay {
 public:
  virtual ~RayRelay() = default;

  /// Whose samples are marched here.
  virtual const CellBlock& block() const = 0;
  /// The next tile of which all is known that lies in front; waits for it. Null if there will be no more. Safe on any thread.
  virtual std::unique_ptr<RelayedTile> take() = 0;
  /// The same of a tile that is there already: null if none is. Safe on any thread.
  virtual std::unique_ptr<RelayedTile> takeReady() = 0;
  /// When its part here has been marched. Safe on any thread.
  virtual void handOn(std::unique_ptr<RelayedTile> tile) = 0;
  /// take() gives no more.
  virtual void close() noexcept = 0;
};

/// Voxels on each side of a block's that marching its samples reads: one for gradients, and as many as a step is long; `axis`: 0, 1, 2.
int marginOf(const RenderSettings& settings, const VolumeGeometry& geometry, int axis);
/// The block's voxels, and those.
VoxelRows rowsOf(const CellBlock& block, const RenderSettings& settings, const VolumeGeometry& geometry);

/// Marches the part of rays that lies in one block of a volume.
class PieceMarcher {
 public:
  virtual ~PieceMarcher() = default;

  /// What stands in the light's way may be in any block: shadows and occlusion are found in this coarse copy of all of the volume, by the same function. The same frames come of
  /// the same copy, however the volume is cut; to those of one process they are as near as the copy is to the volume.
  virtual void setLightCopy(const ProxyPtr& copy) = 0;

  /// Works at a relay's tiles, on all cores, until there are no more. `sample`: what is wanted of the rays beside their colours, or null. Reads voxels of
  /// rowsOf() the relay's block. Throws what Marcher::march() does, UsageError for settings that whyNotInPieces() knows.
  virtual void marchPieces(const Camera& camera, const RenderSettings& settings, const SampleSettings* sample, RayRelay& relay, const std::stop_token& stop) = 0;
};

/// What arrives of the lights, at places of a grid over the volume.
struct FoundLight {
  LightVolume volume;      ///< without channels where nothing stands in the light's way. Its values are in this program's memory, and stay until the next call of who has found them
  std::vector<float> key;  ///< the same for the same values, as long as the marcher's copy of the volume is the same
};

/// One that marches where it finds light as well.
class HostPieceMarcher : public PieceMarcher {
 public:
  /// As its own rays find it, for others that march by these settings. Throws as marchPieces() does.
  virtual FoundLight findLight(const Camera& camera, const RenderSettings& settings, const std::stop_token& stop) = 0;
};

/// On the CPU. Shares what `marched` has.
std::unique_ptr<HostPieceMarcher> makePieceMarcher(std::shared_ptr<const MarchedVolume> marched);

/// What makes marchers of pieces, and where these march.
struct PieceMaker {
  std::function<std::unique_ptr<PieceMarcher>(std::shared_ptr<const MarchedVolume>)> make = makePieceMarcher;
  std::function<Backend()> backend = [] { return Backend::cpu; };  ///< now: a device may be left. Safe on any thread
  uint64_t roomBytes = 0;  ///< for voxels, where they march; 0: not known
};

/// Whether rays by these settings want shadows or occlusion, for which a marcher of pieces is to have a copy of the volume.
bool needsLightCopy(const RenderSettings& settings);
/// Voxels along the longest edge of that copy.
inline constexpr int kLightCopyEdge = 256;

/// Why rays by these settings can be marched whole alone; empty if they need not.
std::string whyNotInPieces(const RenderSettings& settings);

}  // namespace warpscope

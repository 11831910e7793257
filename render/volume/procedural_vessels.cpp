// A vascular tree that fills the volume: terminals are spread over a crown, and their set is split in two again and
// again. Radii follow Murray 1926 ("The Physiological Principle of Minimum Work"): r^3 of a branch is the sum of its
// children's.
#include <algorithm>
#include <numeric>
#include <span>

#include "render/volume/procedural_fields.h"

namespace warpscope::procedural {
namespace {

// Lengths of the tree are in units of the volume's sides, radii in units of its shortest side.
constexpr int kCells = 12;                    // terminals: one in each of 12^3 cells, where the crown reaches
constexpr float kTrunkRadius = 1.0f / 32.0f;  // a trunk 1/16 of the side across
constexpr float kLeastRadiusVoxels = 0.3f;    // thinner branches are left out
constexpr float kEdgeVoxels = 0.8f;           // half the width of the soft edge
constexpr int kPieces = 7;                    // straight pieces of a branch

/// A straight tube piece with round ends.
struct Piece {
  glm::vec3 begin, end;
  float radiusBegin, radiusEnd;
};

/// True where the crown reaches: a rounded cube over a funnel that leaves the trunk free.
bool isInCrown(const glm::vec3& p) {
  const glm::vec3 c = (2.0f * p - 1.0f) / 0.96f;
  const glm::vec3 c2 = c * c;
  const float horizontal = std::sqrt(c.x * c.x + c.z * c.z);
  return glm::dot(c2, c2) < 1.15f && p.y > 0.09f && horizontal < 0.15f + 2.6f * (p.y - 0.06f);
}

std::vector<glm::vec3> scatterTerminals(RandomSequence& random) {
  std::vector<glm::vec3> terminals;
  for (int i = 0; i < kCells * kCells * kCells; ++i) {
    const glm::vec3 cell(i % kCells, i / kCells % kCells, i / (kCells * kCells));
    const glm::vec3 p = (cell + 0.5f + 0.5f * random.inCube()) / static_cast<float>(kCells);
    const glm::vec3 offset = 0.02f * random.inCube();
    const bool hasNeighbor = random.uniform() < 0.15f;
    if (!isInCrown(p)) continue;
    terminals.push_back(p);
    // A second one a few voxels away, often fed by another branch: the gaps that a warp tears or closes wrongly.
    if (hasNeighbor && isInCrown(p + offset)) terminals.push_back(p + offset);
  }
  return terminals;
}

class Tree {
 public:
  explicit Tree(uint32_t seed) : random_(seed), terminals_(scatterTerminals(random_)) {
    grow(terminals_, {0.5f, -0.01f, 0.5f}, {0.0f, 1.0f, 0.0f}, 1.0f);
  }
  const std::vector<Piece>& pieces() const { return pieces_; }

 private:
  /// Grows the branch that feeds `terminals` from `start`, then its children. `share` is its part of the parent's flow.
  void grow(std::span<glm::vec3> terminals, const glm::vec3& start, const glm::vec3& heading, float share) {
    const size_t count = terminals.size();
    const glm::vec3 center =
        std::accumulate(terminals.begin(), terminals.end(), glm::vec3(0.0f)) / static_cast<float>(count);
    const bool isTwig = count == 1;
    const float reach = isTwig ? 1.0f : random_.uniform(0.32f, 0.56f);
    glm::vec3 end = start + reach * (center - start);
    const float length = glm::length(end - start) + 1e-6f;
    if (!isTwig) end += 0.10f * length * random_.inCube();

    // The larger child keeps the parent's course, the smaller one turns away (Murray's law of angles, qualitatively).
    const glm::vec3 chord = (end - start) / length;
    const glm::vec3 leave = glm::normalize(glm::mix(chord, heading, 0.2f + 0.6f * share) + 0.15f * random_.inCube());
    const glm::vec3 arrive = glm::normalize(chord + 0.25f * (chord - leave) + 0.25f * random_.inCube());
    addBranch(start, end, leave * length, arrive * length, radiusOf(count), isTwig ? 0.7f : 0.97f);
    if (isTwig) return;

    const size_t half = split(terminals, center, arrive);
    const float share0 = static_cast<float>(half) / static_cast<float>(count);
    grow(terminals.first(half), end, arrive, share0);
    grow(terminals.subspan(half), end, arrive, 1.0f - share0);
  }

  /// Orders the terminals along their widest direction across `heading` and returns where to cut.
  size_t split(std::span<glm::vec3> terminals, const glm::vec3& center, const glm::vec3& heading) {
    glm::mat3 covariance(0.0f);
    for (const glm::vec3& p : terminals) covariance += glm::outerProduct(p - center, p - center);
    // Power iteration for the first eigenvector; what lies along the heading is projected out of every iterate.
    glm::vec3 axis = random_.inCube() + glm::vec3(0.01f, 0.0f, 0.02f);
    for (int i = 0; i < 16; ++i) {
      axis -= heading * glm::dot(axis, heading);
      axis = covariance * (axis / (glm::length(axis) + 1e-20f));
    }
    std::sort(terminals.begin(), terminals.end(), [&](const glm::vec3& a, const glm::vec3& b) {
      const float da = glm::dot(a, axis), db = glm::dot(b, axis);
      if (da != db) return da < db;
      return a.x != b.x ? a.x < b.x : a.y != b.y ? a.y < b.y : a.z < b.z;
    });
    const float cut = static_cast<float>(terminals.size()) * random_.uniform(0.28f, 0.72f);
    return std::clamp<size_t>(static_cast<size_t>(cut + 0.5f), 1, terminals.size() - 1);
  }

  float radiusOf(size_t count) const {
    return kTrunkRadius *
           static_cast<float>(cubeRoot(static_cast<double>(count) / static_cast<double>(terminals_.size())));
  }

  /// A cubic Hermite curve, cut into straight pieces. It begins a little wider, as branches do where they leave.
  void addBranch(const glm::vec3& p0, const glm::vec3& p1, const glm::vec3& t0, const glm::vec3& t1, float radius,
                 float taper) {
    const auto at = [&](float t) {
      const float s = 1.0f - t;
      return s * s * (1.0f + 2.0f * t) * p0 + t * s * s * t0 + t * t * (3.0f - 2.0f * t) * p1 - t * t * s * t1;
    };
    const auto radiusAt = [&](float t) {
      const float flare = std::max(0.0f, 1.0f - 4.0f * t);
      return radius * (1.0f + 0.12f * flare * flare + (taper - 1.0f) * t);
    };
    for (int i = 0; i < kPieces; ++i) {
      const float ta = static_cast<float>(i) / kPieces, tb = static_cast<float>(i + 1) / kPieces;
      pieces_.push_back({at(ta), at(tb), radiusAt(ta), radiusAt(tb)});
    }
  }

  RandomSequence random_;
  std::vector<glm::vec3> terminals_;
  std::vector<Piece> pieces_;
};

/// 255 on the centre line, 0.6 of it at the wall, then a soft edge.
float profile(float distance, float radius) {
  const float unit = distance / std::max(radius, 0.5f);
  const float body = 255.0f - 102.0f * std::min(unit * unit, 1.0f);
  return body * smoothStep((radius + kEdgeVoxels - distance) / (2.0f * kEdgeVoxels));
}

constexpr uint32_t kVesselBrickSide = 32;

/// Puts a piece (in voxels) into the part [lower, upper) of the volume. Where tubes meet the greatest value stays, so
/// the order of the pieces does not matter.
void drawPiece(const Piece& piece, const glm::ivec3& lower, const glm::ivec3& upper, const glm::uvec3& dims,
               uint8_t* voxels) {
  const glm::vec3 reach(std::max(piece.radiusBegin, piece.radiusEnd) + kEdgeVoxels);
  const glm::ivec3 first = glm::max(lower, glm::ivec3(glm::floor(glm::min(piece.begin, piece.end) - reach - 0.5f)));
  const glm::ivec3 last = glm::min(upper, glm::ivec3(glm::ceil(glm::max(piece.begin, piece.end) + reach + 0.5f)));
  const glm::vec3 along = piece.end - piece.begin;
  const float inverse = 1.0f / std::max(glm::dot(along, along), 1e-12f);
  for (int z = first.z; z < last.z; ++z)
    for (int y = first.y; y < last.y; ++y) {
      uint8_t* row = voxels + (size_t(z) * dims.y + size_t(y)) * dims.x;
      for (int x = first.x; x < last.x; ++x) {
        const glm::vec3 offset = glm::vec3(x, y, z) + 0.5f - piece.begin;
        const float t = glm::clamp(glm::dot(offset, along) * inverse, 0.0f, 1.0f);
        const float radius = piece.radiusBegin + t * (piece.radiusEnd - piece.radiusBegin);
        const glm::vec3 away = offset - t * along;
        const float squared = glm::dot(away, away);
        if (squared >= (radius + kEdgeVoxels) * (radius + kEdgeVoxels)) continue;
        row[x] = std::max(row[x], quantize(profile(std::sqrt(squared), radius)));
      }
    }
}

}  // namespace

void fillVessels(uint8_t* voxels, const Wanted& wanted, const std::stop_token& stop) {
  const glm::uvec3& dims = wanted.dims;
  const Tree tree(wanted.seed);
  const auto side = static_cast<float>(std::min({dims.x, dims.y, dims.z}));
  const glm::uvec3 bricks = (dims + kVesselBrickSide - 1u) / kVesselBrickSide;
  std::vector<Piece> pieces;
  std::vector<std::vector<uint32_t>> piecesOf(size_t{bricks.x} * bricks.y * bricks.z);
  for (Piece piece : tree.pieces()) {
    piece.radiusBegin *= side;
    piece.radiusEnd *= side;
    if (piece.radiusBegin < kLeastRadiusVoxels) continue;
    piece.begin *= glm::vec3(dims);
    piece.end *= glm::vec3(dims);
    const glm::vec3 reach(piece.radiusBegin + kEdgeVoxels + 1.0f);
    const glm::vec3 top(bricks - 1u);
    const auto brickOf = [&](const glm::vec3& p) {
      return glm::uvec3(glm::clamp(p / static_cast<float>(kVesselBrickSide), glm::vec3(0.0f), top));
    };
    const glm::uvec3 first = brickOf(glm::min(piece.begin, piece.end) - reach);
    const glm::uvec3 last = brickOf(glm::max(piece.begin, piece.end) + reach);
    for (uint32_t z = first.z; z <= last.z; ++z)
      for (uint32_t y = first.y; y <= last.y; ++y)
        for (uint32_t x = first.x; x <= last.x; ++x)
          piecesOf[(size_t{z} * bricks.y + y) * bricks.x + x].push_back(static_cast<uint32_t>(pieces.size()));
    pieces.push_back(piece);
  }
  fillBricks(kVesselBrickSide, wanted, 1, stop, [&](const glm::uvec3& brick, const glm::uvec3& lower, const glm::uvec3& upper) {
    for (uint32_t z = lower.z; z < upper.z; ++z)
      for (uint32_t y = lower.y; y < upper.y; ++y) {
        uint8_t* row = voxels + (size_t{z} * dims.y + y) * dims.x;
        std::fill(row + lower.x, row + upper.x, uint8_t{0});
      }
    for (const uint32_t piece : piecesOf[(size_t{brick.z} * bricks.y + brick.y) * bricks.x + brick.x]) drawPiece(pieces[piece], lower, upper, dims, voxels);
  });
}

}  // namespace warpscope::procedural

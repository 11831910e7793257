// One pass makes the planes that all metrics look at.
// See picture_errors.h.
#include "render/metrics/picture_errors.h"

#include <array>

#include "render/base/error.h"
#include "render/metrics/batches.h"
#include "render/metrics/displayed.h"
#include "render/metrics/holes.h"
#include "render/metrics/psnr.h"
#include "render/metrics/ssim.h"

namespace warpscope {
namespace {

constexpr size_t kPixelsPerPiece = 1 << 12;

/// Sums over the pixels of each Visibility.
struct Shares {
  std::array<size_t, 3> pixels{};
  std::array<double, 3> squares{}, flip{};
  Shares operator+(const Shares& other) const {
    Shares sum = *this;
    for (size_t kind = 0; kind < 3; ++kind) {
      sum.pixels[kind] += other.pixels[kind];
      sum.squares[kind] += other.squares[kind];
      sum.flip[kind] += other.flip[kind];
    }
    return sum;
  }
};

Shares sharesOf(const DisplayedPlanes& a, const DisplayedPlanes& b, const Image<float>& map, const Image<Visibility>& mask) {
  return sumOverPieces<Shares>(a.linear[0].size(), kPixelsPerPiece, [&](size_t begin, size_t end) {
    Shares sum;
    for (size_t i = begin; i < end; ++i) {
      const auto kind = static_cast<size_t>(mask[i]);
      ++sum.pixels[kind];
      sum.flip[kind] += static_cast<double>(map[i]);
      for (size_t channel = 0; channel < 3; ++channel) {
        const auto difference = static_cast<double>(a.srgb[channel][i] - b.srgb[channel][i]);
        sum.squares[kind] += difference * difference;
      }
    }
    return sum;
  });
}

}  // namespace

struct PictureJudge::Prepared {
  Image<glm::vec4> reference;  // for holes
  glm::vec3 background;
  DisplayedPlanes planes;
  FlipReference flip;
  SsimReference ssim;

  Prepared(const Image<glm::vec4>& picture, const glm::vec3& behind, float pixelsPerDegree)
      : reference(picture), background(behind), planes(displayedPlanes(picture, behind, "a ground truth")), flip(planes.linear, pixelsPerDegree),
        ssim(planes.srgb) {}
};

PictureJudge::PictureJudge(const Image<glm::vec4>& reference, const glm::vec3& background, float pixelsPerDegree) {
  requireOneSize(reference, reference, "a ground truth");
  prepared_ = std::make_unique<const Prepared>(reference, background, pixelsPerDegree);
}

PictureJudge::~PictureJudge() = default;
PictureJudge::PictureJudge(PictureJudge&&) noexcept = default;
PictureJudge& PictureJudge::operator=(PictureJudge&&) noexcept = default;

PictureErrors PictureJudge::errorsOf(const WarpedImage& image, const Image<Visibility>* mask, Image<float>* map) const {
  const Prepared& known = *prepared_;
  requireOneSize(image.color, known.reference, "a picture's errors");
  if (mask && (mask->width() != known.reference.width() || mask->height() != known.reference.height()))
    throw InputError("what the frame knew of a picture's pixels needs the picture's size");
  const DisplayedPlanes planes = displayedPlanes(image.color, known.background, "a picture's errors");

  PictureErrors errors;
  errors.psnrDb = psnrOfSquares(sumOfSquares(planes.srgb, known.planes.srgb), known.reference.size());
  errors.psnrLinearDb = psnrOfSquares(sumOfSquares(planes.linear, known.planes.linear), known.reference.size());
  errors.ssim = known.ssim.similarity(planes.srgb);
  Image<float> ownMap;
  Image<float>& flipMap = map ? *map : ownMap;
  errors.flip = known.flip.difference(planes.linear, flipMap);
  const HoleCount holes = countHoles(image, known.reference);
  errors.holeFraction = holes.fraction();
  errors.filledFraction = holes.filledFraction();
  if (!mask) return errors;

  const Shares shares = sharesOf(planes, known.planes, flipMap, *mask);
  const auto split = [&](Visibility visibility, std::optional<double>& flipMean, std::optional<double>& psnrDb) {
    const auto kind = static_cast<size_t>(visibility);
    if (shares.pixels[kind] == 0) return;
    flipMean = shares.flip[kind] / static_cast<double>(shares.pixels[kind]);
    psnrDb = psnrOfSquares(shares.squares[kind], shares.pixels[kind]);
  };
  split(Visibility::visible, errors.flipVisible, errors.psnrVisibleDb);
  split(Visibility::disoccluded, errors.flipDisoccluded, errors.psnrDisoccludedDb);
  return errors;
}

}  // namespace warpscope

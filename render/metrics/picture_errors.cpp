// One pass makes the planes that all metrics look at; one pass over them takes the sums, whole and by what the frame knew.
// See picture_errors.h.
#include "render/metrics/picture_errors.h"

#include <array>

#include "render/core/error.h"
#include "render/metrics/batches.h"
#include "render/metrics/displayed.h"
#include "render/metrics/holes.h"
#include "render/metrics/psnr.h"
#include "render/metrics/ssim.h"

namespace warpscope {
namespace {

constexpr size_t kPixelsPerPiece = 1 << 12;

/// Sums of squared differences over red, green and blue.
struct Squares {
  double srgb = 0.0, linear = 0.0;
  Squares operator+(const Squares& other) const { return {srgb + other.srgb, linear + other.linear}; }
};

Squares squaresOf(const DisplayedPlanes& a, const DisplayedPlanes& b) {
  return sumOverPieces<Squares>(a.size(), kPixelsPerPiece, [&](size_t begin, size_t end) {
    Squares sum;
    for (size_t channel = 0; channel < 3; ++channel) {
      sum.srgb += squaredDifference(&a.srgb[channel][begin], &b.srgb[channel][begin], end - begin);
      sum.linear += squaredDifference(&a.linear[channel][begin], &b.linear[channel][begin], end - begin);
    }
    return sum;
  });
}

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
  return sumOverPieces<Shares>(a.size(), kPixelsPerPiece, [&](size_t begin, size_t end) {
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
      : reference(picture), background(behind), planes(displayedPlanes(picture, behind, "a ground truth")), flip(planes, pixelsPerDegree),
        ssim(planes) {}
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
  const Squares squares = squaresOf(planes, known.planes);
  errors.psnrDb = psnrOfSquares(squares.srgb, planes.size());
  errors.psnrLinearDb = psnrOfSquares(squares.linear, planes.size());
  errors.ssim = known.ssim.similarity(planes);
  Image<float> ownMap;
  Image<float>& flipMap = map ? *map : ownMap;
  errors.flip = known.flip.difference(planes, flipMap);
  errors.holeFraction = countHoles(image, known.reference).fraction();
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

// Sums over a picture's pixels, whole and by what the frame knew of them.
// See picture_errors.h.
#include "render/metrics/picture_errors.h"

#include <array>
#include <cmath>
#include <limits>

#include "render/core/error.h"
#include "render/metrics/displayed.h"
#include "render/metrics/holes.h"
#include "render/metrics/psnr.h"
#include "render/metrics/ssim.h"

namespace warpscope {
namespace {

double decibels(double squares, size_t pixels) {
  return squares == 0.0 ? std::numeric_limits<double>::infinity() : -10.0 * std::log10(squares / (3.0 * static_cast<double>(pixels)));
}

/// Sums over the pixels of one kind.
struct Share {
  size_t pixels = 0;
  double squares = 0.0, flip = 0.0;
};

}  // namespace

struct PictureJudge::Prepared {
  Image<glm::vec4> reference;
  glm::vec3 background;
  float pixelsPerDegree;
};

PictureJudge::PictureJudge(const Image<glm::vec4>& reference, const glm::vec3& background, float pixelsPerDegree)
    : prepared_(new Prepared{reference, background, pixelsPerDegree}) {
  flip(reference, reference, background, pixelsPerDegree);  // refuses what cannot be compared
}

PictureJudge::~PictureJudge() = default;
PictureJudge::PictureJudge(PictureJudge&&) noexcept = default;
PictureJudge& PictureJudge::operator=(PictureJudge&&) noexcept = default;

PictureErrors PictureJudge::errorsOf(const WarpedImage& image, const Image<Visibility>* mask, Image<float>* map) const {
  const auto& [reference, background, pixelsPerDegree] = *prepared_;
  if (mask && (mask->width() != reference.width() || mask->height() != reference.height()))
    throw InputError("the mask of a picture needs the picture's size");
  PictureErrors errors;
  errors.psnrDb = psnrSrgb(image.color, reference, background);
  errors.ssim = ssimSrgb(image.color, reference, background);
  errors.holeFraction = countHoles(image, reference).fraction();
  FlipResult flipped = flip(image.color, reference, background, pixelsPerDegree);
  errors.flip = flipped.mean;
  const DisplayedPlanes a = displayedPlanes(image.color, background, "PSNR"), b = displayedPlanes(reference, background, "PSNR");
  double linearSquares = 0.0;
  std::array<Share, 3> shares;
  for (size_t i = 0; i < reference.size(); ++i) {
    Share& share = shares[mask ? static_cast<size_t>((*mask)[i]) : 0];
    ++share.pixels;
    share.flip += flipped.map[i];
    for (int channel = 0; channel < 3; ++channel) {
      const auto plane = static_cast<size_t>(channel);
      const double difference = a[plane][i] - b[plane][i];
      share.squares += difference * difference;
      const auto linearOf = [&](const glm::vec4& pixel) {
        return static_cast<double>(glm::clamp(pixel[channel] + (1.0f - pixel.a) * background[channel], 0.0f, 1.0f));
      };
      linearSquares += std::pow(linearOf(image.color[i]) - linearOf(reference[i]), 2.0);
    }
  }
  errors.psnrLinearDb = decibels(linearSquares, reference.size());
  const auto split = [&](Visibility kind, std::optional<double>& flipMean, std::optional<double>& psnrDb) {
    const Share& share = shares[static_cast<size_t>(kind)];
    if (!mask || share.pixels == 0) return;
    flipMean = share.flip / static_cast<double>(share.pixels);
    psnrDb = decibels(share.squares, share.pixels);
  };
  split(Visibility::visible, errors.flipVisible, errors.psnrVisibleDb);
  split(Visibility::disoccluded, errors.flipDisoccluded, errors.psnrDisoccludedDb);
  if (map) *map = std::move(flipped.map);
  return errors;
}

}  // namespace warpscope

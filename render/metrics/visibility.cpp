// Samples are looked up by their pixels.
// See visibility.h.
#include "render/metrics/visibility.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <vector>

#include "render/core/parallel.h"

namespace warpscope {
namespace {

constexpr size_t kSamplesPerPiece = 1 << 14;

/// Coordinate of the pixel that holds an image position inside the picture.
uint32_t pixelAt(float position, uint32_t count) {
  return static_cast<uint32_t>(std::clamp(std::floor(position), 0.0f, static_cast<float>(count - 1)));
}

/// A frame's samples by pixel.
class PixelSamples {
 public:
  explicit PixelSamples(const SampleFrame& frame)
      : width_(frame.camera.width), height_(frame.camera.height), ends_(size_t{width_} * height_ + 1), positions_(frame.size()) {
    std::vector<glm::vec3> positions(frame.size());
    std::vector<uint32_t> pixels(frame.size());
    const SampleGrid grid = frame.grid();
    parallelForRanges(frame.size(), kSamplesPerPiece, [&](size_t begin, size_t end) {
      for (size_t i = begin; i < end; ++i) {
        positions[i] = unpackPosition(frame.samples[i], grid);
        pixels[i] = std::min(rowOf(frame.samples[i]), height_ - 1) * width_ + std::min(columnOf(frame.samples[i]), width_ - 1);
      }
    });
    // Counting sort: ends_[p] is where the samples of pixel p begin, and after filling where they end.
    for (const uint32_t pixel : pixels) ++ends_[pixel + 1];
    for (size_t p = 1; p < ends_.size(); ++p) ends_[p] += ends_[p - 1];
    for (size_t i = 0; i < positions.size(); ++i) positions_[ends_[pixels[i]]++] = positions[i];
  }

  uint32_t width() const { return width_; }
  uint32_t height() const { return height_; }
  /// Calls body(position) for the samples of pixels x0..x1 of row y, both ends included.
  template <class Body>
  void forPixels(uint32_t x0, uint32_t x1, uint32_t y, const Body& body) const {
    const size_t first = size_t{y} * width_ + x0, last = size_t{y} * width_ + x1;
    for (size_t i = first == 0 ? 0 : ends_[first - 1]; i < ends_[last]; ++i) body(positions_[i]);
  }

 private:
  uint32_t width_, height_;
  std::vector<size_t> ends_;
  std::vector<glm::vec3> positions_;
};

/// Largest distance between a position and what is stored of it, twice: a step of depth along the rays through the corners.
float quantizationStep(const SampleFrame& frame) {
  const PixelGrid& pixels = frame.grid().pixels;
  return frame.quantization.depthStep * glm::length(glm::vec3(pixels.halfWidth * pixels.edge, pixels.halfHeight * pixels.edge, 1.0f));
}

}  // namespace

Image<Visibility> visibilityOf(const SampleFrame& frame, const SampleFrame& reference) {
  requireUsable(frame.camera);
  requireUsable(reference.camera);
  const PixelSamples known(frame), wanted(reference);
  const float voxelDiagonal = 2.0f * std::max(frame.voxelRadius, reference.voxelRadius);
  const float quantization = quantizationStep(frame) + quantizationStep(reference);
  const float diagonalOfPixel = std::sqrt(2.0f) * pixelEdge(frame.camera);

  const auto isKnown = [&](const glm::vec3& point) {
    const Projection seen = project(frame.camera, point);
    const glm::vec2 size(known.width(), known.height());
    if (!(seen.forwardDepth > 0.0f && seen.pixel.x >= 0.0f && seen.pixel.y >= 0.0f && seen.pixel.x < size.x && seen.pixel.y < size.y)) return false;
    const float tolerance = voxelDiagonal + diagonalOfPixel * seen.forwardDepth + quantization;
    const uint32_t x = pixelAt(seen.pixel.x, known.width()), y = pixelAt(seen.pixel.y, known.height());
    float nearest = std::numeric_limits<float>::infinity();  // squared
    for (uint32_t row = y - std::min(y, 1u); row <= std::min(y + 1, known.height() - 1); ++row)
      known.forPixels(x - std::min(x, 1u), std::min(x + 1, known.width() - 1), row, [&](const glm::vec3& position) {
        const glm::vec3 offset = position - point;
        nearest = std::min(nearest, glm::dot(offset, offset));
      });
    return nearest <= tolerance * tolerance;
  };

  Image<Visibility> mask(reference.camera.width, reference.camera.height, Visibility::empty);
  parallelForRanges(mask.height(), 8, [&](size_t begin, size_t end) {
    for (auto y = static_cast<uint32_t>(begin); y < end; ++y)
      for (uint32_t x = 0; x < mask.width(); ++x) {
        float least = std::numeric_limits<float>::infinity();  // squared distance of the sample nearest to the eye
        glm::vec3 point(0.0f);
        wanted.forPixels(x, x, y, [&](const glm::vec3& position) {
          const glm::vec3 offset = position - reference.camera.eye;
          if (glm::dot(offset, offset) >= least) return;
          least = glm::dot(offset, offset);
          point = position;
        });
        if (std::isfinite(least)) mask(x, y) = isKnown(point) ? Visibility::visible : Visibility::disoccluded;
      }
  });
  return mask;
}

}  // namespace warpscope

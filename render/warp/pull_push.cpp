// Four sweeps find the gaps; a pyramid gives them colours.
// See pull_push.h.
#include "render/warp/pull_push.h"

#include <algorithm>
#include <vector>

#include "render/base/error.h"
#include "render/core/parallel.h"

namespace warpscope {
namespace {

constexpr size_t kRows = 16;

/// How many of its four directions see something covered, for each pixel that is not.
std::vector<uint8_t> enclosures(const Image<uint32_t>& samples) {
  const uint32_t width = samples.width(), height = samples.height();
  std::vector<uint8_t> seen(samples.size(), 0);
  parallelForRanges(height, kRows, [&](size_t begin, size_t end) {
    for (size_t y = begin; y < end; ++y) {
      const size_t row = y * width;
      bool isBehind = false;
      for (size_t x = 0; x < width; ++x) {
        isBehind |= samples[row + x] != kNoSample;
        seen[row + x] = static_cast<uint8_t>(seen[row + x] + isBehind);
      }
      isBehind = false;
      for (size_t x = width; x-- > 0;) {
        isBehind |= samples[row + x] != kNoSample;
        seen[row + x] = static_cast<uint8_t>(seen[row + x] + isBehind);
      }
    }
  });
  // Columns side by side, so that memory is gone through row by row.
  constexpr size_t kColumns = 64;
  parallelForRanges((width + kColumns - 1) / kColumns, 1, [&](size_t begin, size_t end) {
    for (size_t group = begin; group < end; ++group) {
      const size_t first = group * kColumns, last = std::min<size_t>(first + kColumns, width);
      const auto sweep = [&](auto&& rowAt) {
        bool isBehind[kColumns] = {};
        for (size_t i = 0; i < height; ++i)
          for (size_t x = first; x < last; ++x) {
            const size_t pixel = rowAt(i) * width + x;
            isBehind[x - first] |= samples[pixel] != kNoSample;
            seen[pixel] = static_cast<uint8_t>(seen[pixel] + isBehind[x - first]);
          }
      };
      sweep([](size_t i) { return i; });
      sweep([&](size_t i) { return height - 1 - i; });
    }
  });
  return seen;
}

/// Averages of covered pixels, premultiplied by how much is covered: 0..1.
struct Level {
  Image<glm::vec4> color;
  Image<float> weight;
};

/// Squares of two by two; what is left over at the right and below makes squares of its own.
Level pulled(const Level& fine) {
  Level coarse;
  const uint32_t width = (fine.color.width() + 1) / 2, height = (fine.color.height() + 1) / 2;
  coarse.color.reshape(width, height);
  coarse.weight.reshape(width, height);
  parallelForRanges(height, kRows, [&](size_t begin, size_t end) {
    for (auto y = static_cast<uint32_t>(begin); y < end; ++y)
      for (uint32_t x = 0; x < width; ++x) {
        glm::vec4 color(0.0f);
        float weight = 0.0f;
        for (uint32_t v = 2 * y; v < std::min(2 * y + 2, fine.color.height()); ++v)
          for (uint32_t u = 2 * x; u < std::min(2 * x + 2, fine.color.width()); ++u) {
            color += fine.color(u, v);
            weight += fine.weight(u, v);
          }
        // No more than whole: then a coarser level adds nothing to it.
        const float share = weight > 1.0f ? 1.0f / weight : 1.0f;
        coarse.color(x, y) = color * share;
        coarse.weight(x, y) = std::min(weight, 1.0f);
      }
  });
  return coarse;
}

/// Between the centres of a level's four nearest squares, for the middle of a pixel of the next finer one.
struct Blended {
  glm::vec4 color{0.0f};
  float weight = 0.0f;
};
Blended blendedAt(const Level& coarse, uint32_t x, uint32_t y) {
  Blended sum;
  const auto neighbour = [](uint32_t at, uint32_t count) {  // the second nearest square along an axis
    const uint32_t own = at / 2;
    return at % 2 == 0 ? (own > 0 ? own - 1 : own) : std::min(own + 1, count - 1);
  };
  const uint32_t xs[2] = {x / 2, neighbour(x, coarse.color.width())}, ys[2] = {y / 2, neighbour(y, coarse.color.height())};
  for (int j = 0; j < 2; ++j)
    for (int i = 0; i < 2; ++i) {
      const float share = (i == 0 ? 0.75f : 0.25f) * (j == 0 ? 0.75f : 0.25f);
      sum.color += share * coarse.color(xs[i], ys[j]);
      sum.weight += share * coarse.weight(xs[i], ys[j]);
    }
  return sum;
}

/// What is not covered whole takes the rest from the coarser level.
void push(Level& fine, const Level& coarse) {
  parallelForRanges(fine.color.height(), kRows, [&](size_t begin, size_t end) {
    for (auto y = static_cast<uint32_t>(begin); y < end; ++y)
      for (uint32_t x = 0; x < fine.color.width(); ++x) {
        const float rest = 1.0f - fine.weight(x, y);
        if (!(rest > 0.0f)) continue;
        const Blended blended = blendedAt(coarse, x, y);
        if (!(blended.weight > 0.0f)) continue;
        fine.color(x, y) += rest / blended.weight * blended.color;
        fine.weight(x, y) = 1.0f;
      }
  });
}

}  // namespace

void fillGaps(WarpedImage& image, const std::stop_token& stop) {
  const std::vector<uint8_t> seen = enclosures(image.samples);
  const auto isGap = [&](size_t i) { return image.samples[i] == kNoSample && seen[i] >= kEnclosedBy; };
  bool hasGaps = false;
  for (size_t i = 0; i < seen.size() && !hasGaps; ++i) hasGaps = isGap(i);
  if (!hasGaps) return;
  std::vector<Level> levels(1);
  levels[0].color = image.color;
  levels[0].weight.reshape(image.samples.width(), image.samples.height());
  for (size_t i = 0; i < image.samples.size(); ++i) levels[0].weight[i] = image.samples[i] != kNoSample ? 1.0f : 0.0f;
  while (levels.back().color.size() > 1) {
    if (stop.stop_requested()) throw OperationCancelled();
    levels.push_back(pulled(levels.back()));
  }
  for (size_t level = levels.size() - 1; level-- > 0;) push(levels[level], levels[level + 1]);
  if (stop.stop_requested()) throw OperationCancelled();
  parallelForRanges(image.samples.size(), 1 << 14, [&](size_t begin, size_t end) {
    for (size_t i = begin; i < end; ++i) {
      if (!isGap(i)) continue;
      image.color[i] = levels[0].color[i];
      image.samples[i] = kFilled;
    }
  });
}

}  // namespace warpscope

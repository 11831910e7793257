// Overlaps of hats, and a tridiagonal system for each line.
// See linear_fit.h.
#include "render/volume/linear_fit.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numeric>
#include <utility>

#include "render/core/parallel.h"

namespace warpscope {
namespace {

/// Cells of equal length along an axis, and for each its part in what is interpolated: 1 at its middle, 0 at those beside it; of the outermost ones 1 to the ends.
struct Hats {
  uint32_t count = 1;
  double length = 1.0;  // of a cell

  double middle(uint32_t cell) const { return (cell + 0.5) * length; }
  double begin(uint32_t cell) const { return cell == 0 ? 0.0 : middle(cell - 1); }
  double end(uint32_t cell) const { return cell + 1 == count ? count * length : middle(cell + 1); }
  double at(uint32_t cell, double place) const {
    const bool isOutside = place < middle(cell) ? cell == 0 : cell + 1 == count;
    return isOutside ? 1.0 : std::max(1.0 - std::abs(place - middle(cell)) / length, 0.0);
  }
};

/// The integral of the product of two hats: between places where neither has a corner it is a parabola, for which Simpson's rule is exact.
double overlapOf(const Hats& a, uint32_t cellA, const Hats& b, uint32_t cellB) {
  const double begin = std::max(a.begin(cellA), b.begin(cellB)), end = std::min(a.end(cellA), b.end(cellB));
  if (!(begin < end)) return 0.0;
  std::array<double, 4> corners{begin, std::clamp(a.middle(cellA), begin, end), std::clamp(b.middle(cellB), begin, end), end};
  if (corners[1] > corners[2]) std::swap(corners[1], corners[2]);
  const auto product = [&](double place) { return a.at(cellA, place) * b.at(cellB, place); };
  double sum = 0.0;
  for (size_t i = 0; i + 1 < corners.size(); ++i) {
    const double from = corners[i], to = corners[i + 1];
    sum += (to - from) / 6.0 * (product(from) + 4.0 * product(0.5 * (from + to)) + product(to));
  }
  return sum;
}

/// A cell that has what lies from `begin` to `end`, in lengths of fine ones, and the middles there.
CellMean cellBetween(double begin, double end, uint32_t fine) {
  CellMean mean;
  mean.ownFirst = static_cast<uint32_t>(std::ceil(begin - 0.5));
  mean.ownEnd = std::min(static_cast<uint32_t>(end + 0.5), fine);
  return mean;
}

void addPart(CellMean& mean, uint32_t cell, double weight) {
  if (!(weight > 0.0)) return;  // before the first one or behind the last
  if (mean.weights.empty()) mean.first = cell;
  mean.weights.push_back(weight);
}

/// Of what was added; their sum as it was.
double scaleToOne(std::vector<double>& weights) {
  const double sum = std::accumulate(weights.begin(), weights.end(), 0.0);
  for (double& weight : weights) weight /= sum;
  return sum;
}

}  // namespace

std::vector<CellMean> boxMeans(uint32_t fine, uint32_t coarse) {
  std::vector<CellMean> means;
  const double length = static_cast<double>(fine) / coarse;
  for (uint32_t cell = 0; cell < coarse; ++cell) {
    const double begin = cell * length, end = (cell + 1) * length;
    CellMean& mean = means.emplace_back(cellBetween(begin, end, fine));
    for (auto i = static_cast<uint32_t>(begin); i < fine && i < end; ++i) addPart(mean, i, std::min(end, i + 1.0) - std::max(begin, static_cast<double>(i)));
    scaleToOne(mean.weights);
  }
  return means;
}

LinearFit::LinearFit(uint32_t fine, uint32_t coarse) : toNext_(coarse), toLast_(coarse) {
  const Hats many{fine, 1.0}, few{coarse, static_cast<double>(fine) / coarse};
  for (uint32_t cell = 0; cell < coarse; ++cell) {
    CellMean& mean = means_.emplace_back(cellBetween(cell * few.length, (cell + 1) * few.length, fine));
    const auto end = std::min(static_cast<uint32_t>(few.end(cell) + 1.5), fine);  // behind those whose hats reach it
    for (auto i = static_cast<uint32_t>(std::max(few.begin(cell) - 1.0, 0.0)); i < end; ++i) addPart(mean, i, overlapOf(few, cell, many, i));
    // As the means of the fine ones are: all that a cell has a part in adds up to its hat's integral.
    const double integral = scaleToOne(mean.weights);
    if (cell > 0) toLast_[cell] = overlapOf(few, cell, few, cell - 1) / integral;
    if (cell + 1 < coarse) toNext_[cell] = overlapOf(few, cell, few, cell + 1) / integral;
  }
}

void LinearFit::solve(std::span<double> numbers) const {
  // Elimination from one end, without pivots (Thomas 1949): what is beside a diagonal weighs at most half of it, so that no divisor comes near 0.
  std::vector<double> above(numbers.size());
  const auto isLinked = [&](size_t cell, size_t other) { return other < numbers.size() && !std::isnan(numbers[cell]) && !std::isnan(numbers[other]); };
  for (size_t i = 0; i < numbers.size(); ++i) {
    const double toLast = i > 0 && isLinked(i, i - 1) ? toLast_[i] : 0.0, toNext = isLinked(i, i + 1) ? toNext_[i] : 0.0;
    double own = 1.0 - toLast - toNext;
    if (toLast > 0.0) {
      own -= toLast * above[i - 1];
      numbers[i] -= toLast * numbers[i - 1];
    }
    numbers[i] /= own;
    above[i] = toNext / own;
  }
  for (size_t i = numbers.size(); i-- > 0;)
    if (above[i] > 0.0) numbers[i] -= above[i] * numbers[i + 1];
}

void solveGrid(std::span<float> numbers, std::span<const LinearFit> axes, const std::stop_token& stop) {
  const size_t columns = axes[0].means().size(), rows = axes[1].means().size(), slices = axes[2].means().size();
  const auto alongAxis = [&](const LinearFit& fit, size_t lines, size_t step, const auto& beginOf) {
    parallelForRanges(lines, 64, stop, [&](size_t first, size_t end) {
      std::vector<double> line(fit.means().size());
      for (size_t i = first; i < end; ++i) {
        float* const begin = &numbers[beginOf(i)];
        for (size_t k = 0; k < line.size(); ++k) line[k] = static_cast<double>(begin[k * step]);
        fit.solve(line);
        for (size_t k = 0; k < line.size(); ++k) begin[k * step] = static_cast<float>(line[k]);
      }
    });
  };
  alongAxis(axes[0], rows * slices, 1, [&](size_t i) { return i * columns; });
  alongAxis(axes[1], columns * slices, columns, [&](size_t i) { return i / columns * columns * rows + i % columns; });
  alongAxis(axes[2], columns * rows, columns * rows, [](size_t i) { return i; });
}

}  // namespace warpscope

// Fewer numbers along an axis that stand for many: those whose linear interpolation is nearest, by the integral of the squared difference, to that of the many.
// The L2 projection onto linear splines (Unser, Aldroubi, Eden 1993, "The L2 polynomial spline pyramid"). Of several axes, one after the other.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

namespace warpscope {

/// What a coarse cell's number is made of: a mean of fine ones.
struct CellMean {
  uint32_t first = 0;                 ///< the first fine cell that counts
  std::vector<double> weights;        ///< of it and those behind it; their sum is 1
  uint32_t ownFirst = 0, ownEnd = 0;  ///< fine cells whose middles lie in the coarse one, its borders among it

  bool isOwn(uint32_t cell) const { return cell >= ownFirst && cell < ownEnd; }
  uint32_t end() const { return first + static_cast<uint32_t>(weights.size()); }
};

/// The means of what lies in each of the coarse cells. 1 <= coarse <= fine.
std::vector<CellMean> boxMeans(uint32_t fine, uint32_t coarse);

/// Cells of an axis, `fine` and `coarse` ones that together are as long. Numbers belong to their middles; between these they are interpolated linearly, and from the outermost ones
/// to the ends they stay as they are, as a volume's values do.
class LinearFit {
 public:
  /// 1 <= coarse <= fine.
  LinearFit(uint32_t fine, uint32_t coarse);

  const std::vector<CellMean>& means() const { return means_; }
  /// Of the coarse cells' means the numbers that fit. Those that are NaN stay, and the others are as if those had what is beside them.
  void solve(std::span<double> numbers) const;

 private:
  std::vector<CellMean> means_;
  std::vector<double> toNext_, toLast_;  // what the mean of a cell has of the next one's number, and of the one's before; the rest is its own
};

/// Fits means of a grid of cells, x fastest, along each axis, in parallel.
void solveGrid(std::span<float> numbers, const LinearFit& x, const LinearFit& y, const LinearFit& z);

}  // namespace warpscope

// Fewer numbers along an axis that stand for many: those whose linear interpolation is nearest, by the integral of the squared difference, to that of the many.
// The projection onto linear splines by least squares, as images are reduced with the least loss (Unser, Aldroubi, Eden 1995, "Enlargement or reduction of digital images with minimum loss of
// information"). Deviations: any ratio; to the ends numbers stay as they are, so that sums are kept; a system is solved where there they filter; cells may be missing, beside which it is near, but not
// nearest: what is missing is taken to be as what is beside it. Of several axes, one after the other.
#pragma once

#include <cstdint>
#include <span>
#include <stop_token>
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

/// Fits means of a grid of cells, x fastest, along each of three axes, in parallel. Throws OperationCancelled if `stop` is set.
void solveGrid(std::span<float> numbers, std::span<const LinearFit> axes, const std::stop_token& stop);

}  // namespace warpscope

// Fewer numbers along an axis that stand for many: those whose linear interpolation is nearest, by the integral of the squared difference, to that of the many.
// The L2 projection onto linear splines (Unser, Aldroubi, Eden 1993, "The L2 polynomial spline pyramid"). Of several axes, one after the other.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

namespace warpscope {

/// Cells of an axis, `fine` and `coarse` ones that together are as long. Numbers belong to their middles; between these they are interpolated linearly, and from the outermost ones
/// to the ends they stay as they are, as a volume's values do.
class LinearFit {
 public:
  /// What a coarse cell's number is made of: a mean of fine ones.
  struct Mean {
    uint32_t first = 0;           ///< the first fine cell that counts
    std::vector<double> weights;  ///< of it and those behind it; their sum is 1
    uint32_t ownFirst = 0, ownEnd = 0;  ///< fine cells whose middles lie in the coarse one, its borders among it
    bool isOwn(uint32_t cell) const { return cell >= ownFirst && cell < ownEnd; }
    uint32_t end() const { return first + static_cast<uint32_t>(weights.size()); }
  };

  /// 1 <= coarse <= fine.
  LinearFit(uint32_t fine, uint32_t coarse);

  uint32_t size() const { return static_cast<uint32_t>(means_.size()); }
  const Mean& mean(size_t cell) const { return means_[cell]; }
  /// Of the coarse cells' means the numbers that fit. Those that are NaN stay, and the others are as if those had what is beside them.
  void solve(std::span<double> numbers) const;

 private:
  std::vector<Mean> means_;
  std::vector<double> toNext_, toLast_;  // what the mean of a cell has of the next one's number, and of the one's before; the rest is its own
};

/// Fits means of a grid of dims.x * dims.y * dims.z cells, x fastest, along each axis; in parallel.
struct GridFit {
  LinearFit x, y, z;

  void solve(std::span<float> numbers) const;
};

}  // namespace warpscope

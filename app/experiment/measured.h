// Repeated timings in two numbers.
// Median and interquartile range (Tukey 1977): neither minds an outlier.
#pragma once

#include <vector>

namespace warpscope {

/// Of repeated runs, after a warm-up; milliseconds.
struct Measured {
  double medianMs = 0.0;
  double spreadMs = 0.0;  ///< between the quartiles

  bool operator==(const Measured&) const = default;
};

/// Median and spread between the quartiles; `timesMs` is not empty.
Measured measuredOf(std::vector<double> timesMs);

}  // namespace warpscope

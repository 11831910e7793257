// What a test of a hard case found: the worst error, beside the bound that it was held to. The rows of README.md's
// table. A test's case is the number in its name, Case07 or On/Case07; table.py reads the files that are written.
#pragma once

#include <cmath>
#include <limits>
#include <string>

#include "render/core/backend.h"

namespace warpscope {

/// A row of the table.
struct Record {
  std::string function;  ///< what was evaluated, as its header names it
  std::string oracle;    ///< what told the truth
  std::string unit;      ///< of both errors; empty where nothing may differ
  double worst = 0.0;
  double bound = 0.0;  ///< as declared with the function; 0: bit for bit
  Backend backend = Backend::cpu;
};

/// Expects that the worst error is within the bound, and where WARPSCOPE_STABILITY_RECORDS names a folder leaves the
/// row there, in a file of the running test. Several rows of one test go into one file.
void record(const Record& row);

/// Of a test that compares bits, values or verdicts: nothing of it may have failed.
void recordExact(const std::string& function, const std::string& oracle, Backend backend = Backend::cpu);

/// The largest of many errors. One that is not a number is infinite.
class Worst {
 public:
  void see(double error) {
    if (std::isnan(error)) error = std::numeric_limits<double>::infinity();
    if (error > value_) value_ = error;
  }
  double value() const { return value_; }

 private:
  double value_ = 0.0;
};

}  // namespace warpscope

// How much is borne of those who show wrong tokens: see login_limiter.h.
#pragma once

#include <chrono>
#include <cstddef>

namespace warpscope::net {

struct LoginLimits {
  int freeFailures = 3;  ///< in a row that cost nothing: a URL that was not copied whole
  std::chrono::milliseconds firstPause{1000}, longestPause{30000};
  std::chrono::milliseconds memory{600000};  ///< an address that has been quiet for this long begins anew
  size_t maxAddresses = 1024;                ///< remembered at a time; of more, the one that failed longest ago is forgotten
  int linesAMinute = 30;                     ///< for the log, of all addresses together
};

}  // namespace warpscope::net

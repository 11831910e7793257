// Who shows wrong tokens is listened to less and less often, and what is said of that in the log stays short.
// Pauses double, as in OpenSSH's PerSourcePenalties (sshd_config(5)). A token of 192 bits is not guessed; what is spared is work and the log.
#pragma once

#include <boost/asio/ip/address.hpp>
#include <map>
#include <string>
#include <string_view>

#include "net/login_limits.h"
#include "net/times.h"

namespace warpscope::net {

/// Of one thread. Time is handed in, so that tests need no waiting.
class LoginLimiter {
 public:
  explicit LoginLimiter(const LoginLimits& limits = {}) : limits_(limits) {}

  // A peer is ADDRESS:PORT, or [ADDRESS]:PORT, as Stream::peer() says it; its port does not matter.

  /// Whether a connection from there is to be listened to; if not, it is to be closed without a word, so that an honest client tries again later.
  bool admits(std::string_view peer, TimePoint now);
  /// A wrong token came from there. Returns the line for the log; empty if there have been enough of them lately.
  std::string failed(std::string_view peer, TimePoint now);
  /// The right token came from there.
  void succeeded(std::string_view peer);

  size_t addresses() const { return sources_.size(); }

 private:
  struct Source {
    int failures = 0;       ///< in a row
    size_t turnedAway = 0;  ///< since the last of them
    TimePoint lastFailure, listensAgain;
  };

  void forget(TimePoint now);

  const LoginLimits limits_;
  std::map<boost::asio::ip::address, Source> sources_;
  TimePoint minuteBegan_{};
  int lines_ = 0;          ///< in this minute
  size_t silent_ = 0;      ///< failures without a line since the last line
};

}  // namespace warpscope::net

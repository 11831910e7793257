// Counting by address.
// See login_limiter.h.
#include "net/login_limiter.h"

#include <algorithm>
#include <cstdio>
#include <utility>

#include "net/tcp_stream.h"

namespace warpscope::net {
namespace {

namespace ip = boost::asio::ip;

/// Those that one machine can change as it likes are one: an IPv6 network of 64 bits (RFC 4291, 2.5.1). An IPv4 address in IPv6's form is itself.
/// What is no address is one source of its own.
ip::address sourceOf(std::string_view peer) {
  std::string_view host = peer.substr(0, peer.rfind(':'));
  if (host.starts_with('[') && host.ends_with(']')) host = host.substr(1, host.size() - 2);
  boost::system::error_code error;
  const ip::address address = ip::make_address(std::string(host), error);
  return networkOf(address);  // of an error the unspecified one
}

std::string secondsText(Clock::Duration duration) {
  char text[32];
  std::snprintf(text, sizeof text, "%.3g s", std::chrono::duration<double>(duration).count());
  return text;
}

}  // namespace

bool LoginLimiter::admits(std::string_view peer, TimePoint now) {
  const auto found = sources_.find(sourceOf(peer));
  if (found == sources_.end() || now >= found->second.listensAgain) return true;
  ++found->second.turnedAway;
  return false;
}

std::string LoginLimiter::failed(std::string_view peer, TimePoint now) {
  forget(now);
  Source& source = sources_[sourceOf(peer)];
  ++source.failures;
  source.lastFailure = now;
  const size_t turnedAway = std::exchange(source.turnedAway, 0);
  Clock::Duration pause{0};
  if (source.failures > limits_.freeFailures) {
    pause = limits_.firstPause;
    for (int i = limits_.freeFailures + 1; i < source.failures && pause < limits_.longestPause; ++i) pause *= 2;
    pause = std::min<Clock::Duration>(pause, limits_.longestPause);
  }
  source.listensAgain = now + pause;

  if (now - minuteBegan_ >= std::chrono::minutes(1)) {
    minuteBegan_ = now;
    lines_ = 0;
  }
  if (lines_ >= limits_.linesAMinute) {
    ++silent_;
    return {};
  }
  ++lines_;
  std::string line = std::string(peer) + ": a wrong token";
  if (source.failures > 1) line += ", number " + std::to_string(source.failures) + " in a row";
  if (turnedAway > 0) line += "; " + std::to_string(turnedAway) + " more connections were turned away meanwhile";
  if (pause > Clock::Duration(0)) line += "; not listened to for " + secondsText(pause);
  if (const size_t silent = std::exchange(silent_, 0); silent > 0) line += " (and " + std::to_string(silent) + " wrong tokens that no line tells of)";
  return line;
}

void LoginLimiter::succeeded(std::string_view peer) { sources_.erase(sourceOf(peer)); }

void LoginLimiter::forget(TimePoint now) {
  std::erase_if(sources_, [&](const auto& entry) { return now - entry.second.lastFailure >= limits_.memory; });
  if (sources_.size() < limits_.maxAddresses) return;
  sources_.erase(std::min_element(sources_.begin(), sources_.end(),
                                  [](const auto& a, const auto& b) { return a.second.lastFailure < b.second.lastFailure; }));
}

}  // namespace warpscope::net

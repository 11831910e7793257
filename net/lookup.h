// Names to addresses, without anybody who has to wait for them.
// getaddrinfo() (RFC 3493, section 6.1) cannot be interrupted: it runs in a thread that is left to itself once its answer is not wanted.
#pragma once

#include <functional>
#include <string>
#include <vector>

#include "net/asio.h"

namespace warpscope::net {

/// The addresses of `host`; blocks, perhaps for long. Throws system_error.
using Resolver = std::function<std::vector<asio::ip::address>(const std::string& host)>;

/// The system's.
std::vector<asio::ip::address> resolveBySystem(const std::string& host);

/// What `resolver` says of `host`, a name or an address without brackets. When the deadline comes first, or when the coroutine or its
/// executor is destroyed, the resolver goes on in its own thread and nobody hears of its answer. Throws DeadlineExceeded or system_error.
Awaitable<std::vector<asio::ip::address>> lookUp(asio::any_io_executor executor, std::string host, TimePoint deadline, Resolver resolver);

}  // namespace warpscope::net

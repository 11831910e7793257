// Boost.Asio as this room uses it: coroutines, one clock, short names.
// Written for Boost 1.74, which has neither cancellation of single operations nor operators on awaitables.
#pragma once

#include <utility>  // before Asio, whose coroutines use std::exchange without including it

#include <boost/asio.hpp>

#include "net/times.h"

namespace warpscope::net {

namespace asio = boost::asio;

using boost::system::error_code;
using boost::system::system_error;

/// What a coroutine of this room returns. It begins when it is awaited.
template <class T = void>
using Awaitable = asio::awaitable<T>;

/// `co_await operation(..., into(error))`: failures are stored instead of thrown.
inline auto into(error_code& error) { return asio::redirect_error(asio::use_awaitable, error); }

}  // namespace warpscope::net

// A thread for each lookup, and a pipe whose closing says that it has ended.
// See lookup.h. The thread knows nothing of Asio, so it may outlast whoever asked, and even the io_context.
#include "net/lookup.h"

#include <fcntl.h>
#include <unistd.h>

#include <memory>
#include <mutex>
#include <thread>

#include "net/deadline.h"

namespace warpscope::net {
namespace {

using Addresses = std::vector<asio::ip::address>;

error_code lastError() { return error_code(errno, boost::system::system_category()); }

/// What the thread and the one who waits share.
struct Errand {
  std::mutex mutex;
  Addresses found;
  error_code error;
  bool isDone = false;
};

/// Closes the descriptor with its last owner.
class Descriptor {
 public:
  explicit Descriptor(int handle) : handle_(handle) {}
  Descriptor(Descriptor&& other) noexcept : handle_(std::exchange(other.handle_, -1)) {}
  ~Descriptor() {
    if (handle_ >= 0) ::close(handle_);
  }

 private:
  int handle_;
};

void run(Errand& errand, const std::string& host, const Resolver& resolver) {
  Addresses found;
  error_code error;
  try {
    found = resolver(host);
    if (found.empty()) error = asio::error::host_not_found;
  } catch (const system_error& failure) {
    error = failure.code();
  } catch (const std::exception&) {
    error = asio::error::no_recovery;
  }
  const std::scoped_lock lock(errand.mutex);
  errand.found = std::move(found);
  errand.error = error;
  errand.isDone = true;
}

}  // namespace

Addresses resolveBySystem(const std::string& host) {
  asio::io_context unused;  // Asio's resolver does not take to its thread unless it is asked to
  Addresses found;
  for (const auto& entry : asio::ip::tcp::resolver(unused).resolve(host, "")) found.push_back(entry.endpoint().address());
  return found;
}

Awaitable<Addresses> lookUp(asio::any_io_executor executor, std::string host, TimePoint deadline, Resolver resolver) {
  error_code error;
  const asio::ip::address address = asio::ip::make_address(host, error);
  if (!error) co_return Addresses{address};

  const std::string what = "cannot look up '" + host + "'";
  int ends[2];
  if (::pipe2(ends, O_CLOEXEC) != 0) throw system_error(lastError(), what);
  Descriptor ended(ends[1]);
  asio::posix::stream_descriptor waiting(executor, ends[0]);
  const auto errand = std::make_shared<Errand>();
  try {
    std::thread([errand, host, resolver = std::move(resolver), ended = std::move(ended)] { run(*errand, host, resolver); }).detach();
  } catch (const std::system_error& failure) {
    throw system_error(error_code(failure.code().value(), boost::system::system_category()), what);
  }
  const Watchdog watchdog(executor, deadline, [&waiting] {
    error_code ignored;
    waiting.close(ignored);
  });
  co_await waiting.async_wait(asio::posix::stream_descriptor::wait_read, into(error));
  const std::scoped_lock lock(errand->mutex);
  if (!errand->isDone) throw DeadlineExceeded("looking up '" + host + "'");
  if (errand->error) throw system_error(errand->error, what);
  co_return std::move(errand->found);
}

}  // namespace warpscope::net

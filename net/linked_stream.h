// A stream behind a simulated link: what is written and read through it takes the time that two LinkModels say.
// It stands at one end of the connection and delays both directions, so that the other end needs to know nothing of it.
#pragma once

#include <memory>

#include "net/link_settings.h"
#include "net/stream.h"

namespace warpscope::net {

/// What is on the link is held in memory, up to LinkModel::capacityBytes() a direction; beyond that writes wait, and the inner stream is not
/// read from. A write is done when the link has taken its bytes, and fails when an error of an earlier one has had time to come back.
/// Errors and ends of the inner stream arrive as late as bytes do. Without anything to simulate, calls go straight to the inner stream.
class LinkedStream final : public Stream {
 public:
  /// `settings.up` is for what is written here, `settings.down` for what is read. Throws LinkSettingsError.
  LinkedStream(std::unique_ptr<Stream> inner, DuplexLinkSettings settings);
  /// Closes.
  ~LinkedStream() override;

  using Stream::write;
  Awaitable<size_t> readSome(asio::mutable_buffer buffer) override;
  Awaitable<void> write(std::span<const asio::const_buffer> buffers) override;
  /// Lets the link run empty first.
  Awaitable<void> finish(TimePoint deadline) override;
  /// Drops what is on the link.
  void close() noexcept override;
  void abort() noexcept override;
  asio::any_io_executor executor() override;
  const std::string& peer() const override;

  /// For what is sent from now on; what is under way keeps its time. Throws LinkSettingsError.
  void setSettings(DuplexLinkSettings settings);
  const DuplexLinkSettings& settings() const;

  /// What is on the link.
  size_t bytesUp() const;
  size_t bytesDown() const;

 private:
  struct State;
  const std::shared_ptr<State> state_;
};

}  // namespace warpscope::net

// TLS over TCP, as tls_policy.h says: the server shows its certificate, the client accepts exactly the one whose fingerprint it was given.
// TLS 1.3: RFC 8446; 1.2: RFC 5246. No certificate authorities and no names: addresses carry the fingerprint (see address.h).
#pragma once

#include <boost/asio/ssl.hpp>
#include <memory>

#include "net/certificate.h"
#include "net/tcp_stream.h"

namespace warpscope::net {

/// The server showed another certificate than the one asked for: it is another server, or somebody in between.
class FingerprintMismatch : public system_error {
 public:
  FingerprintMismatch(const std::string& peer, const Fingerprint& expected, const Fingerprint& shown);

  /// what() without the code's own words.
  const std::string& sentence() const { return sentence_; }

 private:
  explicit FingerprintMismatch(const std::string& sentence);

  std::string sentence_;
};

/// What the peer says is no TLS.
class NoTls : public system_error {
 public:
  using system_error::system_error;
};

/// An end of the connection without TLS's own farewell is an error (ssl::error::stream_truncated): bytes may be missing.
class TlsStream final : public Stream {
 public:
  using Context = std::shared_ptr<asio::ssl::context>;

  /// A stream that has not shaken hands yet: openTls() and acceptTls() make them.
  TlsStream(std::unique_ptr<TcpStream> tcp, Context context);

  using Stream::write;
  Awaitable<size_t> readSome(asio::mutable_buffer buffer) override;
  Awaitable<void> write(std::span<const asio::const_buffer> buffers) override;
  Awaitable<void> finish(TimePoint deadline) override;
  void close() noexcept override { tcp_->close(); }
  void abort() noexcept override { tcp_->abort(); }
  asio::any_io_executor executor() override { return tcp_->executor(); }
  const std::string& peer() const override { return tcp_->peer(); }

  /// "TLSv1.3"
  std::string version();

 private:
  friend class TlsHandshake;

  const Context context_;
  const std::unique_ptr<TcpStream> tcp_;
  asio::ssl::stream<asio::ip::tcp::socket&> ssl_;
  bool hasEnded_ = false;
  bool isFinishing_ = false;
};

/// What every connection of a server shares. Throws system_error.
TlsStream::Context makeServerContext(const Identity& identity);

/// The server's side of the handshake. Throws DeadlineExceeded, NoTls, or system_error.
Awaitable<std::unique_ptr<TlsStream>> acceptTls(std::unique_ptr<TcpStream> tcp, TlsStream::Context context, TimePoint deadline);

/// The client's side. Nothing is sent to a server with another certificate. Throws as acceptTls(), or FingerprintMismatch.
Awaitable<std::unique_ptr<TlsStream>> openTls(std::unique_ptr<TcpStream> tcp, Fingerprint expected, TimePoint deadline);

}  // namespace warpscope::net

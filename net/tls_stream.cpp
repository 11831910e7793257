// Handshakes, the check of the fingerprint, farewells.
// See tls_stream.h.
#include "net/tls_stream.h"

#include <openssl/crypto.h>
#include <openssl/x509.h>

#include <array>

#include "net/deadline.h"

namespace warpscope::net {
namespace {

namespace ssl = asio::ssl;

/// What the client expects, and what it was shown.
struct Pin {
  Fingerprint expected;
  Fingerprint shown{};
  bool isMatched = false;
  bool isShown = false;
};

/// In place of OpenSSL's verification, which knows only authorities.
int verifyPin(X509_STORE_CTX* store, void* argument) {
  Pin& pin = *static_cast<Pin*>(argument);
  unsigned size = 0;
  const X509* const certificate = X509_STORE_CTX_get0_cert(store);
  pin.isShown = certificate != nullptr && X509_digest(certificate, EVP_sha256(), pin.shown.data(), &size) == 1 && size == pin.shown.size();
  pin.isMatched = pin.isShown && CRYPTO_memcmp(pin.shown.data(), pin.expected.data(), pin.expected.size()) == 0;
  X509_STORE_CTX_set_error(store, pin.isMatched ? X509_V_OK : X509_V_ERR_CERT_REJECTED);
  return pin.isMatched ? 1 : 0;
}

TlsStream::Context newContext(ssl::context::method side) {
  auto context = std::make_shared<ssl::context>(side);
  if (SSL_CTX_set_min_proto_version(context->native_handle(), TLS1_2_VERSION) != 1)
    throw system_error(ssl::error::unspecified_system_error, "this OpenSSL cannot do TLS 1.2");
  SSL_CTX_set_options(context->native_handle(), SSL_OP_NO_RENEGOTIATION | SSL_OP_NO_COMPRESSION);
  return context;
}

/// The words for what peers that do not speak TLS look like.
bool isNoTls(const error_code& error) {
  if (error.category() != asio::error::get_ssl_category()) return false;
  switch (ERR_GET_REASON(static_cast<unsigned long>(error.value()))) {
    case SSL_R_WRONG_VERSION_NUMBER:
    case SSL_R_HTTP_REQUEST:
    case SSL_R_HTTPS_PROXY_REQUEST:
    case SSL_R_UNKNOWN_PROTOCOL:
    case SSL_R_UNEXPECTED_MESSAGE:
    case SSL_R_PACKET_LENGTH_TOO_LONG:
    case SSL_R_BAD_PACKET_LENGTH:
      return true;
    default:
      return false;
  }
}

/// A server's fatal "user canceled": it has no place for this connection. RFC 8446, section 6.1.
bool isFull(const error_code& error) {
  return error.category() == asio::error::get_ssl_category() && ERR_GET_REASON(static_cast<unsigned long>(error.value())) == SSL_R_TLSV1_ALERT_USER_CANCELLED;
}

}  // namespace

FingerprintMismatch::FingerprintMismatch(const std::string& peer, const Fingerprint& expected, const Fingerprint& shown)
    : FingerprintMismatch("the server at " + peer + " is not the one that the address is for, or somebody is in between: its certificate has the "
                          "fingerprint " + fingerprintText(shown) + ", not " + fingerprintText(expected)) {}

FingerprintMismatch::FingerprintMismatch(const std::string& sentence)
    : system_error(make_error_code(boost::system::errc::permission_denied), sentence), sentence_(sentence) {}

/// What the two sides of the handshake have in common.
class TlsHandshake {
 public:
  /// OpenSSL's alert stays in Asio's buffers when the handshake fails, and the peer would see an end that says nothing.
  static Awaitable<void> sayThatThisIsTls(TlsStream& stream, TimePoint deadline) {
    // A fatal "unexpected message": RFC 8446, sections 5.1 and 6.2.
    constexpr std::array<uint8_t, 7> kAlert{21, 3, 3, 0, 2, 2, 10};
    try {
      co_await withDeadline(*stream.tcp_, deadline, "refusing", stream.tcp_->write(asio::buffer(kAlert)));
    } catch (const system_error&) {
      // It is gone already: nobody is left to be told.
    }
  }

  static Awaitable<void> shakeHands(TlsStream& stream, ssl::stream_base::handshake_type side, TimePoint deadline) {
    error_code error;
    {
      const Watchdog watchdog(stream.executor(), deadline, [&stream] { stream.abort(); });
      co_await stream.ssl_.async_handshake(side, into(error));
      if (watchdog.hasExpired()) throw DeadlineExceeded("TLS handshake with " + stream.peer());
    }
    if (!error) co_return;
    if (isFull(error)) throw std::runtime_error(stream.peer() + " has no room for another connection");
    const std::string what = "TLS handshake with " + stream.peer();
    if (!isNoTls(error)) throw system_error(error, what);
    if (side == ssl::stream_base::server) co_await sayThatThisIsTls(stream, deadline);
    throw NoTls(error, what + ": the peer does not speak TLS");
  }
};

TlsStream::TlsStream(std::unique_ptr<TcpStream> tcp, Context context)
    : context_(std::move(context)), tcp_(std::move(tcp)), ssl_(tcp_->socket(), *context_) {}

Awaitable<size_t> TlsStream::readSome(asio::mutable_buffer buffer) {
  error_code error = asio::error::operation_aborted;
  size_t count = 0;
  if (!tcp_->isClosed() && !isFinishing_) {
    if (hasEnded_) co_return 0;
    count = co_await ssl_.async_read_some(buffer, into(error));
    hasEnded_ = error == asio::error::eof;
    // Asio reports a broken connection once: a farewell that waits for the peer's would not hear of it.
    if (error && !hasEnded_ && isFinishing_) tcp_->close();
  }
  if (tcp_->isClosed()) error = asio::error::operation_aborted;
  if (error == asio::error::eof) co_return 0;
  if (error) throw system_error(error, "reading from " + peer());
  co_return count;
}

Awaitable<void> TlsStream::write(std::span<const asio::const_buffer> buffers) {
  error_code error = asio::error::operation_aborted;
  if (!tcp_->isClosed()) co_await asio::async_write(ssl_, buffers, into(error));
  if (tcp_->isClosed()) error = asio::error::operation_aborted;
  if (error) throw system_error(error, "writing to " + peer());
}

Awaitable<void> TlsStream::finish(TimePoint deadline) {
  if (tcp_->isClosed() || std::exchange(isFinishing_, true)) co_return;
  {
    // The farewell waits for the peer's, which may never come.
    const Watchdog watchdog(executor(), deadline, [this] { close(); });
    error_code ignored;
    co_await ssl_.async_shutdown(into(ignored));
  }
  co_await tcp_->finish(deadline);
}

std::string TlsStream::version() { return SSL_get_version(ssl_.native_handle()); }

TlsStream::Context makeServerContext(const Identity& identity) {
  TlsStream::Context context = newContext(ssl::context::tls_server);
  context->use_private_key(asio::buffer(identity.keyPem), ssl::context::pem);
  context->use_certificate(asio::buffer(identity.certificatePem), ssl::context::pem);
  // Sessions are not resumed; tickets would be bytes that a client which only writes never reads, and whose end would be a reset.
  SSL_CTX_set_num_tickets(context->native_handle(), 0);
  SSL_CTX_set_session_cache_mode(context->native_handle(), SSL_SESS_CACHE_OFF);
  return context;
}

Awaitable<std::unique_ptr<TlsStream>> acceptTls(std::unique_ptr<TcpStream> tcp, TlsStream::Context context, TimePoint deadline) {
  auto stream = std::make_unique<TlsStream>(std::move(tcp), std::move(context));
  co_await TlsHandshake::shakeHands(*stream, ssl::stream_base::server, deadline);
  co_return stream;
}

Awaitable<std::unique_ptr<TlsStream>> openTls(std::unique_ptr<TcpStream> tcp, Fingerprint expected, TimePoint deadline) {
  // Used in the handshake alone: renegotiation is off.
  Pin pin{expected};
  const TlsStream::Context context = newContext(ssl::context::tls_client);
  SSL_CTX_set_verify(context->native_handle(), SSL_VERIFY_PEER, nullptr);
  SSL_CTX_set_cert_verify_callback(context->native_handle(), verifyPin, &pin);
  auto stream = std::make_unique<TlsStream>(std::move(tcp), context);
  std::exception_ptr failure;
  try {
    co_await TlsHandshake::shakeHands(*stream, ssl::stream_base::client, deadline);
  } catch (const std::exception&) {
    failure = std::current_exception();
  }
  SSL_CTX_set_cert_verify_callback(context->native_handle(), nullptr, nullptr);
  if (pin.isShown && !pin.isMatched) throw FingerprintMismatch(stream->peer(), pin.expected, pin.shown);
  if (failure) std::rethrow_exception(failure);
  // A handshake cannot succeed without a certificate; should it ever, this is where it ends.
  if (!pin.isMatched) throw system_error(ssl::error::unexpected_result, "the server at " + stream->peer() + " showed no certificate");
  co_return stream;
}

}  // namespace warpscope::net

// Where a server is, as one URL: warp://HOST:PORT in the clear, warps://HOST:PORT/#fp=HEX&token=BASE64URL through TLS.
// The form of URLs: RFC 3986. What follows the # is the secret part; it says by what to know the server, and what to show it.
#pragma once

#include <cstdint>
#include <optional>
#include <stdexcept>
#include <string>
#include <string_view>

#include "net/fingerprint.h"
#include "net/token.h"

namespace warpscope::net {

inline constexpr uint16_t kDefaultPort = 4711;

/// An address that is none. The sentence says what would be right, and never holds a token.
class AddressError : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

struct HostPort {
  std::string host;  ///< a name, or an IPv4 or IPv6 address, without brackets
  uint16_t port = kDefaultPort;

  bool operator==(const HostPort&) const = default;
};

/// What a client of a TLS server has to know.
struct Credentials {
  Fingerprint fingerprint;  ///< of the server's certificate
  Token token;

  bool operator==(const Credentials&) const = default;
};

struct Address {
  HostPort where;
  std::optional<Credentials> credentials;  ///< with them TLS, without them plain TCP

  bool isEncrypted() const { return credentials.has_value(); }
  bool operator==(const Address&) const = default;
};

/// Reads a URL. A missing port is kDefaultPort. Throws AddressError.
Address parseAddress(std::string_view url);

/// Reads HOST:PORT, HOST, [IPV6]:PORT or [IPV6], as one says where to listen: port 0 stands for a free one. Throws AddressError.
HostPort parseListenAddress(std::string_view text);

/// IPv6 addresses get their brackets.
std::string toString(const HostPort& where);
/// With the token: for handing over, and never for logs.
std::string toString(const Address& address);
/// For logs: with three dots for the token.
std::string toStringWithoutToken(const Address& address);

/// Whether `host` is this machine and nobody else can reach it: localhost, 127.0.0.0/8, ::1. Servers listen elsewhere through TLS only.
bool isLoopback(std::string_view host);

}  // namespace warpscope::net

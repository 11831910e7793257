// Taking URLs apart and putting them together.
// See address.h.
#include "net/address.h"

#include <algorithm>
#include <charconv>

#include "net/asio.h"

namespace warpscope::net {
namespace {

constexpr std::string_view kPlainScheme = "warp://", kEncryptedScheme = "warps://";
constexpr std::string_view kForms = "warp://HOST:PORT or warps://HOST:PORT/#fp=FINGERPRINT&token=TOKEN";
constexpr size_t kLongestHost = 253;  // RFC 1035, 2.3.4, without the root's dot
constexpr size_t kLongestShown = 100;

std::string shownInQuotes(std::string_view text) {
  return text.size() <= kLongestShown ? "'" + std::string(text) + "'" : "'" + std::string(text.substr(0, kLongestShown)) + "...'";
}

/// Sentences begin with what they are about.
[[noreturn]] void refuse(std::string_view subject, std::string_view sentence) {
  throw AddressError(shownInQuotes(subject) + ": " + std::string(sentence));
}

bool isDigit(char c) { return c >= '0' && c <= '9'; }
bool isNameCharacter(char c) { return isDigit(c) || (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || c == '-' || c == '.' || c == '_'; }

/// `shown` is what the sentences are about, `leastPort` the lowest one that is allowed.
uint16_t parsePort(std::string_view text, std::string_view shown, unsigned leastPort) {
  unsigned port = 0;
  const char* const end = text.data() + text.size();
  const auto [stop, error] = std::from_chars(text.data(), end, port);
  if (error != std::errc{} || stop != end || port < leastPort || port > 65535)
    refuse(shown, "the port must be a number from " + std::to_string(leastPort) + " to 65535, not " + shownInQuotes(text));
  return static_cast<uint16_t>(port);
}

void requireHost(std::string_view host, std::string_view shown) {
  if (host.empty()) refuse(shown, "the host is missing");
  if (host.size() > kLongestHost) refuse(shown, "the host is longer than " + std::to_string(kLongestHost) + " characters");
  const auto wrong = std::find_if_not(host.begin(), host.end(), isNameCharacter);
  if (wrong != host.end()) refuse(shown, "a host has no " + shownInQuotes(std::string_view(&*wrong, 1)));
  if (!std::all_of(host.begin(), host.end(), [](char c) { return isDigit(c) || c == '.'; })) return;
  error_code error;
  asio::ip::make_address_v4(std::string(host), error);
  if (error) refuse(shown, shownInQuotes(host) + " is no IPv4 address");
}

HostPort parseHostPort(std::string_view text, std::string_view shown, unsigned leastPort) {
  HostPort where;
  std::string_view rest;
  if (text.starts_with('[')) {
    const size_t bracket = text.find(']');
    if (bracket == std::string_view::npos) refuse(shown, "the ] after the IPv6 address is missing");
    where.host = text.substr(1, bracket - 1);
    error_code error;
    asio::ip::make_address_v6(where.host, error);
    if (error) refuse(shown, shownInQuotes(where.host) + " is no IPv6 address");
    rest = text.substr(bracket + 1);
    if (!rest.empty() && rest[0] != ':') refuse(shown, "after ] comes nothing, or : and the port");
  } else {
    if (std::count(text.begin(), text.end(), ':') > 1) refuse(shown, "an IPv6 address goes into brackets, as in [::1]:4711");
    const size_t colon = std::min(text.find(':'), text.size());
    where.host = text.substr(0, colon);
    requireHost(where.host, shown);
    rest = text.substr(colon);
  }
  if (!rest.empty()) where.port = parsePort(rest.substr(1), shown, leastPort);
  return where;
}

/// In place of a token that is not shown.
constexpr std::string_view kNoToken = "...";

/// `fragment`: what follows the #. `shown` is what stands before it.
Credentials parseCredentials(std::string_view fragment, std::string_view shown) {
  std::optional<Fingerprint> fingerprint;
  std::optional<Token> token;
  while (!fragment.empty()) {
    const size_t length = std::min(fragment.find('&'), fragment.size());
    const std::string_view part = fragment.substr(0, length);
    fragment.remove_prefix(std::min(length + 1, fragment.size()));
    // What is wrong here may be a mistyped token: it is not repeated.
    if (part.starts_with("fp=")) {
      if (fingerprint) refuse(shown, "there are two fingerprints after the #");
      fingerprint = parseFingerprint(part.substr(3));
      if (!fingerprint) refuse(shown, "the fingerprint (fp=) must be 64 hexadecimal digits");
    } else if (part.starts_with("token=")) {
      if (token) refuse(shown, "there are two tokens after the #");
      if (part.substr(6) == kNoToken) refuse(shown, "its token was left out, as it is wherever an address is kept: give the whole address, as its server printed it");
      token = Token::parse(part.substr(6));
      if (!token) {
        refuse(shown, "the token (token=) must be " + std::to_string(Token::kCharacters) +
                          " characters of A-Z, a-z, 0-9, - and _; was the address copied whole?");
      }
    } else {
      refuse(shown, "after the # come fp=FINGERPRINT and token=TOKEN, joined by &, and nothing else");
    }
  }
  if (!fingerprint) refuse(shown, "the server's fingerprint is missing: warps://HOST:PORT/#fp=FINGERPRINT&token=TOKEN");
  if (!token) refuse(shown, "the token is missing: warps://HOST:PORT/#fp=FINGERPRINT&token=TOKEN");
  return {*fingerprint, *token};
}

std::string withToken(const Address& address, std::string_view token) {
  if (!address.credentials) return std::string(kPlainScheme) + toString(address.where);
  return std::string(kEncryptedScheme) + toString(address.where) + "/#fp=" + fingerprintText(address.credentials->fingerprint) +
         "&token=" + std::string(token);
}

}  // namespace

Address parseAddress(std::string_view url) {
  const size_t hash = std::min(url.find('#'), url.size());
  const std::string_view open = url.substr(0, hash);  // what may be shown
  const bool isEncrypted = open.starts_with(kEncryptedScheme);
  if (!isEncrypted && !open.starts_with(kPlainScheme)) refuse(open, "an address is " + std::string(kForms));
  std::string_view authority = open.substr((isEncrypted ? kEncryptedScheme : kPlainScheme).size());
  if (const size_t slash = authority.find('/'); slash != std::string_view::npos) {
    if (slash + 1 != authority.size()) refuse(open, "nothing may stand between the / after the port and the #");
    authority.remove_suffix(1);
  }
  Address address{parseHostPort(authority, open, 1), {}};
  if (isEncrypted)
    address.credentials = parseCredentials(hash < url.size() ? url.substr(hash + 1) : std::string_view(), open);
  else if (hash < url.size())
    refuse(open, "warp:// is not encrypted and has neither fingerprint nor token; is it warps://?");
  return address;
}

HostPort parseListenAddress(std::string_view text) { return parseHostPort(text, text, 0); }

std::string toString(const HostPort& where) {
  const bool needsBrackets = where.host.find(':') != std::string::npos;
  return (needsBrackets ? "[" + where.host + "]" : where.host) + ":" + std::to_string(where.port);
}

std::string toString(const Address& address) {
  return withToken(address, address.credentials ? address.credentials->token.text() : std::string());
}

std::string toStringWithoutToken(const Address& address) { return withToken(address, kNoToken); }

bool isLoopback(std::string_view host) {
  if (host == "localhost") return true;
  error_code error;
  const asio::ip::address address = asio::ip::make_address(std::string(host), error);
  if (error) return false;
  if (!address.is_v6() || !address.to_v6().is_v4_mapped()) return address.is_loopback();
  return asio::ip::make_address_v4(asio::ip::v4_mapped, address.to_v6()).is_loopback();
}

}  // namespace warpscope::net

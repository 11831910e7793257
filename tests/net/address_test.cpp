// URLs: what is read, what is refused and with which words, what is printed, and that tokens stay out of both logs and complaints.
// Mirrors net/address.h.
#include "net/address.h"

#include <gmock/gmock.h>

#include "tests/complaint.h"

namespace warpscope::net {
namespace {

using testing::HasSubstr;
using testing::Not;

constexpr char kFingerprint[] = "00112233445566778899aabbccddeeff0123456789abcdef0123456789abcdef";
constexpr char kToken[] = "ABCDEFGHIJKLMNOPabcdefghijkl-_09";

std::string complaintOf(std::string_view url) {
  return warpscope::complaintOf<AddressError>([&] { parseAddress(url); });
}

std::string encrypted(const std::string& where) { return "warps://" + where + "/#fp=" + kFingerprint + "&token=" + kToken; }

TEST(Address, ReadsPlainOnes) {
  struct Case {
    std::string_view url, host;
    uint16_t port;
  };
  for (const auto& [url, host, port] : {
           Case{"warp://127.0.0.1:80", "127.0.0.1", 80},
           Case{"warp://127.0.0.1:80/", "127.0.0.1", 80},
           Case{"warp://localhost", "localhost", kDefaultPort},
           Case{"warp://localhost/", "localhost", kDefaultPort},
           Case{"warp://render-1.example_lab.org:65535", "render-1.example_lab.org", 65535},
           Case{"warp://[::1]:1", "::1", 1},
           Case{"warp://[fe80::1]", "fe80::1", kDefaultPort},
       }) {
    SCOPED_TRACE(url);
    const Address address = parseAddress(url);
    EXPECT_EQ(address.where.host, host);
    EXPECT_EQ(address.where.port, port);
    EXPECT_FALSE(address.isEncrypted());
    EXPECT_EQ(parseAddress(toString(address)), address);
  }
}

TEST(Address, ReadsEncryptedOnes) {
  for (const char* const where : {"10.0.0.7:4711", "[2001:db8::7]:4711", "host:4711"}) {
    const Address address = parseAddress(encrypted(where));
    ASSERT_TRUE(address.isEncrypted());
    EXPECT_EQ(fingerprintText(address.credentials->fingerprint), kFingerprint);
    EXPECT_EQ(address.credentials->token.text(), kToken);
    EXPECT_EQ(toString(address), encrypted(where));
    EXPECT_EQ(parseAddress(toString(address)), address);
  }
}

TEST(Address, TheOrderAfterTheHashAndTheCaseOfDigitsDoNotMatter) {
  std::string upper = kFingerprint;
  for (char& c : upper) c = static_cast<char>(std::toupper(c));
  EXPECT_EQ(parseAddress("warps://h:1/#token=" + std::string(kToken) + "&fp=" + upper), parseAddress(encrypted("h:1")));
  EXPECT_EQ(parseAddress("warps://h:1#fp=" + upper + "&token=" + kToken), parseAddress(encrypted("h:1")));
}

TEST(Address, SaysWhatIsWrong) {
  struct Case {
    std::string url;
    std::string_view complaint;
  };
  const std::string fp = std::string("fp=") + kFingerprint, token = std::string("token=") + kToken;
  for (const auto& [url, complaint] : {
           Case{"", "'': an address is warp://HOST:PORT or warps://"},
           Case{"http://host:1", "'http://host:1': an address is warp://HOST:PORT"},
           Case{"host:1", "an address is warp://HOST:PORT"},
           Case{"warp://", "the host is missing"},
           Case{"warp://:1", "the host is missing"},
           Case{"warp://host:", "the port must be a number from 1 to 65535, not ''"},
           Case{"warp://host:0", "the port must be a number from 1 to 65535, not '0'"},
           Case{"warp://host:65536", "from 1 to 65535, not '65536'"},
           Case{"warp://host:-1", "not '-1'"},
           Case{"warp://host:1x", "not '1x'"},
           Case{"warp://host:99999999999999999999", "not '99999999999999999999'"},
           Case{"warp://::1:4711", "an IPv6 address goes into brackets"},
           Case{"warp://[::1", "the ] after the IPv6 address is missing"},
           Case{"warp://[::1]4711", "after ] comes nothing, or : and the port"},
           Case{"warp://[::g]:1", "'::g' is no IPv6 address"},
           Case{"warp://[]:1", "'' is no IPv6 address"},
           Case{"warp://300.1.1.1:1", "'300.1.1.1' is no IPv4 address"},
           Case{"warp://user@host:1", "a host has no '@'"},
           Case{"warp://ho st:1", "a host has no ' '"},
           Case{"warp://" + std::string(254, 'a'), "longer than 253"},
           Case{"warp://host:1/path", "nothing may stand between the / after the port and the #"},
           Case{"warp://host:1/#" + fp, "warp:// is not encrypted"},
           Case{"warps://host:1", "the server's fingerprint is missing"},
           Case{"warps://host:1/#", "the server's fingerprint is missing"},
           Case{"warps://host:1/#" + token, "the server's fingerprint is missing"},
           Case{"warps://host:1/#" + fp, "the token is missing"},
           Case{"warps://host:1/#fp=12&" + token, "the fingerprint (fp=) must be 64 hexadecimal digits"},
           Case{"warps://host:1/#" + fp + "&" + fp + "&" + token, "two fingerprints"},
           Case{"warps://host:1/#" + token + "&" + fp + "&" + token, "two tokens"},
           Case{"warps://host:1/#" + fp + "&token=short", "the token (token=) must be 32 characters"},
           Case{"warps://host:1/#" + fp + "&" + token + "&x=1", "and nothing else"},
           Case{"warps://host:1/#" + fp + ";" + token, "must be 64 hexadecimal digits"},
       })
    EXPECT_THAT(complaintOf(url), HasSubstr(complaint)) << url;
}

TEST(Address, NeitherLogsNorComplaintsHoldTokens) {
  const std::string url = encrypted("host:1");
  EXPECT_THAT(toStringWithoutToken(parseAddress(url)), Not(HasSubstr(kToken)));
  EXPECT_EQ(toStringWithoutToken(parseAddress(url)), std::string("warps://host:1/#fp=") + kFingerprint + "&token=...");
  EXPECT_EQ(toStringWithoutToken(parseAddress("warp://host:1")), "warp://host:1");
  // Each character mistyped leads to a complaint, and none of these has the token's text.
  for (size_t i = 0; i < url.size(); ++i) {
    std::string mistyped = url;
    mistyped[i] = '!';
    const std::string complaint = complaintOf(mistyped);
    EXPECT_NE(complaint, "") << mistyped;
    EXPECT_THAT(complaint, Not(HasSubstr("klm"))) << mistyped;
    EXPECT_THAT(complaint, Not(HasSubstr("-_0"))) << mistyped;
  }
}

TEST(Address, WhereToListen) {
  EXPECT_EQ(parseListenAddress("0.0.0.0:0"), (HostPort{"0.0.0.0", 0}));
  EXPECT_EQ(parseListenAddress("[::]:17"), (HostPort{"::", 17}));
  EXPECT_EQ(parseListenAddress("localhost"), (HostPort{"localhost", kDefaultPort}));
  EXPECT_EQ(toString(HostPort{"::", 17}), "[::]:17");
  EXPECT_THROW(parseListenAddress("host:65536"), AddressError);
  EXPECT_THROW(parseListenAddress(""), AddressError);
  EXPECT_THROW(parseListenAddress("warp://host:1"), AddressError);
}

TEST(Address, KnowsThisMachine) {
  for (const char* const host : {"localhost", "127.0.0.1", "127.255.0.9", "::1", "::ffff:127.0.0.1"}) EXPECT_TRUE(isLoopback(host)) << host;
  for (const char* const host : {"0.0.0.0", "::", "10.0.0.1", "128.0.0.1", "::2", "::ffff:10.0.0.1", "localhost.example.org", ""})
    EXPECT_FALSE(isLoopback(host)) << host;
}

}  // namespace
}  // namespace warpscope::net

// Which versions and suites of TLS the two sides take, against peers that offer others.
// Mirrors net/tls_policy.h; the peers are OpenSSL's own ends, joined in memory.
#include "net/tls_policy.h"

#include <gmock/gmock.h>
#include <openssl/err.h>
#include <openssl/pem.h>

#include <memory>

#include "net/certificate.h"

namespace warpscope::net {
namespace {

using Context = std::unique_ptr<SSL_CTX, decltype(&SSL_CTX_free)>;

/// An end without a policy: it takes what OpenSSL can do at all.
Context lax(bool isServer) {
  Context context(SSL_CTX_new(isServer ? TLS_server_method() : TLS_client_method()), SSL_CTX_free);
  SSL_CTX_set_security_level(context.get(), 0);
  SSL_CTX_set_min_proto_version(context.get(), TLS1_VERSION);
  SSL_CTX_set_cipher_list(context.get(), "ALL:@SECLEVEL=0");
  return context;
}

Context ours(bool isServer) {
  Context context(SSL_CTX_new(isServer ? TLS_server_method() : TLS_client_method()), SSL_CTX_free);
  EXPECT_TRUE(applyTlsPolicy(context.get()));
  return context;
}

void show(SSL_CTX* server, const Identity& identity) {
  BIO* const key = BIO_new_mem_buf(identity.keyPem.data(), static_cast<int>(identity.keyPem.size()));
  BIO* const certificate = BIO_new_mem_buf(identity.certificatePem.data(), static_cast<int>(identity.certificatePem.size()));
  EVP_PKEY* const read = PEM_read_bio_PrivateKey(key, nullptr, nullptr, nullptr);
  X509* const shown = PEM_read_bio_X509(certificate, nullptr, nullptr, nullptr);
  EXPECT_EQ(SSL_CTX_use_certificate(server, shown), 1);
  EXPECT_EQ(SSL_CTX_use_PrivateKey(server, read), 1);
  X509_free(shown);
  EVP_PKEY_free(read);
  BIO_free(key);
  BIO_free(certificate);
}

/// Version and suite that the two agree on; empty if they do not.
std::string agreed(SSL_CTX* client, SSL_CTX* server) {
  static const Identity kIdentity = makeIdentity();
  show(server, kIdentity);
  using Ssl = std::unique_ptr<SSL, decltype(&SSL_free)>;
  const Ssl a(SSL_new(client), SSL_free), b(SSL_new(server), SSL_free);
  BIO *ofA = nullptr, *ofB = nullptr;
  BIO_new_bio_pair(&ofA, 0, &ofB, 0);
  SSL_set_bio(a.get(), ofA, ofA);
  SSL_set_bio(b.get(), ofB, ofB);
  SSL_set_connect_state(a.get());
  SSL_set_accept_state(b.get());
  for (int i = 0; i < 20; ++i) {
    const int doneA = SSL_do_handshake(a.get()), doneB = SSL_do_handshake(b.get());
    if (doneA == 1 && doneB == 1) return std::string(SSL_get_version(a.get())) + " " + SSL_get_cipher_name(a.get());
    const auto waits = [](const SSL* end, int done) { return done == 1 || SSL_get_error(end, done) == SSL_ERROR_WANT_READ || SSL_get_error(end, done) == SSL_ERROR_WANT_WRITE; };
    if (!waits(a.get(), doneA) || !waits(b.get(), doneB)) break;
  }
  ERR_clear_error();
  return "";
}

void only(SSL_CTX* context, int version, const char* suites) {
  SSL_CTX_set_min_proto_version(context, version);
  SSL_CTX_set_max_proto_version(context, version);
  if (suites != nullptr) ASSERT_EQ(SSL_CTX_set_cipher_list(context, (std::string(suites) + ":@SECLEVEL=0").c_str()), 1) << suites;
}

struct Offer {
  int version;
  const char* suites;
  const char* expected;  ///< what comes of it among ours; empty: nothing
};

TEST(TlsPolicy, TakesAeadAloneOnBothSides) {
  EXPECT_THAT(agreed(ours(false).get(), ours(true).get()), testing::StartsWith("TLSv1.3 "));
  const Offer offers[] = {
      {TLS1_3_VERSION, nullptr, "TLSv1.3 "},
      {TLS1_2_VERSION, "ECDHE-ECDSA-AES128-GCM-SHA256", "TLSv1.2 ECDHE-ECDSA-AES128-GCM-SHA256"},
      {TLS1_2_VERSION, "ECDHE-ECDSA-CHACHA20-POLY1305", "TLSv1.2 ECDHE-ECDSA-CHACHA20-POLY1305"},
      {TLS1_2_VERSION, "ECDHE-ECDSA-AES128-SHA", ""},     // CBC, SHA-1
      {TLS1_2_VERSION, "ECDHE-ECDSA-AES256-SHA384", ""},  // CBC
      {TLS1_2_VERSION, "AECDH-AES128-SHA", ""},           // nobody is shown
      {TLS1_1_VERSION, "ALL", ""},
      {TLS1_VERSION, "ALL", ""},
  };
  for (const bool isClientOurs : {false, true})
    for (const Offer& offer : offers) {
      SCOPED_TRACE(std::to_string(offer.version) + " " + (offer.suites != nullptr ? offer.suites : "") + (isClientOurs ? ", our client" : ", our server"));
      const Context foreign = lax(isClientOurs);
      only(foreign.get(), offer.version, offer.suites);
      const Context own = ours(!isClientOurs);
      const std::string found = isClientOurs ? agreed(own.get(), foreign.get()) : agreed(foreign.get(), own.get());
      if (*offer.expected == '\0')
        EXPECT_EQ(found, "");
      else
        EXPECT_THAT(found, testing::StartsWith(offer.expected));
      // It is the policy that makes the difference, not what this OpenSSL can do.
      const Context other = lax(!isClientOurs);
      EXPECT_NE(isClientOurs ? agreed(other.get(), foreign.get()) : agreed(foreign.get(), other.get()), "");
    }
}

}  // namespace
}  // namespace warpscope::net

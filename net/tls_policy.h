// What both sides of a connection ask of TLS: version 1.3, or 1.2 with suites that keep earlier connections secret and check what they decrypt.
// RFC 9325 (recommendations for TLS), sections 3.1 and 4.2; AEAD: RFC 5116.
#pragma once

#include <openssl/ssl.h>

namespace warpscope::net {

/// Sets versions, suites and what may be negotiated besides. False if this OpenSSL cannot do that.
bool applyTlsPolicy(SSL_CTX* context);

}  // namespace warpscope::net

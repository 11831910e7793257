// The lists.
// See tls_policy.h.
#include "net/tls_policy.h"

namespace warpscope::net {

bool applyTlsPolicy(SSL_CTX* context) {
  SSL_CTX_set_options(context, SSL_OP_NO_RENEGOTIATION | SSL_OP_NO_COMPRESSION);
  // All suites of TLS 1.3 are AEAD; the machine's configuration may leave some out. Of 1.2 those whose keys are of this connection alone (ECDHE).
  return SSL_CTX_set_min_proto_version(context, TLS1_2_VERSION) == 1 &&
         SSL_CTX_set_cipher_list(context, "ECDHE+AESGCM:ECDHE+CHACHA20:!aNULL:!PSK") == 1;
}

}  // namespace warpscope::net

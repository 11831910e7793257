// The server's identity: a key and a self-signed certificate, made on first use and kept, so that clients know it again.
// EC P-256 (FIPS 186-4) with SHA-256; X.509 v3 (RFC 5280). Clients pin the fingerprint, so names and dates in it decide nothing.
#pragma once

#include <filesystem>
#include <stdexcept>
#include <string>

#include "net/fingerprint.h"

namespace warpscope::net {

/// A key or certificate that cannot be made, read or kept. The sentence names the file.
class CertificateError : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

struct Identity {
  std::string keyPem;  ///< PKCS #8, unencrypted: secret
  std::string certificatePem;
  Fingerprint fingerprint{};
};

/// A new key and its certificate. Throws CertificateError.
Identity makeIdentity();

/// The identity in `folder`/identity.pem: key and certificate in one file of mode 0600, so that they are there together or not at all.
/// Without the file, makes the folder and the file; if several processes do so at once, all get the same. Throws CertificateError, also
/// if others than the owner can read the file.
Identity loadOrMakeIdentity(const std::filesystem::path& folder);

}  // namespace warpscope::net

// The server's identity: a key and a self-signed certificate, made on first use and kept, so that clients know it again.
// EC P-256 (FIPS 186-4) with SHA-256; X.509 v3 (RFC 5280). Clients pin the fingerprint, so names and dates in it decide nothing for them.
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
/// Without the file, makes the folder and the file; if several processes do so at once, all get the same. Throws CertificateError with what helps: also if
/// folder or file are not the user's own or not closed to others, for a link or a pipe in the file's place, a key that is weak, under a password or another
/// certificate's, and a certificate whose dates have passed.
Identity loadOrMakeIdentity(const std::filesystem::path& folder);

}  // namespace warpscope::net

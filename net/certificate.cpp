// Making keys and certificates with OpenSSL, and keeping them in a file that nobody else can read.
// See certificate.h.
#include "net/certificate.h"

#include <fcntl.h>
#include <openssl/err.h>
#include <openssl/pem.h>
#include <openssl/rand.h>
#include <openssl/x509v3.h>
#include <sys/stat.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <cstring>
#include <memory>
#include <string_view>

namespace warpscope::net {
namespace fs = std::filesystem;
namespace {

template <auto release>
struct Release {
  template <class T>
  void operator()(T* object) const {
    release(object);
  }
};
using Key = std::unique_ptr<EVP_PKEY, Release<EVP_PKEY_free>>;
using Certificate = std::unique_ptr<X509, Release<X509_free>>;
using Number = std::unique_ptr<BIGNUM, Release<BN_free>>;
using Memory = std::unique_ptr<BIO, Release<BIO_free>>;
using Extension = std::unique_ptr<X509_EXTENSION, Release<X509_EXTENSION_free>>;

constexpr const char* kFileName = "identity.pem";
constexpr long kSecondsPerDay = 86400, kYesterday = -kSecondsPerDay, kDays = 365 * 30;

[[noreturn]] void failOfOpenSsl(const std::string& what) {
  const unsigned long code = ERR_peek_last_error();
  ERR_clear_error();
  const char* const reason = ERR_reason_error_string(code);
  throw CertificateError(what + ": " + (reason != nullptr ? reason : "OpenSSL does not say why"));
}

void check(bool isDone, const char* what) {
  if (!isDone) failOfOpenSsl(std::string("cannot make a certificate: ") + what);
}

Memory newMemory() {
  Memory memory(BIO_new(BIO_s_mem()));
  check(memory != nullptr, "no memory");
  return memory;
}

std::string textOf(BIO* memory) {
  char* bytes = nullptr;
  const long size = BIO_get_mem_data(memory, &bytes);
  return {bytes, static_cast<size_t>(size)};
}

Fingerprint fingerprintOf(const X509* certificate) {
  Fingerprint fingerprint;
  unsigned size = 0;
  if (X509_digest(certificate, EVP_sha256(), fingerprint.data(), &size) != 1 || size != fingerprint.size())
    failOfOpenSsl("cannot take the fingerprint of a certificate");
  return fingerprint;
}

void setSerialNumber(X509* certificate) {
  constexpr int kBits = 127;  // positive, and at most 20 octets (RFC 5280, 4.1.2.2)
  const Number number(BN_new());
  check(number && BN_rand(number.get(), kBits, BN_RAND_TOP_ANY, BN_RAND_BOTTOM_ANY) == 1, "serial number");
  check(BN_to_ASN1_INTEGER(number.get(), X509_get_serialNumber(certificate)) != nullptr, "serial number");
}

void addExtension(X509* certificate, int which, const char* value) {
  X509V3_CTX context;
  X509V3_set_ctx_nodb(&context);
  X509V3_set_ctx(&context, certificate, certificate, nullptr, nullptr, 0);
  const Extension extension(X509V3_EXT_conf_nid(nullptr, &context, which, value));
  check(extension && X509_add_ext(certificate, extension.get(), -1) == 1, value);
}

/// A name in the error's place: strerror, and the file.
[[noreturn]] void failOfFile(const fs::path& path, const char* what) {
  throw CertificateError(path.string() + ": " + what + ": " + std::strerror(errno));
}

class File {
 public:
  explicit File(int descriptor) : descriptor_(descriptor) {}
  ~File() {
    if (descriptor_ >= 0) ::close(descriptor_);
  }
  File(const File&) = delete;
  File& operator=(const File&) = delete;
  operator int() const { return descriptor_; }

 private:
  const int descriptor_;
};

Identity parseIdentity(const std::string& pem, const fs::path& path) {
  static constexpr char kAdvice[] = "; remove the file to have a new identity made, which clients then have to be told";
  const auto refuse = [&](const char* what) -> void {
    ERR_clear_error();
    throw CertificateError(path.string() + ": " + what + kAdvice);
  };
  // A callback in place of a prompt: an encrypted key is refused instead of asked for on the terminal.
  const auto noPassword = [](char*, int, int, void*) { return -1; };
  const Memory keyText(BIO_new_mem_buf(pem.data(), static_cast<int>(pem.size())));
  const Memory certificateText(BIO_new_mem_buf(pem.data(), static_cast<int>(pem.size())));
  check(keyText && certificateText, "no memory");
  const Key key(PEM_read_bio_PrivateKey(keyText.get(), nullptr, noPassword, nullptr));
  if (!key) refuse("holds no private key");
  const Certificate certificate(PEM_read_bio_X509(certificateText.get(), nullptr, noPassword, nullptr));
  if (!certificate) refuse("holds no certificate");
  if (X509_check_private_key(certificate.get(), key.get()) != 1) refuse("holds a key and a certificate that do not belong together");

  const Memory keyOut = newMemory(), certificateOut = newMemory();
  check(PEM_write_bio_PrivateKey(keyOut.get(), key.get(), nullptr, nullptr, 0, nullptr, nullptr) == 1, "writing the key");
  check(PEM_write_bio_X509(certificateOut.get(), certificate.get()) == 1, "writing the certificate");
  return {textOf(keyOut.get()), textOf(certificateOut.get()), fingerprintOf(certificate.get())};
}

/// False if there is no such file.
bool readSecret(const fs::path& path, std::string& text) {
  constexpr size_t kLargest = 64 << 10;
  const File file(::open(path.c_str(), O_RDONLY | O_CLOEXEC));
  if (file < 0 && errno == ENOENT) return false;
  if (file < 0) failOfFile(path, "cannot be read");
  struct stat status;
  if (::fstat(file, &status) != 0) failOfFile(path, "cannot be read");
  if (!S_ISREG(status.st_mode)) throw CertificateError(path.string() + ": cannot be used as identity: it is no file");
  if ((status.st_mode & (S_IRWXG | S_IRWXO)) != 0)
    throw CertificateError(path.string() + ": others can read or change this key; chmod 600 it, or remove it to have a new one made");
  std::array<char, 4096> piece;
  while (true) {
    const ssize_t count = ::read(file, piece.data(), piece.size());
    if (count < 0 && errno == EINTR) continue;
    if (count < 0) failOfFile(path, "cannot be read");
    if (count == 0) return true;
    text.append(piece.data(), static_cast<size_t>(count));
    if (text.size() > kLargest) throw CertificateError(path.string() + ": is too large for a key and a certificate");
  }
}

void writeSecret(const fs::path& path, std::string_view text) {
  const File file(::open(path.c_str(), O_WRONLY | O_CREAT | O_EXCL | O_CLOEXEC, S_IRUSR | S_IWUSR));
  if (file < 0) failOfFile(path, "cannot be written");
  while (!text.empty()) {
    const ssize_t count = ::write(file, text.data(), text.size());
    if (count < 0 && errno == EINTR) continue;
    if (count < 0) failOfFile(path, "cannot be written");
    text.remove_prefix(static_cast<size_t>(count));
  }
  if (::fsync(file) != 0) failOfFile(path, "cannot be written");
}

/// Puts `text` at `path` unless something is there by then.
void putSecret(const fs::path& path, std::string_view text) {
  std::array<unsigned char, 8> random;
  check(RAND_bytes(random.data(), random.size()) == 1, "random numbers");
  fs::path partial = path;
  partial += ".partial-";
  for (const unsigned char byte : random) partial += std::to_string(byte);
  std::error_code ignored;
  try {
    writeSecret(partial, text);
    // Unlike a rename, a link does not replace what another process has put there. Not every file system has links.
    if (::link(partial.c_str(), path.c_str()) != 0 && errno != EEXIST && ::rename(partial.c_str(), path.c_str()) != 0)
      failOfFile(path, "cannot be written");
  } catch (...) {
    fs::remove(partial, ignored);
    throw;
  }
  fs::remove(partial, ignored);
}

}  // namespace

Identity makeIdentity() {
  const Key key(EVP_EC_gen("P-256"));
  check(key != nullptr, "key");
  const Certificate certificate(X509_new());
  check(certificate != nullptr, "no memory");
  X509* const made = certificate.get();
  check(X509_set_version(made, X509_VERSION_3) == 1, "version");
  setSerialNumber(made);
  // From yesterday on, as clocks differ.
  check(X509_gmtime_adj(X509_getm_notBefore(made), kYesterday) != nullptr, "dates");
  check(X509_time_adj_ex(X509_getm_notAfter(made), kDays, 0, nullptr) != nullptr, "dates");
  check(X509_set_pubkey(made, key.get()) == 1, "public key");
  X509_NAME* const name = X509_get_subject_name(made);
  check(X509_NAME_add_entry_by_txt(name, "CN", MBSTRING_ASC, reinterpret_cast<const unsigned char*>("warpscope"), -1, -1, 0) == 1, "name");
  check(X509_set_issuer_name(made, name) == 1, "issuer");
  addExtension(made, NID_basic_constraints, "critical,CA:FALSE");
  addExtension(made, NID_key_usage, "critical,digitalSignature");
  addExtension(made, NID_ext_key_usage, "serverAuth");
  check(X509_sign(made, key.get(), EVP_sha256()) > 0, "signature");

  const Memory keyText = newMemory(), certificateText = newMemory();
  check(PEM_write_bio_PrivateKey(keyText.get(), key.get(), nullptr, nullptr, 0, nullptr, nullptr) == 1, "writing the key");
  check(PEM_write_bio_X509(certificateText.get(), made) == 1, "writing the certificate");
  return {textOf(keyText.get()), textOf(certificateText.get()), fingerprintOf(made)};
}

Identity loadOrMakeIdentity(const fs::path& folder) {
  const fs::path path = folder / kFileName;
  std::string pem;
  if (readSecret(path, pem)) return parseIdentity(pem, path);

  std::error_code error;
  if (fs::create_directories(folder, error)) fs::permissions(folder, fs::perms::owner_all, error);
  if (error) throw CertificateError(folder.string() + ": cannot be made: " + error.message());
  const Identity made = makeIdentity();
  putSecret(path, made.keyPem + made.certificatePem);
  if (!readSecret(path, pem)) throw CertificateError(path.string() + ": was removed as soon as it was made");
  return parseIdentity(pem, path);
}

}  // namespace warpscope::net

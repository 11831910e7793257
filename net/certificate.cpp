// Making keys and certificates with OpenSSL, and keeping them in a file that nobody else can read.
// See certificate.h.
#include "net/certificate.h"

#include <fcntl.h>
#include <openssl/err.h>
#include <openssl/pem.h>
#include <openssl/rand.h>
#include <openssl/ssl.h>
#include <openssl/x509v3.h>
#include <sys/stat.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <cstring>
#include <ctime>
#include <memory>
#include <string_view>

#include "render/base/shell_word.h"

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
using Context = std::unique_ptr<SSL_CTX, Release<SSL_CTX_free>>;
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

std::string dateText(const ASN1_TIME* time) {
  tm date{};
  char text[16] = "";
  if (ASN1_TIME_to_tm(time, &date) == 1) std::strftime(text, sizeof text, "%Y-%m-%d", &date);
  return text;
}

/// What is wrong with a key and its certificate as such; empty if TLS takes them.
std::string faultOf(const EVP_PKEY* key, X509* certificate) {
  const int kind = EVP_PKEY_get_base_id(key);
  if (kind != EVP_PKEY_EC && kind != EVP_PKEY_RSA && kind != EVP_PKEY_ED25519 && kind != EVP_PKEY_ED448)
    return "holds a key of a kind that TLS does not sign with; take one of EC P-256 or RSA";
  constexpr int kLeastSecurityBits = 112;  // NIST SP 800-57, part 1: RSA of 2048 bits, curves of 224
  if (EVP_PKEY_get_security_bits(key) < kLeastSecurityBits)
    return "holds a key of " + std::to_string(EVP_PKEY_get_bits(key)) + " bits, which can be broken; RSA needs 2048, a curve 224";
  // Clients know the certificate by its fingerprint and look at no date: whoever gave it one meant it all the same.
  if (X509_cmp_current_time(X509_get0_notAfter(certificate)) < 0)
    return "holds a certificate that has expired on " + dateText(X509_get0_notAfter(certificate));
  if (X509_cmp_current_time(X509_get0_notBefore(certificate)) > 0)
    return "holds a certificate that is not valid before " + dateText(X509_get0_notBefore(certificate)) + "; look at this machine's clock, too";
  if (X509_check_private_key(certificate, key) != 1) return "holds a key and a certificate that do not belong together";
  // What else OpenSSL demands, such as of signatures, is its policy and depends on the machine.
  const Context context(SSL_CTX_new(TLS_server_method()));
  check(context != nullptr, "no memory");
  ERR_clear_error();
  if (SSL_CTX_use_certificate(context.get(), certificate) != 1 || SSL_CTX_use_PrivateKey(context.get(), const_cast<EVP_PKEY*>(key)) != 1) {
    const char* const reason = ERR_reason_error_string(ERR_peek_last_error());
    return "holds a certificate that TLS does not take: " + std::string(reason != nullptr ? reason : "OpenSSL does not say why");
  }
  return {};
}

Identity parseIdentity(const std::string& pem, const fs::path& path) {
  static constexpr char kAdvice[] = "; remove the file to have a new identity made, which clients then have to be told";
  const auto refuse = [&](const std::string& what) -> void {
    ERR_clear_error();
    throw CertificateError(path.string() + ": " + what + kAdvice);
  };
  // A callback in place of a prompt: an encrypted key is refused instead of asked for on the terminal.
  bool wantsPassword = false;
  const auto noPassword = [](char*, int, int, void* wanted) {
    *static_cast<bool*>(wanted) = true;
    return -1;
  };
  const Memory keyText(BIO_new_mem_buf(pem.data(), static_cast<int>(pem.size())));
  const Memory certificateText(BIO_new_mem_buf(pem.data(), static_cast<int>(pem.size())));
  check(keyText && certificateText, "no memory");
  const Key key(PEM_read_bio_PrivateKey(keyText.get(), nullptr, noPassword, &wantsPassword));
  if (!key && wantsPassword) refuse("holds a private key under a password, which a server has nobody to ask for; write it without one (openssl pkey -in FILE)");
  const auto damage = [&](const char* mark) { return pem.find(mark) != std::string::npos ? std::string(" that can be read: it is damaged") : std::string(); };
  if (!key) refuse("holds no private key" + damage("PRIVATE KEY-----"));
  const Certificate certificate(PEM_read_bio_X509(certificateText.get(), nullptr, noPassword, &wantsPassword));
  if (!certificate) refuse("holds no certificate" + damage("-----BEGIN CERTIFICATE"));
  if (const std::string fault = faultOf(key.get(), certificate.get()); !fault.empty()) refuse(fault);

  const Memory keyOut = newMemory(), certificateOut = newMemory();
  check(PEM_write_bio_PrivateKey(keyOut.get(), key.get(), nullptr, nullptr, 0, nullptr, nullptr) == 1, "writing the key");
  check(PEM_write_bio_X509(certificateOut.get(), certificate.get()) == 1, "writing the certificate");
  return {textOf(keyOut.get()), textOf(certificateOut.get()), fingerprintOf(certificate.get())};
}

/// Throws unless what is open is the user's, and closed to all others. Who may write to the folder may replace the key.
void requireOwn(int descriptor, const fs::path& path, const char* others, const char* mode) {
  struct stat status {};
  if (::fstat(descriptor, &status) != 0) failOfFile(path, "cannot be looked at");
  if (status.st_uid != ::geteuid())
    throw CertificateError(path.string() + ": belongs to another user (" + std::to_string(status.st_uid) + "), who can change the key in it; make it yours with: chown " +
                           std::to_string(::geteuid()) + " " + shellWord(path.string()));
  if ((status.st_mode & (S_IRWXG | S_IRWXO)) != 0)
    throw CertificateError(path.string() + ": others can " + others + "; close it to them with: chmod " + mode + " " + shellWord(path.string()));
}

/// The folder that the identity is in: open, so that nobody can put another one in its place between two looks at it.
class Folder {
 public:
  /// Makes it where it is missing, with those that it is in.
  explicit Folder(const fs::path& path) : path_(path), descriptor_(opened()) { requireOwn(descriptor_, path_, "look into this folder, where the server's key is", "700"); }

  /// False if there is no such file.
  bool read(const char* name, std::string& text) const {
    constexpr size_t kLargest = 64 << 10;
    const fs::path path = path_ / name;
    // Neither waits for a pipe nor goes where a link leads.
    const File file(::openat(descriptor_, name, O_RDONLY | O_CLOEXEC | O_NOFOLLOW | O_NONBLOCK | O_NOCTTY));
    if (file < 0 && errno == ENOENT) return false;
    if (file < 0 && errno == ELOOP)
      throw CertificateError(path.string() + ": is a symbolic link, which is not followed; put the file itself there, or remove the link to have a new identity made");
    struct stat status {};
    if (file < 0 && errno != ENXIO) failOfFile(path, "cannot be read");
    if (file < 0 || ::fstat(file, &status) != 0 || !S_ISREG(status.st_mode))
      throw CertificateError(path.string() + ": cannot be used as identity: it is no regular file; remove it to have a new one made");
    requireOwn(file, path, "read or change this key", "600");
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

  /// Writes `text` unless something is there by then.
  void put(const char* name, std::string_view text) const {
    std::array<unsigned char, 8> random;
    check(RAND_bytes(random.data(), random.size()) == 1, "random numbers");
    std::string partial = std::string(name) + ".partial-";
    for (const unsigned char byte : random) partial += std::to_string(byte);
    try {
      write(partial, text);
      // Unlike a rename, a link does not replace what another process has put there. Not every file system has links.
      if (::linkat(descriptor_, partial.c_str(), descriptor_, name, 0) != 0 && errno != EEXIST &&
          ::renameat(descriptor_, partial.c_str(), descriptor_, name) != 0)
        failOfFile(path_ / name, "cannot be written");
    } catch (...) {
      ::unlinkat(descriptor_, partial.c_str(), 0);
      throw;
    }
    ::unlinkat(descriptor_, partial.c_str(), 0);
  }

 private:
  int opened() const {
    constexpr int kHow = O_RDONLY | O_DIRECTORY | O_CLOEXEC;
    int folder = ::open(path_.c_str(), kHow);
    if (folder < 0 && errno == ENOENT) {
      std::error_code error;
      if (path_.has_parent_path()) fs::create_directories(path_.parent_path(), error);
      if (error) throw CertificateError(path_.string() + ": cannot be made: " + error.message());
      if (::mkdir(path_.c_str(), S_IRWXU) != 0 && errno != EEXIST) failOfFile(path_, "cannot be made");
      folder = ::open(path_.c_str(), kHow);
    }
    if (folder < 0) failOfFile(path_, "cannot be used as the folder of the server's identity");
    return folder;
  }

  void write(const std::string& name, std::string_view text) const {
    const fs::path path = path_ / name;
    const File file(::openat(descriptor_, name.c_str(), O_WRONLY | O_CREAT | O_EXCL | O_CLOEXEC | O_NOFOLLOW, S_IRUSR | S_IWUSR));
    if (file < 0) failOfFile(path, "cannot be written");
    while (!text.empty()) {
      const ssize_t count = ::write(file, text.data(), text.size());
      if (count < 0 && errno == EINTR) continue;
      if (count < 0) failOfFile(path, "cannot be written");
      text.remove_prefix(static_cast<size_t>(count));
    }
    if (::fsync(file) != 0) failOfFile(path, "cannot be written");
  }

  const fs::path path_;
  const File descriptor_;
};

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
  const Folder open(folder);
  std::string pem;
  if (open.read(kFileName, pem)) return parseIdentity(pem, path);
  const Identity made = makeIdentity();
  open.put(kFileName, made.keyPem + made.certificatePem);
  if (!open.read(kFileName, pem)) throw CertificateError(path.string() + ": was removed as soon as it was made");
  return parseIdentity(pem, path);
}

}  // namespace warpscope::net

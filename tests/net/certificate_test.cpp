// The identity of a server: what is in it, that it stays the same, who can read it, and what becomes of damaged files.
// Mirrors net/certificate.h.
#include "net/certificate.h"

#include <gmock/gmock.h>
#include <openssl/pem.h>
#include <openssl/x509v3.h>
#include <sys/stat.h>
#include <unistd.h>

#include <fstream>
#include <set>
#include <thread>
#include <vector>

#include "tests/test_folder.h"

namespace warpscope::net {
namespace {

namespace fs = std::filesystem;
using testing::HasSubstr;

class CertificateTest : public testing::Test {
 protected:
  fs::path file() const { return root_ / "identity.pem"; }
  mode_t modeOf(const fs::path& path) const {
    struct stat status;
    return stat(path.c_str(), &status) == 0 ? status.st_mode & 07777 : 0;
  }
  std::string content() const { return contentOf(file()); }
  void replaceContent(const std::string& text) const { std::ofstream(file(), std::ios::binary | std::ios::trunc) << text; }
  std::string complaint() const {
    try {
      loadOrMakeIdentity(root_);
    } catch (const CertificateError& error) {
      return error.what();
    }
    return "";
  }

  const TestFolder folder_;
  const fs::path root_ = folder_.path() / "its identity";  // which is not there, and of which a shell would make two words
};

TEST_F(CertificateTest, IsMadeOnceAndKept) {
  const Identity made = loadOrMakeIdentity(root_ / "sub");
  const Identity loaded = loadOrMakeIdentity(root_ / "sub");
  EXPECT_EQ(loaded.fingerprint, made.fingerprint);
  EXPECT_EQ(loaded.keyPem, made.keyPem);
  EXPECT_EQ(loaded.certificatePem, made.certificatePem);
  EXPECT_NE(makeIdentity().fingerprint, made.fingerprint);
}

TEST_F(CertificateTest, NobodyElseCanReadTheKey) {
  const mode_t before = umask(0);
  loadOrMakeIdentity(root_);
  umask(before);
  EXPECT_EQ(modeOf(file()), mode_t{0600});
  EXPECT_EQ(modeOf(root_), mode_t{0700});
  size_t count = 0;
  for ([[maybe_unused]] const auto& entry : fs::directory_iterator(root_)) ++count;
  EXPECT_EQ(count, 1u) << "something was left beside the file";

  ASSERT_EQ(chmod(file().c_str(), 0640), 0);
  EXPECT_THAT(complaint(), HasSubstr(file().string() + ": others can read or change this key; close it to them with: chmod 600 '" + file().string() + "'"));
  ASSERT_EQ(chmod(file().c_str(), 0600), 0);
  for (const mode_t mode : {mode_t{0750}, mode_t{0701}, mode_t{0720}}) {
    ASSERT_EQ(chmod(root_.c_str(), mode), 0);
    EXPECT_THAT(complaint(), HasSubstr(root_.string() + ": others can look into this folder, where the server's key is; close it to them with: chmod 700 '" + root_.string() + "'"));
  }
  ASSERT_EQ(chmod(root_.c_str(), 0700), 0);
  EXPECT_EQ(complaint(), "");
}

TEST_F(CertificateTest, IsP256WithADateAndNoAuthority) {
  const Identity identity = makeIdentity();
  BIO* const memory = BIO_new_mem_buf(identity.certificatePem.data(), static_cast<int>(identity.certificatePem.size()));
  X509* const certificate = PEM_read_bio_X509(memory, nullptr, nullptr, nullptr);
  ASSERT_NE(certificate, nullptr);
  EVP_PKEY* const key = X509_get0_pubkey(certificate);
  char group[32] = "";
  size_t size = 0;
  EXPECT_EQ(EVP_PKEY_get_group_name(key, group, sizeof group, &size), 1);
  EXPECT_STREQ(group, "prime256v1");
  EXPECT_EQ(X509_verify(certificate, key), 1);
  EXPECT_EQ(X509_check_ca(certificate), 0);
  EXPECT_EQ(X509_cmp_current_time(X509_get0_notBefore(certificate)), -1);
  EXPECT_EQ(X509_cmp_current_time(X509_get0_notAfter(certificate)), 1);
  X509_free(certificate);
  BIO_free(memory);
}

TEST_F(CertificateTest, AllWhoMakeOneAtOnceGetTheSame) {
  std::vector<Identity> identities(8);
  {
    std::vector<std::jthread> threads;
    for (Identity& identity : identities) threads.emplace_back([&] { identity = loadOrMakeIdentity(root_); });
  }
  std::set<std::string> fingerprints;
  for (const Identity& identity : identities) fingerprints.insert(fingerprintText(identity.fingerprint));
  EXPECT_EQ(fingerprints.size(), 1u);
}

TEST_F(CertificateTest, SaysWhatIsWrongWithAFile) {
  const Identity identity = loadOrMakeIdentity(root_);
  replaceContent("");
  EXPECT_THAT(complaint(), HasSubstr(file().string() + ": holds no private key; remove the file"));
  replaceContent("nothing of use");
  EXPECT_THAT(complaint(), HasSubstr("holds no private key"));
  replaceContent(identity.keyPem.substr(0, identity.keyPem.size() / 2));
  EXPECT_THAT(complaint(), HasSubstr("holds no private key"));
  replaceContent(identity.keyPem);
  EXPECT_THAT(complaint(), HasSubstr("holds no certificate"));
  replaceContent(makeIdentity().keyPem + identity.certificatePem);
  EXPECT_THAT(complaint(), HasSubstr("do not belong together"));
  replaceContent(std::string(1 << 20, 'x'));
  EXPECT_THAT(complaint(), HasSubstr("is too large"));
  replaceContent(identity.keyPem + identity.certificatePem);
  EXPECT_EQ(complaint(), "");
}

TEST_F(CertificateTest, SaysWhatHelpsAgainstOtherPeoplesKeys) {
  const auto identityOf = [&](const std::string& commands) {
    const std::string folder = root_.string();
    const int code = std::system(("cd '" + folder + "' && (" + commands + ") > /dev/null 2>&1 && cat key.pem certificate.pem > identity.pem && rm key.pem certificate.pem").c_str());
    return code == 0;
  };
  if (std::system("openssl version > /dev/null 2>&1") != 0) GTEST_SKIP() << "no openssl here";
  loadOrMakeIdentity(root_);
  const std::string request = "openssl req -x509 -subj /CN=a -key key.pem -out certificate.pem";
  ASSERT_TRUE(identityOf("openssl genrsa -out key.pem 2048 && " + request));
  EXPECT_EQ(complaint(), "");
  ASSERT_TRUE(identityOf("openssl genrsa -out key.pem 512 && " + request));
  EXPECT_THAT(complaint(), HasSubstr(file().string() + ": holds a key of 512 bits, which can be broken; RSA needs 2048"));
  ASSERT_TRUE(identityOf("openssl genpkey -algorithm EC -pkeyopt ec_paramgen_curve:P-256 -out key.pem && " + request + " && openssl pkey -in key.pem -aes256 "
                         "-passout pass:secret -out locked.pem && mv locked.pem key.pem"));
  EXPECT_THAT(complaint(), HasSubstr(file().string() + ": holds a private key under a password"));
  ASSERT_TRUE(identityOf("openssl genpkey -algorithm EC -pkeyopt ec_paramgen_curve:P-256 -out key.pem && openssl req -new -subj /CN=a -key key.pem -out request.pem && "
                         "openssl x509 -req -in request.pem -signkey key.pem -days -1 -out certificate.pem; rm -f request.pem; test -s certificate.pem"));
  EXPECT_THAT(complaint(), HasSubstr(file().string() + ": holds a certificate that has expired on "));
  for (const char* text : {"remove the file to have a new identity made"}) EXPECT_THAT(complaint(), HasSubstr(text));
}

/// Neither waited for nor followed.
TEST_F(CertificateTest, TakesARegularFileAlone) {
  const Identity identity = loadOrMakeIdentity(root_);
  const fs::path elsewhere = root_ / "elsewhere.pem";
  fs::rename(file(), elsewhere);
  fs::create_symlink(elsewhere, file());
  EXPECT_THAT(complaint(), HasSubstr(file().string() + ": is a symbolic link, which is not followed"));
  fs::remove(file());
  ASSERT_EQ(mkfifo(file().c_str(), 0600), 0);
  EXPECT_THAT(complaint(), HasSubstr(file().string() + ": cannot be used as identity: it is no regular file"));
  fs::remove(file());
  fs::create_directory(file());
  EXPECT_THAT(complaint(), HasSubstr(file().string() + ": cannot be used as identity: it is no regular file"));
  fs::remove(file());
  fs::rename(elsewhere, file());
  EXPECT_EQ(loadOrMakeIdentity(root_).fingerprint, identity.fingerprint);
}

TEST_F(CertificateTest, BelongsToTheUser) {
  if (geteuid() != 0) GTEST_SKIP() << "only root can give files away";
  loadOrMakeIdentity(root_);
  ASSERT_EQ(chown(file().c_str(), 12345, gid_t(-1)), 0);
  EXPECT_THAT(complaint(), HasSubstr(file().string() + ": belongs to another user (12345), who can change the key in it; make it yours with: chown 0 '"));
  ASSERT_EQ(chown(file().c_str(), 0, gid_t(-1)), 0);
  ASSERT_EQ(chown(root_.c_str(), 12345, gid_t(-1)), 0);
  EXPECT_THAT(complaint(), HasSubstr(root_.string() + ": belongs to another user (12345)"));
}

TEST_F(CertificateTest, SaysWhereItCannotBeKept) {
  std::ofstream(root_) << "a file where the folder should be";
  EXPECT_THAT(complaint(), HasSubstr(root_.string()));
}

}  // namespace
}  // namespace warpscope::net

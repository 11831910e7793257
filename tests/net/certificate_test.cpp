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

namespace warpscope::net {
namespace {

namespace fs = std::filesystem;
using testing::HasSubstr;

class CertificateTest : public testing::Test {
 protected:
  void SetUp() override {
    root_ = fs::path(testing::TempDir()) / ("certificate_" + std::to_string(getpid()) + "_" +
                                            testing::UnitTest::GetInstance()->current_test_info()->name());
    fs::remove_all(root_);
  }
  void TearDown() override { fs::remove_all(root_); }

  fs::path file() const { return root_ / "identity.pem"; }
  mode_t modeOf(const fs::path& path) const {
    struct stat status;
    return stat(path.c_str(), &status) == 0 ? status.st_mode & 07777 : 0;
  }
  std::string content() const {
    std::ifstream stream(file(), std::ios::binary);
    return {std::istreambuf_iterator<char>(stream), {}};
  }
  void replaceContent(const std::string& text) const { std::ofstream(file(), std::ios::binary | std::ios::trunc) << text; }
  std::string complaint() const {
    try {
      loadOrMakeIdentity(root_);
    } catch (const CertificateError& error) {
      return error.what();
    }
    return "";
  }

  fs::path root_;
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
  EXPECT_THAT(complaint(), HasSubstr(file().string() + ": others can read or change this key; chmod 600 it"));
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

TEST_F(CertificateTest, SaysWhereItCannotBeKept) {
  std::ofstream(root_) << "a file where the folder should be";
  EXPECT_THAT(complaint(), HasSubstr(root_.string()));
}

}  // namespace
}  // namespace warpscope::net

// Tokens and fingerprints as text: what is written is read, and nothing else is; no two tokens are alike.
// Mirrors net/token.h and net/fingerprint.h.
#include "net/token.h"

#include <gtest/gtest.h>

#include <set>

#include "net/fingerprint.h"

namespace warpscope::net {
namespace {

TEST(Token, IsReadAsItIsWritten) {
  for (int i = 0; i < 200; ++i) {
    const Token token = Token::random();
    const std::string text = token.text();
    EXPECT_EQ(text.size(), Token::kCharacters);
    const std::optional<Token> read = Token::parse(text);
    ASSERT_TRUE(read) << text;
    EXPECT_EQ(*read, token);
  }
}

TEST(Token, KnownBytes) {
  std::array<uint8_t, Token::kBytes> bytes{};
  EXPECT_EQ(Token(bytes).text(), "AAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAA");
  bytes.fill(0xff);
  EXPECT_EQ(Token(bytes).text(), "________________________________");
  for (size_t i = 0; i < bytes.size(); ++i) bytes[i] = static_cast<uint8_t>(i * 11 + 3);
  EXPECT_EQ(Token(bytes).text(), "Aw4ZJC86RVBbZnF8h5KdqLO-ydTf6vUA");
}

TEST(Token, RefusesWhatIsNone) {
  const std::string text = Token::random().text();
  EXPECT_FALSE(Token::parse(""));
  EXPECT_FALSE(Token::parse(text.substr(1)));
  EXPECT_FALSE(Token::parse(text + "A"));
  for (const char wrong : {'=', '+', '/', ' ', '\0', '\xc3'}) {
    std::string changed = text;
    changed[17] = wrong;
    EXPECT_FALSE(Token::parse(changed)) << wrong;
  }
}

TEST(Token, AnyBitMakesAnotherOne) {
  const Token token = Token::random();
  for (size_t bit = 0; bit < 8 * Token::kBytes; ++bit) {
    std::array<uint8_t, Token::kBytes> bytes;
    std::copy(token.bytes().begin(), token.bytes().end(), bytes.begin());
    bytes[bit / 8] ^= static_cast<uint8_t>(1 << bit % 8);
    EXPECT_FALSE(Token(bytes) == token) << bit;
  }
}

TEST(Token, NoTwoAreAlike) {
  std::set<std::string> texts;
  for (int i = 0; i < 1000; ++i) texts.insert(Token::random().text());
  EXPECT_EQ(texts.size(), 1000u);
}

TEST(FingerprintText, IsReadAsItIsWritten) {
  Fingerprint fingerprint;
  for (size_t i = 0; i < fingerprint.size(); ++i) fingerprint[i] = static_cast<uint8_t>(i * 37 + 200);
  const std::string text = fingerprintText(fingerprint);
  EXPECT_EQ(text.substr(0, 6), "c8ed12");
  EXPECT_EQ(parseFingerprint(text), fingerprint);
  EXPECT_FALSE(parseFingerprint(text.substr(2)));
  EXPECT_FALSE(parseFingerprint(text + "00"));
  for (const char wrong : {'g', ' ', '-', '+', 'x', ':'}) {
    for (const size_t at : {size_t{20}, size_t{21}}) {
      std::string changed = text;
      changed[at] = wrong;
      EXPECT_FALSE(parseFingerprint(changed)) << wrong;
    }
  }
}

}  // namespace
}  // namespace warpscope::net

// What is printed of texts from outside: nothing that a terminal would obey, and all else as it was.
// Mirrors render/base/printable.h.
#include "render/base/printable.h"

#include <gtest/gtest.h>

namespace warpscope {
namespace {

using namespace std::string_literals;

TEST(Printable, ControlCharactersOfBothSetsAreWrittenOut) {
  EXPECT_EQ(printable("a\x1b[2Jb\x07\x7f"), "a\\x1b[2Jb\\x07\\x7f");
  EXPECT_EQ(printable("a\0b"s), "a\\x00b");
  // A lone byte of C1 is obeyed by terminals of 8 bits, its form in UTF-8 by the others.
  for (int byte = 0x80; byte < 0xa0; ++byte) {
    char raw[8], encoded[8];
    std::snprintf(raw, sizeof raw, "\\x%02x", byte);
    std::snprintf(encoded, sizeof encoded, "\\u%04x", byte);
    EXPECT_EQ(printable(std::string(1, static_cast<char>(byte)) + "31m"), raw + "31m"s);
    EXPECT_EQ(printable("\xc2"s + static_cast<char>(byte)), encoded);
  }
}

TEST(Printable, WellFormedTextStaysAsItIs) {
  for (const std::string text : {"", "plain ~", "\xc2\xa0\xc3\xa9\xdf\xbf", "\xe2\x82\xac\xed\x9f\xbf\xee\x80\x80\xef\xbf\xbd", "\xf0\x9f\x8c\x8d\xf4\x8f\xbf\xbf"})
    EXPECT_EQ(printable(text), text);
}

TEST(Printable, WhatIsNoUtf8IsWrittenOutByteForByte) {
  EXPECT_EQ(printable("\xff\xfe"), "\\xff\\xfe");
  EXPECT_EQ(printable("\xc0\xaf"), "\\xc0\\xaf");                          // longer than need be
  EXPECT_EQ(printable("\xe0\x80\xaf"), "\\xe0\\x80\\xaf");                  // likewise
  EXPECT_EQ(printable("\xf0\x80\x80\xaf"), "\\xf0\\x80\\x80\\xaf");         // likewise
  EXPECT_EQ(printable("\xed\xa0\x80"), "\\xed\\xa0\\x80");                  // half of a pair
  EXPECT_EQ(printable("\xf4\x90\x80\x80"), "\\xf4\\x90\\x80\\x80");         // beyond the last character
  EXPECT_EQ(printable("\xe2\x82"), "\\xe2\\x82");                           // cut off
  EXPECT_EQ(printable("\xe2\x82x"), "\\xe2\\x82x");
}

TEST(Printable, NothingTurnsTheDirectionOfWriting) {
  EXPECT_EQ(printable("a\xe2\x80\xae" "gnp.exe"), "a\\u202egnp.exe");
  EXPECT_EQ(printable("\xe2\x81\xa6\xe2\x80\xa8\xd8\x9c"), "\\u2066\\u2028\\u061c");
}

TEST(Printable, LinesAreOneUnlessTheyAreMeant) {
  EXPECT_EQ(printable("a\nb\r\tc"), "a b  c");
  EXPECT_EQ(printableLines("a\nb\x1b\n"), "a\nb\\x1b\n");
  EXPECT_EQ(printableJson("{\n \"a\": \"\xc2\x9b\x7f\"}"), "{\n \"a\": \"\\u009b\\u007f\"}");
}

}  // namespace
}  // namespace warpscope

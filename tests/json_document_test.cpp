// Complaints about JSON: each names the file, the line, the key and what would be right.
// Mirrors app/scene/json_document.h.
#include "app/scene/json_document.h"

#include <gmock/gmock.h>

#include <ctime>
#include <fstream>

#include "render/base/error.h"
#include "tests/complaint.h"
#include "tests/test_folder.h"

namespace warpscope {
namespace {

using testing::AllOf;
using testing::HasSubstr;
using testing::StartsWith;

std::string complaintAbout(const std::string& text) {
  return complaintOf([&] { JsonDocument(text, "f.json"); });
}

constexpr std::string_view kText = R"({
  "name": "x",
  "list": [
    1,
    2.5
  ],
  "flag": true,
  "inner": {
    "deep":
      7
  }
})";

TEST(JsonDocument, ReadsValues) {
  const JsonDocument document(kText, "f.json");
  const Node root = document.root();
  EXPECT_EQ(root.at("name").string(), "x");
  EXPECT_EQ(root.at("list").elements(0, 9)[1].number(0.0, 10.0), 2.5);
  EXPECT_EQ(root.at("list").elements(2, 2)[0].integer(1, 1), 1);
  EXPECT_TRUE(root.at("flag").boolean());
  EXPECT_EQ(root.at("inner").at("deep").integer(-100, 100), 7);
  EXPECT_FALSE(root.find("absent"));
  EXPECT_TRUE(root.at("name").isString());
  EXPECT_TRUE(root.at("list").isArray());
}

TEST(JsonDocument, WrongTypesNameKeyAndLine) {
  const JsonDocument document(kText, "f.json");
  const Node root = document.root();
  EXPECT_THAT(complaintOf([&] { root.at("name").number(0, 1); }),
              AllOf(StartsWith("f.json:2: "), HasSubstr("'name'"), HasSubstr("must be a number, not string")));
  EXPECT_THAT(complaintOf([&] { root.at("list").string(); }), AllOf(StartsWith("f.json:3: "), HasSubstr("'list'"), HasSubstr("array")));
  EXPECT_THAT(complaintOf([&] { root.at("flag").elements(0, 1); }), AllOf(StartsWith("f.json:7: "), HasSubstr("'flag'")));
  EXPECT_THAT(complaintOf([&] { root.at("inner").boolean(); }), AllOf(StartsWith("f.json:8: "), HasSubstr("'inner'")));
  EXPECT_THAT(complaintOf([&] { root.at("inner").at("deep").string(); }), AllOf(StartsWith("f.json:9: "), HasSubstr("'inner.deep'")));
  EXPECT_THAT(complaintOf([&] { root.at("name").requireObject({}); }), AllOf(StartsWith("f.json:2: "), HasSubstr("must be an object")));
}

TEST(JsonDocument, ElementsKnowTheirLines) {
  const JsonDocument document(kText, "f.json");
  const std::vector<Node> elements = document.root().at("list").elements(2, 2);
  EXPECT_THAT(complaintOf([&] { elements[0].string(); }), AllOf(StartsWith("f.json:4: "), HasSubstr("'list.0'")));
  EXPECT_THAT(complaintOf([&] { elements[1].string(); }), AllOf(StartsWith("f.json:5: "), HasSubstr("'list.1'")));  // a number at its line's end
  const JsonDocument others("[\n{},\n[],\n\"s\",\nnull,\nfalse\n]", "g");
  int line = 2;
  for (const Node& element : others.root().elements(5, 5))
    EXPECT_THAT(complaintOf([&] { element.number(0, 1); }), StartsWith("g:" + std::to_string(line++) + ": "));
}

TEST(JsonDocument, RangesAreChecked) {
  const JsonDocument document(R"({"a": 5, "b": 2.5, "c": [1, 2], "d": 1e300})", "f.json");
  const Node root = document.root();
  EXPECT_EQ(root.at("a").number(5.0, 5.0), 5.0);
  EXPECT_THAT(complaintOf([&] { root.at("a").number(6, 7); }), AllOf(HasSubstr("'a'"), HasSubstr("between 6 and 7, not 5")));
  EXPECT_THAT(complaintOf([&] { root.at("b").integer(0, 9); }), AllOf(HasSubstr("'b'"), HasSubstr("whole")));
  EXPECT_THAT(complaintOf([&] { root.at("c").elements(3, 3); }), AllOf(HasSubstr("'c'"), HasSubstr("3 elements")));
  EXPECT_THAT(complaintOf([&] { root.at("c").elements(3, 9); }), AllOf(HasSubstr("'c'"), HasSubstr("3 to 9 elements")));
  EXPECT_THAT(complaintOf([&] { root.at("d").integer(0, 9); }), HasSubstr("'d'"));
}

TEST(JsonDocument, UnknownKeysProposeTheNearest) {
  const JsonDocument document("{\n\"volume\": 1,\n\"fovDeg\": 40\n}", "f.json");
  constexpr std::string_view known[] = {"volume", "fovYDeg", "title"};
  EXPECT_THAT(complaintOf([&] { document.root().requireObject(known); }),
              AllOf(StartsWith("f.json:3: "), HasSubstr("'fovDeg'"), HasSubstr("did you mean 'fovYDeg'?")));
  constexpr std::string_view all[] = {"volume", "fovDeg"};
  EXPECT_EQ(complaintOf([&] { document.root().requireObject(all); }), "");
}

TEST(JsonDocument, MissingKeysAreNamed) {
  const JsonDocument document("{\"a\":\n{\"b\": 1}}", "f.json");
  EXPECT_THAT(complaintOf([&] { document.root().at("volume"); }), AllOf(StartsWith("f.json:1: "), HasSubstr("'volume'")));
  EXPECT_THAT(complaintOf([&] { document.root().at("a").at("c"); }), AllOf(HasSubstr("'a'"), HasSubstr("lacks the key 'c'")));
}

TEST(JsonDocument, DuplicateKeysAreRefused) {
  EXPECT_THAT(complaintAbout("{\n\"a\": 1,\n\"b\": 2,\n\"a\": 3\n}"), AllOf(StartsWith("f.json:4: "), HasSubstr("'a'"), HasSubstr("twice")));
  EXPECT_THAT(complaintAbout("{\"o\": {\"a\": 1,\n\"a\": 1}}"), StartsWith("f.json:2: "));
  EXPECT_EQ(complaintAbout("{\"a\": {\"a\": {\"a\": 1}}, \"b\": [{\"a\": 1}, {\"a\": 2}]}"), "");
}

TEST(JsonDocument, KeysWithOddCharacters) {
  const JsonDocument document("{\"a/b~c\": 1,\n\"a\": {\"b~c\": 2}, \"\":\n3}", "f.json");
  EXPECT_THAT(complaintOf([&] { document.root().at("a/b~c").string(); }), StartsWith("f.json:1: 'a/b~c' must be"));
  EXPECT_THAT(complaintOf([&] { document.root().at("a").at("b~c").string(); }), StartsWith("f.json:2: 'a.b~c' must be"));
  EXPECT_EQ(document.root().at("").integer(0, 9), 3);
}

/// Where a message and the name of a file would end.
TEST(JsonDocument, ZerosInStringsAreRefused) {
  for (const char* text : {"{\n\"name\": \"a\\u0000b\"}", "{\n\"na\\u0000me\": 1}", "[\n\"\\u0000\"]"})
    EXPECT_THAT(complaintAbout(text), AllOf(StartsWith("f.json:2: "), HasSubstr("character zero"))) << text;
  EXPECT_EQ(complaintAbout("[\"\\u0001\\\\u0000\"]"), "");
}

/// Measured against the library's own parser, so that neither the machine nor the build matters.
TEST(JsonDocument, ManySmallElementsAreQuick) {
  std::string text = "{\"a\": [";
  while (text.size() < (4u << 20)) text += "0,";
  text += "0],\n\"b\": {\"c\": [[], {},\n1]}}";
  const std::clock_t start = std::clock();
  EXPECT_TRUE(nlohmann::json::parse(text).is_object());
  const std::clock_t plain = std::clock() - start;
  const JsonDocument document(text, "f.json");
  const Node root = document.root();
  EXPECT_THAT(complaintOf([&] { root.at("b").at("c").elements(3, 3)[2].string(); }), StartsWith("f.json:3: 'b.c.2' "));
  EXPECT_LT(std::clock() - start - plain, 8 * plain) << "as if something were kept for every element";
}

TEST(JsonDocument, SyntaxErrorsNameTheLine) {
  const auto expectAt = [](int line, const std::string& text) {
    EXPECT_THAT(complaintAbout(text), AllOf(StartsWith("f.json:" + std::to_string(line) + ": "), HasSubstr("not valid JSON"))) << text;
  };
  expectAt(1, "{\"a\": 1 \"b\": 2}");
  expectAt(3, "{\n\"a\": 1,\n\"b\": nope\n}");
  expectAt(2, "{\n\"a\": tru\n}");  // the word that is wrong ends its line
  expectAt(2, "{\n\"a\": \"no end\n}");
  expectAt(3, "[1,\n2\n3]");
  expectAt(2, "{\n} {}");
  expectAt(2, "[1,\n]");
  expectAt(1, "NaN");
  expectAt(1, "[1e999]");
  expectAt(1, "[01]");
  expectAt(1, "// no comments\n{}");
}

TEST(JsonDocument, EmptyAndCutOffTexts) {
  EXPECT_THAT(complaintAbout(""), StartsWith("f.json:1: "));
  EXPECT_THAT(complaintAbout("   \n\n"), StartsWith("f.json:"));
  EXPECT_THAT(complaintAbout(std::string("\0\0", 2)), StartsWith("f.json:1: "));
  const std::string whole(kText);
  for (size_t length = 0; length < whole.size(); ++length)
    EXPECT_THAT(complaintAbout(whole.substr(0, length)), StartsWith("f.json:")) << length;
}

TEST(JsonDocument, DeepNestingIsRefusedNotFollowed) {
  EXPECT_EQ(complaintAbout(std::string(64, '[') + std::string(64, ']')), "");
  EXPECT_THAT(complaintAbout(std::string(65, '[') + std::string(65, ']')), HasSubstr("deep"));
  EXPECT_THAT(complaintAbout(std::string(5'000'000, '[')), HasSubstr("deep"));
  std::string objects;
  for (int i = 0; i < 100000; ++i) objects += "{\"a\":\n";
  EXPECT_THAT(complaintAbout(objects), AllOf(StartsWith("f.json:6"), HasSubstr("deep")));
}

TEST(JsonDocument, OtherRootsThanObjects) {
  const JsonDocument array("[]", "f.json");
  EXPECT_THAT(complaintOf([&] { array.root().requireObject({}); }), AllOf(StartsWith("f.json:1: "), HasSubstr("must be an object, not array")));
  EXPECT_THAT(complaintOf([&] { array.root().at("a"); }), HasSubstr("f.json:1: "));
  const JsonDocument number("3", "f.json");
  EXPECT_FALSE(number.root().find("a"));
}

TEST(JsonDocument, Files) {
  const TestFolder folder;
  const std::filesystem::path path = folder.file("it.json");
  std::ofstream(path) << "{\"a\": 1}\n";
  EXPECT_EQ(JsonDocument::fromFile(path).root().at("a").integer(0, 9), 1);
  std::ofstream(path, std::ios::trunc).flush();
  EXPECT_THAT(complaintOf([&] { JsonDocument::fromFile(path); }), StartsWith(path.string() + ":1: "));
  std::filesystem::resize_file(path, (256u << 20) + 1);  // sparse
  EXPECT_THAT(complaintOf([&] { JsonDocument::fromFile(path); }), HasSubstr("too large"));
  std::filesystem::remove(path);
  EXPECT_THAT(complaintOf([&] { JsonDocument::fromFile(path); }), StartsWith(path.string() + ": "));
  EXPECT_THAT(complaintOf([&] { JsonDocument::fromFile(folder.path()); }), StartsWith(folder.path().string()));
}

}  // namespace
}  // namespace warpscope

// Parsing, finding lines, and checked access.
// See json_document.h.
#include "app/scene/json_document.h"

#include <algorithm>
#include <cmath>

#include "render/base/error.h"
#include "render/base/input_file.h"
#include "render/base/nearest_name.h"
#include "render/base/printable.h"

namespace warpscope {
namespace {

using Json = nlohmann::json;

/// Walks over the text and counts the lines that the parser has taken. A line break belongs to the line that it ends, because the
/// parser takes the character behind a number before it reports the number.
class CountingIterator {
 public:
  using iterator_category = std::input_iterator_tag;
  using value_type = char;
  using difference_type = std::ptrdiff_t;
  using pointer = const char*;
  using reference = const char&;

  CountingIterator(const char* at, int* line) : at_(at), line_(line) {}
  reference operator*() const { return *at_; }
  CountingIterator& operator++() {
    if (afterBreak_) ++*line_;
    afterBreak_ = *at_ == '\n';
    ++at_;
    return *this;
  }
  CountingIterator operator++(int) {
    CountingIterator before = *this;
    ++*this;
    return before;
  }
  bool operator==(const CountingIterator& other) const { return at_ == other.at_; }
  bool operator!=(const CountingIterator& other) const { return at_ != other.at_; }

 private:
  const char* at_;
  int* line_;
  bool afterBreak_ = false;
};

/// Builds the value, and complains about what the format allows but no document of this program may have.
class BuildingSax : public nlohmann::json_sax<Json> {
 public:
  BuildingSax(Json& root, const int& line, const std::string& source) : root_(root), line_(line), source_(source) {}

  bool null() override { return put(nullptr); }
  bool boolean(bool value) override { return put(value); }
  bool number_integer(number_integer_t value) override { return put(value); }
  bool number_unsigned(number_unsigned_t value) override { return put(value); }
  bool number_float(number_float_t value, const string_t&) override { return put(value); }
  bool string(string_t& value) override {
    requireText(value);
    return put(std::move(value));
  }
  bool binary(binary_t&) override { return false; }
  bool start_object(size_t) override { return open(Json::object()); }
  bool start_array(size_t) override { return open(Json::array()); }
  bool end_object() override { return close(); }
  bool end_array() override { return close(); }
  bool key(string_t& key) override {
    requireText(key);
    const auto [member, isNew] = open_.back()->get_ref<Json::object_t&>().try_emplace(key);
    if (!isNew) fail("the key '" + key + "' stands there twice");
    member_ = &member->second;
    return true;
  }
  bool parse_error(size_t, const std::string& token, const nlohmann::detail::exception& error) override {
    // The parser's text begins with an identifier of its own and the position; what was expected comes last.
    if (token.empty()) fail("not valid JSON: the text ends before the document does");
    const std::string text = error.what();
    const size_t reason = text.find("; ");
    fail("not valid JSON near '" + token.substr(0, 40) + "'" + (reason == std::string::npos ? "" : ": " + text.substr(reason + 2)));
  }

 private:
  [[noreturn]] void fail(const std::string& text) const { throw InputError(source_ + ":" + std::to_string(line_) + ": " + text); }
  /// Names of files end at a zero, and so do messages.
  void requireText(const string_t& text) const {
    if (text.find('\0') != string_t::npos) fail("a string must not contain the character zero (\\u0000)");
  }

  Json* attach(Json value) {
    if (open_.empty()) return &(root_ = std::move(value));
    if (!open_.back()->is_array()) return &(*member_ = std::move(value));
    auto& elements = open_.back()->get_ref<Json::array_t&>();
    return &elements.emplace_back(std::move(value));
  }
  bool put(Json value) {
    attach(std::move(value));
    return true;
  }
  bool open(Json value) {
    constexpr size_t kDeepest = 64;
    if (open_.size() >= kDeepest) fail("nested more than 64 levels deep");
    open_.push_back(attach(std::move(value)));
    return true;
  }
  bool close() {
    open_.pop_back();
    return true;
  }

  Json& root_;
  const int& line_;
  const std::string& source_;
  std::vector<Json*> open_;  // what is being filled, outermost first; only the last grows, so that the others stay where they are
  Json* member_ = nullptr;   // the value of the key that was read last
};

/// Walks over a text that was parsed before until the value that `path` leads to begins, and notes the line: a key's, if it has one.
class LineFindingSax : public nlohmann::json_sax<Json> {
 public:
  LineFindingSax(std::span<const std::string> path, const int& line) : path_(path), line_(line) {}

  /// Nothing until the value is found.
  std::optional<int> found() const { return found_; }

  bool null() override { return begin(); }
  bool boolean(bool) override { return begin(); }
  bool number_integer(number_integer_t) override { return begin(); }
  bool number_unsigned(number_unsigned_t) override { return begin(); }
  bool number_float(number_float_t, const string_t&) override { return begin(); }
  bool string(string_t&) override { return begin(); }
  bool binary(binary_t&) override { return false; }
  bool start_object(size_t) override { return open(false); }
  bool start_array(size_t) override { return open(true); }
  bool end_object() override { return close(); }
  bool end_array() override { return close(); }
  bool key(string_t& key) override { return step(key); }
  bool parse_error(size_t, const std::string&, const nlohmann::detail::exception&) override { return false; }

 private:
  struct Open {
    bool isArray;
    bool isOnPath;
    size_t count = 0;  // elements that have begun
  };

  /// The next member or element of the innermost value. False, which ends the walk, if it is the one.
  bool step(std::string_view name) {
    isOnPath_ = open_.back().isOnPath && path_[open_.size() - 1] == name;
    if (isOnPath_ && open_.size() == path_.size()) found_ = line_;
    return !found_;
  }
  bool begin() {
    if (open_.empty()) {
      isOnPath_ = true;
      if (path_.empty()) found_ = line_;
      return !found_;
    }
    Open& parent = open_.back();
    if (!parent.isArray) return true;  // key() has been asked
    const size_t index = parent.count++;
    if (parent.isOnPath) return step(std::to_string(index));
    isOnPath_ = false;
    return true;
  }
  bool open(bool isArray) {
    if (!begin()) return false;
    open_.push_back({isArray, isOnPath_});
    return true;
  }
  bool close() {
    open_.pop_back();
    return true;
  }

  std::span<const std::string> path_;
  const int& line_;
  std::vector<Open> open_;
  bool isOnPath_ = false;  // the value that begins next, or has begun last
  std::optional<int> found_;
};

template <class Sax>
void walk(std::string_view text, int& line, Sax& sax) {
  Json::sax_parse(CountingIterator(text.data(), &line), CountingIterator(text.data() + text.size(), &line), &sax);
}

std::string displayName(std::span<const std::string> path) {
  if (path.empty()) return "the document";
  std::string name;
  for (const std::string& step : path) name += (name.empty() ? "'" : ".") + step;
  return name + "'";
}

}  // namespace

std::string textOf(const Json& document) {
  // Beyond ASCII only in strings, where an escape means the same; the library writes out no more than C0.
  return printableJson(document.dump(2, ' ', false, Json::error_handler_t::replace)) + "\n";
}

JsonDocument::JsonDocument(std::string_view text, std::string source) : text_(text), source_(std::move(source)) {
  int line = 1;
  BuildingSax sax(value_, line, source_);
  walk(text_, line, sax);
}

JsonDocument JsonDocument::fromFile(const std::filesystem::path& path, uint64_t maxBytes) {
  return JsonDocument(readInputFile(path, maxBytes, "a JSON file of this kind"), path.string());
}

Node JsonDocument::root() const { return Node(*this, value_, {}); }

void Node::fail(std::string_view text) const {
  int line = 1;
  LineFindingSax sax(path_, line);
  walk(document_->text_, line, sax);
  throw InputError(document_->source_ + ":" + std::to_string(sax.found().value_or(1)) + ": " + displayName(path_) + " " + std::string(text));
}

Node Node::child(std::string key, const Json& value) const {
  std::vector<std::string> path = path_;
  path.push_back(std::move(key));
  return Node(*document_, value, std::move(path));
}

void Node::requireObject(std::span<const std::string_view> known) const {
  if (!value_->is_object()) fail(std::string("must be an object, not ") + value_->type_name());
  for (const auto& [key, member] : value_->items())
    if (std::find(known.begin(), known.end(), key) == known.end())
      child(key, member).fail("is not known here" + knownInstead(key, known));
}

std::optional<Node> Node::find(std::string_view key) const {
  const auto member = value_->find(std::string(key));
  if (member == value_->end()) return std::nullopt;
  return child(std::string(key), *member);
}

Node Node::at(std::string_view key) const {
  if (auto node = find(key)) return *node;
  fail("lacks the key '" + std::string(key) + "'");
}

std::vector<Node> Node::elements(size_t lowest, size_t highest) const {
  if (!value_->is_array()) fail(std::string("must be an array, not ") + value_->type_name());
  if (value_->size() < lowest || value_->size() > highest)
    fail(lowest == highest ? "must have " + std::to_string(lowest) + " elements"
                           : "must have " + std::to_string(lowest) + " to " + std::to_string(highest) + " elements");
  std::vector<Node> nodes;
  for (size_t i = 0; i < value_->size(); ++i)
    nodes.push_back(child(std::to_string(i), (*value_)[i]));
  return nodes;
}

std::string Node::string() const {
  if (!value_->is_string()) fail(std::string("must be a string, not ") + value_->type_name());
  return value_->get<std::string>();
}

bool Node::boolean() const {
  if (!value_->is_boolean()) fail(std::string("must be true or false, not ") + value_->type_name());
  return value_->get<bool>();
}

double Node::number(double lowest, double highest) const {
  if (!value_->is_number()) fail(std::string("must be a number, not ") + value_->type_name());
  const double number = value_->get<double>();
  if (!(number >= lowest && number <= highest))
    fail("must be between " + numberText(lowest) + " and " + numberText(highest) + ", not " + numberText(number));
  return number;
}

int64_t Node::integer(int64_t lowest, int64_t highest) const {
  const double value = number(static_cast<double>(lowest), static_cast<double>(highest));
  if (value != std::floor(value)) fail("must be a whole number");
  return static_cast<int64_t>(value);
}

}  // namespace warpscope

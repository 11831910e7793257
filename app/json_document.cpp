// Parsing with lines, and checked access.
// See json_document.h.
#include "app/json_document.h"

#include <fstream>
#include <iterator>
#include <sstream>

#include "render/core/error.h"
#include "render/core/nearest_name.h"

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

std::string escapePointer(std::string key) {
  for (size_t i = 0; i < key.size(); ++i) {
    if (key[i] == '~') key.replace(i++, 1, "~0");
    else if (key[i] == '/') key.replace(i++, 1, "~1");
  }
  return key;
}

/// Builds the value and notes where everything begins.
class LineNotingSax : public nlohmann::json_sax<Json> {
 public:
  LineNotingSax(Json& root, std::map<std::string, int>& lines, const int& line, const std::string& source)
      : root_(root), lines_(lines), line_(line), source_(source) {}

  bool null() override { return put(nullptr); }
  bool boolean(bool value) override { return put(value); }
  bool number_integer(number_integer_t value) override { return put(value); }
  bool number_unsigned(number_unsigned_t value) override { return put(value); }
  bool number_float(number_float_t value, const string_t&) override { return put(value); }
  bool string(string_t& value) override { return put(value); }
  bool binary(binary_t&) override { return false; }
  bool start_object(size_t) override { return open(Json::object()); }
  bool start_array(size_t) override { return open(Json::array()); }
  bool end_object() override { return close(); }
  bool end_array() override { return close(); }
  bool key(string_t& key) override {
    if (open_.back().value->contains(key))
      throw InputError(source_ + ":" + std::to_string(line_) + ": the key '" + key + "' stands there twice");
    key_ = key;
    lines_[open_.back().pointer + "/" + escapePointer(key)] = line_;
    return true;
  }
  bool parse_error(size_t, const std::string& token, const nlohmann::detail::exception& error) override {
    // The parser's text begins with an identifier of its own and the position; what was expected comes last.
    const std::string text = error.what();
    const size_t reason = text.find("; ");
    throw InputError(source_ + ":" + std::to_string(line_) + ": not valid JSON near '" + token.substr(0, 40) + "'" +
                     (reason == std::string::npos ? "" : ": " + text.substr(reason + 2)));
  }

 private:
  struct Open {
    Json* value;
    std::string pointer;
  };

  Json* attach(Json value, std::string& pointer) {
    if (open_.empty()) {
      root_ = std::move(value);
      pointer = "";
      lines_[pointer] = line_;
      return &root_;
    }
    Open& parent = open_.back();
    if (parent.value->is_array()) {
      pointer = parent.pointer + "/" + std::to_string(parent.value->size());
      lines_[pointer] = line_;
      parent.value->push_back(std::move(value));
      return &parent.value->back();
    }
    pointer = parent.pointer + "/" + escapePointer(key_);
    return &((*parent.value)[key_] = std::move(value));
  }
  bool put(Json value) {
    std::string pointer;
    attach(std::move(value), pointer);
    return true;
  }
  bool open(Json value) {
    constexpr size_t kDeepest = 64;
    if (open_.size() >= kDeepest)
      throw InputError(source_ + ":" + std::to_string(line_) + ": nested more than 64 levels deep");
    std::string pointer;
    Json* attached = attach(std::move(value), pointer);
    open_.push_back({attached, pointer});
    return true;
  }
  bool close() {
    open_.pop_back();
    return true;
  }

  Json& root_;
  std::map<std::string, int>& lines_;
  const int& line_;
  const std::string& source_;
  std::vector<Open> open_;
  std::string key_;
};

std::string displayName(const std::string& pointer) {
  std::string name = pointer.empty() ? "the document" : "'" + pointer.substr(1) + "'";
  for (char& c : name)
    if (c == '/') c = '.';
  return name;
}

std::string numberText(double value) {
  std::ostringstream text;
  text << value;
  return text.str();
}

}  // namespace

std::string textOf(const Json& document) { return document.dump(2, ' ', false, Json::error_handler_t::replace) + "\n"; }

JsonDocument::JsonDocument(std::string_view text, std::string source) : source_(std::move(source)) {
  int line = 1;
  LineNotingSax sax(value_, lines_, line, source_);
  Json::sax_parse(CountingIterator(text.data(), &line), CountingIterator(text.data() + text.size(), &line), &sax);
}

JsonDocument JsonDocument::fromFile(const std::filesystem::path& path) {
  constexpr uintmax_t kLargest = 64 << 20;
  std::error_code error;
  const uintmax_t sizeBytes = std::filesystem::file_size(path, error);
  if (error) throw InputError(path.string() + ": cannot be read: " + error.message());
  if (sizeBytes > kLargest) throw InputError(path.string() + ": too large for a JSON file of this program (64 MiB)");
  std::ifstream file(path, std::ios::binary);
  const std::string text{std::istreambuf_iterator<char>(file), {}};
  if (!file) throw InputError(path.string() + ": cannot be read");
  return JsonDocument(text, path.string());
}

Node JsonDocument::root() const { return Node(*this, value_, ""); }

void Node::fail(std::string_view text) const {
  const auto line = document_->lines_.find(pointer_);
  throw InputError(document_->source_ + ":" + std::to_string(line == document_->lines_.end() ? 1 : line->second) + ": " +
                   displayName(pointer_) + " " + std::string(text));
}

void Node::requireObject(std::span<const std::string_view> known) const {
  if (!value_->is_object()) fail(std::string("must be an object, not ") + value_->type_name());
  for (const auto& [key, member] : value_->items())
    if (std::find(known.begin(), known.end(), key) == known.end())
      Node(*document_, member, pointer_ + "/" + escapePointer(key)).fail("is not known here: " + unknownName("key", key, known));
}

std::optional<Node> Node::find(std::string_view key) const {
  const auto member = value_->find(std::string(key));
  if (member == value_->end()) return std::nullopt;
  return Node(*document_, *member, pointer_ + "/" + escapePointer(std::string(key)));
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
    nodes.emplace_back(*document_, (*value_)[i], pointer_ + "/" + std::to_string(i));
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

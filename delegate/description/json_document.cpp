#include "delegate/description/json_document.h"

#include <set>
#include <vector>

namespace alabaster::hd::description {
namespace {

using nlohmann::json;
constexpr size_t kMaxDepth = 64;

// The parser's position. The parser reads one character past a number, hence before_last().
struct Progress {
  const char* at = nullptr;
  const char* end = nullptr;
  size_t line = 1;
  bool last_was_newline = false;

  char take() {
    const char c = *at++;
    last_was_newline = c == '\n';
    line += last_was_newline ? 1 : 0;
    return c;
  }
  size_t before_last() const { return last_was_newline ? line - 1 : line; }
};

// An input iterator over a text. It counts lines in a shared Progress, because the parser copies its iterators.
class CountingIterator {
 public:
  using iterator_category = std::input_iterator_tag;
  using value_type = char;
  using difference_type = std::ptrdiff_t;
  using pointer = const char*;
  using reference = const char&;

  explicit CountingIterator(Progress* progress) : progress_(progress) {}
  reference operator*() const { return *progress_->at; }
  CountingIterator& operator++() {
    progress_->take();
    return *this;
  }
  bool operator==(const CountingIterator& o) const { return at_end() == o.at_end(); }
  bool operator!=(const CountingIterator& o) const { return !(*this == o); }

 private:
  bool at_end() const { return progress_ == nullptr || progress_->at == progress_->end; }
  Progress* progress_;
};

// Builds the table from pointer to line, and refuses duplicate keys and deep nesting, which a DOM would silently
// accept.
class LineRecorder : public nlohmann::json_sax<json> {
 public:
  LineRecorder(const Progress& progress, std::map<std::string, size_t>* lines) : progress_(progress), lines_(*lines) {}

  bool null() override { return scalar(); }
  bool boolean(bool) override { return scalar(); }
  bool number_integer(number_integer_t) override { return scalar(); }
  bool number_unsigned(number_unsigned_t) override { return scalar(); }
  bool number_float(number_float_t, const string_t&) override { return scalar(); }
  bool string(string_t&) override { return scalar(); }
  bool binary(binary_t&) override { return scalar(); }
  bool start_object(size_t) override { return open(false); }
  bool start_array(size_t) override { return open(true); }
  bool end_object() override { return close(); }
  bool end_array() override { return close(); }
  bool key(string_t& name) override {
    Level& level = levels_.back();
    if (!level.keys.insert(name).second) {
      error_ = "line " + std::to_string(progress_.line) + ": the key \"" + name + "\" appears twice; remove one";
      return false;
    }
    level.current = pointer_append(level.pointer, name);
    note_line(level.current, progress_.line);
    return true;
  }
  bool parse_error(size_t, const std::string& token, const nlohmann::detail::exception& e) override {
    const std::string line = "line " + std::to_string(progress_.before_last()) + ": ";
    if (e.id == 406) return error_ = line + token + " is larger than any number; write a smaller one", false;
    std::string what = e.what();
    if (const size_t dash = what.find(": "); dash != std::string::npos) what = what.substr(dash + 2);
    error_ = line + "not valid JSON: " + what;
    if (what.find("last read") == std::string::npos && !token.empty()) error_ += " near '" + token + "'";
    return false;
  }
  const std::string& error() const { return error_; }

 private:
  struct Level {
    std::string pointer;  // of the container
    std::string current;  // of its member
    bool array = false;
    size_t index = 0;
    std::set<std::string> keys;
  };

  // A place with a longer name is told by the line of what contains it: under a long key each entry would cost as much.
  void note_line(const std::string& pointer, size_t line) {
    constexpr size_t kLongestPointer = 1000;
    if (pointer.size() <= kLongestPointer) lines_[pointer] = line;
  }

  std::string begin_value() {
    if (levels_.empty()) return "";
    Level& level = levels_.back();
    if (level.array) {
      level.current = pointer_append(level.pointer, std::to_string(level.index++));
      note_line(level.current, progress_.before_last());
    }
    return level.current;
  }
  bool scalar() {
    begin_value();
    return true;
  }
  bool open(bool array) {
    const std::string pointer = begin_value();
    if (levels_.empty()) lines_[""] = progress_.line;
    if (levels_.size() == kMaxDepth) {
      error_ = "line " + std::to_string(progress_.line) + ": nested deeper than " + std::to_string(kMaxDepth) +
               " levels; simplify the render description";
      return false;
    }
    levels_.push_back({pointer, "", array, 0, {}});
    return true;
  }
  bool close() {
    levels_.pop_back();
    return true;
  }

  const Progress& progress_;
  std::map<std::string, size_t>& lines_;
  std::vector<Level> levels_;
  std::string error_;
};

}  // namespace

std::string JsonDocument::known(std::string pointer) const {
  while (!pointer.empty() && !lines.contains(pointer) && !options.contains(pointer)) pointer.resize(pointer.rfind('/'));
  return pointer;
}

std::string JsonDocument::place(const std::string& pointer) const {
  const std::string found = known(pointer);
  if (const auto option = options.find(found); option != options.end()) return option->second;
  if (lines.empty()) return origin;
  const auto line = lines.find(found);
  constexpr size_t kLongestPointer = 200;
  const std::string shown = pointer.size() > kLongestPointer ? pointer.substr(0, kLongestPointer - 3) + "..." : pointer;
  return origin + ":" + std::to_string(line == lines.end() ? 1 : line->second) + (shown.empty() ? "" : " " + shown);
}

void JsonDocument::set(const std::string& pointer, json set_value, const std::string& option) {
  value[json::json_pointer(pointer)] = std::move(set_value);
  for (auto line = lines.lower_bound(pointer); line != lines.end() && line->first.starts_with(pointer);)
    line = line->first.size() == pointer.size() || line->first[pointer.size()] == '/' ? lines.erase(line)
                                                                                      : std::next(line);
  options[pointer] = option;
}

bool parse_json(const std::string& text, const std::string& origin, JsonDocument* document, std::string* error) {
  *document = {};
  document->origin = origin;
  Progress progress{text.data(), text.data() + text.size()};
  LineRecorder recorder(progress, &document->lines);
  if (!json::sax_parse(CountingIterator(&progress), CountingIterator(nullptr), &recorder)) {
    *error = recorder.error();
    return false;
  }
  document->value = json::parse(text, nullptr, false);
  return true;
}

std::string pointer_append(const std::string& parent, const std::string& step) {
  json::json_pointer pointer;
  pointer.push_back(step);
  return parent + pointer.to_string();
}

}  // namespace alabaster::hd::description

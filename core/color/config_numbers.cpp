#include "core/color/config_numbers.h"

#include <locale>
#include <string_view>

namespace alabaster {
namespace {

// The keys whose values OpenColorIO 2.1 reads as numbers, each between two spaces.
constexpr std::string_view kNumberKeys =
    " allocationvars base black blacks blue brightness center clamp contrast control_points exposure gain gamma green "
    "highlights lift lin_side_break lin_side_offset lin_side_slope linear_slope log_exposure_step log_midway_gray "
    "log_side_offset log_side_slope luma master matrix max_in_value max_out_value midtones min_in_value min_out_value "
    "offset params pivot power red rgb s_contrast sat saturation shadows slope slopes start value vars white whites "
    "width ";

bool is_digit(char c) {
  return c >= '0' && c <= '9';
}
bool is_part_of_key(char c) {
  return (c >= 'a' && c <= 'z') || c == '_';
}
bool is_part_of_number(char c) {
  return is_digit(c) || c == '.' || c == '+' || c == '-' || c == 'e' || c == 'E';
}

/// A decimal number as a whole one with an exponent; anything else as it is.
std::string whole(std::string_view text) {
  size_t at = text.starts_with('-') || text.starts_with('+') ? 1 : 0;
  std::string digits(text.substr(0, at));
  const auto take_digits = [&] {
    const size_t begin = at;
    while (at < text.size() && is_digit(text[at])) digits += text[at++];
    return static_cast<int>(at - begin);
  };
  const int before = take_digits();
  if (at == text.size() || text[at] != '.') return std::string(text);
  ++at;
  const int after = take_digits();
  if (before + after == 0) return std::string(text);
  int exponent = 0;
  if (at < text.size()) {
    const size_t sign = at + 1;
    const bool negative = sign < text.size() && text[sign] == '-';
    at = sign + (sign < text.size() && (text[sign] == '-' || text[sign] == '+') ? 1 : 0);
    if ((text[sign - 1] != 'e' && text[sign - 1] != 'E') || at == text.size() || text.size() - at > 6)
      return std::string(text);
    for (; at < text.size() && is_digit(text[at]); ++at) exponent = 10 * exponent + (text[at] - '0');
    if (at < text.size()) return std::string(text);
    if (negative) exponent = -exponent;
  }
  return digits + "e" + std::to_string(exponent - after);
}

/// Copies YAML and changes the numbers that follow certain keys.
class Rewriter {
 public:
  explicit Rewriter(std::string_view yaml) : yaml_(yaml) { out_.reserve(yaml.size()); }

  std::string run() {
    while (at_ < yaml_.size()) {
      if (yaml_[at_] == '#' && (at_ == 0 || is_space(yaml_[at_ - 1])))
        copy_line();
      else if (is_part_of_key(yaml_[at_]) && (at_ == 0 || !is_part_of_key(yaml_[at_ - 1])))
        take_word();
      else
        out_ += yaml_[at_++];
    }
    return std::move(out_);
  }

 private:
  static bool is_space(char c) { return c == ' ' || c == '\t' || c == '\n' || c == '\r'; }
  bool is(char c) const { return at_ < yaml_.size() && yaml_[at_] == c; }
  void copy() { out_ += yaml_[at_++]; }
  void copy_spaces() {
    while (is(' ') || is('\t')) copy();
  }
  void copy_line() {
    while (at_ < yaml_.size() && !is('\n')) copy();
  }

  void take_word() {
    const size_t begin = at_;
    while (at_ < yaml_.size() && is_part_of_key(yaml_[at_])) copy();
    const std::string key = " " + std::string(yaml_.substr(begin, at_ - begin)) + " ";
    if (!is(':') || kNumberKeys.find(key) == std::string_view::npos) return;
    copy();
    copy_spaces();
    if (is('['))
      take_list();
    else if (at_ < yaml_.size() && is_part_of_number(yaml_[at_]))
      take_number();
    else
      take_block_list();
  }

  void take_number() {
    const size_t begin = at_;
    while (at_ < yaml_.size() && is_part_of_number(yaml_[at_])) ++at_;
    const bool ends = at_ == yaml_.size() || is_space(yaml_[at_]) || is(',') || is(']') || is('}');
    const std::string_view text = yaml_.substr(begin, at_ - begin);
    out_ += ends ? whole(text) : std::string(text);
  }

  // A list such as [1, 2], which may span several lines.
  void take_list() {
    int depth = 0;
    do {
      if (is('#')) copy_line();
      if (is('[')) ++depth;
      if (is(']')) --depth;
      if (at_ < yaml_.size() && is_part_of_number(yaml_[at_]))
        take_number();
      else if (at_ < yaml_.size())
        copy();
    } while (depth > 0 && at_ < yaml_.size());
  }

  // Lines of "- 1".
  void take_block_list() {
    for (;;) {
      size_t line = yaml_.find('\n', at_);
      if (line == std::string_view::npos || !is_empty(at_, line)) return;
      const size_t dash = yaml_.find_first_not_of(" \t", line + 1);
      if (dash == std::string_view::npos || yaml_[dash] != '-' || dash + 1 >= yaml_.size() || yaml_[dash + 1] != ' ')
        return;
      while (at_ <= dash) copy();
      copy_spaces();
      if (at_ < yaml_.size() && is_part_of_number(yaml_[at_])) take_number();
    }
  }
  /// Nothing but spaces and a comment.
  bool is_empty(size_t begin, size_t end) const {
    const size_t first = yaml_.find_first_not_of(" \t\r", begin);
    return first >= end || yaml_[first] == '#';
  }

  std::string_view yaml_;
  std::string out_;
  size_t at_ = 0;
};

}  // namespace

bool streams_read_decimal_points() {
  return std::use_facet<std::numpunct<char>>(std::locale()).decimal_point() == '.';
}

std::string with_whole_numbers(const std::string& yaml) {
  return Rewriter(yaml).run();
}

}  // namespace alabaster

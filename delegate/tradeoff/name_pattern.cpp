#include "delegate/tradeoff/name_pattern.h"

#include <regex.h>

#include <cctype>
#include <cstring>

namespace alabaster::tradeoff {

struct NamePattern::Compiled {
  explicit Compiled(const std::string& text) : error(regcomp(&pattern, text.c_str(), REG_EXTENDED | REG_NOSUB)) {}
  ~Compiled() {
    if (error == 0) regfree(&pattern);
  }
  Compiled(const Compiled&) = delete;
  Compiled& operator=(const Compiled&) = delete;

  regex_t pattern;
  int error;
};

NamePattern::NamePattern(const std::string& text) {
  constexpr size_t kLongest = 500;
  const std::string shown = text.size() > 60 ? text.substr(0, 57) + "..." : text;
  // regcomp() copies what a plus repeats: groups in groups would grow without bound.
  bool back_reference = false, plus_of_group = false;
  for (size_t i = 0; i + 1 < text.size(); ++i) {
    back_reference |= text[i] == '\\' && std::isdigit(static_cast<unsigned char>(text[i + 1]));
    plus_of_group |= std::strchr(")*+?", text[i]) != nullptr && text[i + 1] == '+';
  }
  if (text.size() > kLongest) {
    fault_ = "'" + shown + "' is longer than " + std::to_string(kLongest) + " characters: shorten it.";
  } else if (back_reference || text.find('{') != std::string::npos) {
    fault_ = "'" + shown + "' has a back reference or a count, which are not supported: write names, |, ., *, + and ?.";
  } else if (plus_of_group) {
    fault_ = "'" + shown + "' has a + after a group or a repetition, which is not supported: write * instead.";
  } else if (!text.empty()) {
    const auto compiled = std::make_shared<const Compiled>(text);
    char reason[200] = "";
    if (compiled->error != 0) regerror(compiled->error, &compiled->pattern, reason, sizeof reason);
    if (compiled->error == 0)
      compiled_ = compiled;
    else
      fault_ = "'" + shown + "' is not a regular expression (" + reason + "): correct it.";
  }
}

bool NamePattern::matches(const std::string& name) const {
  if (!fault_.empty()) return false;
  return !compiled_ || regexec(&compiled_->pattern, name.c_str(), 0, nullptr, 0) == 0;
}

}  // namespace alabaster::tradeoff

#include "testenv/view/player/script.h"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <optional>
#include <sstream>

namespace alabaster::view {
namespace {

struct Form {
  const char* name;
  const char* words;  // a letter each: p pixels, n a number, w a word
};
constexpr Form kForms[] = {
    {"size", "pp"},      {"drag", "wnnnn"}, {"click", "nn"}, {"wheel", "nnn"}, {"key", "w"},
    {"press", "w"},      {"choose", "ww"},  {"slide", "wn"}, {"type", "ww"},   {"copy", "ww"},
    {"screenshot", "w"}, {"state", ""},     {"quit", ""},
};

/// The range of a number. No screen is larger, and GLFW ends the program at sizes below 0; a wait beyond an hour is a
/// mistake.
struct Range {
  double least, most;
  const char* what;
};
constexpr Range kPixels{1, 16384, "a whole number of pixels"}, kNumbers{-1e4, 1e4, "a number"},
    kSeconds{0, 3600, "a number of seconds"}, kSamples{0, 1e9, "a number of samples"};

std::optional<double> number_of(const std::string& word) {
  double number = 0;
  const char* const end = word.data() + word.size();
  const auto [stop, error] = std::from_chars(word.data(), end, number);
  return error == std::errc() && stop == end ? std::optional(number) : std::nullopt;
}

std::string range_fault(const std::string& word, const Range& range) {
  const auto number = number_of(word);
  const bool fits = number && *number >= range.least && *number <= range.most;  // no NaN does
  if (fits && (&range != &kPixels || *number == std::floor(*number))) return {};
  std::ostringstream text;
  text << "'" << word << "' is not " << range.what << " from " << range.least << " to " << range.most;
  return text.str();
}

// False if a quoted word has no end.
bool split(const std::string& line, std::vector<std::string>* words) {
  for (size_t i = 0; i < line.size();) {
    if (line[i] == '#') return true;
    if (line[i] == ' ' || line[i] == '\t' || line[i] == '\r') {
      ++i;
      continue;
    }
    const bool quoted = line[i] == '"';
    const size_t begin = quoted ? i + 1 : i;
    const size_t end = quoted ? line.find('"', begin) : std::min(line.find_first_of(" \t\r", begin), line.size());
    if (end == std::string::npos) return false;
    words->push_back(line.substr(begin, end - begin));
    i = quoted ? end + 1 : end;
  }
  return true;
}

// "wait samples 4 30" and its kin: a condition, its number, and the longest time.
std::string wait_fault(const std::vector<std::string>& words) {
  const bool counted = !words.empty() && (words[0] == "samples" || words[0] == "seconds");
  if (!counted && (words.empty() || (words[0] != "covered" && words[0] != "converged")))
    return "wait for covered, converged, samples N or seconds S";
  const size_t least = counted ? 2 : 1;
  if (words.size() < least || words.size() > least + 1) return "wait " + words[0] + " has too few or too many words";
  for (size_t i = 1; i < words.size(); ++i)
    if (std::string fault = range_fault(words[i], i == 1 && words[0] == "samples" ? kSamples : kSeconds);
        !fault.empty())
      return fault;
  if (words[0] == "seconds" && words.size() > 2 && *number_of(words[1]) > *number_of(words[2]))
    return "wait seconds " + words[1] + " takes longer than the " + words[2] + " seconds that it may take";
  return {};
}

std::string fault(const ScriptAction& action) {
  if (action.name == "wait") return wait_fault(action.words);
  for (const Form& form : kForms) {
    if (action.name != form.name) continue;
    const std::string wanted = form.words;
    if (wanted.size() != action.words.size())
      return action.name + " takes " + std::to_string(wanted.size()) + " words, not " +
             std::to_string(action.words.size());
    for (size_t i = 0; i < wanted.size(); ++i)
      if (wanted[i] != 'w')
        if (std::string fault = range_fault(action.words[i], wanted[i] == 'p' ? kPixels : kNumbers); !fault.empty())
          return fault;
    return {};
  }
  return "there is no action '" + action.name + "'";
}

}  // namespace

double ScriptAction::number(size_t i) const {
  return number_of(words[i]).value_or(0);
}

Script read_script(const std::string& text) {
  Script script;
  std::istringstream stream(text);
  int number = 0;
  for (std::string line; std::getline(stream, line);) {
    ++number;
    std::vector<std::string> words;
    std::string problem = split(line, &words) ? "" : "a word in quotes has no end";
    if (problem.empty() && words.empty()) continue;
    ScriptAction action{number, words.empty() ? "" : words[0], {}};
    if (problem.empty()) {
      action.words.assign(words.begin() + 1, words.end());
      problem = fault(action);
    }
    if (!problem.empty()) {
      script.problem = "line " + std::to_string(number) + ": " + problem;
      return script;
    }
    script.actions.push_back(std::move(action));
  }
  return script;
}

}  // namespace alabaster::view

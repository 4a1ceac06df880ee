#include "delegate/view/script.h"

#include <algorithm>
#include <cmath>
#include <sstream>

namespace alabaster::view {
namespace {

struct Form {
  const char* name;
  const char* words;  // a letter each: n a number, w a word
};
constexpr Form kForms[] = {
    {"size", "nn"},   {"drag", "wnnnn"}, {"click", "nn"}, {"wheel", "nnn"},    {"key", "w"},  {"press", "w"},
    {"choose", "ww"}, {"slide", "wn"},   {"type", "ww"},  {"screenshot", "w"}, {"state", ""}, {"quit", ""},
};

bool is_number(const std::string& word) {
  std::istringstream stream(word);
  double number = 0;
  return stream >> number && stream.peek() == std::char_traits<char>::eof() && std::isfinite(number);
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
    if (!is_number(words[i])) return "'" + words[i] + "' is not a number";
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
      if (wanted[i] == 'n' && !is_number(action.words[i])) return "'" + action.words[i] + "' is not a number";
    return {};
  }
  return "there is no action '" + action.name + "'";
}

}  // namespace

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

// A JSON text together with the origin of each of its values, so that errors can name it: a line of the file, or an
// option that was set over it.
#pragma once

#include <map>
#include <nlohmann/json.hpp>
#include <string>

namespace alabaster::hd::description {

struct JsonDocument {
  nlohmann::json value;
  std::string origin;                          // the file, as shown to people
  std::map<std::string, size_t> lines;         // JSON pointer -> line; empty if the origin has no lines
  std::map<std::string, std::string> options;  // JSON pointer -> the option that set it: "--spp 16"

  /// "scene.json:12 /materials/0/set"; the option alone, or the origin alone if it has no lines.
  std::string place(const std::string& pointer) const;
  /// True if an option set the value, and not the file.
  bool is_of_option(const std::string& pointer) const { return options.contains(known(pointer)); }
  /// Sets a value in the place of the file's.
  void set(const std::string& pointer, nlohmann::json set_value, const std::string& option);

 private:
  /// The innermost value of known origin that holds the one at `pointer`.
  std::string known(std::string pointer) const;
};

/// Parses strictly (no comments, no duplicate keys, at most 64 levels). False if the text is invalid; *error then names
/// the fault and its line.
bool parse_json(const std::string& text, const std::string& origin, JsonDocument* document, std::string* error);

/// `parent` with one more step, escaped as RFC 6901 requires.
std::string pointer_append(const std::string& parent, const std::string& step);

}  // namespace alabaster::hd::description

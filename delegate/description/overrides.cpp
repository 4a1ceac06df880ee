#include <algorithm>
#include <sstream>

#include "delegate/description/description_reader.h"
#include "delegate/description/name_match.h"

namespace alabaster::hd::description {
namespace {

using nlohmann::json;

// The limit is about that of a description's file. Readers of values take stack for each level.
bool is_too_deep(const std::string& text) {
  constexpr int kMostLevels = 60;
  int depth = 0;
  return std::any_of(text.begin(), text.end(), [&](char c) {
    if (c == ']' || c == '}') --depth;
    return (c == '[' || c == '{') && ++depth > kMostLevels;
  });
}

/// JSON has digits on both sides of a point and no plus sign; people write .1, 1. and +1.
std::string with_all_digits(const std::string& text) {
  const auto digit_at = [&](size_t i) { return i < text.size() && text[i] >= '0' && text[i] <= '9'; };
  std::string out;
  bool quoted = false;
  for (size_t i = 0; i < text.size(); ++i) {
    const char c = text[i];
    if (c == '"' && (i == 0 || text[i - 1] != '\\')) quoted = !quoted;
    const bool point = c == '.' && !quoted, before = i > 0 && digit_at(i - 1), after = digit_at(i + 1);
    if (c == '+' && !quoted && (i == 0 || text[i - 1] == '[' || text[i - 1] == ',')) continue;
    if (point && !before && after) out += '0';
    out += c;
    if (point && before && !after) out += '0';
  }
  return out;
}

json json_or_text(const std::string& text) {
  json value = json::parse(text, nullptr, false);
  if (value.is_discarded()) value = json::parse(with_all_digits(text), nullptr, false);
  return value.is_discarded() ? json(text) : value;
}

// "materials/skin.roughness" -> {"materials": [{"match": "skin", "set": {"roughness": value}}]}
json patch_for(const std::string& place, json value, std::string* error) {
  const size_t slash = place.find('/');
  if (slash == std::string::npos) {
    const bool camera = place.rfind("camera.", 0) == 0;
    return camera ? json{{"camera", {{place.substr(7), value}}}} : json{{"settings", {{place, value}}}};
  }
  const std::string kind = place.substr(0, slash);
  const size_t dot = place.rfind('.');
  if (dot == std::string::npos || dot < slash + 2 || dot + 1 == place.size()) {
    *error = "'" + place + "' does not name a parameter: write " + kind + "/NAME.parameter=value.";
    return {};
  }
  const std::string name = place.substr(slash + 1, dot - slash - 1), parameter = place.substr(dot + 1);
  json entry{{"match", name}};
  if (kind == "materials") {
    entry["set"][parameter] = std::move(value);
  } else {
    entry[parameter] = std::move(value);
  }
  if (kind == "materials" || kind == "meshes" || kind == "lights") return json{{kind, {entry}}};
  *error = "'" + kind + "' cannot be set." + suggestion(kind, {"materials", "meshes", "lights"});
  return {};
}

std::optional<double> to_number(const std::string& text) {
  if (is_too_deep(text)) return std::nullopt;
  const json value = json_or_text(text);
  return value.is_number() ? std::optional(value.get<double>()) : std::nullopt;
}

}  // namespace

bool is_utf8(const std::string& text) {
  try {
    json(text).dump();
    return true;
  } catch (const json::type_error&) {
    return false;
  }
}

bool override_document(const std::string& assignment, JsonDocument* document, std::string* error) {
  const size_t equals = assignment.find('=');
  if (equals == std::string::npos || equals == 0) {
    *error = "'" + assignment + "' is not an assignment: write key=value.";
    return false;
  }
  if (!is_utf8(assignment)) {
    *error = "It is not UTF-8, as names and values of a scene are.";
    return false;
  }
  if (is_too_deep(assignment)) {
    *error = "The value is nested too deeply: no setting has more than a few levels.";
    return false;
  }
  error->clear();
  *document = {};
  document->origin = assignment;
  document->value = patch_for(assignment.substr(0, equals), json_or_text(assignment.substr(equals + 1)), error);
  return error->empty();
}

JsonDocument dome_document(const std::string& dome) {
  std::vector<std::string> parts;
  std::istringstream stream(dome);
  for (std::string part; std::getline(stream, part, ',');) parts.push_back(part);
  std::vector<double> numbers;
  for (const std::string& part : parts)
    if (const auto number = to_number(part)) numbers.push_back(*number);
  json light{{"name", "dome"}, {"type", "domeLight"}};
  if (!parts.empty() && numbers.size() == parts.size() && numbers.size() <= 4) {
    const bool gray = numbers.size() <= 2;
    light["color"] = gray ? json{numbers[0], numbers[0], numbers[0]} : json{numbers[0], numbers[1], numbers[2]};
    if (numbers.size() % 2 == 0) light["intensity"] = numbers.back();
  } else if (parts.size() > 1 && to_number(parts.back())) {
    light["intensity"] = numbers.back();
    light["texture:file"] = dome.substr(0, dome.rfind(','));
  } else {
    light["texture:file"] = dome;
  }
  JsonDocument document;
  document.origin = "dome " + dome;
  document.value = json{{"lights", {light}}};
  return document;
}

}  // namespace alabaster::hd::description

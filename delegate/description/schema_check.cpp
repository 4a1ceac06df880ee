#include "delegate/description/schema_check.h"

#include <algorithm>
#include <limits>
#include <map>

#include "delegate/description/render_description.h"
#include "delegate/host/schemas.h"
#include "delegate/support/nearest_name.h"
#include "delegate/support/retired_settings.h"
#include "delegate/support/schema_text.h"

namespace alabaster::hd::description {
namespace {

using nlohmann::json;

using Schemas = std::map<std::string, json>;  // by their names, each parsed once

const json& parsed_schema(const std::string& name, Schemas* parsed) {
  const auto found = parsed->find(name);
  return found != parsed->end() ? found->second : parsed->emplace(name, json::parse(SchemaText(name))).first->second;
}

void expand(json* node, const json& root, Schemas* parsed) {
  if (node->is_object() && node->contains("$ref")) {
    const std::string target = (*node)["$ref"];
    const size_t hash = target.find('#');
    const std::string file = target.substr(0, hash);
    const json::json_pointer pointer(hash == std::string::npos ? "" : target.substr(hash + 1));
    const std::string name = file.substr(0, file.rfind('.'));
    const json& document = file.empty() ? root : parsed_schema(name, parsed);
    json replacement = document.at(pointer);
    expand(&replacement, document, parsed);
    *node = std::move(replacement);
    return;
  }
  if (node->is_structured())
    for (json& child : *node) expand(&child, root, parsed);
}

// A schema and, recursively, all its alternatives.
std::vector<const json*> alternatives(const json& schema) {
  std::vector<const json*> all{&schema};
  for (const char* key : {"anyOf", "oneOf", "allOf"})
    if (const auto list = schema.find(key); list != schema.end())
      for (const json& child : *list) {
        const auto more = alternatives(child);
        all.insert(all.end(), more.begin(), more.end());
      }
  return all;
}

// The schema of a member by this schema alone, without its alternatives; null if it describes none.
const json* own_member(const json& schema, const std::string& key, bool in_array) {
  const auto members = schema.find(in_array ? "items" : "properties");
  if (members == schema.end()) return nullptr;
  if (in_array) return &*members;
  const auto found = members->find(key);
  return found == members->end() ? nullptr : &*found;
}
const json* member_schema(const json& schema, const std::string& key, bool in_array) {
  for (const json* part : alternatives(schema))
    if (const json* member = own_member(*part, key, in_array)) return member;
  return nullptr;
}

// The keywords of JSON schemas that schemas/ uses are those of this file; a test fails for another one.
struct Type {
  const char* name;
  bool (json::*is)() const noexcept;
  const char *one, *several;  // in messages
};
constexpr Type kTypes[] = {{"number", &json::is_number, "a number", "numbers"},
                           {"integer", &json::is_number_integer, "a whole number", "whole numbers"},
                           {"boolean", &json::is_boolean, "true or false", "entries"},
                           {"string", &json::is_string, "text", "entries"},
                           {"array", &json::is_array, "a list", "entries"},
                           {"object", &json::is_object, "an object", "entries"}};
// Null: the schema does not say it.
const Type* type_of(const json& schema) {
  const auto name = schema.find("type");
  const auto* found = name == schema.end() ? std::end(kTypes)
                                           : std::find_if(std::begin(kTypes), std::end(kTypes),
                                                          [&](const Type& type) { return *name == type.name; });
  return found == std::end(kTypes) ? nullptr : found;
}

std::string range_text(const json& schema) {
  const bool low = schema.contains("minimum"), high = schema.contains("maximum");
  if (low && high) return " from " + schema["minimum"].dump() + " to " + schema["maximum"].dump();
  if (low) return ", at least " + schema["minimum"].dump();
  if (high) return ", at most " + schema["maximum"].dump();
  if (schema.contains("exclusiveMinimum")) return " above " + schema["exclusiveMinimum"].dump();
  return "";
}

std::string array_expectation(const json& schema) {
  const json items = schema.value("items", json::object());
  const Type* const type = type_of(items);
  const std::string entries = (type ? type->several : "entries") + range_text(items);
  const json low = schema.value("minItems", json());
  if (low.is_null()) return "a list of " + entries;
  return (low == schema.value("maxItems", json()) ? "a list of " : "a list of at least ") + low.dump() + " " + entries;
}

std::string object_expectation(const json& schema) {
  std::string either;
  for (const json& choice : schema.value("anyOf", json::array())) {
    std::string keys;
    for (const json& key : choice.value("required", json::array()))
      keys += (keys.empty() ? "'" : " and '") + key.get<std::string>() + "'";
    either += (either.empty() ? " with " : ", or with ") + keys;
  }
  return "an object" + either;
}

/// The beginning that a pattern, "^BEGINNING.", requires.
std::string beginning_of(const json& schema) {
  const std::string pattern = schema.value("pattern", "");
  return pattern.size() < 2 ? std::string() : pattern.substr(1, pattern.size() - 2);
}

// Puts into words which values the schema accepts.
std::string expectation(const json& schema) {
  if (schema.contains("enum")) {
    std::string text;
    for (const json& choice : schema["enum"]) text += (text.empty() ? "one of " : ", ") + choice.get<std::string>();
    return text;
  }
  if (schema.contains("pattern")) return "a text that begins with '" + beginning_of(schema) + "'";
  const Type* const type = type_of(schema);
  if (type && type->is == &json::is_array) return array_expectation(schema);
  if (type && type->is == &json::is_object) return object_expectation(schema);
  if (type && !(type->is == &json::is_string && schema.contains("anyOf"))) return type->one + range_text(schema);
  std::string text;
  for (const char* key : {"anyOf", "allOf"})
    for (const json& choice : schema.value(key, json::array()))
      text += (text.empty() ? "" : ", or ") + expectation(choice);
  return text;
}

/// " Did you mean 'walk'?" of a value that is none of the words of the schema and its alternatives; empty if none is
/// near.
std::string near_choice(const json& value, const json& schema) {
  std::vector<std::string> words;
  for (const json* part : alternatives(schema))
    for (const json& word : part->value("enum", json::array())) words.push_back(word);
  return value.is_string() ? support::Suggestion(value.get<std::string>(), words) : std::string();
}

std::string shortened(const std::string& text) {
  return text.size() > 60 ? text.substr(0, 57) + "..." : text;
}

std::string shortened(const json& value) {
  return shortened(value.dump(-1, ' ', false, json::error_handler_t::replace));
}

constexpr size_t kMostMessages = 100;

/// Type, range, length and words of a value, but not its members.
bool fits_itself(const json& value, const json& schema) {
  if (const Type* const type = type_of(schema); type && !(value.*type->is)()) return false;
  if (const auto words = schema.find("enum"); words != schema.end())
    if (std::find(words->begin(), words->end(), value) == words->end()) return false;
  if (value.is_number()) {
    const auto number = value.get<double>();
    constexpr double kInfinite = std::numeric_limits<double>::infinity();
    return number >= schema.value("minimum", -kInfinite) && number <= schema.value("maximum", kInfinite) &&
           number > schema.value("exclusiveMinimum", -kInfinite);
  }
  if (value.is_string()) {
    const std::string beginning = beginning_of(schema);
    const auto& text = value.get_ref<const std::string&>();
    return text.size() >= schema.value("minLength", size_t(0)) &&
           (beginning.empty() || (text.starts_with(beginning) && text.size() > beginning.size()));
  }
  return !value.is_array() ||
         (value.size() >= schema.value("minItems", size_t(0)) && value.size() <= schema.value("maxItems", ~size_t(0)));
}

std::vector<std::string> missing_keys(const json& value, const json& schema) {
  std::vector<std::string> missing;
  if (const auto required = schema.find("required"); required != schema.end())
    for (const json& key : *required)
      if (!value.contains(key.get_ref<const std::string&>())) missing.push_back(key);
  return missing;
}

/// The alternative of the value's type, if there is just one and it describes members.
const json* only_of_type(const json& value, const json& choices) {
  const json* found = nullptr;
  for (const json& choice : choices)
    if (value.is_object() && choice.contains("properties")) {
      if (found) return nullptr;
      found = &choice;
    }
  return found;
}

/// The member, or entry of a member, of which `key` is a key: "set" for baseColor of an edit of materials,
/// "materials/set" from the description on. Empty: there is none within that many levels.
std::string home_of(const std::string& key, const json& schema, int levels) {
  std::map<std::string, const json*> members;
  std::string found;  // the last match by name, so that "set" is preferred to "replace"
  for (const std::string& name : known_keys(schema)) {
    const json* member = member_schema(schema, name, false);
    if (const json* entry = member_schema(*member, {}, true)) member = entry;
    if (member_schema(*member, key, false)) found = name;
    members.emplace(name, member);
  }
  for (auto it = members.begin(); it != members.end() && found.empty() && levels > 1; ++it)
    if (const std::string home = home_of(key, *it->second, levels - 1); !home.empty()) found = it->first + "/" + home;
  return found;
}

class Checker {
 public:
  Checker(const JsonDocument& document, const DiagnosticSink& sink) : document_(document), sink_(sink) {}

  bool run() {
    find_unknown_keys(document_.value, schema_, "");
    if (clean_) check(document_.value, schema_, "");
    if (faults_ > kMostMessages && sink_)
      sink_({Severity::error, "description.more", document_.origin,
             "There are " + std::to_string(faults_ - kMostMessages) + " more faults like these."});
    return clean_;
  }

 private:
  bool fail(const char* code, const std::string& pointer, const std::string& text) {
    clean_ = false;
    if (++faults_ <= kMostMessages && sink_) sink_({Severity::error, code, document_.place(pointer), text});
    return false;
  }

  void find_unknown_keys(const json& value, const json& schema, const std::string& pointer) {
    if (!value.is_structured()) return;
    const std::vector<std::string> known = known_keys(schema);
    for (const auto& [key, child] : value.items()) {
      const std::string place = pointer_append(pointer, key);
      const json* of_child = member_schema(schema, key, value.is_array());
      if (of_child) {
        find_unknown_keys(child, *of_child, place);
      } else if (value.is_object() && !known.empty()) {
        const std::string retired = retired_text(pointer, key, "");
        fail("description.key.unknown", place,
             retired.empty() ? "Unknown key '" + shortened(key) + "'." + right_key(key, known, schema) : retired);
      }
    }
  }

  std::string right_key(const std::string& key, const std::vector<std::string>& known, const json& schema) const {
    const std::string near = support::Suggestion(key, known);
    std::string home = near.empty() ? home_of(key, schema, 1) : "";
    if (near.empty() && home.empty()) home = home_of(key, schema_, 2);
    return home.empty() ? near : " '" + home + "' has a key of this name.";
  }

  static std::string retired_text(const std::string& pointer, const std::string& key, const std::string& value) {
    return pointer == "/settings" ? support::RetiredSetting(key, value) : std::string();
  }

  /// True if the value satisfies the schema. Else reports the innermost faults of the value, or the first one of each
  /// list that has too many or too few entries.
  bool check(const json& value, const json& schema, const std::string& pointer) {
    if (!fits_itself(value, schema)) return report_value(value, schema, pointer);
    bool fits = true;
    if (const auto all = schema.find("allOf"); all != schema.end())
      for (const json& part : *all) {
        if (!fits_itself(value, part)) return report_value(value, part, pointer, schema.value("description", ""));
        fits = check(value, part, pointer) && fits;
      }
    if (const auto any = schema.find("anyOf"); any != schema.end() && !fits_one_of(value, *any)) {
      const json* alone = only_of_type(value, *any);
      return alone ? check(value, *alone, pointer) : report_value(value, schema, pointer);
    }
    for (const std::string& key : missing_keys(value, schema)) fits = report_missing(key, schema, pointer);
    return (!value.is_structured() || check_members(value, schema, pointer)) && fits;
  }

  bool check_members(const json& value, const json& schema, const std::string& pointer) {
    const bool is_closed = value.is_object() && !schema.value("additionalProperties", true);
    bool fit = true;
    for (const auto& [key, child] : value.items()) {
      const json* of_child = own_member(schema, key, value.is_array());
      fit = (of_child ? check(child, *of_child, pointer_append(pointer, key)) : !is_closed) && fit;
    }
    return fit;
  }

  bool fits_one_of(const json& value, const json& choices) {
    ++trials_;
    const bool fits =
        std::any_of(choices.begin(), choices.end(), [&](const json& choice) { return check(value, choice, ""); });
    --trials_;
    return fits;
  }

  bool report_missing(const std::string& key, const json& schema, const std::string& pointer) {
    if (trials_ > 0) return false;
    const json* wanted = member_schema(schema, key, false);
    return fail("description.key.missing", pointer,
                "'" + key + "' is missing." + (wanted ? " " + wanted->value("description", "") : ""));
  }
  /// `meaning`: of the value; empty: the schema's own description.
  bool report_value(const json& value, const json& schema, const std::string& pointer, std::string meaning = {}) {
    if (trials_ > 0) return false;
    if (meaning.empty()) meaning = schema.value("description", "");
    const size_t slash = pointer.rfind('/');
    if (value.is_string() && slash != std::string::npos)
      if (const std::string retired =
              retired_text(pointer.substr(0, slash), pointer.substr(slash + 1), value.get<std::string>());
          !retired.empty())
        return fail("description.value", pointer, retired);
    const std::string near = near_choice(value, schema);
    return fail("description.value", pointer,
                shortened(value) + " is not valid: expected " + expectation(schema) + "." + near +
                    (meaning.empty() ? "" : " " + meaning));
  }

  const JsonDocument& document_;
  const json& schema_ = description_schema();
  const DiagnosticSink& sink_;
  bool clean_ = true;
  size_t faults_ = 0;
  int trials_ = 0;  // above 0: an alternative is tried, and its faults are not reported
};

}  // namespace

std::vector<std::string> known_keys(const json& schema) {
  std::vector<std::string> keys;
  for (const json* part : alternatives(schema))
    if (part->contains("properties"))
      for (const auto& [key, value] : (*part)["properties"].items()) keys.push_back(key);
  return keys;
}

json expanded_schema(const std::string& name) {
  Schemas parsed;
  const json& root = parsed_schema(name, &parsed);
  json expanded = root;
  for (const char* key : {"$id", "$schema", "definitions"}) expanded.erase(key);
  expand(&expanded, root, &parsed);
  return expanded;
}

const json& description_schema() {
  static const auto* schema = new json(expanded_schema("render_description"));
  return *schema;
}

bool check_description(const JsonDocument& document, const DiagnosticSink& sink) {
  return Checker(document, sink).run();
}

// A row of a table is in the schemas of the library that has the row: they are made from the tables, once. They are
// never destroyed, because threads may load while the process ends.
const char* SchemaText(const std::string& name) {
  static const auto* made = new std::map<std::string, std::string>([] {
    std::map<std::string, std::string> texts = host::TableSchemas();
    texts["render_description"] = host::WithTables(support::schema_text("render_description"));
    return texts;
  }());
  const auto found = made->find(name);
  return found == made->end() ? support::schema_text(name) : found->second.c_str();
}

}  // namespace alabaster::hd::description

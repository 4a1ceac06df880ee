#include "delegate/description/schema_check.h"

#include <algorithm>
#include <map>
#include <set>

#include "delegate/description/name_match.h"
#include "delegate/description/render_description.h"
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

// The schema of a member of the object or array that `schema` describes; null if it describes none.
const json* member_schema(const json& schema, const std::string& step, bool in_array) {
  for (const json* part : alternatives(schema)) {
    if (in_array && part->contains("items")) return &(*part)["items"];
    if (in_array || !part->contains("properties")) continue;
    const json& properties = (*part)["properties"];
    if (const auto found = properties.find(step); found != properties.end()) return &*found;
  }
  return nullptr;
}

std::vector<std::string> known_keys(const json& schema) {
  std::vector<std::string> keys;
  for (const json* part : alternatives(schema))
    if (part->contains("properties"))
      for (const auto& [key, value] : (*part)["properties"].items()) keys.push_back(key);
  return keys;
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
  const std::string type = items.value("type", "");
  const std::string of = type == "number" ? "numbers" : type == "integer" ? "whole numbers" : "entries";
  const json low = schema.value("minItems", json()), high = schema.value("maxItems", json());
  if (!low.is_null() && low == high) return "a list of " + low.dump() + " " + of + range_text(items);
  if (!low.is_null()) return "a list of at least " + low.dump() + " " + of + range_text(items);
  return "a list of " + of + range_text(items);
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

// Puts into words which values the schema accepts.
std::string expectation(const json& schema) {
  if (schema.contains("enum")) {
    std::string text;
    for (const json& choice : schema["enum"]) text += (text.empty() ? "one of " : ", ") + choice.get<std::string>();
    return text;
  }
  const std::string type = schema.value("type", "");
  if (type == "number") return "a number" + range_text(schema);
  if (type == "integer") return "a whole number" + range_text(schema);
  if (type == "boolean") return "true or false";
  if (type == "string") return "text";
  if (type == "array") return array_expectation(schema);
  if (type == "object") return object_expectation(schema);
  std::string text;
  for (const char* key : {"anyOf", "allOf"})
    for (const json& choice : schema.value(key, json::array()))
      text += (text.empty() ? "" : ", or ") + expectation(choice);
  return text;
}

std::string shortened(const std::string& text) {
  return text.size() > 60 ? text.substr(0, 57) + "..." : text;
}

std::string shortened(const json& value) {
  return shortened(value.dump(-1, ' ', false, json::error_handler_t::replace));
}

constexpr size_t kMostMessages = 100;

class Checker {
 public:
  Checker(const JsonDocument& document, const DiagnosticSink& sink) : document_(document), sink_(sink) {}

  bool run() {
    find_unknown_keys(document_.value, schema_, "");
    if (clean_) report_violations();
    if (faults_ > kMostMessages && sink_)
      sink_({Severity::error, "description.more", document_.origin,
             "There are " + std::to_string(faults_ - kMostMessages) + " more faults like these."});
    return clean_;
  }

 private:
  void fail(const char* code, const std::string& pointer, const std::string& text) {
    clean_ = false;
    if (++faults_ <= kMostMessages && sink_) sink_({Severity::error, code, document_.place(pointer), text});
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
             retired.empty() ? "Unknown key '" + shortened(key) + "'." + suggestion(key, known) : retired);
      }
    }
  }

  static std::string retired_text(const std::string& pointer, const std::string& key, const std::string& value) {
    return pointer == "/settings" ? support::RetiredSetting(key, value) : std::string();
  }

  // The validator names a violation and everything that contains it, and every alternative that failed. This keeps the
  // innermost place, but none deeper than the alternatives' own.
  void report_violations() {
    std::vector<Violation> found = find_violations(document_.value);
    std::set<Steps> choices, insides;  // insides: places that contain another violation
    for (const Violation& v : found) {
      if (is_choice(v)) choices.insert(v.steps);
      for (Steps outer = v.steps; !outer.empty();) {
        outer.pop_back();
        if (!insides.insert(outer).second) break;  // then those that contain it are known
      }
    }
    std::erase_if(found, [&](const Violation& v) {
      if (is_inside(v.steps, choices)) return true;
      return !is_choice(v) && (choices.contains(v.steps) || insides.contains(v.steps));
    });
    std::set<Steps> told;
    for (const Violation& v : found)
      if (told.insert(v.steps).second) report_violation(v);
  }

  using Steps = std::vector<std::string>;
  static bool is_choice(const Violation& v) { return v.text.find("anyOf") != std::string::npos; }
  static bool is_inside(Steps steps, const std::set<Steps>& places) {
    while (!steps.empty()) {
      steps.pop_back();
      if (places.contains(steps)) return true;
    }
    return false;
  }

  void report_violation(const Violation& violation) {
    std::string pointer;
    const json* value = &document_.value;
    const json* schema = &schema_;
    for (const std::string& step : violation.steps) {
      pointer = pointer_append(pointer, step);
      if (schema) schema = member_schema(*schema, step, value->is_array());
      value = value->is_array() ? &(*value)[std::stoul(step)] : &(*value)[step];
    }
    const std::string missing = "Missing required property '";
    if (const size_t at = violation.text.find(missing); at != std::string::npos) {
      const size_t start = at + missing.size();
      const std::string key = violation.text.substr(start, violation.text.find('\'', start) - start);
      const json* wanted = schema ? member_schema(*schema, key, false) : nullptr;
      fail("description.key.missing", pointer,
           "'" + key + "' is missing." + (wanted ? " " + wanted->value("description", "") : ""));
      return;
    }
    if (violation.steps.size() == 2 && value->is_string())
      if (const std::string retired =
              retired_text("/" + violation.steps[0], violation.steps[1], value->get<std::string>());
          !retired.empty())
        return fail("description.value", pointer, retired);
    fail("description.value", pointer,
         shortened(*value) + " is not valid" +
             (schema ? ": expected " + expectation(*schema) + ". " + schema->value("description", "") : "."));
  }

  const JsonDocument& document_;
  const json& schema_ = description_schema();
  const DiagnosticSink& sink_;
  bool clean_ = true;
  size_t faults_ = 0;
};

}  // namespace

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

const char* SchemaText(const std::string& name) {
  return support::schema_text(name);
}

}  // namespace alabaster::hd::description

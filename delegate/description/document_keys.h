// The keys of a render description: a table from which documents are checked and schemas written. Internal to this
// room.
#pragma once

#include <nlohmann/json.hpp>

#include "delegate/api/types.h"
#include "delegate/description/json_document.h"
#include "delegate/host/scene_fields.h"

namespace alabaster::hd::description {

struct Key;
using Keys = std::vector<Key>;

inline constexpr double kInfinite = std::numeric_limits<double>::infinity();

/// One key, or one entry of a list.
struct Key {
  host::FieldRow row;     // name and meaning; of a value type, range, unit and default, too
  std::string kind = {};  // whose table of fields has the row and checks values; empty: it is the description's own
  Keys keys = {};         // of an object, or of each object of a list
  enum class Form { value, object, values, objects, value_or_object, values_or_object } form = Form::value;
  size_t least = 0, most = ~size_t(0);               // entries of a list
  std::vector<std::vector<std::string>> needs = {};  // the keys of one of these sets must be there
  std::string reference = {};                        // what a schema refers to in its place
  bool has_own_text = false;                         // which the schema has beside the reference
  std::vector<std::string> beginnings = {};          // of texts beside the row's words
};

/// All of a description, as an object of its parts. Any thread.
const Key& description_key();
/// colorTexture, numberTexture or distanceTexture.
Key texture_key(const std::string& name);
/// A key by name; null: there is none.
const Key* find_key(const Keys& keys, const std::string& name);
std::vector<std::string> names_of(const Keys& keys);

/// True if the document's keys are known, and each value fits its row. Otherwise reports every fault: unknown keys
/// first, each with the nearest known key, then values and missing keys.
bool check_description(const JsonDocument& document, const DiagnosticSink& sink);

}  // namespace alabaster::hd::description

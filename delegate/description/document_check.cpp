// Checks the form of a description by the table of its keys, and values by the tables of fields.
#include <algorithm>
#include <limits>

#include "delegate/description/document_keys.h"
#include "delegate/description/lengths.h"
#include "delegate/support/json_values.h"
#include "delegate/support/nearest_name.h"
#include "delegate/support/retired_settings.h"

namespace alabaster::hd::description {
namespace {

using nlohmann::json;
using Form = Key::Form;

constexpr size_t kMostMessages = 100;

std::string shortened(const std::string& text) {
  return text.size() > 60 ? text.substr(0, 57) + "..." : text;
}

bool takes_object(const Key& key) {
  return key.form == Form::object || key.form == Form::value_or_object || key.form == Form::values_or_object;
}
bool takes_list(const Key& key) {
  return key.form == Form::values || key.form == Form::objects || key.form == Form::values_or_object;
}
bool takes_value(const Key& key) {
  return key.form == Form::value || key.form == Form::value_or_object;
}

// Sentences --------------------------------------------------------------------------------------------
std::string object_text(const Key& key) {
  std::string either;
  for (const auto& set : key.needs) {
    std::string keys;
    for (const std::string& name : set) keys += (keys.empty() ? "'" : " and '") + name + "'";
    either += (either.empty() ? " with " : ", or with ") + keys;
  }
  return "an object" + either;
}

std::string value_text(const Key& key) {
  const bool is_text = key.row.words.empty() && key.row.type.type == ALABASTER_STRING;
  const bool may_be_empty = !key.kind.empty() || key.row.fallback.text_or("none").empty();
  return host::MustBe(key.row) + (is_text && !may_be_empty ? " that is not empty" : "") +
         (key.beginning.empty() ? "" : ", or a text that begins with '" + key.beginning + "'");
}

std::string list_text(const Key& key) {
  std::string count;
  if (key.least > 0) count = (key.least == key.most ? "" : "at least ") + std::to_string(key.least) + " ";
  if (key.form == Form::objects) return "a list of " + count + "objects";
  host::FieldRow row = key.row;
  if (!row.words.empty()) return "a list of " + count + "words: " + value_text(key);
  if (row.type.type == ALABASTER_STRING) return "a list of " + count + "texts";
  row.name = host::MustBe(row);  // "a whole number, at least 0"
  const size_t number = row.name.find("number");
  return "a list of " + count + row.name.substr(2, number - 2) + "numbers" + row.name.substr(number + 6);
}

std::string must_be(const Key& key) {
  std::string text;
  if (takes_list(key)) text = list_text(key);
  if (takes_value(key)) text = value_text(key);
  if (takes_object(key)) text += (text.empty() ? "" : ", or ") + object_text(key);
  return text;
}

/// `text` with a full stop, unless it ends as a sentence does.
std::string sentence(const std::string& text) {
  return text.ends_with('.') || text.ends_with('?') ? text : text + ".";
}

/// Of a value that is no field: the sentence ends with its meaning.
std::string fault_text(const std::string& subject, const std::string& must, const json& value, const Key& key) {
  const std::string near = value.is_string() ? support::DidYouMean(value.get<std::string>(), key.row.words) : "";
  return sentence(subject + " must be " + must + ", and is " +
                  shortened(value.dump(-1, ' ', false, json::error_handler_t::replace)) + near) +
         (key.kind.empty() ? " " + key.row.text : "");
}

/// What is missing in a text in the place of a length.
std::string unit_hint(const json& value, const Key& key) {
  const auto is_text = [](const json& one) { return one.is_string(); };
  const bool any = value.is_array() ? std::any_of(value.begin(), value.end(), is_text) : is_text(value);
  return any && key.row.unit == "scene unit" ? " A length may have a unit, " + length_units() + ": 3.7mm." : "";
}

std::string name_text(const Key& key) {
  return "'" + key.row.name + "'";
}
std::string entry_text(const Key& key) {
  return "An entry of '" + key.row.name + "'";
}

/// True if a value of the description's own fits its row.
bool fits(const json& value, const Key& key) {
  const host::FieldRow& row = key.row;
  if (!row.words.empty() || row.type.type == ALABASTER_STRING) {
    if (!value.is_string()) return false;
    const auto& text = value.get_ref<const std::string&>();
    if (!key.beginning.empty() && text.size() > key.beginning.size() && text.starts_with(key.beginning)) return true;
    if (row.words.empty()) return !text.empty() || row.fallback.text_or("none").empty();
    return std::find(row.words.begin(), row.words.end(), text) != row.words.end();
  }
  const bool is_number = row.type.type == ALABASTER_INT ? value.is_number_integer() : value.is_number();
  return is_number && value.get<double>() >= row.low && value.get<double>() <= row.high;
}

/// The member, or entry of a member, of which `name` is a key: "set" for baseColor of an edit of materials,
/// "materials/set" from the description on. Empty: there is none within that many levels.
std::string home_of(const std::string& name, const Keys& keys, int levels) {
  std::string found;
  for (const Key& key : keys)
    if (found.empty() && find_key(key.keys, name)) found = key.row.name;
  for (size_t i = 0; i < keys.size() && found.empty() && levels > 1; ++i)
    if (const std::string home = home_of(name, keys[i].keys, levels - 1); !home.empty())
      found = keys[i].row.name + "/" + home;
  return found;
}

class Checker {
 public:
  Checker(const JsonDocument& document, const DiagnosticSink& sink) : document_(document), sink_(sink) {}

  bool run() {
    find_unknown_keys(document_.value, description_key(), "");
    if (faults_ == 0) check(document_.value, description_key(), "");
    if (faults_ > kMostMessages && sink_)
      sink_({Severity::error, "description.more", document_.origin,
             "There are " + std::to_string(faults_ - kMostMessages) + " more faults like these."});
    return faults_ == 0;
  }

 private:
  void fail(const char* code, const std::string& pointer, const std::string& text) {
    if (++faults_ <= kMostMessages && sink_) sink_({Severity::error, code, document_.place(pointer), text});
  }

  void find_unknown_keys(const json& value, const Key& key, const std::string& pointer, bool is_entry = false) {
    if (value.is_array() && key.form == Form::objects && !is_entry)
      for (size_t i = 0; i < value.size(); ++i)
        find_unknown_keys(value[i], key, pointer_append(pointer, std::to_string(i)), true);
    if (!value.is_object() || !(is_entry || takes_object(key)) || without_unit(value, key.row, 1)) return;
    for (const auto& [name, child] : value.items()) {
      const std::string place = pointer_append(pointer, name);
      if (const Key* of_child = find_key(key.keys, name)) {
        find_unknown_keys(child, *of_child, place);
        continue;
      }
      const std::string retired = pointer == "/settings" ? support::RetiredSetting(name, "") : std::string();
      fail("description.key.unknown", place,
           retired.empty() ? "Unknown key '" + shortened(name) + "'." + right_key(name, key.keys) : retired);
    }
  }

  static std::string right_key(const std::string& name, const Keys& keys) {
    const std::string near = support::Suggestion(name, names_of(keys));
    std::string home = near.empty() ? home_of(name, keys, 1) : "";
    if (near.empty() && home.empty()) home = home_of(name, description_key().keys, 2);
    return home.empty() ? near : " '" + home + "' has a key of this name.";
  }

  /// Reports the innermost faults of the value, or the first one of each list that has too many or too few entries.
  void check(const json& given, const Key& key, const std::string& pointer) {
    // The scene's unit is not known yet. Bounds of lengths are 0, or none.
    const std::optional<json> number = without_unit(given, key.row, 1);
    const json& value = number ? *number : given;
    if (value.is_object() && takes_object(key)) return check_object(value, key, pointer, name_text(key));
    if (value.is_array() && takes_list(key)) return check_list(value, key, pointer);
    if (takes_value(key)) return check_value(value, key, pointer);
    fail("description.value", pointer,
         fault_text(pointer.empty() ? "A render description" : name_text(key), must_be(key), value, key) +
             unit_hint(value, key));
  }

  /// `subject`: the object, or an entry of a list.
  void check_object(const json& value, const Key& key, const std::string& pointer, const std::string& subject) {
    const auto is_there = [&](const std::string& name) { return value.contains(name); };
    const auto is_whole = [&](const auto& set) { return std::all_of(set.begin(), set.end(), is_there); };
    if (key.needs.size() > 1 && std::none_of(key.needs.begin(), key.needs.end(), is_whole))
      return fail("description.value", pointer, fault_text(subject, object_text(key), value, key));
    if (key.needs.size() == 1)
      for (const std::string& name : key.needs[0])
        if (!is_there(name))
          fail("description.key.missing", pointer, "'" + name + "' is missing. " + find_key(key.keys, name)->row.text);
    for (const auto& [name, child] : value.items())
      check(child, *find_key(key.keys, name), pointer_append(pointer, name));
  }

  void check_list(const json& value, const Key& key, const std::string& pointer) {
    if (value.size() < key.least || value.size() > key.most)
      return fail("description.value", pointer, fault_text(name_text(key), must_be(key), value, key));
    for (size_t i = 0; i < value.size(); ++i) {
      const std::string place = pointer_append(pointer, std::to_string(i));
      if (key.form == Form::objects && value[i].is_object())
        check_object(value[i], key, place, entry_text(key));
      else if (key.form == Form::objects)
        fail("description.value", place, fault_text(entry_text(key), object_text(key), value[i], key));
      else if (!fits(value[i], key))
        fail("description.value", place,
             fault_text(entry_text(key), value_text(key), value[i], key) + unit_hint(value[i], key));
    }
  }

  void check_value(const json& value, const Key& key, const std::string& pointer) {
    const Value given = support::value_of(value);
    std::string fault;
    // No field takes what has no value: a null, objects, and lists of several types.
    if (key.kind.empty() ? !fits(value, key) : given.empty())
      fault = fault_text(name_text(key), must_be(key), value, key);
    else if (!key.kind.empty())
      fault = host::CheckField(key.kind, key.row.name, given);
    if (!fault.empty()) fail("description.value", pointer, sentence(fault) + unit_hint(value, key));
  }

  const JsonDocument& document_;
  const DiagnosticSink& sink_;
  size_t faults_ = 0;
};

}  // namespace

bool check_description(const JsonDocument& document, const DiagnosticSink& sink) {
  return Checker(document, sink).run();
}

}  // namespace alabaster::hd::description

// Checks a document against its schema (gltf_schema.cpp).
#include <algorithm>
#include <cmath>
#include <set>

#include "delegate/gltf/gltf_schema.h"

namespace alabaster::hd::gltf {
namespace {

class StructureCheck {
 public:
  StructureCheck(Json& root, Report& report) : root_(root), report_(report) {}

  void run() {
    check_declarations("extensionsUsed", &declared_);
    std::set<std::string> required;
    check_declarations("extensionsRequired", &required);
    check_object(root_, "", document_schema());
    for (const std::string& name : required) {
      if (!declared_.contains(name))
        report_.warning("extension.undeclared", "extensionsRequired", name + " is missing from extensionsUsed; add it");
      if (!reads_extension(name))
        report_.error("extension.required", "extensionsRequired", name + " is not supported; re-export without it");
    }
    for (const std::string& name : used_)
      if (!declared_.contains(name))
        report_.warning("extension.undeclared", "extensionsUsed", name + " is used but not listed; add it");
  }

 private:
  void error(const std::string& element, const std::string& text) {
    report_.error("structure", element, text + "; export the file again");
  }

  void check_declarations(const char* name, std::set<std::string>* names) {
    const Json& list = at(root_, name);
    if (!list.is_array() && root_.contains(name)) return error(name, "must be an array of extension names");
    for (const Json& entry : list) {
      if (!entry.is_string()) return error(name, "must be an array of extension names");
      if (!names->insert(entry.get<std::string>()).second)
        report_.warning("structure.duplicate", name, entry.get<std::string>() + " is listed twice; remove one");
    }
  }

  void check_object(Json& value, const std::string& element, const Schema& schema) {
    if (!value.is_object()) return error(element, "must be an object");
    leave_out_nulls(value, element);
    for (const Property& property : schema.properties) {
      const auto found = value.find(property.name);
      const std::string name = element_name(element, property.name);
      if (found != value.end()) {
        check_value(*found, name, property);
      } else if (property.required) {
        error(name, "is required and missing");
      }
    }
    const auto extensions = value.find("extensions");
    if (extensions != value.end()) check_extensions(*extensions, element_name(element, "extensions"), schema);
  }

  // JavaScript's exporters write null for an infinite number and for a value that is not set.
  void leave_out_nulls(Json& value, const std::string& element) {
    for (auto member = value.begin(); member != value.end();) {
      if (!member->is_null() || member.key() == "extras") {
        ++member;
        continue;
      }
      report_.warning("structure.null", element_name(element, member.key()),
                      "is null and counts as absent; leave it out");
      member = value.erase(member);
    }
  }

  void check_extensions(Json& extensions, const std::string& element, const Schema& schema) {
    if (!extensions.is_object()) return error(element, "must be an object");
    leave_out_nulls(extensions, element);
    for (auto& [name, value] : extensions.items()) {
      used_.insert(name);
      const Property* property = nullptr;
      for (const Property& extension : schema.extensions)
        if (name == extension.name) property = &extension;
      const std::string place = element_name(element, name);
      if (!value.is_object()) {
        error(place, "must be an object");
      } else if (property) {
        check_object(value, place, *property->schema);
      } else if (knows_extension(name)) {
        report_.warning("extension.misplaced", place, "the extension does not belong here and is ignored; move it");
      }
    }
  }

  void check_value(Json& value, const std::string& element, const Property& property) {
    switch (property.kind) {
      case Kind::boolean:
        if (!value.is_boolean()) error(element, "must be true or false");
        break;
      case Kind::integer:
        check_number(value, element, property, true);
        break;
      case Kind::number:
        check_number(value, element, property, false);
        break;
      case Kind::text:
        check_text(value, element, property);
        break;
      case Kind::object:
        check_object(value, element, *property.schema);
        break;
      case Kind::reference:
        check_reference(value, element, property.target);
        break;
      case Kind::reference_map:
        check_reference_maps(value, element, property);
        break;
      case Kind::objects:
      case Kind::numbers:
      case Kind::references:
        check_array(value, element, property);
        break;
    }
  }

  void check_number(Json& value, const std::string& element, const Property& property, bool integral) {
    if (!value.is_number()) return error(element, integral ? "must be an integer" : "must be a number");
    const double number = value.get<double>();
    if (integral && value.is_number_float()) {
      if (number != std::floor(number) || std::abs(number) > 9007199254740992.0)
        return error(element, "must be an integer");
      value = int64_t(number);
    }
    if (!integral) value = number;  // tinygltf keeps the integers of extensions in 32 bits
    if (number >= property.minimum && number <= property.maximum) return;
    const std::string text = value.dump() + " is out of range";
    if (!property.harmless) return report_.error("value.range", element, text + "; correct the value");
    report_.warning("value.range", element, text + "; the nearest legal value is used");
    value = std::clamp(number, property.minimum, property.maximum);
  }

  void check_text(const Json& value, const std::string& element, const Property& property) {
    if (!value.is_string()) return error(element, "must be a string");
    const std::string text = value.get<std::string>();
    if (property.target &&
        std::string_view(property.target).find(std::string("|").append(text).append("|")) == std::string_view::npos)
      error(element, std::string("'").append(text, 0, 60).append("' is not one of ").append(property.target));
  }

  void check_array(Json& value, const std::string& element, const Property& property) {
    if (!value.is_array()) return error(element, "must be an array");
    // An empty list is harmless, but a matrix or colour without numbers is an error.
    if (value.empty() && property.min_items <= 1)
      return report_.warning("structure.empty", element, "is empty; leave it out");
    if (value.size() < property.min_items || value.size() > property.max_items)
      return error(element,
                   "has " + std::to_string(value.size()) + " values, not " +
                       std::to_string(value.size() < property.min_items ? property.min_items : property.max_items));
    std::set<Json> seen;
    for (size_t i = 0; i < value.size(); ++i) {
      const std::string place = element_name(element, i);
      if (property.kind == Kind::objects) check_object(value[i], place, *property.schema);
      if (property.kind == Kind::numbers) check_number(value[i], place, property, false);
      if (property.kind == Kind::references && check_reference(value[i], place, property.target) &&
          !seen.insert(value[i]).second)
        report_.warning("structure.duplicate", place, "is listed twice; remove one");
    }
  }

  // {"POSITION": 0, ...}; with a schema set, an array of such maps (morph targets).
  void check_reference_maps(Json& value, const std::string& element, const Property& property) {
    if (property.schema) {
      if (!value.is_array()) return error(element, "must be an array");
      Property one = property;
      one.schema = nullptr;
      for (size_t i = 0; i < value.size(); ++i) check_reference_maps(value[i], element_name(element, i), one);
      return;
    }
    if (!value.is_object()) return error(element, "must be an object");
    if (value.empty()) report_.warning("structure.empty", element, "is empty; nothing is drawn");
    for (auto& [name, accessor] : value.items())
      check_reference(accessor, element_name(element, name), property.target);
  }

  bool check_reference(Json& value, const std::string& element, const std::string& target) {
    if (value.is_number_float() && value.get<double>() == std::floor(value.get<double>()) &&
        std::abs(value.get<double>()) < 1e9)
      value = int64_t(value.get<double>());
    if (!value.is_number_integer()) {
      error(element, "must be an index into " + target);
      return false;
    }
    const size_t size = array_at(target).size();
    if (value.is_number_unsigned() ? value.get<uint64_t>() < size
                                   : value.get<int64_t>() >= 0 && uint64_t(value.get<int64_t>()) < size)
      return true;
    report_.error("reference", element,
                  value.dump() + " is out of range: " + target + " has " + std::to_string(size) +
                      " elements; export the file again");
    return false;
  }

  // `place`: "extensions.KHR_lights_punctual.lights". Null without an array there.
  const Json& array_at(std::string_view place) const {
    const Json* found = &root_;
    for (size_t begin = 0, end = 0; end != std::string_view::npos; begin = end + 1) {
      end = place.find('.', begin);
      found = &at(*found, place.substr(begin, end - begin));
    }
    static const Json kNone;
    return found->is_array() ? *found : kNone;
  }

  Json& root_;
  Report& report_;
  std::set<std::string> declared_, used_;
};

}  // namespace

void check_structure(Json& root, Report& report) {
  StructureCheck(root, report).run();
}

}  // namespace alabaster::hd::gltf

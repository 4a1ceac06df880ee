#include "delegate/description/layers.h"

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <sstream>

#include "delegate/description/document_keys.h"
#include "delegate/description/places.h"
#include "delegate/description/quality_presets.h"
#include "delegate/support/extension.h"
#include "delegate/support/json_bounds.h"
#include "delegate/support/json_values.h"
#include "delegate/support/nearest_name.h"

namespace alabaster::hd::description {
namespace {

using nlohmann::json;

// The limit is about that of a description's file. Readers of values take stack for each level.
bool is_too_deep(const std::string& text) {
  return support::bounds_of_json(text, 60).too_deep_at != std::string::npos;
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

std::optional<double> to_number(const std::string& text) {
  if (is_too_deep(text)) return std::nullopt;
  const json value = json_or_text(text);
  return value.is_number() ? std::optional(value.get<double>()) : std::nullopt;
}

bool is_utf8(const std::string& text) {
  try {
    json(text).dump();
    return true;
  } catch (const json::type_error&) {
    return false;
  }
}

json dome_light(const std::string& dome) {
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
  return light;
}

// Lists of a description whose entries change the prims of a name.
constexpr const char* kLists[] = {"materials", "meshes", "lights"};
bool is_list(const std::string& part) {
  return std::find(std::begin(kLists), std::end(kLists), part) != std::end(kLists);
}
/// Sets a key of the camera or the settings.
void set_key(const std::string& part, const std::string& key, json value, const std::string& origin,
             JsonDocument* document) {
  json& keys = *document->value.emplace(part, json::object()).first;
  if (part == "camera" && std::count(std::begin(kPlacements), std::end(kPlacements), key) > 0)
    for (const char* other : kPlacements) keys.erase(other);
  document->set(pointer_append("/" + part, key), std::move(value), origin);
}
/// Adds an entry to a list.
void add_entry(const std::string& list, json entry, const std::string& origin, JsonDocument* document) {
  const auto found = document->value.find(list);
  const size_t size = found == document->value.end() ? 0 : found->size();
  document->set("/" + list + "/" + std::to_string(size), std::move(entry), origin);
}

/// Reads options as a description.
class OptionReader {
 public:
  OptionReader(const LoadOptions& options, const DiagnosticSink& sink, JsonDocument* given)
      : options_(options), sink_(sink), given_(given) {}

  bool read() {
    for (const auto& [name, number] : {std::pair{"time", options_.time.value_or(0)},
                                       {"shutter", options_.shutter ? options_.shutter->open : 0},
                                       {"shutter", options_.shutter ? options_.shutter->close : 0}})
      if (!std::isfinite(number)) return fail("option", option(name), "It is not a finite number.");
    if (!options_.camera.empty()) set("camera", "use", options_.camera, option("camera", options_.camera));
    if (const auto& shutter = options_.shutter) {
      set("camera", "shutterOpen", shutter->open, option("shutter"));
      set("camera", "shutterClose", shutter->close, option("shutter"));
    }
    for (const Override& one : options_.overrides)
      if (const std::string fault = read_override(one); !fault.empty()) return fail("override", one.origin, fault);
    if (const auto& size = options_.size) set("settings", "resolution", {size->x, size->y}, option("size"));
    if (const auto& c = options_.crop) set("settings", "crop", {c->minX, c->minY, c->maxX, c->maxY}, option("crop"));
    const std::string dome = option("dome", options_.dome);
    if (!is_utf8(options_.dome)) return fail("dome", dome, "It is not UTF-8, as names of files in a scene are.");
    if (!options_.dome.empty()) add_entry("lights", dome_light(options_.dome), dome, given_);
    return true;
  }

 private:
  std::string option(const std::string& name, const std::string& value = {}) const {
    return option_text(options_, name, value);
  }
  bool fail(const char* code, const std::string& where, const std::string& text) const {
    if (sink_) sink_({Severity::error, code, where, text});
    return false;
  }
  void set(const char* part, const std::string& key, json value, const std::string& origin) {
    set_key(part, key, std::move(value), origin, given_);
  }

  /// The fault, or "".
  std::string read_override(const Override& one) {
    if (one.value.empty()) return "'" + one.place + "' is not an assignment: write key=value.";
    const auto* text = one.value.get<std::string>();
    if (!is_utf8(one.place) || (text && !is_utf8(*text))) return "It is not UTF-8, as names and values of a scene are.";
    if (text && is_too_deep(*text)) return "The value is nested too deeply: no setting has more than a few levels.";
    return read_place(one.place, text ? json_or_text(*text) : support::json_of(one.value), one.origin);
  }

  std::string read_place(const std::string& place, json value, const std::string& origin) {
    const size_t end = std::min(place.find_first_of("./"), place.size()), dot = place.rfind('.');
    const std::string kind = place.substr(0, end);
    const bool is_of_list = is_list(kind);
    if (!is_of_list && kind != "camera" && end == place.size()) {
      add_setting(place, std::move(value), origin);
      return {};
    }
    if (!place.substr(end).starts_with(is_of_list ? "/" : ".") || !(is_of_list || kind == "camera"))
      return end < place.size() ? unknown_place(place) : no_parameter(place);
    if (dot == std::string::npos || dot + 1 == place.size() || (is_of_list && dot < end + 2))
      return no_parameter(place);
    if (!is_of_list) {
      set("camera", place.substr(end + 1), std::move(value), origin);
      return {};
    }
    json entry{{"match", place.substr(end + 1, dot - end - 1)}};
    (kind == "materials" ? entry["set"] : entry)[place.substr(dot + 1)] = std::move(value);
    add_entry(kind, std::move(entry), origin, given_);
    return {};
  }

  // A preset is written out where it stands.
  void add_setting(const std::string& name, json value, const std::string& origin) {
    if (name == "quality" && value.is_string())
      if (const QualityPreset* preset = FindQualityPreset(value.get<std::string>()))
        for (const auto& [key, own] : preset->settings) set("settings", key, support::json_of(own), origin);
    set("settings", name, std::move(value), origin);
  }

  // "--set camera=1" and the like. A place begins with the kind.
  static std::string no_parameter(const std::string& place) {
    const std::string kind = place.substr(0, place.find_first_of("./"));
    return "'" + place + "' does not name a parameter: write " + kind + (kind == "camera" ? "" : "/NAME") +
           ".parameter=value.";
  }

  static std::string unknown_place(const std::string& place) {
    const size_t end = place.find_first_of("./"), last = place.find_last_of("./");
    std::vector<std::string> kinds{"camera"};
    kinds.insert(kinds.end(), std::begin(kLists), std::end(kLists));
    const std::string kind = support::NearestName(place.substr(0, end), kinds), parameter = place.substr(last + 1);
    const std::vector<std::string> settings = names_of(find_key(description_key().keys, "settings")->keys);
    std::string nearest = support::NearestName(parameter, settings);
    if (place.find('/') != std::string::npos && nearest != parameter) nearest.clear();
    if (kind == "camera")
      nearest = "camera." + parameter;
    else if (!kind.empty())
      nearest = kind + "/" + (last > end + 1 ? place.substr(end + 1, last - end - 1) : "NAME") + "." + parameter;
    return "'" + place +
           "' cannot be set: write SETTING=value, camera.PARAMETER=value, or materials/NAME.PARAMETER=value, and the "
           "same for meshes and lights." +
           (nearest.empty() ? "" : " Did you mean '" + nearest + "'?");
  }

  const LoadOptions& options_;
  const DiagnosticSink& sink_;
  JsonDocument* const given_;
};

/// Calls visit(pointer, &name) for each name of a file to read. The names of products are those of files to write.
void for_each_input_name(const std::string& pointer, json* value,
                         const std::function<void(const std::string&, json*)>& visit) {
  for (auto& [key, child] : value->items()) {
    const bool named =
        value->is_object() && (key == "file" || key == "texture:file" || key == "shaping:ies:file" || key == "ocio");
    if (named && child.is_string() && !child.get<std::string>().empty())
      visit(pointer_append(pointer, key), &child);
    else if (child.is_structured() && key != "products")
      for_each_input_name(pointer_append(pointer, key), &child, visit);
  }
}

// Settings that the preset sets need not be written beside it.
void contract_preset(json* description) {
  const auto settings = description->find("settings");
  if (settings == description->end()) return;
  if (const QualityPreset* preset = FindQualityPreset(settings->value("quality", "")))
    for (const auto& [key, own] : preset->settings)
      if (settings->value(key, json()) == support::json_of(own)) settings->erase(key);
}

}  // namespace

Override::Override(const std::string& assignment) : origin(assignment) {
  const size_t equals = assignment.find('=');
  place = assignment.substr(0, equals);
  if (equals != std::string::npos && equals > 0)
    value = assignment.substr(equals + 1);
  else
    place = assignment;
}

void expand_preset(json* description) {
  const auto settings = description->find("settings");
  if (settings == description->end()) return;
  if (const QualityPreset* preset = FindQualityPreset(settings->value("quality", "")))
    for (const auto& [key, own] : preset->settings) settings->emplace(key, support::json_of(own));
}

std::string option_text(const LoadOptions& options, const std::string& name, const std::string& value) {
  const std::string text = (options.are_flags ? "--" : "") + name;
  return value.empty() ? text : text + (options.are_flags ? " " : "=") + value;
}

bool read_options(const LoadOptions& options, const DiagnosticSink& sink, JsonDocument* given) {
  given->value = json::object();
  return OptionReader(options, sink, given).read();
}

bool lay_over(const JsonDocument& given, const LoadOptions& options, const DiagnosticSink& sink,
              JsonDocument* document) {
  json& all = document->value;
  // The file's camera is called "camera", if it makes one. Its changes are meant for that one, and not for another.
  const auto own = all.find("camera");
  const bool keeps_own = options.camera == "camera" && own != all.end() && own->size() > size_t(own->contains("use"));
  if (!options.camera.empty() && !keeps_own)
    document->set("/camera", json::object(), option_text(options, "camera", options.camera));
  for (const auto& [part, content] : given.value.items())
    for (const auto& [key, value] : content.items()) {
      const std::string& origin = given.options.at(pointer_append("/" + part, key));
      if (content.is_array())
        add_entry(part, value, origin, document);
      else if (!(keeps_own && part == "camera" && key == "use" && value == options.camera))
        set_key(part, key, value, origin, document);
    }

  const char* const list = all.contains("gltf") ? "gltf" : "models";
  const auto models = all.find(list);
  for (const auto& [key, choice] :
       {std::pair{"scene", options.scene}, {"animation", options.animation}, {"variant", options.variant}}) {
    if (choice.empty() || models == all.end()) continue;
    const std::string pointer = std::string("/") + list;
    if (models->size() > 1 && sink)
      sink({Severity::error, "gltf.choice", document->place(pointer),
            "There are several models: write scene, animation or variant beside each one's file."});
    if (models->size() > 1) return false;
    document->set(pointer + "/0/" + key, choice, option_text(options, key, choice));
  }
  return true;
}

std::string WithOptions(const std::string& text, const LoadOptions& options,
                        const std::function<std::string(const std::string&)>& place) {
  try {
    JsonDocument document;
    document.value = json::parse(text);
    if (!document.value.is_object()) return {};
    LoadOptions no_dome = options;
    no_dome.dome.clear();
    expand_preset(&document.value);
    if (JsonDocument given; read_options(no_dome, {}, &given)) lay_over(given, no_dome, {}, &document);
    for (const char* list : {"gltf", "models"})
      if (const auto models = document.value.find(list); options.time && models != document.value.end())
        for (json& model : *models)
          if (support::lower_extension(model["file"]) != ".alab")
            model["time"] = model.value("time", 0.0) + *options.time;
    contract_preset(&document.value);
    for_each_input_name("", &document.value, [&](const std::string& pointer, json* name) {
      const auto given = name->get<std::string>();
      *name = place(document.is_of_option(pointer) ? std::filesystem::absolute(given).string() : given);
    });
    return document.value.dump();
  } catch (const std::exception&) {
    return {};
  }
}

}  // namespace alabaster::hd::description

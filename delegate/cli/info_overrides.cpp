#include "delegate/cli/info_overrides.h"

#include <nlohmann/json.hpp>
#include <set>

#include "delegate/cli/shell_word.h"
#include "delegate/description/render_description.h"

namespace alabaster::cli {
namespace {

constexpr size_t kWidth = 100;

struct Kind {
  const char *list, *example;    // a list of a render description, and a change of an entry
  const char *schema, *pointer;  // the properties that an entry has
};
constexpr Kind kKinds[] = {{"materials", "roughness=0.3", "disney_material", "/properties"},
                           {"meshes", "visible=false", "render_description", "/properties/meshes/items/properties"},
                           {"lights", "intensity=2", "render_description", "/properties/lights/items/properties"},
                           {"camera", "fStop=2.8", "render_description", "/properties/camera/properties"}};

// A glob that matches the name itself.
std::string escaped(const std::string& name) {
  std::string out;
  for (const char c : name) {
    if (c == '*' || c == '?' || c == '[' || c == '\\') out += '\\';
    out += c;
  }
  return out;
}

/// The names with commas, in lines of some width that are indented.
std::string wrapped(const std::string& begin, const std::vector<std::string>& names) {
  std::string text = begin, line;
  for (size_t i = 0; i < names.size(); ++i) {
    const std::string word = names[i] + (i + 1 < names.size() ? "," : "");
    if (begin.size() + line.size() + 1 + word.size() > kWidth)
      text += line + "\n" + std::string(begin.size(), ' '), line.clear();
    line += " " + word;
  }
  return text + line + "\n";
}

std::vector<std::string> properties_of(const Kind& kind) {
  const std::set<std::string> of_new_entries{"match", "name", "type"};
  const auto schema = nlohmann::ordered_json::parse(hd::description::SchemaText(kind.schema));
  std::vector<std::string> names;
  for (const auto& [name, value] : schema.at(nlohmann::ordered_json::json_pointer(kind.pointer)).items())
    if (!of_new_entries.contains(name)) names.push_back(name);
  return names;
}

}  // namespace

std::string override_lines(const std::string& list, const std::string& name) {
  for (const Kind& kind : kKinds)
    if (list == kind.list) {
      const std::string place = name.empty() ? list : list + "/" + escaped(name);
      return "  to change: --set " + shell_word(place + "." + kind.example) + "\n" +
             wrapped("  can be set:", properties_of(kind));
    }
  return {};
}

}  // namespace alabaster::cli

#include <algorithm>

#include "delegate/description/schema_check.h"
#include "delegate/description/written_parts.h"

namespace alabaster::hd::description {

using nlohmann::json;

json written_light(const Path& id, const host::LightDescription& light, WrittenFiles* files) {
  static const json properties = expanded_schema("lights")["properties"];
  json made = {{"type", light.type.str()}, {"transform", to_json(light.transform)}};
  for (const auto& [name, property] : properties.items()) {
    const json types = property.value("appliesTo", json{light.type.str()});
    if (std::find(types.begin(), types.end(), light.type.str()) == types.end()) continue;
    const auto held = light.parameters.find(name);
    if (held == light.parameters.end() || held->second.empty()) continue;
    if (name.ends_with(":file"))
      made[name] = files->name_of(id, held->second);
    else
      made[name] = to_json(held->second, property);
  }
  // The reader makes a light that is treated as a point one without a radius.
  if (made.value("treatAsPoint", false) && !made.contains("radius")) made["radius"] = properties["radius"]["default"];
  return made;
}

}  // namespace alabaster::hd::description

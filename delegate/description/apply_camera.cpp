#include <cmath>

#include "delegate/description/load_state.h"
#include "delegate/description/places.h"
#include "delegate/support/json_values.h"

namespace alabaster::hd::description {
namespace {

/// The only camera of that name.
Path the_camera(LoadState& load, const std::string& name) {
  const std::vector<Path> found = find_prims(load, "camera", name, "/camera/use");
  if (found.size() == 1) return found[0];
  std::string paths;
  for (const Path& path : found) paths += (paths.empty() ? "'" : ", '") + path.str() + "'";
  load.fail("/camera/use",
            "'" + name + "' names " + std::to_string(found.size()) + " cameras: " + paths + "; give the path of one.");
}

}  // namespace

void apply_camera(LoadState& load) {
  const nlohmann::json* entry = load.part("camera");
  if (!entry) return;
  if (entry->contains("use")) load.camera.use = the_camera(load, (*entry)["use"]).str();
  load.camera.placement = placement_of(load, "/camera", *entry);
  if (const auto look = entry->find("lookAt"); look != entry->end() && look->contains("target")) {
    const auto target = (*look)["target"].get<std::array<double, 3>>();
    load.result->look_at = Vec3d(target[0], target[1], target[2]);
  }
  for (const host::FieldRow& row : host::ParameterRows("camera")) {
    const auto given = entry->find(row.name);
    if (given == entry->end()) continue;
    Value& value = load.camera.parameters[row.name] = field_value(*given);
    if (given->is_string()) value = Token(given->get<std::string>());
    if (row.in_millimetres) value = given->get<float>() * load.result->info.units_per_millimetre();
  }
}

double Millimetres(float length, const host::SceneInfo& scene) {
  const float units = scene.units_per_millimetre();
  float guess = length / units;
  for (int i = 0; i < 4 && guess * units != length; ++i)
    guess = std::nextafter(guess, guess * units < length ? INFINITY : -INFINITY);
  return support::shortest_decimal(guess);
}

}  // namespace alabaster::hd::description

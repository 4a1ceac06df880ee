#include "delegate/description/apply_motion.h"
#include "delegate/description/load_state.h"
#include "delegate/description/placement.h"
#include "delegate/support/json_values.h"

namespace alabaster::hd::description {
namespace {

using nlohmann::json;
constexpr float kMetresPerMillimetre = 0.001f;

// The camera is placed by one of transform, lookAt and motion.
void place_camera(LoadState& load, const json& entry) {
  CameraPlan& plan = load.camera;
  const auto transform = entry.find("transform"), look = entry.find("lookAt"), motion = entry.find("motion");
  const auto end = entry.end();
  if (transform != end && look != end) load.fail("/camera", "Give either a transform or lookAt, not both.");
  if (motion != end) {
    if (transform != end || look != end) load.fail("/camera", "Give either a motion or a single placement, not both.");
    plan.motion = to_motion(load, "/camera/motion", *motion);
    plan.transform = transform_at(plan.motion, 0);
  } else if (transform != end) {
    plan.transform = to_transform(*transform);
    if (!plan.transform) load.fail("/camera/transform", "The transform cannot be inverted or is not affine.");
  } else if (look != end) {
    const Vec3d up = look->contains("up") ? to_vec3d((*look)["up"]) : up_vector(load.result->info.up);
    const Vec3d eye = to_vec3d((*look)["eye"]), target = to_vec3d((*look)["target"]);
    plan.transform = look_at(eye, target, up, !look->contains("up"));
    plan.target_distance = (target - eye).length();
    if (!plan.transform)
      load.fail("/camera/lookAt", "The camera has no direction: eye and target coincide, or up lies along the view.");
  }
}

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
  const json* entry = load.part("camera");
  if (!entry) return;
  if (entry->contains("use")) load.camera.use = the_camera(load, (*entry)["use"]).str();
  place_camera(load, *entry);
  for (const host::FieldRow& row : host::ParameterRows("camera")) {
    const auto given = entry->find(row.name);
    if (given == entry->end()) continue;
    Value& value = load.camera.parameters[row.name] = support::value_of(*given);
    if (given->is_string()) value = Token(given->get<std::string>());
    if (given->is_number()) value = given->get<float>() * (row.in_millimetres ? kMetresPerMillimetre : 1.0f);
  }
}

}  // namespace alabaster::hd::description

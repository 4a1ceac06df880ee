#include "delegate/description/apply_motion.h"
#include "delegate/description/description_reader.h"
#include "delegate/description/placement.h"
#include "delegate/description/schema_check.h"

namespace alabaster::hd::description {
namespace {

using nlohmann::json;
constexpr float kMetresPerMillimetre = 0.001f;

Array<Vec4f> to_planes(const json& planes) {
  std::vector<Vec4f> all;
  for (const json& p : planes)
    all.emplace_back(p[0].get<float>(), p[1].get<float>(), p[2].get<float>(), p[3].get<float>());
  return all;
}

}  // namespace

bool apply_camera(const Reader& reader) {
  const auto entry = reader.value().find("camera");
  if (entry == reader.value().end()) return true;
  CameraPlan& plan = reader.state().camera;
  if (entry->contains("transform") && entry->contains("lookAt"))
    return reader.fail("/camera", "Give either a transform or lookAt, not both.");
  if (entry->contains("use")) {
    plan.use = (*entry)["use"];
    plan.use_place = "/camera/use";
    const auto found = find_prims(reader, PrimKind::camera, plan.use, plan.use_place);
    if (found.empty()) return false;
    plan.use = found[0].str();
  }
  if (entry->contains("transform")) {
    plan.transform = to_transform((*entry)["transform"]);
    if (!plan.transform) return reader.fail("/camera/transform", "The transform cannot be inverted or is not affine.");
  }
  if (const auto look = entry->find("lookAt"); look != entry->end()) {
    const Vec3d up = look->contains("up") ? to_vec3d((*look)["up"]) : Vec3d(0, 1, 0);
    plan.transform = look_at(to_vec3d((*look)["eye"]), to_vec3d((*look)["target"]), up, !look->contains("up"));
    if (!plan.transform)
      return reader.fail("/camera/lookAt",
                         "The camera has no direction: eye and target coincide, or up lies along the view.");
  }
  if (const auto motion = entry->find("motion"); motion != entry->end()) {
    if (entry->contains("transform") || entry->contains("lookAt"))
      return reader.fail("/camera", "Give either a motion or a single placement, not both.");
    const auto samples = to_motion(reader, "/camera/motion", *motion);
    if (!samples) return false;
    plan.motion = *samples;
    plan.transform = transform_at(plan.motion, 0);
  } else if (entry->contains("transform") || entry->contains("lookAt")) {
    plan.motion = {};
  }
  static const json parameters = expanded_schema("camera")["properties"];
  for (const auto& [name, schema] : parameters.items()) {
    const auto given = entry->find(name);
    if (given == entry->end()) continue;
    if (name == "clipPlanes") {
      plan.parameters[name] = to_planes(*given);
    } else if (given->is_number()) {
      const bool millimetres = schema.value("unitInDescription", "") == "mm";
      plan.parameters[name] = given->get<float>() * (millimetres ? kMetresPerMillimetre : 1.0f);
    } else {
      plan.parameters[name] = given->is_string() ? Value(Token(given->get<std::string>())) : to_value(*given);
    }
  }
  return true;
}

}  // namespace alabaster::hd::description

#include <cmath>

#include "delegate/description/description_reader.h"
#include "delegate/description/placement.h"
#include "delegate/description/soft_dome.h"
#include "delegate/support/window_policy.h"

namespace alabaster::hd::description {
namespace {

// A description's camera starts from a 50 mm lens and full-frame film; metres.
std::map<Token, Value> default_lens() {
  return {{"focalLength", 0.050f}, {"horizontalAperture", 0.036f}, {"verticalAperture", 0.024f}};
}

double parameter(const host::CameraDescription& camera, const char* name, double fallback) {
  const auto found = camera.parameters.find(name);
  return found == camera.parameters.end() ? fallback : found->second.number_or(fallback);
}

// The picture's frustum, once the film has been fitted to the picture's shape.
Frustum visible_frustum(const host::CameraDescription& camera, const RenderSettingsDescription& settings) {
  const double focal = parameter(camera, "focalLength", 0.050);
  const double x = parameter(camera, "horizontalAperture", 0.036) / (2 * focal);
  const double y = parameter(camera, "verticalAperture", 0.024) / (2 * focal);
  const double aspect = double(settings.width) / settings.height * double(settings.pixelAspectRatio);
  const support::CameraWindow seen = support::conform_window({x, y}, aspect, settings.windowPolicy);
  return {seen.width, seen.height};
}

Path first_camera(const LoadState& state) {
  for (const gltf::GltfSummary& model : state.result->gltf)
    if (!model.cameras.empty()) return model.cameras.front();
  return {};
}

bool complete_camera(LoadState* state) {
  const CameraPlan& plan = state->camera;
  const Path base = plan.use.empty() && !plan.transform ? first_camera(*state) : Path(plan.use);
  if (!base.empty() && !plan.transform && plan.parameters.empty()) {
    state->settings.camera = base;
    return true;
  }
  host::CameraDescription camera;
  if (base.empty()) {
    camera.parameters = default_lens();
  } else {
    camera = state->scene->GetCameras().at(base);
  }
  for (const auto& [name, value] : plan.parameters) camera.parameters[name] = value;
  if (plan.transform) camera.transform = *plan.transform;
  if (base.empty() && !plan.transform) {
    const auto projection = camera.parameters.find("projection");
    if (projection != camera.parameters.end() && projection->second.text_or("") == "orthographic") {
      if (*state->sink)
        (*state->sink)({Severity::error, "description.camera", "camera",
                        "An orthographic camera cannot frame the scene by itself; add a lookAt or a transform."});
      return false;
    }
    const Framed framed = frame_points(enclosing_points(*state->scene), visible_frustum(camera, state->settings));
    camera.transform = framed.camera;
    if (!camera.parameters.count("focusDistance"))
      camera.parameters["focusDistance"] = static_cast<float>(framed.distance);
    state->result->notes.push_back("no camera: framed the scene");
  }
  const Path path = "/camera";
  state->scene->SetCamera(path, std::move(camera));
  state->settings.camera = path;
  return true;
}

bool any_emission(const host::RetainedSceneDelegate& scene) {
  for (const auto& [path, network] : scene.GetMaterials())
    for (const auto& [node_path, node] : network.nodes)
      if (const auto emission = node.parameters.find("emission"); emission != node.parameters.end())
        if (emission->second.get_or(Vec3f(0)).length() > 0) return true;
  return false;
}

void complete_lights(LoadState* state) {
  if (!state->scene->GetLights().empty() || any_emission(*state->scene)) return;
  const Matrix4d camera = state->scene->GetCameras().at(state->settings.camera).transform;
  state->scene->SetLight("/lights/default_dome", soft_dome(camera));
  state->result->notes.push_back("no light: added a soft dome");
}

// Makes one RenderSettings prim for each resolution and crop of the products.
void complete_settings(LoadState* state) {
  std::vector<std::pair<FramePlan, RenderSettingsDescription>> renders{{FramePlan(), state->settings}};
  if (!state->products.empty()) renders.clear();
  for (ProductPlan& plan : state->products) {
    auto render = renders.begin();
    while (render != renders.end() && !(render->first == plan.frame)) ++render;
    if (render == renders.end()) {
      renders.emplace_back(plan.frame, state->settings);
      render = renders.end() - 1;
      if (plan.frame.resolution) {
        render->second.width = plan.frame.resolution->x;
        render->second.height = plan.frame.resolution->y;
        render->second.crop.reset();  // the crop belongs to the other resolution
      }
      if (plan.frame.crop) render->second.crop = plan.frame.crop;
    }
    render->second.products.push_back(std::move(plan.product));
  }
  for (size_t i = 0; i < renders.size(); ++i) {
    const Path path = i == 0 ? Path("/render") : Path("/render" + std::to_string(i + 1));
    state->scene->SetRenderSettings(path, std::move(renders[i].second));
    if (i == 0) {
      state->result->settings = path;
    } else {
      state->result->further_settings.push_back(path);
    }
  }
}

}  // namespace

bool complete_scene(LoadState* state) {
  if (!complete_camera(state)) return false;
  complete_lights(state);
  complete_settings(state);
  return true;
}

}  // namespace alabaster::hd::description

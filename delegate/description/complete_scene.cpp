#include <algorithm>

#include "delegate/description/layers.h"
#include "delegate/description/load_state.h"
#include "delegate/description/placement.h"
#include "delegate/description/studio.h"
#include "delegate/support/lookup.h"
#include "delegate/support/size_text.h"
#include "delegate/support/window_policy.h"

namespace alabaster::hd::description {
namespace {

using support::number_in;

// A description's camera starts from a 50 mm lens and full-frame film.
std::map<Token, Value> default_lens(const host::SceneInfo& info) {
  const auto in_units = [&](double metres) { return static_cast<float>(metres / info.metersPerUnit); };
  return {
      {"focalLength", in_units(0.050)}, {"horizontalAperture", in_units(0.036)}, {"verticalAperture", in_units(0.024)}};
}

// The picture's frustum, once the film has been fitted to the picture's shape.
Frustum visible_frustum(const host::CameraDescription& camera, const RenderSettingsDescription& settings) {
  const double focal = number_in(camera.parameters, "focalLength", 0.050);
  const double x = number_in(camera.parameters, "horizontalAperture", 0.036) / (2 * focal);
  const double y = number_in(camera.parameters, "verticalAperture", 0.024) / (2 * focal);
  const double aspect = double(settings.width) / settings.height * double(settings.pixelAspectRatio);
  const support::CameraWindow seen = support::conform_window({x, y}, aspect, settings.windowPolicy);
  return {seen.width, seen.height};
}

// Of a complete model, only where it is the first.
Path first_camera(const LoadState& state) {
  for (const SceneFile::Model& model : state.result->models)
    if (!model.cameras.empty() && (!model.is_complete || &model == &state.result->models.front()))
      return model.cameras.front();
  return {};
}

Path base_camera(const LoadState& state) {
  const CameraPlan& plan = state.camera;
  return plan.use.empty() && !plan.placement.transform ? first_camera(state) : Path(plan.use);
}

// The camera `base`, or a new one if it is empty, with the plan's changes.
host::CameraDescription planned_camera(const LoadState& state, const Path& base) {
  const CameraPlan& plan = state.camera;
  host::CameraDescription camera;
  if (base.empty()) {
    camera.parameters = default_lens(state.result->info);
  } else {
    camera = state.scene->GetCameras().at(base);
  }
  for (const auto& [name, value] : plan.parameters) {
    camera.parameters[name] = value;
    camera.parameters.erase(Token(name.str() + ":samples"));
  }
  const Placement& placed = plan.placement;
  if (placed.transform) camera.transform = *placed.transform, camera.transformSamples = placed.motion;
  if (placed.target_distance > 0 && !plan.parameters.contains("focusDistance") &&
      number_in(camera.parameters, "focusDistance") == 0)
    camera.parameters["focusDistance"] = static_cast<float>(placed.target_distance);
  return camera;
}

void complete_camera(LoadState* state) {
  const CameraPlan& plan = state->camera;
  const Path base = base_camera(*state);
  if (!base.empty() && !plan.placement.transform && plan.parameters.empty()) {
    state->settings.camera = base;
    return;
  }
  host::CameraDescription camera = planned_camera(*state, base);
  if (number_in(camera.parameters, "shutterClose", 0) < number_in(camera.parameters, "shutterOpen", 0))
    state->fail("/camera/shutterClose",
                "The shutter closes before it opens: shutterClose must not be less than shutterOpen.");
  if (base.empty() && !plan.placement.transform) {
    if (support::text_in(camera.parameters, "projection") == "orthographic")
      state->fail("/camera/projection",
                  "An orthographic camera cannot frame the scene by itself; add a lookAt or a transform.");
    const Token& up = state->result->info.up;
    const Framed framed =
        frame_points(from_world(enclosing_points(*state->scene), up), visible_frustum(camera, state->settings));
    camera.transform = to_world(framed.camera, up);
    if (!camera.parameters.contains("focusDistance"))
      camera.parameters["focusDistance"] = static_cast<float>(framed.distance);
    state->result->notes.push_back("no camera: framed the scene");
    state->result->framed = true;
  }
  if (!(base == state->planned_camera)) state->planned_camera = free_path(state, state->planned_camera.str());
  state->scene->SetCamera(state->planned_camera, std::move(camera));
  state->settings.camera = state->planned_camera;
}

// A texture of emission is a display or a label as a rule, and an unlit surface shows its own colour: nobody means
// either to light a scene. Numbers of a mesh or its instances are lamps.
bool is_light(const MaterialNetwork& material, const MaterialNode& node) {
  if (number_in(node.parameters, "specular", 1) == 0 && number_in(node.parameters, "ior", 1.5) == 1) return false;
  if (const auto connected = node.inputConnections.find("emission"); connected != node.inputConnections.end()) {
    const auto is_primvar = [&](const MaterialConnection& one) {
      const auto upstream = material.nodes.find(one.upstreamNode);
      return upstream != material.nodes.end() && upstream->second.nodeTypeId == Token("AlabasterPrimvar");
    };
    return std::any_of(connected->second.begin(), connected->second.end(), is_primvar);
  }
  const auto emission = node.parameters.find("emission");
  return emission != node.parameters.end() && emission->second.get_or(Vec3f(0)).length() > 0;
}

bool any_emission(const host::RetainedSceneDelegate& scene) {
  const auto& all = scene.GetMaterials();
  return std::any_of(all.begin(), all.end(), [](const auto& material) { return gives_light(material.second); });
}

void add_studio(LoadState* state, const StudioPlan& plan, bool backdrop) {
  host::RetainedSceneDelegate* scene = state->scene;
  const size_t all = scene->GetLights().size();
  remove_lights(scene, false);
  const size_t domes = scene->GetLights().size();
  add_studio_lights(plan, domes == 0, scene);
  if (backdrop) add_studio_backdrop(plan, scene);
  const std::string added = backdrop ? "added a studio, lights and a backdrop" : "added the lights of a studio";
  const std::string on = option_text(state->options, "studio", "on");
  const std::string off = option_text(state->options, "studio", "off");
  state->studio_is_alone = state->studio == StudioChoice::on;
  if (state->studio_is_alone)
    return state->result->notes.push_back(on + ": " + added + (all > domes ? " in place of the scene's lights" : ""));
  const std::string others = backdrop ? off : on + ": with a backdrop; " + off;
  state->result->notes.push_back("no light: " + added + " (" + others + ": a soft dome)");
}

// Without being asked, the studio brings no backdrop before a file's own camera, since it might hide what the camera
// was placed to see; and where that camera stands among the objects, they would hide the lights, so a dome is added.
void complete_lights(LoadState* state, bool own_camera) {
  host::RetainedSceneDelegate& scene = *state->scene;
  const bool lit = !scene.GetLights().empty() || any_emission(scene), asked = state->studio == StudioChoice::on;
  state->result->has_light = lit || asked;
  if (lit && !asked) return;
  if (state->is_complete && !asked) {
    state->result->notes.push_back("no light: the scene is drawn as the archive has it (" +
                                   option_text(state->options, "studio", "on") + ": lights and a backdrop)");
    return;
  }
  const Matrix4d camera = scene.GetCameras().at(state->settings.camera).transform;
  const Token& up = state->result->info.up;
  if (state->studio != StudioChoice::off)
    if (const auto plan = plan_studio(enclosing_points(scene), camera, up);
        plan && (asked || !own_camera || !plan->inside))
      return add_studio(state, *plan, (asked || !own_camera) && !plan->below);
  if (lit) return;
  scene.SetLight("/lights/default_dome", soft_dome(camera, up));
  state->result->notes.push_back("no light: added a soft dome");
}

/// Products of one size and crop.
struct Render {
  FramePlan frame;
  RenderSettingsDescription settings;
  std::string crop_place = "/settings/crop";  // of its crop in the description
};

std::vector<Render> plan_renders(LoadState* state) {
  std::vector<Render> renders;
  if (state->products.empty()) renders.emplace_back().settings = state->settings;
  for (ProductPlan& plan : state->products) {
    if (state->options.size) plan.frame.resolution.reset();
    if (state->options.crop) plan.frame.crop = state->options.crop;
    const auto is_same = [&](const Render& render) { return render.frame == plan.frame; };
    auto render = std::find_if(renders.begin(), renders.end(), is_same);
    if (render == renders.end()) {
      render = renders.emplace(render);
      render->frame = plan.frame;
      render->settings = state->settings;
      if (const auto& size = plan.frame.resolution) {
        render->settings.width = size->x, render->settings.height = size->y;
        render->settings.crop.reset();  // the crop belongs to the other resolution
      }
      if (plan.frame.crop) render->settings.crop = plan.frame.crop;
      if (plan.frame.crop && !state->options.crop) render->crop_place = plan.place + "/crop";
    }
    render->settings.products.push_back(std::move(plan.product));
  }
  for (const auto& [frame, settings, crop_place] : renders)
    if (!settings.window().overlaps(settings.frame_window()))
      state->fail(crop_place, "The crop lies wholly outside the frame of " +
                                  support::size_option(settings.width, settings.height) + ".");
  return renders;
}

// Makes one RenderSettings prim for each resolution and crop of the products, unless the options say both.
void complete_settings(LoadState* state) {
  std::vector<Render> renders = plan_renders(state);
  for (const auto& [path, of_archive] : state->scene->GetAllRenderSettings()) {
    RenderSettingsDescription settings = of_archive;
    if (!settings.products.empty()) state->result->further_settings.push_back(path);
    if (const auto& size = state->options.size) settings.width = size->x, settings.height = size->y;
    if (state->options.crop) settings.crop = state->options.crop;
    state->scene->SetRenderSettings(path, std::move(settings));
  }
  Path path = state->settings_path;
  if (!state->archive_settings) path = free_path(state, path.str());
  size_t number = 1;
  for (size_t i = 0; i < renders.size(); ++i) {
    while (i > 0 && state->scene->GetAllRenderSettings().contains(path))
      path = Path("/render" + std::to_string(++number));
    state->scene->SetRenderSettings(path, std::move(renders[i].settings));
    if (i == 0) {
      state->result->settings = path;
    } else {
      state->result->further_settings.push_back(path);
    }
  }
}

}  // namespace

bool gives_light(const MaterialNetwork& material) {
  return std::any_of(material.nodes.begin(), material.nodes.end(),
                     [&](const auto& node) { return is_light(material, node.second); });
}

// A camera that was framed stays where it is.
void pose_camera(LoadState* state) {
  const Path base = base_camera(*state);
  if (base.empty() || !(state->settings.camera == state->planned_camera)) return;
  state->scene->SetCamera(state->planned_camera, planned_camera(*state, base));
}

void complete_scene(LoadState* state) {
  const bool own_camera = state->camera.placement.transform || !base_camera(*state).empty();
  complete_camera(state);
  complete_lights(state, own_camera);
  complete_settings(state);
}

}  // namespace alabaster::hd::description

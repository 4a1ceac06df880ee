#include "delegate/c_api/functions.h"
#include "delegate/c_api/scene_prims.h"

namespace alabaster::hd::c_api {
namespace {

using host::RetainedSceneDelegate;

/// Runs `call` on the scene and the path, under the scene's lock.
template <class Call>
AlabasterStatus on_prim(AlabasterScene* handle, const char* path, const Call& call) {
  return guarded([&] {
    const std::shared_ptr<SceneData> data = required(handle, "scene").data;
    if (required(path, "path") == '\0') throw bad_argument("the path is empty");
    const SceneLock lock(*data);
    call(data->scene, Path(path));
  });
}

/// The same with what read(path, reader) makes of `given`, whose arrays come back whatever fails.
template <class T, class Read, class Call>
AlabasterStatus on_prim_with(const T* given, AlabasterScene* handle, const char* path, const Read& read,
                             const Call& call) {
  return guarded([&] {
    ValueReader reader(given);
    const std::shared_ptr<SceneData> data = required(handle, "scene").data;
    if (required(path, "path") == '\0') throw bad_argument("the path is empty");
    const Path id(path);
    auto made = read(id, reader);
    reader.take();
    const SceneLock lock(*data);
    call(data->scene, id, std::move(made));
  });
}

/// A copy of the description, to be changed and set again; its arrays are shared.
template <class Map>
auto copy_of(const Map& map, const Path& path, const char* kind) {
  const auto found = map.find(path);
  if (found == map.end()) throw Failure(ALABASTER_NOT_FOUND, std::string("there is no ") + kind + " " + path.str());
  return found->second;
}

description::LoadOptions read_options(const AlabasterLoadOptions* given) {
  description::LoadOptions options;
  if (!given) return options;
  const auto in = sized(given, "options");
  for (const char* text : items(in.overrides, in.override_count, "overrides"))
    options.overrides.push_back(text_or(text, ""));
  options.camera = text_or(in.camera, "");
  options.dome = text_or(in.dome, "");
  options.scene = text_or(in.scene, "");
  options.animation = text_or(in.animation, "");
  options.variant = text_or(in.variant, "");
  if (in.time) options.time = *in.time;
  if (in.shutter) options.shutter = description::LoadOptions::Shutter{in.shutter[0], in.shutter[1]};
  options.keep_going = in.keep_going != 0;
  options.allow_outside = in.allow_outside != 0;
  return options;
}

/// Calls visit(path, type) for every prim.
template <class Visit>
void for_each_prim(const RetainedSceneDelegate& scene, const Visit& visit) {
  for (const auto& entry : scene.GetMeshes()) visit(entry.first, Token("mesh"));
  for (const auto& entry : scene.GetInstancers()) visit(entry.first, Token("instancer"));
  for (const auto& entry : scene.GetMaterials()) visit(entry.first, Token("material"));
  for (const auto& entry : scene.GetLights()) visit(entry.first, entry.second.type);
  for (const auto& entry : scene.GetCameras()) visit(entry.first, Token("camera"));
  for (const auto& entry : scene.GetAllRenderSettings()) visit(entry.first, Token("renderSettings"));
}

std::vector<std::pair<Path, Token>> all_prims(const RetainedSceneDelegate& scene) {
  std::vector<std::pair<Path, Token>> prims;
  for_each_prim(scene, [&](const Path& path, const Token& type) { prims.emplace_back(path, type); });
  return prims;
}

}  // namespace

AlabasterStatus scene_create(AlabasterReport report, void* user, AlabasterScene** scene) {
  return guarded([&] {
    auto& out = required(scene, "scene");
    auto data = std::make_shared<SceneData>();
    data->reports = std::make_shared<Reports>(report, user);
    out = new AlabasterScene{std::move(data)};
  });
}

void scene_destroy(AlabasterScene* scene) {
  destroy(scene);
}

AlabasterStatus scene_load(AlabasterScene* handle, const char* file, const AlabasterLoadOptions* options,
                           AlabasterLoaded* loaded) {
  return guarded([&] {
    const std::shared_ptr<SceneData> held = required(handle, "scene").data;
    SceneData& data = *held;
    const SceneLock lock(data);
    data.reports->take_error({});
    const auto read = read_options(options);
    data.loaded = description::LoadScene(&required(file, "file"), &data.scene, sink_of(data.reports), read);
    if (!data.loaded.ok) throw Failure(ALABASTER_INPUT_FAILED, data.reports->take_error("the scene cannot be loaded"));
    if (!loaded) return;
    std::string notes;
    for (const std::string& note : data.loaded.notes) notes += note + "\n";
    const auto kept = [&](const std::string& text) { return data.loaded_texts.insert(text).first->c_str(); };
    AlabasterLoaded told{};
    told.settings = kept(data.loaded.settings.str());
    told.color_config = kept(data.loaded.color_config);
    told.notes = kept(notes);
    answer(loaded, told, "loaded");
  });
}

AlabasterStatus scene_clear(AlabasterScene* handle) {
  return guarded([&] {
    const std::shared_ptr<SceneData> held = required(handle, "scene").data;
    SceneData& data = *held;
    const SceneLock lock(data);
    for (const auto& prim : all_prims(data.scene)) data.scene.Remove(prim.first);
  });
}

AlabasterStatus remove_prim(AlabasterScene* handle, const char* path) {
  return on_prim(handle, path, [](RetainedSceneDelegate& scene, const Path& id) {
    const auto prims = all_prims(scene);
    if (std::none_of(prims.begin(), prims.end(), [&](const auto& prim) { return prim.first == id; }))
      throw Failure(ALABASTER_NOT_FOUND, "there is no prim " + id.str());
    scene.Remove(id);
  });
}

AlabasterStatus set_mesh(AlabasterScene* handle, const char* path, const AlabasterMesh* mesh) {
  return on_prim_with(
      mesh, handle, path, [&](const Path&, ValueReader& reader) { return read_mesh(mesh, reader); },
      [](RetainedSceneDelegate& scene, const Path& id, auto made) { scene.SetMesh(id, std::move(made)); });
}

namespace {

/// A mesh with that primvar alone.
host::MeshDescription read_one(const AlabasterPrimvar* primvar, const char* name, ValueReader& reader) {
  host::MeshDescription one;
  read_primvar(required(primvar, name), reader, &one);
  return one;
}

}  // namespace

AlabasterStatus set_primvar(AlabasterScene* handle, const char* path, const AlabasterPrimvar* primvar) {
  const auto set = [](RetainedSceneDelegate& scene, const Path& id, host::MeshDescription one) {
    host::MeshDescription mesh = copy_of(scene.GetMeshes(), id, "mesh");
    const Token name = one.primvars.begin()->first;
    mesh.primvars.erase(name);
    mesh.primvarSamples.erase(name);
    if (!one.primvars.begin()->second.value.empty()) mesh.primvars.merge(one.primvars);
    mesh.primvarSamples.merge(one.primvarSamples);
    scene.SetMesh(id, std::move(mesh));
  };
  return on_prim_with(
      primvar, handle, path, [&](const Path&, ValueReader& reader) { return read_one(primvar, "primvar", reader); },
      set);
}

AlabasterStatus set_transform(AlabasterScene* handle, const char* path, const double* matrix) {
  return on_prim(handle, path, [&](RetainedSceneDelegate& scene, const Path& id) {
    const auto moved = [&](auto description) {
      description.transform = matrix_of(matrix);
      if constexpr (requires { description.transformSamples; }) description.transformSamples = {};
      return description;
    };
    if (scene.GetMeshes().contains(id)) return scene.SetMesh(id, moved(scene.GetMeshes().at(id)));
    if (scene.GetLights().contains(id)) return scene.SetLight(id, moved(scene.GetLights().at(id)));
    if (scene.GetInstancers().contains(id)) return scene.SetInstancer(id, moved(scene.GetInstancers().at(id)));
    scene.SetCamera(id, moved(copy_of(scene.GetCameras(), id, "mesh, light, instancer or camera")));
  });
}

AlabasterStatus set_visible(AlabasterScene* handle, const char* path, int32_t visible) {
  return on_prim(handle, path, [&](RetainedSceneDelegate& scene, const Path& id) {
    const auto shown = [&](auto description) {
      description.visible = visible != 0;
      return description;
    };
    if (scene.GetMeshes().contains(id)) return scene.SetMesh(id, shown(scene.GetMeshes().at(id)));
    scene.SetLight(id, shown(copy_of(scene.GetLights(), id, "mesh or light")));
  });
}

AlabasterStatus bind_material(AlabasterScene* handle, const char* path, const char* material) {
  return on_prim(handle, path, [&](RetainedSceneDelegate& scene, const Path& id) {
    host::MeshDescription mesh = copy_of(scene.GetMeshes(), id, "mesh");
    mesh.material = Path(text_or(material, ""));
    scene.SetMesh(id, std::move(mesh));
  });
}

AlabasterStatus set_instancer(AlabasterScene* handle, const char* path, const AlabasterInstancer* instancer) {
  return on_prim_with(
      instancer, handle, path, [&](const Path&, ValueReader& reader) { return read_instancer(instancer, reader); },
      [](RetainedSceneDelegate& scene, const Path& id, auto made) { scene.SetInstancer(id, std::move(made)); });
}

AlabasterStatus set_instance_values(AlabasterScene* handle, const char* path, const AlabasterPrimvar* values,
                                    size_t first) {
  const auto set = [&](RetainedSceneDelegate& scene, const Path& id, const host::MeshDescription& one) {
    const auto& [name, primvar] = *one.primvars.begin();
    const auto found = scene.GetInstancers().find(id);
    if (found == scene.GetInstancers().end()) throw Failure(ALABASTER_NOT_FOUND, "there is no instancer " + id.str());
    if (!found->second.primvars.contains(name))
      throw Failure(ALABASTER_NOT_FOUND, "the instancer " + id.str() + " has no primvar " + name.str());
    if (!one.primvarSamples.empty())
      throw bad_argument("'" + name.str() + "': single instances take no motion; set it with the instancer");
    if (!scene.SetInstanceValues(id, name, first, primvar.value))
      throw bad_argument("the values of " + name.str() + " are of another type than the instancer's or beyond its end");
  };
  return on_prim_with(
      values, handle, path, [&](const Path&, ValueReader& reader) { return read_one(values, "values", reader); }, set);
}

AlabasterStatus set_material(AlabasterScene* handle, const char* path, const AlabasterMaterial* material) {
  return on_prim_with(
      material, handle, path, [&](const Path& id, ValueReader& reader) { return read_material(id, material, reader); },
      [](RetainedSceneDelegate& scene, const Path& id, auto made) { scene.SetMaterial(id, std::move(made)); });
}

AlabasterStatus set_light(AlabasterScene* handle, const char* path, const AlabasterLight* light) {
  return on_prim_with(
      light, handle, path, [&](const Path&, ValueReader& reader) { return read_light(light, reader); },
      [](RetainedSceneDelegate& scene, const Path& id, auto made) { scene.SetLight(id, std::move(made)); });
}

AlabasterStatus set_camera(AlabasterScene* handle, const char* path, const AlabasterCamera* camera) {
  return on_prim_with(
      camera, handle, path, [&](const Path&, ValueReader& reader) { return read_camera(camera, reader); },
      [](RetainedSceneDelegate& scene, const Path& id, auto made) { scene.SetCamera(id, std::move(made)); });
}

AlabasterStatus set_render_settings(AlabasterScene* handle, const char* path, const AlabasterRenderSettings* settings) {
  return on_prim_with(
      settings, handle, path, [&](const Path&, ValueReader& reader) { return read_render_settings(settings, reader); },
      [](RetainedSceneDelegate& scene, const Path& id, auto made) { scene.SetRenderSettings(id, std::move(made)); });
}

namespace {

template <class Map>
void put(Map& map, const std::string& key, const Value& value) {
  if (value.empty())
    map.erase(key);
  else
    map[key] = value;
}

void put_in_network(MaterialNetwork& network, const Path& id, const std::string& key, const Value& value) {
  const size_t dot = key.find('.');
  const auto node = dot == std::string::npos ? network.nodes.end() : network.nodes.find(id.append(key.substr(0, dot)));
  if (node == network.nodes.end())
    throw Failure(ALABASTER_NOT_FOUND, "material " + id.str() + " has no node for '" + key + "': name node.parameter");
  put(node->second.parameters, key.substr(dot + 1), value);
}

}  // namespace

AlabasterStatus set_parameter(AlabasterScene* handle, const char* path, const char* name, const AlabasterValue* in) {
  const auto set = [&](RetainedSceneDelegate& scene, const Path& id, const Value& value) {
    const std::string key = name;
    if (scene.GetLights().contains(id)) {
      auto light = scene.GetLights().at(id);
      put(light.parameters, key, value);
      scene.SetLight(id, std::move(light));
    } else if (scene.GetCameras().contains(id)) {
      auto camera = scene.GetCameras().at(id);
      put(camera.parameters, key, value);
      scene.SetCamera(id, std::move(camera));
    } else if (scene.GetAllRenderSettings().contains(id)) {
      auto settings = scene.GetAllRenderSettings().at(id);
      refuse_retired({{key, value}});
      put(settings.settings, key, value);
      scene.SetRenderSettings(id, std::move(settings));
    } else {
      auto network = copy_of(scene.GetMaterials(), id, "light, camera, material or render settings");
      put_in_network(network, id, key, value);
      scene.SetMaterial(id, std::move(network));
    }
  };
  return on_prim_with(
      in, handle, path,
      [&](const Path&, ValueReader& reader) { return reader.value(required(in, "value"), &required(name, "name")); },
      set);
}

AlabasterStatus get_prims(AlabasterScene* handle, AlabasterVisit visit, void* user) {
  return guarded([&] {
    const std::shared_ptr<SceneData> held = required(handle, "scene").data;
    SceneData& data = *held;
    if (!visit) throw bad_argument("visit is null");
    const auto prims = [&] {  // `visit` may call the library, so it is called without the lock
      const SceneLock lock(data);
      return all_prims(data.scene);
    }();
    for (const auto& [path, type] : prims) {
      const Value value(type);
      const ValueView view(value);
      visit(user, path.str().c_str(), &view.get());
    }
  });
}

}  // namespace alabaster::hd::c_api

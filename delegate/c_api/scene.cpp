#include "core/subsurface/medium.h"
#include "delegate/c_api/values.h"
#include "delegate/host/scene_fields.h"
#include "delegate/support/nearest_name.h"

namespace alabaster::hd::c_api {
namespace {

Path prim_path(const char* path) {
  if (required(path, "path") == '\0') throw bad_argument("the path is empty");
  return path;
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
  if (!(in.frames_per_second >= 0)) throw bad_argument("frames_per_second must be above 0, or 0 for the model's own");
  if (in.frames_per_second > 0) options.frames_per_second = in.frames_per_second;
  if (in.next_frame) options.next_frame = true;
  options.keep_going = in.keep_going != 0;
  options.allow_outside = in.allow_outside != 0;
  return options;
}

AlabasterStatus scene_create(AlabasterReport report, void* user, AlabasterScene** scene) {
  return guarded([&] {
    auto& out = required(scene, "scene");
    auto data = std::make_shared<SceneData>();
    data->reports = std::make_shared<Reports>(report, user);
    out = new AlabasterScene{std::move(data)};
  });
}

AlabasterStatus scene_load(AlabasterScene* handle, const char* file, const AlabasterLoadOptions* options,
                           AlabasterLoaded* loaded) {
  return with_data(handle, "scene", [&](SceneData& data) {
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
  return with_data(handle, "scene", [](SceneData& data) {
    const SceneLock lock(data);
    for (const auto& prim : host::ListPrims(data.scene)) data.scene.Remove(prim.first);
  });
}

AlabasterStatus remove_prim(AlabasterScene* handle, const char* path) {
  return with_data(handle, "scene", [&](SceneData& data) {
    const Path id = prim_path(path);
    const SceneLock lock(data);
    if (!data.scene.Remove(id)) throw Failure(ALABASTER_NOT_FOUND, host::NoSuchPrim(data.scene, id));
  });
}

/// Runs call(scene, path, fields) with the fields, whose arrays come back whatever fails.
template <class Call>
AlabasterStatus with_fields(AlabasterScene* handle, const char* path, const ParameterList& given, const Call& call) {
  return guarded([&] {
    ValueReader reader(&given);
    const std::shared_ptr<SceneData> data = required(handle, "scene").data;
    const Path id = prim_path(path);
    const host::Fields fields = reader.fields(given);
    reader.take();
    const SceneLock lock(*data);
    const host::SetResult result = call(&data->scene, id, fields);
    if (!result.found) throw Failure(ALABASTER_NOT_FOUND, result.fault);
    if (!result.fault.empty()) throw bad_argument(std::string(path) + ": " + result.fault);
    const auto& prims = data->scene.GetPrims();
    const auto* mesh = host::FindPrim<host::MeshDescription>(prims, id);
    if (mesh ? !mesh->instancer.empty() : host::FindPrim<host::InstancerDescription>(prims, id) != nullptr)
      data->unmatched.insert(id);
  });
}

AlabasterStatus scene_set(AlabasterScene* handle, const char* path, const char* kind, const AlabasterParameter* fields,
                          size_t count) {
  return with_fields(handle, path, {fields, count}, [&](auto* scene, const Path& id, const host::Fields& read) {
    return host::SetPrim(scene, id, Token(&required(kind, "kind")), read);
  });
}

AlabasterStatus scene_edit(AlabasterScene* handle, const char* path, const AlabasterParameter* fields, size_t count) {
  return with_fields(handle, path, {fields, count}, [](auto* scene, const Path& id, const host::Fields& read) {
    return host::EditPrim(scene, id, read);
  });
}

/// Why a part of an instancer's values cannot be replaced; "" if not for what this compares.
std::string misfit(const Token& name, const Value& held, size_t first, const Value& given) {
  const std::string values = "the values of " + name.str();
  if (!given.is_array()) return values + " must be an array: one for each instance";
  const TypeInfo &own = GetTypeInfo(held.type()), &other = GetTypeInfo(given.type());
  if (own.components != other.components || (own.bytes == 0) != (other.bytes == 0))
    return values + " are of type " + own.name + ", and those given are of type " + other.name;
  if (first <= held.count() && given.count() <= held.count() - first) return {};
  return values + " are " + std::to_string(held.count()) + ", and " + std::to_string(given.count()) + " from number " +
         std::to_string(first) + " on go beyond their end";
}

void edit_instances(AlabasterScene* handle, const char* path, size_t first, const std::map<Token, Value>& elements) {
  SceneData& data = *required(handle, "scene").data;
  const Path id(&required(path, "path"));
  const SceneLock lock(data);
  const auto found = data.scene.GetInstancers().find(id);
  if (found == data.scene.GetInstancers().end())
    throw Failure(ALABASTER_NOT_FOUND,
                  "there is no instancer " + id.str() + support::DidYouMeanPath(id.str(), data.scene.GetInstancers()));
  std::string names;
  for (const auto& [name, value] : elements) {
    if (!found->second.primvars.contains(name))
      throw Failure(ALABASTER_NOT_FOUND, "the instancer " + id.str() + " has no primvar " + name.str() +
                                             support::DidYouMeanPath(name.str(), found->second.primvars));
    names += (names.empty() ? "" : ", ") + name.str();
  }
  if (data.scene.SetInstanceValues(id, first, elements)) return;
  for (const auto& [name, value] : elements)
    if (const std::string fault = misfit(name, found->second.primvars.at(name), first, value); !fault.empty())
      throw bad_argument(id.str() + ": " + fault);
  throw bad_argument(id.str() + ": the values of " + names +
                     " are of another type than the instancer's, or its samples end before them");
}

AlabasterStatus scene_set_instances(AlabasterScene* handle, const char* path, const char* primvar, size_t first,
                                    const AlabasterValue* values) {
  return guarded([&] {
    ValueReader reader(values);
    const Token name(&required(primvar, "primvar"));
    const Value read = reader.value(required(values, "values"), primvar);
    reader.take();
    edit_instances(handle, path, first, {{name, read}});
  });
}

AlabasterStatus scene_edit_instances(AlabasterScene* handle, const char* path, size_t first,
                                     const AlabasterParameter* primvars, size_t count) {
  return guarded([&] {
    const ParameterList given{primvars, count};
    ValueReader reader(&given);
    const Dictionary read = reader.dictionary(given, "primvars");
    reader.take();
    edit_instances(handle, path, first, {read.begin(), read.end()});
  });
}

AlabasterStatus get_prims(AlabasterScene* handle, AlabasterVisit visit, void* user) {
  return with_data(handle, "scene", [&](SceneData& data) {
    if (!visit) throw bad_argument("visit is null");
    const auto prims = [&] {  // `visit` may call the library, so it is called without the lock
      const SceneLock lock(data);
      return host::ListPrims(data.scene);
    }();
    for (const auto& [path, type] : prims) {
      visit_value(path.str().c_str(), type, visit, user);
    }
  });
}

AlabasterStatus field_type(const char* kind, const char* name, int32_t* type, int32_t* is_array) {
  return guarded_at_any_time([&] {
    const host::FieldType found = host::TypeOfField(Token(text_or(kind, "")), &required(name, "name"));
    required(type, "type") = found.type;
    required(is_array, "is_array") = found.is_array;
  });
}

AlabasterStatus absorbed_share(double color, double anisotropy, double* share) {
  return guarded_at_any_time(
      [&] { required(share, "share") = one_minus_alpha(color, AlbedoInversion::exact, anisotropy); });
}

}  // namespace

void add_scene_functions(AlabasterApi* api) {
  api->scene_create = scene_create;
  api->scene_destroy = destroy_handle;
  api->scene_load = scene_load;
  api->scene_clear = scene_clear;
  api->remove = remove_prim;
  api->scene_set = scene_set;
  api->scene_edit = scene_edit;
  api->scene_set_instances = scene_set_instances;
  api->get_prims = get_prims;
  api->field_type = field_type;
  api->scene_edit_instances = scene_edit_instances;
  api->absorbed_share = absorbed_share;
}

}  // namespace alabaster::hd::c_api

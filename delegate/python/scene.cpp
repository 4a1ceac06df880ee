#include <algorithm>

#include "delegate/python/objects.h"

namespace alabaster::python {
namespace {

std::string text(const py::dict& options, const char* name) {
  return options.contains(name) ? text_or_none(options[name], name) : std::string();
}
py::object option(const py::dict& options, const char* name) {
  return options.contains(name) ? py::object(options[name]) : py::none();
}
bool flag(const py::dict& options, const char* name, bool otherwise) {
  return options.contains(name) ? python::flag(options[name], name) : otherwise;
}
/// Options that a call takes: a misspelt one is an error.
void check_options(const py::dict& options, std::initializer_list<const char*> known) {
  for (const auto& entry : entries(options, "options")) {
    const std::string& name = entry.first;
    if (std::find(known.begin(), known.end(), name) == known.end())
      throw py::type_error("unexpected keyword argument '" + name + "'");
  }
}

/// The fields of a dict or None, and of keyword arguments.
c_api::Parameters all_fields(const std::string& kind, const py::object& given, const py::dict& options) {
  c_api::Parameters fields;
  if (!given.is_none()) add_fields(kind, given, "fields", &fields);
  add_fields(kind, options, "fields", &fields);
  return fields;
}

/// Throws for a field that prims of this kind do not have. Those of a material are its nodes'.
void check_names(const std::string& path, const std::string& kind, const py::object& given, const py::dict& options) {
  if (kind == "material") return;
  const c_api::Scene scratch = c_api::make_scene();
  for (const py::object& fields : {given, py::object(options)})
    if (!fields.is_none())
      for (const auto& named : entries(fields, "fields"))
        c_api::set(scratch, path, kind, {{field_name(named.first), Value()}});
}

}  // namespace

Scene::Scene(py::object report)
    : report_(std::move(report)), messages_(report_), handle_(c_api::make_scene(&Messages::hear, &messages_)) {}
Scene::~Scene() {
  drop(handle_);
}

py::dict Scene::load(const py::object& file, const py::dict& options) {
  check_options(options, {"overrides", "camera", "dome", "scene", "animation", "variant", "time", "shutter",
                          "frames_per_second", "next_frame", "keep_going", "allow_outside"});
  const std::vector<std::string> overrides =
      options.contains("overrides") ? texts(options["overrides"], "overrides") : std::vector<std::string>();
  std::vector<const char*> raw;
  for (const std::string& one : overrides) raw.push_back(one.c_str());
  const std::string camera = text(options, "camera"), dome = text(options, "dome"), scene = text(options, "scene");
  const std::string animation = text(options, "animation"), variant = text(options, "variant");
  auto in = c_api::sized<AlabasterLoadOptions>();
  in.overrides = raw.data(), in.override_count = raw.size();
  in.camera = camera.c_str(), in.dome = dome.c_str(), in.scene = scene.c_str();
  in.animation = animation.c_str(), in.variant = variant.c_str();
  double time = 0;
  if (const py::object given = option(options, "time"); !given.is_none()) time = number(given, "time"), in.time = &time;
  std::array<double, 2> shutter{};
  if (const py::object given = option(options, "shutter"); !given.is_none()) {
    const std::vector<py::object> times = items(given, "shutter");
    if (times.size() != 2) throw py::value_error("shutter must be two times: when it opens and when it closes");
    shutter = {number(times[0], "shutter"), number(times[1], "shutter")};
    in.shutter = shutter.data();
  }
  if (const py::object given = option(options, "frames_per_second"); !given.is_none())
    in.frames_per_second = number(given, "frames_per_second");
  in.next_frame = flag(options, "next_frame", false);
  in.keep_going = flag(options, "keep_going", false);
  in.allow_outside = flag(options, "allow_outside", false);
  const std::string name = file_name(file, "file");
  auto loaded = c_api::sized<AlabasterLoaded>();
  run([&](const AlabasterApi& api, AlabasterScene* held) { return api.scene_load(held, name.c_str(), &in, &loaded); });
  py::dict told;
  told["settings"] = name_to_python(loaded.settings);
  told["color_config"] = name_to_python(loaded.color_config);
  told["notes"] = message_to_python(loaded.notes).attr("splitlines")();
  return told;
}

void Scene::write(const py::object& file, const py::object& overrides, const py::kwargs& frame) {
  if (frame.contains("aovs")) throw py::type_error("unexpected keyword argument 'aovs'");
  const FrameOptions options = changed({}, frame_changes(frame));
  const c_api::Parameters held = overrides.is_none() ? c_api::Parameters() : python::parameters(overrides, "overrides");
  const std::string name = file_name(file, "file");
  std::vector<AlabasterParameter> camera;
  const std::vector<AlabasterParameter> raw = c_api::pass(held);
  const AlabasterFrame in = options.pass(&camera);
  run([&](const AlabasterApi& api, AlabasterScene* scene) {
    return api.scene_write(scene, name.c_str(), &in, raw.data(), raw.size());
  });
}

py::dict Scene::prims() {
  Answers told;
  run([&](const AlabasterApi& api, AlabasterScene* held) { return api.get_prims(held, &keep_answer, &told); });
  py::dict all;
  for (const auto& [path, type] : told) all[name_to_python(path)] = type.to_python();
  return all;
}

void Scene::set(const std::string& path, const std::string& kind, const py::object& fields, const py::dict& options) {
  const c_api::Parameters held = [&] {
    try {
      return all_fields(kind, fields, options);
    } catch (const py::builtin_exception&) {  // a misspelt name is the cause of a value that cannot be read
      check_names(path, kind, fields, options);
      throw;
    }
  }();
  const std::vector<AlabasterParameter> raw = c_api::pass(held);
  run([&](const AlabasterApi& api, AlabasterScene* scene) {
    return api.scene_set(scene, path.c_str(), kind.c_str(), raw.data(), raw.size());
  });
}

void Scene::edit(const std::string& path, const py::object& fields, const py::dict& options) {
  const c_api::Parameters held = [&] {
    try {
      return all_fields("", fields, options);
    } catch (const py::builtin_exception&) {
      const py::dict all = prims();
      if (const py::str name(path); all.contains(name)) check_names(path, py::str(all[name]), fields, options);
      throw;
    }
  }();
  const std::vector<AlabasterParameter> raw = c_api::pass(held);
  run([&](const AlabasterApi& api, AlabasterScene* scene) {
    return api.scene_edit(scene, path.c_str(), raw.data(), raw.size());
  });
}

void Scene::set_instance_values(const std::string& path, size_t first, const py::dict& options) {
  py::dict named;
  for (const auto& [name, values] : entries(options, "options")) {
    const bool is_field = name.find(':') != std::string::npos || field_name(name).starts_with("primvars:");
    named[py::str(is_field ? name : "primvars:" + name)] = values;
  }
  c_api::Parameters all;
  add_fields("instancer", named, "options", &all);
  c_api::Parameters primvars;
  for (auto& [field, value] : all) {
    if (field.ends_with(":samples"))
      throw py::value_error("instances that are set one by one stand still: their values have no motion");
    for (const char* suffix : {":interpolation", ":role", ":indices"})
      if (field.ends_with(suffix))
        throw py::value_error(field.substr(0, field.rfind(':')) +
                              ": values by instance are numbers alone, without interpolation, role or indices");
    if (value.type() != ALABASTER_NONE) primvars.emplace_back(field.substr(field.find(':') + 1), std::move(value));
  }
  const std::vector<AlabasterParameter> raw = c_api::pass(primvars);
  run([&](const AlabasterApi& api, AlabasterScene* scene) {
    return api.scene_edit_instances(scene, path.c_str(), first, raw.data(), raw.size());
  });
}

}  // namespace alabaster::python

#include <algorithm>

#include "delegate/python/fields.h"

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
/// None: no entries.
std::vector<std::pair<std::string, py::object>> entries_of(const py::object& values, const char* name) {
  return values.is_none() ? std::vector<std::pair<std::string, py::object>>() : entries(values, name);
}

/// Options that a call takes: a misspelt one is an error.
void check_options(const py::dict& options, std::initializer_list<const char*> known) {
  for (const auto& entry : entries(options, "options")) {
    const std::string& name = entry.first;
    if (std::find(known.begin(), known.end(), name) == known.end())
      throw py::type_error("unexpected keyword argument '" + name + "'");
  }
}

Primvar primvar_of(const py::object& values, const std::string& name, const char* interpolation) {
  return py::isinstance<Primvar>(values) ? object_of<Primvar>(values, name, "a Primvar")
                                         : Primvar(values, interpolation);
}

/// (faces' sizes, corners) of indices with or without counts: without, rows are faces, or three numbers each.
std::pair<Value, Value> topology(const py::object& indices, const py::object& counts) {
  Value corners = array(ALABASTER_INT, indices, "indices");
  if (!counts.is_none()) return {array(ALABASTER_INT, counts, "counts"), std::move(corners)};
  const std::vector<size_t> shape = shape_of(indices, "indices");
  const size_t corners_each = shape.size() == 2 ? shape[1] : 3;
  const size_t faces = shape.empty() || corners_each == 0 ? 0 : shape.size() == 2 ? shape[0] : shape[0] / 3;
  return {Value::of(ALABASTER_INT, std::vector<int32_t>(faces, int32_t(corners_each))), std::move(corners)};
}

/// The options of meshes that are not fields by the rule of names.
void add_mesh_option(const std::string& path, const std::string& name, const py::object& value,
                     c_api::Parameters* fields) {
  if (name == "primvars") {
    for (const auto& [primvar, values] : entries_of(value, "primvars"))
      add_primvar(primvar, primvar_of(values, primvar, "vertex"), primvar, true, fields);
  } else if (name == "subsets") {
    size_t number = 0;
    for (const auto& [material, faces] : entries_of(value, "subsets")) {
      const std::string subset = "subsets:" + path + "/" + std::to_string(number++);
      add_field(subset + ":faces", faces, "subsets[" + material + "]", fields);
      fields->emplace_back(subset + ":material", Value(material));
    }
  } else if (name == "subdiv_tags") {
    if (!value.is_none()) add_fields(value, name, fields);
  } else if (name == "left_handed") {
    if (python::flag(value, name)) fields->emplace_back("orientation", Value("leftHanded"));
  } else if (name == "visible" || name == "double_sided") {
    fields->emplace_back(field_name(name), Value(python::flag(value, name)));
  } else if (name == "material" || name == "instancer" || name == "scheme" || name == "cull_style" ||
             name == "render_tag") {
    const std::string word = text_or_none(value, name);
    fields->emplace_back(field_name(name), word.empty() ? Value() : Value(word));
  } else if (name == "refine_level") {
    fields->emplace_back(field_name(name), Value(whole(value, name)));
  } else if (name != "motion") {
    add_field(name == "holes" ? "holeIndices" : field_name(name), value, name, fields);
  }
}

// The options of instancers, and the primvars that they are.
constexpr std::pair<const char*, const char*> kPlaces[] = {{"transforms", "hydra:instanceTransforms"},
                                                           {"translations", "hydra:instanceTranslations"},
                                                           {"rotations", "hydra:instanceRotations"},
                                                           {"scales", "hydra:instanceScales"}};

void add_node(const std::string& name, const py::object& values, c_api::Parameters* fields) {
  if (name.find('.') != std::string::npos) throw py::value_error("node '" + name + "': names of nodes have no dot");
  std::string type = "AlabasterDisney";
  c_api::Parameters inputs;
  for (const auto& [input, value] : entries(values, "node '" + name + "'")) {
    if (input == "type")
      type = python::text(value, input);
    else
      add_field(name + "." + input, value, input, &inputs);
  }
  fields->emplace_back(name + ".type", Value(type));
  fields->insert(fields->end(), inputs.begin(), inputs.end());
}

}  // namespace

Scene::Scene(py::object report)
    : messages_(std::move(report)), handle_(c_api::make_scene(&Messages::hear, &messages_)) {}
Scene::~Scene() {
  drop(handle_);
}

py::dict Scene::load(const py::object& file, const py::dict& options) {
  check_options(options, {"overrides", "camera", "dome", "scene", "animation", "variant", "time", "shutter",
                          "frames_per_second", "keep_going", "allow_outside"});
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

void Scene::set_fields(const std::string& path, const std::string& kind, const c_api::Parameters& fields) {
  const std::vector<AlabasterParameter> raw = c_api::pass(fields);
  run([&](const AlabasterApi& api, AlabasterScene* scene) {
    return api.scene_set(scene, path.c_str(), kind.c_str(), raw.data(), raw.size());
  });
}

void Scene::edit_fields(const std::string& path, const c_api::Parameters& fields) {
  const std::vector<AlabasterParameter> raw = c_api::pass(fields);
  run([&](const AlabasterApi& api, AlabasterScene* scene) {
    return api.scene_edit(scene, path.c_str(), raw.data(), raw.size());
  });
}

void Scene::set_mesh(const std::string& path, const py::object& points, const py::object& indices,
                     const py::object& counts, const py::dict& options) {
  c_api::Parameters fields;
  Primvar given = primvar_of(points, "points", "vertex");
  if (!py::isinstance<Primvar>(points)) given.role = "point";
  add_primvar("points", given, "points", true, &fields);
  auto [faces, corners] = topology(indices, counts);
  fields.emplace_back("faceVertexCounts", std::move(faces));
  fields.emplace_back("faceVertexIndices", std::move(corners));
  for (const auto& [name, value] : entries(options, "options")) add_mesh_option(path, name, value, &fields);
  if (options.contains("motion")) add_field("transform:samples", options["motion"], "motion", &fields);
  set_fields(path, "mesh", fields);
}

void Scene::set_primvar(const PrimPath& mesh, const Text& name, const py::object& values, const Text& interpolation) {
  c_api::Parameters fields;
  add_primvar(name, primvar_of(values, name, interpolation.c_str()), name, true, &fields);
  edit_fields(mesh, fields);
}

void Scene::set_instancer(const std::string& path, const py::dict& prototypes, const py::dict& options) {
  c_api::Parameters fields;
  for (const auto& [name, indices] : entries(prototypes, "prototypes"))
    add_field("prototypes:" + name, indices, "prototypes[" + name + "]", &fields);
  for (const auto& [name, value] : entries(options, "options")) {
    const auto place = std::find_if(std::begin(kPlaces), std::end(kPlaces),
                                    [&, &wanted = name](const auto& one) { return wanted == one.first; });
    if (place != std::end(kPlaces) && !value.is_none())
      add_primvar(place->second, primvar_of(value, name, "instance"), name, false, &fields);
    else if (place == std::end(kPlaces) && name != "motion")
      add_field(field_name(name), value, name, &fields);
  }
  if (options.contains("motion")) add_field("transform:samples", options["motion"], "motion", &fields);
  set_fields(path, "instancer", fields);
}

void Scene::set_instance_values(const std::string& path, size_t first, const py::dict& options) {
  check_options(options, {"transforms", "translations", "rotations", "scales"});
  c_api::Parameters all;  // read before the first one is set
  for (const auto& [name, primvar] : kPlaces)
    if (const py::object values = option(options, name); !values.is_none())
      add_primvar(primvar, Primvar(values, "instance"), name, false, &all);
  for (const auto& [name, value] : all) {
    const AlabasterValue raw = value.pass();
    const std::string primvar = name.substr(name.find(':') + 1);
    run([&](const AlabasterApi& api, AlabasterScene* scene) {
      return api.scene_set_instances(scene, path.c_str(), primvar.c_str(), first, &raw);
    });
  }
}

void Scene::set_material(const std::string& path, const py::object& nodes, const std::string& displacement,
                         const py::dict& parameters) {
  if (!nodes.is_none() && py::len(parameters) > 0)
    throw py::type_error("a material has nodes, or parameters: put these into a node");
  c_api::Parameters fields;
  for (const auto& [name, values] : entries_of(nodes, "nodes")) {
    add_node(name, values, &fields);
    if (name == "surface") fields.emplace_back("surface", Value(name));
  }
  if (nodes.is_none()) add_node("surface", parameters, &fields);
  if (!displacement.empty()) fields.emplace_back("displacement", Value(displacement));
  set_fields(path, "material", fields);
}

void Scene::set_light(const std::string& path, const std::string& type, const py::object& transform, bool visible,
                      const py::dict& parameters) {
  c_api::Parameters fields;
  add_field("transform", transform, "transform", &fields);
  fields.emplace_back("visible", Value(visible));
  add_fields(parameters, "parameters", &fields);
  set_fields(path, type, fields);
}

void Scene::set_camera(const std::string& path, const py::dict& options) {
  set_fields(path, "camera", camera_fields(options));
}

void Scene::set_render_settings(const std::string& path, const py::dict& options) {
  c_api::Parameters fields;
  for (const auto& [name, value] : entries(options, "settings")) {
    const bool is_length = name == "width" || name == "height";
    if (is_length && (value.is_none() || length_of(value, name) == 0)) continue;
    if (name == "pixel_aspect" && (value.is_none() || number(value, name) == 0)) continue;
    add_field(name == "pixel_aspect" ? "pixelAspectRatio" : field_name(name), value, name, &fields);
  }
  set_fields(path, "renderSettings", fields);
}

}  // namespace alabaster::python

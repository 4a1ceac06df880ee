#include <algorithm>

#include "delegate/python/objects.h"

namespace alabaster::python {
namespace {

int32_t interpolation_of(const std::string& name) {
  constexpr const char* kNames[] = {"constant", "uniform", "varying", "vertex", "faceVarying", "instance"};
  for (int32_t i = 0; i < 6; ++i)
    if (name == kNames[i]) return i;
  throw py::value_error("interpolation is constant, uniform, varying, vertex, faceVarying or instance");
}

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

/// Options that a call knows, so that a misspelt one is an error and not ignored.
void check_options(const py::dict& options, std::initializer_list<const char*> known) {
  for (const auto& entry : entries(options, "options")) {
    const std::string& name = entry.first;
    if (std::find(known.begin(), known.end(), name) == known.end())
      throw py::type_error("unexpected keyword argument '" + name + "'");
  }
}

/// The type of the elements of a primvar whose name decides it; NONE: their shape does.
int32_t type_of(const std::string& primvar) {
  if (primvar == "hydra:instanceRotations") return ALABASTER_QUATERNION;
  if (primvar == "hydra:instanceTransforms") return ALABASTER_MATRIX;
  const bool vectors = primvar == "points" || primvar == "normals" || primvar == "hydra:instanceTranslations" ||
                       primvar == "hydra:instanceScales";
  return vectors ? ALABASTER_FLOAT3 : ALABASTER_NONE;
}

/// Primvars with what their structs point at. Nothing is lent before pass().
class Primvars {
 public:
  void add(const std::string& name, const Primvar& primvar) { add(name, primvar, name); }
  /// `argument`: its name in errors.
  void add(const std::string& name, const Primvar& primvar, const std::string& argument) {
    const int32_t type = type_of(name);
    Value values;
    if (type != ALABASTER_NONE)
      values = array(type, primvar.values, argument);
    else if (PyUnicode_Check(primvar.values.ptr()) || PyBool_Check(primvar.values.ptr()))
      values = parameter(primvar.values, argument);
    else if (!primvar.values.is_none())
      values = array_by_shape(primvar.values, argument);
    if (!primvar.motion.is_none() && type == ALABASTER_NONE)
      throw py::value_error("points, normals and transforms of instances have motion; " + argument + " has none");
    Motion motion = Motion::of_arrays(primvar.motion, type, "motion of " + argument);
    Value indices = array(ALABASTER_INT, primvar.indices, "indices of " + argument);
    named_.push_back({name, primvar.role, std::move(values), std::move(indices),
                      interpolation_of(primvar.interpolation), std::move(motion)});
  }
  std::vector<AlabasterPrimvar> pass() const {
    std::vector<AlabasterPrimvar> raw;
    for (const Named& p : named_)
      raw.push_back(
          {p.name.c_str(), door::or_null(p.role), p.interpolation, p.values.pass(), p.indices.pass(), p.motion.pass()});
    return raw;
  }

 private:
  struct Named {
    std::string name, role;
    Value values, indices;
    int32_t interpolation;
    Motion motion;
  };
  std::vector<Named> named_;
};

/// (faces' sizes, corners) of indices with or without counts: without, rows are faces, or three numbers each.
std::pair<Value, Value> topology(const py::object& indices, const py::object& counts) {
  Value corners = array(ALABASTER_INT, indices, "indices");
  if (!counts.is_none()) return {array(ALABASTER_INT, counts, "counts"), std::move(corners)};
  const std::vector<size_t> shape = shape_of(indices, "indices");
  const size_t corners_each = shape.size() == 2 ? shape[1] : 3;
  const size_t faces = shape.empty() || corners_each == 0 ? 0 : shape.size() == 2 ? shape[0] : shape[0] / 3;
  return {Value::of(ALABASTER_INT, std::vector<int32_t>(faces, int32_t(corners_each))), std::move(corners)};
}

/// Creases, corners and rules. Nothing is lent before pass().
class SubdivTags {
 public:
  explicit SubdivTags(const py::object& given) {
    py::dict in;
    for (const auto& [name, value] : entries_of(given, "subdiv_tags")) in[py::str(name)] = value;
    check_options(in,
                  {"interpolate_boundary", "face_varying_linear_interpolation", "crease_method", "triangle_subdivision",
                   "crease_indices", "crease_lengths", "crease_weights", "corner_indices", "corner_weights"});
    rules_ = {text(in, "interpolate_boundary"), text(in, "face_varying_linear_interpolation"),
              text(in, "crease_method"), text(in, "triangle_subdivision")};
    for (const auto& [type, name] :
         {std::pair(ALABASTER_INT, "crease_indices"), std::pair(ALABASTER_INT, "crease_lengths"),
          std::pair(ALABASTER_FLOAT, "crease_weights"), std::pair(ALABASTER_INT, "corner_indices"),
          std::pair(ALABASTER_FLOAT, "corner_weights")})
      values_.push_back(array(type, option(in, name), name));
  }
  AlabasterSubdivTags pass() const {
    return {sizeof(AlabasterSubdivTags), door::or_null(rules_[0]), door::or_null(rules_[1]), door::or_null(rules_[2]),
            door::or_null(rules_[3]),    values_[0].pass(),        values_[1].pass(),        values_[2].pass(),
            values_[3].pass(),           values_[4].pass()};
  }

 private:
  std::array<std::string, 4> rules_;
  std::vector<Value> values_;
};

/// Nodes of a material, with what their structs point at.
struct Network {
  struct Node {
    std::string name, type;
    door::Parameters parameters;
    std::vector<std::array<std::string, 3>> connections;  // input, node, output
    std::vector<AlabasterParameter> raw_parameters;
    std::vector<AlabasterConnection> raw_connections;
  };
  std::vector<Node> nodes;

  static bool is_connection(py::handle value) {
    if (!py::isinstance<py::tuple>(value) || py::len(value) != 2) return false;
    const auto pair = py::reinterpret_borrow<py::tuple>(value);
    return py::isinstance<py::str>(pair[0]) && py::isinstance<py::str>(pair[1]);
  }
  static void connect(Node& node, const std::string& input, const py::object& value) {
    if (!is_connection(value)) throw wrong_type("each of " + input, "a pair of texts", value);
    const auto pair = py::reinterpret_borrow<py::tuple>(value);
    node.connections.push_back({input, python::text(pair[0], input), python::text(pair[1], input)});
  }
  static bool starts_with_connection(const py::object& value) {
    return py::isinstance<py::list>(value) && py::len(value) > 0 && is_connection(py::object(value[py::int_(0)]));
  }

  /// A pair of texts is a connection: the node and its output. A list of them is their product.
  void add(const std::string& name, const py::object& values, const std::string& type) {
    Node node{name, type, {}, {}, {}, {}};
    for (const auto& [input, value] : entries(values, "node '" + name + "'")) {
      if (input == "type")
        node.type = python::text(value, input);
      else if (is_connection(value))
        connect(node, input, value);
      else if (starts_with_connection(value))
        for (const py::object& one : items(value, input)) connect(node, input, one);
      else
        node.parameters.emplace_back(input, parameter(value, input));
    }
    nodes.push_back(std::move(node));
  }

  std::vector<AlabasterNode> pass() {
    std::vector<AlabasterNode> raw;
    for (Node& node : nodes) {
      node.raw_parameters = door::pass(node.parameters);
      for (const auto& [input, upstream, output] : node.connections)
        node.raw_connections.push_back({input.c_str(), upstream.c_str(), output.c_str()});
      raw.push_back({node.name.c_str(), node.type.c_str(), node.raw_parameters.data(), node.raw_parameters.size(),
                     node.raw_connections.data(), node.raw_connections.size()});
    }
    return raw;
  }
};

}  // namespace

Scene::Scene(py::object report)
    : messages_(std::move(report)), handle_(door::make_scene(&Messages::hear, &messages_)) {}
Scene::~Scene() {
  drop(handle_);
}

py::dict Scene::load(const py::object& file, const py::dict& options) {
  check_options(
      options, {"overrides", "camera", "dome", "scene", "animation", "variant", "time", "keep_going", "allow_outside"});
  const std::vector<std::string> overrides =
      options.contains("overrides") ? texts(options["overrides"], "overrides") : std::vector<std::string>();
  std::vector<const char*> raw;
  for (const std::string& one : overrides) raw.push_back(one.c_str());
  const std::string camera = text(options, "camera"), dome = text(options, "dome"), scene = text(options, "scene");
  const std::string animation = text(options, "animation"), variant = text(options, "variant");
  auto in = door::sized<AlabasterLoadOptions>();
  in.overrides = raw.data(), in.override_count = raw.size();
  in.camera = camera.c_str(), in.dome = dome.c_str(), in.scene = scene.c_str();
  in.animation = animation.c_str(), in.variant = variant.c_str();
  double time = 0;
  if (const py::object given = option(options, "time"); !given.is_none()) time = number(given, "time"), in.time = &time;
  in.keep_going = flag(options, "keep_going", false);
  in.allow_outside = flag(options, "allow_outside", false);
  const std::string name = file_name(file, "file");
  auto loaded = door::sized<AlabasterLoaded>();
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
  const door::Parameters held = overrides.is_none() ? door::Parameters() : python::parameters(overrides, "overrides");
  const std::string name = file_name(file, "file");
  auto camera = door::sized<AlabasterCamera>();
  const std::vector<AlabasterParameter> raw = door::pass(held);
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

namespace {

/// Faces that have a material of their own, by its path.
class Subsets {
 public:
  Subsets(const std::string& mesh, const py::object& by_material) {
    for (const auto& [material, faces] : entries_of(by_material, "subsets"))
      held_.push_back({mesh + "/" + std::to_string(held_.size()), material,
                       array(ALABASTER_INT, faces, "subsets[" + material + "]")});
  }
  std::vector<AlabasterSubset> pass() const {
    std::vector<AlabasterSubset> raw;
    for (const Subset& one : held_) raw.push_back({one.id.c_str(), one.material.c_str(), one.faces.pass()});
    return raw;
  }

 private:
  struct Subset {
    std::string id, material;
    Value faces;
  };
  std::vector<Subset> held_;
};

Primvar primvar_of(const py::object& values, const std::string& name, const char* interpolation) {
  return py::isinstance<Primvar>(values) ? object_of<Primvar>(values, name, "a Primvar")
                                         : Primvar(values, interpolation);
}

Primvars primvars_of(const py::object& points, const py::object& others) {
  Primvars primvars;
  Primvar given = primvar_of(points, "points", "vertex");
  if (!py::isinstance<Primvar>(points)) given.role = "point";
  primvars.add("points", given);
  for (const auto& [name, value] : entries_of(others, "primvars"))
    primvars.add(name, primvar_of(value, name, "vertex"));
  return primvars;
}

}  // namespace

namespace {
int32_t cull_style(const std::string& name) {
  const char* const names[] = {
      "dontCare", "nothing", "back", "front", "backUnlessDoubleSided", "frontUnlessDoubleSided"};
  for (int32_t style = ALABASTER_CULL_DONT_CARE; style <= ALABASTER_CULL_FRONT_UNLESS_DOUBLE_SIDED; ++style)
    if (name.empty() || name == names[style]) return style;
  throw py::value_error("there is no cull_style '" + name + "'");
}
}  // namespace

void Scene::set_mesh(const std::string& path, const py::object& points, const py::object& indices,
                     const py::object& counts, const py::dict& options) {
  check_options(options, {"primvars", "material", "transform", "scheme", "refine_level", "instancer", "visible",
                          "double_sided", "cull_style", "left_handed", "holes", "invisible_faces", "subsets",
                          "subdiv_tags", "render_tag", "categories", "motion"});
  const std::string material = text(options, "material"), instancer = text(options, "instancer");
  const std::string scheme = text(options, "scheme");
  const std::array<double, 16> transform = matrix(option(options, "transform"), "transform");
  auto mesh = door::sized<AlabasterMesh>();
  mesh.transform = transform.data();
  mesh.material = door::or_null(material), mesh.instancer = door::or_null(instancer);
  mesh.scheme = door::or_null(scheme);
  mesh.orientation = flag(options, "left_handed", false) ? "leftHanded" : nullptr;
  mesh.invisible = !flag(options, "visible", true), mesh.single_sided = !flag(options, "double_sided", true);
  mesh.refine_level = options.contains("refine_level") ? whole(options["refine_level"], "refine_level") : 0;
  mesh.cull_style = cull_style(text(options, "cull_style"));
  const Primvars primvars = primvars_of(points, option(options, "primvars"));
  const auto [faces, corners] = topology(indices, counts);
  const Value holes = array(ALABASTER_INT, option(options, "holes"), "holes");
  const Value invisible_faces = array(ALABASTER_INT, option(options, "invisible_faces"), "invisible_faces");
  const Subsets subsets(path, option(options, "subsets"));
  const std::string render_tag = text(options, "render_tag");
  const Tokens categories(option(options, "categories"), "categories");
  const Motion motion = Motion::of_transforms(option(options, "motion"), "motion");
  const SubdivTags tags(option(options, "subdiv_tags"));

  const AlabasterSubdivTags raw_tags = tags.pass();
  const std::vector<AlabasterPrimvar> raw_primvars = primvars.pass();
  const std::vector<AlabasterSubset> raw_subsets = subsets.pass();
  mesh.face_vertex_counts = faces.pass(), mesh.face_vertex_indices = corners.pass(), mesh.hole_indices = holes.pass();
  mesh.invisible_faces = invisible_faces.pass();
  mesh.subdiv_tags = &raw_tags;
  mesh.render_tag = door::or_null(render_tag), mesh.categories = categories.pass(), mesh.motion = motion.pass();
  mesh.primvars = raw_primvars.data(), mesh.primvar_count = raw_primvars.size();
  mesh.subsets = raw_subsets.data(), mesh.subset_count = raw_subsets.size();
  run([&](const AlabasterApi& api, AlabasterScene* scene) { return api.set_mesh(scene, path.c_str(), &mesh); });
}

void Scene::set_primvar(const PrimPath& mesh, const Text& name, const py::object& values, const Text& interpolation) {
  Primvars primvars;
  primvars.add(name, primvar_of(values, name, interpolation.c_str()));
  const AlabasterPrimvar raw = primvars.pass()[0];
  run([&](const AlabasterApi& api, AlabasterScene* scene) { return api.set_primvar(scene, mesh.c_str(), &raw); });
}

namespace {
// The options of instancers, and the primvars that they are.
constexpr std::pair<const char*, const char*> kPlaces[] = {{"transforms", "hydra:instanceTransforms"},
                                                           {"translations", "hydra:instanceTranslations"},
                                                           {"rotations", "hydra:instanceRotations"},
                                                           {"scales", "hydra:instanceScales"}};
}  // namespace

void Scene::set_instancer(const std::string& path, const py::dict& prototypes, const py::dict& options) {
  check_options(options, {"transforms", "translations", "rotations", "scales", "transform", "parent", "motion"});
  Primvars primvars;
  for (const auto& [option_name, name] : kPlaces)
    if (const py::object values = option(options, option_name); !values.is_none())
      primvars.add(name, primvar_of(values, option_name, "instance"), option_name);
  const std::array<double, 16> transform = matrix(option(options, "transform"), "transform");
  const std::string parent = text(options, "parent");
  const Motion motion = Motion::of_transforms(option(options, "motion"), "motion");
  std::vector<std::pair<std::string, Value>> instances;
  for (const auto& [name, indices] : entries(prototypes, "prototypes"))
    instances.emplace_back(name, array(ALABASTER_INT, indices, "prototypes[" + name + "]"));
  const std::vector<AlabasterPrimvar> raw = primvars.pass();
  std::vector<AlabasterPrototype> held;
  for (const auto& [name, indices] : instances) held.push_back({name.c_str(), indices.pass()});
  auto instancer = door::sized<AlabasterInstancer>();
  instancer.transform = transform.data();
  instancer.parent = door::or_null(parent);
  instancer.primvars = raw.data(), instancer.primvar_count = raw.size();
  instancer.prototypes = held.data(), instancer.prototype_count = held.size();
  instancer.motion = motion.pass();
  run([&](const AlabasterApi& api, AlabasterScene* scene) {
    return api.set_instancer(scene, path.c_str(), &instancer);
  });
}

void Scene::set_instance_values(const std::string& path, size_t first, const py::dict& options) {
  check_options(options, {"transforms", "translations", "rotations", "scales"});
  std::vector<Primvars> all;  // read before the first one is set
  for (const auto& [option_name, name] : kPlaces)
    if (const py::object values = option(options, option_name); !values.is_none())
      all.emplace_back().add(name, Primvar(values, "instance"), option_name);
  for (const Primvars& one : all) {
    const AlabasterPrimvar raw = one.pass()[0];
    run([&](const AlabasterApi& api, AlabasterScene* scene) {
      return api.set_instance_values(scene, path.c_str(), &raw, first);
    });
  }
}

void Scene::set_material(const std::string& path, const py::object& nodes, const std::string& displacement,
                         const py::dict& parameters) {
  Network network;
  if (!nodes.is_none() && py::len(parameters) > 0)
    throw py::type_error("a material has nodes, or parameters: put these into a node");
  for (const auto& [name, values] : entries_of(nodes, "nodes")) network.add(name, values, "AlabasterDisney");
  if (nodes.is_none()) network.add("surface", parameters, "AlabasterDisney");
  const bool named = std::any_of(network.nodes.begin(), network.nodes.end(),
                                 [&](const Network::Node& node) { return !nodes.is_none() && node.name == "surface"; });
  const std::vector<AlabasterNode> raw = network.pass();
  auto material = door::sized<AlabasterMaterial>();
  material.nodes = raw.data(), material.node_count = raw.size();
  material.surface = named ? "surface" : nullptr;
  material.displacement = door::or_null(displacement);
  run([&](const AlabasterApi& api, AlabasterScene* scene) { return api.set_material(scene, path.c_str(), &material); });
}

void Scene::set_light(const std::string& path, const std::string& type, const py::object& transform, bool visible,
                      const py::dict& parameters) {
  const std::array<double, 16> placed = matrix(transform, "transform");
  const door::Parameters held = python::parameters(parameters, "parameters");
  const std::vector<AlabasterParameter> raw = door::pass(held);
  auto light = door::sized<AlabasterLight>();
  light.type = type.c_str();
  light.transform = placed.data();
  light.invisible = !visible;
  light.parameters = raw.data(), light.parameter_count = raw.size();
  run([&](const AlabasterApi& api, AlabasterScene* scene) { return api.set_light(scene, path.c_str(), &light); });
}

void Scene::set_camera(const std::string& path, const py::dict& options) {
  const Camera held(options);
  const AlabasterCamera camera = held.pass();
  run([&](const AlabasterApi& api, AlabasterScene* scene) { return api.set_camera(scene, path.c_str(), &camera); });
}

void Scene::set_render_settings(const std::string& path, const py::dict& options) {
  auto settings = door::sized<AlabasterRenderSettings>();
  std::string camera;
  door::Parameters held;
  for (const auto& [name, value] : entries(options, "settings")) {
    const bool own = name == "camera" || name == "width" || name == "height" || name == "pixel_aspect" ||
                     name == "frame" || name == "crop";
    if (!own)
      held.emplace_back(name, parameter(value, name));
    else if (value.is_none())
      continue;
    else if (name == "camera")
      camera = python::text(value, name);
    else if (name == "crop")
      settings.crop = rect_of(value, name);
    else if (name == "width" || name == "height")
      (name == "width" ? settings.width : settings.height) = length_of(value, name);
    else
      (name == "frame" ? settings.frame : settings.pixel_aspect) = number(value, name);
  }
  settings.camera = door::or_null(camera);
  const std::vector<AlabasterParameter> raw = door::pass(held);
  settings.settings = raw.data(), settings.setting_count = raw.size();
  run([&](const AlabasterApi& api, AlabasterScene* scene) {
    return api.set_render_settings(scene, path.c_str(), &settings);
  });
}

}  // namespace alabaster::python

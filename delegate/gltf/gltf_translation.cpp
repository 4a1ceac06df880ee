#include "delegate/gltf/gltf_translation.h"

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <numeric>

#include "delegate/gltf/gltf_material.h"
#include "delegate/gltf/gltf_vertices.h"
#include "delegate/support/color_space.h"

namespace alabaster::hd::gltf {
namespace {

constexpr size_t kLongestName = 120;

void append_bytes(const void* data, size_t bytes, std::string* key) {
  key->append(static_cast<const char*>(data), bytes);
}

/// `text` with every character that a path must not have replaced by '_'.
std::string clean_name(const std::string& text) {
  std::string name = text;
  if (name.size() > kLongestName) {
    size_t end = kLongestName;  // not inside a UTF-8 sequence
    while (end > 0 && (static_cast<unsigned char>(name[end]) & 0xc0) == 0x80) --end;
    name.resize(end);
  }
  for (char& c : name)
    if (c == '/' || static_cast<unsigned char>(c) <= ' ' || c == 0x7f) c = '_';
  return name;
}

constexpr double kFilmHeight = 0.024, kFilmAspect = 1.5;  // of 35 mm film, in metres
constexpr float kNoFarPlane = 1e30f;
constexpr double kDegrees = 180 / 3.14159265358979323846;

Vec2f clipping_range(double znear, double zfar) {
  return {float(znear), zfar > znear ? float(zfar) : kNoFarPlane};
}

// glTF gives an angle where the contract has a lens: the film is 24 mm high, and the focal length follows from yfov.
// Without an aspectRatio the film is 36 mm wide; vertical framing then agrees with glTF under every window policy that
// keeps the height. Orthographic apertures are twice the magnifications, in metres. Without a far plane
// clippingRange.y is 1e30.
host::CameraDescription translate_camera(const tinygltf::Camera& camera, const Matrix4d& transform) {
  host::CameraDescription description;
  description.transform = transform;
  auto& parameters = description.parameters;
  if (camera.type == "orthographic") {
    const auto& lens = camera.orthographic;
    parameters["projection"] = Token("orthographic");
    parameters["horizontalAperture"] = float(2 * std::abs(lens.xmag));
    parameters["verticalAperture"] = float(2 * std::abs(lens.ymag));
    parameters["clippingRange"] = clipping_range(lens.znear, lens.zfar);
    return description;
  }
  const auto& lens = camera.perspective;
  const double aspect = lens.aspectRatio > 0 ? lens.aspectRatio : kFilmAspect;
  parameters["projection"] = Token("perspective");
  parameters["focalLength"] = float(kFilmHeight / 2 / std::tan(lens.yfov / 2));
  parameters["horizontalAperture"] = float(kFilmHeight * aspect);
  parameters["verticalAperture"] = float(kFilmHeight);
  parameters["clippingRange"] = clipping_range(lens.znear, lens.zfar);
  return description;
}

// KHR_lights_punctual. Photometric values are kept as radiometric ones: the intensity of point and spot lights
// (candela) becomes radiant intensity, and that of directional lights (lux) irradiance; choose the exposure
// accordingly. `range`, a cut-off for game engines, is ignored with a report.
host::LightDescription translate_light(const tinygltf::Light& light, const Matrix4d& transform) {
  host::LightDescription description;
  description.transform = transform;
  auto& parameters = description.parameters;
  parameters["color"] =
      light.color.size() == 3 ? Vec3f(float(light.color[0]), float(light.color[1]), float(light.color[2])) : Vec3f(1);
  parameters[std::string("color") + support::kColorSpace] = Token(support::kLinearRec709);
  parameters["intensity"] = float(light.intensity);
  if (light.type == "directional") {
    description.type = "distantLight";
    parameters["angle"] = 0.0f;
    return description;
  }
  description.type = "sphereLight";
  parameters["treatAsPoint"] = true;
  parameters["radius"] = 0.0f;
  if (light.type == "spot") {
    const double outer = std::clamp(light.spot.outerConeAngle, 0.0, 90 / kDegrees);
    parameters["coneInner"] = float(std::clamp(light.spot.innerConeAngle, 0.0, outer) * kDegrees);
    parameters["coneOuter"] = float(outer * kDegrees);
  }
  return description;
}

}  // namespace

std::string prim_name(size_t index, const std::string& name) {
  std::string text = std::to_string(index);
  if (!name.empty()) text.append("_").append(clean_name(name));
  return text;
}

std::string artist_name(size_t index, const std::string& name) {
  return name.empty() ? std::to_string(index) : clean_name(name);
}

Path root_of(const Document& document) {
  return Path("/gltf").append(clean_name(std::filesystem::path(document.file).stem().string()));
}

SceneTranslator::SceneTranslator(const Document& document, int refine_level)
    : document_(document),
      model_(document.model),
      refine_level_(refine_level),
      root_(root_of(document)),
      tree_(document, document.scene) {
  for (size_t m = 0; m < document.materials.size(); ++m)
    material_paths_.push_back(
        root_.append("materials").append(prim_name(m, document.materials[m].value("name", std::string()))));
  if (!model_.skins.empty()) {
    all_nodes_.emplace(document, -1);
    places_.resize(model_.nodes.size());
    for (size_t i = 0; i < all_nodes_->nodes().size(); ++i) places_[all_nodes_->nodes()[i].index] = i;
  }
  find_users();
  find_what_moves();
}

Path SceneTranslator::child(const char* folder, size_t node) const {
  return root_.append(folder).append(prim_name(node, model_.nodes[node].name));
}

void SceneTranslator::find_users() {
  for (size_t i = 0; i < tree_.nodes().size(); ++i) {
    const PlacedNode& placed = tree_.nodes()[i];
    const tinygltf::Node& node = model_.nodes[placed.index];
    if (node.mesh < 0 || !placed.visible) continue;
    MeshUsers& users = users_[{node.mesh, node.skin}];
    users.mesh = size_t(node.mesh);
    users.skin = node.skin;
    users.nodes.push_back(i);
  }
}

void SceneTranslator::find_what_moves() {
  std::vector<char> morphs(model_.nodes.size(), 0);
  for (const tinygltf::Animation& animation : model_.animations)
    for (const tinygltf::AnimationChannel& channel : animation.channels)
      if (channel.target_path == "weights") morphs[size_t(channel.target_node)] = 1;
  for (auto& [key, users] : users_) {
    const auto any = [&nodes = users.nodes](const auto& is_so) {
      return std::any_of(nodes.begin(), nodes.end(), is_so);
    };
    users.deforms = any([&](size_t i) { return morphs[tree_.nodes()[i].index] != 0; });
    if (users.skin >= 0)
      for (const int joint : model_.skins[size_t(users.skin)].joints)
        users.deforms = users.deforms || all_nodes_->nodes()[places_[size_t(joint)]].moves;
    users.moves = users.deforms || any([&](size_t i) { return tree_.nodes()[i].moves; });
    // Moving them later reads no accessor.
    if (users.moves)
      for (const size_t i : users.nodes) instances_of(tree_.nodes()[i].index);
  }
}

bool SceneTranslator::deforms() const {
  return std::any_of(users_.begin(), users_.end(), [](const auto& entry) { return entry.second.deforms; });
}

void SceneTranslator::add_still_prims(host::SceneEdits* edits, Report& report) {
  const std::vector<VertexColors> vertex_colors = find_vertex_colors(document_);
  for (size_t m = 0; m < document_.materials.size(); ++m)
    edits->set(material_paths_[m], translate_material(document_, m, vertex_colors[m], material_paths_[m], report),
               artist_name(m, document_.materials[m].value("name", std::string())));
  add_views(false, edits);
  for (auto& [key, users] : users_) {
    if (users.moves) continue;
    add_users(users, edits, report);
    users.shapes.clear();
  }
  shared_.clear();
}

void SceneTranslator::add_moving_prims(host::SceneEdits* edits, Report& report) {
  ++calls_;
  tree_.update();
  if (all_nodes_) all_nodes_->update();
  add_views(true, edits);
  for (auto& [key, users] : users_) {
    if (!users.moves) continue;
    add_users(users, edits, report);
    std::erase_if(users.shapes, [this](const auto& entry) { return entry.second.call != calls_; });
  }
  shared_.clear();
}

// Cameras and lights.
void SceneTranslator::add_views(bool moving, host::SceneEdits* edits) const {
  for (const PlacedNode& placed : tree_.nodes()) {
    if (placed.moves != moving) continue;
    const tinygltf::Node& node = model_.nodes[placed.index];
    const std::string name = artist_name(placed.index, node.name);
    if (node.camera >= 0)
      edits->set(child("cameras", placed.index), translate_camera(model_.cameras[size_t(node.camera)], placed.world),
                 name);
    const auto extension = node.extensions.find("KHR_lights_punctual");
    if (!placed.visible || extension == node.extensions.end()) continue;
    const int light = extension->second.Get("light").GetNumberAsInt();
    edits->set(child("lights", placed.index), translate_light(model_.lights[size_t(light)], placed.world), name);
  }
}

void SceneTranslator::add_users(MeshUsers& users, host::SceneEdits* edits, Report& report) {
  std::map<std::vector<double>, MeshUse> uses;
  for (const size_t i : users.nodes) {
    const PlacedNode& placed = tree_.nodes()[i];
    MeshUse& use = uses[morph_weights(model_.nodes[placed.index], model_.meshes[users.mesh])];
    use.nodes.push_back(placed.index);
    for (const Matrix4d& instance : instances_of(placed.index))
      use.placements.push_back(with_thickness(instance * placed.world));
  }
  for (const auto& [weights, use] : uses) add_mesh(users, use, *shape_of(users, weights, report), edits);
}

const std::vector<Matrix4d>& SceneTranslator::instances_of(size_t node) {
  const auto [found, is_new] = instances_.try_emplace(node);
  if (is_new) found->second = instance_transforms(document_, model_.nodes[node]);
  return found->second;
}

// A mesh with several placements becomes one prototype below the first of its nodes, placed by an instancer. A mesh
// that follows a skin is placed by its joints, however many nodes use it.
void SceneTranslator::add_mesh(const MeshUsers& users, const MeshUse& use, const TranslatedMesh& shape,
                               host::SceneEdits* edits) const {
  const std::string name = artist_name(use.nodes[0], model_.nodes[use.nodes[0]].name);
  const Path parent = child("nodes", use.nodes[0]);
  const std::vector<tinygltf::Primitive>& primitives = model_.meshes[users.mesh].primitives;
  const auto material_of = [&](size_t p) {
    return primitives[p].material < 0 ? Path() : material_paths_[size_t(primitives[p].material)];
  };
  host::InstancerDescription instancer;
  for (const MeshPart& part : shape.parts) {
    host::MeshDescription description = part.mesh;
    const size_t first = part.primitives[0];
    const Path id = parent.append((part.primitives.size() > 1 ? "mesh_" : "") + std::to_string(first));
    // The mesh's own material is that of faces without one, which may be a primitive's.
    const bool all_have_one = std::all_of(part.primitives.begin(), part.primitives.end(),
                                          [&](size_t p) { return primitives[p].material >= 0; });
    if (all_have_one) description.material = material_of(first);
    for (size_t i = 0; i < description.topology.geomSubsets.size(); ++i) {
      description.topology.geomSubsets[i].id = parent.append(std::to_string(part.primitives[i]));
      description.topology.geomSubsets[i].materialId = material_of(part.primitives[i]);
    }
    const bool by_skin = users.skin >= 0 && follows_skin(primitives[first]);
    if (!by_skin && use.placements.size() == 1) {
      description.transform = use.placements[0];
    } else if (!by_skin) {
      description.instancer = parent.append("instancer");
      std::vector<int32_t> instances(use.placements.size());
      std::iota(instances.begin(), instances.end(), 0);
      instancer.indices[id] = Array<int32_t>(std::move(instances));
    }
    edits->set(id, std::move(description), name);
  }
  if (instancer.indices.empty()) return;
  instancer.primvars["hydra:instanceTransforms"] = Array<Matrix4d>(use.placements);
  edits->set(parent.append("instancer"), std::move(instancer), name);
}

std::vector<Matrix4d> SceneTranslator::joints_of(const MeshUsers& users) const {
  if (users.skin < 0) return {};
  std::vector<Matrix4d> worlds(model_.nodes.size());
  for (const PlacedNode& node : all_nodes_->nodes()) worlds[node.index] = node.world;
  return joint_matrices(document_, model_.skins[size_t(users.skin)], worlds);
}

SceneTranslator::Shape SceneTranslator::shape_of(MeshUsers& users, const std::vector<double>& weights, Report& report) {
  PrimitiveShape shape{refine_level_, weights, joints_of(users)};
  std::string key = std::to_string(shape.weights.size());
  append_bytes(shape.weights.data(), shape.weights.size() * sizeof(double), &key);
  append_bytes(shape.joint_matrices.data(), shape.joint_matrices.size() * sizeof(Matrix4d), &key);
  const auto [found, is_new] = users.shapes.try_emplace(key);
  if (is_new) found->second.shape = translate(users.mesh, shape, {document_.alike[users.mesh], std::move(key)}, report);
  found->second.call = calls_;
  return found->second.shape;
}

// Meshes that are alike share what is decoded, because the limit of memory counts it once. Their faults are reported
// for each.
SceneTranslator::Shape SceneTranslator::translate(size_t mesh, const PrimitiveShape& shape,
                                                  const std::pair<size_t, std::string>& key, Report& report) {
  Shape& shared = shared_[key];
  if (!shared) shared = std::make_shared<const TranslatedMesh>(translate_mesh(document_, mesh, shape));
  for (const MeshFault& fault : shared->faults)
    report.warning(fault.code, element_name("meshes", mesh) + fault.element, fault.text);
  return shared;
}

}  // namespace alabaster::hd::gltf

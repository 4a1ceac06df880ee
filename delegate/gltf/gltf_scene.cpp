#include "delegate/gltf/gltf_scene.h"

#include <exception>
#include <filesystem>

#include "delegate/gltf/gltf_light_camera.h"
#include "delegate/gltf/gltf_material.h"
#include "delegate/gltf/gltf_mesh.h"
#include "delegate/gltf/gltf_names.h"

namespace alabaster::hd::gltf {
namespace {

// Row vectors (p' = p * M): read row by row, glTF's column-major matrix for column vectors is already transposed.
Matrix4d local_transform(const tinygltf::Node& node) {
  Matrix4d m;
  if (node.matrix.size() == 16) {
    for (size_t i = 0; i < 16; ++i) m[int(i / 4)][int(i % 4)] = i % 4 == 3 ? (i == 15 ? 1.0 : 0.0) : node.matrix[i];
    return m;
  }
  if (node.scale.size() == 3) m.setScale(Imath::V3d(node.scale[0], node.scale[1], node.scale[2]));
  if (node.rotation.size() == 4) {  // x y z w
    const Imath::V3d axis(node.rotation[0], node.rotation[1], node.rotation[2]);
    Imath::Quatd rotation(node.rotation[3], axis);
    if (rotation.length() > 0) m *= rotation.normalized().toMatrix44();
  }
  if (node.translation.size() == 3) {
    Matrix4d translation;
    translation.setTranslation(Imath::V3d(node.translation[0], node.translation[1], node.translation[2]));
    m *= translation;
  }
  return m;
}

struct PlacedNode {
  size_t index = 0;
  Matrix4d world;
};

// The prims of a document, kept apart until all of them are known to be valid.
struct Prims {
  std::map<Path, host::MeshDescription> meshes;
  std::map<Path, host::InstancerDescription> instancers;
  std::map<Path, MaterialNetwork> materials;
  std::map<Path, host::LightDescription> lights;
  std::map<Path, host::CameraDescription> cameras;
};

class SceneTranslator {
 public:
  SceneTranslator(const Document& document, const GltfOptions& options, Report& report)
      : document_(document),
        model_(document.model),
        options_(options),
        report_(report),
        root_(options.root.append("gltf").append(clean_name(std::filesystem::path(document.file).stem().string()))) {}

  Prims run() {
    for (size_t m = 0; m < model_.materials.size(); ++m) {
      material_paths_.push_back(root_.append("materials").append(prim_name(m, model_.materials[m].name)));
      prims_.materials[material_paths_.back()] = translate_material(document_, m, material_paths_.back(), report_);
    }
    std::map<size_t, std::vector<PlacedNode>> users;  // mesh -> nodes
    for (const PlacedNode& placed : placed_nodes()) {
      const tinygltf::Node& node = model_.nodes[placed.index];
      if (node.mesh >= 0) users[size_t(node.mesh)].push_back(placed);
      if (node.camera >= 0)
        prims_.cameras[child("cameras", placed.index)] =
            translate_camera(model_.cameras[size_t(node.camera)], placed.world);
      add_light(node, placed);
    }
    for (const auto& [mesh, nodes] : users) add_mesh(mesh, nodes);
    return std::move(prims_);
  }

 private:
  Path child(const char* folder, size_t node) const {
    return root_.append(folder).append(prim_name(node, model_.nodes[node].name));
  }

  std::vector<size_t> scene_roots() const {
    const int scene = model_.defaultScene >= 0 ? model_.defaultScene : 0;
    std::vector<char> is_child(model_.nodes.size(), 0);
    for (const tinygltf::Node& node : model_.nodes)
      for (const int c : node.children) is_child[size_t(c)] = 1;
    std::vector<size_t> roots, others;
    if (model_.scenes.empty()) {
      for (size_t n = 0; n < model_.nodes.size(); ++n)
        if (!is_child[n]) roots.push_back(n);
      return roots;
    }
    // Child nodes that a scene lists come last: they are used only if their parents are not in the scene.
    for (const int n : model_.scenes[size_t(scene)].nodes) (is_child[size_t(n)] ? others : roots).push_back(size_t(n));
    roots.insert(roots.end(), others.begin(), others.end());
    return roots;
  }

  // Depth first, in the order of the document, each node once.
  std::vector<PlacedNode> placed_nodes() const {
    std::vector<PlacedNode> placed;
    std::vector<char> visited(model_.nodes.size(), 0);
    for (const size_t root : scene_roots()) {
      std::vector<PlacedNode> open = {{root, local_transform(model_.nodes[root]) * options_.transform}};
      while (!open.empty()) {
        const PlacedNode node = open.back();
        open.pop_back();
        if (visited[node.index]) continue;
        visited[node.index] = 1;
        placed.push_back(node);
        const std::vector<int>& children = model_.nodes[node.index].children;
        for (auto c = children.rbegin(); c != children.rend(); ++c)
          open.push_back({size_t(*c), local_transform(model_.nodes[size_t(*c)]) * node.world});
      }
    }
    return placed;
  }

  void add_light(const tinygltf::Node& node, const PlacedNode& placed) {
    const auto extension = node.extensions.find("KHR_lights_punctual");
    if (extension == node.extensions.end()) return;
    const int light = extension->second.Get("light").GetNumberAsInt();
    prims_.lights[child("lights", placed.index)] = translate_light(model_.lights[size_t(light)], placed.world);
  }

  // A mesh used by several nodes becomes one prototype below the first of them, placed by an instancer.
  void add_mesh(size_t index, const std::vector<PlacedNode>& nodes) {
    const Path parent = child("nodes", nodes[0].index);
    const tinygltf::Mesh& mesh = model_.meshes[index];
    host::InstancerDescription instancer;
    std::vector<int32_t> instances;
    for (size_t p = 0; p < mesh.primitives.size(); ++p) {
      const std::string element = element_name(element_name("meshes", index) + ".primitives", p);
      auto description = translate_primitive(document_, mesh.primitives[p], element, options_.refine_level, report_);
      if (!description) continue;
      const Path id = parent.append(std::to_string(p));
      if (mesh.primitives[p].material >= 0)
        description->material = material_paths_[size_t(mesh.primitives[p].material)];
      if (nodes.size() == 1) {
        description->transform = nodes[0].world;
      } else {
        description->instancer = parent.append("instancer");
        instances.clear();
        for (size_t n = 0; n < nodes.size(); ++n) instances.push_back(int32_t(n));
        instancer.indices[id] = Array<int32_t>(instances);
      }
      prims_.meshes[id] = std::move(*description);
    }
    if (instancer.indices.empty()) return;
    std::vector<Matrix4d> transforms;
    for (const PlacedNode& node : nodes) transforms.push_back(node.world);
    instancer.primvars["hydra:instanceTransforms"] = Array<Matrix4d>(std::move(transforms));
    prims_.instancers[parent.append("instancer")] = std::move(instancer);
  }

  const Document& document_;
  const tinygltf::Model& model_;
  const GltfOptions& options_;
  Report& report_;
  const Path root_;
  std::vector<Path> material_paths_;
  Prims prims_;
};

void hand_over(Prims prims, host::RetainedSceneDelegate* scene, GltfSummary* summary) {
  for (auto& [id, material] : prims.materials) {
    summary->materials.push_back(id);
    scene->SetMaterial(id, std::move(material));
  }
  for (auto& [id, instancer] : prims.instancers) scene->SetInstancer(id, std::move(instancer));
  for (auto& [id, mesh] : prims.meshes) {
    summary->meshes.push_back(id);
    scene->SetMesh(id, std::move(mesh));
  }
  for (auto& [id, light] : prims.lights) {
    summary->lights.push_back(id);
    scene->SetLight(id, std::move(light));
  }
  for (auto& [id, camera] : prims.cameras) {
    summary->cameras.push_back(id);
    scene->SetCamera(id, std::move(camera));
  }
}

void load(const std::string& file, const GltfOptions& options, host::RetainedSceneDelegate* scene, Report& report,
          GltfSummary* summary) {
  Document document;
  document.files.push_back(file);
  if (!read_document(file, options.max_file_bytes, report, &document)) return;
  summary->files = document.files;
  summary->extensionsUsed = document.extensionsUsed;
  summary->extensionsRequired = document.extensionsRequired;
  summary->extensionsIgnored = document.extensionsIgnored;
  Prims prims = SceneTranslator(document, options, report).run();
  if (report.failed()) return;
  if (prims.meshes.empty()) report.warning("scene.empty", "", "the scene has nothing to draw");
  hand_over(std::move(prims), scene, summary);
  summary->ok = true;
}

}  // namespace

GltfSummary LoadGltf(const std::string& file, const GltfOptions& options, host::RetainedSceneDelegate* scene,
                     const DiagnosticSink& sink) {
  Report report(file, sink);
  GltfSummary summary;
  try {
    load(file, options, scene, report, &summary);
  } catch (const std::bad_alloc&) {
    report.error("memory", "", "not enough memory; split the file or lower max_file_bytes");
  } catch (const std::exception& e) {
    report.error("internal", "", std::string("reading failed (") + e.what() + "); export the file again");
  }
  report.finish();
  return summary;
}

}  // namespace alabaster::hd::gltf

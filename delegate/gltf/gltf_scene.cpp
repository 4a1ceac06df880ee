#include "delegate/gltf/gltf_scene.h"

#include <algorithm>
#include <exception>
#include <filesystem>
#include <numeric>
#include <tuple>

#include "core/math/float_environment.h"
#include "delegate/gltf/gltf_animation.h"
#include "delegate/gltf/gltf_image_light.h"
#include "delegate/gltf/gltf_light_camera.h"
#include "delegate/gltf/gltf_material.h"
#include "delegate/gltf/gltf_mesh.h"
#include "delegate/gltf/gltf_morph.h"
#include "delegate/gltf/gltf_names.h"
#include "delegate/gltf/gltf_nodes.h"
#include "delegate/gltf/gltf_skin.h"
#include "delegate/gltf/gltf_variants.h"

namespace alabaster::hd::gltf {
namespace {

// A mesh in one shape, and where it is placed.
struct MeshUse {
  size_t mesh = 0;
  int skin = -1;                     // -1: none
  std::vector<double> weights;       // of its morph targets
  std::vector<size_t> nodes;         // that use it
  std::vector<Matrix4d> placements;  // of all their instances
};

// The prims of a document, kept apart until all of them are known to be valid.
struct Prims {
  std::map<Path, host::MeshDescription> meshes;
  std::map<Path, host::InstancerDescription> instancers;
  std::map<Path, MaterialNetwork> materials;
  std::map<Path, host::LightDescription> lights;
  std::map<Path, host::CameraDescription> cameras;
};

Path root_of(const Document& document, const GltfOptions& options) {
  return options.root.append("gltf").append(clean_name(std::filesystem::path(document.file).stem().string()));
}

class SceneTranslator {
 public:
  SceneTranslator(const Document& document, const GltfOptions& options, Report& report)
      : document_(document),
        model_(document.model),
        options_(options),
        report_(report),
        root_(root_of(document, options)) {}

  Prims run() {
    const std::vector<VertexColors> vertex_colors = find_vertex_colors(document_);
    for (size_t m = 0; m < model_.materials.size(); ++m) {
      material_paths_.push_back(root_.append("materials").append(prim_name(m, model_.materials[m].name)));
      prims_.materials[material_paths_.back()] =
          translate_material(document_, m, vertex_colors[m], material_paths_.back(), report_);
    }
    for (const PlacedNode& placed : placed_nodes(document_, options_.transform)) {
      const tinygltf::Node& node = model_.nodes[placed.index];
      if (node.mesh >= 0 && placed.visible) add_use(node, placed);
      if (node.camera >= 0)
        prims_.cameras[child("cameras", placed.index)] =
            translate_camera(model_.cameras[size_t(node.camera)], placed.world);
      if (placed.visible) add_light(node, placed);
    }
    for (const auto& [key, use] : uses_) add_mesh(use);
    return std::move(prims_);
  }

 private:
  Path child(const char* folder, size_t node) const {
    return root_.append(folder).append(prim_name(node, model_.nodes[node].name));
  }

  void add_use(const tinygltf::Node& node, const PlacedNode& placed) {
    const std::vector<double> weights = morph_weights(node, model_.meshes[size_t(node.mesh)]);
    MeshUse& use = uses_[{node.mesh, node.skin, weights}];
    use.mesh = size_t(node.mesh);
    use.skin = node.skin;
    use.weights = weights;
    use.nodes.push_back(placed.index);
    for (const Matrix4d& instance : instance_transforms(document_, node))
      use.placements.push_back(instance * placed.world);
  }

  void add_light(const tinygltf::Node& node, const PlacedNode& placed) {
    const auto extension = node.extensions.find("KHR_lights_punctual");
    if (extension == node.extensions.end()) return;
    const int light = extension->second.Get("light").GetNumberAsInt();
    prims_.lights[child("lights", placed.index)] = translate_light(model_.lights[size_t(light)], placed.world);
  }

  // A mesh with several placements becomes one prototype below the first of its nodes, placed by an instancer. A
  // mesh that follows a skin is placed by its joints, however many nodes use it.
  void add_mesh(const MeshUse& use) {
    const Path parent = child("nodes", use.nodes[0]);
    const tinygltf::Mesh& mesh = model_.meshes[use.mesh];
    PrimitiveShape shape{options_.refine_level, use.weights, {}};
    if (use.skin >= 0) shape.joint_matrices = joint_matrices(document_, model_.skins[size_t(use.skin)], worlds_);
    host::InstancerDescription instancer;
    std::vector<int32_t> instances(use.placements.size());
    std::iota(instances.begin(), instances.end(), 0);
    for (size_t p = 0; p < mesh.primitives.size(); ++p) {
      const std::string element = element_name(element_name("meshes", use.mesh) + ".primitives", p);
      auto description = translate_primitive(document_, mesh.primitives[p], element, shape, report_);
      if (!description) continue;
      const Path id = parent.append(std::to_string(p));
      if (mesh.primitives[p].material >= 0)
        description->material = material_paths_[size_t(mesh.primitives[p].material)];
      if (follows_skin(mesh.primitives[p], shape)) {
        description->transform = options_.transform;
      } else if (use.placements.size() == 1) {
        description->transform = use.placements[0];
      } else {
        description->instancer = parent.append("instancer");
        instancer.indices[id] = Array<int32_t>(instances);
      }
      prims_.meshes[id] = std::move(*description);
    }
    if (instancer.indices.empty()) return;
    instancer.primvars["hydra:instanceTransforms"] = Array<Matrix4d>(use.placements);
    prims_.instancers[parent.append("instancer")] = std::move(instancer);
  }

  const Document& document_;
  const tinygltf::Model& model_;
  const GltfOptions& options_;
  Report& report_;
  const Path root_;
  const std::vector<Matrix4d> worlds_ = world_transforms(model_);  // of all nodes, without options_.transform
  std::vector<Path> material_paths_;
  std::map<std::tuple<int, int, std::vector<double>>, MeshUse> uses_;  // by mesh, skin and weights
  Prims prims_;
};

// The prims at several times, as samples of those at the frame's own.
class MotionSampler {
 public:
  MotionSampler(const GltfOptions& options, Prims* prims) : options_(options), prims_(*prims) {}

  void run(Document* document, Report& report) {
    constexpr int kSamples = 5;
    hold_more(&document->memory, kSamples * document->geometry_bytes, "the geometry over the shutter");
    Report silent({}, {});
    for (int i = 0; i < kSamples; ++i) {
      const double open = options_.shutter_open, length = options_.shutter_close - open;
      const double seconds = open + length * i / (kSamples - 1);
      apply_animation(options_.time.value_or(0) + seconds, document);
      frames_.push_back(seconds * options_.frames_per_second);
      poses_.push_back(SceneTranslator(*document, options_, silent).run());
    }
    for (auto& [id, mesh] : prims_.meshes) {
      sample_transform(id, &Prims::meshes, &mesh, report);
      for (const char* name : {"points", "normals"}) sample_primvar(id, name, &mesh);
    }
    for (auto& [id, camera] : prims_.cameras) sample_transform(id, &Prims::cameras, &camera, report);
    for (auto& [id, instancer] : prims_.instancers) sample_instances(id, &instancer, report);
  }

 private:
  template <class T>
  void sample_transform(const Path& id, std::map<Path, T> Prims::*all, T* prim, Report& report) const {
    TimeSamples<Matrix4d> samples{frames_, {}};
    for (const Prims& pose : poses_) {
      const auto found = (pose.*all).find(id);
      if (found == (pose.*all).end() || !is_placed_alike(found->second, *prim)) return warn(id, report);
      samples.values.push_back(found->second.transform);
    }
    if (changes(samples)) prim->transformSamples = std::move(samples);
  }

  void sample_primvar(const Path& id, const char* name, host::MeshDescription* mesh) const {
    if (!mesh->primvars.contains(name)) return;
    TimeSamples<Value> samples{frames_, {}};
    for (const Prims& pose : poses_) {
      const auto found = pose.meshes.find(id);
      if (found == pose.meshes.end() || !is_placed_alike(found->second, *mesh)) return;
      if (!(found->second.topology == mesh->topology)) return;
      samples.values.push_back(found->second.primvars.at(name).value);
    }
    if (changes(samples)) mesh->primvarSamples[name] = std::move(samples);
  }

  // A mesh may be placed by several nodes, each of which moves by itself.
  void sample_instances(const Path& id, host::InstancerDescription* instancer, Report& report) const {
    const Token name = "hydra:instanceTransforms";
    TimeSamples<Value> samples{frames_, {}};
    for (const Prims& pose : poses_) {
      const auto found = pose.instancers.find(id);
      if (found == pose.instancers.end()) return warn(id, report);
      samples.values.push_back(found->second.primvars.at(name));
    }
    if (changes(samples)) instancer->primvarSamples[name] = std::move(samples);
  }

  // Nodes whose morph weights are equal at one time share a mesh there, which an instancer places.
  static bool is_placed_alike(const host::MeshDescription& a, const host::MeshDescription& b) {
    return a.instancer == b.instancer;
  }
  static bool is_placed_alike(const host::CameraDescription&, const host::CameraDescription&) { return true; }

  static void warn(const Path& id, Report& report) {
    report.warning("motion", id.str(),
                   "is not there, or not by itself, at all times of the shutter; it is drawn without motion blur");
  }

  template <class T>
  static bool changes(const TimeSamples<T>& samples) {
    return std::any_of(samples.values.begin(), samples.values.end(),
                       [&](const T& value) { return !(value == samples.values.front()); });
  }

  const GltfOptions& options_;
  Prims& prims_;
  std::vector<double> frames_;
  std::vector<Prims> poses_;
};

void hand_over(Prims&& prims, host::RetainedSceneDelegate* scene, GltfSummary* summary) {
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
  if (!read_document(file, options, report, &document)) return;
  summary->files = document.files;
  summary->extensionsUsed = document.extensionsUsed;
  summary->extensionsRequired = document.extensionsRequired;
  summary->extensionsIgnored = document.extensionsIgnored;
  summary->scenes = document.scenes;
  summary->variants = document.variants;
  summary->animations = document.animations;
  if (document.animation >= 0) apply_animation(options.time.value_or(0), &document);
  if (document.variant >= 0) apply_variant(size_t(document.variant), &document.model);
  Prims prims = SceneTranslator(document, options, report).run();
  if (document.image_light) {
    const std::string name = "image_" + prim_name(document.image_light->index, document.image_light->name);
    prims.lights[root_of(document, options).append("lights").append(name)] =
        translate_image_light(&document, options.transform, report);
  }
  if (report.failed()) return;
  summary->memory_bytes = document.geometry_bytes;
  if (document.animation >= 0 && options.shutter_close > options.shutter_open)
    MotionSampler(options, &prims).run(&document, report);
  if (prims.meshes.empty()) report.warning("scene.empty", "", "the scene has nothing to draw");
  hand_over(std::move(prims), scene, summary);
  summary->ok = true;
}

}  // namespace

GltfSummary LoadGltf(const std::string& file, const GltfOptions& options, host::RetainedSceneDelegate* scene,
                     const DiagnosticSink& sink) {
  const FloatEnvironment environment;
  Report report(file, sink);
  GltfSummary summary;
  try {
    load(file, options, scene, report, &summary);
  } catch (const MemoryRefused& e) {
    report.error("memory", "", e.what());
  } catch (const std::bad_alloc&) {
    report.error("memory", "", "not enough memory; split the file or lower max_file_bytes");
  } catch (const std::exception& e) {
    report.error("internal", "", std::string("reading failed (") + e.what() + "); export the file again");
  }
  report.finish();
  return summary;
}

}  // namespace alabaster::hd::gltf

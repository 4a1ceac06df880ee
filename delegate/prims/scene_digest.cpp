#include "delegate/prims/scene_digest.h"

#include <tbb/parallel_for.h>

#include "core/light/ies_profile.h"

namespace alabaster::hd::prims {
namespace {

/// Digests of things that are shared, each made once.
template <class T>
using Shared = std::map<const T*, std::string>;

template <class T, class Add>
void digest_all(Shared<T>* shared, const Add& add) {
  shared->erase(nullptr);
  std::vector<typename Shared<T>::value_type*> all;
  for (auto& one : *shared) all.push_back(&one);
  tbb::parallel_for(size_t(0), all.size(), [&](size_t i) {
    Digest digest;
    add(*all[i]->first, &digest);
    all[i]->second = digest.text();
  });
}

template <class... T>
void add(Digest* digest, const T&... parts) {
  (digest->add(parts), ...);
}

template <class Row, class T>
void add_parameters(std::span<const Row> table, const T& object, Digest* digest) {
  for (const Row& parameter : table) std::visit([&](auto member) { digest->add(object.*member); }, parameter.member);
}

void add_mesh(const MeshPrototype& prototype, Digest* digest) {
  const Mesh& mesh = prototype.mesh;
  add(digest, mesh.points, mesh.triangles, mesh.normals, mesh.normal_triangles);
  add(digest, mesh.tangents.values, mesh.tangents.triangles);
  for (const UvSet& uvs : mesh.uv_sets) add(digest, uvs.name.text(), uvs.values, uvs.triangles);
  for (const NamedAttribute& primvar : mesh.primvars) {
    digest->add(primvar.name.text());
    std::visit([&](const auto& attribute) { add(digest, attribute.values, attribute.triangles); }, primvar.values);
  }
  digest->add(mesh.triangle_face);
  for (const MeshPose& pose : mesh.later_poses) add(digest, pose.points, pose.normals);
}

class SceneDigest {
 public:
  explicit SceneDigest(const Translation& translation) : translation_(translation) {
    for (const InstanceDescription& instance : translation.scene.instances) add_shared(instance);
    for (const InstanceArrayDescription& array : translation.scene.arrays) add_shared(array.look);
    for (const auto& [material, unset] : materials_)
      for (const Texture* image : material->images()) images_[image];
    for (const LightParameters& light : translation.scene.lights) images_[light.texture.get()];
    digest_all(&images_, [](const Texture& image, Digest* digest) { image.add_to(digest); });
    digest_all(&meshes_, add_mesh);
    digest_all(&slots_, [](const TriangleSlots& slots, Digest* digest) { digest->add(slots); });
    digest_all(&materials_, [this](const DisneyMaterial& material, Digest* digest) { add_material(material, digest); });
  }

  std::map<std::string, std::string> by_name() const {
    std::map<std::string, Digest> prims;
    for (const InstanceDescription& instance : translation_.scene.instances)
      add_instance(instance, &prims["mesh " + instance.name]);
    for (const InstanceArrayDescription& array : translation_.scene.arrays)
      for (size_t i = 0; i < array.places->size(); ++i)
        if (const auto instance = array.instance(i)) add_instance(*instance, &prims["mesh " + instance->name]);
    std::map<std::string, std::string> digests;
    for (const auto& [name, digest] : prims) digests[name] = digest.text();
    for (const auto& [material, digest] : materials_) {
      std::string& held = digests["material " + material->name];
      held = std::max(held, digest);  // two of a name have the same contents, or the greater stands for both
    }
    for (size_t i = 0; i < translation_.scene.lights.size(); ++i)
      digests["light " + translation_.light_paths[i].str()] = digest_light(translation_.scene.lights[i]);
    return digests;
  }

 private:
  void add_shared(const InstanceDescription& instance) {
    meshes_[instance.prototype.get()];
    slots_[&instance.triangle_slots()];
    for (const auto& material : instance.materials) materials_[material.get()];
  }
  void add_image(const Texture* image, Digest* digest) const { digest->add(image ? images_.at(image) : std::string()); }
  void add_lookup(const TextureLookup& lookup, Digest* digest) const {
    add_image(lookup.image.get(), digest);
    add(digest, lookup.primvar.text(), lookup.fallback, lookup.transform, lookup.scale, lookup.bias, lookup.alpha_scale,
        lookup.alpha_bias);
  }
  void add_material(const DisneyMaterial& material, Digest* digest) const {
    add_parameters(material_parameters(), material.constants, digest);
    for (const MaterialTexture& texture : material.textures) {
      add_lookup(texture.lookup, digest);
      for (const MaterialTexture::Use& use : texture.uses) add(digest, std::string(use.parameter->name), use.channel);
    }
    for (const auto* map : {&material.normal_map, &material.coat_normal_map}) {
      digest->add(map->has_value());
      if (!*map) continue;
      add_lookup(**map, digest);
      add(digest, (*map)->is_bump, (*map)->channel);
    }
  }
  void add_instance(const InstanceDescription& instance, Digest* digest) const {
    add(digest, meshes_.at(instance.prototype.get()), instance.object_to_world, instance.poses);
    if (!instance.ends.empty()) digest->add(instance.ends);
    if (instance.mesh_ends) add(digest, instance.mesh_ends->points[0], instance.mesh_ends->points[1]);
    for (const auto& material : instance.materials) digest->add(material->name);
    add(digest, slots_.at(&instance.triangle_slots()), instance.prim_id, instance.instance_id, instance.subsurface_set,
        instance.options.double_sided, instance.options.camera_cull);
    add_parameters(mesh_parameters(), instance.options, digest);
    if (instance.values)
      for (const UvSetName& name : instance.values->names()) {
        Vec4f numbers(0);
        const int count = instance.values->read(name, static_cast<size_t>(instance.instance_id), &numbers);
        add(digest, name.text(), count, numbers);
      }
    if (instance.category_set != 0) digest->add(translation_.scene.category_sets[instance.category_set]);
    if (instance.light_group != 0) digest->add(translation_.scene.light_groups[instance.light_group - 1]);
  }
  std::string digest_light(const LightParameters& light) const {
    Digest digest;
    add(&digest, light.type, light.light_to_world);
    if (!light.poses.empty()) digest.add(light.poses);
    add_parameters(light_parameters(), light, &digest);
    add(&digest, light.color_of_temperature, light.visible_to_camera);
    for (const uint32_t link : {light.light_link, light.shadow_link})
      if (link != 0)
        digest.add(translation_.categories[link - 1].str());
      else
        digest.add(link);
    if (light.group != 0) digest.add(translation_.scene.light_groups[light.group - 1]);
    add_image(light.texture.get(), &digest);
    if (light.ies) light.ies->add_to(&digest);
    return digest.text();
  }

  const Translation& translation_;
  Shared<Texture> images_;
  Shared<MeshPrototype> meshes_;
  Shared<TriangleSlots> slots_;
  Shared<DisneyMaterial> materials_;
};

}  // namespace

std::map<std::string, std::string> digest_scene(const Translation& translation) {
  constexpr size_t kMostNames = 10000;
  std::map<std::string, std::string> digests = SceneDigest(translation).by_name();
  if (digests.size() <= kMostNames) return digests;
  std::map<std::string, Digest> kinds;
  for (const auto& [name, text] : digests) {
    Digest& kind = kinds["one " + name.substr(0, name.find(' '))];
    kind.add(name);
    kind.add(text);
  }
  digests.clear();
  for (const auto& [kind, digest] : kinds) digests[kind] = digest.text();
  return digests;
}

std::string digest_camera(const CameraParameters& camera) {
  Digest digest;
  add_parameters(camera_parameters(), camera, &digest);
  add(&digest, camera.camera_to_world, camera.clip_near, camera.clip_far, camera.clip_planes, camera.orthographic,
      camera.poses, camera.opens, camera.closes);
  uint32_t member = 0;
  for (const auto* samples : {&camera.focal_lengths, &camera.f_stops, &camera.focus_distances}) {
    if (!samples->values.empty()) add(&digest, member, samples->times, samples->values);
    ++member;
  }
  if (!camera.ends.empty()) digest.add(camera.ends);
  return digest.text();
}

}  // namespace alabaster::hd::prims

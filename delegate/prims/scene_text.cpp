// The translated scene as text: for goldens, and for people who ask what the renderer was given.
#include "core/diagnostics/plain_format.h"
#include "core/light/ies_profile.h"
#include "delegate/prims/scene_translation.h"
#include "delegate/support/parameters.h"
#include "delegate/support/size_text.h"

namespace alabaster::hd::prims {
namespace {

std::string yes_no(bool b) {
  return b ? "yes" : "no";
}

template <class Row, class T>
std::string parameter_lines(std::span<const Row> table, const T& object) {
  std::string text;
  for (const Row& parameter : table)
    text += std::string("  ") + parameter.name + " " + support::get_parameter(parameter, object).to_string() + "\n";
  return text;
}

std::string texture_text(const std::shared_ptr<const Texture>& texture) {
  return texture ? support::size_option(texture->width(), texture->height()) : std::string("none");
}

std::string lookup_text(const TextureLookup& lookup, Channel channel) {
  std::string source = (lookup.image ? texture_text(lookup.image) + " " : "") + lookup.primvar.text();
  if (!(lookup.transform == UvTransform()))
    for (const Vec2f& corner : {Vec2f(0, 0), Vec2f(1, 0), Vec2f(0, 1)})  // where the placement takes them
      source += " " + Value(lookup.transform(corner)).to_string();
  return source + " " + std::string(kTextureOutputs[static_cast<size_t>(channel)]);
}

// A map of normals or heights, or a displacement, with its scale.
std::string map_line(const char* name, const TextureLookup& lookup, Channel channel, const Value& scale) {
  return std::string("  ") + name + " " + lookup_text(lookup, channel) + " scale " + scale.to_string() + "\n";
}
std::string normal_map_line(const char* name, const std::optional<NormalMap>& map) {
  if (!map) return {};
  const Value scale = map->is_bump ? Value(map->scale.r) : Value(Vec3f(map->scale.r, map->scale.g, map->scale.b));
  return map_line(name, *map, map->is_bump ? map->channel : Channel::rgb, scale);
}
std::string displacement_line(const std::optional<Displacement>& moved) {
  constexpr const char* kSpaces[] = {"displacement by normal", "displacement by tangent", "displacement by object"};
  const bool is_height = moved && moved->space == DisplacementSpace::normal;
  return moved ? map_line(kSpaces[static_cast<size_t>(moved->space)], moved->texture,
                          is_height ? moved->channel : Channel::rgb, moved->scale)
               : std::string();
}

std::string material_text(const DisneyMaterial& material) {
  std::string text = parameter_lines(material_parameters(), material.constants);
  for (const MaterialTexture& texture : material.textures)
    for (const MaterialTexture::Use& use : texture.uses)
      text += std::string("  ") + use.parameter->name + " texture " + lookup_text(texture.lookup, use.channel) + "\n";
  const bool is_bump = material.normal_map && material.normal_map->is_bump;
  return text + normal_map_line(is_bump ? "bump" : "normal", material.normal_map) +
         normal_map_line("coatNormal", material.coat_normal_map) + displacement_line(material.displacement);
}

std::string matrix_line(const Matrix4d& m) {
  return "  transform " + Value(m).to_string() + "\n";
}

std::string pose_lines(const std::vector<Matrix4d>& poses) {
  std::string text;
  for (const Matrix4d& pose : poses) text += "  pose " + Value(pose).to_string() + "\n";
  return text;
}

std::string instance_text(const InstanceDescription& instance, const Translation& translation, const Path* materials) {
  const Mesh& mesh = instance.prototype->mesh;
  std::string text = "instance " + instance.name + " prim " + std::to_string(instance.prim_id) + " instance " +
                     std::to_string(instance.instance_id) + "\n" + matrix_line(instance.object_to_world);
  text += pose_lines(instance.poses);
  text += "  mesh points " + std::to_string(mesh.points.size()) + " triangles " +
          std::to_string(mesh.triangles.size()) + " normals " + yes_no(!mesh.normals.empty()) + " uvs " +
          yes_no(!mesh.uv_sets.empty()) + " closed " + yes_no(mesh.closed) + "\n";
  const MeshOptions& options = instance.options;
  if (!options.double_sided) text += "  single-sided\n";
  if (options.camera_cull != CameraCull::none)
    text += options.camera_cull == CameraCull::back ? "  back culled\n" : "  front culled\n";
  for (const auto& row : mesh_parameters())
    if (const Value value = support::get_parameter(row, options);
        !(value == support::get_parameter(row, InstanceDescription().options)))
      text += std::string("  ") + row.name + " " + value.to_string() + "\n";
  if (!instance.subsurface_set.empty()) text += "  subsurfaceSet " + instance.subsurface_set + "\n";
  if (instance.light_group != 0)
    text += "  lightGroup " + translation.scene.light_groups[instance.light_group - 1] + "\n";
  if (instance.values)
    for (const UvSetName& name : instance.values->names()) {
      Vec4f numbers(0);
      instance.values->read(name, static_cast<size_t>(instance.instance_id), &numbers);
      text += "  primvar " + name.text() + " " + Value(numbers).to_string() + "\n";
    }
  if (instance.category_set != 0)
    for (const uint32_t category : translation.scene.category_sets[instance.category_set])
      text += "  category " + translation.categories[category - 1].str() + "\n";
  for (size_t i = 0; i < instance.materials.size(); ++i)
    text += "  material " + std::to_string(i) + " " + (materials[i].empty() ? "default" : materials[i].str()) + "\n";
  return text;
}

std::string sample_lines(const char* name, const alabaster::TimeSamples<float>& samples) {
  std::string text;
  for (size_t i = 0; i < samples.values.size(); ++i)
    text += std::string("  ") + name + " " + Value(samples.values[i]).to_string() + " at " +
            Value(samples.times[i]).to_string() + "\n";
  return text;
}

std::string camera_text(const Path& path, const CameraParameters& camera) {
  return "camera " + path.str() + "\n" + matrix_line(camera.camera_to_world) + pose_lines(camera.poses) +
         "  projection " + (camera.orthographic ? "orthographic" : "perspective") + "\n" +
         parameter_lines(camera_parameters(), camera) + sample_lines("focalLength", camera.focal_lengths) +
         sample_lines("fStop", camera.f_stops) + sample_lines("focusDistance", camera.focus_distances) +
         "  clippingRange " + Value(Vec2f(camera.clip_near, camera.clip_far)).to_string() + "\n" +
         (camera.clip_planes.empty() ? "" : "  clipPlanes " + std::to_string(camera.clip_planes.size()) + "\n");
}

// "named skin: 3 objects, material /m/wax: 2 objects".
std::string subsurface_sets(const Translation& translation) {
  std::map<std::string, size_t> sizes;
  for (const auto& instance : translation.scene.instances)
    if (!instance.subsurface_set.empty()) ++sizes[instance.subsurface_set];
  for (const auto& array : translation.scene.arrays) {
    if (array.look.subsurface_set.empty()) continue;
    for (size_t i = 0; i < array.places->size(); ++i) sizes[array.look.subsurface_set] += array.places->at(i) ? 1 : 0;
  }
  std::string text;
  for (const auto& [name, size] : sizes)
    text += (text.empty() ? "" : ", ") + name + ": " + std::to_string(size) + " objects";
  return text;
}

std::vector<const InstanceDescription*> looks(const Translation& translation) {
  std::vector<const InstanceDescription*> all;
  for (const auto& instance : translation.scene.instances) all.push_back(&instance);
  for (const auto& array : translation.scene.arrays) all.push_back(&array.look);
  return all;
}

std::string first_material(const Translation& translation, bool (*is)(const DisneyMaterial&)) {
  for (const InstanceDescription* instance : looks(translation))
    for (const auto& material : instance->materials)
      if (is(*material)) return "material " + material->name + " of " + instance->name;
  return "";
}

}  // namespace

std::string dump_scene(const Translation& translation, const Records& cameras) {
  std::string text;
  const Path* materials = translation.material_paths.data();
  std::map<std::string, const DisneyMaterial*> used;
  for (const auto& instance : translation.scene.instances) {
    text += instance_text(instance, translation, materials);
    materials += instance.materials.size();
    for (const auto& material : instance.materials) used[material->name] = material.get();
  }
  for (size_t i = 0; i < translation.scene.arrays.size(); ++i) {
    const InstanceArrayDescription& array = translation.scene.arrays[i];
    for (size_t number = 0; number < array.places->size(); ++number)
      if (const auto instance = array.instance(number))
        text += instance_text(*instance, translation, translation.array_materials[i].data());
    for (const auto& material : array.look.materials) used[material->name] = material.get();
  }
  for (const MatteNames& names : translation.scene.mattes)
    text += "mattes of prim " + std::to_string(names.prim_id) + " object " + names.object + " asset " + names.asset +
            " instances " + std::to_string(names.instances) + "\n";
  for (const auto& [name, material] : used) text += "material " + name + "\n" + material_text(*material);
  for (size_t i = 0; i < translation.scene.lights.size(); ++i) {
    const auto& light = translation.scene.lights[i];
    text += std::string(kLightTypes[static_cast<size_t>(light.type)]) + " " + translation.light_paths[i].str() + "\n" +
            matrix_line(light.light_to_world) + pose_lines(light.poses) + parameter_lines(light_parameters(), light) +
            "  texture " + texture_text(light.texture) + "\n";
    if (light.ies) text += "  profile mean " + Value(static_cast<float>(light.ies->mean())).to_string() + "\n";
    if (light.light_link != 0) text += "  lightLink " + translation.categories[light.light_link - 1].str() + "\n";
    if (light.shadow_link != 0) text += "  shadowLink " + translation.categories[light.shadow_link - 1].str() + "\n";
    if (light.group != 0) text += "  lightGroup " + translation.scene.light_groups[light.group - 1] + "\n";
    const Rgb& glow = light.color_of_temperature;
    if (light.enable_color_temperature)
      text += "  color of temperature " + Value(Vec3f(glow.r, glow.g, glow.b)).to_string() + "\n";
  }
  for (const auto& [path, record] : cameras)
    if (const auto* camera = std::any_cast<CameraRecord>(&record)) text += camera_text(path, camera->camera);
  return text;
}

std::string describe_requirements(const SceneSnapshot& snapshot, const Translation& translation) {
  std::string text;
  const auto line = [&](const char* what, bool required, const std::string& reason) {
    text +=
        std::string(what) + ": " + yes_no(required) + (required && !reason.empty() ? " (" + reason + ")" : "") + "\n";
  };
  line("subsurface", snapshot.features.subsurface,
       first_material(translation, [](const DisneyMaterial& m) { return m.scatters(); }));
  const std::string sets = subsurface_sets(translation);
  line("subsurface sets", !sets.empty(), sets);
  line("emissive meshes", snapshot.features.emissive_meshes,
       first_material(translation, [](const DisneyMaterial& m) { return m.emits(); }));
  line("textures", snapshot.features.textures,
       first_material(translation, [](const DisneyMaterial& m) { return !m.textures.empty(); }));
  std::string smooth;
  for (const InstanceDescription* instance : looks(translation))
    if (smooth.empty() && !instance->prototype->mesh.normals.empty()) smooth = instance->name;
  line("smooth normals", !smooth.empty(), smooth);
  text += "instances: " + std::to_string(snapshot.instance_count()) + " of " +
          std::to_string(snapshot.prototypes.size()) + " meshes\n";
  text += "lights: " + std::to_string(snapshot.lights.size()) + "\n";
  return text + plain_format("memory: %.1f MB\n", double(snapshot.memory_bytes) / 1e6);
}

}  // namespace alabaster::hd::prims

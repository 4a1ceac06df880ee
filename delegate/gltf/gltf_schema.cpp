#include "delegate/gltf/gltf_schema.h"

#include <set>

#include "delegate/gltf/gltf_schema_parts.h"

namespace alabaster::hd::gltf {
namespace {

const Schema& accessor_schema() {
  static const Schema indices{{reference("bufferView", "bufferViews", true), integer("byteOffset", 0, 2147483647),
                               integer("componentType", 5121, 5125, true)},
                              {}};
  static const Schema values{{reference("bufferView", "bufferViews", true), integer("byteOffset", 0, 2147483647)}, {}};
  static const Schema sparse{
      {integer("count", 1, 2147483647, true), object("indices", indices, true), object("values", values, true)}, {}};
  static const Schema schema{{text("name"),
                              reference("bufferView", "bufferViews"),
                              integer("byteOffset", 0, kMostInteger),
                              integer("componentType", 5120, 5126, true),
                              {.name = "normalized", .kind = Kind::boolean},
                              integer("count", 1, 2147483647, true),
                              text("type", "|SCALAR|VEC2|VEC3|VEC4|MAT2|MAT3|MAT4|", true),
                              {.name = "max", .kind = Kind::numbers, .max_items = 16},
                              {.name = "min", .kind = Kind::numbers, .max_items = 16},
                              object("sparse", sparse)},
                             {}};
  return schema;
}

const Schema& mesh_schema() {
  static const Schema mapping{{reference("material", "materials", true),
                               {.name = "variants",
                                .kind = Kind::references,
                                .required = true,
                                .target = "extensions.KHR_materials_variants.variants"}},
                              {}};
  static const Schema variants{{objects("mappings", mapping, true)}, {}};
  static const Schema draco{{reference("bufferView", "bufferViews", true), object("attributes", kMarker, true)}, {}};
  static const Schema primitive{
      {{.name = "attributes", .kind = Kind::reference_map, .required = true, .target = "accessors"},
       reference("indices", "accessors"),
       reference("material", "materials"),
       integer("mode", 0, 6),
       {.name = "targets", .kind = Kind::reference_map, .target = "accessors", .schema = &kMarker}},
      {object("FB_ngon_encoding", kMarker), object("KHR_draco_mesh_compression", draco),
       object("KHR_materials_variants", variants)}};
  static const Schema schema{
      {text("name"), objects("primitives", primitive, true), {.name = "weights", .kind = Kind::numbers}}, {}};
  return schema;
}

const Schema& node_schema() {
  static const Schema light{{reference("light", "extensions.KHR_lights_punctual.lights", true)}, {}};
  static const Schema visibility{{{.name = "visible", .kind = Kind::boolean}}, {}};
  static const Schema instancing{
      {{.name = "attributes", .kind = Kind::reference_map, .required = true, .target = "accessors"}}, {}};
  static const Schema schema{{text("name"),
                              reference("camera", "cameras"),
                              reference("mesh", "meshes"),
                              reference("skin", "skins"),
                              {.name = "children", .kind = Kind::references, .target = "nodes"},
                              numbers("matrix", 16),
                              numbers("translation", 3),
                              numbers("rotation", 4),
                              numbers("scale", 3),
                              {.name = "weights", .kind = Kind::numbers}},
                             {object("KHR_lights_punctual", light), object("EXT_mesh_gpu_instancing", instancing),
                              object("KHR_node_visibility", visibility)}};
  return schema;
}

const Schema& camera_schema() {
  constexpr double kTiny = std::numeric_limits<double>::min();
  static const Schema perspective{
      {{.name = "yfov", .kind = Kind::number, .required = true, .minimum = kTiny, .maximum = 3.14159265},
       {.name = "znear", .kind = Kind::number, .required = true, .minimum = kTiny},
       {.name = "zfar", .kind = Kind::number, .minimum = kTiny},
       {.name = "aspectRatio", .kind = Kind::number, .minimum = kTiny}},
      {}};
  static const Schema orthographic{{{.name = "xmag", .kind = Kind::number, .required = true},
                                    {.name = "ymag", .kind = Kind::number, .required = true},
                                    {.name = "znear", .kind = Kind::number, .required = true, .minimum = 0},
                                    {.name = "zfar", .kind = Kind::number, .required = true, .minimum = kTiny}},
                                   {}};
  static const Schema schema{{text("name"), text("type", "|perspective|orthographic|", true),
                              object("perspective", perspective), object("orthographic", orthographic)},
                             {}};
  return schema;
}

const Schema& animation_schema() {
  static const Schema target{{reference("node", "nodes"), text("path", nullptr, true)},
                             {object("KHR_animation_pointer", kMarker)}};
  static const Schema channel{{integer("sampler", 0, kMostInteger, true), object("target", target, true)}, {}};
  static const Schema sampler{{reference("input", "accessors", true), reference("output", "accessors", true),
                               text("interpolation", "|LINEAR|STEP|CUBICSPLINE|")},
                              {}};
  static const Schema schema{{text("name"), objects("channels", channel, true), objects("samplers", sampler, true)},
                             {}};
  return schema;
}

const Schema& lights_schema() {
  static const Schema spot{{factor("innerConeAngle", 0, 1.5707964), factor("outerConeAngle", 0, 1.5707964)}, {}};
  static const Schema light{{text("name"), text("type", "|point|spot|directional|", true), color("color", 1),
                             factor("intensity", 0, kInfinity), factor("range", 0, kInfinity), object("spot", spot)},
                            {}};
  static const Schema schema{{objects("lights", light, true)}, {}};
  return schema;
}

// The nested arrays, irradianceCoefficients and specularImages, are checked where they are read.
const Schema& image_lights_schema() {
  static const Schema light{{text("name"), numbers("rotation", 4), factor("intensity", 0, kInfinity),
                             integer("specularImageSize", 1, 4096, true)},
                            {}};
  static const Schema schema{{objects("lights", light, true)}, {}};
  return schema;
}

}  // namespace

const Schema& document_schema() {
  static const Schema asset{{text("version", nullptr, true), text("minVersion"), text("generator"), text("copyright")},
                            {}};
  static const Schema fallback{{{.name = "fallback", .kind = Kind::boolean}}, {}};
  static const Schema buffer{{text("name"), text("uri"), integer("byteLength", 1, kMostInteger, true)},
                             {object("EXT_meshopt_compression", fallback)}};
  static const Schema meshopt{
      {reference("buffer", "buffers", true), integer("byteOffset", 0, kMostInteger),
       integer("byteLength", 1, kMostInteger, true), integer("byteStride", 1, 256, true),
       integer("count", 1, 2147483647, true), text("mode", "|ATTRIBUTES|TRIANGLES|INDICES|", true),
       text("filter", "|NONE|OCTAHEDRAL|QUATERNION|EXPONENTIAL|")},
      {}};
  static const Schema view{
      {text("name"), reference("buffer", "buffers", true), integer("byteOffset", 0, kMostInteger),
       integer("byteLength", 1, kMostInteger, true), integer("byteStride", 1, 2147483647), integer("target", 0, 65535)},
      {object("EXT_meshopt_compression", meshopt)}};
  static const Schema image{{text("name"), text("uri"), text("mimeType"), reference("bufferView", "bufferViews")}, {}};
  static const Schema sampler{{text("name"), integer("magFilter", 0, 65535), integer("minFilter", 0, 65535),
                               integer("wrapS", 0, 65535), integer("wrapT", 0, 65535)},
                              {}};
  static const Schema other_source{{reference("source", "images")}, {}};
  static const Schema texture{{text("name"), reference("sampler", "samplers"), reference("source", "images")},
                              {object("EXT_texture_webp", other_source), object("KHR_texture_basisu", other_source)}};
  static const Schema image_light{{reference("light", "extensions.EXT_lights_image_based.lights", true)}, {}};
  static const Schema scene{{text("name"), {.name = "nodes", .kind = Kind::references, .target = "nodes"}},
                            {object("EXT_lights_image_based", image_light)}};
  static const Schema skin{{text("name"),
                            reference("inverseBindMatrices", "accessors"),
                            reference("skeleton", "nodes"),
                            {.name = "joints", .kind = Kind::references, .required = true, .target = "nodes"}},
                           {}};
  static const Schema variant{{text("name", nullptr, true)}, {}};
  static const Schema variants{{objects("variants", variant, true)}, {}};
  static const Schema schema{
      {object("asset", asset, true), objects("buffers", buffer), objects("bufferViews", view),
       objects("accessors", accessor_schema()), objects("meshes", mesh_schema()), objects("nodes", node_schema()),
       objects("scenes", scene), reference("scene", "scenes"), objects("materials", material_schema()),
       objects("textures", texture), objects("images", image), objects("samplers", sampler),
       objects("cameras", camera_schema()), objects("skins", skin), objects("animations", animation_schema())},
      {object("EXT_lights_image_based", image_lights_schema()), object("KHR_lights_punctual", lights_schema()),
       object("KHR_materials_variants", variants)}};
  return schema;
}

namespace {

void add_extension_names(const Schema& schema, std::set<std::string>* names) {
  for (const Property& extension : schema.extensions) {
    names->insert(extension.name);
    add_extension_names(*extension.schema, names);
  }
  for (const Property& property : schema.properties)
    if (property.schema) add_extension_names(*property.schema, names);
}

}  // namespace

bool knows_extension(const std::string& name) {
  static const std::set<std::string> names = [] {
    std::set<std::string> all;
    add_extension_names(document_schema(), &all);
    return all;
  }();
  return names.contains(name);
}

bool reads_extension(const std::string& name) {
  // Those that have no place of their own: KHR_xmp is metadata, of which the picture has nothing.
  static const std::set<std::string> anywhere = {"KHR_mesh_quantization", "KHR_xmp", "KHR_xmp_json_ld"};
  static const std::set<std::string> refused = {"KHR_animation_pointer", "KHR_texture_basisu"};
  return anywhere.contains(name) || (knows_extension(name) && !refused.contains(name));
}

}  // namespace alabaster::hd::gltf

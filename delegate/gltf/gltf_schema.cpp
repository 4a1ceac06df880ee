#include "delegate/gltf/gltf_schema.h"

#include <set>

namespace alabaster::hd::gltf {
namespace {

constexpr double kMostInteger = 9007199254740992.0;  // 2^53: every integer below is exact in JSON's numbers

Property reference(const char* name, const char* target, bool required = false) {
  return {.name = name, .kind = Kind::reference, .required = required, .target = target};
}
Property object(const char* name, const Schema& schema, bool required = false) {
  return {.name = name, .kind = Kind::object, .required = required, .schema = &schema};
}
Property objects(const char* name, const Schema& schema, bool required = false) {
  return {.name = name, .kind = Kind::objects, .required = required, .schema = &schema};
}
Property integer(const char* name, double minimum, double maximum, bool required = false) {
  return {.name = name, .kind = Kind::integer, .required = required, .minimum = minimum, .maximum = maximum};
}
Property text(const char* name, const char* choices = nullptr, bool required = false) {
  return {.name = name, .kind = Kind::text, .required = required, .target = choices};
}
// A factor of a material or light; values out of range are clamped.
Property factor(const char* name, double minimum, double maximum) {
  return {.name = name, .kind = Kind::number, .minimum = minimum, .maximum = maximum, .harmless = true};
}
Property color(const char* name, double maximum, size_t items = 3) {
  return {.name = name,
          .kind = Kind::numbers,
          .minimum = 0,
          .maximum = maximum,
          .min_items = items,
          .max_items = items,
          .harmless = true};
}
Property numbers(const char* name, size_t items) {
  return {.name = name, .kind = Kind::numbers, .min_items = items, .max_items = items};
}

constexpr double kInfinity = std::numeric_limits<double>::infinity();
const Schema kMarker{};  // an extension whose content is not checked

const Schema& texture_info_schema() {
  static const Schema transform{{numbers("offset", 2),
                                 {.name = "rotation", .kind = Kind::number},
                                 numbers("scale", 2),
                                 integer("texCoord", 0, 1000)},
                                {}};
  static const Schema schema{{reference("index", "textures", true),
                              integer("texCoord", 0, 1000),
                              {.name = "scale", .kind = Kind::number},
                              {.name = "strength", .kind = Kind::number}},
                             {object("KHR_texture_transform", transform)}};
  return schema;
}

const Schema& material_schema() {
  const Schema& texture = texture_info_schema();
  static const Schema pbr{
      {color("baseColorFactor", 1, 4), object("baseColorTexture", texture), factor("metallicFactor", 0, 1),
       factor("roughnessFactor", 0, 1), object("metallicRoughnessTexture", texture)},
      {}};
  static const Schema ior{{factor("ior", 0, kInfinity)}, {}};
  static const Schema specular{{factor("specularFactor", 0, 1), object("specularTexture", texture),
                                color("specularColorFactor", kInfinity), object("specularColorTexture", texture)},
                               {}};
  static const Schema clearcoat{
      {factor("clearcoatFactor", 0, 1), object("clearcoatTexture", texture), factor("clearcoatRoughnessFactor", 0, 1),
       object("clearcoatRoughnessTexture", texture), object("clearcoatNormalTexture", texture)},
      {}};
  static const Schema sheen{{color("sheenColorFactor", 1), object("sheenColorTexture", texture),
                             factor("sheenRoughnessFactor", 0, 1), object("sheenRoughnessTexture", texture)},
                            {}};
  static const Schema strength{{factor("emissiveStrength", 0, kInfinity)}, {}};
  static const Schema volume{
      {factor("thicknessFactor", 0, kInfinity), object("thicknessTexture", texture),
       factor("attenuationDistance", std::numeric_limits<double>::min(), kInfinity), color("attenuationColor", 1)},
      {}};
  static const Schema scatter{{color("multiscatterColor", 1), color("multiscatterColorFactor", 1),
                               object("multiscatterColorTexture", texture), factor("scatterAnisotropy", -1, 1)},
                              {}};
  static const Schema diffuse{
      {factor("diffuseTransmissionFactor", 0, 1), object("diffuseTransmissionTexture", texture),
       color("diffuseTransmissionColorFactor", 1), object("diffuseTransmissionColorTexture", texture)},
      {}};
  static const Schema disney{{object("baseColorTexture", texture), object("scatterDistanceTexture", texture)}, {}};
  static const Schema schema{
      {text("name"),
       object("pbrMetallicRoughness", pbr),
       object("normalTexture", texture),
       object("occlusionTexture", texture),
       object("emissiveTexture", texture),
       color("emissiveFactor", 1),
       text("alphaMode", "|OPAQUE|MASK|BLEND|"),
       factor("alphaCutoff", 0, kInfinity),
       {.name = "doubleSided", .kind = Kind::boolean}},
      {object("KHR_materials_ior", ior), object("KHR_materials_specular", specular),
       object("KHR_materials_clearcoat", clearcoat), object("KHR_materials_sheen", sheen),
       object("KHR_materials_emissive_strength", strength), object("KHR_materials_volume", volume),
       object("KHR_materials_volume_scatter", scatter), object("KHR_materials_diffuse_transmission", diffuse),
       object("ALAB_materials_disney", disney), object("KHR_materials_transmission", kMarker),
       object("KHR_materials_anisotropy", kMarker), object("KHR_materials_dispersion", kMarker),
       object("KHR_materials_iridescence", kMarker), object("KHR_materials_pbrSpecularGlossiness", kMarker),
       object("KHR_materials_unlit", kMarker)}};
  return schema;
}

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
                               {.name = "variants", .kind = Kind::references, .required = true, .target = "variants"}},
                              {}};
  static const Schema variants{{objects("mappings", mapping, true)}, {}};
  static const Schema primitive{
      {{.name = "attributes", .kind = Kind::reference_map, .required = true, .target = "accessors"},
       reference("indices", "accessors"),
       reference("material", "materials"),
       integer("mode", 0, 6),
       {.name = "targets", .kind = Kind::reference_map, .target = "accessors", .schema = &kMarker}},
      {object("FB_ngon_encoding", kMarker), object("KHR_draco_mesh_compression", kMarker),
       object("KHR_materials_variants", variants)}};
  static const Schema schema{
      {text("name"), objects("primitives", primitive, true), {.name = "weights", .kind = Kind::numbers}}, {}};
  return schema;
}

const Schema& node_schema() {
  static const Schema light{{reference("light", "lights", true)}, {}};
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
                              object("KHR_node_visibility", kMarker)}};
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

}  // namespace

const Schema& document_schema() {
  static const Schema asset{{text("version", nullptr, true), text("minVersion"), text("generator"), text("copyright")},
                            {}};
  static const Schema buffer{{text("name"), text("uri"), integer("byteLength", 1, kMostInteger, true)},
                             {object("EXT_meshopt_compression", kMarker)}};
  static const Schema view{
      {text("name"), reference("buffer", "buffers", true), integer("byteOffset", 0, kMostInteger),
       integer("byteLength", 1, kMostInteger, true), integer("byteStride", 1, 2147483647), integer("target", 0, 65535)},
      {object("EXT_meshopt_compression", kMarker)}};
  static const Schema image{{text("name"), text("uri"), text("mimeType"), reference("bufferView", "bufferViews")}, {}};
  static const Schema sampler{{text("name"), integer("magFilter", 0, 65535), integer("minFilter", 0, 65535),
                               integer("wrapS", 0, 65535), integer("wrapT", 0, 65535)},
                              {}};
  static const Schema other_source{{reference("source", "images")}, {}};
  static const Schema texture{{text("name"), reference("sampler", "samplers"), reference("source", "images")},
                              {object("EXT_texture_webp", other_source), object("KHR_texture_basisu", other_source)}};
  static const Schema scene{{text("name"), {.name = "nodes", .kind = Kind::references, .target = "nodes"}}, {}};
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
      {object("KHR_lights_punctual", lights_schema()), object("KHR_materials_variants", variants)}};
  return schema;
}

bool reads_extension(const std::string& name) {
  static const std::set<std::string> names = {"ALAB_materials_disney",
                                              "EXT_mesh_gpu_instancing",
                                              "FB_ngon_encoding",
                                              "KHR_lights_punctual",
                                              "KHR_materials_clearcoat",
                                              "KHR_materials_diffuse_transmission",
                                              "KHR_materials_emissive_strength",
                                              "KHR_materials_ior",
                                              "KHR_materials_sheen",
                                              "KHR_materials_specular",
                                              "KHR_materials_variants",
                                              "KHR_materials_volume",
                                              "KHR_materials_volume_scatter",
                                              "KHR_mesh_quantization",
                                              "KHR_texture_transform"};
  return names.count(name) > 0;
}

}  // namespace alabaster::hd::gltf

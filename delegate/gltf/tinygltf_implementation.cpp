// The only translation unit with tinygltf's code, reduced to parsing: without file access, image decoding and Draco.
// The input has already been checked (gltf_document.cpp).
#include <fstream>  // tiny_gltf.h does not include it if TINYGLTF_NO_FS is set

#define TINYGLTF_IMPLEMENTATION
#include "delegate/gltf/tinygltf_model.h"

namespace tinygltf {
namespace {

using Json = nlohmann::json;

constexpr bool kKeepText = false;  // of extras and extensions

// ParseMesh has more parameters in tinygltf 2.9 than in 2.7.
template <class T>
bool parse_mesh(T* mesh, Model* model, std::string* errors, const Json& json) {
  if constexpr (requires { ParseMesh(mesh, model, errors, json, kKeepText); }) {
    return ParseMesh(mesh, model, errors, json, kKeepText);
  } else {
    std::string warnings;
    return ParseMesh(mesh, model, errors, &warnings, json, kKeepText, {});
  }
}

// Adds an element for each of the array `object`[name], which may be absent.
template <class T, class Parse>
bool parse_all(const Json& object, const char* name, std::vector<T>* all, const Parse& parse) {
  const auto array = object.find(name);
  if (array == object.end()) return true;
  all->reserve(array->size());
  for (const Json& json : *array)
    if (!parse(&all->emplace_back(), json)) return false;
  return true;
}

bool parse_scene(Scene* scene, std::string* errors, const Json& json) {
  ParseStringProperty(&scene->name, errors, json, "name", false);
  ParseIntegerArrayProperty(&scene->nodes, errors, json, "nodes", false);
  return true;
}

bool parse_lights(const Json& root, std::string* errors, Model* model) {
  const Json::json_pointer place("/extensions/KHR_lights_punctual");
  return !root.contains(place) || parse_all(root[place], "lights", &model->lights, [&](Light* light, const Json& json) {
    return ParseLight(light, errors, json, kKeepText);
  });
}

}  // namespace

bool parse_checked(const Json& root, Model* model, std::string* errors) {
  const auto all = [&](const char* name, auto* array, const auto& parse) {
    return parse_all(root, name, array,
                     [&](auto* one, const Json& json) { return parse(one, errors, json, kKeepText); });
  };
  return parse_all(root, "meshes", &model->meshes,
                   [&](Mesh* mesh, const Json& json) { return parse_mesh(mesh, model, errors, json); }) &&
         all("nodes", &model->nodes, ParseNode) &&
         parse_all(root, "scenes", &model->scenes,
                   [&](Scene* scene, const Json& json) { return parse_scene(scene, errors, json); }) &&
         parse_all(
             root, "textures", &model->textures,
             [&](Texture* texture, const Json& json) { return ParseTexture(texture, errors, json, kKeepText, ""); }) &&
         all("animations", &model->animations, ParseAnimation) && all("skins", &model->skins, ParseSkin) &&
         all("samplers", &model->samplers, ParseSampler) && all("cameras", &model->cameras, ParseCamera) &&
         parse_lights(root, errors, model);
}

}  // namespace tinygltf

// tinygltf, reduced to its plain structs and a parser of checked JSON, without file or image access.
#pragma once

#include <unistd.h>  // tiny_gltf.h uses it without including it

#include <nlohmann/json.hpp>

#define TINYGLTF_NO_STB_IMAGE
#define TINYGLTF_NO_STB_IMAGE_WRITE
#define TINYGLTF_NO_EXTERNAL_IMAGE
#define TINYGLTF_NO_FS
#include <tiny_gltf.h>

namespace tinygltf {

/// Adds the meshes, nodes, scenes, textures, animations, skins, samplers, cameras and lights of a document
/// whose indices and types have been checked. False and `errors` if tinygltf refuses it.
bool parse_checked(const nlohmann::json& root, Model* model, std::string* errors);

}  // namespace tinygltf

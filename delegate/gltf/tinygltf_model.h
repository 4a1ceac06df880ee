// tinygltf, reduced to a parser of checked JSON text into plain structs, without file or image access.
#pragma once

#include <unistd.h>  // tiny_gltf.h uses it without including it

#define TINYGLTF_NO_STB_IMAGE
#define TINYGLTF_NO_STB_IMAGE_WRITE
#define TINYGLTF_NO_EXTERNAL_IMAGE
#define TINYGLTF_NO_FS
#include <tiny_gltf.h>

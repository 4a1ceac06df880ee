// The only translation unit with tinygltf's code, reduced to parsing: without file access, image decoding and Draco.
// The input has already been checked (gltf_document.cpp).
#include <fstream>  // tiny_gltf.h does not include it if TINYGLTF_NO_FS is set

#define TINYGLTF_IMPLEMENTATION
#include "delegate/gltf/tinygltf_model.h"

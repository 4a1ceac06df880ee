// The one translation unit that carries tinygltf's code: parsing alone. Files, image decoding and Draco stay out;
// what it is given has been checked whole before (gltf_document.cpp).
#include <fstream>  // tiny_gltf.h forgets it when TINYGLTF_NO_FS is set

#define TINYGLTF_IMPLEMENTATION
#include "delegate/gltf/tinygltf_model.h"

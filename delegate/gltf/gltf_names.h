// Names of prims, made from a document's names.
#pragma once

#include <string>

namespace alabaster::hd::gltf {

/// The name of a prim, "3_name" or "3": unique within its array and without '/', blanks and control characters.
std::string prim_name(size_t index, const std::string& name);
/// `text` with every character that a path must not have replaced by '_'.
std::string clean_name(const std::string& text);

}  // namespace alabaster::hd::gltf

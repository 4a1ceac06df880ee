// Names of prims, made from a document's names, and names of Disney parameters in a document.
#pragma once

#include <string>

namespace alabaster::hd::gltf {

/// The name of a prim, "3_name" or "3": unique within its array and without '/', blanks and control characters.
std::string prim_name(size_t index, const std::string& name);
/// `text` with every character that a path must not have replaced by '_'.
std::string clean_name(const std::string& text);

/// 3 for a colour, 1 for a number, 0 for a name that is not a parameter of the node AlabasterDisney.
int disney_parameter_components(const std::string& name);
/// The known parameter with the fewest edits from `name`.
std::string nearest_disney_parameter(const std::string& name);

}  // namespace alabaster::hd::gltf

// The structure of a glTF document as data: the type and range of every property, and the array that every index refers
// to. Source: glTF 2.0 specification, chapter 5, and the specifications of the extensions.
#pragma once

#include <limits>

#include "delegate/gltf/gltf_container.h"

namespace alabaster::hd::gltf {

enum class Kind { boolean, integer, number, numbers, text, object, objects, reference, references, reference_map };

struct Schema;

struct Property {
  const char* name;
  Kind kind;
  bool required = false;
  double minimum = -std::numeric_limits<double>::infinity();  // of a number, of each of `numbers`
  double maximum = std::numeric_limits<double>::infinity();
  size_t min_items = 1, max_items = std::numeric_limits<size_t>::max();
  bool harmless = false;         // a value out of range is only a warning; the nearest legal one is used
  const char* target = nullptr;  // the array that references refer to ("meshes"), or the choices of a text, "|a|b|c|"
  const Schema* schema = nullptr;
};

struct Schema {
  std::vector<Property> properties;
  std::vector<Property> extensions;  // by extension name; all of Kind::object
};

const Schema& document_schema();

/// True for extensions that have a place in the schema.
bool knows_extension(const std::string& name);
/// True for extensions that affect the picture; all others are listed in `extensionsIgnored`.
bool reads_extension(const std::string& name);

/// Checks structure, types, ranges and every reference of the document's own arrays. Integral floats ("2.0") become
/// integers, and harmless values out of range the nearest legal ones. Fatal faults are errors; empty arrays, misplaced
/// or undeclared extensions are warnings.
void check_structure(Json& root, Report& report);

}  // namespace alabaster::hd::gltf

// The shape of a glTF document as data: which property is of which type and range, and what every index refers to.
// Source: glTF 2.0 specification, chapter 5, and the texts of the extensions named.
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
  bool harmless = false;         // a value out of range is a warning: the translation takes the nearest legal one
  const char* target = nullptr;  // of references: the array referred to; of text: the choices, "|a|b|c|"
  const Schema* schema = nullptr;
};

struct Schema {
  std::vector<Property> properties;
  std::vector<Property> extensions;  // by extension name; all of Kind::object
};

const Schema& document_schema();

/// Extensions whose meaning reaches the picture; every other is named in `extensionsIgnored`.
bool reads_extension(const std::string& name);

/// Checks structure, types, ranges and every reference of the document's own arrays. Integral floats ("2.0") become
/// integers. Fatal faults are errors; empty arrays, misplaced or undeclared extensions are warnings.
void check_structure(Json& root, Report& report);

}  // namespace alabaster::hd::gltf

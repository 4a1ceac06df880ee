// Fields of prims from Python's arguments. Internal to this room.
#pragma once

#include "delegate/python/objects.h"

namespace alabaster::python {

/// The field that an argument sets: "double_sided" is doubleSided, and arguments that are short forms have names of
/// their own ("motion"). Names with a colon or a dot stay as they are.
std::string field_name(const std::string& argument);

/// Adds a field for each entry of a dict. The type of a field decides how its value is read, and errors name the
/// argument. A Primvar adds the fields of its interpolation, indices, role and motion, too. `kind` is empty where the
/// prim is not known.
void add_fields(const std::string& kind, py::handle values, const std::string& name, c_api::Parameters* fields);

}  // namespace alabaster::python

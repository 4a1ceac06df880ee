// Fields of prims (alabaster_types.h) from Python's arguments. Internal to this room.
#pragma once

#include "delegate/python/objects.h"

namespace alabaster::python {

/// "double_sided" is the field doubleSided; names with a colon or a dot stay as they are.
std::string field_name(const std::string& argument);

/// Adds the field of that name. A Primvar adds those of its interpolation, indices, role and motion, too. `argument`:
/// its name in errors.
void add_field(const std::string& name, const py::object& value, const std::string& argument,
               c_api::Parameters* fields);

/// Adds a field for each entry.
void add_fields(py::handle values, const std::string& argument, c_api::Parameters* fields);

/// "primvars:NAME" and its suffixes. `of_mesh`: instancers have no suffix but :samples.
void add_primvar(const std::string& name, const Primvar& primvar, const std::string& argument, bool of_mesh,
                 c_api::Parameters* fields);

/// transform, motion, and parameters by name.
c_api::Parameters camera_fields(py::handle options);

}  // namespace alabaster::python

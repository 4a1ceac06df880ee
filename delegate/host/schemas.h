// Files that are written from the tables of parameters and fields: schemas, pages of the manual, part of Python's stub.
#pragma once

#include <map>
#include <string>

#include "delegate/api/export.h"

namespace alabaster::hd::host {

/// The texts of the schemas that are written from tables, by their names: disney_material, mesh, lights, camera and
/// render_settings.
ALABASTER_API std::map<std::string, std::string> TableSchemas();

/// The texts of these files, by their paths in the sources: the schemas disney_material, mesh, lights, camera and
/// render_settings, delegate/manual/parameters and delegate/python/hdalabaster/_fields.pyi.
ALABASTER_API std::map<std::string, std::string> TableFiles();

/// `text`, a schema that is written by hand, with its list of AOVs, and with all parameters of each table that it
/// refers to: a run of lines that are `"NAME": {"$ref": "TABLE.json#/properties/NAME"}` is replaced by the lines of all
/// parameters of the table.
ALABASTER_API std::string WithTables(const std::string& text);

}  // namespace alabaster::hd::host

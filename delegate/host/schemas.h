// schemas/*.json from the tables of parameters.
#pragma once

#include <string>
#include <vector>

#include "delegate/api/export.h"

namespace alabaster::hd::host {

/// The schemas that are made of tables: disney_material, lights, camera, render_settings.
ALABASTER_API std::vector<std::string> TableSchemas();

/// The text of such a schema, as schemas/NAME.json has it.
ALABASTER_API std::string SchemaOfTable(const std::string& name);

/// `text`, a schema that is written by hand, with all parameters of each table that it refers to: a run of lines that
/// are `"NAME": {"$ref": "TABLE.json#/properties/NAME"}` is replaced by the lines of all parameters of the table.
ALABASTER_API std::string WithTableReferences(const std::string& text);

}  // namespace alabaster::hd::host

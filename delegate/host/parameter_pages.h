// Files that are written from the tables of parameters and fields: pages of the manual, part of Python's stub.
#pragma once

#include <map>
#include <string>

#include "delegate/api/export.h"

namespace alabaster::hd::host {

/// The texts of delegate/manual/parameters and delegate/python/hdalabaster/_fields.pyi, by their paths in the sources.
ALABASTER_API std::map<std::string, std::string> ParameterPages();

}  // namespace alabaster::hd::host

// Programs that lie beside this one and run in its place.
#pragma once

#include <string>

namespace alabaster::cli {

/// The file `name` in the folder of this program; empty if there is none.
std::string program_beside(const char* name);

/// Runs `program` in the place of this one. `arguments` begin with the name of the program and end with null. Returns
/// only if that fails, after a report, with the exit code.
int run_beside(const std::string& program, char* const* arguments);

}  // namespace alabaster::cli

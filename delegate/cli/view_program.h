// The program of the window.
#pragma once

#include <string>

namespace alabaster::cli {

/// The file alabaster-view beside this program; empty if there is none.
std::string view_program();

}  // namespace alabaster::cli

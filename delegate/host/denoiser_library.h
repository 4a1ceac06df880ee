// Open Image Denoise as the library finds it at run time.
#pragma once

#include <string>

#include "delegate/api/export.h"

namespace alabaster::hd::host {

/// Empty if AOV `denoised` can be rendered; else the reason and the remedy, in sentences. Loads the library, which
/// takes milliseconds. Any thread.
ALABASTER_API std::string DenoiserFault();
/// The version of the library that is found, such as "2.5.1"; empty: none. Loads it, too.
ALABASTER_API std::string DenoiserVersion();

}  // namespace alabaster::hd::host

// Where temporary files go.
#pragma once

#include <string>

namespace alabaster {

/// The folder that the environment names (TMPDIR, else TMP, TEMP or TEMPDIR), else /tmp. It need not exist.
std::string temporary_folder();

}  // namespace alabaster

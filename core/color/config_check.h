// Faults of an OpenColorIO configuration that OpenColorIO itself does not survive. Internal to this room.
#pragma once

#include <OpenColorIO/OpenColorIO.h>

#include <map>
#include <string>

#include "core/files/input_file.h"

namespace alabaster {

/// Reads the text of a configuration file that is not larger than 16 MiB. Empty, or the reason why there is none.
std::string read_config_text(const InputFile& file, std::string* text);

/// Checks a configuration before OpenColorIO reads it: OpenColorIO's time for it, which grows with the square of the
/// number of colour spaces, is bounded. Empty, or the reason.
std::string config_text_fault(const std::string& text);

/// Checks that no colour space, look, view transform or named transform is made of itself, directly or by way of others
/// (views of displays included), and that every LUT is a regular file if it is there (a FIFO or device has no end) and
/// refers to no further file. `within`: a real path of a folder that LUTs must lie in or below; empty: anywhere. Empty,
/// or the reason. `luts` gets the LUTs of a configuration without a fault, by their names in it: where each is found,
/// empty where it is not.
std::string config_fault(const OCIO_NAMESPACE::ConstConfigRcPtr& config, const std::string& within,
                         std::map<std::string, std::string>* luts = nullptr);

}  // namespace alabaster

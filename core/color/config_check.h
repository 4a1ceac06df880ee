// Faults of an OpenColorIO configuration that OpenColorIO itself does not survive. Internal to this room.
#pragma once

#include <OpenColorIO/OpenColorIO.h>

#include <string>

namespace alabaster {

/// The text of a configuration file; empty if it is not a regular file that can be read, or larger than 16 MiB.
std::string config_text(const std::string& path);

/// Checks a configuration file before OpenColorIO reads it: it is a regular file of a sensible size, and OpenColorIO's
/// time for it, which grows with the square of the number of colour spaces, is bounded. Empty, or the reason.
std::string config_file_fault(const std::string& path);

/// Checks that no colour space, look, view transform or named transform is made of itself, directly or by way of others
/// (views of displays included), and that every LUT is a regular file if it is there (a FIFO or device has no end).
/// Empty, or the reason.
std::string config_fault(const OCIO_NAMESPACE::ConstConfigRcPtr& config);

}  // namespace alabaster

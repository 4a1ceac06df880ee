// Numbers of an OpenColorIO configuration in any locale. Internal to this room.
#pragma once

#include <string>

namespace alabaster {

/// True if streams of this program read "0.5" as a number. OpenColorIO's reader of configurations, alone of all that
/// it reads, follows the global locale of C++ (std::locale::global), which is the host's.
bool streams_read_decimal_points();

/// The YAML text of a configuration with the numbers of its transforms and of luma written as whole numbers with an
/// exponent, "0.055" as "0055e-3": the same numbers, which every locale reads. Names and other texts stay.
std::string with_whole_numbers(const std::string& yaml);

}  // namespace alabaster

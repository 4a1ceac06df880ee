// Floats as numbers of JSON.
#pragma once

namespace alabaster::hd::support {

/// The shortest decimal that reads back as the same float: 0.1, not 0.10000000149.
double shortest_decimal(float value);

}  // namespace alabaster::hd::support

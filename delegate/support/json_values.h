// Values as JSON, for files that programs read: statistics, notes of checkpoints, descriptions.
#pragma once

#include <nlohmann/json_fwd.hpp>

#include "delegate/api/types.h"

namespace alabaster::hd::support {

/// The shortest decimal that reads back as the same float: 0.1, not 0.10000000149.
double shortest_decimal(float value);

/// Numbers, with floats as their shortest decimals; texts; lists of vectors, matrices and arrays; objects of
/// dictionaries. An empty value is null.
nlohmann::json json_of(const Value& value);

/// The value of a flag, a text, a whole number, another number (a float, or a double that no float's shortest decimal
/// is), of 2 or 3 numbers (a vector of floats), or of an array of whole numbers, of numbers, of lists of 4 numbers
/// (vectors), or of texts. Empty: there
/// is none.
Value value_of(const nlohmann::json& json);

/// As dump(2), but what fits into a line stands on one.
std::string readable_json(const nlohmann::ordered_json& value, const std::string& indent = "\n");

}  // namespace alabaster::hd::support

// Lengths with a unit in a description: "3.7mm", "[3.7, 1.4, 0.7]mm", {"mm": [3.7, 1.4, 0.7]}. Internal to this room.
#pragma once

#include <nlohmann/json.hpp>
#include <optional>
#include <string>

#include "delegate/description/document_keys.h"

namespace alabaster::hd::description {

/// "um, mm, cm, m, in or ft".
std::string length_units();
/// A pattern of the texts above, and the names of units, for schemas.
nlohmann::ordered_json length_schema();

/// `value` in the unit that its row has without one, if it has a unit, or entries of a list have. None: it has none, or
/// the row is no length.
std::optional<nlohmann::json> without_unit(const nlohmann::json& value, const host::FieldRow& row,
                                           double metres_per_unit);

/// Replaces the lengths with a unit in a checked description by numbers of scene units. False: one is too large.
[[nodiscard]] bool resolve_lengths(double metres_per_unit, const Key& key, nlohmann::json* value);

}  // namespace alabaster::hd::description

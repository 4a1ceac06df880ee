// Values of fields as JSON, with arrays in tensors. Internal to this room.
#pragma once

#include <functional>

#include "delegate/archive/tensors.h"

namespace alabaster::hd::archive {

/// {"type": number, text or list}; {"type[]": list, or the name of a tensor}. Numbers that JSON lacks (NaN, infinity)
/// are tensors, too. `asset` writes the names and contents of files.
nlohmann::json write_value(const Value& value, TensorWriter* tensors,
                           const std::function<nlohmann::json(const AssetPath&)>& asset);
/// Throws Fault.
Value read_value(const nlohmann::json& json, const TensorReader& tensors,
                 const std::function<AssetPath(const nlohmann::json&)>& asset);

}  // namespace alabaster::hd::archive

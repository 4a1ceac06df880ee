// Checks a document against a schema of schemas/ and reports each fault and its place in plain words.
#pragma once

#include "delegate/api/types.h"
#include "delegate/description/json_document.h"

namespace alabaster::hd::description {

/// A schema with every $ref replaced by its target; the result has no references.
nlohmann::json expanded_schema(const std::string& name);
/// The schema of render descriptions. It is made once and never destroyed: threads may load while the process ends. Any
/// thread.
const nlohmann::json& description_schema();

/// The keys of the objects that a schema describes.
std::vector<std::string> known_keys(const nlohmann::json& schema);

/// True if `document` satisfies the schema of render descriptions. Otherwise reports every violation: unknown keys
/// first, each with the nearest known key, then types, ranges and missing keys.
bool check_description(const JsonDocument& document, const DiagnosticSink& sink);

}  // namespace alabaster::hd::description

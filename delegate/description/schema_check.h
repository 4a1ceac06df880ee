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

/// A violation's place, as the steps of a JSON pointer, and the validator's words. find_violations stands in
/// schema_validator.cpp, the only file that compiles the validator.
struct Violation {
  std::vector<std::string> steps;
  std::string text;
};
std::vector<Violation> find_violations(const nlohmann::json& description);

/// True if `document` satisfies the schema of render descriptions. Otherwise reports every violation: unknown keys
/// first, each with the nearest known key, then types, ranges and missing keys.
bool check_description(const JsonDocument& document, const DiagnosticSink& sink);

}  // namespace alabaster::hd::description

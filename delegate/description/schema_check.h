// Checks a document against a schema of schemas/ and says in people's words what is wrong where.
#pragma once

#include "delegate/api/types.h"
#include "delegate/description/json_document.h"

namespace alabaster::hd::description {

/// A schema with every $ref replaced by what it names; the result refers to nothing.
nlohmann::json expanded_schema(const std::string& name);

/// The place of each violation, as JSON pointer steps, with the validator's words. schema_validator.cpp, the only file
/// that compiles the validator.
struct Violation {
  std::vector<std::string> steps;
  std::string text;
};
std::vector<Violation> find_violations(const nlohmann::json& value, const nlohmann::json& schema);

/// True if `document` satisfies `schema` (expanded). Otherwise reports every violation: unknown keys first, with the
/// nearest known key; then types, ranges and what is missing.
bool check_schema(const JsonDocument& document, const nlohmann::json& schema, const DiagnosticSink& sink);

}  // namespace alabaster::hd::description

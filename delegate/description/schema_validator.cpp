#include <valijson/adapters/nlohmann_json_adapter.hpp>
#include <valijson/schema.hpp>
#include <valijson/schema_parser.hpp>
#include <valijson/validation_results.hpp>
#include <valijson/validator.hpp>

#include "delegate/description/schema_check.h"

namespace alabaster::hd::description {
namespace {

// The validator's context entries: "<root>", "[\"key\"]" and "[3]".
std::vector<std::string> steps_of(const std::vector<std::string>& context) {
  std::vector<std::string> steps;
  for (const std::string& entry : context) {
    if (entry.size() < 2 || entry.front() != '[') continue;
    const std::string inner = entry.substr(1, entry.size() - 2);
    const bool quoted = inner.size() >= 2 && inner.front() == '"';
    steps.push_back(quoted ? inner.substr(1, inner.size() - 2) : inner);
  }
  return steps;
}

}  // namespace

std::vector<Violation> find_violations(const nlohmann::json& value, const nlohmann::json& schema) {
  valijson::Schema parsed;
  const valijson::adapters::NlohmannJsonAdapter schema_adapter(schema);
  valijson::SchemaParser().populateSchema(schema_adapter, parsed);
  valijson::ValidationResults results;
  const valijson::adapters::NlohmannJsonAdapter value_adapter(value);
  std::vector<Violation> violations;
  if (valijson::Validator(valijson::Validator::kStrongTypes).validate(parsed, value_adapter, &results))
    return violations;
  for (const auto& error : results) violations.push_back({steps_of(error.context), error.description});
  return violations;
}

}  // namespace alabaster::hd::description

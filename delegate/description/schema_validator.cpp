#include <memory>
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

std::unique_ptr<valijson::Schema> validators_schema() {
  auto schema = std::make_unique<valijson::Schema>();
  valijson::SchemaParser().populateSchema(valijson::adapters::NlohmannJsonAdapter(description_schema()), *schema);
  return schema;
}

}  // namespace

std::vector<Violation> find_violations(const nlohmann::json& description) {
  static const valijson::Schema* schema = validators_schema().release();  // lives as long as description_schema()
  valijson::ValidationResults results;
  const valijson::adapters::NlohmannJsonAdapter adapter(description);
  std::vector<Violation> violations;
  if (valijson::Validator(valijson::Validator::kStrongTypes).validate(*schema, adapter, &results)) return violations;
  for (const auto& error : results) violations.push_back({steps_of(error.context), error.description});
  return violations;
}

}  // namespace alabaster::hd::description

// Values of render descriptions that a schema refuses, and the words for it.
#include "delegate/description/schema_check.h"

#include <gtest/gtest.h>

#include <set>

namespace alabaster::hd::description {
namespace {

using nlohmann::json;

std::string fault_of(const json& value) {
  JsonDocument document;
  document.value = value;
  document.origin = "scene.json";
  std::string said;
  const bool ok = check_description(document, [&](const Diagnostic& d) { said += d.where + ": " + d.text + "\n"; });
  EXPECT_EQ(ok, said.empty());
  return said;
}

struct Row {
  const char *document, *says;  // "": it is accepted
};
constexpr Row kRows[] = {
    {R"({"settings":{"samples":4}})", ""},
    {R"({"settings":{"samples":4.5}})", "4.5 is not valid: expected a whole number from 1 to 1048576"},
    {R"({"settings":{"samples":0}})", "0 is not valid"},
    {R"({"settings":{"energy":"all"}})", "expected one of burley2015, bounded, conserving"},
    {R"({"camera":{"focalLength":0}})", "expected a number above 0"},
    {R"({"lights":[{"name":"a","type":"domeLight","color":[1,1]}]})", "expected a list of 3 numbers, at least 0"},
    {R"({"lights":[{"name":"a","type":"domeLight","color":[1,1,-1]}]})", "-1 is not valid"},
    {R"({"lights":[{"type":"domeLight"}]})", "expected an object with 'name' and 'type', or with 'match'"},
    {R"({"lights":[{"name":""}]})", "is not valid"},
    {R"({"materials":[{"match":"a","set":{"roughness":{"file":"a.png","scale":2}}}]})", ""},
    {R"({"materials":[{"match":"a","set":{"roughness":2}}]})", "2 is not valid: expected a number from 0 to 1, or an"},
    // Inside the alternative that the value is one of.
    {R"({"materials":[{"match":"a","set":{"roughness":{"file":3}}}]})", "3 is not valid: expected text"},
    {R"({"materials":[{"match":"a","set":{"roughness":{"scale":2}}}]})", "'file' is missing"},
    {R"({"camera":{"transform":{"rotate":{"axis":[0,1,0],"angle":20}}}})", "expected a list of 3 numbers"},
    {R"({"products":[{"file":"a.exr","aovs":["color","primvars:a"]}]})", ""},
    {R"({"products":[{"file":"a.exr","aovs":["primvars:"]}]})", "or a text that begins with 'primvars:'"},
    {R"({"products":[{}]})", "'file' is missing"},
    {R"([])", "expected an object"},
    {R"({"gltf":{}})", "expected a list of entries"},
};

TEST(SchemaCheck, RefusedValuesAreNamedWithWhatIsExpected) {
  for (const Row& row : kRows) {
    const std::string said = fault_of(json::parse(row.document));
    if (*row.says)
      EXPECT_NE(said.find(row.says), std::string::npos) << row.document << ": " << said;
    else
      EXPECT_EQ(said, "") << row.document;
  }
}

void add_keywords(const json& schema, std::set<std::string>* all) {
  for (const auto& [key, value] : schema.items()) {
    all->insert(key);
    if (key == "properties")
      for (const json& property : value) add_keywords(property, all);
    if (key == "items") add_keywords(value, all);
    if (key == "anyOf" || key == "allOf")
      for (const json& choice : value) add_keywords(choice, all);
  }
}

TEST(SchemaCheck, SchemasHaveNoOtherKeywords) {
  std::set<std::string> keywords;
  add_keywords(description_schema(), &keywords);
  const std::set<std::string> checked = {"additionalProperties",
                                         "allOf",
                                         "anyOf",
                                         "enum",
                                         "exclusiveMinimum",
                                         "items",
                                         "maxItems",
                                         "maximum",
                                         "minItems",
                                         "minLength",
                                         "minimum",
                                         "pattern",
                                         "properties",
                                         "required",
                                         "type"};
  const std::set<std::string> words = {"appliesTo", "default", "description", "title", "unit", "unitInDescription"};
  for (const std::string& keyword : keywords)
    EXPECT_TRUE(checked.contains(keyword) || words.contains(keyword)) << keyword;
}

}  // namespace
}  // namespace alabaster::hd::description

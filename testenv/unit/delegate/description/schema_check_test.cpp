// Values of render descriptions that a schema refuses, and the words for it.
#include <gtest/gtest.h>

#include <nlohmann/json.hpp>
#include <set>

#include "delegate/description/render_description.h"
#include "testenv/support/gltf_testing.h"

namespace alabaster::hd::description {
namespace {

using gltf::testing::TemporaryFolder;
using nlohmann::json;

/// The faults of the document's form.
std::string fault_of(const std::string& document) {
  const TemporaryFolder folder;
  const std::string file = folder.write("scene.json", document);
  std::string said;
  host::RetainedSceneDelegate scene;
  LoadScene(file, &scene, [&](const Diagnostic& d) {
    if (d.code.starts_with("description.value") || d.code.starts_with("description.key")) said += d.text + "\n";
  });
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
    {R"({"products":[{"file":"a.exr","aovs":["cameraDepht"]}]})", "Did you mean 'cameraDepth'?"},
    {R"({"products":[{}]})", "'file' is missing"},
    {R"([])", "expected an object"},
    {R"({"gltf":{}})", "expected a list of entries"},
};

TEST(SchemaCheck, RefusedValuesAreNamedWithWhatIsExpected) {
  for (const Row& row : kRows) {
    const std::string said = fault_of(row.document);
    if (*row.says)
      EXPECT_NE(said.find(row.says), std::string::npos) << row.document << ": " << said;
    else
      EXPECT_EQ(said, "") << row.document;
  }
}

void add_keywords(const json& schema, std::set<std::string>* all) {
  for (const auto& [key, value] : schema.items()) {
    all->insert(key);
    if (key == "properties" || key == "definitions")
      for (const json& property : value) add_keywords(property, all);
    if (key == "items") add_keywords(value, all);
    if (key == "anyOf" || key == "allOf")
      for (const json& choice : value) add_keywords(choice, all);
  }
}

TEST(SchemaCheck, SchemasHaveNoOtherKeywords) {
  std::set<std::string> keywords;
  for (const char* name :
       {"render_description", "disney_material", "textures", "mesh", "lights", "camera", "render_settings"})
    add_keywords(json::parse(SchemaText(name)), &keywords);
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
  const std::set<std::string> words = {"$id",         "$ref",        "$schema", "appliesTo", "default",
                                       "definitions", "description", "title",   "unit",      "unitInDescription"};
  for (const std::string& keyword : keywords)
    EXPECT_TRUE(checked.contains(keyword) || words.contains(keyword)) << keyword;
}

}  // namespace
}  // namespace alabaster::hd::description

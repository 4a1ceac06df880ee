// The form of a render description: what is refused, and the words for it. Values of fields: field_table_test.cpp.
#include <gtest/gtest.h>

#include "delegate/description/render_description.h"
#include "testenv/support/gltf_testing.h"

namespace alabaster::hd::description {
namespace {

using gltf::testing::TemporaryFolder;

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
    {R"({"settings":{"resolution":[4,0]}})",
     "An entry of 'resolution' must be a whole number from 1 to 65536, and is 0. Width"},
    {R"({"settings":{"resolution":[4]}})",
     "'resolution' must be a list of 2 whole numbers from 1 to 65536, and is [4]."},
    {R"({"settings":{"quality":"drafd"}})",
     "one of preview, draft, production, reference, and is \"drafd\"; did you mean"},
    {R"({"settings":{"samples":null}})", "'samples' must be a whole number from 1 to 1048576, and is null."},
    {R"({"lights":[{"name":"a","type":"domeLight","color":[]}]})", "'color' must be a colour: three numbers"},
    {R"({"lights":[{"name":"a","type":"domeLight","color":{"r":1}}]})", "three numbers, at least 0, and is {\"r\":1}."},
    {R"({"lights":[{"type":"domeLight"}]})",
     "An entry of 'lights' must be an object with 'name' and 'type', or with 'match', and is"},
    {R"({"lights":[3]})", "An entry of 'lights' must be an object with 'name' and 'type', or with 'match', and is 3."},
    {R"({"lights":[{"match":""}]})", "'match' must be a text that is not empty, and is \"\"."},
    {R"({"materials":[{"match":"a","set":{"roughness":{"file":"a.png","scale":2}}}]})", ""},
    {R"({"materials":[{"match":"a","set":{"thin":{"file":"a.png"}}}]})", "'thin' must be true or false"},
    {R"({"materials":[{"match":"a","set":{"roughness":{"file":3}}}]})",
     "'file' must be a text that is not empty, and is 3."},
    {R"({"materials":[{"match":"a","set":{"roughness":{"scale":2}}}]})", "'file' is missing. Image file"},
    {R"({"materials":[{"match":"a","set":{"roughness":[]}}]})",
     "a number from 0 to 1, or an object with 'file', and is []."},
    {R"({"meshes":[{"match":"a","creases":[{"points":[1]}]}]})",
     "a list of at least 2 whole numbers, at least 0, and is [1]."},
    {R"({"camera":{"transform":{"rotate":{"axis":[0,1,0],"angle":20}}}})",
     "'rotate' must be a list of 3 numbers, and is"},
    {R"({"camera":{"transform":[1]}})", "'transform' must be a list of 16 numbers, or an object, and is [1]."},
    {R"({"products":[{"file":"a.exr","aovs":["color","primvars:a"]}]})", ""},
    {R"({"products":[{"file":"a.exr","aovs":["primvars:"]}]})", "or a text that begins with 'primvars:'"},
    {R"({"products":[{"file":"a.exr","aovs":["cameraDepht"]}]})", "did you mean 'cameraDepth'?"},
    {R"({"products":[{"file":"a.exr","exposure":100}]})", "'exposure' must be a number from -64 to 64, and is 100."},
    {R"({"products":[{}]})", "'file' is missing"},
    {R"([])", "A render description must be an object, and is []."},
    {R"({"gltf":{}})", "'gltf' must be a list of objects, and is {}."},
};

TEST(DocumentCheck, RefusedValuesAreNamedWithWhatIsExpected) {
  for (const Row& row : kRows) {
    const std::string said = fault_of(row.document);
    if (*row.says)
      EXPECT_NE(said.find(row.says), std::string::npos) << row.document << ": " << said;
    else
      EXPECT_EQ(said, "") << row.document;
  }
}

}  // namespace
}  // namespace alabaster::hd::description

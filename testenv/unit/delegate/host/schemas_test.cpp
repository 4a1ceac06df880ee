// schemas/*.json are what the tables of parameters say.
#include "delegate/host/schemas.h"

#include <gtest/gtest.h>

#include <fstream>

#include "core/camera/camera.h"
#include "core/light/light_parameters.h"
#include "core/material/node_inputs.h"
#include "core/scene/mesh_options.h"
#include "core/session/render_settings.h"
#include "testenv/support/build_paths.h"

namespace alabaster::hd::host {
namespace {

constexpr const char* kDescription = "schemas/render_description.json";

TEST(Schemas, FilesAreThoseOfTheTables) {
  for (const auto& [name, text] : TableFiles())
    EXPECT_TRUE(text == alabaster::testing::source_text(name)) << name << ": run 'alabaster schema --write .'";
  const std::string description = alabaster::testing::source_text(kDescription);
  EXPECT_TRUE(WithTables(description) == description) << "run 'alabaster schema --write .'";
}

TEST(Schemas, EveryKindHasAPage) {
  const auto files = TableFiles();
  const auto page = [&](const std::string& name) { return files.at("delegate/manual/parameters/" + name + ".md"); };
  EXPECT_NE(page("mesh").find("| `doubleSided` | bool |  | `true` | none | False: rays"), std::string::npos);
  EXPECT_NE(page("mesh").find("| `refineLevel` | int | 0 to 8 | `0` | levels |"), std::string::npos);
  EXPECT_NE(page("mesh").find("| `scheme` | word | none, catmullClark, loop, bilinear | `none` |"), std::string::npos);
  EXPECT_NE(page("instancer").find("| `prototypes:PATH` | array of int |"), std::string::npos);
  EXPECT_NE(page("material").find("| `NODE.baseColor` | color or texture |"), std::string::npos);
  EXPECT_NE(page("texture_node").find("| `NODE.stScale` | float2 |  | `[1,1]` |"), std::string::npos);
  EXPECT_NE(page("light").find("| `texture:file` | text |"), std::string::npos);
  EXPECT_NE(page("camera").find("| `clipPlanes` | array of float4 |"), std::string::npos);
  EXPECT_NE(page("render_settings").find("| `width` | int | 1 to 1048576 | `1280` | pixels |"), std::string::npos);
  EXPECT_NE(page("render_settings").find("| `samples` | int | 1 to 1048576 |"), std::string::npos);
  EXPECT_NE(page("product").find("| `exposure` | float | -64 to 64 | `0` | stops |"), std::string::npos);
  EXPECT_NE(files.at("delegate/python/hdalabaster/_fields.pyi").find("    double_sided: Optional[bool]\n"),
            std::string::npos);
}

TEST(Schemas, ADescriptionGetsTheParametersAndAovsThatItLacks) {
  const std::string description = alabaster::testing::source_text(kDescription);
  for (const std::string line :
       {"          \"radius\": {\"$ref\": \"lights.json#/properties/radius\"},\n", "                    \"Peye\",\n"}) {
    std::string lacking = description;
    ASSERT_NE(lacking.find(line), std::string::npos);
    lacking.erase(lacking.find(line), line.size());
    EXPECT_TRUE(WithTables(lacking) == description) << line;
  }
}

TEST(Schemas, EveryParameterHasItsWords) {
  const auto check = [](const auto& rows) {
    for (const auto& row : rows) {
      EXPECT_STRNE(row.unit, "") << row.name;
      EXPECT_STRNE(row.text, "") << row.name;
    }
  };
  check(material_parameters()), check(mesh_parameters()), check(light_parameters()), check(camera_parameters());
  check(setting_parameters()), check(texture_inputs()), check(displacement_inputs());
}

}  // namespace
}  // namespace alabaster::hd::host

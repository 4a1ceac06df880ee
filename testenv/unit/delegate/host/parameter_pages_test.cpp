// Pages of the manual and Python's stub are what the tables of fields say.
#include "delegate/host/parameter_pages.h"

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

TEST(ParameterPages, FilesAreThoseOfTheTables) {
  for (const auto& [name, text] : ParameterPages())
    EXPECT_TRUE(text == alabaster::testing::source_text(name)) << name << ": run 'alabaster schema --write .'";
}

TEST(ParameterPages, EveryKindHasAPage) {
  const auto files = ParameterPages();
  const auto page = [&](const std::string& name) { return files.at("delegate/manual/parameters/" + name + ".md"); };
  EXPECT_NE(page("mesh").find("| `doubleSided` | bool |  | `true` | none | False: rays"), std::string::npos);
  EXPECT_NE(page("mesh").find("| `refineLevel` | int | 0 to 8 | `0` | levels |"), std::string::npos);
  EXPECT_NE(page("mesh").find("| `scheme` | word | none, catmullClark, loop, bilinear | `none` |"), std::string::npos);
  EXPECT_NE(page("instancer").find("| `prototypes:PATH` | array of int |"), std::string::npos);
  EXPECT_NE(page("material").find("| `NODE.baseColor` | color or texture |"), std::string::npos);
  EXPECT_NE(page("texture_node").find("| `NODE.stScale` | float2 |  | `(1, 1)` |"), std::string::npos);
  EXPECT_NE(page("light").find("| `texture:file` | text |"), std::string::npos);
  EXPECT_NE(page("camera").find("| `clipPlanes` | array of float4 |"), std::string::npos);
  EXPECT_NE(page("render_settings").find("| `width` | int | 1 to 1048576 | `1280` | pixels |"), std::string::npos);
  EXPECT_NE(page("render_settings").find("| `samples` | int | 1 to 1048576 |"), std::string::npos);
  EXPECT_NE(page("product").find("| `exposure` | float | -64 to 64 | `0` | stops |"), std::string::npos);
  EXPECT_NE(files.at("delegate/python/hdalabaster/_fields.pyi").find("    double_sided: Optional[bool]\n"),
            std::string::npos);
}

TEST(ParameterPages, EveryParameterHasItsWords) {
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

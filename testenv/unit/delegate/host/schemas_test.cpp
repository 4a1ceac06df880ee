// schemas/*.json are what the tables of parameters say.
#include "delegate/host/schemas.h"

#include <gtest/gtest.h>

#include <fstream>

#include "core/camera/camera.h"
#include "core/light/light_description.h"
#include "core/material/disney_material.h"
#include "core/session/render_settings.h"
#include "testenv/support/build_paths.h"

namespace alabaster::hd::host {
namespace {

std::string text_of(const std::string& schema) {
  std::ifstream file(testing::source_file("schemas/" + schema + ".json"));
  return {std::istreambuf_iterator<char>(file), {}};
}

TEST(Schemas, AreThoseOfTheTables) {
  for (const std::string& name : TableSchemas())
    EXPECT_TRUE(SchemaOfTable(name) == text_of(name)) << name << ": run 'alabaster schema --write schemas'";
  const std::string description = text_of("render_description");
  EXPECT_TRUE(WithTableReferences(description) == description) << "run 'alabaster schema --write schemas'";
}

TEST(Schemas, ADescriptionGetsTheParametersThatItLacks) {
  const std::string description = text_of("render_description");
  const std::string line = "          \"radius\": {\"$ref\": \"lights.json#/properties/radius\"},\n";
  std::string lacking = description;
  ASSERT_NE(lacking.find(line), std::string::npos);
  lacking.erase(lacking.find(line), line.size());
  EXPECT_TRUE(WithTableReferences(lacking) == description);
}

TEST(Schemas, EveryParameterHasItsWords) {
  const auto check = [](const auto& rows) {
    for (const auto& row : rows) {
      EXPECT_STRNE(row.unit, "") << row.name;
      EXPECT_STRNE(row.text, "") << row.name;
    }
  };
  check(material_parameters()), check(light_parameters()), check(camera_parameters()), check(setting_parameters());
}

}  // namespace
}  // namespace alabaster::hd::host

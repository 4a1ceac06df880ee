// Panels made from the tables.
#include "delegate/view/parameter_rows.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <set>

#include "delegate/host/scene_fields.h"

namespace alabaster::view {
namespace {

const ParameterRow& find(const std::vector<ParameterRow>& rows, const std::string& name) {
  const auto row = std::find_if(rows.begin(), rows.end(), [&](const auto& r) { return r.name == name; });
  EXPECT_NE(row, rows.end()) << name;
  return *row;
}

// A row for everything that a person can set: only the camera's lists of planes and ranges have none.
TEST(ParameterRows, EveryParameterHasARow) {
  const std::set<std::string> lists{"clippingRange", "clipPlanes"};
  for (const char* schema : {"disney_material", "lights", "camera", "render_settings"}) {
    const auto rows = parameter_rows(schema);
    auto row = rows.begin();
    for (const hd::host::FieldRow& field : hd::host::ParameterRows(schema)) {
      if (lists.contains(field.name)) continue;
      ASSERT_NE(row, rows.end());
      EXPECT_EQ(row->name, field.name);
      EXPECT_FALSE(row->label.empty()) << row->name;
      EXPECT_LE(row->minimum, row->maximum) << row->name;
      EXPECT_FALSE(row++->default_value.empty());
    }
    EXPECT_EQ(row, rows.end());
  }
  EXPECT_TRUE(parameter_rows("no such schema").empty());
}

TEST(ParameterRows, ARowHasTheTablesWords) {
  const auto rows = parameter_rows("disney_material");
  const ParameterRow& distance = find(rows, "scatterDistance");
  EXPECT_EQ(distance.label, "Scatter distance");
  EXPECT_EQ(distance.unit, "mm");
  EXPECT_EQ(distance.kind, RowKind::color);
  EXPECT_EQ(distance.minimum, 0);
  EXPECT_TRUE(std::isinf(distance.maximum));
  const ParameterRow& ior = find(rows, "ior");
  EXPECT_EQ(ior.kind, RowKind::number);
  EXPECT_EQ(ior.minimum, 1);
  EXPECT_EQ(ior.maximum, 4);
  EXPECT_EQ(ior.default_value.number_or(0), 1.5);
  EXPECT_EQ(ior.unit, "");
  EXPECT_EQ(find(rows, "thin").kind, RowKind::toggle);
  EXPECT_EQ(find(rows, "priority").kind, RowKind::integer);
  const auto settings = parameter_rows("render_settings");
  EXPECT_EQ(find(settings, "subsurface").kind, RowKind::choice);
  EXPECT_EQ(find(settings, "subsurface").choices.size(), 4u);
  const auto lights = parameter_rows("lights");
  EXPECT_EQ(find(lights, "shaping:cone:angle").label, "Shaping cone angle");
  EXPECT_EQ(find(lights, "texture:file").kind, RowKind::text);
  EXPECT_EQ(find(lights, "length").applies_to, std::vector<std::string>{"cylinderLight"});
}

// A slider shows where its value stands, whatever a file or a keyboard has set.
TEST(ParameterRows, ASliderCoversItsValueAndStaysWithinTheLimits) {
  for (const char* schema : {"disney_material", "lights", "camera", "render_settings"})
    for (const ParameterRow& row : parameter_rows(schema)) {
      if (row.kind == RowKind::toggle || row.kind == RowKind::choice || row.kind == RowKind::text) continue;
      for (const double scene_size : {0.01, 3.0, 5000.0})
        for (const double asked : {row.default_value.number_or(0), 0.0, 0.3, 123456.0, -123456.0}) {
          const double value = limited(row, asked);
          const SoftRange range = soft_range(row, value, scene_size);
          EXPECT_LT(range.low, range.high) << row.name << " " << value;
          EXPECT_LE(range.low, value) << row.name;
          EXPECT_GE(range.high, value) << row.name;
          EXPECT_GE(range.low, row.minimum) << row.name;
          EXPECT_LE(range.high, row.maximum) << row.name;
          EXPECT_TRUE(std::isfinite(range.low) && std::isfinite(range.high)) << row.name;
          if (range.logarithmic) {
            EXPECT_GE(range.low, 0) << row.name;
          }
        }
    }
}

TEST(ParameterRows, LengthsHaveTheScaleOfTheScene) {
  const auto rows = parameter_rows("disney_material");
  const ParameterRow& distance = find(rows, "scatterDistance");
  EXPECT_DOUBLE_EQ(soft_range(distance, 0.001, 0.3).high, 0.3);
  EXPECT_DOUBLE_EQ(soft_range(distance, 0.001, 40).high, 40);
  EXPECT_TRUE(soft_range(distance, 0.001, 40).logarithmic) << "a thousandth of the scene can be set by hand";
  EXPECT_FALSE(soft_range(find(rows, "roughness"), 0.5, 40).logarithmic);
}

TEST(ParameterRows, ValuesEndAtTheLimits) {
  const auto rows = parameter_rows("disney_material");
  EXPECT_EQ(limited(find(rows, "ior"), 0.2), 1);
  EXPECT_EQ(limited(find(rows, "ior"), 9), 4);
  EXPECT_EQ(limited(find(rows, "ior"), NAN), 1.5);
}

TEST(ParameterRows, LabelsAndUnitsArePlainWords) {
  const auto material = parameter_rows("disney_material"), lights = parameter_rows("lights"),
             camera = parameter_rows("camera");
  EXPECT_EQ(find(material, "ior").label, "IOR");
  EXPECT_EQ(find(material, "iridescenceIor").label, "Iridescence IOR");
  EXPECT_EQ(find(material, "specTrans").label, "Specular transmission");
  EXPECT_EQ(find(material, "diffTransColor").label, "Diffuse transmission color");
  EXPECT_EQ(find(lights, "shaping:ies:file").label, "Shaping IES file");
  EXPECT_EQ(find(camera, "fStop").label, "F stop");
  const auto shown = [](const ParameterRow& row, double value) {
    char text[64];
    std::snprintf(text, sizeof text, value_format(row, soft_range(row, value, 10), value).c_str(), value);
    return std::string(text);
  };
  EXPECT_EQ(shown(find(lights, "width"), 0.5), "0.500 mm");
  EXPECT_EQ(shown(find(lights, "colorTemperature"), 6500), "6500 K");
  EXPECT_EQ(shown(find(material, "iridescenceThickness"), 400), "400 nm");
  EXPECT_EQ(shown(find(camera, "fStop"), 2.8), "f/2.80");
  EXPECT_EQ(shown(find(camera, "fStop"), 0), "0 (pinhole)");
  EXPECT_EQ(shown(find(parameter_rows("render_settings"), "timeLimit"), 0), "0 (none)");
}

}  // namespace
}  // namespace alabaster::view

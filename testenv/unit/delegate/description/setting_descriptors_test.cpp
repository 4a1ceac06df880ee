// schemas/render_settings.json and what a delegate reports about its settings say the same.
#include <gtest/gtest.h>

#include <memory>
#include <nlohmann/json.hpp>

#include "delegate/api/render_delegate.h"
#include "delegate/description/render_description.h"

namespace alabaster::hd {
namespace {

TEST(SettingDescriptors, AreTheSchemas) {
  const DelegateOptions options;
  const std::unique_ptr<RenderDelegate, decltype(&DestroyAlabasterRenderDelegate)> delegate(
      CreateAlabasterRenderDelegate(kAbiVersion, &options), &DestroyAlabasterRenderDelegate);
  ASSERT_TRUE(delegate);
  const auto properties = nlohmann::json::parse(description::SchemaText("render_settings")).at("properties");
  const auto descriptors = delegate->GetRenderSettingDescriptors();
  EXPECT_EQ(descriptors.size(), properties.size());
  for (const RenderSettingDescriptor& descriptor : descriptors) {
    const std::string key = descriptor.key.str();
    ASSERT_TRUE(properties.contains(key)) << key;
    const auto& schema = properties[key];
    if (schema["type"] == "string") {
      EXPECT_EQ(descriptor.defaultValue.text_or(""), schema["default"]) << key;
      EXPECT_EQ(descriptor.choices, schema["enum"].get<std::vector<std::string>>()) << key;
    } else {
      EXPECT_EQ(descriptor.defaultValue.number_or(-1), schema["default"]) << key;
      EXPECT_EQ(descriptor.minimum.number_or(-1), schema["minimum"]) << key;
      EXPECT_EQ(descriptor.maximum.number_or(-1), schema["maximum"]) << key;
    }
    EXPECT_EQ(delegate->GetRenderSetting(descriptor.key), descriptor.defaultValue) << key;
  }
}

}  // namespace
}  // namespace alabaster::hd

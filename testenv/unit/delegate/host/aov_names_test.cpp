// The AOVs of files are those that the delegate renders and the schema names.
#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

#include "delegate/description/render_description.h"
#include "delegate/host/product_writer.h"

namespace alabaster::hd::host {
namespace {

TEST(AovNames, AreTheSchemas) {
  const auto schema = nlohmann::json::parse(description::SchemaText("render_description"));
  EXPECT_EQ(
      schema["properties"]["products"]["items"]["properties"]["aovs"]["items"]["enum"].get<std::vector<std::string>>(),
      ProductAovs());
}

TEST(AovNames, AreTheDelegates) {
  const DelegateOptions options;
  RenderDelegate* delegate = CreateAlabasterRenderDelegate(kAbiVersion, &options);
  ASSERT_TRUE(delegate);
  for (const std::string& name : ProductAovs()) {
    const Format format = delegate->GetDefaultAovDescriptor(name).format;
    EXPECT_NE(format, Format::invalid) << name;
    EXPECT_EQ(UsualRenderVar(name).dataType == Token("int"), format == Format::int32) << name;
  }
  DestroyAlabasterRenderDelegate(delegate);
}

}  // namespace
}  // namespace alabaster::hd::host

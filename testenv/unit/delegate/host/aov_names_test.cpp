// The AOVs of files are those that the delegate renders and the manual lists.
#include <gtest/gtest.h>

#include <fstream>
#include <map>
#include <sstream>

#include "core/film/aov.h"
#include "delegate/api/render_delegate.h"
#include "delegate/host/frame_recorder.h"
#include "delegate/host/product_writer.h"
#include "testenv/support/build_paths.h"

namespace alabaster::hd::host {
namespace {

TEST(AovNames, NamesAreThoseOfTheDelegate) {
  const DelegateOptions options;
  RenderDelegate* delegate = CreateAlabasterRenderDelegate(kAbiVersion, &options);
  ASSERT_TRUE(delegate);
  for (const std::string& name : ProductAovs()) {
    const Format format = delegate->GetDefaultAovDescriptor(name).format;
    EXPECT_NE(format, Format::invalid) << name;
    const bool counts = name == "sampleCount" || name == "nonfiniteSamples";  // of which programs read floats alone
    EXPECT_EQ(UsualRenderVar(name).dataType == Token("int"), format == Format::int32 && !counts) << name;
  }
  DestroyAlabasterRenderDelegate(delegate);
}

std::vector<std::string> split(const std::string& text, char separator) {
  std::vector<std::string> parts;
  std::istringstream stream(text);
  for (std::string part; std::getline(stream, part, separator);) {
    std::erase_if(part, [](char c) { return c == ' ' || c == '`'; });
    parts.push_back(part);
  }
  return parts;
}

// Rows of the table in the manual: | `name`, `name` | channels, channels | meaning |
std::map<std::string, std::string> listed_channels() {
  std::ifstream page(testing::source_file("delegate/manual/pipeline.md"));
  std::map<std::string, std::string> listed;
  bool in_table = false;
  for (std::string line; std::getline(page, line);) {
    if (line.starts_with("## ")) in_table = line == "## AOVs";
    if (!in_table || !line.starts_with("| `")) continue;
    const auto cells = split(line, '|');
    const auto names = split(cells.at(1), ','), channels = split(cells.at(2), ',');
    EXPECT_EQ(names.size(), channels.size()) << line;
    for (size_t i = 0; i < std::min(names.size(), channels.size()); ++i) listed[names[i]] = channels[i];
  }
  return listed;
}

TEST(AovNames, NamesAreThoseOfTheManual) {
  std::map<std::string, std::string> expected;
  for (const AovInfo& aov : kAovs) {
    const std::string layer = aov.layer, channels = aov.channels;
    expected[aov.name] = layer + (layer.empty() ? "" : ".") + channels;
  }
  expected["primvars:NAME"] = "primvars:NAME.XYZ";
  expected["lightGroup:NAME"] = "lightGroup_NAME.RGB";
  EXPECT_EQ(listed_channels(), expected);
}

// Rows of the table in the manual: | AOV | `expression`, `expression` |
// promise: pipeline.lpe.color, pipeline.lpe.emission, pipeline.lpe.diffuse, pipeline.lpe.direct_diffuse
// promise: pipeline.lpe.indirect_diffuse, pipeline.lpe.direct_specular, pipeline.lpe.indirect_specular
// promise: pipeline.lpe.transmission, pipeline.lpe.specular, pipeline.lpe.subsurface, pipeline.lpe.direct_subsurface
// promise: pipeline.lpe.indirect_subsurface, pipeline.lpe.light_group, pipeline.lpe.unknown
TEST(AovNames, LightPathExpressionsOfTheManualAreAovs) {
  std::ifstream page(testing::source_file("delegate/manual/pipeline.md"));
  size_t rows = 0;
  bool in_table = false;
  for (std::string line; std::getline(page, line);) {
    if (line.starts_with("#")) in_table = line == "### Light path expressions";
    if (!in_table || !line.starts_with("| ") || line.find('`') == std::string::npos) continue;
    ++rows;
    const std::string aov = line.substr(2, line.find(' ', 2) - 2);
    EXPECT_TRUE(find_aov(aov)) << line;
    size_t expressions = 0;
    for (size_t begin = line.find('`'); begin != std::string::npos; begin = line.find('`', begin + 1)) {
      const size_t end = line.find('`', begin + 1);
      const std::string expression = line.substr(begin + 1, end - begin - 1);
      EXPECT_EQ(UsualRenderVar("lpe:" + expression).aov, Token(aov)) << expression;
      EXPECT_EQ(UsualRenderVar("lpe:" + expression).name, aov);
      ++expressions, begin = end;
    }
    EXPECT_GT(expressions, 0u) << line;
  }
  EXPECT_EQ(rows, 13u);
  EXPECT_EQ(UsualRenderVar("lpe:C <RD> [LO]").aov, Token("directDiffuse"));
  for (const std::string unknown :
       {"lpe:", "lpe:C<RD>VL", "lpe:C.*<L.''>", "lpe:C.*<L.'a'><L.'b'>", "lpe:CB", "lpe:C<RD>"})
    EXPECT_EQ(UsualRenderVar(unknown).aov, Token(unknown));
  EXPECT_NE(NoSuchAov("lpe:CVL").find("pipeline.md, \"Light path expressions\""), std::string::npos);
}

}  // namespace
}  // namespace alabaster::hd::host

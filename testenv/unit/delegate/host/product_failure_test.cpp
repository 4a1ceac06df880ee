#include <OpenImageIO/imageio.h>
#include <gtest/gtest.h>
#include <sys/resource.h>

#include <csignal>
#include <fstream>

#include "testenv/unit/delegate/host/product_fixture.h"

namespace alabaster::hd::host {
namespace {

TEST_F(ProductFile, CheckRefusesWhatCannotBeWrittenAndSaysWhy) {
  std::ofstream(path("file")) << "x";
  fs::create_directory(path("folder.exr"));
  const auto with = [&](const char* name, const std::function<void(RenderProduct&)>& change) {
    RenderProduct p = product(name);
    change(p);
    return p;
  };
  const auto with_vars = [&](const char* name, const std::vector<RenderVar>& vars) {
    return with(name, [&](RenderProduct& p) { p.vars = vars; });
  };
  const auto nothing = [](RenderProduct&) {};
  const std::pair<RenderProduct, std::string> cases[] = {
      {with("a.gif", nothing), ".exr"},
      {with("a", nothing), ".exr"},
      {with("none/a.exr", nothing), "no folder"},
      {with("file/a.exr", nothing), "not a folder"},
      {with("folder.exr", nothing), "choose another name"},
      {with("a.exr", [](RenderProduct& p) { p.dataType = "uint8"; }), "half or float"},
      {with("a.jpg", [](RenderProduct& p) { p.dataType = "uint16"; }), "uint8 for .jpg"},
      {with("a.png", [](RenderProduct& p) { p.compression = "zip"; }), "leave it out"},
      {with("a.exr", [](RenderProduct& p) { p.compression = "lzw"; }), "none rle zip zips piz"},
      {with("a.png", [](RenderProduct& p) { p.tiles = 64; }), "leave them out"},
      {with("a.exr", [](RenderProduct& p) { p.tiles = 15; }), "16 to 256"},
      {with("a.exr", [](RenderProduct& p) { p.tiles = -64; }), "16 to 256"},
      {with_vars("a.exr", {{"x", "caustics", "half"}}), "sampleCount"},
      {with_vars("a.exr", {{"x", "color", "int"}}), "does not hold integers"},
      {with_vars("a.exr", {{"x", "color", "double"}}), "half, float or int"},
      {with_vars("a.exr", {{"x", "color", "half"}, {"x", "color", "half"}}), "x.R"},
      {with_vars("a.png", {{"", "primId", "int"}}), ".exr"},
      {with_vars("a.png", {{"", "color", "half"}, {"", "albedo", "half"}}), "one AOV"},
      {with_vars("a.jpg", {{"", "alpha", "half"}}), "no alpha"},
      {with("a.png", [](RenderProduct& p) { p.colorSpace = "ACEScg", p.display = "sRGB"; }), "only one"},
      {with("a.exr", [](RenderProduct& p) { p.colorSpace = "AdobeRGB"; }), "ACEScg"},
      {with("a.png", [](RenderProduct& p) { p.display = "TV"; }), "Rec.2100-PQ"},
      {with("a.png", [](RenderProduct& p) { p.view = "Filmic"; }), "Un-tone-mapped"},
      {with("a.png", [](RenderProduct& p) { p.look = "Warm"; }), "looks"},
  };
  for (const auto& [p, expected] : cases) {
    EXPECT_FALSE(check(p)) << p.file;
    ASSERT_EQ(reports_.size(), 1u) << p.file << text();
    EXPECT_EQ(reports_[0].severity, Severity::error);
    EXPECT_NE(text().find(expected), std::string::npos) << expected << " in " << text();
    EXPECT_FALSE(CheckProduct(p, {0, 0, kWidth, kHeight}, colors_, {}));
  }
  EXPECT_FALSE(CheckProduct(product("a.exr"), {0, 0, kWidth, kHeight}, {"/none.ocio"}, sink_));
  EXPECT_EQ(listing(), (std::vector<std::string>{"file", "folder.exr"})) << "a check leaves nothing behind";
}

// promise: pipeline.format.compression
TEST_F(ProductFile, LossyCompressionOfWhatNeedsItsBitsIsRefusedByName) {
  for (const char* name : {"pxr24", "b44", "b44a", "dwaa", "dwab"})
    for (const char* aov : {"depth", "cameraDepth", "Peye", "primId", "cryptoObject", "sampleCount", "primvars:st"}) {
      RenderProduct p = product("a.exr");
      p.compression = name, p.vars = {UsualRenderVar("color"), UsualRenderVar(aov)};
      EXPECT_FALSE(check(p)) << name << aov;
      EXPECT_NE(text().find("AOV '" + std::string(aov) + "' needs all its bits"), std::string::npos) << text();
      p.vars.pop_back();
      EXPECT_TRUE(check(p)) << name << text();
      p.vars.push_back(UsualRenderVar(aov)), p.compression = "piz";
      EXPECT_TRUE(check(p)) << aov << text();
    }
}

TEST_F(ProductFile, WritingReportsWhatTheImageLacks) {
  RenderProduct p = product("a.exr");
  p.vars = all_vars();
  ProductImage image = frame();
  image.aovs.erase("albedo");
  EXPECT_FALSE(write(p, image));
  EXPECT_NE(text().find("albedo"), std::string::npos);
  image = frame();
  image.aovs["normal"].floats = image.aovs["normal"].floats.subspan(1);
  EXPECT_FALSE(write(p, image));
  EXPECT_NE(text().find("normal"), std::string::npos);
  image = frame();
  image.framing.dataWindow = {};
  EXPECT_FALSE(write(p, image));
  EXPECT_TRUE(listing().empty());
}

// libjpeg would end the process, and OpenImageIO 2.5 refuses PNGs that 2.4 writes.
// promise: pipeline.format.limits, security.no_exit
TEST_F(ProductFile, MorePixelsThanAFormatHoldsAreRefusedBeforeAndAfterRendering) {
  const std::pair<const char*, int> limits[] = {{"a.jpg", 65500}, {"a.jpeg", 65500}, {"a.png", 65535}};
  for (const auto& [name, most] : limits)
    for (const bool wide : {true, false}) {
      const RenderProduct p = product(name);
      const auto window = [wide = wide](int side) {
        return wide ? Rect2i{-3, 0, side - 3, 1} : Rect2i{0, 5, 1, side + 5};
      };
      EXPECT_TRUE(CheckProduct(p, window(most), colors_, sink_)) << text();
      reports_.clear();
      EXPECT_FALSE(CheckProduct(p, window(most + 1), colors_, sink_));
      ASSERT_EQ(reports_.size(), 1u);
      EXPECT_EQ(reports_[0].code, "product.invalid");
      EXPECT_EQ(reports_[0].where, p.file);
      EXPECT_NE(text().find(std::to_string(most) + " x " + std::to_string(most)), std::string::npos) << text();
      EXPECT_NE(text().find("write an .exr or .tif file"), std::string::npos) << text();
      ProductImage image;
      image.framing = {{0, 0}, {20, 10}, window(most + 1), 1};
      const Vec2i size(image.framing.dataWindow.width(), image.framing.dataWindow.height());
      image.aovs["color"] = floats(
          4, [](int, int) { return 0.5f; }, size);
      EXPECT_FALSE(write(p, image));
      EXPECT_NE(text().find("write an .exr or .tif file"), std::string::npos) << text();
    }
  for (const char* name : {"a.exr", "a.tif", "a.png", "a.jpg"}) {
    reports_.clear();
    EXPECT_FALSE(CheckProduct(product(name), {INT32_MIN, 0, INT32_MAX, 10}, colors_, sink_));
    EXPECT_NE(text().find("4294967295 x 10; render it smaller or in crops"), std::string::npos) << text();
  }
  EXPECT_TRUE(CheckProduct(product("a.exr"), {0, 0, 65536, 65536}, colors_, sink_));
  EXPECT_TRUE(CheckProduct(product("a.tif"), {0, 0, 65536, 65536}, colors_, sink_));
  EXPECT_TRUE(listing().empty());
}

// A JPEG's blocks end at 65533 bytes: libjpeg ends the process at a longer one.
// promise: pipeline.format.limits, security.no_exit
TEST_F(ProductFile, LongAttributesOfAJpegAreCutOffWithAWarning) {
  ProductImage image = frame();
  image.metadata["alabaster/sceneFaults"] = std::string(100000, 'x');
  image.metadata["Software"] = std::string(70000, 's');
  EXPECT_TRUE(write(product("a.jpg"), image)) << text();
  ASSERT_EQ(reports_.size(), 2u) << text();
  EXPECT_EQ(reports_[1].severity, Severity::warning);
  EXPECT_NE(text().find("attribute 'alabaster/sceneFaults' is cut off: a JPEG holds short texts only"),
            std::string::npos)
      << text();
  for (int i = 0; i < 100; ++i) image.metadata["more" + std::to_string(i)] = std::string(3000, '&');
  EXPECT_TRUE(write(product("b.jpg"), image)) << text();
  EXPECT_NE(text().find("attribute 'more99' is left out"), std::string::npos);
  EXPECT_TRUE(write(product("a.exr"), image));
  EXPECT_TRUE(reports_.empty()) << text();
  EXPECT_TRUE(write(product("a.png"), image));
  EXPECT_TRUE(write(product("a.tif"), image));
  EXPECT_TRUE(reports_.empty()) << text();
}

// promise: pipeline.format.limits
TEST_F(ProductFile, NamesThatOpenExrWouldCutOffAreRefusedOrLeftOut) {
  RenderProduct p = product("a.exr");
  p.vars = {{std::string(300, 'n'), "depth", "float"}};
  EXPECT_FALSE(check(p));
  EXPECT_NE(text().find("302 bytes, and an EXR holds 255"), std::string::npos) << text();
  p.vars[0].name.resize(253);
  EXPECT_TRUE(check(p)) << text();
  ProductImage image = frame();
  image.metadata[std::string(256, 'a')] = 1;
  EXPECT_TRUE(write(product("a.exr"), image));
  EXPECT_NE(text().find("is left out"), std::string::npos) << text();
}

TEST_F(ProductFile, WindowsBeyondOpenExrAreRefused) {
  ProductImage image = frame();
  for (const float corner : {1e30f, INFINITY, std::nanf("")}) {
    image.framing.displayMax = {corner, 10};
    EXPECT_FALSE(write(product("a.exr"), image)) << corner;
  }
  image = frame();
  image.framing.dataWindow = {INT_MIN, 0, INT_MAX, 1};
  EXPECT_FALSE(write(product("a.exr"), image));
}

// A value with line breaks adds no lines of its own to the text that other formats hold.
TEST_F(ProductFile, AttributesCannotPassForOthers) {
  ProductImage image = frame();
  image.metadata["alabaster/camera"] = std::string("/c\nalabaster/incomplete: 1");
  ASSERT_TRUE(write(product("a.png"), image)) << text();
  const auto png = OIIO::ImageInput::open(path("a.png"));
  ASSERT_TRUE(png);
  const std::string description = png->spec().get_string_attribute("ImageDescription");
  EXPECT_NE(description.find("alabaster/camera: /c\n  alabaster/incomplete: 1\n"), std::string::npos) << description;
}

/// Limits the files of this process to `bytes`, as a full disk would.
struct FileSizeLimit {
  rlimit old{};
  void (*handler)(int) = std::signal(SIGXFSZ, SIG_IGN);
  explicit FileSizeLimit(rlim_t bytes) {
    ::getrlimit(RLIMIT_FSIZE, &old);
    rlimit limit = old;
    limit.rlim_cur = bytes;
    ::setrlimit(RLIMIT_FSIZE, &limit);
  }
  ~FileSizeLimit() {
    ::setrlimit(RLIMIT_FSIZE, &old);
    std::signal(SIGXFSZ, handler);
  }
};

// promise: pipeline.output.replaced
TEST_F(ProductFile, AFullDiskLeavesTheOldFileAndNothingElse) {
  ProductImage image;
  image.framing.displayMax = {128, 128};
  image.framing.dataWindow = {0, 0, 128, 128};
  image.aovs["color"] =
      floats(4, [](int i, int c) { return float((i * 7919 + c * 104729) % 1013) / 1013; }, {128, 128});
  for (const char* name : {"f.exr", "f.png", "f.tif", "f.jpg"}) {
    const RenderProduct p = product(name);
    std::ofstream(p.file) << "what was here before";
    bool written = true;
    {
      const FileSizeLimit limit(5000);
      written = write(p, image);
    }
    EXPECT_FALSE(written) << name;
    ASSERT_EQ(reports_.size(), 1u);
    EXPECT_EQ(reports_[0].where, p.file);
    EXPECT_NE(text().find("disk"), std::string::npos) << text();
    std::ifstream in(p.file);
    EXPECT_EQ(std::string(std::istreambuf_iterator<char>(in), {}), "what was here before");
    EXPECT_EQ(listing(), std::vector<std::string>{name});
    EXPECT_TRUE(write(p, image)) << text();
    const auto in_again = OIIO::ImageInput::open(p.file);
    ASSERT_TRUE(in_again);
    EXPECT_EQ(in_again->spec().width, 128);
    fs::remove(p.file);
  }
}

TEST_F(ProductFile, AFolderThatGoesAwayIsReported) {
  fs::create_directory(path("gone"));
  const RenderProduct p = product("gone/a.exr");
  EXPECT_TRUE(check(p)) << text();
  fs::remove(path("gone"));
  EXPECT_FALSE(write(p, frame()));
  EXPECT_NE(text().find("No such file"), std::string::npos) << text();
}

TEST_F(ProductFile, AFolderWithoutPermissionIsRefused) {
  if (::geteuid() == 0) GTEST_SKIP() << "the superuser may write everywhere";
  fs::create_directory(path("locked"));
  fs::permissions(path("locked"), fs::perms::owner_read | fs::perms::owner_exec);
  EXPECT_FALSE(check(product("locked/a.exr")));
  EXPECT_FALSE(write(product("locked/a.exr"), frame()));
  fs::permissions(path("locked"), fs::perms::owner_all);
}

TEST_F(ProductFile, ColoursAreDescribedAndSaved) {
  const std::string text = DescribeColors(colors_, sink_);
  for (const char* expected : {"configuration: built-in", "rendering space: Linear Rec.709", "ACEScg", "sRGB *",
                               "ACES *", "Rec.2100-PQ", "looks: none"})
    EXPECT_NE(text.find(expected), std::string::npos) << expected << " in\n" << text;
  std::ofstream(path("saved.ocio")) << SerializeColors(colors_, sink_);
  const std::string again = DescribeColors({path("saved.ocio")}, sink_);
  EXPECT_EQ(again.substr(again.find('\n')), text.substr(text.find('\n'))) << "a saved config is the same config";
  EXPECT_TRUE(reports_.empty());
  EXPECT_EQ(DescribeColors({"/none.ocio"}, sink_), "");
  EXPECT_EQ(SerializeColors({"/none.ocio"}, sink_), "");
  EXPECT_EQ(reports_.size(), 2u);
}

}  // namespace
}  // namespace alabaster::hd::host

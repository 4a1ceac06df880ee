#include "core/texture/exr_header.h"

#include <gtest/gtest.h>

#include <cstring>
#include <string>

namespace alabaster {
namespace {

constexpr size_t kMaxPixels = size_t(1) << 28;
constexpr uint32_t kTiled = 0x200, kMultipart = 0x1000;

std::string number(uint32_t value) {
  std::string bytes;
  for (int i = 0; i < 4; ++i) bytes.push_back(static_cast<char>(value >> 8 * i & 255));
  return bytes;
}

std::string attribute(const std::string& name, const std::string& type, const std::string& value) {
  return name + '\0' + type + '\0' + number(static_cast<uint32_t>(value.size())) + value;
}

std::string window(uint32_t width, uint32_t height) {
  return attribute("dataWindow", "box2i", number(0) + number(0) + number(width - 1) + number(height - 1));
}

std::string tiles(uint32_t width, uint32_t height) {
  return attribute("tiles", "tiledesc", number(width) + number(height) + '\0');
}

/// A file of these parts with `data` bytes after them.
std::string file(uint32_t flags, const std::string& headers, size_t data) {
  return number(20000630) + number(2 | flags) + headers + (flags & kMultipart ? std::string(1, '\0') : std::string()) +
         std::string(data, 'x');
}
std::string part(const std::string& attributes) {
  return attributes + '\0';
}

/// The fault's text, or "".
std::string fault_of(const std::string& bytes) {
  FileBytes source;
  source.size = bytes.size();
  source.read = [&](uint64_t offset, void* out, size_t count) {
    EXPECT_TRUE(offset <= bytes.size() && count <= bytes.size() - offset);
    std::memcpy(out, bytes.data() + offset, count);
    return true;
  };
  ImageFault fault;
  const bool good = check_exr_header(source, kMaxPixels, &fault);
  EXPECT_EQ(good, fault.text.empty());
  return fault.text;
}

TEST(ExrHeader, ValidHeaderIsAccepted) {
  EXPECT_EQ(fault_of(file(0, part(attribute("owner", "string", "me") + window(64, 16)), 16 * 8)), "");
  EXPECT_EQ(fault_of(file(kTiled, part(window(100, 100) + tiles(32, 32)), 16 * 8)), "");
  EXPECT_EQ(fault_of(file(kTiled, part(window(10, 10) + tiles(64, 64)), 8)), "");
  const std::string one = part(window(64, 16) + attribute("chunkCount", "int", number(16)));
  EXPECT_EQ(fault_of(file(kMultipart, one + one, 32 * 8)), "");
  EXPECT_EQ(fault_of(file(0, part(attribute("views", "stringvector", number(4) + "left" + number(0))), 8)), "");
}

// Whatever else is wrong, OpenEXR finds.
TEST(ExrHeader, TruncatedHeaderIsLeftToOpenExr) {
  const std::string whole = file(0, part(window(64, 1) + tiles(1, 1)), 0);
  for (size_t size = 0; size + 9 < whole.size(); ++size) {
    const std::string text = fault_of(whole.substr(0, size));
    EXPECT_TRUE(text.empty() || text.find("more than the file has") != std::string::npos) << size << text;
  }
  EXPECT_EQ(fault_of(file(0, std::string(1000, 'n'), 0)), "");
}

TEST(ExrHeader, AttributeBeyondTheFileIsRefused) {
  std::string bytes = attribute("note", "string", "text");
  bytes.replace(bytes.size() - 8, 4, number(1979711495));
  EXPECT_EQ(fault_of(file(0, bytes, 100)),
            "its attribute 'note' claims 1979711495 bytes, more than the file has; export or copy the image again");
  const std::string texts = attribute("views", "stringvector", number(4) + "left" + number(0x7fffffff));
  EXPECT_NE(fault_of(file(0, part(texts), 100)).find("a text of its attribute 'views' claims 2147483647 bytes"),
            std::string::npos);
}

TEST(ExrHeader, MorePiecesThanOffsetsAreRefused) {
  EXPECT_EQ(fault_of(file(0, part(window(1, 100000000)), 600)),
            "it claims 100000000 pieces, more than the file has; export or copy the image again");
  const std::string blocks = attribute("compression", "compression", std::string(1, '\3'));  // ZIP: sixteen lines
  EXPECT_EQ(fault_of(file(0, part(blocks + window(1, 1600)), 100 * 8)), "");
  EXPECT_NE(fault_of(file(0, part(blocks + window(1, 160000)), 100 * 8)), "");
  EXPECT_NE(fault_of(file(kTiled, part(window(4096, 4096) + tiles(1, 1)), 4096)), "");
  const std::string counted = part(window(1, 1) + attribute("chunkCount", "int", number(0x7fffffff)));
  EXPECT_NE(fault_of(file(kMultipart, part(window(1, 1)) + counted, 600)), "");
  // The parts share the file.
  const std::string one = part(window(1, 100));
  EXPECT_EQ(fault_of(file(kMultipart, one + one, 200 * 8)), "");
  EXPECT_EQ(fault_of(file(kMultipart, one + one + one + one, 200 * 8)),
            "it claims 300 pieces, more than the file has; export or copy the image again");
}

// Each costs OpenEXR many times its bytes.
TEST(ExrHeader, TooManyAttributesAreRefused) {
  std::string many;
  for (int i = 0; i < 1 << 16; ++i) many += attribute("a", "b", "");
  EXPECT_EQ(fault_of(file(0, part(many), 8)), "");
  EXPECT_EQ(fault_of(file(0, part(many + attribute("a", "b", "")), 8)),
            "the image has more than 65536 attributes; export it with fewer");
}

TEST(ExrHeader, PixelsBeyondTheLimitAreRefused) {
  EXPECT_EQ(fault_of(file(0, part(window(0x40000000, 1)), 600)),
            "the image claims 1073741824 x 1 pixels and the limit is 268435456 pixels; make it smaller");
  EXPECT_NE(fault_of(file(kTiled, part(window(10, 10) + tiles(20000, 20000)), 600)).find("tiles of 20000 x 20000"),
            std::string::npos);
}

}  // namespace
}  // namespace alabaster

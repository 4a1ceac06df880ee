// Values that become JSON come back as the same values.
#include "delegate/support/json_values.h"

#include <gtest/gtest.h>

#include <limits>
#include <nlohmann/json.hpp>

namespace alabaster::hd::support {
namespace {

using nlohmann::json;

TEST(JsonValues, ValuesSurviveARoundTrip) {
  for (const Value& value :
       {Value(true), Value(int32_t(-3)), Value(int64_t(1) << 40), Value(0.1f), Value(1e-40f), Value(0.1234567890123),
        Value("text"), Value(Vec2f(1, 0.3f)), Value(Vec3f(0.1f, 2, -3)), Value(Array<int32_t>{1, 2, 3, 4}),
        Value(Array<std::string>{"a", "b"}), Value(Array<float>{0.1f, 0.2f, 0.3f, 0.4f})})
    EXPECT_EQ(value_of(json::parse(json_of(value).dump())), value) << value.to_string();
}

TEST(JsonValues, HaveTheirFormsInFiles) {
  EXPECT_EQ(json_of(Value()), json());
  EXPECT_EQ(json_of(0.02f).dump(), "0.02");
  EXPECT_EQ(json_of(uint32_t(4294967295)).dump(), "4294967295");
  EXPECT_EQ(json_of(std::numeric_limits<float>::infinity()).dump(), "null");
  EXPECT_EQ(json_of(Token("walk")), "walk");
  EXPECT_EQ(json_of(Array<Path>{"/a"}), json{"/a"});
  EXPECT_EQ(json_of(Array<Vec4f>{{1, 2, 3, 4}}), (json{{1.0, 2.0, 3.0, 4.0}}));
  EXPECT_EQ(json_of(Matrix4d()).size(), 16u);
  Dictionary inner{{"x", Value(1)}};
  EXPECT_EQ(json_of(std::make_shared<const Dictionary>(inner)), (json{{"x", 1}}));
}

TEST(JsonValues, TextThatIsNoValueIsEmpty) {
  for (const char* text : {"null", "{}", "[]", "[1, \"a\"]", "[[1]]", "[null]", "[true]"})
    EXPECT_TRUE(value_of(json::parse(text)).empty()) << text;
  EXPECT_EQ(value_of(json::parse("1e300")), Value(1e300));
}

}  // namespace
}  // namespace alabaster::hd::support

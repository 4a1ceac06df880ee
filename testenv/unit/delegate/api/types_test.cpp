#include "delegate/api/types.h"

#include <gtest/gtest.h>

#include <cmath>
#include <thread>

#include "delegate/api/scene_types.h"

namespace alabaster::hd {
namespace {

TEST(Token, EqualTextIsOneTokenOnEveryThread) {
  constexpr int kThreads = 8, kTokens = 500;
  std::vector<std::vector<Token>> made(kThreads);
  std::vector<std::thread> threads;
  for (auto& tokens : made)
    threads.emplace_back([&tokens] {
      for (int i = 0; i < kTokens; ++i) tokens.emplace_back("token_" + std::to_string(i));
    });
  for (auto& thread : threads) thread.join();
  for (const auto& tokens : made) {
    EXPECT_EQ(tokens, made[0]);
    EXPECT_EQ(&tokens[7].str(), &made[0][7].str());
  }
  EXPECT_FALSE(made[0][0] == made[0][1]);
}

TEST(Token, EmptyIsFalseAndOrderIsByText) {
  EXPECT_TRUE(Token("").empty());
  EXPECT_TRUE(Token() == Token(""));
  EXPECT_LT(Token("a"), Token("b"));
  EXPECT_FALSE(Token("b") < Token("b"));
}

TEST(Path, AppendSeparatesOnce) {
  EXPECT_EQ(Path("/").append("x").str(), "/x");
  EXPECT_EQ(Path("/y").append("x").str(), "/y/x");
}

TEST(Value, AnswersWithItsTypeOrTheFallback) {
  EXPECT_EQ(Value(3).number_or(9), 3);
  EXPECT_EQ(Value(true).number_or(9), 1);
  EXPECT_EQ(Value(2.5).number_or(9), 2.5);
  EXPECT_EQ(Value("3").number_or(9), 9);
  EXPECT_EQ(Value().number_or(9), 9);
  EXPECT_EQ(Value("text").text_or("no"), "text");
  EXPECT_EQ(Value(Token("token")).text_or("no"), "token");
  EXPECT_EQ(Value(Path("/p")).text_or("no"), "/p");
  EXPECT_EQ(Value(AssetPath{"a.png", "", nullptr}).text_or("no"), "a.png");
  EXPECT_EQ(Value(AssetPath{"a.png", "/x/a.png", nullptr}).text_or("no"), "/x/a.png");
  EXPECT_EQ(Value(1.0f).text_or("no"), "no");
  EXPECT_EQ(Value(7).get<float>(), nullptr);
}

TEST(Array, MemoryThatAHostEditsIsComparedByItsVersion) {
  auto memory = std::make_shared<std::vector<float>>(std::vector<float>{1, 2});
  const auto lent = [&](uint64_t version) { return Array<float>(memory, memory->data(), memory->size(), version); };
  EXPECT_EQ(lent(0), lent(0));
  EXPECT_EQ(lent(1), lent(1));
  EXPECT_FALSE(lent(1) == lent(2)) << "edited in between, though the values are the same now";
  EXPECT_FALSE(lent(1) == (Array<float>{1, 2})) << "it may have been anything when it was set";
  EXPECT_EQ(lent(0), (Array<float>{1, 2}));
  const Array<float> kept = lent(1).frozen();
  EXPECT_EQ(kept, (Array<float>{1, 2}));
  EXPECT_EQ(lent(0).frozen().data(), memory->data()) << "what never changes is not copied";
  (*memory)[0] = 7;
  EXPECT_EQ(kept[0], 1);
  EXPECT_EQ(Value(lent(3)).frozen(), Value(Array<float>{7, 2}));
}

TEST(Value, HoldsHalvesAndBooleans) {
  EXPECT_EQ(Value(Half(0.5f)).number_or(9), 0.5);
  EXPECT_EQ(Value(Half(0.5f)).to_string(), "0.5");
  EXPECT_EQ(Value(Vec3h(Vec3f(1, 2, 3))).to_string(), "(1, 2, 3)");
  EXPECT_EQ(Value(Array<bool>{true, false}).to_string(), "[true, false]");
  EXPECT_FALSE((std::is_constructible_v<Value, unsigned long>)) << "no number becomes a half by itself";
  std::array<double, 4> components{};
  EXPECT_EQ(Value(Vec2d(1, 2)).components(&components), 2u);
  EXPECT_EQ(components[1], 2);
  EXPECT_EQ(Value(Half(3.0f)).components(&components), 1u);
  EXPECT_EQ(Value("3").components(&components), 0u);
}

TEST(Value, EqualityComparesTypeAndContents) {
  EXPECT_EQ(Value(1), Value(1));
  EXPECT_FALSE(Value(1) == Value(1.0f));
  EXPECT_EQ(Value(Array<float>{1, 2}), Value(Array<float>{1, 2}));
  EXPECT_FALSE(Value(Array<float>{1, 2}) == Value(Array<float>{1, 3}));
  EXPECT_EQ(Value(NAN), Value(NAN)) << "a setting of NaN set twice must not count as a change";
  const auto dictionary = [](int n) { return std::make_shared<const Dictionary>(Dictionary{{"k", n}}); };
  EXPECT_EQ(Value(dictionary(1)), Value(dictionary(1)));
  EXPECT_FALSE(Value(dictionary(1)) == Value(dictionary(2)));
}

TEST(Value, TextIsStable) {
  EXPECT_EQ(Value().to_string(), "empty");
  EXPECT_EQ(Value(true).to_string(), "true");
  EXPECT_EQ(Value(0.42f).to_string(), "0.42") << "the shortest decimal that reads back as the same float";
  EXPECT_EQ(Value(0.1f + 0.2f).to_string(), "0.3");
  EXPECT_EQ(Value(16777216.0f).to_string(), "16777216");
  EXPECT_EQ(Value(1e-7f).to_string(), "1e-07");
  EXPECT_EQ(Value(1 / 3.0).to_string(), "0.333333333");
  EXPECT_EQ(Value(Vec3f(1, 2, 3.5f)).to_string(), "(1, 2, 3.5)");
  EXPECT_EQ(Value(Array<int32_t>{4, 5}).to_string(), "[4, 5]");
  EXPECT_EQ(Value("x").to_string(), "\"x\"");
  EXPECT_EQ(Value(Path("/p")).to_string(), "</p>");
  EXPECT_EQ(Value(std::make_shared<const Dictionary>(Dictionary{{"a", 1}, {"b", "c"}})).to_string(),
            "{a: 1, b: \"c\"}");
  EXPECT_EQ(Value(Matrix4d()).to_string(), "((1, 0, 0, 0), (0, 1, 0, 0), (0, 0, 1, 0), (0, 0, 0, 1))");
}

TEST(Array, HoldsTheHostsMemoryByItsOwner) {
  auto owner = std::make_shared<std::vector<int32_t>>(std::vector<int32_t>{1, 2, 3});
  Array<int32_t> array(owner, owner->data(), owner->size());
  EXPECT_EQ(array.data(), owner->data()) << "no copy";
  const std::weak_ptr<void> alive = owner;
  owner.reset();
  EXPECT_FALSE(alive.expired());
  EXPECT_EQ(array[2], 3);
  array = {};
  EXPECT_TRUE(alive.expired());
}

TEST(Format, SizesAndComponents) {
  EXPECT_EQ(FormatSize(Format::invalid), 0u);
  EXPECT_EQ(FormatSize(Format::unorm8vec4), 4u);
  EXPECT_EQ(FormatSize(Format::float16vec3), 6u);
  EXPECT_EQ(FormatSize(Format::float32vec2), 8u);
  EXPECT_EQ(FormatSize(Format::int32), 4u);
  EXPECT_EQ(FormatComponents(Format::float32vec3), 3);
  EXPECT_EQ(FormatComponents(Format::int32), 1);
}

}  // namespace
}  // namespace alabaster::hd

#!/usr/bin/env python3
"""The function finder sees every kind of function in a sample, with its length; the check names what is too long."""
import unittest

from check_lengths import faults
from function_finder import find_functions

SAMPLE = r"""
#include "core/math/vector.h"
#define TWICE(x) \
  do { x; x; } while (0)

extern "C" {
int c_function() {  // { a brace in a comment
  return '{';
}
}

namespace alabaster {
namespace {

enum class Word { one, two };
constexpr int kNumbers[] = {1, 2, 3};
const std::map<int, std::function<int(int)>> kTable{{1, [](int i) { return i; }}};
const auto kSquare = [](float x) -> float {
  return x * x;
};

template <class T, class = std::enable_if_t<(sizeof(T) > 4)>>
requires(std::is_integral_v<T>) T wrapped_signature(const std::vector<T>& values,
                                                    const Dictionary& settings = {},
                                                    T otherwise = T{1}) noexcept(true) {
  for (T v : values) {
    if (v) return v;
  }
  return otherwise;
}

}  // namespace

class Mesh final : public Shape<Vec3f> {
 public:
  Mesh() = default;
  explicit Mesh(int size) : size_{size}, values_(static_cast<size_t>(size), 0), names_{"a", "b"} {
    assert(size > 0);
  }
  bool operator==(const Mesh& o) const { return size_ == o.size_; }
  float operator()(int i) const {
    return values_[i];
  }
  int size() const override { return size_; }
  struct Inner {
    int depth() const {
      return 1;
    }
  };

 private:
  int size_{0};
  std::vector<float> values_ = {1, 2};
  std::vector<std::string> names_{};
};

auto Mesh::many_lambdas(std::span<const int> values) const -> std::vector<int> {
  const auto twice = [](int i) { return 2 * i; };
  const auto report = [&](const char* text) {
    if (text) return "{";
    return R"(}}}
    raw {{{ text
    )";
  };
  struct Local {
    int f() { return 1; }
  };
  return transform(values, [&](int i) {
    return twice(i);
  });
}

Mesh::~Mesh() {}

TEST(Mesh, Has) {
  EXPECT_TRUE(true);
}

INSTANTIATE_TEST_SUITE_P(All, Mesh, testing::Values(Case{1}, Case{2}), [](const auto& info) { return info.name; });

const char* text() {
  return R"text(
one { line
another
)text";
}

}  // namespace alabaster
"""


class FunctionFinder(unittest.TestCase):
    def test_finds_every_kind_of_function(self):
        found = [(f.name, f.lines) for f in find_functions(SAMPLE)]
        self.assertEqual(found, [
            ("c_function", 3), ("kSquare", 3), ("wrapped_signature", 9), ("Mesh", 3), ("operator_", 1), ("operator_", 3),
            ("size", 1), ("depth", 3), ("Mesh::many_lambdas", 14), ("Mesh::~Mesh", 1), ("Mesh.Has", 3), ("text", 4)])

    def test_lines_are_those_of_the_file(self):
        lines = SAMPLE.splitlines()
        for function in find_functions(SAMPLE):
            self.assertIn(function.name.split("::")[-1].split(".")[-1].rstrip("_"), "".join(lines[function.first - 1:function.first + 1]))
            self.assertIn("}", lines[function.last - 1])


def function(lines, decisions):
    """A member function with so many lines and decisions."""
    body = ["    if (a && b) g();"] * (decisions // 2) + ["    if (a) g();"] * (decisions % 2)
    return "struct A {\n  void f(int a,\n         int b) {\n" + "\n".join(body + ["    g();"] * (lines - 3 - len(body))) + "\n  }\n};\n"


class Lengths(unittest.TestCase):
    def test_a_straight_function_may_have_120_lines(self):
        self.assertEqual(list(faults("a.h", function(120, 5), {})), [])
        self.assertEqual(list(faults("a.h", function(121, 5), {})), ["a.h:2: f has 121 lines; at most 120"])

    def test_a_function_that_branches_may_have_40(self):
        self.assertEqual(list(faults("a.h", function(40, 6), {})), [])
        self.assertEqual(list(faults("a.h", function(41, 6), {})), ["a.h:2: f with 6 decisions has 41 lines; at most 40"])

    def test_decisions_are_counted(self):
        text = "int f() {\n  // if\n  switch (a) { case 1: case 2: return b ? 1 : 2; }\n  try { for (;;) while (x || y) g(\"if\"); } catch (...) {}\n}\n"
        self.assertEqual([f.decisions for f in find_functions(text)], [7])

    def test_listed_functions_may_not_grow(self):
        self.assertEqual(list(faults("a.h", function(50, 6), {"f": 50})), [])
        self.assertEqual(list(faults("a.h", function(51, 6), {"f": 50})), ["a.h:2: f has grown from 50 to 51 lines; at most 40 are wanted"])

    def test_the_list_shrinks(self):
        self.assertEqual(list(faults("a.h", function(45, 6), {"f": 50})), ["a.h:2: f has 45 lines: say so in long_functions.txt, which has 50"])
        self.assertEqual(list(faults("a.h", function(40, 6), {"f": 50})), ["a.h: f is no longer too long: take it out of long_functions.txt"])

    def test_a_long_file_is_named(self):
        self.assertEqual(list(faults("a.h", "int a;\n" * 600, {})), [])
        self.assertEqual(list(faults("a.h", "int a;\n" * 601, {})), ["a.h: 601 lines; at most 600: split the file"])


if __name__ == "__main__":
    unittest.main()

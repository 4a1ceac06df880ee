// CHECK and DCHECK, as pbrt has them: conditions that only a fault of ours can break. A failed one throws, because the
// library never ends its host's process; the driver of the work catches it (a render session fails with the message and
// the sample). CHECK is for rare questions, DCHECK for inner loops: release builds leave it out.
#pragma once

#include <locale>
#include <sstream>
#include <stdexcept>
#include <string>
#include <string_view>

namespace alabaster {

class CheckFailure : public std::logic_error {
 public:
  using std::logic_error::logic_error;
};

namespace check_detail {

/// The part of a path from the repository's root on: messages carry no path of the machine that built the library.
inline std::string_view from_root(std::string_view file) {
  for (const std::string_view room : {"/testenv/", "/delegate/", "/core/"})
    if (const size_t found = file.rfind(room); found != std::string_view::npos) return file.substr(found + 1);
  return file;
}

[[noreturn]] inline void fail(const char* condition, const std::string& values, std::string_view file, int line) {
  throw CheckFailure("check failed: " + std::string(condition) + values + " (" + std::string(from_root(file)) + ":" +
                     std::to_string(line) + ")");
}

template <class A, class B>
[[noreturn]] void fail_comparison(const char* condition, const A& a, const B& b, std::string_view file, int line) {
  std::ostringstream values;
  values.imbue(std::locale::classic());  // not the host's
  values.precision(9);
  values << ": " << a << " against " << b;
  fail(condition, values.str(), file, line);
}

}  // namespace check_detail
}  // namespace alabaster

#define CHECK(condition) ((condition) ? void(0) : ::alabaster::check_detail::fail(#condition, "", __FILE__, __LINE__))
#define ALABASTER_CHECK_COMPARISON(a, op, b)                                                               \
  do {                                                                                                     \
    const auto& check_a = (a);                                                                             \
    const auto& check_b = (b);                                                                             \
    if (!(check_a op check_b))                                                                             \
      ::alabaster::check_detail::fail_comparison(#a " " #op " " #b, check_a, check_b, __FILE__, __LINE__); \
  } while (false)
#define CHECK_EQ(a, b) ALABASTER_CHECK_COMPARISON(a, ==, b)
#define CHECK_LT(a, b) ALABASTER_CHECK_COMPARISON(a, <, b)
#define CHECK_LE(a, b) ALABASTER_CHECK_COMPARISON(a, <=, b)
#define CHECK_GE(a, b) ALABASTER_CHECK_COMPARISON(a, >=, b)

#ifdef NDEBUG
#define DCHECK(condition) void(0)
#define DCHECK_LE(a, b) void(0)
#define DCHECK_GE(a, b) void(0)
#else
#define DCHECK(condition) CHECK(condition)
#define DCHECK_LE(a, b) CHECK_LE(a, b)
#define DCHECK_GE(a, b) CHECK_GE(a, b)
#endif

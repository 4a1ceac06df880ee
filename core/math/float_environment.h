// The floating-point environment in which everything is computed: rounding to nearest, subnormal numbers, no traps.
#pragma once

#include <cfenv>

namespace alabaster {

/// Sets the default environment for this thread and, when it ends, puts back that of before with its flags. A host may
/// have set another rounding mode, flush subnormals to zero or trap: every entry into the library has one, every thread
/// of the library, and every task that TBB may run in an arena of the host's, which has the host's environment.
class FloatEnvironment {
 public:
  FloatEnvironment() noexcept {
    std::fegetenv(&before_);
    std::fesetenv(FE_DFL_ENV);
  }
  ~FloatEnvironment() { std::fesetenv(&before_); }
  FloatEnvironment(const FloatEnvironment&) = delete;
  FloatEnvironment& operator=(const FloatEnvironment&) = delete;

 private:
  std::fenv_t before_;
};

}  // namespace alabaster

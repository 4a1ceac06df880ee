// Our own library in the place of Open Image Denoise, so that it is tested on machines that have none.
#pragma once

#include <cstdlib>
#include <optional>
#include <string>

#include "testenv/support/build_paths.h"

namespace alabaster::testing {

/// Sets environment variables for the scope, one value each.
class Environment {
 public:
  Environment(const char* name, const std::string& value) : name_(name) {
    if (const char* old = std::getenv(name)) old_ = old;
    setenv(name, value.c_str(), 1);
  }
  ~Environment() {
    if (old_)
      setenv(name_, old_->c_str(), 1);
    else
      unsetenv(name_);
  }
  Environment(const Environment&) = delete;
  Environment& operator=(const Environment&) = delete;

 private:
  const char* name_;
  std::optional<std::string> old_;
};

/// The fake library of testenv/support/fake_oidn, which does what $FAKE_OIDN says.
struct FakeOidn {
  explicit FakeOidn(const std::string& behaviour = "") : behaviour_("FAKE_OIDN", behaviour) {}
  Environment library_{"ALABASTER_OIDN", kFakeOidn};
  Environment behaviour_;
};

}  // namespace alabaster::testing

#pragma once

#include <gtest/gtest.h>

#include "delegate/view/parameter_rows.h"

namespace alabaster::view {

/// The row of a schema with this name; fails the test if there is none.
inline ParameterRow row_of(const char* schema, const std::string& name) {
  for (const ParameterRow& row : parameter_rows(schema))
    if (row.name == name) return row;
  ADD_FAILURE() << name;
  return {};
}

}  // namespace alabaster::view

// Parameters of prims: values by the rows of core's tables, and reports of those that do not fit.
#pragma once

#include "delegate/prims/diagnostics.h"
#include "delegate/support/parameters.h"

namespace alabaster::hd::prims {

/// Reports what is wrong with parameter `name` of `where`, and the value that is used instead.
void report_fault(const alabaster::DiagnosticSink& sink, const std::string& where, const std::string& name,
                  support::ParameterFault fault, const Value& value);

/// Sets the parameters of a table: get(name), or the default where that is empty or faulty (reported).
template <class Rows, class T, class Get>
void read_parameters(const Rows& rows, const Get& get, const std::string& where, const alabaster::DiagnosticSink& sink,
                     T* object) {
  const T defaults;
  for (const auto& row : rows) {
    const Value value = get(row.name);
    support::set_parameter(row, support::get_parameter(row, defaults), object);
    if (!value.empty()) report_fault(sink, where, row.name, support::set_parameter(row, value, object), value);
  }
}

}  // namespace alabaster::hd::prims

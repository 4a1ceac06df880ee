// Parameters of prims: values by the rows of core's tables, and reports of those that do not fit.
#pragma once

#include "delegate/prims/diagnostics.h"
#include "delegate/support/parameters.h"

namespace alabaster::hd::prims {

using support::get_parameter;
using support::ParameterFault;
using support::read_color;
using support::read_number;
using support::set_parameter;

/// Reports what is wrong with parameter `name` of `where`, and the value that is used instead.
void report_fault(const alabaster::DiagnosticSink& sink, const std::string& where, const std::string& name,
                  ParameterFault fault, const Value& value);

}  // namespace alabaster::hd::prims

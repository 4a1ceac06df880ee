#include "delegate/prims/parameters.h"

namespace alabaster::hd::prims {

void report_fault(const alabaster::DiagnosticSink& sink, const std::string& where, const std::string& name,
                  support::ParameterFault fault, const Value& value) {
  if (fault == support::ParameterFault::type)
    alabaster::report(sink, alabaster::Severity::warning, "parameter.type", where,
                      name + " cannot be '" + value.to_string() + "'; the default is used");
  if (fault == support::ParameterFault::range)
    alabaster::report(sink, alabaster::Severity::warning, "parameter.range", where,
                      name + " = " + value.to_string() + " is out of range; the nearest value in range is used");
}

}  // namespace alabaster::hd::prims

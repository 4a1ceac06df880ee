#include "delegate/prims/parameters.h"

namespace alabaster::hd::prims {

void report_fault(const alabaster::DiagnosticSink& sink, const std::string& where, const std::string& name,
                  ParameterFault fault, const Value& value) {
  if (fault == ParameterFault::type)
    alabaster::report(sink, alabaster::Severity::warning, "parameter.type", where,
                      name + " cannot be '" + value.to_string() + "'; the default is used");
  if (fault == ParameterFault::range)
    alabaster::report(sink, alabaster::Severity::warning, "parameter.range", where,
                      name + " = " + value.to_string() + " is out of range; the nearest value in range is used");
}

}  // namespace alabaster::hd::prims

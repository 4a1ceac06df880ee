// Values across the C door. Internal to this room.
#pragma once

#include <deque>

#include "delegate/c_api/handles.h"

namespace alabaster::hd::c_api {

/// Takes values of a host. A fault does not end the reading, since every value that is lent must be given back:
/// finish() throws what was wrong first.
class ValueReader {
 public:
  Value value(const AlabasterValue& in);
  Array<int32_t> ints(const AlabasterValue& in, const char* name) { return array<int32_t>(in, name); }
  Array<float> floats(const AlabasterValue& in, const char* name) { return array<float>(in, name); }
  std::vector<Token> tokens(const AlabasterValue& in, const char* name) {
    const Array<Token> names = array<Token>(in, name);
    return {names.begin(), names.end()};
  }
  std::map<Token, Value> parameters(const AlabasterParameter* parameters, size_t count);
  Dictionary dictionary(const AlabasterParameter* parameters, size_t count);
  TimeSamples<Matrix4d> transforms(const AlabasterMotion& motion);
  TimeSamples<Value> samples(const AlabasterMotion& motion);
  void fault(const std::string& text) {
    if (fault_.empty()) fault_ = text;
  }
  void finish() const {
    if (!fault_.empty()) throw bad_argument(fault_);
  }

 private:
  template <class T>
  Array<T> array(const AlabasterValue& in, const char* name) {
    const Value held = value(in);
    if (const auto* values = held.get<Array<T>>()) return *values;
    if (!held.empty()) fault(std::string(name) + " has the wrong type");
    return {};
  }
  std::string fault_;
};

Matrix4d matrix_of(const double* matrix);  // null: identity

/// A value of ours as hosts read it; it must outlive this.
class ValueView {
 public:
  explicit ValueView(const Value& value);
  ValueView(const ValueView&) = delete;
  ValueView& operator=(const ValueView&) = delete;
  const AlabasterValue& get() const { return view_; }

 private:
  AlabasterValue view_{};
  uint8_t bool_ = 0;
  std::vector<const char*> texts_;
  std::deque<ValueView> inner_;
  std::vector<AlabasterParameter> entries_;
};

void visit_dictionary(const Dictionary& values, AlabasterVisit visit, void* user);

}  // namespace alabaster::hd::c_api

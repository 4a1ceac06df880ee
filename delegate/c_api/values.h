// Values across the C interface. Internal to this room.
#pragma once

#include <deque>

#include "delegate/c_api/handles.h"
#include "delegate/host/scene_fields.h"

namespace alabaster::hd::c_api {

/// The arguments of a command, or settings.
struct ParameterList {
  const AlabasterParameter* first = nullptr;
  size_t count = 0;
};

/// Takes the values of one argument of a call. The arrays that it lends are given back when the reader ends, unless
/// take() has come: then each is given back when nothing reads it any more. So whatever fails, each comes back once.
class ValueReader {
 public:
  /// `given` may be null.
  template <class T>
  explicit ValueReader(const T* given) : given_(given), give_back_(&give_back_all<T>) {}
  ~ValueReader() {
    if (given_) give_back_(given_);
  }
  ValueReader(const ValueReader&) = delete;
  ValueReader& operator=(const ValueReader&) = delete;

  /// `name` is that of messages.
  Value value(const AlabasterValue& in, const char* name);
  std::vector<Token> tokens(const AlabasterValue& in, const char* name);
  host::Fields fields(const ParameterList& in);
  Dictionary dictionary(const ParameterList& in, const char* name);
  /// All that `given` lends has been read.
  void take();

 private:
  /// An array that is lent.
  struct Loan {
    ~Loan();
    void (*release)(void*) = nullptr;
    void* owner = nullptr;
    bool is_taken = false;  // else the reader gives it back
  };
  template <class T>
  static void give_back_all(const void* given);
  std::shared_ptr<const void> borrow(const AlabasterValue& in);
  Value samples(const AlabasterValue& in, const char* name);

  const void* given_;
  void (*give_back_)(const void*);
  std::vector<std::shared_ptr<Loan>> loans_;
};

/// A value of ours as hosts read it; it must outlive this.
class ValueView {
 public:
  explicit ValueView(const Value& value);
  ValueView(const ValueView&) = delete;
  ValueView& operator=(const ValueView&) = delete;
  const AlabasterValue& get() const { return view_; }

 private:
  AlabasterValue view_{};
  std::vector<const char*> texts_;
  std::deque<ValueView> inner_;
  std::vector<AlabasterParameter> entries_;
  std::vector<AlabasterSample> samples_;
};

/// Calls `visit` with one value, or with each of a dictionary.
void visit_value(const char* name, const Value& value, AlabasterVisit visit, void* user);
void visit_dictionary(const Dictionary& values, AlabasterVisit visit, void* user);

}  // namespace alabaster::hd::c_api

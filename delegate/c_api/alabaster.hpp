// The C interface for C++17: handles that destroy themselves, values that hold what they point at, exceptions. Header
// only: it is compiled into the host, and nothing of C++ crosses into the library. alabaster.h says what every call
// does.
#pragma once

#include <array>
#include <memory>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

#include "alabaster.h"

namespace alabaster::c_api {

class Error : public std::runtime_error {
 public:
  Error(AlabasterStatus failed_with, const std::string& text) : std::runtime_error(text), status(failed_with) {}
  AlabasterStatus status;
};

inline const AlabasterApi& api() {
  static const AlabasterApi* const table = alabaster_api(ALABASTER_API_VERSION);
  if (!table)
    throw Error(ALABASTER_INTERNAL, "libhdAlabaster is older than the header that this program was built with");
  return *table;
}

inline void check(AlabasterStatus status) {
  if (status != ALABASTER_OK) throw Error(status, api().last_error());
}

/// A struct with its size set.
template <class T>
T sized() {
  T made{};
  made.size = sizeof made;
  return made;
}

// Values -------------------------------------------------------------------------------------------
/// Null in a call, as a struct's member or as an argument, means the default.
inline const char* or_null(const std::string& text) {
  return text.empty() ? nullptr : text.c_str();
}

class Value {
 public:
  Value() = default;
  Value(bool v) : Value(ALABASTER_BOOL, uint8_t(v)) {}                     // NOLINT(google-explicit-constructor)
  Value(int32_t v) : Value(ALABASTER_INT, v) {}                            // NOLINT(google-explicit-constructor)
  Value(int64_t v) : Value(ALABASTER_INT64, v) {}                          // NOLINT(google-explicit-constructor)
  Value(float v) : Value(ALABASTER_FLOAT, v) {}                            // NOLINT(google-explicit-constructor)
  Value(double v) : Value(ALABASTER_DOUBLE, v) {}                          // NOLINT(google-explicit-constructor)
  Value(std::array<float, 2> v) : Value(ALABASTER_FLOAT2, v) {}            // NOLINT(google-explicit-constructor)
  Value(std::array<float, 3> v) : Value(ALABASTER_FLOAT3, v) {}            // NOLINT(google-explicit-constructor)
  Value(std::array<float, 4> v) : Value(ALABASTER_FLOAT4, v) {}            // NOLINT(google-explicit-constructor)
  Value(const std::array<double, 16>& v) : Value(ALABASTER_MATRIX, v) {}   // NOLINT(google-explicit-constructor)
  Value(const std::string& text) : Value(text.c_str()) {}                  // NOLINT(google-explicit-constructor)
  Value(const char* text) : Value(ALABASTER_STRING, std::string(text)) {}  // NOLINT(google-explicit-constructor)
  /// Of a prim, or of what an input of a material's node is connected to: "node.output".
  static Value path(const std::string& path) { return Value(ALABASTER_PATH, path); }
  static Value paths(std::vector<std::string> paths) { return Value(ALABASTER_PATH, std::move(paths)); }
  /// An array of words.
  static Value tokens(std::vector<std::string> words) { return Value(ALABASTER_TOKEN, std::move(words)); }
  /// Values at times.
  static Value samples(std::vector<std::pair<double, Value>> values) {
    Value made;
    made.type_ = ALABASTER_SAMPLES, made.count_ = values.size();
    made.samples_ = std::make_shared<const Samples>(Samples{std::move(values)});
    return made;
  }

  /// An array that the library reads where it lies, for as long as it holds `owner`. Elements are of `type`. `edited`:
  /// the host edits it in place (ALABASTER_EDITED_ARRAY).
  static Value lend(int32_t type, std::shared_ptr<const void> owner, const void* data, size_t count,
                    bool edited = false) {
    Value made;
    made.type_ = type, made.data_ = data, made.count_ = count;
    made.is_array_ = edited ? ALABASTER_EDITED_ARRAY : ALABASTER_ARRAY;
    made.owner_ = std::move(owner);
    return made;
  }
  /// An array without an owner: its memory must live until the call, which copies it.
  static Value array(int32_t type, const void* data, size_t count) { return lend(type, nullptr, data, count); }
  /// `values` are the components of elements of `type`, one after the other.
  template <class T>
  static Value of(int32_t type, std::vector<T> values, size_t components = 1) {
    auto held = std::make_shared<const std::vector<T>>(std::move(values));
    return lend(type, held, held->data(), held->size() / components);
  }

  /// For one call, to which it gives what is lent, and during which this lives. Any thread.
  AlabasterValue pass() const {
    if (samples_) return samples_->pass();
    AlabasterValue raw = {type_, is_array_, data_, count_, nullptr, nullptr};
    if (!owner_) return raw;
    raw.owner = new std::shared_ptr<const void>(owner_);
    raw.release = [](void* owner) { delete static_cast<std::shared_ptr<const void>*>(owner); };
    return raw;
  }
  int32_t type() const { return type_; }

 private:
  struct Samples {
    std::vector<std::pair<double, Value>> values;
    AlabasterValue pass() const;
  };
  struct Texts {
    std::vector<std::string> held;
    std::vector<const char*> raw;
  };
  Value(int32_t type, const std::string& text) : type_(type), count_(1) {
    bytes_ = std::make_shared<const std::vector<char>>(text.c_str(), text.c_str() + text.size() + 1);
    data_ = bytes_->data();
  }
  Value(int32_t type, std::vector<std::string> texts)
      : type_(type), is_array_(ALABASTER_ARRAY), count_(texts.size()), texts_(std::make_shared<Texts>()) {
    texts_->held = std::move(texts);
    for (const std::string& text : texts_->held) texts_->raw.push_back(text.c_str());
    data_ = texts_->raw.data();
  }
  template <class T>
  Value(int32_t type, const T& v) : type_(type), count_(1) {
    const auto* first = reinterpret_cast<const char*>(&v);
    bytes_ = std::make_shared<const std::vector<char>>(first, first + sizeof v);
    data_ = bytes_->data();
  }

  int32_t type_ = ALABASTER_NONE;
  int32_t is_array_ = ALABASTER_SCALAR;
  const void* data_ = nullptr;
  size_t count_ = 0;
  std::shared_ptr<const std::vector<char>> bytes_;  // of what is no array
  std::shared_ptr<const void> owner_;
  std::shared_ptr<Texts> texts_;
  std::shared_ptr<const Samples> samples_;
};
inline AlabasterValue Value::Samples::pass() const {
  auto raw = std::make_unique<std::vector<AlabasterSample>>();
  for (const auto& [time, value] : values) raw->push_back({time, value.pass()});
  const size_t count = raw->size();
  const void* data = raw->data();
  return {ALABASTER_SAMPLES,
          ALABASTER_SCALAR,
          data,
          count,
          [](void* owner) { delete static_cast<std::vector<AlabasterSample>*>(owner); },
          raw.release()};
}

using Parameters = std::vector<std::pair<std::string, Value>>;

/// `parameters`, which must outlive it, for one call.
inline std::vector<AlabasterParameter> pass(const Parameters& parameters) {
  std::vector<AlabasterParameter> raw;
  for (const auto& [name, value] : parameters) raw.push_back({name.c_str(), value.pass()});
  return raw;
}

/// A value that the library tells, as a T: a number of any type converts.
template <class T>
T number(const AlabasterValue& value, T otherwise = {}) {
  switch (value.is_array ? int32_t(ALABASTER_NONE) : value.type) {
    case ALABASTER_BOOL:
      return T(*static_cast<const uint8_t*>(value.data));
    case ALABASTER_INT:
      return T(*static_cast<const int32_t*>(value.data));
    case ALABASTER_INT64:
      return T(*static_cast<const int64_t*>(value.data));
    case ALABASTER_UINT:
      return T(*static_cast<const uint32_t*>(value.data));
    case ALABASTER_FLOAT:
      return T(*static_cast<const float*>(value.data));
    case ALABASTER_DOUBLE:
      return T(*static_cast<const double*>(value.data));
    default:
      return otherwise;
  }
}

/// Calls visit(name, value) for what `ask(AlabasterVisit, void*)` tells.
template <class Ask, class Visit>
void tell(const Ask& ask, Visit visit) {
  check(
      ask([](void* user, const char* name, const AlabasterValue* value) { (*static_cast<Visit*>(user))(name, *value); },
          static_cast<void*>(&visit)));
}

// Handles ------------------------------------------------------------------------------------------
struct Destroy {
  void operator()(AlabasterScene* handle) const { api().scene_destroy(handle); }
  void operator()(AlabasterDelegate* handle) const { api().delegate_destroy(handle); }
  void operator()(AlabasterPass* handle) const { api().pass_destroy(handle); }
  void operator()(AlabasterBuffer* handle) const { api().buffer_destroy(handle); }
  void operator()(AlabasterDisplay* handle) const { api().display_destroy(handle); }
};
using Scene = std::unique_ptr<AlabasterScene, Destroy>;
using Delegate = std::unique_ptr<AlabasterDelegate, Destroy>;
using Pass = std::unique_ptr<AlabasterPass, Destroy>;
using Buffer = std::unique_ptr<AlabasterBuffer, Destroy>;
using Display = std::unique_ptr<AlabasterDisplay, Destroy>;

inline Scene make_scene(AlabasterReport report = nullptr, void* user = nullptr) {
  AlabasterScene* made = nullptr;
  check(api().scene_create(report, user, &made));
  return Scene(made);
}

/// Makes a prim, or replaces the one of that path. alabaster_types.h lists the kinds.
inline void set(const Scene& scene, const std::string& path, const std::string& kind, const Parameters& fields) {
  const auto raw = pass(fields);
  check(api().scene_set(scene.get(), path.c_str(), kind.c_str(), raw.data(), raw.size()));
}
/// Changes fields of a prim.
inline void edit(const Scene& scene, const std::string& path, const Parameters& fields) {
  const auto raw = pass(fields);
  check(api().scene_edit(scene.get(), path.c_str(), raw.data(), raw.size()));
}

/// Writes the scene as a pass of `frame` draws it; null: as the first render settings say.
inline void write_scene(const Scene& scene, const std::string& file, const AlabasterFrame* frame = nullptr,
                        const Parameters& settings = {}) {
  const auto raw = pass(settings);
  check(api().scene_write(scene.get(), file.c_str(), frame, raw.data(), raw.size()));
}

inline Delegate make_delegate(const Scene& scene, const Parameters& settings = {}, AlabasterReport report = nullptr,
                              void* user = nullptr) {
  const auto raw = pass(settings);
  auto options = sized<AlabasterDelegateOptions>();
  options.report = report, options.user = user;
  options.settings = raw.data(), options.setting_count = raw.size();
  AlabasterDelegate* made = nullptr;
  check(api().delegate_create(&options, scene.get(), &made));
  return Delegate(made);
}

inline Pass make_pass(const Delegate& delegate) {
  AlabasterPass* made = nullptr;
  check(api().pass_create(delegate.get(), &made));
  return Pass(made);
}

/// In the format that suits the AOV.
inline Buffer make_buffer(const Delegate& delegate, const std::string& aov, int32_t width, int32_t height) {
  int32_t format = ALABASTER_FORMAT_NONE;
  check(api().aov_format(delegate.get(), aov.c_str(), &format));
  if (format == ALABASTER_FORMAT_NONE) throw Error(ALABASTER_NOT_FOUND, api().last_error());
  AlabasterBuffer* made = nullptr;
  check(api().buffer_create(delegate.get(), width, height, format, &made));
  return Buffer(made);
}

/// Pixels as they were when it was made, for as long as it lives, whatever happens to the buffer.
class Pixels {
 public:
  explicit Pixels(const Buffer& buffer) : raw_(sized<AlabasterPixels>()) {
    check(api().buffer_map(buffer.get(), &raw_));
  }
  ~Pixels() {
    if (raw_.mapping) api().pixels_unmap(&raw_);
  }
  Pixels(const Pixels&) = delete;
  Pixels& operator=(const Pixels&) = delete;
  const AlabasterPixels& get() const { return raw_; }

 private:
  AlabasterPixels raw_;
};

}  // namespace alabaster::c_api

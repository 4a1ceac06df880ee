#include "delegate/c_api/values.h"

#include <limits>

namespace alabaster::hd::c_api {
namespace {

template <class T>
inline constexpr int32_t kType = ALABASTER_NONE;
template <>
inline constexpr int32_t kType<int32_t> = ALABASTER_INT;
template <>
inline constexpr int32_t kType<int64_t> = ALABASTER_INT64;
template <>
inline constexpr int32_t kType<uint32_t> = ALABASTER_UINT;
template <>
inline constexpr int32_t kType<float> = ALABASTER_FLOAT;
template <>
inline constexpr int32_t kType<double> = ALABASTER_DOUBLE;
template <>
inline constexpr int32_t kType<Vec2f> = ALABASTER_FLOAT2;
template <>
inline constexpr int32_t kType<Vec3f> = ALABASTER_FLOAT3;
template <>
inline constexpr int32_t kType<Vec4f> = ALABASTER_FLOAT4;
template <>
inline constexpr int32_t kType<Vec2i> = ALABASTER_INT2;
template <>
inline constexpr int32_t kType<Vec3i> = ALABASTER_INT3;
template <>
inline constexpr int32_t kType<Vec3d> = ALABASTER_DOUBLE3;
template <>
inline constexpr int32_t kType<Quatf> = ALABASTER_QUATERNION;
template <>
inline constexpr int32_t kType<Matrix4d> = ALABASTER_MATRIX;
template <>
inline constexpr int32_t kType<Half> = ALABASTER_FLOAT16;
template <>
inline constexpr int32_t kType<Vec2h> = ALABASTER_FLOAT16_2;
template <>
inline constexpr int32_t kType<Vec3h> = ALABASTER_FLOAT16_3;
template <>
inline constexpr int32_t kType<Vec4h> = ALABASTER_FLOAT16_4;
template <>
inline constexpr int32_t kType<Vec2d> = ALABASTER_DOUBLE2;
template <>
inline constexpr int32_t kType<Vec4d> = ALABASTER_DOUBLE4;
template <>
inline constexpr int32_t kType<Quath> = ALABASTER_QUATERNION16;
template <>
inline constexpr int32_t kType<bool> = ALABASTER_BOOL;
template <>
inline constexpr int32_t kType<Token> = ALABASTER_TOKEN;
template <>
inline constexpr int32_t kType<std::string> = ALABASTER_STRING;
template <>
inline constexpr int32_t kType<Path> = ALABASTER_PATH;

// Hosts' numbers are read as Imath's types where they lie.
static_assert(sizeof(Vec2f) == 8 && sizeof(Vec3f) == 12 && sizeof(Vec4f) == 16 && sizeof(Vec3d) == 24);
static_assert(sizeof(Half) == 2 && sizeof(Vec3h) == 6 && sizeof(Quath) == 8 && sizeof(Vec2d) == 16 &&
              sizeof(bool) == 1);
static_assert(sizeof(Quatf) == 16 && offsetof(Quatf, r) == 0 && sizeof(Matrix4d) == 128);

template <class T>
Value scalar(const AlabasterValue& in) {
  T value;
  std::memcpy(static_cast<void*>(&value), in.data, sizeof value);
  return value;
}

constexpr const char* kTypeNames[] = {
    "none",   "bool",       "int",  "int64",   "uint",       "float",  "double",  "float2",  "float3",
    "float4", "int2",       "int3", "double3", "quaternion", "matrix", "token",   "string",  "path",
    "asset",  "dictionary", "half", "half2",   "half3",      "half4",  "double2", "double4", "quaternion of halves"};
std::string type_name(int32_t type) {
  const bool known = type >= 0 && size_t(type) < std::size(kTypeNames);
  return known ? kTypeNames[type] : "type " + std::to_string(type);
}
std::string type_name(const AlabasterValue& in) {
  return (in.is_array ? "an array of " : "a value of ") + type_name(in.type);
}
Failure bad_value(const char* name, const std::string& text) {
  return bad_argument("'" + std::string(name) + "': " + text);
}

// Each time it is lent, memory that the host edits counts as edited.
uint64_t version_of(const AlabasterValue& in) {
  static std::atomic<uint64_t> lent{0};
  return in.is_array == ALABASTER_EDITED_ARRAY ? ++lent : 0;
}

template <class T>
Value lent_or_copied(const AlabasterValue& in, std::shared_ptr<const void> owner) {
  const auto* data = static_cast<const T*>(in.data);
  if (in.count > std::numeric_limits<size_t>::max() / 2 / sizeof(T))
    throw bad_argument("an array of " + std::to_string(in.count) + " elements is larger than any memory");
  if (!owner) return Array<T>(std::vector<T>(data, data + in.count));
  if (reinterpret_cast<uintptr_t>(data) % alignof(T) != 0) throw bad_argument("a lent array is not aligned");
  return Array<T>(std::move(owner), data, in.count, version_of(in));
}

template <class T>
Value texts(const AlabasterValue& in) {
  const auto* data = static_cast<const char* const*>(in.data);
  std::vector<T> held;
  for (size_t i = 0; i < in.count; ++i) held.emplace_back(std::string(text_or(data[i], "")));
  return Array<T>(std::move(held));
}

Value array_of(const AlabasterValue& in, std::shared_ptr<const void> owner) {
  switch (in.type) {
    case ALABASTER_INT:
      return lent_or_copied<int32_t>(in, std::move(owner));
    case ALABASTER_FLOAT:
      return lent_or_copied<float>(in, std::move(owner));
    case ALABASTER_DOUBLE:
      return lent_or_copied<double>(in, std::move(owner));
    case ALABASTER_FLOAT2:
      return lent_or_copied<Vec2f>(in, std::move(owner));
    case ALABASTER_FLOAT3:
      return lent_or_copied<Vec3f>(in, std::move(owner));
    case ALABASTER_FLOAT4:
      return lent_or_copied<Vec4f>(in, std::move(owner));
    case ALABASTER_QUATERNION:
      return lent_or_copied<Quatf>(in, std::move(owner));
    case ALABASTER_MATRIX:
      return lent_or_copied<Matrix4d>(in, std::move(owner));
    case ALABASTER_BOOL:
      return lent_or_copied<bool>(in, std::move(owner));
    case ALABASTER_INT64:
      return lent_or_copied<int64_t>(in, std::move(owner));
    case ALABASTER_UINT:
      return lent_or_copied<uint32_t>(in, std::move(owner));
    case ALABASTER_INT2:
      return lent_or_copied<Vec2i>(in, std::move(owner));
    case ALABASTER_INT3:
      return lent_or_copied<Vec3i>(in, std::move(owner));
    case ALABASTER_DOUBLE2:
      return lent_or_copied<Vec2d>(in, std::move(owner));
    case ALABASTER_DOUBLE3:
      return lent_or_copied<Vec3d>(in, std::move(owner));
    case ALABASTER_DOUBLE4:
      return lent_or_copied<Vec4d>(in, std::move(owner));
    case ALABASTER_FLOAT16:
      return lent_or_copied<Half>(in, std::move(owner));
    case ALABASTER_FLOAT16_2:
      return lent_or_copied<Vec2h>(in, std::move(owner));
    case ALABASTER_FLOAT16_3:
      return lent_or_copied<Vec3h>(in, std::move(owner));
    case ALABASTER_FLOAT16_4:
      return lent_or_copied<Vec4h>(in, std::move(owner));
    case ALABASTER_QUATERNION16:
      return lent_or_copied<Quath>(in, std::move(owner));
    case ALABASTER_PATH:
      return texts<Path>(in);
    case ALABASTER_TOKEN:
      return texts<Token>(in);
    case ALABASTER_STRING:
      return texts<std::string>(in);
  }
  throw bad_argument("there are no arrays of " + type_name(in.type));
}

Value scalar_of(const AlabasterValue& in) {
  const auto* text = static_cast<const char*>(in.data);
  switch (in.type) {
    case ALABASTER_BOOL:
      return *static_cast<const uint8_t*>(in.data) != 0;
    case ALABASTER_INT:
      return scalar<int32_t>(in);
    case ALABASTER_INT64:
      return scalar<int64_t>(in);
    case ALABASTER_UINT:
      return scalar<uint32_t>(in);
    case ALABASTER_FLOAT:
      return scalar<float>(in);
    case ALABASTER_DOUBLE:
      return scalar<double>(in);
    case ALABASTER_FLOAT2:
      return scalar<Vec2f>(in);
    case ALABASTER_FLOAT3:
      return scalar<Vec3f>(in);
    case ALABASTER_FLOAT4:
      return scalar<Vec4f>(in);
    case ALABASTER_INT2:
      return scalar<Vec2i>(in);
    case ALABASTER_INT3:
      return scalar<Vec3i>(in);
    case ALABASTER_DOUBLE2:
      return scalar<Vec2d>(in);
    case ALABASTER_DOUBLE3:
      return scalar<Vec3d>(in);
    case ALABASTER_DOUBLE4:
      return scalar<Vec4d>(in);
    case ALABASTER_FLOAT16:
      return scalar<Half>(in);
    case ALABASTER_FLOAT16_2:
      return scalar<Vec2h>(in);
    case ALABASTER_FLOAT16_3:
      return scalar<Vec3h>(in);
    case ALABASTER_FLOAT16_4:
      return scalar<Vec4h>(in);
    case ALABASTER_QUATERNION:
      return scalar<Quatf>(in);
    case ALABASTER_MATRIX:
      return scalar<Matrix4d>(in);
    case ALABASTER_TOKEN:
      return Token(text);
    case ALABASTER_STRING:
      return std::string(text);
    case ALABASTER_PATH:
      return Path(text);
    case ALABASTER_ASSET:
      return AssetPath{text, text, nullptr};
  }
  throw bad_argument("there are no values of " + type_name(in.type));
}

Value read_value(const AlabasterValue& in, std::shared_ptr<const void> owner) {
  if (in.type == ALABASTER_NONE) return {};
  if (in.is_array < ALABASTER_SCALAR || in.is_array > ALABASTER_EDITED_ARRAY)
    throw bad_argument("there is no is_array " + std::to_string(in.is_array));
  if (in.is_array && in.count == 0) {
    static constexpr double kNothing = 0;
    AlabasterValue empty = in;
    empty.data = &kNothing;
    return array_of(empty, nullptr);
  }
  if (!in.data) throw bad_argument("the data of " + type_name(in) + " is null");
  return in.is_array ? array_of(in, std::move(owner)) : scalar_of(in);
}

}  // namespace

std::string name_of(const char* name, const char* what) {
  if (!name || !*name) throw bad_argument(std::string("a ") + what + " has no name");
  return name;
}

ValueReader::Loan::~Loan() {
  if (!is_taken) return;
  const CallbackScope scope;
  release(owner);
}

// Null: the array is not lent.
std::shared_ptr<const void> ValueReader::borrow(const AlabasterValue& in) {
  if (!in.release) return nullptr;
  loans_.push_back(std::make_shared<Loan>(Loan{in.release, in.owner}));
  return loans_.back();
}

Value ValueReader::value(const AlabasterValue& in, const char* name) {
  try {
    return read_value(in, borrow(in));
  } catch (const Failure& failure) {
    throw bad_value(name, failure.what());
  }
}

template <class T>
Array<T> ValueReader::array(const AlabasterValue& in, const char* name) {
  const Value held = value(in, name);
  if (const auto* values = held.get<Array<T>>()) return *values;
  if (!held.empty())
    throw bad_argument(std::string(name) + " has the wrong type: it must be an array of " + type_name(kType<T>) +
                       ", and is " + type_name(in));
  return {};
}
template Array<int32_t> ValueReader::array(const AlabasterValue&, const char*);
template Array<float> ValueReader::array(const AlabasterValue&, const char*);
template Array<Token> ValueReader::array(const AlabasterValue&, const char*);

std::map<Token, Value> ValueReader::parameters(const ParameterList& in, const char* name) {
  std::map<Token, Value> read;
  for (auto& [key, held] : dictionary(in, name)) read[Token(key)] = held;
  return read;
}

Dictionary ValueReader::dictionary(const ParameterList& in, const char* name) {
  Dictionary read;
  for (const AlabasterParameter& one : items(in.first, in.count, name)) {
    const std::string own_name = name_of(one.name, "parameter");
    read[own_name] = value(one.value, own_name.c_str());
  }
  return read;
}

TimeSamples<Value> ValueReader::samples(const AlabasterMotion& motion) {
  TimeSamples<Value> read;
  const auto times = items(motion.times, motion.count, "times of a motion");
  const auto values = items(motion.values, motion.count, "values of a motion");
  for (size_t i = 0; i < motion.count; ++i) {
    read.times.push_back(times[i]);
    read.values.push_back(value(values[i], "motion"));
  }
  return read;
}

TimeSamples<Matrix4d> ValueReader::transforms(const AlabasterMotion& motion) {
  TimeSamples<Matrix4d> read;
  TimeSamples<Value> values = samples(motion);
  read.times = std::move(values.times);
  for (size_t i = 0; i < motion.count; ++i) {
    if (!values.values[i].get<Matrix4d>())
      throw bad_argument("the motion of a transform must be matrices, and has " + type_name(motion.values[i]));
    read.values.push_back(values.values[i].get_or(Matrix4d()));
  }
  return read;
}

void ValueReader::take() {
  given_ = nullptr;
  for (const auto& loan : loans_) loan->is_taken = true;
  loans_.clear();
}

Matrix4d matrix_of(const double* matrix) {
  Matrix4d held;
  if (matrix) std::memcpy(held.getValue(), matrix, sizeof held);
  return held;
}

ValueView::ValueView(const Value& value) {
  view_.count = 1;
  std::visit(
      [this]<class T>(const T& v) {
        view_.type = kType<T>;
        view_.data = &v;
        if constexpr (std::is_same_v<T, bool>) {
          view_.type = ALABASTER_BOOL;
          bool_ = v ? 1 : 0;
          view_.data = &bool_;
        } else if constexpr (std::is_same_v<T, std::string>) {
          view_.data = v.c_str();
        } else if constexpr (std::is_same_v<T, Token> || std::is_same_v<T, Path>) {
          view_.data = v.str().c_str();
        } else if constexpr (std::is_same_v<T, AssetPath>) {
          view_.type = ALABASTER_ASSET;
          view_.data = v.authored.c_str();
        } else if constexpr (std::is_same_v<T, std::shared_ptr<const Dictionary>>) {
          view_.type = ALABASTER_DICTIONARY;
          if (v)
            for (const auto& [name, held] : *v) entries_.push_back({name.c_str(), inner_.emplace_back(held).get()});
          view_.data = entries_.data(), view_.count = entries_.size();
        } else if constexpr (requires {
                               v.begin();
                               v.size();
                             }) {
          using Element = std::decay_t<decltype(v[0])>;
          view_.type = kType<Element>;
          view_.is_array = 1;
          view_.data = v.data(), view_.count = v.size();
          constexpr bool kIsName = std::is_same_v<Element, Token> || std::is_same_v<Element, Path>;
          if constexpr (kIsName || std::is_same_v<Element, std::string>) {
            for (const Element& text : v) {
              if constexpr (kIsName)
                texts_.push_back(text.str().c_str());
              else
                texts_.push_back(text.c_str());
            }
            view_.data = texts_.data();
          }
        }
      },
      value.storage());
}

void visit_dictionary(const Dictionary& values, AlabasterVisit visit, void* user) {
  if (!visit) throw bad_argument("visit is null");
  for (const auto& [name, value] : values) {
    const ValueView view(value);
    visit(user, name.c_str(), &view.get());
  }
}

}  // namespace alabaster::hd::c_api

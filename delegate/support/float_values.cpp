#include "delegate/support/float_values.h"

#include <type_traits>

namespace alabaster::hd::support {
namespace {

template <class T>
struct InFloats {};  // no `Type`: not of numbers
template <class T>
requires(std::is_arithmetic_v<T> || std::is_same_v<T, Half>) struct InFloats<T> {
  using Type = float;
};
template <class T>
struct InFloats<Imath::Vec2<T>> {
  using Type = Vec2f;
};
template <class T>
struct InFloats<Imath::Vec3<T>> {
  using Type = Vec3f;
};
template <class T>
struct InFloats<Imath::Vec4<T>> {
  using Type = Vec4f;
};
template <class T>
struct InFloats<Imath::Quat<T>> {
  using Type = Quatf;
};

template <class T>
typename InFloats<T>::Type in_floats(const T& value) {
  using Type = typename InFloats<T>::Type;
  if constexpr (std::is_same_v<Type, float>)
    return static_cast<float>(value);
  else if constexpr (std::is_same_v<Type, Quatf>)
    return Quatf(float(value.r), float(value.v.x), float(value.v.y), float(value.v.z));
  else
    return Type(value);
}

struct Convert {
  const Value& given;
  template <class T>
  Value operator()(const Array<T>& array) const {
    if constexpr (requires { typename InFloats<T>::Type; }) {
      using Type = typename InFloats<T>::Type;
      if constexpr (!std::is_same_v<Type, T>) {
        std::vector<Type> floats;
        floats.reserve(array.size());
        for (const T& value : array) floats.push_back(in_floats(value));
        return Array<Type>(std::move(floats));
      }
    }
    return given.frozen();
  }
  template <class T>
  Value operator()(const T& value) const {
    if constexpr (requires { typename InFloats<T>::Type; } && !std::is_same_v<T, Quatf>)
      return Array<typename InFloats<T>::Type>{in_floats(value)};
    else
      return given;
  }
};

}  // namespace

Value FloatValues(const Value& value) {
  return std::visit(Convert{value}, value.storage());
}

}  // namespace alabaster::hd::support

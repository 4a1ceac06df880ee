#include "delegate/support/float_values.h"

namespace alabaster::hd::support {
namespace {

/// The elements' numbers as an array of T, which has `components` floats.
template <class T>
Value floats_of(const Value& value, size_t components) {
  std::vector<T> floats(value.count());
  auto* out = reinterpret_cast<float*>(floats.data());
  for (size_t i = 0; i < floats.size() * components; ++i) out[i] = static_cast<float>(value.component(i));
  return floats;
}

}  // namespace

Value FloatValues(const Value& value) {
  const TypeInfo& info = GetTypeInfo(value.type());
  const bool is_quaternion = value.type() == ALABASTER_QUATERNION || value.type() == ALABASTER_QUATERNION16;
  if (info.bytes == 0 || info.components > 4 || (is_quaternion && !value.is_array())) return value;
  if (value.is_array() && info.scalar == Scalar::float32) return value.frozen();
  switch (info.components) {
    case 1:
      return floats_of<float>(value, 1);
    case 2:
      return floats_of<Vec2f>(value, 2);
    case 3:
      return floats_of<Vec3f>(value, 3);
    default:
      return is_quaternion ? floats_of<Quatf>(value, 4) : floats_of<Vec4f>(value, 4);
  }
}

}  // namespace alabaster::hd::support

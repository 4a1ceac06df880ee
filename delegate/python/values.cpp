#include "delegate/python/values.h"

#include <cmath>
#include <cstring>
#include <mutex>

namespace alabaster::python {
namespace {

/// A view of an object's memory, kept until the library returns it and Python's lock is held.
struct Returned {
  std::mutex mutex;
  std::vector<Py_buffer*> views;
};
Returned& returned() {
  static auto* held = new Returned;  // threads of the library may outlive static objects
  return *held;
}

class View {
 public:
  /// Empty if `object` has no buffer of plain numbers.
  explicit View(py::handle object) : view_(new Py_buffer{}) {
    if (PyObject_CheckBuffer(object.ptr()) != 0 && PyObject_GetBuffer(object.ptr(), view_, PyBUF_RECORDS_RO) == 0)
      return;
    PyErr_Clear();
    delete view_;
    view_ = nullptr;
  }
  ~View() {
    if (!view_) return;
    PyBuffer_Release(view_);
    delete view_;
  }
  View(const View&) = delete;
  View& operator=(const View&) = delete;

  explicit operator bool() const { return view_ != nullptr; }
  const Py_buffer& get() const { return *view_; }
  /// 'f', 'd', 'i', ...; 0 for what is no number in the machine's order.
  char format() const {
    std::string format = view_->format ? view_->format : "B";
    if (!format.empty() && (format[0] == '@' || format[0] == '=' || format[0] == '<')) format.erase(0, 1);
    return format.size() == 1 ? format[0] : '\0';
  }
  bool is_contiguous() const { return PyBuffer_IsContiguous(view_, 'C') != 0; }
  size_t numbers() const { return size_t(view_->len) / size_t(view_->itemsize); }

  /// The memory, for as long as the result lives; the view is empty afterwards.
  std::shared_ptr<const void> keep() {
    return {std::exchange(view_, nullptr), [](const Py_buffer* view) {
              const std::lock_guard lock(returned().mutex);
              returned().views.push_back(const_cast<Py_buffer*>(view));
            }};
  }

 private:
  Py_buffer* view_;
};

template <class T>
double read_as(const char* at) {
  T value;
  std::memcpy(&value, at, sizeof value);
  return double(value);
}

// IEEE 754 binary16, which C++20 has no type for.
double read_half(const char* at) {
  uint16_t bits = 0;
  std::memcpy(&bits, at, sizeof bits);
  const int exponent = bits >> 10 & 31, fraction = bits & 1023;
  const double sign = bits >> 15 ? -1 : 1;
  if (exponent == 31) return fraction ? std::nan("") : sign * HUGE_VAL;
  return sign * (exponent == 0 ? std::ldexp(fraction, -24) : std::ldexp(1024 + fraction, exponent - 25));
}

double number_at(const char* at, char format) {
  switch (format) {
    case 'e':
      return read_half(at);
    case 'f':
      return read_as<float>(at);
    case 'd':
      return read_as<double>(at);
    case 'i':
      return read_as<int32_t>(at);
    case 'I':
      return read_as<uint32_t>(at);
    case 'l':
    case 'q':
      return read_as<int64_t>(at);
    case 'L':
    case 'Q':
      return read_as<uint64_t>(at);
    case 'h':
      return read_as<int16_t>(at);
    case 'H':
      return read_as<uint16_t>(at);
    case 'b':
      return read_as<int8_t>(at);
    case 'B':
    case '?':
      return read_as<uint8_t>(at);
  }
  throw py::type_error(std::string("arrays of type '") + format +
                       "' cannot be read; use float16, float32, float64 or int32");
}

void read_axis(const Py_buffer& view, char format, int axis, const char* at, std::vector<double>& numbers) {
  if (axis == view.ndim) return numbers.push_back(number_at(at, format));
  for (Py_ssize_t i = 0; i < view.shape[axis]; ++i)
    read_axis(view, format, axis + 1, at + i * view.strides[axis], numbers);
}

void read_numbers(py::handle values, std::vector<double>& numbers) {
  if (const View view(values); view)
    return read_axis(view.get(), view.format(), 0, static_cast<const char*>(view.get().buf), numbers);
  if (PyFloat_Check(values.ptr()) || PyLong_Check(values.ptr()) || !PySequence_Check(values.ptr()))
    return numbers.push_back(values.cast<double>());
  for (const py::handle value : py::reinterpret_borrow<py::sequence>(values)) read_numbers(value, numbers);
}

struct ElementType {
  size_t components;
  char format;  // of the memory that is lent
};
ElementType element_of(int32_t type) {
  switch (type) {
    case ALABASTER_INT:
      return {1, 'i'};
    case ALABASTER_FLOAT2:
      return {2, 'f'};
    case ALABASTER_FLOAT3:
      return {3, 'f'};
    case ALABASTER_FLOAT4:
    case ALABASTER_QUATERNION:
      return {4, 'f'};
    case ALABASTER_MATRIX:
      return {16, 'd'};
    default:
      return {1, 'f'};
  }
}

bool is_text(py::handle value) {
  return py::isinstance<py::str>(value) || py::hasattr(value, "__fspath__");
}

}  // namespace

void free_returned() {
  std::vector<Py_buffer*> views;
  {
    const std::lock_guard lock(returned().mutex);
    views.swap(returned().views);
  }
  for (Py_buffer* view : views) {
    PyBuffer_Release(view);
    delete view;
  }
}

std::vector<size_t> shape_of(py::handle values) {
  if (const View view(values); view) return {view.get().shape, view.get().shape + view.get().ndim};
  if (!PySequence_Check(values.ptr()) || is_text(values)) return {};
  const auto sequence = py::reinterpret_borrow<py::sequence>(values);
  std::vector<size_t> shape = {sequence.size()};
  if (!sequence.empty())
    for (const size_t length : shape_of(py::object(sequence[0]))) shape.push_back(length);
  return shape;
}

Value array(int32_t type, py::handle values, const char* name) {
  if (values.is_none()) return {};
  const ElementType element = element_of(type);
  const auto check = [&](size_t numbers) {
    if (numbers % element.components != 0)
      throw py::value_error(std::string(name) + " must have " + std::to_string(element.components) +
                            " numbers for each element");
    return numbers / element.components;
  };
  if (View view(values); view && view.format() == element.format && view.is_contiguous()) {
    const size_t count = check(view.numbers());
    const void* data = view.get().buf;
    const bool edited = view.get().readonly == 0;
    return Value::lend(type, view.keep(), data, count, edited);
  }
  std::vector<double> numbers;
  read_numbers(values, numbers);
  check(numbers.size());
  if (element.format == 'd') return Value::of(type, std::move(numbers), element.components);
  if (element.format == 'i') return Value::of(type, std::vector<int32_t>(numbers.begin(), numbers.end()));
  return Value::of(type, std::vector<float>(numbers.begin(), numbers.end()), element.components);
}

Value array_by_shape(py::handle values, const char* name) {
  const std::vector<size_t> shape = shape_of(values);
  if (shape.size() == 1) {
    const View view(values);
    const bool whole =
        view ? std::strchr("iIlLqQhHbB", view.format()) != nullptr
             : shape[0] > 0 && PyLong_Check(py::object(py::reinterpret_borrow<py::sequence>(values)[0]).ptr());
    return array(whole ? ALABASTER_INT : ALABASTER_FLOAT, values, name);
  }
  if (shape.size() == 2 && shape[1] == 2) return array(ALABASTER_FLOAT2, values, name);
  if (shape.size() == 2 && shape[1] == 3) return array(ALABASTER_FLOAT3, values, name);
  if (shape.size() == 2 && shape[1] == 4) return array(ALABASTER_FLOAT4, values, name);
  if (shape.size() == 3 && shape[1] == 4 && shape[2] == 4) return array(ALABASTER_MATRIX, values, name);
  throw py::value_error(std::string(name) + " must have the shape (n), (n, 2), (n, 3), (n, 4) or (n, 4, 4)");
}

std::array<double, 16> matrix(py::handle values) {
  std::vector<double> numbers;
  if (values.is_none()) return {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1};
  read_numbers(values, numbers);
  if (numbers.size() != 16) throw py::value_error("a matrix must have 4 x 4 numbers");
  std::array<double, 16> read{};
  std::copy(numbers.begin(), numbers.end(), read.begin());
  return read;
}

Value parameter(py::handle value) {
  if (value.is_none()) return {};
  if (PyBool_Check(value.ptr())) return Value(value.cast<bool>());
  if (PyLong_Check(value.ptr())) {
    const auto whole = value.cast<int64_t>();
    return whole == int32_t(whole) ? Value(int32_t(whole)) : Value(whole);
  }
  if (PyFloat_Check(value.ptr())) return Value(value.cast<double>());
  if (is_text(value)) return Value(py::str(value).cast<std::string>());
  std::vector<double> numbers;
  read_numbers(value, numbers);
  const auto at = [&](size_t i) { return float(numbers[i]); };
  switch (numbers.size()) {
    case 1:
      return Value(numbers[0]);
    case 2:
      return Value(std::array<float, 2>{at(0), at(1)});
    case 3:
      return Value(std::array<float, 3>{at(0), at(1), at(2)});
    case 4:
      return Value(std::array<float, 4>{at(0), at(1), at(2), at(3)});
    case 16:
      return Value(matrix(value));
  }
  throw py::value_error("a parameter has 1 to 4 numbers, or 16 of a matrix");
}

door::Parameters parameters(const py::dict& values) {
  door::Parameters read;
  for (const auto& [name, value] : values) read.emplace_back(name.cast<std::string>(), parameter(value));
  return read;
}

namespace {

template <class T>
py::object numbers_of(const void* data, size_t components, size_t count, bool is_array) {
  const auto* at = static_cast<const T*>(data);
  const auto element = [&](size_t i) -> py::object {
    if (components == 1) return py::cast(at[i]);
    py::tuple parts(components);
    for (size_t c = 0; c < components; ++c) parts[c] = at[i * components + c];
    return parts;
  };
  if (!is_array) return element(0);
  py::list all;
  for (size_t i = 0; i < count; ++i) all.append(element(i));
  return all;
}

py::object text_of(const AlabasterValue& value) {
  if (!value.is_array) return py::str(static_cast<const char*>(value.data));
  py::list all;
  for (size_t i = 0; i < value.count; ++i) all.append(py::str(static_cast<const char* const*>(value.data)[i]));
  return all;
}

}  // namespace

py::object to_python(const AlabasterValue& value) {
  const bool many = value.is_array != 0;
  switch (value.type) {
    case ALABASTER_NONE:
      return py::none();
    case ALABASTER_BOOL:
      return py::bool_(*static_cast<const uint8_t*>(value.data) != 0);
    case ALABASTER_INT:
      return numbers_of<int32_t>(value.data, 1, value.count, many);
    case ALABASTER_INT64:
      return numbers_of<int64_t>(value.data, 1, value.count, many);
    case ALABASTER_UINT:
      return numbers_of<uint32_t>(value.data, 1, value.count, many);
    case ALABASTER_DOUBLE:
      return numbers_of<double>(value.data, 1, value.count, many);
    case ALABASTER_INT2:
      return numbers_of<int32_t>(value.data, 2, value.count, many);
    case ALABASTER_INT3:
      return numbers_of<int32_t>(value.data, 3, value.count, many);
    case ALABASTER_DOUBLE3:
      return numbers_of<double>(value.data, 3, value.count, many);
    case ALABASTER_MATRIX:
      return numbers_of<double>(value.data, 16, value.count, many);
    case ALABASTER_FLOAT:
    case ALABASTER_FLOAT2:
    case ALABASTER_FLOAT3:
    case ALABASTER_FLOAT4:
    case ALABASTER_QUATERNION:
      return numbers_of<float>(value.data, element_of(value.type).components, value.count, many);
    case ALABASTER_DICTIONARY: {
      py::dict entries;
      const auto* held = static_cast<const AlabasterParameter*>(value.data);
      for (size_t i = 0; i < value.count; ++i) entries[held[i].name] = to_python(held[i].value);
      return entries;
    }
    default:
      return text_of(value);
  }
}

}  // namespace alabaster::python

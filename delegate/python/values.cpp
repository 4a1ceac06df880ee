#include "delegate/python/values.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <limits>
#include <memory>
#include <mutex>

namespace alabaster::python {
namespace {

constexpr int kMostNested = 8;  // lists within lists; a list that holds itself has no end

/// Views that the library has returned, kept until Python's lock is held.
struct Returned {
  std::mutex mutex;
  std::vector<Py_buffer*> views;
};
Returned* g_returned = new Returned;  // threads of the library may outlive static objects

/// A view of an object's memory, kept until the library returns it and Python's lock is held.
class View {
 public:
  /// Empty if `object` has no buffer, or none whose elements are described.
  explicit View(py::handle object) : view_(nullptr) {
    if (PyObject_CheckBuffer(object.ptr()) == 0) return;
    auto view = std::make_unique<Py_buffer>();
    if (PyObject_GetBuffer(object.ptr(), view.get(), PyBUF_RECORDS_RO) == 0)
      view_ = view.release();
    else if (PyErr_ExceptionMatches(PyExc_Exception) != 0)
      PyErr_Clear();
    else
      throw py::error_already_set();
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
  /// The size decides, for ctypes gives C's long the same letter on every machine.
  Element element() const {
    std::string format = format_text();
    if (!format.empty() && (format[0] == '@' || format[0] == '=' || format[0] == '<')) format.erase(0, 1);
    const auto bytes = size_t(view_->itemsize);
    if (format.size() != 1 || (bytes != 1 && bytes != 2 && bytes != 4 && bytes != 8)) return {};
    if (std::strchr("efd", format[0]) && bytes != 1) return {'f', bytes};
    if (std::strchr("bhilqn", format[0])) return {'i', bytes};
    return {std::strchr("BHILQN?", format[0]) ? 'u' : '\0', bytes};
  }
  std::string format_text() const { return view_->format ? view_->format : "B"; }
  size_t numbers() const { return size_t(view_->len) / size_t(view_->itemsize); }
  /// The elements one after the other, C's order.
  std::vector<char> contiguous() const {
    std::vector<char> bytes(size_t(view_->len));
    if (PyBuffer_ToContiguous(bytes.data(), view_, view_->len, 'C') != 0) throw py::error_already_set();
    return bytes;
  }
  std::vector<size_t> shape() const { return {view_->shape, view_->shape + view_->ndim}; }
  /// Elements of this kind that the library may read where they lie.
  bool can_be_lent(const Element& as) const {
    const Element own = element();
    return as.bytes > 0 && own.kind == as.kind && own.bytes == as.bytes && PyBuffer_IsContiguous(view_, 'C') != 0 &&
           reinterpret_cast<uintptr_t>(view_->buf) % as.bytes == 0;
  }

  /// The memory, for as long as the result lives; the view is empty afterwards.
  std::shared_ptr<const void> keep() {
    return {std::exchange(view_, nullptr), [](const Py_buffer* view) {
              const std::lock_guard lock(g_returned->mutex);
              g_returned->views.push_back(const_cast<Py_buffer*>(view));
            }};
  }

 private:
  Py_buffer* view_;
};

template <class T>
T read_as(const char* at) {
  T value;
  std::memcpy(&value, at, sizeof value);
  return value;
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

/// The numbers of an argument: reals, or whole numbers of 32 bits.
template <class T>
class Numbers {
 public:
  explicit Numbers(std::string name) : name_(std::move(name)) {}
  /// False: `values` is one number.
  bool read(py::handle values, int depth = 0) {
    if (is_characters(values)) throw wrong_type(name_, "numbers", values);
    if (depth > kMostNested) throw py::value_error(name_ + ": lists are nested too deeply");
    if (const View view(values); view) {
      read_view(view, values);
      return view.get().ndim > 0;
    }
    if (PyFloat_Check(values.ptr()) || PyLong_Check(values.ptr()) || !PySequence_Check(values.ptr())) {
      held.push_back(one(values, depth == 0 ? name_ : "each of " + name_));
      return false;
    }
    read_rows(values, depth);
    return true;
  }
  std::vector<T> held;

 private:
  static constexpr bool kWhole = std::is_same_v<T, int32_t>;

  void read_rows(py::handle values, int depth) {
    const Py_ssize_t length = PySequence_Size(values.ptr());
    if (length < 0) throw py::error_already_set();
    size_t row = 0;
    bool has_rows = false;
    for (Py_ssize_t i = 0; i < length; ++i) {
      const auto item = py::reinterpret_steal<py::object>(PySequence_GetItem(values.ptr(), i));
      if (!item) throw py::error_already_set();
      const size_t before = held.size();
      const bool is_row = read(item, depth + 1);
      if (i == 0) row = held.size() - before, has_rows = is_row;
      if (is_row != has_rows)
        throw py::value_error(name_ + ": element " + std::to_string(i) + (is_row ? " is a row" : " is a number") +
                              ", and the first is not");
      if (held.size() - before != row)
        throw py::value_error(name_ + ": row " + std::to_string(i) + " has " + std::to_string(held.size() - before) +
                              " numbers, and the first has " + std::to_string(row));
    }
  }

  static T one(py::handle value, const std::string& name) {
    if constexpr (kWhole)
      return whole(value, name);
    else
      return number(value, name);
  }
  void read_view(const View& view, py::handle values) {
    const Element element = view.element();
    if (view.get().len == 0) return;
    if (element.kind == 0)
      throw py::type_error(name_ + ": arrays of type '" + view.format_text() + "' (" + type_name(values) +
                           ") cannot be read; use float16, float32, float64 or int32 in the machine's byte order");
    if (kWhole && element.kind == 'f')
      throw py::type_error(name_ + " must be whole numbers, not float" + std::to_string(8 * element.bytes));
    const std::vector<char> bytes = view.contiguous();
    for (size_t at = 0; at < bytes.size(); at += element.bytes) held.push_back(element_at(&bytes[at], element));
  }
  T element_at(const char* at, const Element& element) const {
    if constexpr (kWhole) {
      const int64_t value = integer_at(at, element);
      if (value < std::numeric_limits<int32_t>::min() || value > std::numeric_limits<int32_t>::max())
        throw py::value_error(name_ + " has " + std::to_string(value) + " at place " + std::to_string(held.size()) +
                              ", which 32 bits do not hold");
      return int32_t(value);
    } else {
      return element.kind == 'f' ? real_at(at, element) : T(integer_at(at, element));
    }
  }

  std::string name_;
};

template <class T>
std::vector<T> numbers_of(py::handle values, const std::string& name) {
  Numbers<T> numbers(name);
  numbers.read(values);
  return std::move(numbers.held);
}

std::vector<float> floats(const std::vector<double>& numbers) {
  std::vector<float> held(numbers.size());
  std::transform(numbers.begin(), numbers.end(), held.begin(), [](double number) { return float(number); });
  return held;
}

size_t count_of(size_t numbers, size_t components, const std::string& name) {
  if (numbers % components != 0)
    throw py::value_error(name + " must have " + std::to_string(components) + " numbers for each element");
  return numbers / components;
}

/// Rows of another length than that of the elements are other values. One matrix may stand alone.
void check_rows(const std::vector<size_t>& shape, size_t components, const std::string& name) {
  size_t row = 1;
  for (size_t axis = 1; axis < shape.size(); ++axis) row *= shape[axis];
  const bool is_empty = shape.size() < 2 || shape[0] == 0 || row == 0;
  const bool is_one_matrix = components == 16 && row * shape[0] == components;
  const bool are_rows = components != 16 || shape.back() == 4 || shape.back() == 16;
  if (is_empty || components == 1 || (are_rows && (row == components || is_one_matrix))) return;
  throw py::value_error(name + " must have the shape (n, " + (components == 16 ? "4, 4" : std::to_string(components)) +
                        "), or be their numbers one after the other");
}

std::vector<size_t> shape_within(py::handle values, const std::string& name, int depth) {
  if (is_characters(values)) throw wrong_type(name, "numbers", values);
  if (depth > kMostNested) throw py::value_error(name + ": lists are nested too deeply");
  if (const View view(values); view) return view.shape();
  if (!PySequence_Check(values.ptr())) return {};
  const auto sequence = py::reinterpret_borrow<py::sequence>(values);
  std::vector<size_t> shape = {sequence.size()};
  if (shape[0] > 0)
    for (const size_t length : shape_within(py::object(sequence[0]), name, depth + 1)) shape.push_back(length);
  return shape;
}

/// By AlabasterType.
constexpr Elements kElements[] = {{},
                                  {{'u', 1}, 1},
                                  {{'i', 4}, 1},
                                  {{'i', 8}, 1},
                                  {{'u', 4}, 1},
                                  {{'f', 4}, 1},
                                  {{'f', 8}, 1},
                                  {{'f', 4}, 2},
                                  {{'f', 4}, 3},
                                  {{'f', 4}, 4},
                                  {{'i', 4}, 2},
                                  {{'i', 4}, 3},
                                  {{'f', 8}, 3},
                                  {{'f', 4}, 4},
                                  {{'f', 8}, 16},
                                  {},
                                  {},
                                  {},
                                  {},
                                  {},
                                  {{'f', 2}, 1},
                                  {{'f', 2}, 2},
                                  {{'f', 2}, 3},
                                  {{'f', 2}, 4},
                                  {{'f', 8}, 2},
                                  {{'f', 8}, 4},
                                  {{'f', 2}, 4},
                                  {}};
static_assert(std::size(kElements) == ALABASTER_SAMPLES + 1 && kElements[ALABASTER_MATRIX].components == 16 &&
              kElements[ALABASTER_FLOAT16].of.bytes == 2 && kElements[ALABASTER_QUATERNION16].components == 4);

}  // namespace

Elements elements_of(int32_t type) {
  return type < 0 || size_t(type) >= std::size(kElements) ? Elements() : kElements[type];
}

double real_at(const char* at, const Element& element) {
  if (element.bytes == 2) return read_half(at);
  return element.bytes == 4 ? double(read_as<float>(at)) : read_as<double>(at);
}

int64_t integer_at(const char* at, const Element& element) {
  uint64_t bits = 0;
  std::memcpy(&bits, at, element.bytes);
  const size_t unused = 64 - 8 * element.bytes;
  if (element.kind == 'i') return int64_t(bits << unused) >> unused;
  return int64_t(std::min(bits, uint64_t(std::numeric_limits<int64_t>::max())));
}

void free_returned() {
  std::vector<Py_buffer*> views;
  {
    const std::lock_guard lock(g_returned->mutex);
    views.swap(g_returned->views);
  }
  for (Py_buffer* view : views) {
    PyBuffer_Release(view);
    delete view;
  }
}

void forget_returning_threads() {
  g_returned = new Returned;
}

std::vector<size_t> shape_of(py::handle values, const std::string& name) {
  return shape_within(values, name, 0);
}

Value array(int32_t type, py::handle values, const std::string& name) {
  if (values.is_none()) return {};
  if (is_characters(values)) throw wrong_type(name, "numbers", values);
  const Elements element = elements_of(type);
  check_rows(shape_of(values, name), element.components, name);
  if (View view(values); view && view.can_be_lent(element.of)) {
    const size_t count = count_of(view.numbers(), element.components, name);
    const void* data = view.get().buf;
    const bool edited = view.get().readonly == 0;
    return Value::lend(type, view.keep(), data, count, edited);
  }
  if (type == ALABASTER_INT) return Value::of(type, numbers_of<int32_t>(values, name));
  std::vector<double> numbers = numbers_of<double>(values, name);
  count_of(numbers.size(), element.components, name);
  if (element.of.bytes == 8) return Value::of(type, std::move(numbers), element.components);
  return Value::of(type, floats(numbers), element.components);
}

namespace {

/// All numbers of a list or array with one axis are whole numbers.
bool has_whole_numbers(py::handle values) {
  if (const View view(values); view) return view.element().kind != 'f';
  const std::vector<py::object> held = items(values, "values");
  return !held.empty() &&
         std::all_of(held.begin(), held.end(), [](const py::object& one) { return PyLong_Check(one.ptr()) != 0; });
}

}  // namespace

Value array_by_shape(py::handle values, const std::string& name) {
  const std::vector<size_t> shape = shape_of(values, name);
  if (shape.size() == 1) return array(has_whole_numbers(values) ? ALABASTER_INT : ALABASTER_FLOAT, values, name);
  if (shape.size() == 2 && shape[1] == 2) return array(ALABASTER_FLOAT2, values, name);
  if (shape.size() == 2 && shape[1] == 3) return array(ALABASTER_FLOAT3, values, name);
  if (shape.size() == 2 && shape[1] == 4) return array(ALABASTER_FLOAT4, values, name);
  if (shape.size() == 3 && shape[1] == 4 && shape[2] == 4) return array(ALABASTER_MATRIX, values, name);
  throw py::value_error(name + " must have the shape (n), (n, 2), (n, 3), (n, 4) or (n, 4, 4)");
}

std::array<double, 16> matrix(py::handle values, const std::string& name) {
  if (values.is_none()) return {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1};
  const std::vector<size_t> shape = shape_of(values, name);
  const std::vector<double> numbers = numbers_of<double>(values, name);
  if (numbers.size() != 16 || (shape.back() != 4 && shape.back() != 16))
    throw py::value_error(name + " must have 4 x 4 numbers");
  std::array<double, 16> read{};
  std::copy(numbers.begin(), numbers.end(), read.begin());
  return read;
}

namespace {

Value whole_parameter(py::handle value, const std::string& name) {
  int overflow = 0;
  const long long whole = PyLong_AsLongLongAndOverflow(value.ptr(), &overflow);
  if (overflow != 0) throw py::value_error(name + " is too large");
  return whole == int32_t(whole) ? Value(int32_t(whole)) : Value(int64_t(whole));
}

Value numbers_parameter(py::handle value, const std::string& name) {
  const std::vector<double> numbers = numbers_of<double>(value, name);
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
    case 16: {
      std::array<double, 16> read{};
      std::copy(numbers.begin(), numbers.end(), read.begin());
      return Value(read);
    }
  }
  return array_by_shape(value, name);
}

}  // namespace

Value planes(py::handle values, const std::string& name) {
  check_rows(shape_of(values, name), 4, name);
  std::vector<double> numbers = numbers_of<double>(values, name);
  count_of(numbers.size(), 4, name);
  return Value::of(ALABASTER_FLOAT4, floats(numbers), 4);
}

Value parameter(py::handle value, const std::string& name) {
  if (value.is_none()) return {};
  if (PyBool_Check(value.ptr())) return Value(value.ptr() == Py_True);
  if (PyLong_Check(value.ptr())) return whole_parameter(value, name);
  if (PyFloat_Check(value.ptr())) return Value(PyFloat_AS_DOUBLE(value.ptr()));
  if (PyUnicode_Check(value.ptr())) return Value(text(value, name));
  if (is_text(value)) return Value(file_name(value, name));
  if (!PySequence_Check(value.ptr()) && PyNumber_Check(value.ptr()) == 0 && PyObject_CheckBuffer(value.ptr()) == 0)
    throw wrong_type(name, "None, a bool, number, text, up to four numbers or a matrix", value);
  return numbers_parameter(value, name);
}

c_api::Parameters parameters(py::handle values, const std::string& name) {
  c_api::Parameters read;
  for (const auto& [key, value] : entries(values, name)) read.emplace_back(key, parameter(value, key));
  return read;
}

}  // namespace alabaster::python

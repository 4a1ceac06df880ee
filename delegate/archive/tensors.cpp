#include "delegate/archive/tensors.h"

#include <algorithm>

#include "delegate/support/json_bounds.h"

namespace alabaster::hd::archive {
namespace {

using nlohmann::json;

constexpr size_t kLengthBytes = 8, kMostHeaderBytes = 100'000'000;  // the limit of the format's own readers

/// The format's names of the types of numbers.
const char* dtype(Scalar scalar) {
  switch (scalar) {
    case Scalar::boolean:
      return "BOOL";
    case Scalar::int32:
      return "I32";
    case Scalar::int64:
      return "I64";
    case Scalar::uint32:
      return "U32";
    case Scalar::float16:
      return "F16";
    case Scalar::float32:
      return "F32";
    case Scalar::float64:
      return "F64";
    case Scalar::other:
      break;
  }
  return "U8";
}
size_t bytes_of_dtype(const std::string& type) {
  for (const auto& [name, bytes] : {std::pair("BOOL", 1), std::pair("U8", 1), std::pair("F16", 2), std::pair("I32", 4),
                                    std::pair("U32", 4), std::pair("F32", 4), std::pair("I64", 8), std::pair("F64", 8)})
    if (type == name) return size_t(bytes);
  return 0;
}

/// The whole numbers of `values`, which lie in 0..2^53; nothing else.
std::vector<size_t> sizes_of(const json& values, const std::string& name) {
  std::vector<size_t> sizes;
  if (values.is_array())
    for (const json& value : values)
      if (value.is_number_unsigned() && value.get<uint64_t>() <= (uint64_t(1) << 53))
        sizes.push_back(value.get<size_t>());
  if (!values.is_array() || sizes.size() != values.size())
    throw Fault("tensor '" + name + "' has a shape or offsets that are no whole numbers");
  return sizes;
}

}  // namespace

std::string TensorWriter::store(Tensor tensor) {
  const std::tuple<const void*, size_t, const char*> key = {tensor.bytes.data(), tensor.bytes.size(), tensor.type};
  if (const auto found = names_.find(key); !tensor.bytes.empty() && found != names_.end()) return found->second;
  if (tensor.name.empty()) tensor.name = std::to_string(tensors_.size());
  const std::string name = tensor.name;
  if (!tensor.bytes.empty()) names_[key] = name;
  tensors_.push_back(std::move(tensor));
  return name;
}

std::string TensorWriter::add(const Value& numbers) {
  const TypeInfo& info = GetTypeInfo(numbers.type());
  Tensor tensor{{}, dtype(info.scalar), size_t(info.bytes) / info.components, {numbers.count()}, {}, numbers, {}};
  if (info.components == 16)
    tensor.shape.insert(tensor.shape.end(), {4, 4});
  else if (info.components > 1)
    tensor.shape.push_back(info.components);
  // The copy that is held, because a scalar lies within its value.
  auto& held = tensor.held;
  if (!held.is_array()) {
    const auto* first = static_cast<const uint8_t*>(numbers.data());
    tensor.held_bytes = std::make_shared<const std::vector<uint8_t>>(first, first + info.bytes);
    tensor.bytes = *tensor.held_bytes;
  } else {
    tensor.bytes = {static_cast<const uint8_t*>(held.data()), held.count() * info.bytes};
  }
  return store(std::move(tensor));
}

std::string TensorWriter::add_bytes(std::shared_ptr<const std::vector<uint8_t>> bytes, std::string name) {
  const std::span<const uint8_t> all = *bytes;
  return store({std::move(name), "U8", 1, {all.size()}, all, {}, std::move(bytes)});
}

// The largest elements first: each is then aligned, without gaps, which the format does not allow.
std::vector<const TensorWriter::Tensor*> TensorWriter::by_alignment() const {
  std::vector<const Tensor*> sorted;
  for (const Tensor& tensor : tensors_) sorted.push_back(&tensor);
  std::stable_sort(sorted.begin(), sorted.end(),
                   [](const Tensor* a, const Tensor* b) { return a->element_bytes > b->element_bytes; });
  return sorted;
}

std::string TensorWriter::header(const std::string& format, int version) {
  json header;
  header["__metadata__"] = {{"format", format}, {"version", std::to_string(version)}};
  size_t offset = 0;
  for (const Tensor* tensor : by_alignment()) {
    header[tensor->name] = {
        {"dtype", tensor->type}, {"shape", tensor->shape}, {"data_offsets", {offset, offset + tensor->bytes.size()}}};
    offset += tensor->bytes.size();
  }
  std::string text = header.dump();
  text.resize((text.size() + 7) / 8 * 8, ' ');
  if (text.size() > kMostHeaderBytes) throw Fault("the scene has more arrays than an archive can list");
  std::string length(kLengthBytes, '\0');
  for (size_t i = 0; i < kLengthBytes; ++i) length[i] = char(text.size() >> (8 * i) & 255);
  return length + text;
}

std::vector<std::span<const uint8_t>> TensorWriter::order() const {
  std::vector<std::span<const uint8_t>> all;
  for (const Tensor* tensor : by_alignment()) all.push_back(tensor->bytes);
  return all;
}

void check_depth(std::span<const uint8_t> json) {
  constexpr size_t kMostDepth = 64;  // copies of deeper values would take too much stack
  const std::string_view text(reinterpret_cast<const char*>(json.data()), json.size());
  if (support::bounds_of_json(text, kMostDepth).too_deep_at != std::string_view::npos)
    throw Fault("its JSON is nested deeper than " + std::to_string(kMostDepth) + " levels");
}

std::span<const uint8_t> TensorReader::header_of(std::span<const uint8_t> file) {
  uint64_t length = 0;
  if (file.size() < kLengthBytes) throw Fault("the file is too short for an archive");
  for (size_t i = 0; i < kLengthBytes; ++i) length |= uint64_t(file[i]) << (8 * i);
  if (length > kMostHeaderBytes || length > file.size() - kLengthBytes)
    throw Fault("the header would have " + std::to_string(length) + " bytes; the file is cut, or no archive");
  return file.subspan(kLengthBytes, size_t(length));
}

TensorReader::TensorReader(FileBytes file) : file_(std::move(file)) {
  const std::span<const uint8_t> text = header_of(file_.all);
  check_depth(text);
  const json header = json::parse(text.begin(), text.end(), nullptr, false);
  if (!header.is_object()) throw Fault("the header is no JSON object");
  const size_t begin = kLengthBytes + text.size(), size = file_.all.size() - begin;
  for (const auto& [name, entry] : header.items()) {
    if (name == "__metadata__") {
      metadata_ = entry;
      continue;
    }
    const auto type = entry.is_object() ? entry.find("dtype") : entry.end();
    if (type == entry.end() || !type->is_string()) throw Fault("tensor '" + name + "' has no type");
    const auto& dtype_name = type->get_ref<const std::string&>();
    const size_t element = bytes_of_dtype(dtype_name);
    if (element == 0) throw Fault("tensor '" + name + "' has an unknown type '" + dtype_name + "'");
    const std::vector<size_t> offsets = sizes_of(entry.value("data_offsets", json()), name);
    if (offsets.size() != 2 || offsets[0] > offsets[1] || offsets[1] > size)
      throw Fault("tensor '" + name + "' lies outside of the file, which may be cut");
    size_t bytes = element;
    for (const size_t side : sizes_of(entry.value("shape", json()), name)) {
      if (side != 0 && bytes > size / side) throw Fault("the shape of tensor '" + name + "' is larger than the file");
      bytes *= side;
    }
    if (bytes != offsets[1] - offsets[0]) throw Fault("the shape of tensor '" + name + "' does not fit its bytes");
    tensors_[name] = {dtype_name, begin + offsets[0], begin + offsets[1]};
  }
}

const TensorReader::Tensor& TensorReader::find(const std::string& name, int32_t type) const {
  const auto found = tensors_.find(name);
  if (found == tensors_.end()) throw Fault("there is no tensor '" + name + "'");
  const Tensor& tensor = found->second;
  const TypeInfo& info = GetTypeInfo(type);
  const size_t bytes = tensor.end - tensor.begin;
  if (tensor.type != dtype(info.scalar) || (info.bytes > 0 && bytes % info.bytes != 0))
    throw Fault("tensor '" + name + "' is not an array of " + (type == ALABASTER_NONE ? "bytes" : info.name));
  const size_t alignment = info.bytes > 0 ? size_t(info.bytes) / info.components : 1;
  if (reinterpret_cast<uintptr_t>(file_.all.data() + tensor.begin) % alignment != 0)
    throw Fault("tensor '" + name + "' is not aligned");
  return tensor;
}

Value TensorReader::array(const std::string& name, int32_t type) const {
  const Tensor& tensor = find(name, type);
  const uint8_t* first = file_.all.data() + tensor.begin;
  const size_t count = (tensor.end - tensor.begin) / GetTypeInfo(type).bytes;
  if (type == ALABASTER_BOOL) {  // bytes other than 0 and 1 are no bools of C++
    if (!flags_.contains(name) && std::any_of(first, first + count, [](uint8_t byte) { return byte > 1; }))
      throw Fault("tensor '" + name + "' has bools that are neither 0 nor 1");
    flags_.insert(name);
  }
  return Value::array(type, file_.owner, first, count);
}

Value TensorReader::number(const std::string& name, int32_t type) const {
  const Tensor& tensor = find(name, type);
  if (tensor.end - tensor.begin != GetTypeInfo(type).bytes) throw Fault("tensor '" + name + "' is not one value");
  if (type == ALABASTER_BOOL) return file_.all[tensor.begin] != 0;
  return Value::number(type, file_.all.data() + tensor.begin);
}

std::span<const uint8_t> TensorReader::bytes(const std::string& name) const {
  const Tensor& tensor = find(name, ALABASTER_NONE);
  return {file_.all.data() + tensor.begin, tensor.end - tensor.begin};
}

}  // namespace alabaster::hd::archive

// The layout of safetensors: named arrays of numbers behind a JSON header. Internal to this room.
#pragma once

#include <functional>
#include <map>
#include <nlohmann/json.hpp>
#include <set>
#include <span>
#include <stdexcept>
#include <tuple>
#include <vector>

#include "delegate/api/types.h"

namespace alabaster::hd::archive {

/// A fault of a file, which ends reading or writing.
struct Fault : std::runtime_error {
  using std::runtime_error::runtime_error;
};

/// Arrays to write. Each is stored once, however often it is added: arrays over the same memory are one.
class TensorWriter {
 public:
  /// The name of the tensor of an array or a scalar of numbers.
  std::string add(const Value& numbers);
  /// The name of a tensor of bytes: `name`, or a new one if it is empty.
  std::string add_bytes(std::shared_ptr<const std::vector<uint8_t>> bytes, std::string name = {});
  /// The header with its length, padded to 8 bytes. The tensors follow it in order(). Throws Fault where readers would
  /// refuse it.
  std::string header(const std::string& format, int version);
  std::vector<std::span<const uint8_t>> order() const;

 private:
  struct Tensor {
    std::string name;
    const char* type;
    size_t element_bytes;
    std::vector<size_t> shape;
    std::span<const uint8_t> bytes;
    Value held;  // what owns them
    std::shared_ptr<const std::vector<uint8_t>> held_bytes;
  };
  std::string store(Tensor tensor);
  std::vector<const Tensor*> by_alignment() const;

  std::vector<Tensor> tensors_;
  std::map<std::tuple<const void*, size_t, const char*>, std::string> names_;  // by memory and type
};

/// Throws Fault if a JSON text is nested too deeply.
void check_depth(std::span<const uint8_t> json);

/// The memory of a file, which was read or is mapped.
struct FileBytes {
  std::shared_ptr<const void> owner;
  std::span<const uint8_t> all;
};

/// Tensors of a file. Throws Fault.
class TensorReader {
 public:
  /// `file` begins with the header's length.
  explicit TensorReader(FileBytes file);
  /// The text of the header. Throws Fault if the file is too short for it.
  static std::span<const uint8_t> header_of(std::span<const uint8_t> file);
  const nlohmann::json& metadata() const { return metadata_; }
  /// An array over the file's memory, or a scalar, of that type.
  Value array(const std::string& name, int32_t type) const;
  Value number(const std::string& name, int32_t type) const;
  std::span<const uint8_t> bytes(const std::string& name) const;

 private:
  struct Tensor {
    std::string type;
    size_t begin = 0, end = 0;  // in file_
  };
  const Tensor& find(const std::string& name, int32_t type) const;

  const FileBytes file_;
  std::map<std::string, Tensor> tensors_;
  mutable std::set<std::string> flags_;  // tensors of bools that have been looked through
  nlohmann::json metadata_;
};

/// {"type": number, text or list}; {"type[]": list, or the name of a tensor}. Numbers that JSON lacks (NaN, infinity)
/// are tensors, too. `asset` writes the names and contents of files.
nlohmann::json write_value(const Value& value, TensorWriter* tensors,
                           const std::function<nlohmann::json(const AssetPath&)>& asset);
/// Throws Fault.
Value read_value(const nlohmann::json& json, const TensorReader& tensors,
                 const std::function<AssetPath(const nlohmann::json&)>& asset);

}  // namespace alabaster::hd::archive

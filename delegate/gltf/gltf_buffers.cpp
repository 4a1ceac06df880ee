// Buffers, buffer views and accessors (glTF 2.0, sections 3.6 and 5.1, 5.10, 5.11): checks all byte ranges.
#include <algorithm>
#include <cmath>
#include <map>

#include "delegate/gltf/gltf_compression.h"
#include "delegate/gltf/gltf_document.h"

namespace alabaster::hd::gltf {
namespace {

// Accessors without data are zeros that cost the document no bytes. No real document needs more than this.
constexpr uint64_t kMostZeroBytes = uint64_t(16) << 20;
// Bytes read to compare stated with real bounds. The limit keeps many accessors over the same bytes from costing too
// much.
constexpr uint64_t kMostBoundsBytes = uint64_t(1) << 30;

uint64_t offset_of(const Json& object) {
  return object.value("byteOffset", uint64_t(0));
}

class BufferLoader {
 public:
  BufferLoader(const Bytes& chunk, Report& report, Document* document)
      : chunk_(chunk), report_(report), base_(document->base), memory_(document->memory) {}

  /// Many buffers may be one file, which is read once.
  const std::map<std::string, Bytes>& files() const { return files_; }

  /// Null after an error, and for the place of data that is stored compressed elsewhere (EXT_meshopt_compression).
  Bytes load(const Json& buffer, size_t index) {
    if (!buffer.contains("uri") && at(extension_of(buffer, "EXT_meshopt_compression"), "fallback") == true)
      return nullptr;
    const std::string element = element_name("buffers", index);
    const uint64_t length = buffer["byteLength"].get<uint64_t>();
    std::string reason;
    const Bytes bytes = buffer.contains("uri") ? from_uri(buffer["uri"].get<std::string>(), element, &reason)
                                               : from_chunk(index, length, element, &reason);
    if (!bytes) {
      report_.error("buffer", element, reason);
      return nullptr;
    }
    if (bytes->size() < length) {
      report_.error("buffer.short", element + ".byteLength",
                    std::to_string(length) + " bytes are declared, but the data has " + std::to_string(bytes->size()) +
                        "; export the file again");
      return nullptr;
    }
    return bytes;
  }

 private:
  Bytes from_chunk(size_t index, uint64_t length, const std::string& element, std::string* reason) {
    if (index != 0 || !chunk_) {
      *reason = "has no uri, and the file has no binary chunk; export the file again";
      return nullptr;
    }
    if (chunk_->size() > length + 3)
      report_.warning("buffer.long", element, "the GLB's binary chunk is longer than byteLength; the rest is ignored");
    return chunk_;
  }

  Bytes from_uri(const std::string& uri, const std::string& element, std::string* reason) {
    if (!is_data_uri(uri)) {
      const auto file = resolve_uri(base_, uri, reason);
      if (!file) return nullptr;
      if (const auto known = files_.find(*file); known != files_.end()) return known->second;
      const Bytes bytes = read_file({*file, base_.within}, &memory_, reason);
      if (!bytes) {
        *reason = "'" + *file + "': " + *reason;
        return nullptr;
      }
      return files_[*file] = bytes;
    }
    hold_more(&memory_, uri.size() / 4 * 3, element);
    auto data = decode_data_uri(uri, reason);
    if (!data) return nullptr;
    if (data->media_type != "application/octet-stream" && data->media_type != "application/gltf-buffer")
      report_.warning("buffer.media_type", element + ".uri",
                      "media type '" + data->media_type.substr(0, 60) + "' is unusual; write application/octet-stream");
    return std::make_shared<const std::vector<uint8_t>>(std::move(data->bytes));
  }

  Bytes chunk_;
  Report& report_;
  const UriBase& base_;
  MemoryReservation& memory_;
  std::map<std::string, Bytes> files_;  // by name
};

struct View {
  const uint8_t* data = nullptr;
  uint64_t offset = 0, length = 0, stride = 0;  // stride 0: tightly packed
};

// Bytes of one element; matrix columns start at multiples of four (glTF 2.0, section 3.6.2.4).
size_t element_size(const std::string& type, size_t component) {
  if (type == "SCALAR") return component;
  const size_t n = size_t(type.back() - '0');
  return type[0] == 'V' ? n * component : n * ((n * component + 3) / 4 * 4);
}

size_t component_count(const std::string& type) {
  if (type == "SCALAR") return 1;
  const size_t n = size_t(type.back() - '0');
  return type[0] == 'V' ? n : n * n;
}

class AccessorLoader : DocumentCheck {
 public:
  using DocumentCheck::DocumentCheck;

  void run() {
    for (size_t i = 0; i < list("bufferViews").size(); ++i) load_view(list("bufferViews")[i], i);
    for (size_t m = 0; m < list("meshes").size() && !report_.failed(); ++m)
      load_draco_mesh(list("meshes")[m]["primitives"], element_name("meshes", m) + ".primitives");
    if (report_.failed()) return;
    for (size_t i = 0; i < list("accessors").size(); ++i) {
      AccessorView& accessor = document_.accessors.emplace_back();
      if (const auto bytes = draco_.find(i); bytes != draco_.end()) accessor.data = bytes->second->data();
      load_accessor(list("accessors")[i], element_name("accessors", i), &accessor);
    }
  }

 private:
  void load_view(const Json& json, size_t index) {
    const std::string element = element_name("bufferViews", index);
    View view{nullptr, offset_of(json), json["byteLength"].get<uint64_t>(), json.value("byteStride", uint64_t(0))};
    if (const Json& compressed = extension_of(json, "EXT_meshopt_compression"); !compressed.empty()) {
      load_meshopt(compressed, element + ".extensions.EXT_meshopt_compression", &view);
    } else if (!document_.buffers[json["buffer"].get<size_t>()]) {
      report_.error("bufferView.buffer", element, "lies in a buffer without data; export the file again");
    } else if (!(view.data = bytes_of(json))) {
      report_.error("bufferView.range", element,
                    "byteOffset + byteLength exceeds the buffer of " + length_of(json["buffer"]).dump() +
                        " bytes; export the file again");
    }
    const std::string stride = std::to_string(view.stride);
    if (view.stride > 0 && (view.stride < 4 || view.stride > 252 || view.stride % 4 != 0))
      report_.error("bufferView.stride", element + ".byteStride",
                    stride + " is not a multiple of 4 from 4 to 252; export the file again");
    else if (view.stride > view.length)
      report_.warning("bufferView.stride", element + ".byteStride", stride + " exceeds the view");
    views_.push_back(view);
  }

  const Json& length_of(const Json& buffer) const { return list("buffers")[buffer.get<size_t>()]["byteLength"]; }

  // The bytes that buffer, byteOffset and byteLength name; null if they do not lie in the buffer.
  const uint8_t* bytes_of(const Json& json) const {
    const Bytes& buffer = document_.buffers[json["buffer"].get<size_t>()];
    const uint64_t available = length_of(json["buffer"]).get<uint64_t>(), offset = offset_of(json);
    const bool inside = buffer && offset <= available && json["byteLength"].get<uint64_t>() <= available - offset;
    return inside ? buffer->data() + offset : nullptr;
  }

  void load_meshopt(const Json& json, const std::string& place, View* view) {
    const uint8_t* stored = bytes_of(json);
    const uint64_t length = json["byteLength"].get<uint64_t>();
    if (!stored) return report_.error("bufferView.range", place, "lies outside its buffer; compress the file again");
    std::string reason;
    hold_more(&document_.memory,
              std::min(json["count"].get<uint64_t>() * json["byteStride"].get<uint64_t>(), kMostMeshoptGrowth * length),
              place);
    const Bytes bytes = decode_meshopt(json, {stored, size_t(length)}, &reason);
    if (!bytes) return report_.error("bufferView.meshopt", place, reason);
    document_.decoded.push_back(bytes);
    if (bytes->size() < view->length)
      return report_.error("bufferView.meshopt", place,
                           "decodes to " + std::to_string(bytes->size()) + " bytes, but the view has " +
                               std::to_string(view->length) + "; compress the file again");
    view->data = bytes->data();
    view->offset = 0;
  }

  // Accessors that have data without compression are read as they are.
  void load_draco_mesh(const Json& primitives, const std::string& element) {
    std::vector<DracoPrimitive> decoded(primitives.size());
    std::vector<std::pair<const Json*, DracoPrimitive*>> all;
    for (size_t p = 0; p < primitives.size() && !report_.failed(); ++p) {
      load_draco(primitives[p], element_name(element, p), &decoded[p]);
      if (!decoded[p].accessors.empty()) all.emplace_back(&primitives[p], &decoded[p]);
    }
    if (report_.failed()) return;
    if (all.size() > 1) join_seams_of(all, element);
    for (DracoPrimitive& primitive : decoded)
      for (auto& [index, bytes] : primitive.accessors) {
        if (list("accessors")[index].contains("bufferView") || draco_.contains(index)) continue;
        draco_[index] = std::make_shared<const std::vector<uint8_t>>(std::move(bytes));
        document_.decoded.push_back(draco_[index]);
      }
  }

  void join_seams_of(const std::vector<std::pair<const Json*, DracoPrimitive*>>& primitives,
                     const std::string& element) {
    uint64_t bytes = 0;
    for (const auto& [primitive, decoded] : primitives) {
      const auto count = [&](const Json& index) {
        return list("accessors")[index.get<size_t>()]["count"].get<uint64_t>();
      };
      if (decoded->step > 0)
        bytes += count((*primitive)["indices"]) * kSeamBytesOfIndex +
                 count((*primitive)["attributes"]["POSITION"]) * kSeamBytesOfPoint;
    }
    const size_t before = document_.memory.bytes();
    hold_more(&document_.memory, bytes, "joining the seams of " + element);
    join_draco_seams(root_, primitives);
    document_.memory.shrink(before);
  }

  void load_draco(const Json& primitive, const std::string& element, DracoPrimitive* decoded) {
    const Json& compressed = extension_of(primitive, "KHR_draco_mesh_compression");
    if (compressed.empty()) return;
    uint64_t declared = 0;
    bool needed = false;
    const auto add = [&](const Json& index) {
      const Json& accessor = list("accessors")[index.get<size_t>()];
      needed = needed || !accessor.contains("bufferView");
      declared += accessor["count"].get<uint64_t>() * 16;
    };
    for (const auto& [name, index] : primitive["attributes"].items()) add(index);
    if (primitive.contains("indices")) add(primitive["indices"]);
    if (!needed) return;
    const std::string place = element + ".extensions.KHR_draco_mesh_compression";
    const View& view = views_[compressed["bufferView"].get<size_t>()];
    hold_more(&document_.memory, declared, place);
    std::string reason;
    if (!decode_draco(root_, primitive, {view.data, size_t(view.length)}, decoded, &reason))
      return report_.error("mesh.draco", place, reason);
  }

  void load_accessor(const Json& json, const std::string& element, AccessorView* accessor) {
    accessor->type = json["type"].get<std::string>();
    accessor->component_type = json["componentType"].get<int>();
    accessor->count = json["count"].get<size_t>();
    accessor->normalized = json.value("normalized", false);
    accessor->components = component_count(accessor->type);
    accessor->has_bounds = json.contains("min") && json.contains("max");
    const size_t component = component_size(accessor->component_type);
    if (component == 0)
      return report_.error("accessor.type", element + ".componentType", "is not a glTF type; export the file again");
    if (accessor->normalized && component == 4)
      report_.warning("accessor.normalized", element, "only 8-bit and 16-bit integers can be normalized; ignored");
    const size_t size = element_size(accessor->type, component);
    const bool is_decoded = accessor->data != nullptr;
    accessor->stride = size;
    if (json.contains("bufferView")) {
      place(json, element, size, accessor);
    } else if (!accessor->data) {
      zero_bytes_ += accessor->count * uint64_t(size);
      if (zero_bytes_ > kMostZeroBytes)
        return report_.error("accessor.zeros", element, "declares too many elements without data; lower count");
    }
    if (json.contains("sparse")) load_sparse(json["sparse"], element + ".sparse", size, accessor);
    if (report_.failed() || is_decoded) return;  // Draco rounds numbers, also beyond the bounds
    check_bounds(json, element, *accessor);
  }

  // data + stride * (count - 1) + size must end inside the view; counts are below 2^31, offsets below 2^53.
  void place(const Json& json, const std::string& element, size_t size, AccessorView* accessor) {
    const View& view = views_[json["bufferView"].get<size_t>()];
    const uint64_t offset = offset_of(json);
    accessor->buffer_view = json["bufferView"].get<int>();
    accessor->has_stride = view.stride > 0;
    if (view.stride > 0) {
      if (view.stride < size)
        return report_.error("accessor.stride", element,
                             "the view's byteStride is shorter than an element; export the file again");
      accessor->stride = view.stride;
    }
    const uint64_t needed = offset + accessor->stride * uint64_t(accessor->count - 1) + size;
    if (needed > view.length)
      return report_.error("accessor.range", element,
                           "needs " + std::to_string(needed) + " bytes, but the view has " +
                               std::to_string(view.length) + "; export the file again");
    const size_t component = component_size(accessor->component_type);
    if (offset % component != 0 || (view.offset + offset) % component != 0)
      report_.warning("accessor.alignment", element, "the offset is not a multiple of the component's size");
    accessor->data = view.data + offset;
  }

  void load_sparse(const Json& json, const std::string& element, size_t size, AccessorView* accessor) {
    const Json &indices = json["indices"], &values = json["values"];
    const size_t count = json["count"].get<size_t>();
    const int index_type = indices["componentType"].get<int>();
    const View& index_view = views_[indices["bufferView"].get<size_t>()];
    const View& value_view = views_[values["bufferView"].get<size_t>()];
    const uint64_t index_offset = offset_of(indices), value_offset = offset_of(values);
    if (index_type != kUnsignedByte && index_type != kUnsignedShort && index_type != kUnsignedInt)
      return report_.error("accessor.sparse", element + ".indices.componentType",
                           "must be an unsigned integer type; export the file again");
    if (count > accessor->count)
      return report_.error("accessor.sparse", element + ".count",
                           "is larger than the accessor's count; export the file again");
    if (index_offset + count * uint64_t(component_size(index_type)) > index_view.length ||
        value_offset + count * uint64_t(size) > value_view.length)
      return report_.error("accessor.sparse", element, "exceeds its buffer views; export the file again");
    accessor->sparse_count = count;
    accessor->sparse_index_type = index_type;
    accessor->sparse_indices = index_view.data + index_offset;
    accessor->sparse_values = value_view.data + value_offset;
    check_sparse_indices(element, *accessor);
  }

  void check_sparse_indices(const std::string& element, const AccessorView& accessor) {
    int64_t previous = -1;
    bool rising = true;
    for (size_t k = 0; k < accessor.sparse_count; ++k) {
      const uint8_t* p = accessor.sparse_indices + k * component_size(accessor.sparse_index_type);
      const uint32_t index = read_index(p, accessor.sparse_index_type);
      if (index >= accessor.count)
        return report_.error(
            "accessor.sparse", element + ".indices",
            "index " + std::to_string(index) + " is not below the accessor's count; export the file again");
      rising = rising && int64_t(index) > previous;
      previous = index;
    }
    if (!rising)
      report_.warning("accessor.sparse", element + ".indices",
                      "do not increase strictly; the last value of an element is used");
  }

  // The bounds are not relied on, but false ones are the sign of a broken exporter.
  void check_bounds(const Json& json, const std::string& element, const AccessorView& accessor) {
    for (const char* name : {"min", "max"}) {
      if (!json.contains(name)) continue;
      if (json[name].size() != accessor.components)
        return report_.warning("accessor.bounds", element_name(element, name), "has the wrong number of values");
    }
    if (!accessor.has_bounds || accessor.type[0] == 'M' || !accessor.data) return;
    bounds_bytes_ += accessor.count * accessor.components * sizeof(float);
    if (bounds_bytes_ > kMostBoundsBytes) return;
    AccessorView plain = accessor;
    plain.normalized = false;
    const std::vector<float> values = read_floats(plain);
    const size_t n = accessor.components;
    size_t first = values.size();  // outside
    for (size_t c = 0; c < n; ++c) {
      double low = json["min"][c].get<double>(), high = json["max"][c].get<double>();
      const double slack = 1e-6 * std::max(std::abs(low), std::abs(high));
      low -= slack, high += slack;
      for (size_t i = c; i < first; i += n)
        if (!(values[i] >= low && values[i] <= high)) first = i;
    }
    if (first < values.size())
      report_.warning("accessor.bounds", element,
                      "element " + std::to_string(first / n) + " lies outside min and max, which are ignored");
  }

  std::vector<View> views_;
  AccessorBytes draco_;
  uint64_t zero_bytes_ = 0, bounds_bytes_ = 0;
};

}  // namespace

void load_buffers(const Json& root, const Bytes& binary_chunk, Report& report, Document* document) {
  const Json& buffers = at(root, "buffers");
  BufferLoader loader(binary_chunk, report, document);
  for (size_t i = 0; i < buffers.size(); ++i) document->buffers.push_back(loader.load(buffers[i], i));
  for (const auto& [file, bytes] : loader.files()) document->facts.files.push_back(file);
}

void load_accessors(const Json& root, Report& report, Document* document) {
  AccessorLoader(root, document, report).run();
}

}  // namespace alabaster::hd::gltf

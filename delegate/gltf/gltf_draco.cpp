#include <draco/attributes/attribute_quantization_transform.h>
#include <draco/compression/decode.h>
#include <draco/compression/point_cloud/point_cloud_decoder.h>
#include <draco/core/varint_decoding.h>
#include <draco/metadata/metadata_decoder.h>

#include <algorithm>
#include <cstring>

#include "delegate/gltf/gltf_accessor.h"
#include "delegate/gltf/gltf_compression.h"
#include "delegate/gltf/gltf_surfaces.h"

namespace alabaster::hd::gltf {
namespace {

// A Draco mesh begins with these, by which its decoder allocates.
struct Counts {
  uint32_t faces = 0;
  uint32_t points = 0;  // 0: the decoder bounds them by the faces
};

// Bitstream 2.2 is the only one that glTF allows. Empty if this is none.
std::optional<Counts> read_counts(ByteRange compressed) {
  draco::DecoderBuffer buffer;
  buffer.Init(reinterpret_cast<const char*>(compressed.data), compressed.size);
  draco::DracoHeader header;
  if (!draco::PointCloudDecoder::DecodeHeader(&buffer, &header).ok()) return {};
  if (header.encoder_type != draco::TRIANGULAR_MESH || header.version_major != 2 || header.version_minor != 2)
    return {};
  buffer.set_bitstream_version(draco::kDracoMeshBitstreamVersion);
  if (header.flags & METADATA_FLAG_MASK) {
    draco::GeometryMetadata metadata;
    if (!draco::MetadataDecoder().DecodeGeometryMetadata(&buffer, &metadata)) return {};
  }
  Counts counts;
  const bool edgebreaker = header.encoder_method == draco::MESH_EDGEBREAKER_ENCODING;
  uint8_t traversal = 0;
  uint32_t vertices = 0;
  if (edgebreaker && !(buffer.Decode(&traversal) && draco::DecodeVarint(&vertices, &buffer))) return {};
  if (!draco::DecodeVarint(&counts.faces, &buffer)) return {};
  if (!edgebreaker && !draco::DecodeVarint(&counts.points, &buffer)) return {};
  return counts;
}

template <class T>
bool copy_attribute(const draco::PointAttribute& attribute, size_t count, size_t components, uint8_t* out) {
  std::vector<T> element(components);
  for (size_t i = 0; i < count; ++i) {
    const auto value = attribute.mapped_index(draco::PointIndex(uint32_t(i)));
    if (value >= uint32_t(attribute.size()) || !attribute.ConvertValue<T>(value, int8_t(components), element.data()))
      return false;
    std::memcpy(out + i * components * sizeof(T), element.data(), components * sizeof(T));
  }
  return true;
}

// The values as they are stored: the accessor says if integers are normalized.
bool copy_attribute(const draco::PointAttribute& attribute, int component_type, size_t count, uint8_t* out) {
  const auto components = size_t(attribute.num_components());
  switch (component_type) {
    case kByte:
      return copy_attribute<int8_t>(attribute, count, components, out);
    case kUnsignedByte:
      return copy_attribute<uint8_t>(attribute, count, components, out);
    case kShort:
      return copy_attribute<int16_t>(attribute, count, components, out);
    case kUnsignedShort:
      return copy_attribute<uint16_t>(attribute, count, components, out);
    case kUnsignedInt:
      return copy_attribute<uint32_t>(attribute, count, components, out);
    default:
      return copy_attribute<float>(attribute, count, components, out);
  }
}

class PrimitiveDecoder {
 public:
  PrimitiveDecoder(const Json& root, const Json& primitive, DracoPrimitive* decoded, std::string* reason)
      : root_(root), primitive_(primitive), decoded_(*decoded), reason_(reason) {}

  bool run(ByteRange compressed) {
    const Json& attributes = primitive_["extensions"]["KHR_draco_mesh_compression"]["attributes"];
    if (!primitive_.contains("indices")) return fail("the primitive has no indices");
    const Json& indices = root_["accessors"][primitive_["indices"].get<size_t>()];
    const auto counts = read_counts(compressed);
    if (!counts) return fail("is not a mesh in Draco's bitstream 2.2");
    if (uint64_t(counts->faces) * 3 > indices["count"].get<uint64_t>()) return fail("has more faces than its indices");
    for (const auto& [name, id] : attributes.items())
      if (!id.is_number_unsigned()) return fail("attribute " + name + " has no number");
    for (const auto& [name, index] : primitive_["attributes"].items())
      if (counts->points > root_["accessors"][index.get<size_t>()]["count"].get<uint64_t>())
        return fail("has more points than " + name);
    draco::DecoderBuffer buffer;
    buffer.Init(reinterpret_cast<const char*>(compressed.data), compressed.size);
    draco::Decoder decoder;
    decoder.SetSkipAttributeTransform(draco::GeometryAttribute::POSITION);
    auto decoded = decoder.DecodeMeshFromBuffer(&buffer);
    if (!decoded.ok()) return fail(std::string("cannot be decoded (") + decoded.status().error_msg() + ")");
    mesh_ = std::move(decoded).value();
    for (const auto& [name, id] : attributes.items())
      if (primitive_["attributes"].contains(name) && !take_attribute(name, id.get<uint32_t>())) return false;
    return take_indices(primitive_["indices"].get<size_t>(), indices);
  }

 private:
  bool fail(const std::string& why) {
    *reason_ = why + "; compress the file again";
    return false;
  }

  bool take_attribute(const std::string& name, uint32_t id) {
    const size_t index = primitive_["attributes"][name].get<size_t>();
    const Json& accessor = root_["accessors"][index];
    const draco::PointAttribute* attribute = mesh_->GetAttributeByUniqueId(id);
    if (!attribute) return fail("has no attribute " + std::to_string(id) + " for " + name);
    const std::string type = accessor["type"];
    const size_t components = type == "SCALAR" ? 1 : size_t(type.back() - '0'), count = mesh_->num_points();
    const int component_type = accessor["componentType"].get<int>();
    if (type[0] == 'M' || components != size_t(attribute->num_components()) || accessor["count"] != count)
      return fail(name + " has " + std::to_string(count) + " elements of " +
                  std::to_string(attribute->num_components()) + " components, which accessors[" +
                  std::to_string(index) + "] contradicts");
    std::vector<uint8_t> bytes(count * components * component_size(component_type));
    draco::AttributeQuantizationTransform grid;
    const bool copied = attribute->GetAttributeTransformData() && grid.InitFromAttribute(*attribute)
                            ? component_type == kFloat && copy_rounded(*attribute, grid, bytes.data())
                            : copy_attribute(*attribute, component_type, count, bytes.data());
    if (bytes.empty() || !copied) return fail("the numbers of " + name + " do not fit its accessor");
    if (name == "POSITION" && components == 3 && grid.is_initialized()) decoded_.step = step_of(grid);
    decoded_.accessors[index] = std::move(bytes);
    return true;
  }

  static float step_of(const draco::AttributeQuantizationTransform& grid) {
    return grid.range() / float((uint64_t(1) << grid.quantization_bits()) - 1);
  }

  // Positions are dequantized here, because Draco drops the grid once it has made floats of them.
  bool copy_rounded(const draco::PointAttribute& stored, const draco::AttributeQuantizationTransform& grid,
                    uint8_t* out) {
    draco::PointAttribute floats;
    floats.Init(draco::GeometryAttribute::POSITION, int8_t(stored.num_components()), draco::DT_FLOAT32, false,
                stored.size());
    draco::AttributeQuantizationTransform transform = grid;
    if (!transform.InverseTransformAttribute(stored, &floats)) return false;
    const size_t element = size_t(stored.num_components()) * sizeof(float);
    for (uint32_t i = 0; i < mesh_->num_points(); ++i) {
      const auto value = stored.mapped_index(draco::PointIndex(i));
      if (value >= uint32_t(stored.size())) return false;
      std::memcpy(out + i * element, floats.GetAddress(value), element);
    }
    return true;
  }

  bool take_indices(size_t index, const Json& accessor) {
    const size_t count = size_t(mesh_->num_faces()) * 3, size = component_size(accessor["componentType"].get<int>());
    if (accessor["type"] != "SCALAR" || accessor["count"] != count || size == 0)
      return fail("has " + std::to_string(count) + " indices, which accessors[" + std::to_string(index) +
                  "] contradicts");
    std::vector<uint8_t> bytes(count * size);
    for (size_t i = 0; i < count; ++i) {
      const uint32_t vertex = mesh_->face(draco::FaceIndex(uint32_t(i / 3)))[i % 3].value();
      if (size < 4 && vertex >> (8 * size) != 0) return fail("its indices do not fit their accessor");
      std::memcpy(bytes.data() + i * size, &vertex, size);  // little-endian
    }
    decoded_.accessors[index] = std::move(bytes);
    return true;
  }

  const Json &root_, &primitive_;
  DracoPrimitive& decoded_;
  std::string* reason_;
  std::unique_ptr<draco::Mesh> mesh_;
};

}  // namespace

bool decode_draco(const Json& root, const Json& primitive, ByteRange compressed, DracoPrimitive* decoded,
                  std::string* reason) {
  return PrimitiveDecoder(root, primitive, decoded, reason).run(compressed);
}

void join_draco_seams(const Json& root, const std::vector<std::pair<const Json*, DracoPrimitive*>>& primitives) {
  struct Decoded {
    std::vector<uint8_t>* bytes;
    std::vector<Vec3f> points;
    std::vector<uint32_t> triangles;
  };
  std::vector<Decoded> all;
  std::vector<RoundedPiece> pieces;
  all.reserve(primitives.size());
  for (const auto& [primitive, decoded] : primitives) {
    if (!(decoded->step > 0) || primitive->value("mode", 4) != 4) continue;
    const auto positions = decoded->accessors.find((*primitive)["attributes"]["POSITION"].get<size_t>());
    const size_t index = (*primitive)["indices"].get<size_t>();
    const auto corners = decoded->accessors.find(index);
    if (positions == decoded->accessors.end() || corners == decoded->accessors.end()) continue;
    Decoded& one = all.emplace_back(Decoded{&positions->second, {}, {}});
    one.points.resize(one.bytes->size() / sizeof(Vec3f));
    std::memcpy(static_cast<void*>(one.points.data()), one.bytes->data(), one.points.size() * sizeof(Vec3f));
    const int type = root["accessors"][index]["componentType"].get<int>();
    const size_t size = component_size(type);
    for (size_t at = 0; at < corners->second.size(); at += size)
      one.triangles.push_back(read_index(corners->second.data() + at, type));
    const auto is_there = [&one](uint32_t corner) { return corner < one.points.size(); };  // others are refused later
    if (std::all_of(one.triangles.begin(), one.triangles.end(), is_there))
      pieces.push_back({&one.points, &one.triangles, decoded->step});
  }
  join_seams(pieces);
  for (const Decoded& one : all) std::memcpy(one.bytes->data(), one.points.data(), one.bytes->size());
}

}  // namespace alabaster::hd::gltf

#include <draco/compression/decode.h>
#include <draco/compression/point_cloud/point_cloud_decoder.h>
#include <draco/core/varint_decoding.h>
#include <draco/metadata/metadata_decoder.h>

#include <cstring>

#include "delegate/gltf/gltf_accessor.h"
#include "delegate/gltf/gltf_compression.h"

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
  PrimitiveDecoder(const Json& root, const Json& primitive, AccessorBytes* accessors, std::string* reason)
      : root_(root), primitive_(primitive), accessors_(accessors), reason_(reason) {}

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
    auto decoded = draco::Decoder().DecodeMeshFromBuffer(&buffer);
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
    auto bytes = std::make_shared<std::vector<uint8_t>>(count * components * component_size(component_type));
    if (bytes->empty() || !copy_attribute(*attribute, component_type, count, bytes->data()))
      return fail("the numbers of " + name + " do not fit its accessor");
    (*accessors_)[index] = std::move(bytes);
    return true;
  }

  bool take_indices(size_t index, const Json& accessor) {
    const size_t count = size_t(mesh_->num_faces()) * 3, size = component_size(accessor["componentType"].get<int>());
    if (accessor["type"] != "SCALAR" || accessor["count"] != count || size == 0)
      return fail("has " + std::to_string(count) + " indices, which accessors[" + std::to_string(index) +
                  "] contradicts");
    auto bytes = std::make_shared<std::vector<uint8_t>>(count * size);
    for (size_t i = 0; i < count; ++i) {
      const uint32_t vertex = mesh_->face(draco::FaceIndex(uint32_t(i / 3)))[i % 3].value();
      if (size < 4 && vertex >> (8 * size) != 0) return fail("its indices do not fit their accessor");
      std::memcpy(bytes->data() + i * size, &vertex, size);  // little-endian
    }
    (*accessors_)[index] = std::move(bytes);
    return true;
  }

  const Json &root_, &primitive_;
  AccessorBytes* accessors_;
  std::string* reason_;
  std::unique_ptr<draco::Mesh> mesh_;
};

}  // namespace

bool decode_draco(const Json& root, const Json& primitive, ByteRange compressed, AccessorBytes* accessors,
                  std::string* reason) {
  return PrimitiveDecoder(root, primitive, accessors, reason).run(compressed);
}

}  // namespace alabaster::hd::gltf

#include <meshoptimizer.h>

#include "delegate/gltf/gltf_compression.h"

namespace alabaster::hd::gltf {
namespace {

struct CompressedView {
  std::string mode, filter;
  size_t count = 0, stride = 0;
};

// The library asserts these.
bool is_sound(const CompressedView& view) {
  if (view.mode != "ATTRIBUTES")
    return (view.stride == 2 || view.stride == 4) && view.filter == "NONE" &&
           (view.mode == "INDICES" || view.count % 3 == 0);
  if (view.stride == 0 || view.stride % 4 != 0 || view.stride > 256) return false;
  if (view.filter == "OCTAHEDRAL") return view.stride == 4 || view.stride == 8;
  return view.filter != "QUATERNION" || view.stride == 8;
}

int decode(const CompressedView& view, ByteRange compressed, uint8_t* out) {
  if (view.mode == "TRIANGLES")
    return meshopt_decodeIndexBuffer(out, view.count, view.stride, compressed.data, compressed.size);
  if (view.mode == "INDICES")
    return meshopt_decodeIndexSequence(out, view.count, view.stride, compressed.data, compressed.size);
  const int fault = meshopt_decodeVertexBuffer(out, view.count, view.stride, compressed.data, compressed.size);
  if (fault != 0) return fault;
  if (view.filter == "OCTAHEDRAL") meshopt_decodeFilterOct(out, view.count, view.stride);
  if (view.filter == "QUATERNION") meshopt_decodeFilterQuat(out, view.count, view.stride);
  if (view.filter == "EXPONENTIAL") meshopt_decodeFilterExp(out, view.count, view.stride);
  return 0;
}

}  // namespace

Bytes decode_meshopt(const Json& extension, ByteRange compressed, std::string* reason) {
  const CompressedView view{extension["mode"].get<std::string>(), extension.value("filter", "NONE"),
                            extension["count"].get<size_t>(), extension["byteStride"].get<size_t>()};
  if (!is_sound(view)) {
    *reason = "its mode, filter, count and byteStride do not agree; compress the file again";
    return nullptr;
  }
  if (uint64_t(view.count) * view.stride > kMostMeshoptGrowth * compressed.size) {
    *reason = "declares more elements than its bytes can hold; compress the file again";
    return nullptr;
  }
  auto bytes = std::make_shared<std::vector<uint8_t>>(view.count * view.stride);
  if (decode(view, compressed, bytes->data()) == 0) return bytes;
  *reason = "cannot be decoded: its bytes are damaged; compress the file again";
  return nullptr;
}

}  // namespace alabaster::hd::gltf

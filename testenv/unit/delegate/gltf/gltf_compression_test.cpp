// EXT_meshopt_compression and KHR_draco_mesh_compression: the output of their own encoders is read back, and damaged
// bytes are refused.
#include <draco/compression/expert_encode.h>
#include <draco/mesh/triangle_soup_mesh_builder.h>
#include <meshoptimizer.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <map>
#include <utility>

#include "testenv/unit/delegate/gltf/gltf_builder.h"

namespace alabaster::hd::gltf::testing {
namespace {

using Bytes = std::vector<uint8_t>;

constexpr size_t kSide = 20;  // vertices along the side of a wavy sheet

std::vector<float> sheet_points() {
  std::vector<float> points;
  for (size_t i = 0; i < kSide * kSide; ++i)
    points.insert(points.end(), {float(i % kSide), float(i / kSide), std::sin(float(i))});
  return points;
}

std::vector<uint32_t> sheet_indices() {
  std::vector<uint32_t> indices;
  for (uint32_t y = 0; y + 1 < kSide; ++y)
    for (uint32_t x = 0; x + 1 < kSide; ++x) {
      const uint32_t a = y * uint32_t(kSide) + x, b = a + 1, c = a + uint32_t(kSide), d = c + 1;
      indices.insert(indices.end(), {a, b, d, a, d, c});
    }
  return indices;
}

// A buffer view whose data is stored compressed; `buffer` 1 is the place of what is decoded.
size_t compressed_view(GltfBuilder* b, const Bytes& bytes, Json extension) {
  const size_t stored = b->view(bytes);
  extension["buffer"] = 0;
  extension["byteOffset"] = b->json["bufferViews"][stored]["byteOffset"];
  extension["byteLength"] = bytes.size();
  const size_t length = extension["count"].get<size_t>() * extension["byteStride"].get<size_t>();
  b->json["bufferViews"][stored] = {
      {"buffer", 1}, {"byteLength", length}, {"extensions", {{"EXT_meshopt_compression", extension}}}};
  return stored;
}

Bytes encode_vertices(const std::vector<float>& values, size_t stride) {
  const size_t count = values.size() * sizeof(float) / stride;
  Bytes bytes(meshopt_encodeVertexBufferBound(count, stride));
  bytes.resize(meshopt_encodeVertexBuffer(bytes.data(), bytes.size(), values.data(), count, stride));
  return bytes;
}

Bytes encode_indices(const std::vector<uint32_t>& indices) {
  Bytes bytes(meshopt_encodeIndexBufferBound(indices.size(), kSide * kSide));
  bytes.resize(meshopt_encodeIndexBuffer(bytes.data(), bytes.size(), indices.data(), indices.size()));
  return bytes;
}

GltfBuilder meshopt_sheet() {
  GltfBuilder b;
  b.json["extensionsUsed"] = b.json["extensionsRequired"] = {"EXT_meshopt_compression"};
  b.more_buffers = {{{"byteLength", 1 << 20}, {"extensions", {{"EXT_meshopt_compression", {{"fallback", true}}}}}}};
  const size_t count = kSide * kSide;
  const size_t points = compressed_view(&b, encode_vertices(sheet_points(), 12),
                                        {{"count", count}, {"byteStride", 12}, {"mode", "ATTRIBUTES"}});
  const size_t indices = compressed_view(&b, encode_indices(sheet_indices()),
                                         {{"count", sheet_indices().size()}, {"byteStride", 4}, {"mode", "TRIANGLES"}});
  b.json["accessors"] = {
      {{"bufferView", points}, {"componentType", 5126}, {"type", "VEC3"}, {"count", count}},
      {{"bufferView", indices}, {"componentType", 5125}, {"type", "SCALAR"}, {"count", sheet_indices().size()}}};
  b.primitive()["attributes"]["POSITION"] = 0;
  b.primitive()["indices"] = 1;
  return b;
}

TEST(GltfMeshopt, PointsAndTrianglesAreDecoded) {
  const Loaded loaded = meshopt_sheet().load();
  ASSERT_TRUE(loaded.summary.ok) << loaded.said();
  const host::MeshDescription& mesh = only_mesh(loaded);
  const std::vector<float> expected = sheet_points();
  const auto& points = primvar<Array<Vec3f>>(mesh, "points");
  ASSERT_EQ(points.size(), kSide * kSide);
  for (size_t i = 0; i < points.size(); ++i) EXPECT_EQ(points[i].z, expected[3 * i + 2]);
  EXPECT_EQ(mesh.topology.faceVertexCounts.size(), sheet_indices().size() / 3);
  // The codec may turn triangles, but keeps their order.
  std::vector<int32_t> first(mesh.topology.faceVertexIndices.begin(), mesh.topology.faceVertexIndices.begin() + 3);
  std::sort(first.begin(), first.end());
  EXPECT_EQ(first, (std::vector<int32_t>{0, 1, int32_t(kSide) + 1}));
}

TEST(GltfMeshopt, FiltersAreUndone) {
  GltfBuilder b = meshopt_sheet();
  const size_t count = kSide * kSide;
  std::vector<float> normals;
  for (size_t i = 0; i < count; ++i) normals.insert(normals.end(), {0.6f, 0, 0.8f, 0});
  std::vector<float> filtered(count * 2);  // four 16-bit numbers for each
  meshopt_encodeFilterOct(filtered.data(), count, 8, 16, normals.data());
  b.json["extensionsUsed"].push_back("KHR_mesh_quantization");
  b.json["extensionsRequired"].push_back("KHR_mesh_quantization");
  const size_t view =
      compressed_view(&b, encode_vertices(filtered, 8),
                      {{"count", count}, {"byteStride", 8}, {"mode", "ATTRIBUTES"}, {"filter", "OCTAHEDRAL"}});
  b.json["bufferViews"][view]["byteStride"] = 8;
  b.json["accessors"].push_back(
      {{"bufferView", view}, {"componentType", 5122}, {"normalized", true}, {"type", "VEC3"}, {"count", count}});
  b.primitive()["attributes"]["NORMAL"] = 2;
  const Loaded loaded = b.load();
  ASSERT_TRUE(loaded.summary.ok) << loaded.said();
  expect_near(primvar<Array<Vec3f>>(only_mesh(loaded), "normals")[7], Vec3f(0.6f, 0, 0.8f), 1e-3);
}

TEST(GltfMeshopt, DamageIsRefused) {
  const auto expect_error = [](const std::string& what, const std::function<void(Json&)>& damage) {
    GltfBuilder b = meshopt_sheet();
    damage(b.json["bufferViews"][0]["extensions"]["EXT_meshopt_compression"]);
    const Loaded loaded = b.load();
    EXPECT_FALSE(loaded.summary.ok) << what;
    EXPECT_TRUE(loaded.says(Severity::error, "bufferViews[0]")) << loaded.said();
    EXPECT_TRUE(loaded.says(Severity::error, what)) << what << "\n" << loaded.said();
  };
  expect_error("lies outside its buffer", [](Json& view) { view["byteOffset"] = 1 << 30; });
  expect_error("lies outside its buffer", [](Json& view) { view["buffer"] = 1; });
  expect_error("cannot be decoded", [](Json& view) { view["byteLength"] = 100; });
  expect_error("cannot be decoded", [](Json& view) { view["count"] = 2000; });
  expect_error("more elements than its bytes can hold", [](Json& view) { view["count"] = 2000000000; });
  expect_error("do not agree", [](Json& view) { view["byteStride"] = 10; });
  expect_error("do not agree", [](Json& view) { view["filter"] = "QUATERNION"; });
}

// A Draco mesh with positions of floats and normalized 8-bit colours.
draco::EncoderBuffer draco_sheet(int method) {
  draco::TriangleSoupMeshBuilder builder;
  const std::vector<float> points = sheet_points();
  const std::vector<uint32_t> indices = sheet_indices();
  builder.Start(int(indices.size() / 3));
  const int position = builder.AddAttribute(draco::GeometryAttribute::POSITION, 3, draco::DT_FLOAT32);
  const int color = builder.AddAttribute(draco::GeometryAttribute::COLOR, 4, draco::DT_UINT8);
  for (size_t f = 0; f < indices.size() / 3; ++f) {
    uint8_t colors[3][4];
    for (size_t k = 0; k < 3; ++k) {
      const uint8_t red = uint8_t(indices[3 * f + k] % 200);
      colors[k][0] = colors[k][1] = colors[k][2] = red;
      colors[k][3] = 255;
    }
    const auto face = draco::FaceIndex(uint32_t(f));
    builder.SetAttributeValuesForFace(position, face, &points[3 * indices[3 * f]], &points[3 * indices[3 * f + 1]],
                                      &points[3 * indices[3 * f + 2]]);
    builder.SetAttributeValuesForFace(color, face, colors[0], colors[1], colors[2]);
  }
  const auto mesh = builder.Finalize();
  draco::ExpertEncoder encoder(*mesh);
  encoder.SetEncodingMethod(method);
  draco::EncoderBuffer buffer;
  EXPECT_TRUE(encoder.EncodeToBuffer(&buffer).ok());
  return buffer;
}

GltfBuilder draco_document(int method, bool damaged = false) {
  const draco::EncoderBuffer buffer = draco_sheet(method);
  Bytes bytes(buffer.data(), buffer.data() + buffer.size());
  for (size_t i = 40; damaged && i < bytes.size(); i += 7) bytes[i] = uint8_t(bytes[i] ^ 0x5a);
  GltfBuilder b;
  b.json["extensionsUsed"] = b.json["extensionsRequired"] = {"KHR_draco_mesh_compression"};
  const size_t view = b.view(bytes), count = kSide * kSide;
  b.json["accessors"] = {{{"componentType", 5126}, {"type", "VEC3"}, {"count", count}},
                         {{"componentType", 5123}, {"type", "SCALAR"}, {"count", sheet_indices().size()}},
                         {{"componentType", 5121}, {"normalized", true}, {"type", "VEC4"}, {"count", count}}};
  b.primitive()["attributes"] = {{"POSITION", 0}, {"COLOR_0", 2}};
  b.primitive()["indices"] = 1;
  b.primitive()["extensions"]["KHR_draco_mesh_compression"] = {{"bufferView", view},
                                                               {"attributes", {{"POSITION", 0}, {"COLOR_0", 1}}}};
  return b;
}

// The encoder orders vertices as it likes: every vertex is found by its place, and has the colour of that place.
TEST(GltfDraco, MeshesAreDecodedWithAllTheirAttributes) {
  for (const int method : {draco::MESH_SEQUENTIAL_ENCODING, draco::MESH_EDGEBREAKER_ENCODING}) {
    const Loaded loaded = draco_document(method).load();
    ASSERT_TRUE(loaded.summary.ok) << loaded.said();
    const host::MeshDescription& mesh = only_mesh(loaded);
    const auto& points = primvar<Array<Vec3f>>(mesh, "points");
    const auto& colors = primvar<Array<Vec3f>>(mesh, "displayColor");
    ASSERT_EQ(points.size(), kSide * kSide);
    ASSERT_EQ(colors.size(), points.size());
    const std::vector<float> expected = sheet_points();
    for (size_t i = 0; i < points.size(); ++i) {
      const auto vertex = size_t(points[i].x + 0.5f) + kSide * size_t(points[i].y + 0.5f);
      EXPECT_EQ(points[i].z, expected[3 * vertex + 2]);
      EXPECT_NEAR(colors[i].x, float(vertex % 200) / 255, 1e-6f);
    }
    EXPECT_EQ(mesh.topology.faceVertexCounts.size(), sheet_indices().size() / 3);
    EXPECT_EQ(primvar<Array<float>>(mesh, "displayOpacity")[0], 1);
  }
}

/// Adds rows of the sheet's squares as a primitive, whose positions are rounded to a grid of its own.
void add_rounded_rows(GltfBuilder* b, size_t first, size_t end, int bits) {
  draco::TriangleSoupMeshBuilder builder;
  const std::vector<float> points = sheet_points();
  const std::vector<uint32_t> indices = sheet_indices();
  const size_t faces_of_row = 2 * (kSide - 1), faces = (end - first) * faces_of_row;
  builder.Start(int(faces));
  const int position = builder.AddAttribute(draco::GeometryAttribute::POSITION, 3, draco::DT_FLOAT32);
  for (size_t f = 0; f < faces; ++f) {
    const uint32_t* const corners = &indices[3 * (first * faces_of_row + f)];
    builder.SetAttributeValuesForFace(position, draco::FaceIndex(uint32_t(f)), &points[size_t(3) * corners[0]],
                                      &points[size_t(3) * corners[1]], &points[size_t(3) * corners[2]]);
  }
  const auto mesh = builder.Finalize();
  draco::ExpertEncoder encoder(*mesh);
  encoder.SetAttributeQuantization(position, bits);
  draco::EncoderBuffer buffer;
  ASSERT_TRUE(encoder.EncodeToBuffer(&buffer).ok());
  const size_t view = b->view(Bytes(buffer.data(), buffer.data() + buffer.size())), at = b->json["accessors"].size();
  const size_t count = (end - first + 1) * kSide;
  b->json["accessors"].push_back({{"componentType", 5126}, {"type", "VEC3"}, {"count", count}});
  b->json["accessors"].push_back({{"componentType", 5125}, {"type", "SCALAR"}, {"count", 3 * faces}});
  const Json compressed = {{"bufferView", view}, {"attributes", {{"POSITION", 0}}}};
  b->json["meshes"][0]["primitives"].push_back({{"attributes", {{"POSITION", at}}},
                                                {"indices", at + 1},
                                                {"extensions", {{"KHR_draco_mesh_compression", compressed}}}});
}

constexpr size_t kSeam = 7;  // the row at which the rounded sheet is parted

GltfBuilder rounded_sheet() {
  GltfBuilder b;
  b.json["extensionsUsed"] = b.json["extensionsRequired"] = {"KHR_draco_mesh_compression"};
  b.json["accessors"] = Json::array();
  b.json["meshes"][0]["primitives"] = Json::array();
  add_rounded_rows(&b, 0, kSeam, 9);
  add_rounded_rows(&b, kSeam, kSide - 1, 10);
  return b;
}

// glTF-Transform 257, gltf-pipeline 379, draco 713: rounding parts the primitives of one surface.
TEST(GltfDraco, PrimitivesThatRoundingPartsAreOneSurface) {
  const Loaded loaded = rounded_sheet().load();
  ASSERT_TRUE(loaded.summary.ok) << loaded.said();
  const auto& points = primvar<Array<Vec3f>>(only_mesh(loaded), "points");
  std::map<std::pair<float, float>, size_t> seam;
  const std::vector<float> expected = sheet_points();
  for (const Vec3f& p : points) {
    const auto vertex = size_t(p.x + 0.5f) + kSide * size_t(p.y + 0.5f);
    EXPECT_NEAR(p.z, expected[3 * vertex + 2], 0.06f);
    if (std::abs(p.y - float(kSeam)) < 0.1f) ++seam[{p.x, p.z}];
  }
  EXPECT_EQ(seam.size(), kSide);
  for (const auto& [place, count] : seam) EXPECT_EQ(count, 2u) << place.first;
}

// Joining takes about 200 kB for a time.
TEST(GltfDraco, JoiningSeamsStaysBelowTheMemoryLimit) {
  GltfOptions options;
  options.memory_limit = size_t(180) << 10;
  const Loaded refused = rounded_sheet().load(options);
  EXPECT_FALSE(refused.summary.ok);
  EXPECT_TRUE(refused.says(Severity::error, "the seams of meshes[0].primitives needs ")) << refused.said();
  options.memory_limit = size_t(1) << 20;
  const Loaded loaded = rounded_sheet().load(options);
  EXPECT_TRUE(loaded.summary.ok) << loaded.said();
}

TEST(GltfDraco, DamageIsRefused) {
  const auto expect_error = [](const std::string& what, const std::function<void(GltfBuilder&)>& damage) {
    GltfBuilder b = draco_document(draco::MESH_EDGEBREAKER_ENCODING);
    damage(b);
    const Loaded loaded = b.load();
    EXPECT_FALSE(loaded.summary.ok) << what;
    EXPECT_TRUE(loaded.says(Severity::error, what)) << what << "\n" << loaded.said();
  };
  const auto extension = [](GltfBuilder& b) -> Json& {
    return b.primitive()["extensions"]["KHR_draco_mesh_compression"];
  };
  expect_error("has no attribute 9 for COLOR_0", [&](GltfBuilder& b) { extension(b)["attributes"]["COLOR_0"] = 9; });
  expect_error("COLOR_0 has 400 elements of 3 components, which accessors[2] contradicts",
               [&](GltfBuilder& b) { extension(b)["attributes"]["COLOR_0"] = 0; });
  expect_error("attribute POSITION has no number",
               [&](GltfBuilder& b) { extension(b)["attributes"]["POSITION"] = "zero"; });
  expect_error("POSITION has 400 elements", [](GltfBuilder& b) { b.json["accessors"][0]["count"] = 401; });
  expect_error("has more faces than its indices", [](GltfBuilder& b) { b.json["accessors"][1]["count"] = 3; });
  expect_error("2166 indices, which accessors[1]", [](GltfBuilder& b) { b.json["accessors"][1]["count"] = 3000; });
  expect_error("indices do not fit", [](GltfBuilder& b) { b.json["accessors"][1]["componentType"] = 5121; });
  expect_error("the primitive has no indices", [](GltfBuilder& b) { b.primitive().erase("indices"); });
  expect_error("is not a mesh in Draco's bitstream 2.2",
               [&](GltfBuilder& b) { extension(b)["bufferView"] = b.view(Bytes(200, 7)); });
  expect_error("cannot be decoded", [](GltfBuilder& b) { b.json["bufferViews"][0]["byteLength"] = 60; });
  for (const int method : {draco::MESH_SEQUENTIAL_ENCODING, draco::MESH_EDGEBREAKER_ENCODING}) {
    const Loaded loaded = draco_document(method, true).load();  // any outcome but a crash or an unreported refusal
    EXPECT_TRUE(loaded.summary.ok || loaded.count(Severity::error) > 0);
  }
}

// Headers that declare two thousand million faces or points in a few bytes.
TEST(GltfDraco, CountsAreCheckedBeforeAnythingIsDecoded) {
  const Bytes many = {0x80, 0x80, 0x80, 0x80, 7}, few = {3};
  const auto expect_refusal = [](std::vector<Bytes> parts, uint8_t method, const char* what) {
    Bytes bytes = {'D', 'R', 'A', 'C', 'O', 2, 2, 1, method, 0, 0};
    for (const Bytes& part : parts) bytes.insert(bytes.end(), part.begin(), part.end());
    bytes.resize(bytes.size() + 64);
    GltfBuilder b = draco_document(draco::MESH_SEQUENTIAL_ENCODING);
    b.primitive()["extensions"]["KHR_draco_mesh_compression"]["bufferView"] = b.view(bytes);
    const Loaded loaded = b.load();
    EXPECT_TRUE(loaded.says(Severity::error, what)) << loaded.said();
  };
  expect_refusal({many, few}, 0, "has more faces than its indices");
  expect_refusal({few, many}, 0, "has more points than");
  expect_refusal({{0}, few, many}, 1, "has more faces than its indices");
  expect_refusal({{0}, many, few}, 1, "cannot be decoded");
}

}  // namespace
}  // namespace alabaster::hd::gltf::testing

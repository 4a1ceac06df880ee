// Targets whose input is the content of a file.
#include "testenv/fuzz/small_render.h"

namespace alabaster::fuzz {
namespace {

constexpr const char* kModel =
    R"({"asset":{"version":"2.0"},"scene":0,"scenes":[{"nodes":[0]}],"nodes":[{"mesh":0,"name":"pebble"}],)"
    R"("materials":[{"name":"wax"}],"meshes":[{"primitives":[{"attributes":{"POSITION":0},"material":0}]}],)"
    R"("accessors":[{"bufferView":0,"componentType":5126,"count":3,"type":"VEC3","min":[0,0,0],"max":[1,1,0]}],)"
    R"("bufferViews":[{"buffer":0,"byteLength":36}],"buffers":[{"byteLength":36,"uri":)"
    R"("data:application/octet-stream;base64,AAAAAAAAAAAAAAAAAACAPwAAAAAAAAAAAAAAAAAAgD8AAAAA"}]})";
constexpr const char* kDescription =
    R"({"gltf":[{"file":"model.gltf"}],"materials":[{"match":"wax","set":{"scatterDistance":[0.1,0.1,0.1]}}],)"
    R"("lights":[{"name":"key","type":"rectLight","position":[0,2,2],"target":[0,0,0]}],)"
    R"("camera":{"transform":{"translate":[0,0,5]}}})";
constexpr const char* kImage = "#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y 1 +X 1\n\x80\x80\x80\x81";

Bytes bytes_of(const char* text) {
  return {reinterpret_cast<const uint8_t*>(text), std::char_traits<char>::length(text)};
}

void write_neighbours() {
  static const bool written = [] {
    scratch_file("model.gltf", bytes_of(kModel));
    scratch_file("image.hdr", bytes_of(kImage));
    scratch_file("base.json", bytes_of(kDescription));
    return true;
  }();
  static_cast<void>(written);
}

const char* image_extension(Bytes image) {
  constexpr struct {
    const char *extension, *magic;
  } kKinds[] = {{"png", "\x89PNG"}, {"jpg", "\xff\xd8"},     {"exr", "v/1\x01"}, {"hdr", "#?"},   {"tif", "II"},
                {"tif", "MM"},      {"bmp", "BM"},           {"webp", "RIFF"},   {"gif", "GIF8"}, {"dds", "DDS "},
                {"psd", "8BPS"},    {"jp2", "\0\0\0\x0cjP"}, {"ppm", "P"},       {"tga", ""}};
  for (const auto& kind : kKinds) {
    const Bytes magic = bytes_of(kind.magic);
    if (image.size() >= magic.size() && std::equal(magic.begin(), magic.end(), image.begin())) return kind.extension;
  }
  return "png";
}

}  // namespace

void run_gltf(Bytes input) {
  write_neighbours();
  const bool binary = input.size() >= 4 && input[0] == 'g' && input[1] == 'l' && input[2] == 'T';
  load_and_render(scratch_file(binary ? "fuzzed.glb" : "fuzzed.gltf", input));
}

void run_description(Bytes input) {
  write_neighbours();
  load_and_render(scratch_file("fuzzed.json", input));
}

namespace {

/// An archive whose list of prims is `text`, with a tensor of each of some types, all over the same numbers.
std::string archive_of(Bytes text) {
  std::string header =
      R"({"__metadata__":{"format":"alabaster scene","version":"1"},"points":{"dtype":"F32","shape":[4,3],)"
      R"("data_offsets":[0,48]},"counts":{"dtype":"I32","shape":[2],"data_offsets":[48,56]},"indices":)"
      R"({"dtype":"I32","shape":[6],"data_offsets":[56,80]},"image":{"dtype":"U8","shape":[80],)"
      R"("data_offsets":[0,80]},"scene.json":{"dtype":"U8","shape":[)" +
      std::to_string(text.size()) + R"(],"data_offsets":[80,)" + std::to_string(80 + text.size()) + "]}}";
  header.resize((header.size() + 7) / 8 * 8, ' ');
  std::string file(8, '\0');
  for (size_t i = 0; i < 8; ++i) file[i] = char(header.size() >> (8 * i) & 255);
  file += header;
  const float points[] = {0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0, 1};
  const int32_t counts_and_indices[] = {3, 3, 0, 1, 2, 0, 2, 3};
  file.append(reinterpret_cast<const char*>(points), sizeof points);
  file.append(reinterpret_cast<const char*>(counts_and_indices), sizeof counts_and_indices);
  return file.append(text.begin(), text.end());
}

}  // namespace

void run_archive(Bytes input) {
  write_neighbours();
  if (input.empty() || input[0] != '{') return load_and_render(scratch_file("fuzzed.alab", input));
  const std::string file = archive_of(input);
  load_and_render(scratch_file("fuzzed.alab", {reinterpret_cast<const uint8_t*>(file.data()), file.size()}));
}

void run_override(Bytes input) {
  write_neighbours();
  hd::description::LoadOptions options;
  options.overrides = {std::string(input.begin(), input.end())};
  load_and_render(scratch_folder() + "/base.json", options);
}

void run_image(Bytes input) {
  const std::string file = scratch_file(std::string("fuzzed.") + image_extension(input), input);
  hd::host::RetainedSceneDelegate scene;
  add_stage(&scene);
  scene.SetLight("/dome", {"domeLight", {}, {{"texture:file", hd::AssetPath{file, file, nullptr}}}});
  hd::MaterialNetwork network;
  network.nodes["/m/texture"] = {"AlabasterTexture", {{"file", hd::AssetPath{file, file, nullptr}}}, {}};
  network.nodes["/m/surface"] = {
      "AlabasterDisney", {}, {{"baseColor", {{"/m/texture", "rgb"}}}, {"roughness", {{"/m/texture", "r"}}}}};
  network.terminals["surface"] = {"/m/surface", "out"};
  scene.SetMaterial("/m", network);
  add_cube(&scene, "/m");
  render_small(&scene);
}

void run_ocio(Bytes input) {
  const std::string file = scratch_file("fuzzed.ocio", input);
  int errors = 0;
  const hd::DiagnosticSink sink = [&](const hd::Diagnostic& d) { errors += d.severity == hd::Severity::error; };
  const bool described = !hd::host::DescribeColors({file}, sink).empty();
  if (described == (errors > 0)) broken("an OpenColorIO config's answer and its reports contradict each other");
  if (!described) return;
  hd::RenderProduct product;
  product.file = scratch_folder() + "/fuzzed.png";
  if (!hd::host::CheckProduct(product, {0, 0, 1, 1}, {file}, sink)) return;
  const std::vector<float> pixels{0, 0.18f, 1, 1};
  hd::host::ProductImage image;
  image.framing = {{0, 0}, {1, 1}, {0, 0, 1, 1}, 1};
  image.aovs["color"] = {4, pixels, {}};
  hd::host::WriteProducts({product}, image, {file}, sink);
}

}  // namespace alabaster::fuzz

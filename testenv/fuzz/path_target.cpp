// Names of files with placeholders, links and "..", in scene files whose folder is `in`. Nothing outside of it may be
// opened or changed: not when the scene is loaded, and not by links that appear before its files are read and written.
#include <sys/inotify.h>
#include <sys/stat.h>
#include <unistd.h>

#include <array>
#include <filesystem>
#include <fstream>
#include <map>
#include <nlohmann/json.hpp>

#include "testenv/fuzz/small_render.h"
#include "testenv/fuzz/structured_input.h"

namespace alabaster::fuzz {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;

constexpr const char* kNames[] = {"a.png",  "t.1001.png", "t.<UDIM>.png", "o.exr", "o.####.exr", "o.0007.exr",
                                  "m.gltf", "c.ocio",     "l.ies",        "b.bin", "below",      "link",
                                  "..",     ".",          "secret.png",   "out"};

/// The folders `in` and `out`, and what happens in the second.
class Tree {
 public:
  Tree() {
    fs::create_directories(in());
    fs::create_directories(out() / "below");
    const int watch_events = IN_OPEN | IN_ACCESS | IN_MODIFY | IN_CREATE | IN_DELETE | IN_MOVE | IN_ATTRIB;
    for (const char* name : kNames)
      if (is_plain(name)) put(out() / name), put(out() / "below" / name);
    put(out() / "secret.png");
    events_ = ::inotify_init1(IN_NONBLOCK | IN_CLOEXEC);
    for (const fs::path& folder : {out(), out() / "below"})
      if (events_ >= 0 && ::inotify_add_watch(events_, folder.c_str(), watch_events) < 0) events_ = -1;
  }
  static fs::path in() { return fs::path(scratch_folder()) / "in"; }
  static fs::path out() { return fs::path(scratch_folder()) / "out"; }
  static bool is_plain(const std::string& name) {
    return name.find('.') != std::string::npos && name != "." && name != "..";
  }

  /// A new folder `in`, with a file of each name.
  void reset() {
    fs::remove_all(in());
    fs::create_directories(in() / "below");
    for (const char* name : kNames)
      if (is_plain(name)) put(in() / name), put(in() / "below" / name);
  }
  /// Aborts if something has happened outside since the last call.
  void check() {
    alignas(inotify_event) std::array<char, 4096> buffer{};
    const ssize_t size = events_ < 0 ? 0 : ::read(events_, buffer.data(), buffer.size());
    if (size > 0) {
      const auto* event = reinterpret_cast<const inotify_event*>(buffer.data());
      char text[40];
      std::snprintf(text, sizeof text, " (events %x)", unsigned(event->mask));
      broken("outside of the folder something was done to '" + std::string(event->len ? event->name : "the folder") +
             "'" + text);
    }
  }

 private:
  static void put(const fs::path& file) {
    const std::string name = file.filename().string();
    std::ofstream(file, std::ios::binary) << (name.ends_with(".gltf") ? model("b.bin", "a.png").dump()
                                              : name == "l.ies"       ? kProfile
                                                                      : kImage);
  }

 public:
  static json model(const std::string& buffer, const std::string& image) {
    json document = json::parse(kModel);
    document["buffers"][0]["uri"] = buffer;
    document["images"][0]["uri"] = image;
    return document;
  }

 private:
  // An image of one texel, which its content makes one under any name, and a buffer of enough bytes.
  static constexpr const char* kImage =
      "#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y 1 +X 1\n\x80\x80\x80\x81 and further bytes for a buffer of 60\n";
  static constexpr const char* kProfile = "IESNA91\nTILT=NONE\n1 1000 1 2 1 1 2 0 0 0\n1 1 100\n0 90\n0\n1 1\n";
  static constexpr const char* kModel =
      R"({"asset":{"version":"2.0"},"scene":0,"scenes":[{"nodes":[0]}],"nodes":[{"mesh":0}],
      "materials":[{"name":"wax","pbrMetallicRoughness":{"baseColorTexture":{"index":0}}}],"textures":[{"source":0}],
      "images":[{}],"meshes":[{"primitives":[{"attributes":{"POSITION":0,"TEXCOORD_0":1},"material":0}]}],
      "accessors":[{"bufferView":0,"componentType":5126,"count":3,"type":"VEC3","min":[0,0,0],"max":[1,1,0]},
      {"bufferView":0,"componentType":5126,"count":3,"type":"VEC2"}],
      "bufferViews":[{"buffer":0,"byteLength":36}],"buffers":[{"byteLength":36}]})";

  int events_ = -1;
};

std::string name_from(StructuredInput& in) {
  std::string name;
  switch (in.choice(8)) {
    case 0:
      name = Tree::in().string() + "/";
      break;
    case 1:
      name = Tree::out().string() + "/";
      break;
    case 2:
      name = "../out/";
      break;
    default:
      break;
  }
  for (int parts = 1 + in.choice(3); parts > 0; --parts) {
    const int chosen = in.choice(int(std::size(kNames)) + 1);
    name += chosen < int(std::size(kNames)) ? kNames[chosen] : in.text(size_t(in.choice(12)));
    if (parts > 1) name += "/";
  }
  return name;
}

/// Links in place of names of `in`, which lead anywhere.
void make_links(StructuredInput& in) {
  for (int left = in.choice(4); left > 0; --left) {
    const fs::path folder = Tree::in() / (in.flag() ? "below" : ".");
    const std::string name = kNames[in.choice(std::size(kNames))], to = name_from(in);
    const bool is_fifo = in.choice(16) == 15;
    if (name == "." || name == ".." || fs::is_symlink(folder)) continue;  // which would lead outside
    std::error_code ignored;
    fs::remove_all(folder / name, ignored);
    if (is_fifo)
      static_cast<void>(::mkfifo((folder / name).c_str(), 0600));
    else if (!to.empty() && to.find('\0') == std::string::npos)
      fs::create_symlink(to, folder / name, ignored);
  }
}

std::string text_of(const json& document) {
  return document.dump(-1, ' ', false, json::error_handler_t::replace);
}

std::string write_scene(StructuredInput& in) {
  const bool whole = in.flag();
  const std::string image = name_from(in), buffer = in.flag() ? name_from(in) : "b.bin";
  std::ofstream(Tree::in() / "scene.gltf") << text_of(Tree::model(buffer, image));
  if (!whole) return Tree::in() / "scene.gltf";
  json description;
  description["gltf"][0]["file"] = in.choice(4) != 3 ? "scene.gltf" : name_from(in);
  if (in.flag()) description["ocio"] = name_from(in);
  if (in.flag()) description["products"][0]["file"] = name_from(in);
  if (in.flag()) {
    const std::string sky = name_from(in), profile = name_from(in);
    description["lights"] = {{{"name", "sky"}, {"type", "domeLight"}, {"texture:file", sky}},
                             {{"name", "bulb"}, {"type", "sphereLight"}, {"shaping:ies:file", profile}}};
  }
  if (in.flag()) {
    const std::string color = name_from(in);
    description["materials"] = {{{"match", "*"}, {"set", {{"baseColor", {{"file", color}}}}}}};
  }
  std::ofstream(Tree::in() / "scene.json") << text_of(description);
  return Tree::in() / "scene.json";
}

/// As the program names the files of frame 7.
std::string numbered(std::string file) {
  if (const size_t at = file.find("####"); at != std::string::npos) file.replace(at, 4, "0007");
  return file;
}

void write_products(const hd::host::RetainedSceneDelegate& scene, const hd::Path& settings) {
  const std::vector<float> pixels{0, 0.18f, 1, 1};
  hd::host::ProductImage image;
  image.framing = {{0, 0}, {1, 1}, {0, 0, 1, 1}, 1};
  image.aovs["color"] = {4, pixels, {}};
  for (hd::RenderProduct product : scene.GetAllRenderSettings().at(settings).products) {
    product.file = numbered(product.file);
    hd::host::CheckProduct(product, image.framing.dataWindow, {"built-in"}, {});
    hd::host::WriteProducts({product}, image, {"built-in"}, {});
  }
}

}  // namespace

void run_path(Bytes input) {
  static Tree tree;
  StructuredInput in(input);
  tree.reset();
  make_links(in);
  const std::string file = write_scene(in);
  hd::host::RetainedSceneDelegate scene;
  hd::description::LoadOptions options;
  options.keep_going = in.flag();
  const hd::description::SceneFile loaded = hd::description::LoadScene(file, &scene, {}, options);
  tree.check();
  if (!loaded.ok) return;
  make_links(in);
  write_products(scene, loaded.settings);
  if (!loaded.color_config.empty())
    hd::host::DescribeColors({loaded.color_config, nullptr, loaded.color_config_within}, {});
  SmallRender render{.settings = loaded.settings, .options = {}};
  render.options.keep_going = options.keep_going;
  render_small(&scene, render);
  tree.check();
}

}  // namespace alabaster::fuzz

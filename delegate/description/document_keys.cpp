#include "delegate/description/document_keys.h"

#include <algorithm>

#include "delegate/description/quality_presets.h"
#include "delegate/host/product_writer.h"

namespace alabaster::hd::description {
namespace {

using Form = Key::Form;
using Words = std::vector<std::string>;

// Values of the description's own ---------------------------------------------------------------------
Key value(const char* name, int32_t type, const char* meaning, Value fallback = {}, const char* unit = "") {
  Key key{{name, unit, meaning, {type, false}}};
  key.row.fallback = std::move(fallback);
  return key;
}
Key text(const char* name, const char* meaning, Value fallback = {}) {
  return value(name, ALABASTER_STRING, meaning, std::move(fallback));
}
Key word(const char* name, Words words, const char* meaning, Value fallback = {}) {
  Key key = value(name, ALABASTER_TOKEN, meaning, std::move(fallback));
  key.row.words = std::move(words);
  return key;
}
Key within(double low, double high, Key key) {
  key.row.low = low, key.row.high = high;
  return key;
}
Key at_least(double low, Key key) {
  return within(low, kInfinite, std::move(key));
}
/// A list of such values; `count` of them, or at least `least`.
Key list(size_t least, Key key, size_t most = ~size_t(0)) {
  key.form = Form::values, key.least = least, key.most = most;
  return key;
}
Key numbers(const char* name, size_t count, const char* meaning, Value fallback = {}, const char* unit = "") {
  return list(count, value(name, ALABASTER_FLOAT, meaning, std::move(fallback), unit), count);
}

// Objects ----------------------------------------------------------------------------------------------
Key object(const char* name, const char* meaning, Keys keys, std::vector<Words> needs = {}) {
  Key key{{name, "", meaning}};
  key.keys = std::move(keys), key.form = Form::object, key.needs = std::move(needs);
  return key;
}
Key objects(const char* name, const char* meaning, Keys keys, std::vector<Words> needs = {}, size_t least = 0) {
  Key key = object(name, meaning, std::move(keys), std::move(needs));
  key.form = Form::objects, key.least = least;
  return key;
}
Key referred(const char* reference, Key key, bool has_own_text = false) {
  key.reference = reference, key.has_own_text = has_own_text;
  return key;
}

// Fields and parameters of prims -----------------------------------------------------------------------
void add_parameters(const std::string& schema, const std::string& kind, Keys* keys) {
  for (host::FieldRow& row : host::ParameterRows(schema)) {
    const std::string reference = schema + ".json#/properties/" + row.name;
    keys->push_back({std::move(row), kind, {}, Form::value, 0, ~size_t(0), {}, reference});
  }
}
void add_fields(const std::string& kind, const Words& names, Keys* keys) {
  for (host::FieldRow& row : host::FieldRows(kind))
    if (std::find(names.begin(), names.end(), row.name) != names.end()) keys->push_back({std::move(row), kind});
}
Keys joined(std::initializer_list<Keys> parts) {
  Keys all;
  for (const Keys& part : parts) all.insert(all.end(), part.begin(), part.end());
  return all;
}

// Images -----------------------------------------------------------------------------------------------
Keys image(const char* file, const char* color_space) {
  return {text("file", file), text("colorSpace", color_space, "auto"),
          word("wrap", {"repeat", "mirror", "clamp", "black"}, "Continuation of the image outside the unit square.",
               "repeat"),
          text("st", "The mesh's texture coordinates that the image is looked up by.", "st")};
}

Keys material_parameters() {
  Keys keys;
  add_parameters("disney_material", "material", &keys);
  for (Key& key : keys) {
    if (key.row.texture.empty()) continue;
    Key image = texture_key(key.row.texture);
    key.keys = std::move(image.keys), key.needs = std::move(image.needs), key.form = Form::value_or_object;
  }
  return keys;
}

constexpr const char* kHeightChannel = "Channel of the image that is the height.";
Keys relief(const char* file, Keys more) {
  return joined({image(file, "Colour space of the image; auto is raw."),
                 {word("channel", {"r", "g", "b", "a"}, kHeightChannel, "r")},
                 std::move(more)});
}

// Placements -------------------------------------------------------------------------------------------
Key transform() {
  Key key = numbers("transform", 16, "Placement: sixteen numbers in scene units, or translate, rotate and scale.");
  key.form = Form::values_or_object;
  key.keys = {numbers("translate", 3, "Applied last.", Vec3f(0), "scene unit"),
              numbers("rotate", 3, "Rotations around x, then y, then z.", Vec3f(0), "degrees"),
              numbers("scale", 3, "Applied first.", Vec3f(1), "none")};
  return referred("#/definitions/transform", std::move(key));
}
Key motion(const char* meaning = nullptr) {
  return referred(
      "#/definitions/motion",
      objects("motion",
              meaning ? meaning
                      : "Placements at increasing times, in place of a transform. Motion while the "
                        "camera's shutter is open is blurred.",
              {value("time", ALABASTER_FLOAT, "Time relative to the frame that is drawn.", {}, "frames"), transform()},
              {{"time", "transform"}}, 2),
      meaning != nullptr);
}

// Parts of a description -------------------------------------------------------------------------------
Key models(const char* name = "models", const char* meaning = "Models, in the order of loading.") {
  Key level =
      value("refineLevel", ALABASTER_INT, "Subdivision level of meshes with quads (FB_ngon_encoding).", 2, "levels");
  return referred(
      "#/definitions/models",
      objects(name, meaning,
              {text("file", ".gltf, .glb, .usd, .usda, .usdc, .usdz or .alab (a scene archive) file."), transform(),
               motion(), within(0, 8, std::move(level)),
               text("scene", "Scene of the file, by name or index; without it the file's default."),
               text("animation", "Animation of the file, by name or index; without it the first."),
               text("variant", "Variant of the file's materials (KHR_materials_variants), by name or index."),
               value("time", ALABASTER_FLOAT,
                     "Time in the animation; the time of the command line is added. Without both, the model keeps the "
                     "pose in which it is authored.",
                     0.0f, "seconds")},
              {{"file"}}),
      std::string(name) != "models");
}

Key materials() {
  return objects(
      "materials",
      "Changes to materials, applied in order: either match with set, replace or mtlx, or name with set or mtlx; "
      "either "
      "with bump and displacement. A match without a result is an error.",
      {text("match", "Name or path of materials to change; * stands for any text, ? for any character."),
       text("name", "Makes a new material of this name, which meshes can use."),
       referred("disney_material.json",
                object("set", "Parameters to change; all others keep their values. One that is set loses its texture.",
                       material_parameters()),
                true),
       referred("disney_material.json",
                object("replace", "A new definition of the material; parameters not given take their defaults.",
                       material_parameters()),
                true),
       object("mtlx", "A material of MaterialX in the place of the definition; set changes what it gives.",
              {text("file", ".mtlx file."), text("material", "Its material, where it has several.")}, {{"file"}}),
       object("bump", "Heights that tilt the normals and leave the surface where it is.",
              relief("Image of heights, in place of a normal map.",
                     {value("scale", ALABASTER_FLOAT, "Height where the image is 1, in the mesh's own units.", 1.0f,
                            "unit of the mesh")}),
              {{"file"}}),
       object(
           "displacement",
           "Moves the points of the meshes that use the material, before they are traced. Give the meshes enough "
           "points by refineLevel.",
           relief(
               "Image of heights or of vectors.",
               {word("space", {"normal", "tangent", "object"},
                     "normal moves points along their normals by one channel. The others move them by the image's "
                     "colour as a vector: tangent along growing u, growing v and the normal, object along the "
                     "mesh's own axes.",
                     "normal"),
                value("scale", ALABASTER_FLOAT, "Points move by (value - midlevel) * scale, in the mesh's own units.",
                      1.0f, "unit of the mesh"),
                value("midlevel", ALABASTER_FLOAT, "Value of the image that leaves the surface where it is.", 0.0f)}),
           {{"file"}})},
      {{"match"}, {"name"}});
}

Key meshes() {
  Keys keys{text("match",
                 "Name or path of meshes to change, or path of a subset, to which material and visible apply; * stands "
                 "for any text, ? for any character.")};
  add_fields("mesh", {"scheme", "refineLevel", "interpolateBoundary", "faceVaryingLinearInterpolation", "visible"},
             &keys);
  add_parameters("mesh", "mesh", &keys);
  const Key sharpness = at_least(0, value("sharpness", ALABASTER_FLOAT,
                                          "Sharpness: 0 is smooth, 10 and above infinitely sharp.", 10.0f, "levels"));
  keys.push_back(objects("creases", "Sharp edges, which replace the mesh's own.",
                         {list(2, at_least(0, value("points", ALABASTER_INT,
                                                    "Points along the crease; consecutive points share an edge."))),
                          sharpness},
                         {{"points"}}));
  keys.push_back(objects("corners", "Sharp points, which replace the mesh's own.",
                         {at_least(0, value("point", ALABASTER_INT, "Index of the point.", 0, "none")), sharpness},
                         {{"point"}}));
  keys.push_back(text("material", "Name or path of the material to use."));
  keys.push_back(motion("What moves the mesh in the world, from time 0 on, after its own placement."));
  return objects("meshes", "Changes to meshes, applied in order. A match without a result is an error.",
                 std::move(keys), {{"match"}});
}

Key lights() {
  Keys keys{text("name", "Name of a new light."),
            text("match", "Name or path of lights to change; * stands for any text, ? for any character."),
            word("type", {std::begin(kLightTypes), std::end(kLightTypes)}, "Type of a new light.")};
  add_parameters("lights", "light", &keys);
  const Keys more{
      list(0, value("lightLink", ALABASTER_STRING,
                    "Names or paths of the meshes that the light lights, * stands for any text, ? for any character; "
                    "without it all. Emissive meshes light everything.",
                    {}, "none")),
      list(0, value("shadowLink", ALABASTER_STRING,
                    "Names or paths of the meshes that cast shadows of the light; without it all.", {}, "none")),
      transform(),
      numbers("position", 3, "Position of the light.", {}, "scene unit"),
      numbers("target", 3, "A point that the light shines at (along its -z axis).", {}, "scene unit"),
      numbers("up", 3, "Direction towards which the light's y axis leans.", Vec3f(0, 1, 0), "none")};
  return objects("lights",
                 "Lights to add (name and type), or changes to lights of the models (match). A transform excludes "
                 "position, target and up.",
                 joined({keys, more}), {{"name", "type"}, {"match"}});
}

Key camera() {
  Keys keys{text("use", "Name or path of a camera of the models, whose placement and lens the other keys change."),
            transform(), motion(),
            object("lookAt", "Placement by eye and target.",
                   {numbers("eye", 3, "Position of the camera.", {}, "scene unit"),
                    numbers("target", 3, "Point that the camera looks at.", {}, "scene unit"),
                    numbers("up", 3, "Direction that points up in the picture.", Vec3f(0, 1, 0), "none")},
                   {{"eye", "target"}})};
  add_parameters("camera", "camera", &keys);
  return object("camera",
                "The camera. Without a placement the models' first camera is used; if there is none, the scene is "
                "framed. Lens and film are in millimetres, distances in metres.",
                std::move(keys));
}

Keys frame() {
  Key resolution = within(
      1, 65536,
      value("resolution", ALABASTER_INT, "Width and height of the full frame.", Array<int32_t>{1280, 720}, "pixels"));
  Key crop = within(
      std::numeric_limits<int32_t>::min(), std::numeric_limits<int32_t>::max(),
      value("crop", ALABASTER_INT,
            "Region of the frame to render: x0, y0, x1, y1 with y downwards and the end excluded.", {}, "pixels"));
  return {list(2, std::move(resolution), 2), list(4, std::move(crop), 4)};
}

Key settings() {
  Words presets;
  for (const QualityPreset& preset : QualityPresets()) presets.push_back(preset.name);
  Keys keys{word("quality", std::move(presets),
                 "Preset of measured settings (quality_presets.json). Settings given beside it override the preset's."),
            word("studio", {"auto", "on", "off"},
                 "Studio around the objects: key, fill and rim lights, and a neutral backdrop. auto adds it to a scene "
                 "without light, and the backdrop only if there is no camera either; on replaces the scene's lights "
                 "except domes; off adds a soft dome to a scene without light.",
                 "auto")};
  add_parameters("render_settings", "renderSettings", &keys);
  std::erase_if(keys, [](const Key& key) { return key.row.name == "frame"; });  // a field of the prim, too
  add_fields("renderSettings", {"frame", "pixelAspectRatio", "windowPolicy"}, &keys);
  return object("settings", "Render settings.", joined({keys, frame()}));
}

Key products() {
  Keys fields;
  add_fields("product",
             {"dataType", "compression", "tiles", "colorSpace", "display", "view", "look", "exposure", "denoise"},
             &fields);
  Key aovs = word(
      "aovs", host::ProductAovs(),
      "AOVs to write, as layers of an EXR; color by default. primvars:NAME shows the primvar of that name, "
      "lightGroup:NAME the light of that group, and lightGroup:* is all groups. lpe:EXPRESSION is the AOV of these "
      "light paths.");
  aovs.beginnings = {"primvars:", "lightGroup:", "lpe:"};
  return objects("products", "Files to write. Products with the same resolution and crop share a render.",
                 joined({{text("file", "File to write: .exr, .png, .tif, .tiff, .jpg or .jpeg.")},
                         frame(),
                         {list(1, std::move(aovs))},
                         fields}),
                 {{"file"}});
}

}  // namespace

Key texture_key(const std::string& name) {
  const bool is_number = name == "numberTexture";
  Keys keys = image(
      "Image file; a relative name is relative to the render description's folder. <UDIM> in the name stands for the "
      "numbers 1001 + u + 10 v of a set of images, one for each unit square of texture coordinates.",
      name == "colorTexture"
          ? "Colour space of the image: auto (sRGB for 8 and 16 bit; for float the primaries that the file names, else "
            "the rendering space), sRGB, raw, linear (Rec. 709, also where a config renders in another space, such as "
            "ACEScg), or a name from the OCIO config."
          : "Colour space of the image: auto (raw: values are plain numbers, 8-bit ones from 0 to 1), or as for "
            "baseColor.");
  keys.push_back(text("layer",
                      "Layer of an EXR that the image is: a part, or what stands before R, G and B in the names of its "
                      "channels. Without it, the picture (RGBA, beauty, Combined, ...).",
                      ""));
  if (is_number) {
    keys.push_back(word("channel", {"r", "g", "b", "a", "direction"},
                        "The channel of the image that is read; direction is the angle of the vector (2 r - 1, 2 g - "
                        "1), in turns from (1, 0) towards (0, 1), needs colorSpace raw, and is for anisotropicRotation "
                        "alone.",
                        "r"));
    keys.push_back(value("scale", ALABASTER_FLOAT, "Multiplies the image: the parameter where the image is 1.", 1.0f));
  } else {
    keys.push_back(
        at_least(0, numbers("scale", 3, "Multiplies the image per channel: the parameter where the image is 1.",
                            Vec3f(1), name == "distanceTexture" ? "scene unit" : "")));
  }
  return object(name.c_str(),
                is_number                ? "A channel of a texture instead of a number."
                : name == "colorTexture" ? "A texture instead of a colour."
                                         : "A texture of distances, looked up where light enters. Negative and "
                                           "non-finite texels count as 0.",
                std::move(keys), {{"file"}});
}

const Key& description_key() {
  static const auto* key = new Key(
      object("render_description",
             "Everything that glTF cannot express: models under transforms, changes to materials, subdivision, lights, "
             "camera, "
             "settings and the files to write. File names are absolute or relative to the description's folder.",
             {models(), models("gltf", "The former name of models."), materials(), meshes(), lights(), camera(),
              settings(), products(),
              text("ocio", "OpenColorIO config. The command line's --ocio overrides it, and it overrides $OCIO.")}));
  return *key;
}

const Key* find_key(const Keys& keys, const std::string& name) {
  const auto found = std::find_if(keys.begin(), keys.end(), [&](const Key& key) { return key.row.name == name; });
  return found == keys.end() ? nullptr : &*found;
}

std::vector<std::string> names_of(const Keys& keys) {
  std::vector<std::string> names;
  for (const Key& key : keys) names.push_back(key.row.name);
  return names;
}

}  // namespace alabaster::hd::description

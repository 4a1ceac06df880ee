// Plain structs in Hydra's terms: the answers of a SceneDelegate.
#pragma once

#include <optional>

#include "delegate/api/types.h"

namespace alabaster::hd {

// Dirty bits ---------------------------------------------------------------------------------------
/// The bits are our own; an adaptor translates Hydra's. A Sync pulls only what is dirty.
using DirtyBits = uint32_t;
namespace dirty {
inline constexpr DirtyBits kClean = 0;
inline constexpr DirtyBits kPrimId = 1u << 0;
inline constexpr DirtyBits kPoints = 1u << 1;
inline constexpr DirtyBits kPrimvar = 1u << 2;  // a value or the set of descriptors
inline constexpr DirtyBits kMaterialId = 1u << 3;
inline constexpr DirtyBits kTopology = 1u << 4;
inline constexpr DirtyBits kTransform = 1u << 5;
inline constexpr DirtyBits kVisibility = 1u << 6;
inline constexpr DirtyBits kNormals = 1u << 7;
inline constexpr DirtyBits kDoubleSided = 1u << 8;
inline constexpr DirtyBits kDisplayStyle = 1u << 9;
inline constexpr DirtyBits kSubdivTags = 1u << 10;
inline constexpr DirtyBits kInstancer = 1u << 11;
inline constexpr DirtyBits kInstanceIndex = 1u << 12;
inline constexpr DirtyBits kRenderTag = 1u << 13;
inline constexpr DirtyBits kParams = 1u << 14;       // camera, light, material, render settings
inline constexpr DirtyBits kResource = 1u << 15;     // material network, light texture
inline constexpr DirtyBits kDescription = 1u << 16;  // render buffer
inline constexpr DirtyBits kCategories = 1u << 17;   // mesh, instancer
inline constexpr DirtyBits kCullStyle = 1u << 18;
inline constexpr DirtyBits kAll = ~0u;
}  // namespace dirty

/// The prim types of Rprims.
inline constexpr const char* kRprimTypes[] = {"mesh", "basisCurves", "points"};

// Meshes -------------------------------------------------------------------------------------------
enum class Interpolation { constant, uniform, varying, vertex, faceVarying, instance };

/// Those that meshes are asked for: delegate/manual/usd.md. Those of an instancer that are `instance`, with a value for
/// each of its points, are read in their place.
struct PrimvarDescriptor {
  Token name;
  Interpolation interpolation = Interpolation::vertex;
  Token role;  // none | color | lin_rec709 (a colour of that space) | vector | normal | point | textureCoordinate
  bool indexed = false;
  bool operator==(const PrimvarDescriptor&) const = default;
};

struct GeomSubset {
  Path id;
  Path materialId;
  Array<int32_t> indices;  // faces
  bool operator==(const GeomSubset&) const = default;
};

struct MeshTopology {
  Token scheme = "none";              // none | catmullClark | loop | bilinear
  Token orientation = "rightHanded";  // rightHanded | leftHanded
  Array<int32_t> faceVertexCounts;
  Array<int32_t> faceVertexIndices;
  Array<int32_t> holeIndices;
  Array<int32_t> invisibleFaces;   // not drawn; unlike holes they leave the surface around them as it is
  Array<int32_t> invisiblePoints;  // nothing: points of meshes are not drawn
  std::vector<GeomSubset> geomSubsets;
  bool operator==(const MeshTopology&) const = default;
};

/// The sides of its faces that a mesh does not show. Light meets faces by their double-sidedness, so `back` and `front`
/// hide them from camera rays alone: light does not fall through the wall of a room that the camera looks through. The
/// others decide for all rays, but for frontUnlessDoubleSided where it is front.
enum class CullStyle {
  dontCare,                // by double-sidedness
  nothing,                 // double-sided, whatever the mesh says
  back,                    // faces that the camera would see from behind
  front,                   // faces that the camera would see from the front; double-sided for all other rays
  backUnlessDoubleSided,   // by double-sidedness
  frontUnlessDoubleSided,  // front; nothing if double-sided
};

struct SubdivTags {
  Token interpolateBoundary;             // none | edgeOnly | edgeAndCorner (empty = edgeAndCorner)
  Token faceVaryingLinearInterpolation;  // all | none | boundaries | cornersOnly | cornersPlus1 | cornersPlus2 (empty =
                                         // cornersPlus1)
  Token creaseMethod;                    // uniform | chaikin
  Token triangleSubdivision;             // catmullClark | smooth
  Array<int32_t> creaseIndices, creaseLengths;
  Array<float> creaseWeights;  // per crease or per edge
  Array<int32_t> cornerIndices;
  Array<float> cornerWeights;
  bool operator==(const SubdivTags&) const = default;
};

inline constexpr int kMaxRefineLevel = 8;
struct DisplayStyle {
  int refineLevel = 0;  // 0..kMaxRefineLevel; 0 draws the cage
  bool operator==(const DisplayStyle&) const = default;
};

// Curves -------------------------------------------------------------------------------------------
/// Curves are drawn as closed tubes: delegate/manual/usd.md, "Curves and points".
struct BasisCurvesTopology {
  Token type = "cubic";              // cubic | linear
  Token basis = "bezier";            // bezier | bspline | catmullRom; of cubic curves
  Token wrap = "nonperiodic";        // nonperiodic | periodic | pinned
  Array<int32_t> curveVertexCounts;  // the points of each curve, which stand one after the other
  bool operator==(const BasisCurvesTopology&) const = default;
};

// Materials ----------------------------------------------------------------------------------------
/// From an output of another node, upstream.
struct MaterialConnection {
  Path upstreamNode;
  Token upstreamOutput;
  bool operator==(const MaterialConnection&) const = default;
};
struct MaterialNode {
  Token nodeTypeId;  // see MaterialNetwork
  std::map<Token, Value> parameters;
  std::map<Token, std::vector<MaterialConnection>> inputConnections;
  bool operator==(const MaterialNode&) const = default;
};
/// HdMaterialNetwork2's shape. Terminal "surface" names the surface node, terminal "displacement" (if any) the one that
/// displaces the meshes that the material is bound to. Node types:
/// - AlabasterDisney: parameters of schemas/disney_material.json. Every number and colour can be connected. An input's
///   value is its constant (1 if it is not given) times all that is connected to it, clamped to its range. `normal` and
///   `coatNormal` take a texture of normals in tangent space; `bump`, in place of `normal`, one of heights in the
///   mesh's object space units.
///   A colour's constant NAME is in the rendering space, or, where NAME:colorSpace is the Token lin_rec709, in linear
///   Rec. 709. Setting NAME by a field or a description takes NAME:colorSpace away. The color of a light has
///   color:colorSpace.
/// - AlabasterDisplacement: input `displacement`, connected to a texture, and those of schemas/displacement_node.json.
///   Points move by (value - midlevel) * scale in the mesh's object space: along the normal by one channel, or by the
///   vector rgb.
/// - AlabasterTexture: file AssetPath and the inputs of schemas/texture_node.json. Words and names are Tokens,
///   transforms Vec2f and Vec4f: value = texel * scale + bias. Outputs rgb, r, g, b, a, and direction for
///   anisotropicRotation. sourceColorSpace "auto" is sRGB or linear by the image's type for colours, raw for numbers
///   (scatterDistance among them).
/// - AlabasterPrimvar: the primvar `varname` of one to four numbers, of the instance or the mesh (outputs rgb, r, g, b,
///   a); `fallback` (0) where there is none. Without a name, displayColor and as `a` displayOpacity, which are 1 where
///   there is none. scale and bias as AlabasterTexture.
/// - UsdPreviewSurface, surfaces of MaterialX and Arnold, and the nodes above them, as authored: delegate/manual/usd.md
///   lists them. A parameter colorSpace:NAME says the space of NAME.
struct MaterialNetwork {
  std::map<Path, MaterialNode> nodes;
  std::map<Token, MaterialConnection> terminals;
  bool operator==(const MaterialNetwork&) const = default;
};

// Lights and cameras --------------------------------------------------------------------------------
/// The prim types of lights. Their parameters have the names of schemas/lights.json.
inline constexpr const char* kLightTypes[] = {"rectLight", "sphereLight", "distantLight",
                                              "domeLight", "diskLight",   "cylinderLight"};

// Selections and cameras of a pass --------------------------------------------------------------------
/// Rprims by path: those at or below a root, and not at or below an excluded path. Paths are compared by their parts
/// between '/'. No root: all.
struct Collection {
  std::vector<Path> rootPaths, excludePaths;
  bool operator==(const Collection&) const = default;
};

/// A camera by value. Parameters have the names of schemas/camera.json.
struct CameraDescription {
  Matrix4d transform;
  std::map<Token, Value> parameters;
  TimeSamples<Matrix4d> transformSamples = {};  // of what moves
  bool operator==(const CameraDescription&) const = default;
};

// Framing and outputs ------------------------------------------------------------------------------
enum class WindowPolicy { matchVertically, matchHorizontally, fit, crop, dontConform };

/// y-down, half open, in pixels.
struct Rect2i {
  int minX = 0, minY = 0, maxX = 0, maxY = 0;
  int width() const { return maxX - minX; }
  int height() const { return maxY - minY; }
  bool empty() const { return maxX <= minX || maxY <= minY; }
  bool contains(int x, int y) const { return minX <= x && x < maxX && minY <= y && y < maxY; }
  bool overlaps(const Rect2i& o) const { return minX < o.maxX && minY < o.maxY && o.minX < maxX && o.minY < maxY; }
  bool operator==(const Rect2i&) const = default;
};
struct Framing {
  Vec2f displayMin{0, 0}, displayMax{0, 0};  // display window
  Rect2i dataWindow;                         // larger = overscan, smaller = crop
  float pixelAspectRatio = 1;
  bool operator==(const Framing&) const = default;
  bool valid() const {
    return displayMax.x > displayMin.x && displayMax.y > displayMin.y && !dataWindow.empty() && pixelAspectRatio > 0;
  }
};

enum class Format {
  invalid,
  unorm8,
  unorm8vec3,
  unorm8vec4,
  float16,
  float16vec3,
  float16vec4,
  float32,
  float32vec2,
  float32vec3,
  float32vec4,
  int32
};
ALABASTER_API size_t FormatSize(Format format);  // bytes per pixel
ALABASTER_API int FormatComponents(Format format);

struct RenderBufferDescriptor {
  Vec3i dimensions{0, 0, 1};
  Format format = Format::invalid;
  bool operator==(const RenderBufferDescriptor&) const = default;
};

struct AovDescriptor {
  Format format = Format::invalid;  // invalid: the AOV is not supported
  Value clearValue;
};

/// A file to write: UsdRenderProduct with its vars, flattened.
struct RenderVar {
  std::string name;         // channel layer name
  Token aov;                // source: color, depth, ...
  Token dataType = "half";  // half | float | int
  bool operator==(const RenderVar&) const = default;
};
struct RenderProduct {
  std::string file;                 // .exr .png .tif .tiff .jpg .jpeg
  std::vector<RenderVar> vars;      // empty: color (with alpha)
  Token dataType;                   // exr: half (default) | float; png, tiff: uint8 (default) | uint16; jpeg: uint8
  Token compression;                // exr: empty is zip
  int tiles = 0;                    // exr: pixels of a side of its tiles; 0: scanlines
  std::string colorSpace;           // scene-referred output space; empty: the rendering space for EXR
  std::string display, view, look;  // display-referred output (default for png/tiff/jpeg)
  float exposure = 0;               // stops, with display output
  std::optional<bool> denoise;      // exr: AOV denoised beside color; else it in color's place. Unset: the setting
  // These make it a picture of its own, with samples of its own:
  Path camera;                       // empty: that of the settings
  int width = 0, height = 0;         // 0: those of the settings; a crop is scaled with them
  bool disableMotionBlur = false;    // drawn at the frame's time
  bool disableDepthOfField = false;  // through a pinhole
  std::string within;                // as of an AssetPath: where the file must be written
  bool operator==(const RenderProduct&) const = default;
};

/// The RenderSettings Bprim: synced first, so that camera, shutter and frame are known before anything else.
struct RenderSettingsDescription {
  Path camera;
  int width = 1280, height = 720;
  float pixelAspectRatio = 1;
  WindowPolicy windowPolicy = WindowPolicy::matchVertically;
  std::optional<Rect2i> crop;  // pixels, y-down, of the full frame
  double frame = 0;
  std::vector<Token> includedPurposes{"default", "render"};  // of USD; render tags, but for `default`: geometry
  std::vector<RenderProduct> products;
  Dictionary settings;  // names of schemas/render_settings.json
  bool operator==(const RenderSettingsDescription&) const = default;
  Rect2i frame_window() const { return {0, 0, width, height}; }
  Rect2i window() const { return crop.value_or(frame_window()); }  // the pixels to render
};

}  // namespace alabaster::hd

/* Handles, values and structs of the C door: alabaster.h, which includes this, says how they are used. */
#ifndef ALABASTER_TYPES_H
#define ALABASTER_TYPES_H

#include <stddef.h>
#include <stdint.h>

#ifdef __cplusplus
extern "C" {
#endif

typedef struct AlabasterScene AlabasterScene;       /* meshes, materials, lights, cameras, render settings */
typedef struct AlabasterDelegate AlabasterDelegate; /* the renderer; draws one scene */
typedef struct AlabasterPass AlabasterPass;         /* a render: runs in the background, restarted by what changes */
typedef struct AlabasterBuffer AlabasterBuffer;     /* pixels of one AOV */
typedef struct AlabasterDisplay AlabasterDisplay;   /* converts pixels for a screen */

typedef int32_t AlabasterStatus;
enum {
  ALABASTER_OK = 0,
  ALABASTER_INVALID_ARGUMENT = 1,
  ALABASTER_NOT_FOUND = 2,
  ALABASTER_INPUT_FAILED = 3, /* a scene or what it names cannot be read, built or lit */
  ALABASTER_RENDER_FAILED = 4,
  ALABASTER_OUTPUT_FAILED = 5,
  ALABASTER_INTERRUPTED = 6, /* cancelled or stopped: the picture so far is there */
  ALABASTER_DEGRADED = 7,    /* rendered and written without what the scene's faults leave out */
  ALABASTER_OUT_OF_MEMORY = 8,
  ALABASTER_INTERNAL = 9,
};

/* Values --------------------------------------------------------------------------------------- */
/* AlabasterValue.type: the type of `data`, or of its elements */
enum {
  ALABASTER_NONE = 0,
  ALABASTER_BOOL = 1, /* one byte, 0 or 1 */
  ALABASTER_INT = 2,  /* int32_t */
  ALABASTER_INT64 = 3,
  ALABASTER_UINT = 4,
  ALABASTER_FLOAT = 5,
  ALABASTER_DOUBLE = 6,
  ALABASTER_FLOAT2 = 7,
  ALABASTER_FLOAT3 = 8,
  ALABASTER_FLOAT4 = 9,
  ALABASTER_INT2 = 10,
  ALABASTER_INT3 = 11,
  ALABASTER_DOUBLE3 = 12,
  ALABASTER_QUATERNION = 13, /* 4 floats: the real part first */
  ALABASTER_MATRIX = 14,     /* 16 doubles */
  ALABASTER_TOKEN = 15,      /* text: `data` is a const char*; of an array const char* const* */
  ALABASTER_STRING = 16,
  ALABASTER_PATH = 17,       /* of a prim */
  ALABASTER_ASSET = 18,      /* the name of a file */
  ALABASTER_DICTIONARY = 19, /* only in answers; `data` is const AlabasterParameter*, `count` their number */
  ALABASTER_FLOAT16 = 20,    /* IEEE 754 binary16 */
  ALABASTER_FLOAT16_2 = 21,
  ALABASTER_FLOAT16_3 = 22,
  ALABASTER_FLOAT16_4 = 23,
  ALABASTER_DOUBLE2 = 24,
  ALABASTER_DOUBLE4 = 25,
  ALABASTER_QUATERNION16 = 26, /* 4 halves: the real part first; arrays only */
};

/* AlabasterValue.is_array */
enum {
  ALABASTER_SCALAR = 0,
  ALABASTER_ARRAY = 1,
  ALABASTER_EDITED_ARRAY = 2, /* lent, and edited in place by the host: see below */
};

/* Arrays of numbers, vectors, quaternions and matrices may be lent: with `release` the memory is not copied, must not
   change, and must be aligned as its elements are. release(owner) is called once, by any thread and whether or not the
   call succeeded, when the library no longer reads it; it must not call the library. Without `release` it is copied in
   the call. Memory that is lent as ALABASTER_EDITED_ARRAY may be edited in place: it is read, and copied, by pass_start
   and record alone, in their calling thread and those that they start and wait for. Each time it is lent it counts as
   edited. */
typedef struct AlabasterValue {
  int32_t type;
  int32_t is_array;
  const void* data;
  size_t count; /* elements of an array; 1 else */
  void (*release)(void* owner);
  void* owner;
} AlabasterValue;

typedef struct AlabasterParameter {
  const char* name;
  AlabasterValue value;
} AlabasterParameter;

typedef void (*AlabasterVisit)(void* user, const char* name, const AlabasterValue* value); /* valid during the call */

/* Values at increasing times, in frames, relative to the frame that is drawn. Fewer than two: nothing moves. */
typedef struct AlabasterMotion {
  const double* times;
  const AlabasterValue* values;
  size_t count;
} AlabasterMotion;

/* Diagnostics ---------------------------------------------------------------------------------- */
enum { ALABASTER_INFO = 0, ALABASTER_WARNING = 1, ALABASTER_ERROR = 2 };

typedef struct AlabasterDiagnostic {
  int32_t severity;
  const char* code;  /* stable: "mesh.points.short" */
  const char* where; /* prim path, file, element */
  const char* text;  /* what is wrong, and the remedy */
} AlabasterDiagnostic;

/* Called by a thread of the host's or of ours, never under a lock of the renderer's. Must not call the library. */
typedef void (*AlabasterReport)(void* user, const AlabasterDiagnostic* diagnostic);

/* Scenes: prims by path, '/'-separated by custom ------------------------------------------------ */
/* AlabasterPrimvar.interpolation */
enum {
  ALABASTER_CONSTANT = 0,
  ALABASTER_UNIFORM = 1,
  ALABASTER_VARYING = 2,
  ALABASTER_VERTEX = 3,
  ALABASTER_FACE_VARYING = 4,
  ALABASTER_INSTANCE = 5,
};

typedef struct AlabasterPrimvar {
  const char* name; /* "points" (float3), "normals" (float3), "st" (float2, v up), ...: delegate/README.md */
  const char* role; /* null | color | vector | normal | point | textureCoordinate */
  int32_t interpolation;
  AlabasterValue value;
  AlabasterValue indices; /* int array; none: not indexed */
  AlabasterMotion motion; /* of points and normals */
} AlabasterPrimvar;

typedef struct AlabasterSubset {
  const char* id;
  const char* material;
  AlabasterValue faces; /* int array */
} AlabasterSubset;

typedef struct AlabasterSubdivTags {
  size_t size;
  const char* interpolate_boundary;              /* none | edgeOnly | edgeAndCorner (default) */
  const char* face_varying_linear_interpolation; /* all | none | boundaries | cornersOnly, default cornersPlus1, ...2 */
  const char* crease_method;                     /* uniform | chaikin */
  const char* triangle_subdivision;              /* catmullClark | smooth */
  AlabasterValue crease_indices, crease_lengths, crease_weights; /* weights: floats, per crease or per edge */
  AlabasterValue corner_indices, corner_weights;
} AlabasterSubdivTags;

/* AlabasterMesh.cull_style: sides of faces that are not shown. back and front hide them from the camera alone. */
enum {
  ALABASTER_CULL_DONT_CARE = 0, /* by single_sided */
  ALABASTER_CULL_NOTHING = 1,   /* not single-sided, whatever it says */
  ALABASTER_CULL_BACK = 2,
  ALABASTER_CULL_FRONT = 3,
  ALABASTER_CULL_BACK_UNLESS_DOUBLE_SIDED = 4,  /* by single_sided */
  ALABASTER_CULL_FRONT_UNLESS_DOUBLE_SIDED = 5, /* front, if single_sided */
};

typedef struct AlabasterMesh {
  size_t size;
  const char* scheme;      /* none (default) | catmullClark | loop | bilinear */
  const char* orientation; /* rightHanded (default) | leftHanded */
  AlabasterValue face_vertex_counts, face_vertex_indices, hole_indices; /* int arrays */
  const AlabasterPrimvar* primvars;
  size_t primvar_count;
  const AlabasterSubset* subsets; /* faces with a material of their own */
  size_t subset_count;
  const AlabasterSubdivTags* subdiv_tags;
  int32_t refine_level;           /* 0..8; 0 draws the cage */
  int32_t invisible;              /* not zero: it is not drawn */
  int32_t single_sided;           /* not zero: faces are not there for what sees them from behind */
  const double* transform;        /* null: identity */
  const char* material;           /* null: the default material */
  const char* instancer;          /* null: not instanced */
  AlabasterMotion motion;         /* matrices */
  const char* render_tag;         /* geometry (default), render, proxy, guide or hidden: AlabasterFrame.render_tags */
  AlabasterValue categories;      /* tokens: names that lights' parameters lightLink and shadowLink may give */
  AlabasterValue invisible_faces; /* int array: not drawn; unlike holes they leave the surface around them as it is */
  int32_t cull_style;             /* ALABASTER_CULL_... */
} AlabasterMesh;

typedef struct AlabasterPrototype {
  const char* id;         /* of a mesh or an inner instancer */
  AlabasterValue indices; /* int array: its instances, as indices into the primvars */
} AlabasterPrototype;

/* Point p of instance i: p * prototype * M * S * R * T * transform * parent...; the primvars are
   hydra:instanceTransforms (matrices), ...Translations (float3), ...Rotations (quaternions), ...Scales (float3). */
typedef struct AlabasterInstancer {
  size_t size;
  const double* transform;
  const char* parent; /* outer instancer */
  const AlabasterPrimvar* primvars;
  size_t primvar_count;
  const AlabasterPrototype* prototypes;
  size_t prototype_count;
  AlabasterMotion motion;
} AlabasterInstancer;

typedef struct AlabasterConnection {
  const char* input;
  const char* node; /* upstream */
  const char* output;
} AlabasterConnection;

typedef struct AlabasterNode {
  const char* name;
  const char* type; /* AlabasterDisney, AlabasterTexture, AlabasterPrimvar, AlabasterDisplacement: delegate/README.md */
  const AlabasterParameter* parameters; /* schemas/disney_material.json */
  size_t parameter_count;
  const AlabasterConnection* connections;
  size_t connection_count;
} AlabasterNode;

typedef struct AlabasterMaterial {
  size_t size;
  const AlabasterNode* nodes;
  size_t node_count;
  const char* surface;      /* the node that is the surface; null: the first one */
  const char* displacement; /* the node that displaces; null: none */
} AlabasterMaterial;

typedef struct AlabasterLight {
  size_t size;
  const char* type; /* rectLight, diskLight, cylinderLight, sphereLight, distantLight, domeLight */
  const double* transform;
  const AlabasterParameter* parameters; /* schemas/lights.json */
  size_t parameter_count;
  int32_t invisible; /* not zero: it gives no light */
} AlabasterLight;

typedef struct AlabasterCamera {
  size_t size;
  const double* transform;
  const AlabasterParameter* parameters; /* schemas/camera.json */
  size_t parameter_count;
  AlabasterMotion motion;
} AlabasterCamera;

typedef struct AlabasterRect {
  int32_t min_x, min_y, max_x, max_y; /* pixels, y-down, half open; empty: none */
} AlabasterRect;

typedef struct AlabasterRenderSettings {
  size_t size;
  const char* camera;
  int32_t width, height; /* 0: 1280 x 720 */
  double pixel_aspect;   /* 0: 1 */
  AlabasterRect crop;
  double frame;
  const AlabasterParameter* settings; /* schemas/render_settings.json */
  size_t setting_count;
} AlabasterRenderSettings;

typedef struct AlabasterLoadOptions { /* as the program's options of these names */
  size_t size;
  const char* const* overrides; /* "materials/skin.roughness=0.3" */
  size_t override_count;
  const char* camera;
  const char* dome;
  const char* scene;
  const char* animation;
  const char* variant;
  const double* time;    /* seconds; null: the pose in which models are authored */
  const double* shutter; /* two numbers: open and close, in frames */
  int32_t keep_going;    /* leaves images that are missing to the renderer */
  int64_t allow_outside; /* files may be named that lie outside the folder of the file that names them; of 64 bits, so
                            that the structs of hosts that do not know it are shorter */
} AlabasterLoadOptions;

typedef struct AlabasterLoaded { /* strings live until the scene is destroyed */
  size_t size;
  const char* settings;     /* path of the render settings */
  const char* color_config; /* OpenColorIO config that the file names, for setting "ocio"; "" if none */
  const char* notes;        /* "no light: added a studio", a line each */
} AlabasterLoaded;

/* Rendering ------------------------------------------------------------------------------------ */
typedef struct AlabasterDelegateOptions {
  size_t size;
  AlabasterReport report; /* null: faults are not reported */
  void* user;
  const AlabasterParameter* settings; /* as set_setting; and "ocio", the path of an OpenColorIO config */
  size_t setting_count;
} AlabasterDelegateOptions;

typedef struct AlabasterSetting {
  size_t size;
  const char* key;
  const char* name; /* shown to people */
  const char* documentation;
  AlabasterValue default_value, minimum, maximum; /* none: unbounded */
  const char* const* choices;                     /* of a string */
  size_t choice_count;
} AlabasterSetting;
typedef void (*AlabasterVisitSetting)(void* user, const AlabasterSetting* setting);

enum {
  ALABASTER_FORMAT_NONE = 0,
  ALABASTER_UNORM8 = 1,
  ALABASTER_UNORM8_3 = 2,
  ALABASTER_UNORM8_4 = 3,
  ALABASTER_HALF = 4,
  ALABASTER_HALF_3 = 5,
  ALABASTER_HALF_4 = 6,
  ALABASTER_FLOAT32 = 7,
  ALABASTER_FLOAT32_2 = 8,
  ALABASTER_FLOAT32_3 = 9,
  ALABASTER_FLOAT32_4 = 10,
  ALABASTER_INT32 = 11,
};

typedef struct AlabasterBinding {
  const char* aov; /* "color", "depth", "normal", ...: delegate/README.md */
  AlabasterBuffer* buffer;
} AlabasterBinding;

/* AlabasterFrame.window_policy: what gives way where camera and picture differ in shape */
enum {
  ALABASTER_MATCH_VERTICALLY = 0,
  ALABASTER_MATCH_HORIZONTALLY = 1,
  ALABASTER_FIT = 2,
  ALABASTER_CROP = 3,
  ALABASTER_DONT_CONFORM = 4,
};

typedef struct AlabasterFrame {
  size_t size;
  const AlabasterBinding* bindings;
  size_t binding_count;
  const char* settings; /* path of render settings, which then say what is null or 0 below; null: the first ones */
  const char* camera;
  int32_t width, height; /* the whole picture */
  AlabasterRect window;  /* the pixels to render: smaller is a crop, larger is overscan. Buffers are as large as it */
  double pixel_aspect;
  int32_t window_policy;
  const AlabasterCamera* free_camera; /* in the place of `camera`; no prim of the scene */
  AlabasterValue render_tags; /* tokens: of the meshes to draw; none: geometry and render; empty: all but hidden */
  AlabasterValue roots;       /* tokens: paths of the meshes to draw, with all below them; none: all */
  AlabasterValue excluded;    /* tokens: paths of those not to draw, likewise */
} AlabasterFrame;

enum {
  ALABASTER_IDLE = 0,
  ALABASTER_PREPARING = 1,
  ALABASTER_RENDERING = 2,
  ALABASTER_PAUSED = 3,
  ALABASTER_STOPPED = 4,
  ALABASTER_CONVERGED = 5,
  ALABASTER_FAILED = 6,
};

typedef struct AlabasterProgress {
  size_t size;
  double fraction;                      /* 0..1 */
  double seconds;                       /* of rendering */
  uint64_t samples_done, samples_total; /* per pixel */
} AlabasterProgress;

typedef struct AlabasterPixels {
  size_t size;
  const void* data; /* rows bottom-up, without gaps */
  int32_t width, height, format;
  uint64_t generation; /* rises when pixels change */
  void* mapping;       /* the library's */
} AlabasterPixels;

typedef struct AlabasterDisplayOptions { /* null: the default of the configuration */
  size_t size;
  const char* color_config; /* of OpenColorIO; null: $OCIO or the built-in one */
  const char* display;
  const char* view;
  const char* look;
  double exposure; /* stops */
} AlabasterDisplayOptions;

typedef struct AlabasterMemory { /* the caller's, for buffer_show */
  size_t size;
  void* pixels;
  size_t row_bytes; /* from the begin of a row to that of the next */
  int32_t width, height, format;
  int32_t y_up;              /* not zero: the lowest row comes first */
  AlabasterDisplay* display; /* null: the values as they were rendered */
  uint64_t shown;            /* set to 0 whenever anything above, the display or the buffer changes; else leave it */
} AlabasterMemory;

typedef struct AlabasterRecordOptions {
  size_t size;
  const char* settings;     /* path of render settings; null: the first ones */
  const char* const* files; /* to write (.exr .png .tif .jpg), in the place of those that the settings name */
  size_t file_count;
  const char* const* aovs; /* layers of the .exr files besides color */
  size_t aov_count;
  int32_t keep_going; /* renders a scene that has faults without what they leave out */
  /* About ten times a second, by the calling thread; 0 cancels, and what is there is written. May call the library,
     but for record, show and pass_start of the same delegate. */
  int32_t (*progress)(void* user, const AlabasterProgress* progress);
  void* user;
} AlabasterRecordOptions;

/* A face of an instance of a mesh, as pick finds it. */
typedef struct AlabasterPickedInstance {
  const char* instancer;
  int32_t index; /* into the instancer's primvars */
} AlabasterPickedInstance;

typedef struct AlabasterPick {
  size_t size;
  const char* path;                         /* of the mesh */
  int32_t instance_id;                      /* as AOV instanceId counts */
  int32_t face;                             /* as the topology counts; -1: elementId is not bound */
  int32_t x, y;                             /* a pixel that shows it */
  const AlabasterPickedInstance* instances; /* the mesh's instancer first, then the one that places it, ... */
  size_t instance_count;
} AlabasterPick;

typedef void (*AlabasterVisitPick)(void* user, const AlabasterPick* pick); /* valid during the call */

#ifdef __cplusplus
}
#endif
#endif

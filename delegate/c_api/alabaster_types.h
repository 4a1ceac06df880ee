/* Handles, values, fields and structs of the C interface: alabaster.h, which includes this, says how they are used. */
#ifndef ALABASTER_TYPES_H
#define ALABASTER_TYPES_H

#include <stddef.h>
#include <stdint.h>

#include "delegate/api/value_type.h"

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
  int32_t type; /* AlabasterType: of the value, or of the elements of an array */
  int32_t is_array;
  const void* data;
  size_t count; /* elements of an array; 1 else */
  void (*release)(void* owner);
  void* owner;
} AlabasterValue;

/* A value at a time, in frames, relative to the frame that is drawn. ALABASTER_SAMPLES are values at increasing times;
   fewer than two: nothing moves. */
typedef struct AlabasterSample {
  double time;
  AlabasterValue value;
} AlabasterSample;

typedef struct AlabasterParameter {
  const char* name;
  AlabasterValue value;
} AlabasterParameter;

typedef void (*AlabasterVisit)(void* user, const char* name, const AlabasterValue* value); /* valid during the call */

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

/* Scenes: prims by path, '/'-separated by custom. A prim has a kind and fields, which are AlabasterParameters: a value
   of type ALABASTER_NONE sets a field's default, and takes away what a scene has named (a primvar, an input, a node by
   its type). Words and paths may be tokens, strings or paths. An unknown kind or field, a value of another type and one
   out of range are INVALID_ARGUMENT, and nothing is changed; last_error names the nearest field, or what the value must
   be. Parameters of lights, cameras and materials and options of meshes may be out of range: the renderer warns and
   uses the nearest value. Setting transform or a primvar without its samples takes these away.

   Kinds are mesh, instancer, material, camera, renderSettings, rectLight, diskLight, cylinderLight, sphereLight,
   distantLight and domeLight. Each has a page of fields in delegate/manual/parameters, which is installed as
   share/doc/hdalabaster/parameters: name, type, range or words, default, unit and meaning. */
typedef struct AlabasterRect {
  int32_t min_x, min_y, max_x, max_y; /* pixels, y-down, half open; empty: none */
} AlabasterRect;

typedef struct AlabasterLoadOptions { /* as the program's options of these names */
  size_t size;
  const char* const* overrides; /* "materials/skin.roughness=0.3" */
  size_t override_count;
  const char* camera;
  const char* dome;
  const char* scene;
  const char* animation;
  const char* variant;
  const double* time;       /* seconds; null: the pose in which models are authored */
  const double* shutter;    /* two numbers: open and close, in frames */
  int32_t keep_going;       /* leaves images that are missing to the renderer */
  int32_t allow_outside;    /* files may be named that lie outside the folder of the file that names them */
  double frames_per_second; /* of the shutter's frames; 0: the model's time codes, else 24 */
  int32_t next_frame;       /* AOV motion is to show how the models' animations move up to the next frame */
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
  const char* aov; /* "color", "depth", "normal", ...: delegate/manual/pipeline.md */
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
  const AlabasterParameter* free_camera; /* fields of a camera in the place of `camera`; no prim of the scene */
  size_t free_camera_count;              /* 0: none */
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

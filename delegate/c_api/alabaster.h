/* The stable interface of libhdAlabaster: C99, and no type of C++, of its standard library or of Imath. A program that
   was built against this header runs with libraries of the same ALABASTER_API_VERSION whose api->size is as large. All
   functions are members of a table: const AlabasterApi* api = alabaster_api(ALABASTER_API_VERSION), or null.

   Handles are opaque and owned by the host, which destroys them in any order: the library keeps what other handles
   still need. Null may be destroyed.

   Structs that begin with `size` grow at their end: set it to sizeof the struct and everything unused to zero, as
   `AlabasterFrame frame = {.size = sizeof frame};` does in C and `AlabasterFrame frame{}; frame.size = sizeof frame;`
   in C++ (in alabaster.hpp sized<AlabasterFrame>()). Zero and null mean the default. Structs without it stand in arrays
   and never change. INVALID_ARGUMENT is returned for a count without its array, for a `size` that the struct has in no
   version, and for a parameter without a name. Strings are UTF-8, end with a zero byte and are copied during the call.

   Every function that can fail returns a status. api->last_error() then says why, for the calling thread, until its
   next call that fails. Faults of a scene go to the diagnostics callback.

   Threads: one thread at a time calls into a delegate and its scene, passes and buffers; a second one waits. These may
   be called by any thread at any time and do not wait: pass_wait, pass_state, progress, stats, stop, restart, pause,
   resume, buffer_map, pixels_unmap, buffer_read, buffer_show, display_set_exposure.

   Callbacks: those that visit, and the progress callback of record, may call the library; but record, show and
   pass_start of a delegate that records are refused until its record has returned. A visit holds no lock. A progress
   callback keeps other threads out of its delegate, so two recordings whose callbacks call each other's delegate wait
   for one another without end. Report and release callbacks must not call the library: INVALID_ARGUMENT. All of them
   may destroy handles; a handle that a report or release callback destroys goes with the next call that may wait,
   destroys included. They return: a thread that ends in one (pthread_exit) or in a call (pthread_cancel) ends the
   process.

   Calls run in the default floating-point environment, their callbacks included, and put the host's back. No number
   is read or written by the host's locale.

   Spawn, do not fork: a forked child has none of the library's threads. Calls with handles of its parent are
   INVALID_ARGUMENT there, but for destroys, which free nothing. delegate_create fails there with INPUT_FAILED if its
   parent had a delegate at the fork: TBB cannot be used without its threads. EXR files are refused there if its parent
   has read or written one.

   Matrices are 16 doubles, row after row, and points are rows: p' = p M, so a translation stands in the last row. */
#ifndef ALABASTER_H
#define ALABASTER_H

#include "alabaster_types.h"

#ifdef __cplusplus
extern "C" {
#endif

#define ALABASTER_API_VERSION 1
/* The table: further functions are added at its end -------------------------------------------- */
typedef struct AlabasterApi {
  size_t size;
  uint32_t version;     /* of the library: the ALABASTER_API_VERSION it was built with */
  const char* versions; /* "0.1.0", then a line per library that it stands on */
  const char* (*last_error)(void);

  /* Scenes. Arrays that are the same memory count as unchanged, but for ALABASTER_EDITED_ARRAY. A scene may be filled
     before or while a delegate draws it. `report` may be null. */
  AlabasterStatus (*scene_create)(AlabasterReport report, void* user, AlabasterScene** scene);
  void (*scene_destroy)(AlabasterScene* scene);
  AlabasterStatus (*scene_load)(AlabasterScene*, const char* file, const AlabasterLoadOptions*, AlabasterLoaded*);
  AlabasterStatus (*scene_clear)(AlabasterScene*);
  AlabasterStatus (*remove)(AlabasterScene*, const char* path);
  /* Makes a prim of `kind`, or replaces the one of that path, of whatever kind it is, and finds out what differs.
     Fields that are not given have their defaults. alabaster_types.h lists the kinds. */
  AlabasterStatus (*scene_set)(AlabasterScene*, const char* path, const char* kind, const AlabasterParameter* fields,
                               size_t count);
  /* Changes the given fields of a prim, all or none. NOT_FOUND: there is no prim of that path, and last_error names
     the nearest. */
  AlabasterStatus (*scene_edit)(AlabasterScene*, const char* path, const AlabasterParameter* fields, size_t count);
  /* Replaces elements of an instancer's primvar ("hydra:instanceTranslations"), from number `first` on: positions,
     scales, rotations, matrices, or values that looks read. Costs what it changes; scene_edit costs a look at all
     instances. INVALID_ARGUMENT: elements have more or fewer numbers than the primvar's, or lie beyond its end.
     Instances that move stand still there, at the cost of a copy of each sample; the others move as before. */
  AlabasterStatus (*scene_set_instances)(AlabasterScene*, const char* instancer, const char* primvar, size_t first,
                                         const AlabasterValue* values);
  AlabasterStatus (*get_prims)(AlabasterScene*, AlabasterVisit visit, void* user); /* path, and its type as token */

  /* Delegates. One delegate draws a scene; `scene` may be null and come later, by show. */
  AlabasterStatus (*delegate_create)(const AlabasterDelegateOptions*, AlabasterScene*, AlabasterDelegate**);
  void (*delegate_destroy)(AlabasterDelegate*);
  AlabasterStatus (*show)(AlabasterDelegate*, AlabasterScene*);
  AlabasterStatus (*set_setting)(AlabasterDelegate*, const char* key, const AlabasterValue*); /* none: takes it back */
  AlabasterStatus (*get_setting)(AlabasterDelegate*, const char* key, AlabasterVisit visit, void* user); /* an unknown
                                                                   key is INVALID_ARGUMENT, as in set_setting */
  AlabasterStatus (*get_settings)(AlabasterDelegate*, AlabasterVisitSetting visit, void* user);
  AlabasterStatus (*aov_format)(AlabasterDelegate*, const char* aov, int32_t* format); /* FORMAT_NONE: not supported,
                                                                   and last_error names a similar AOV */
  AlabasterStatus (*stats)(AlabasterDelegate*, AlabasterVisit visit, void* user);
  AlabasterStatus (*command)(AlabasterDelegate*, const char* name, const AlabasterParameter* arguments, size_t count,
                             AlabasterVisit visit, void* user); /* "dumpScene", "flush", ...: render_delegate.h */
  AlabasterStatus (*stop)(AlabasterDelegate*);    /* blocks until nothing runs; nothing renders until restart */
  AlabasterStatus (*restart)(AlabasterDelegate*); /* passes may be started again; those that ran stay stopped */
  AlabasterStatus (*pause)(AlabasterDelegate*);
  AlabasterStatus (*resume)(AlabasterDelegate*);
  /* Renders to files and waits: OK, DEGRADED, INTERRUPTED or a failure. `visit`, if any, gets each file written. A
     pause from before ends. */
  AlabasterStatus (*record)(AlabasterDelegate*, const AlabasterRecordOptions*, AlabasterVisit visit, void* user);

  /* Passes. start syncs what has changed in the scene, begins to render if anything differs from what is running, and
     returns. What changed is built in the background, while the old scene goes on, and drawn once it is there. A buffer
     of another size than the frame's window is INVALID_ARGUMENT; an AOV that does not exist is reported and left out.
     wait: *over is 1 when the render is over (converged, stopped or failed), 0 when `seconds` have passed. */
  AlabasterStatus (*pass_create)(AlabasterDelegate*, AlabasterPass**);
  void (*pass_destroy)(AlabasterPass*);
  AlabasterStatus (*pass_start)(AlabasterPass*, const AlabasterFrame*);
  AlabasterStatus (*pass_wait)(AlabasterPass*, double seconds, int32_t* over); /* < 0: without limit */
  AlabasterStatus (*pass_state)(AlabasterPass*, int32_t* state);
  AlabasterStatus (*progress)(AlabasterDelegate*, AlabasterProgress*);
  /* The size of the buffers that `frame` needs: that of its window. */
  AlabasterStatus (*frame_size)(AlabasterDelegate*, const AlabasterFrame* frame, int32_t* width, int32_t* height);

  /* Buffers. A new size takes effect at the next start. map shows what has been rendered so far; its memory is valid
     until pixels_unmap, whatever happens to the buffer or the delegate. read copies it, top row first if y_down,
     into memory of `bytes` bytes: INVALID_ARGUMENT if that is too little. */
  AlabasterStatus (*buffer_create)(AlabasterDelegate*, int32_t width, int32_t height, int32_t format,
                                   AlabasterBuffer**);
  void (*buffer_destroy)(AlabasterBuffer*);
  AlabasterStatus (*buffer_resize)(AlabasterBuffer*, int32_t width, int32_t height, int32_t format);
  AlabasterStatus (*buffer_map)(AlabasterBuffer*, AlabasterPixels*);
  AlabasterStatus (*pixels_unmap)(AlabasterPixels*);
  AlabasterStatus (*buffer_read)(AlabasterBuffer*, void* memory, size_t bytes, int32_t y_down);

  /* A display is made once and kept; a new exposure needs no other one, but memory whose `shown` is 0.
     buffer_show writes what the memory does not show yet, in its format. A buffer of another size writes nothing and is
     NOT_FOUND: the memory then has the buffer's width and height. */
  AlabasterStatus (*display_create)(const AlabasterDisplayOptions*, AlabasterDisplay**);
  void (*display_destroy)(AlabasterDisplay*);
  AlabasterStatus (*display_set_exposure)(AlabasterDisplay*, double stops);
  AlabasterStatus (*buffer_show)(AlabasterBuffer*, AlabasterMemory*);
  /* What the pass shows in a rectangle of its buffers' pixels: each face once, those nearest to its middle first. The
     last start must have bound AOV primId (instanceId and elementId, too, for these numbers) to buffers of
     ALABASTER_INT32: INVALID_ARGUMENT if not. The scene must be as it was at that start. */
  AlabasterStatus (*pick)(AlabasterPass*, const AlabasterRect*, AlabasterVisitPick visit, void* user);
  /* Writes what the pass shows now to a file (.exr .png .tif .jpg), from the buffer that the last start bound to AOV
     color; the pass goes on. A file of an unfinished render is marked so. */
  AlabasterStatus (*snapshot)(AlabasterPass*, const char* file);

  /* Writes the scene to an archive (NAME.alab), which scene_load reads: every prim, with render settings that draw what
     a pass of `frame` draws. `frame` may be null; its bindings count for nothing, and meshes that it leaves out are
     hidden. `settings` come over those of the frame's render settings, as a delegate's do; "ocio" among them names the
     OpenColorIO config, which else is that of the file that was loaded last. Images of files are named by path and
     digest, those in memory are stored. OUTPUT_FAILED: the file is as it was; last_error names the cause. */
  AlabasterStatus (*scene_write)(AlabasterScene*, const char* file, const AlabasterFrame* frame,
                                 const AlabasterParameter* settings, size_t count);

  /* The type of the values that a field takes, and 1 in *is_array if these are arrays of that type. Null as `kind`: the
     type that the field has in every kind that has it. ALABASTER_NONE: it takes several types, or there is no such
     field. Any thread, at any time. */
  AlabasterStatus (*field_type)(const char* kind, const char* name, int32_t* type, int32_t* is_array);

  /* scene_set_instances of several primvars, all or none. Each parameter has the name of one. */
  AlabasterStatus (*scene_edit_instances)(AlabasterScene*, const char* instancer, size_t first,
                                          const AlabasterParameter* primvars, size_t count);
  /* set_setting of several settings, all or none. */
  AlabasterStatus (*set_settings)(AlabasterDelegate*, const AlabasterParameter* settings, size_t count);

  /* Of a material with this subsurfaceColor and scatterAnisotropy (clamped to 0 to 1, -0.9 to 0.9), the share of light
     that each event below the surface absorbs: 1 - the single-scattering albedo. It falls from 1 to 0 as the colour
     rises. Any thread, at any time. */
  AlabasterStatus (*absorbed_share)(double color, double anisotropy, double* share);
} AlabasterApi;

/* Null if the library has another version. The table lives as long as the library is loaded. */
#if defined(ALABASTER_BUILDING_LIBRARY)
__attribute__((visibility("default")))
#endif
const AlabasterApi*
alabaster_api(uint32_t version);

#ifdef __cplusplus
}
#endif
#endif

/* The types of values, for C and C++. The numbers are part of the stable interface: new types are added at the end. */
#ifndef ALABASTER_VALUE_TYPE_H
#define ALABASTER_VALUE_TYPE_H

/* Of a value, or of the elements of an array. */
typedef enum AlabasterType {
  ALABASTER_NONE = 0,
  ALABASTER_BOOL = 1, /* one byte, 0 or 1 */
  ALABASTER_INT = 2,  /* int32_t */
  ALABASTER_INT64 = 3,
  ALABASTER_UINT = 4, /* uint32_t */
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
  ALABASTER_QUATERNION16 = 26, /* 4 halves: the real part first */
  ALABASTER_SAMPLES = 27       /* values at times; `data` is const AlabasterSample*, `count` their number */
} AlabasterType;

#endif

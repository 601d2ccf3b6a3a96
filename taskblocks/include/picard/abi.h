// What a taskblock library and the runtime say to each other: plain C, so that compilers, standard libraries and
// versions may differ on both sides. Component authors use taskblock.h, which fills all of this in.
//
// A library exports one function, picard_library_v1(). What it returns lives as long as the library is loaded and never
// changes. Sizes in the structures let a newer runtime read older libraries; a PICARD_ABI_VERSION that is newer than
// the runtime's is refused. Version 1 had a picard_context without what stands below now_ns and period_ns.
#ifndef PICARD_ABI_H
#define PICARD_ABI_H

/* NOLINTBEGIN(modernize-*): C */

#include <stddef.h>
#include <stdint.h>

#ifdef __cplusplus
extern "C" {
#endif

#define PICARD_ABI_VERSION 2u
#define PICARD_ENTRY "picard_library_v1"

enum picard_kind {
  PICARD_ELEMENTARY = 0,
  PICARD_STRING = 1,
  PICARD_ARRAY = 2,
  PICARD_STRUCT_TYPE = 3,
  PICARD_ENUM_TYPE = 4
};

struct picard_field;
struct picard_enumerator;

/* The type of a port, of an element or of a structure's field. */
struct picard_type {
  uint32_t kind;     /* picard_kind */
  const char* name;  /* elementary: "LREAL"; string: "STRING" or "WSTRING"; structure, enumeration: its name */
  uint32_t capacity; /* string: characters; array: elements, counted from 0 */
  uint32_t size;     /* bytes of a value */
  uint32_t align;
  const struct picard_type* element; /* array; enumeration: the integer type that its values have */
  const struct picard_field* fields; /* structure */
  uint32_t field_count;
  uint32_t enumerator_count;
  const struct picard_enumerator* enumerators; /* enumeration; the first is the value that variables begin with */
};

struct picard_field {
  const char* name;
  const struct picard_type* type;
  uint32_t offset; /* bytes from the start of the structure */
};

struct picard_enumerator {
  const char* name;
  int64_t value;
};

enum picard_direction {
  PICARD_INPUT = 0,
  PICARD_OUTPUT = 1,
  PICARD_CONFIG = 2,       /* an input whose value is a constant of the project, there before ready() */
  PICARD_QUEUE_READER = 3, /* takes elements out of a queue; the type is that of an element */
  PICARD_QUEUE_WRITER = 4  /* puts elements into a queue */
};

struct picard_port {
  const char* name; /* "CUTOFF": as drawings and texts spell it, in capitals */
  const struct picard_type* type;
  uint32_t direction; /* picard_direction */
  const char* summary;
  const char* unit;    /* "mm/s", or "" */
  const char* initial; /* as IEC 61131-3 spells it ("T#1s", "[1, 2]", "(A := 1)"), or "" for the type's own */
  double lowest;       /* declared range of a number; -inf and +inf = none */
  double highest;
};

enum picard_severity { PICARD_NOTE = 0, PICARD_WARNING = 1, PICARD_ERROR = 2 };

/* What the task is told in every cycle. The pointer given to create() stays; what it points to changes. */
struct picard_context {
  int64_t now_ns;    /* the task's clock, taken once a cycle; starts anywhere, never runs back */
  int64_t period_ns; /* of the task; 0 for event and freewheeling tasks */
  /* Since version 2. */
  uint32_t object; /* while create() runs: the number of what is made, for tell() */
  /* Tells the operator a text of at most PICARD_TEXT_BYTES - 1 bytes; null where there is none. Copies it, allocates
   * nothing and never waits: what finds no room is lost and counted. From create(), ready() and fire(), and from
   * threads of the component. */
  void (*tell)(const struct picard_context* context, uint32_t object, uint32_t severity, const char* text);
};

/* A queue as a port sees it. None of these waits; all may be called in fire() alone. */
struct picard_queue {
  int (*push)(struct picard_queue* queue, const void* element); /* 0 = it is full, nothing happened */
  int (*pop)(struct picard_queue* queue, void* element);        /* 0 = it is empty, nothing happened */
  uint32_t (*count)(struct picard_queue* queue);                /* a reader: elements there are */
  uint32_t (*space)(struct picard_queue* queue);                /* a writer: elements that fit */
};

#define PICARD_TEXT_BYTES 160
/* Why something failed; a text that ends with 0. */
struct picard_failure {
  char text[PICARD_TEXT_BYTES];
};

struct picard_block {
  const char* name;    /* "LOWPASS": the type in drawings */
  const char* group;   /* "Filters" */
  const char* summary; /* one sentence */
  const char* details; /* what a user must know besides; paragraphs of Markdown, or "" */
  const struct picard_port* ports;
  uint32_t port_count;
  int64_t budget_ns; /* fire() taking longer is a fault; 0 = not measured */
  /* Makes an object; null with `failure` filled in. `ports[i]` is where the value of port i lies: 8 bytes aligned or as
   * its type demands, for the life of the object. For queues it is a picard_queue. */
  void* (*create)(void* const* ports, const struct picard_context* context, struct picard_failure* failure);
  /* Once, before the first cycle and after the configuration ports have their values. 0 = it failed. */
  int (*ready)(void* object, struct picard_failure* failure);
  /* Once each time the block is executed. 0 = it failed: a fault of the task. */
  int (*fire)(void* object, struct picard_failure* failure);
  void (*destroy)(void* object);
};

struct picard_library {
  uint32_t abi_version; /* PICARD_ABI_VERSION */
  uint32_t block_bytes; /* sizeof(struct picard_block) */
  uint32_t port_bytes;  /* sizeof(struct picard_port) */
  uint32_t type_bytes;  /* sizeof(struct picard_type) */
  const char* name;     /* "filters" */
  const char* version;  /* "1.2.0" */
  const char* failure;  /* null, or why the library cannot describe its blocks */
  const struct picard_block* blocks;
  uint32_t block_count;
};

typedef const struct picard_library* (*picard_entry)(void);

#ifdef __cplusplus
}
#endif

/* NOLINTEND(modernize-*) */

#endif
